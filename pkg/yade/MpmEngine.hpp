// SPDX-License-Identifier: GPL-2.0-or-later
// An engine of a scene, or the whole scene, as an engine of YADE.
#pragma once

#include "coupling/HostTables.hpp"

#include <pkg/common/PyRunner.hpp>

namespace yade {

// A PyRunner, so that scripts find the same attributes with and without this plugin, whose command is run
// only in steps that were not granted.
class MpmEngine : public PyRunner {
  public:
    ~MpmEngine() override { follow(0); }

    void action() override;

    // Takes granted steps from now on. address: of a mpm::StepTable; 0: none.
    void follow(size_t address);

    // clang-format off
    YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(MpmEngine, PyRunner,
        "An engine of a scene of yade_mpm, made by :code:`mpm.yade.attach`.",
        ((int, stage, -1, , "Number of the engine in scene.engines; negative: the whole scene."))
        ,
        /* ctor */
        ,
        .def("_follow", &MpmEngine::follow, "Takes granted steps from the table at an address; 0: none.")
    );
    // clang-format on

  private:
    const mpm::StepTable* table_ = nullptr;
};
REGISTER_SERIALIZABLE(MpmEngine);

} // namespace yade
