// SPDX-License-Identifier: GPL-2.0-or-later
// Hencky elasticity: linear between logarithmic strain and Kirchhoff stress, exact under rotation.
#include "mpm/material/Material.hpp"
#include "mpm/material/tensors.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>

namespace mpm {
namespace {

// ln(I + e) of a symmetric e. Elastic strains are small: with z = e (2 I + e)^-1, ln(I + e) = 2 atanh(z),
// whose series of eight terms is exact to round-off for |z| <= 0.1 (strains up to 0.1). Horner's rule runs on
// three scalars, because y = z^2 obeys y^3 = I1 y^2 - I2 y + I3. Beyond, the spectral form with the iterative
// solver; Eigen's direct one loses half the digits where eigenvalues are close.
Mat<3> logOfIdentityPlus(const Mat<3>& e) {
    const Mat<3> z = e * (2 * Mat<3>::Identity() + e).inverse(), y = z * z;
    const double I1 = y.trace();
    if (I1 <= 0.01) {
        const Mat<3> yy = y * y;
        const double I2 = 0.5 * (I1 * I1 - yy.trace()), I3 = y.determinant();
        double a = 1.0 / 15, b = 0, c = 0; // a I + b y + c y^2
        for (int n = 13; n >= 1; n -= 2) {
            const double oldA = a, oldB = b;
            a = c * I3 + 1.0 / n;
            b = oldA - c * I2;
            c = oldB + c * I1;
        }
        return 2 * a * z + 2 * z * (b * y + c * yy);
    }
    const Eigen::SelfAdjointEigenSolver<Mat<3>> spectrum(e);
    const Vec<3> logarithm = spectrum.eigenvalues().unaryExpr([](double x) { return logOnePlus(x); });
    return spectrum.eigenvectors() * logarithm.asDiagonal() * spectrum.eigenvectors().transpose();
}

// exp(a) - I of a symmetric a.
Mat<3> exponentialMinusIdentity(const Mat<3>& a) {
    const Eigen::SelfAdjointEigenSolver<Mat<3>> spectrum(a);
    const Vec<3> growth = spectrum.eigenvalues().unaryExpr([](double x) { return std::expm1(x); });
    return spectrum.eigenvectors() * growth.asDiagonal() * spectrum.eigenvectors().transpose();
}

// The state is e = b - I and not b itself: with b the last digit of 1 is the last digit of the strain.
class LinearElastic : public MaterialOf<LinearElastic> {
public:
    std::string className() const override { return "LinearElastic"; }
    std::string doc() const override {
        return R"(Linear elasticity in logarithmic strain (Hencky), for large rotation and any number of cycles.

    b <- f b f^T,  f = I + dt L
    eps = 1/2 ln(b),  tau = lambda tr(eps) I + 2 mu eps,  sigma = tau / J

b is the elastic left Cauchy-Green tensor; J is the ratio of current to initial domain volume. An initial
stress is the elastic strain from an unstressed state, while J counts from the initial one.

Source: Hencky 1928, Z. Techn. Phys. 9, 215-220; Simo & Hughes 1998, Computational Inelasticity, ch. 9.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters())
            all.push_back(p);
        return all;
    }
    void finish() override {
        require(density > 0, className(), ": density is required; give density in Mg/m3");
        elasticity_.finish(className());
    }
    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all;
        for (std::string axes : {"XX", "YY", "ZZ", "XY", "XZ", "YZ"})
            all.push_back({"stretch" + axes, "-",
                           "elastic left Cauchy-Green tensor less the identity, b - I, " + axes});
        return all;
    }
    std::array<double, 2> lame() const override { return {elasticity_.lambda(), elasticity_.mu()}; }

    void stateFromStress(const double stress[9], double* state) const override {
        Mat<3> tau;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                tau(i, j) = stress[3 * std::min(i, j) + std::max(i, j)];
        const double volumetric = tau.trace() / (3 * elasticity_.bulk());
        const Mat<3> eps =
            (tau - elasticity_.lambda() * volumetric * Mat<3>::Identity()) / (2 * elasticity_.mu());
        const Mat<3> e = exponentialMinusIdentity(2 * eps);
        for (int k = 0; k < 6; ++k)
            state[k] = e(row[k], column[k]);
    }

