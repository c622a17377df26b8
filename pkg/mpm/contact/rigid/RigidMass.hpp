// SPDX-License-Identifier: GPL-2.0-or-later
// Inverse mass of a rigid body, translation and rotation, as contact sees it. Its moments of inertia are those
// of its shapes, uniformly filled, about its position: contact that took it to be lighter than it is would
// only close more slowly, and what has twice the inverse mass is still stable.
#pragma once

#include "mpm/contact/rigid/RigidShape.hpp"

namespace mpm {

struct RigidMass {
    double inverse = 0;                     // 1/Mg; zero: it does not yield
    Mat<3> inverseInertia = Mat<3>::Zero(); // 1/(Mg m2), in the frame of the body

    Mat<3> inverseInertiaAt(const Eigen::Quaterniond& orientation) const {
        if (inverseInertia.isZero(0)) return inverseInertia;
        const Mat<3> R = orientation.toRotationMatrix();
        return R * inverseInertia * R.transpose();
    }
};

// masses: Mg, of all bodies; zero: it does not yield.
inline std::vector<RigidMass> rigidMasses(const std::vector<RigidShape>& shapes,
                                          const std::vector<double>& masses, int dim) {
    std::vector<RigidMass> all(masses.size());
    std::vector<SecondMoment> sums(masses.size());
    for (const RigidShape& shape : shapes) sums[shape.body] += shape.secondMoment(dim);
    for (size_t b = 0; b < masses.size(); ++b) {
        if (!(masses[b] > 0)) continue;
        all[b].inverse = 1 / masses[b];
        if (!(sums[b].size > 0) || !sums[b].moment.allFinite()) continue;
        const Mat<3> S = sums[b].moment / sums[b].size;
        if (dim == 2)
            all[b].inverseInertia(2, 2) = 1 / (masses[b] * S.trace());
        else
            all[b].inverseInertia = (masses[b] * (S.trace() * Mat<3>::Identity() - S)).inverse();
    }
    return all;
}

} // namespace mpm
