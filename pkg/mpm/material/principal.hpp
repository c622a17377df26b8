// SPDX-License-Identifier: GPL-2.0-or-later
// Principal stresses of one particle of a run, in descending order, and back. For laws whose return goes along
// principal axes, which a return with an isotropic elastic law keeps.
#pragma once

#include "mpm/material/Material.hpp"
#include "mpm/material/lode.hpp"

namespace mpm {

template <int Dim> class PrincipalStress;

template <> class PrincipalStress<2> {
  public:
    double value[3]; // kPa, descending

    PrincipalStress(const MaterialPoints<2>& points, int i) : stress_(points.stress), i_(i) {
        const double xx = stress_[0][i], yy = stress_[4][i], zz = stress_[8][i], mean = 0.5 * (xx + yy);
        half_ = 0.5 * (xx - yy);
        shear_ = stress_[1][i];
        radius_ = std::sqrt(half_ * half_ + shear_ * shear_);
        const double inPlane[] = {mean + radius_, mean - radius_};
        zz_ = zz > inPlane[0] ? 0 : zz < inPlane[1] ? 2 : 1; // place of the stress out of the plane
        int next = 0;
        for (int k = 0; k < 3; ++k) value[k] = k == zz_ ? zz : inPlane[next++];
    }
    void write() const {
        const double major = value[zz_ == 0 ? 1 : 0], minor = value[zz_ == 2 ? 1 : 2];
        const double mean = 0.5 * (major + minor), scale = radius_ > 0 ? 0.5 * (major - minor) / radius_ : 0;
        stress_[0][i_] = mean + scale * half_;
        stress_[4][i_] = mean - scale * half_;
        stress_[8][i_] = value[zz_];
        stress_[1][i_] = stress_[3][i_] = scale * shear_;
    }

  private:
    double* const* stress_;
    int i_, zz_;
    double half_, shear_, radius_;
};

// In space by Lode's angle, and back by Newton's interpolation of the new values over the old ones,
//     s' = v1 I + (s - s1 I) [d12 I + d123 (s - s2 I)],  d12, d123 the divided differences of v over s
// A return keeps the order of the values, so that d12 and d23 are within 0 and 1, however close the old ones are, and an
// error of these counts no more than once.
template <> class PrincipalStress<3> {
  public:
    double value[3];

    PrincipalStress(const MaterialPoints<3>& points, int i) : stress_(points.stress), i_(i) {
        const Symmetric trial = gatherUpper(stress_, i);
        mean_ = trace(trial) / 3;
        s_ = plusSpherical(trial, -mean_);
        const double J2 = halfSquare(s_), q = std::sqrt(J2);
        const Lode lode = lodeOf(s_, J2, q);
        const double half = -q * lode.sine / std::sqrt(3.0), radius = q * (lode.cosine - lode.correction);
        const double all[] = {half + radius, -2 * half, half - radius};
        std::copy(all, all + 3, deviator_);
        for (int k = 0; k < 3; ++k) value[k] = mean_ + deviator_[k];
    }
    void write() const {
        const double d12 = slope(0, 1), d23 = slope(1, 2), wide = deviator_[0] - deviator_[2];
        const double d123 = wide > 0 ? (d12 - d23) / wide : 0;
        const Symmetric first = plusSpherical(s_, -deviator_[0]), second = plusSpherical(s_, -deviator_[1]);
        const Symmetric m = plusSpherical(d12 * first + d123 * timesTransposed(first, second), value[0]);
        scatter(m, stress_, i_);
    }

  private:
    double* const* stress_;
    int i_;
    double mean_, deviator_[3];
    Symmetric s_;

    // Between neighbours. Where the old values are one, so are the new ones, up to round-off.
    double slope(int a, int b) const {
        const double old = deviator_[a] - deviator_[b];
        return old > 0 ? std::clamp((value[a] - value[b]) / old, 0.0, 1.0) : 0;
    }
};

// A trial stress is written to the upper triangle alone; stress that stays is symmetric, too.
template <int Dim> void mirror(const MaterialPoints<Dim>& points, int i) {
    points.stress[3][i] = points.stress[1][i];
    if (Dim == 2) return;
    points.stress[6][i] = points.stress[2][i];
    points.stress[7][i] = points.stress[5][i];
}

} // namespace mpm
