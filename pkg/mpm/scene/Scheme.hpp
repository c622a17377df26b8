// SPDX-License-Identifier: GPL-2.0-or-later
// A scheme says when in a step the stress is updated, and with which velocity. It owns the order of the
// stages and the law of the longest stable step. Sulsky et al. 1995; Bardenhagen 2002.
#pragma once

#include "mpm/base/registry.hpp"

namespace mpm {

class Scheme {
  public:
    std::string name, doc;
    bool stressFirst; // the stress is updated before the forces are summed, not at the end of the step
    bool remaps;      // the velocity that strains is mapped back from the particles, not that of the solution

    // The longest stable step is 2 over the root of the largest eigenvalue of
    // M^-1 (direct K + mapped C M^-1 K): K stiffness, M lumped and C consistent mass
    // (doc/explanation/time-step.md).
    struct StepLaw {
        double direct, mapped;
    };
    StepLaw stepLaw;

    // Whether the velocity that strains is made behind the solution: until then the nodes collect momentum for it.
    bool remapsSolution() const { return remaps && !stressFirst; }

    // A place in the order of the stages, and who stands there.
    struct Place {
        std::vector<std::string> engines; // any of these classes
        bool isNeeded = true;
        bool takesMany = false;  // as many engines as there are
        bool isInserted = false; // by the scene straight behind the place before, where the user gives none
        bool isPlaced = false;   // straight behind the place before, wherever the user has put it
    };
    // hasImplicit: whether there are bodies whose elastic forces enter the solution.
    std::vector<Place> order(bool hasImplicit = false) const;
};

} // namespace mpm
