// SPDX-License-Identifier: GPL-2.0-or-later
#include "yade/MpmEngine.hpp"

#include <core/Scene.hpp>

namespace yade {

void MpmEngine::action() {
    const mpm::HostMoment moment{scene->iter, scene->time, scene->dt};
    if (table_ && table_->act(table_->self, stage, &moment)) return;
    PyRunner::action();
}

void MpmEngine::follow(size_t address) {
    const auto* next = reinterpret_cast<const mpm::StepTable*>(address);
    if (next && next->version != mpm::hostTablesVersion)
        throw std::runtime_error("MpmEngine: solver and plugin are of different versions; build both anew");
    if (next) next->retain(next->self);
    if (table_) table_->release(table_->self);
    table_ = next;
}

YADE_PLUGIN((MpmEngine));

} // namespace yade
