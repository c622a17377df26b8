// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of Domains: boxes that are cut in two, for what has a history of each of them.
#pragma once

#include "mpm/base/types.hpp"

#include <cstdint>
#include <vector>

namespace mpm {

// A particle that was cut in two.
template <int Dim> struct CutBox {
    int64_t kept, made; // ids of the halves
    Vec<Dim> offset;    // m, of the half that kept its id, from the middle of both
};

template <int Dim> class CutBoxes {
  public:
    // What was cut at the start of this step.
    virtual const std::vector<CutBox<Dim>>& justCut() const = 0;

  protected:
    ~CutBoxes() = default;
};

} // namespace mpm
