// SPDX-License-Identifier: GPL-2.0-or-later
// Stiffness and strength of a cross-section of a beam, plate or shell, per metre of its width. A plate has those along
// its width, too, and Poisson's ratio nu, the mean of those of both directions: with S the root of EI EI_width
//     M_line = (EI k_line + nu S k_width)/(1 - nu^2),  M_width alike,  M_xy = S k_xy/(1 + nu)   (Huber),
// and the same for forces, with EA and half of the angle of shear.
#pragma once

#include <cmath>
#include <limits>

namespace mpm {

struct SectionStiffness {
    static constexpr double none = std::numeric_limits<double>::infinity();

    double EA, EI;                        // kN/m, kN m2/m
    double GA = none, limitMoment = none; // kN/m, kN m/m
    double EAWidth = 0, EIWidth = 0;      // of a plate along its width; 0: as along the line
    double poisson = 0;

    struct Plate {
        double along[2];       // line and width
        double cross, sheared; // of the other direction; of the twist, or half of the angle of shear
    };
    Plate membrane() const { return plate(EA, EAWidth); }
    Plate bending() const { return plate(EI, EIWidth); }

  private:
    Plate plate(double line, double width) const {
        if (width == 0) width = line;
        const double mean = std::sqrt(line * width), free = 1 - poisson * poisson;
        return {{line / free, width / free}, poisson * mean / free, mean / (1 + poisson)};
    }
};

} // namespace mpm