    template <int Dim>
    void stress(const MaterialPoints<Dim>& points) const {
        if constexpr (Dim == 2)
            planeStrain(points);
        else
            solid(points);
    }

private:
    static constexpr int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};

    // In the plane ln(b) = 1/2 ln(det b) I + Q dev(b), where Q = (ln l1 - ln l2)/(l1 - l2) of the principal
    // values l1 >= l2. With l1 = (1 + t) l2, Q = ln(1 + t)/(t l2), which is well conditioned down to t = 0.
    void planeStrain(const MaterialPoints<2>& points) const {
        const double lambda = elasticity_.lambda(), mu = elasticity_.mu(), dt = points.dt;
        auto L = points.velocityGradient;
        const double *L11 = L[0], *L12 = L[1], *L21 = L[2], *L22 = L[3], *J = points.volumeRatio;
        double *exx = points.state[0], *eyy = points.state[1], *ezz = points.state[2], *exy = points.state[3];
        double *xx = points.stress[0], *xy = points.stress[1], *yx = points.stress[3], *yy = points.stress[4],
               *zz = points.stress[8];
        const int count = points.count;
#pragma omp simd
        for (int p = 0; p < count; ++p) {
            const double g11 = dt * L11[p], g12 = dt * L12[p], g21 = dt * L21[p], g22 = dt * L22[p];
            // e <- g + g^T + g g^T + f e f^T, written as e plus its change
            const double a = exx[p], b = exy[p], c = eyy[p];
            const double u11 = g11 * a + g12 * b, u12 = g11 * b + g12 * c; // g e
            const double u21 = g21 * a + g22 * b, u22 = g21 * b + g22 * c;
            const double e11 = a + (2 * (g11 + u11) + g11 * (g11 + u11) + g12 * (g12 + u12));
            const double e22 = c + (2 * (g22 + u22) + g21 * (g21 + u21) + g22 * (g22 + u22));
            const double e12 = b + (g12 + u12 + g21 + u21 + g11 * (g21 + u21) + g12 * (g22 + u22));
            exx[p] = e11, eyy[p] = e22, exy[p] = e12;

            const double mean = 0.5 * (e11 + e22), half = 0.5 * (e11 - e22), r2 = half * half + e12 * e12;
            const double r = std::sqrt(r2), growth = 2 * mean + (mean * mean - r2); // det b - 1
            const double l2 = (1 + growth) / (1 + mean + r), t = 2 * r / l2;
            const double ratio = t > 1e-300 ? logOnePlus(t) / t : 1;
            const double logDet = logOnePlus(growth), logZ = logOnePlus(ezz[p]);

            const double overJ = 1 / J[p], spread = mu * ratio / l2; // 2 mu * 1/2 Q
            const double volumetric = 0.5 * lambda * (logDet + logZ);
            const double inPlane = volumetric + 0.5 * mu * logDet;
            xx[p] = overJ * (inPlane + spread * half);
            yy[p] = overJ * (inPlane - spread * half);
            zz[p] = overJ * (volumetric + mu * logZ);
            xy[p] = yx[p] = overJ * spread * e12;
        }
    }

    void solid(const MaterialPoints<3>& points) const {
        const double lambda = elasticity_.lambda(), mu = elasticity_.mu();
        for (int p = 0; p < points.count; ++p) {
            const Mat<3> g = points.dt * gather<3>(points.velocityGradient, p);
            Mat<3> e;
            for (int k = 0; k < 6; ++k)
                e(row[k], column[k]) = e(column[k], row[k]) = points.state[k][p];
            const Mat<3> u = g + g * e; // e <- g + g^T + g g^T + f e f^T
            e += (u + u.transpose() + u * g.transpose()).eval();
            for (int k = 0; k < 6; ++k)
                points.state[k][p] = e(row[k], column[k]);

            const Mat<3> logarithm = logOfIdentityPlus(e); // 2 eps
            Mat<3> tau = mu * logarithm;
            tau.diagonal().array() += 0.5 * lambda * logarithm.trace();
            scatterSymmetric(tau / points.volumeRatio[p], points.stress, p);
        }
    }

    Elasticity elasticity_;
};

MPM_REGISTER(Material, LinearElastic);

} // namespace
} // namespace mpm
