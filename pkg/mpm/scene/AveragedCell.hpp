// SPDX-License-Identifier: GPL-2.0-or-later
// What CellAverage knows of a cell of the grid and the particles of a body in it. Geometry and shares are those of the
// start of the step.
#pragma once

#include "mpm/base/types.hpp"

namespace mpm {

// Of something in the particles of a cell.
struct MeanInCell {
    double weight, value; // sum of their volumes, m3; the mean
};

template <int Dim> struct AveragedCell {
    Vec<Dim> edges;                // m
    double whole = 0;              // volume, m3
    double volume = 0, inside = 0; // of the particles in it; 1 inside the material, 0 at its surface
    double share = 1;              // of the volume of all bodies in it
    double uneven = 1;             // factor of its rate of volume change
    double weight = 0;             // m3, volume of the particles that its rate and stress are means over
    double stress = 0; // mean stress of the particles, kPa; in giveLinear() over their k (FollowingPressure)
    double taken = 0;  // flux of holes beside it, m3/s
    double shared = 0; // m3, of the volume that it shares with a body of another group (SharedCells),
    bool isOpen = false; // where a gap parts both
    Vec<Dim> centre;     // of the particles, when the stress became linear

    void take(const MeanInCell& ofStress) {
        weight = ofStress.weight;
        stress = ofStress.value;
    }
};

} // namespace mpm
