// SPDX-License-Identifier: GPL-2.0-or-later
// Hencky elasticity: linear between logarithmic strain and Kirchhoff stress, exact under rotation.
#include "mpm/material/Material.hpp"
#include "mpm/material/logarithm.hpp"
#include "mpm/material/required.hpp"
#include "mpm/material/stiffening.hpp"
#include "mpm/material/tensors.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace mpm {
namespace {

// ln(I + e) of any symmetric e, with the iterative solver; Eigen's direct one loses half the digits where
// eigenvalues are close.
Symmetric spectralLogOfIdentityPlus(const Symmetric& e) {
    Mat<3> m;
    m << e.xx, e.xy, e.xz, e.xy, e.yy, e.yz, e.xz, e.yz, e.zz;
    const Eigen::SelfAdjointEigenSolver<Mat<3>> spectrum(m);
    const Vec<3> logarithm = spectrum.eigenvalues().unaryExpr([](double x) { return logOnePlus(x); });
    m = spectrum.eigenvectors() * logarithm.asDiagonal() * spectrum.eigenvectors().transpose();
    return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
}

// Cauchy stress from ln(b), which is twice the strain.
MPM_INLINE Symmetric cauchy(double lambda, double mu, const Symmetric& logarithm, double overJ) {
    return plusSpherical(mu * overJ * logarithm, 0.5 * lambda * overJ * trace(logarithm));
}

// Largest sum of |e| along a row, which no principal value exceeds. It takes additions only, so that two
// loops that ask for it, one of them vectorised, agree to the last bit.
MPM_INLINE double largestRow(const Symmetric& e) {
    const double xy = std::abs(e.xy), xz = std::abs(e.xz), yz = std::abs(e.yz);
    const double x = std::abs(e.xx) + (xy + xz), y = std::abs(e.yy) + (xy + yz);
    return std::max(std::max(x, y), std::abs(e.zz) + (xz + yz));
}

// exp(a) - I of a symmetric a.
Mat<3> exponentialMinusIdentity(const Mat<3>& a) {
    const Eigen::SelfAdjointEigenSolver<Mat<3>> spectrum(a);
    const Vec<3> growth = spectrum.eigenvalues().unaryExpr([](double x) { return std::expm1(x); });
    return spectrum.eigenvectors() * growth.asDiagonal() * spectrum.eigenvectors().transpose();
}

// The state is e = b - I and not b itself: with b the last digit of 1 is the last digit of the strain.
class LinearElastic : public StiffeningOf<LinearElastic> {
  public:
    std::string className() const override { return "LinearElastic"; }
    std::string doc() const override {
        return R"(Linear elasticity in logarithmic strain (Hencky), for large rotation and any number of cycles.

    b <- f b f^T,  f = I + dt L
    eps = 1/2 ln(b),  tau = lambda tr(eps) I + 2 mu eps,  sigma = tau / J

b is the elastic left Cauchy-Green tensor; J is the ratio of current to initial domain volume. An initial
stress is the elastic strain from an unstressed state, while J counts from the initial one. With pressureExponent the
moduli are those at P = sqrt(p^2 + (K/mu) J2) of the Kirchhoff stress: the stress derives from an energy, and the moduli
grow in tension and shear, too.

Source: Hencky 1928, Z. Techn. Phys. 9, 215-220; Simo & Hughes 1998, Computational Inelasticity, ch. 9; Houlsby, Amorosi
& Rojas 2005, Geotechnique 55, 383-392 (moduli of the pressure with an energy).)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters()) all.push_back(p);
        for (auto& p : pressure_.parameters()) all.push_back(p);
        return all;
    }
    void finish() override {
        requireDensity(className(), density);
        elasticity_.finish(className());
    }
    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all;
        for (std::string axes : {"XX", "YY", "ZZ", "XY", "XZ", "YZ"})
            all.push_back({"stretch" + axes, "-",
                           "elastic left Cauchy-Green tensor less the identity, b - I, " + axes});
        return all;
    }
    static constexpr bool takesHoopRate = true;
    std::array<double, 2> moduli() const { return {elasticity_.lambda(), elasticity_.mu()}; }
    void setModuli(double lambda, double mu) { elasticity_.lame = {lambda, mu}; }
    static constexpr bool hasPotential = true;

    void stateFromStress(const double stress[9], double* state) const override {
        const double factor = secantAt(stress);
        const auto [lambda, mu] = linearModuli();
        Mat<3> tau;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) tau(i, j) = stress[3 * std::min(i, j) + std::max(i, j)] / factor;
        const double volumetric = tau.trace() / (3 * elasticity_.bulk());
        const Mat<3> eps = (tau - lambda * volumetric * Mat<3>::Identity()) / (2 * mu);
        const Mat<3> e = exponentialMinusIdentity(2 * eps);
        for (int k = 0; k < 6; ++k) state[k] = e(row[k], column[k]);
    }

    // p^2/(2 K) + J2/(2 mu) of the Kirchhoff stress.
    template <int Dim> void linearEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        const double lambda = elasticity_.lambda(), mu = elasticity_.mu();
        for (int p = 0; p < points.count; ++p) {
            const auto [mean, J2] = invariants(points, p);
            energy[p] = 0.5 * mean * mean / (lambda + 2.0 / 3 * mu) + (J2 > 0 ? 0.5 * J2 / mu : 0);
            energy[p] *= points.volume[p] / points.initialVolume[p];
        }
    }

    template <int Dim> void respond(const MaterialPoints<Dim>& points) const {
        stretch(points);
        stressOfStretch(points);
    }

  private:
    static constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

    // e <- g + g^T + g g^T + f e f^T with g = dt L, written as e plus its change.
    static void stretch(const MaterialPoints<2>& points) {
        const double dt = points.dt;
        auto L = points.velocityGradient;
        const double *L11 = L[0], *L12 = L[1], *L21 = L[2], *L22 = L[3];
        double *exx = points.state[0], *eyy = points.state[1], *exy = points.state[3];
        const int count = points.count;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const double g11 = dt * L11[p], g12 = dt * L12[p], g21 = dt * L21[p], g22 = dt * L22[p];
            const double a = exx[p], b = exy[p], c = eyy[p];
            const double u11 = g11 * a + g12 * b, u12 = g11 * b + g12 * c; // g e
            const double u21 = g21 * a + g22 * b, u22 = g21 * b + g22 * c;
            exx[p] = a + (2 * (g11 + u11) + g11 * (g11 + u11) + g12 * (g12 + u12));
            eyy[p] = c + (2 * (g22 + u22) + g21 * (g21 + u21) + g22 * (g22 + u22));
            exy[p] = b + (g12 + u12 + g21 + u21 + g11 * (g21 + u21) + g12 * (g22 + u22));
        }
        double* ezz = points.state[2];
        for (int p = 0; points.hoopRate && p < count; ++p) {
            const double g = dt * points.hoopRate[p];
            ezz[p] += (2 * g + g * g) * (1 + ezz[p]);
        }
    }

    static void stretch(const MaterialPoints<3>& points) {
        const double dt = points.dt;
        const auto L = planes<9>(points.velocityGradient);
        const auto state = planes<6>(points.state);
        const int count = points.count;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const Tensor g = dt * gather(L, p);
            const Symmetric e = stretchAt(state, p);
            const Tensor u = g + g * e;
            const Symmetric after = e + (plusTransposed(u) + timesTransposed(u, g));
            state[0][p] = after.xx;
            state[1][p] = after.yy;
            state[2][p] = after.zz;
            state[3][p] = after.xy;
            state[4][p] = after.xz;
            state[5][p] = after.yz;
        }
    }

    template <class Planes> MPM_INLINE static Symmetric stretchAt(const Planes& e, int p) {
        return {e[0][p], e[1][p], e[2][p], e[3][p], e[4][p], e[5][p]};
    }

    // In the plane ln(b) = 1/2 ln(det b) I + Q dev(b), where Q = ln(l1/l2)/(l1 - l2) of the principal values
    // l1 >= l2, which are 1 + mean +- r. With l1 = (1 + t) l2, Q = ln(1 + t)/(2 r), which is well conditioned
    // down to t = 0.
    void stressOfStretch(const MaterialPoints<2>& points) const {
        const double lambda = elasticity_.lambda(), mu = elasticity_.mu();
        const double *exx = points.state[0], *eyy = points.state[1], *ezz = points.state[2],
                     *exy = points.state[3];
        const double *V = points.volume, *V0 = points.initialVolume;
        double *xx = points.stress[0], *xy = points.stress[1], *yx = points.stress[3], *yy = points.stress[4],
               *zz = points.stress[8];
        const int count = points.count;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const double mean = 0.5 * (exx[p] + eyy[p]), half = 0.5 * (exx[p] - eyy[p]), shear = exy[p];
            const double r2 = half * half + shear * shear, r = std::sqrt(r2 + 1e-300); // not 0
            const double growth = 2 * mean + (mean * mean - r2);                       // det b - 1
            const double t = 2 * r * (1 + mean + r) / (1 + growth), Q = logOnePlus(t) / (2 * r);
            const double logDet = logOnePlus(growth), logZ = logOnePlus(ezz[p]);

            const double overJ = V0[p] / V[p], spread = mu * Q; // 2 mu * 1/2 Q
            const double volumetric = 0.5 * lambda * (logDet + logZ);
            const double inPlane = volumetric + 0.5 * mu * logDet;
            xx[p] = overJ * (inPlane + spread * half);
            yy[p] = overJ * (inPlane - spread * half);
            zz[p] = overJ * (volumetric + mu * logZ);
            xy[p] = yx[p] = overJ * spread * shear;
        }
    }

    // By the series for all, and once more for the rare large strains.
    void stressOfStretch(const MaterialPoints<3>& points) const {
        const double lambda = elasticity_.lambda(), mu = elasticity_.mu();
        const auto state = planes<6>(points.state);
        const auto stress = planes<9>(points.stress);
        const double *V = points.volume, *V0 = points.initialVolume;
        const int count = points.count;
        double largest = 0;
#pragma omp simd reduction(max : largest)
        for (int p = 0; p < count; ++p) {
            const Symmetric e = stretchAt(state, p);
            largest = std::max(largest, largestRow(e));
            scatter(cauchy(lambda, mu, logOfIdentityPlus(e), V0[p] / V[p]), stress, p);
        }
        for (int p = 0; p < count && largest > logarithmLimit; ++p) {
            const Symmetric e = stretchAt(state, p);
            if (largestRow(e) > logarithmLimit)
                scatter(cauchy(lambda, mu, spectralLogOfIdentityPlus(e), V0[p] / V[p]), stress, p);
        }
    }

    Elasticity elasticity_;
};

MPM_REGISTER(Material, LinearElastic);

} // namespace
} // namespace mpm
