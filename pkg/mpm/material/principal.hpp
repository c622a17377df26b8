// SPDX-License-Identifier: GPL-2.0-or-later
// Principal stresses of one particle of a run, in descending order, and back. For laws whose return goes along
// principal axes, which a return with an isotropic elastic law keeps.
#pragma once

#include "mpm/material/Material.hpp"

#include <Eigen/Eigenvalues>

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

template <> class PrincipalStress<3> {
  public:
    double value[3];

    // The iterative solver: the direct one loses half the digits where two values are close.
    PrincipalStress(const MaterialPoints<3>& points, int i) : stress_(points.stress), i_(i) {
        Mat<3> m;
        for (int a = 0; a < 3; ++a)
            for (int b = a; b < 3; ++b) m(a, b) = m(b, a) = stress_[3 * a + b][i];
        spectrum_.compute(m);
        for (int k = 0; k < 3; ++k) value[k] = spectrum_.eigenvalues()[2 - k];
    }
    void write() const {
        const Vec<3> values(value[2], value[1], value[0]);
        const Mat<3>& axes = spectrum_.eigenvectors();
        const Mat<3> m = axes * values.asDiagonal() * axes.transpose();
        for (int a = 0; a < 3; ++a)
            for (int b = a; b < 3; ++b) stress_[3 * a + b][i_] = stress_[3 * b + a][i_] = m(a, b);
    }

  private:
    double* const* stress_;
    int i_;
    Eigen::SelfAdjointEigenSolver<Mat<3>> spectrum_;
};

// A trial stress is written to the upper triangle alone; stress that stays is symmetric, too.
template <int Dim> void mirror(const MaterialPoints<Dim>& points, int i) {
    points.stress[3][i] = points.stress[1][i];
    if (Dim == 2) return;
    points.stress[6][i] = points.stress[2][i];
    points.stress[7][i] = points.stress[5][i];
}

} // namespace mpm
