// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic-perfectly plastic c-phi soil: Mohr-Coulomb yield surface, Drucker-Prager plastic potential.
#include "mpm/material/Material.hpp"
#include "mpm/material/tensors.hpp"

#include <Eigen/LU>

namespace mpm {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const double pi = std::acos(-1.0);

double orInfinity(double limit) {
    return std::isnan(limit) ? infinity : limit;
}

// What the loops need, from the parameters.
struct Constants {
    double lambda, mu, bulk;
    double sinPhi, cCosPhi; // f = q A(theta) + p sin(phi) - c cos(phi)
    double largestA;        // of all theta
    double apex;            // mean stress c cot(phi)
    double beta;            // g = q + 3 beta p
    double dilatancyLimit, tensionCutOff;
    double shearCompliance; // plastic shear strain per unit loss of q, 1/(sqrt(3) mu)
    double bulkCompliance;  // 1/K
};

struct Returned {
    double scale, p; // s = scale s_trial, mean stress p
};

// Along the plastic potential back to the cone. q = sqrt(J2) and qA = q A(theta) of the trial stress; scaling
// s keeps theta, hence the yield function falls linearly and one step is exact. Free of branches and of a
// division by q: q = 0 gives -inf or NaN (elastic, dlam = 0) or +inf, which is the apex.
inline Returned returnMap(const Constants& k, double p, double q, double qA, double plasticVolumetric) {
    const double beta = plasticVolumetric > k.dilatancyLimit ? 0 : k.beta;
    const double f = qA + p * k.sinPhi - k.cCosPhi, volumetric = 3 * k.bulk * beta * q;
    const double ratio = f / (k.mu * qA + volumetric * k.sinPhi);
    const double dlamOverQ = ratio > 0 ? ratio : 0;
    const double scale = 1 - k.mu * dlamOverQ;
    const double pBack = scale < 0 ? k.apex : p - volumetric * dlamOverQ;
    return {scale < 0 ? 0 : scale, pBack > k.tensionCutOff ? k.tensionCutOff : pBack};
}

// q A(theta) in 3D. cos(3 theta) comes from the part of s^2 orthogonal to I and s, whose norm is the root of
// the discriminant: from sin(3 theta) alone, half the digits would be lost near triaxial states.
double lodeStrength(const Mat<3>& s, double J2, double sinPhi) {
    const double q = std::sqrt(J2);
    if (J2 < 1e-200)
        return 0;
    const Mat<3> n = s / q, nn = n * n;
    const double J3 = n.cwiseProduct(nn).sum() / 3;
    const double sin3 = -1.5 * std::sqrt(3.0) * J3;
    const double cos3 = std::sqrt(1.5) * (nn - 2.0 / 3.0 * Mat<3>::Identity() - 1.5 * J3 * n).norm();
    const double theta = std::atan2(sin3, cos3) / 3;
    return q * (std::cos(theta) - std::sin(theta) * sinPhi / std::sqrt(3.0));
}

class MohrCoulombDruckerPrager : public MaterialOf<MohrCoulombDruckerPrager> {
public:
    std::string className() const override { return "MohrCoulombDruckerPrager"; }
    std::string doc() const override {
        return R"(Elastic-perfectly plastic soil: Mohr-Coulomb yield surface f, Drucker-Prager potential g.

    f = (s1 - s3)/2 + (s1 + s3)/2 sin(phi) - c cos(phi)
    g = sqrt(J2) + beta I1,  beta from the dilatancy angle by coneFit
    trial: R sigma R^T + r (lambda tr(D) I + 2 mu D) r^T,  R = r r = (I - W/2)^-1 (I + W/2)
    D, W = sym, skew of dt L (I + dt L/2)^-1

s1 >= s3 are principal Cauchy stresses, tension positive. The elastic law is hypoelastic (Jaumann rate, for
small elastic strain). It is exact for a finite rotation in one step and of second order otherwise, because
D of the midpoint is turned by the half rotation r. The return is closed form; stress beyond the apex goes to
the apex. A tension cut-off then lowers the mean stress alone, and its volume change counts as plastic.

Source: the definition is this project's; Drucker & Prager 1952, Q. Appl. Math. 10, 157-165; Hughes & Winget
1980, Int. J. Numer. Methods Eng. 15, 1862-1867.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters())
            all.push_back(p);
        const Range acute{0, pi / 2, false, true};
        all.push_back({"cohesion", "kPa", "cohesion c", &cohesion_, Range::notNegative()});
        all.push_back({"frictionAngle", "rad", "friction angle phi", &frictionAngle_, acute, {}, true});
        all.push_back({"dilatancyAngle",
                       "rad",
                       "dilatancy angle psi, at most frictionAngle",
                       &dilatancyAngle_,
                       acute,
                       {},
                       true});
        all.push_back({"coneFit",
                       "",
                       "state in which the cone dilates at the dilatancy angle",
                       &coneFit_,
                       {},
                       {"planeStrain", "triaxialCompression", "triaxialExtension"}});
        all.push_back({"tensionCutOff", "kPa", "highest mean stress, at most c cot(phi); not given: off",
                       &tensionCutOff_});
        all.push_back({"dilatancyLimit", "-",
                       "plastic volumetric strain beyond which psi is 0; not given: off", &dilatancyLimit_,
                       Range::notNegative()});
        return all;
    }
    void finish() override;

    std::vector<StateVariable> stateVariables() const override {
        return {{"plasticShearStrain", "-", "accumulated plastic shear strain, sum of sqrt(2/3 de:de)"},
                {"plasticVolumetricStrain", "-", "plastic volumetric strain, dilation positive"}};
    }
    std::array<double, 2> lame() const override { return {elasticity_.lambda(), elasticity_.mu()}; }

    // Any Cauchy stress may be given; one beyond yield returns to the surface in the first step.
    void stateFromStress(const double*, double* state) const override { state[0] = state[1] = 0; }

    template <int Dim>
    void stress(const MaterialPoints<Dim>& points) const {
        if constexpr (Dim == 2)
            planeStrain(points);
        else
            solid(points);
    }

private:
    double beta() const;
    void planeStrain(const MaterialPoints<2>& points) const;
    void solid(const MaterialPoints<3>& points) const;

    Elasticity elasticity_;
    double cohesion_ = notGiven, frictionAngle_ = notGiven, dilatancyAngle_ = 0;
    std::string coneFit_ = "planeStrain";
    double tensionCutOff_ = notGiven, dilatancyLimit_ = notGiven;
    Constants constants_{};
};

double MohrCoulombDruckerPrager::beta() const {
    const double s = std::sin(dilatancyAngle_);
    if (coneFit_ == "triaxialCompression")
        return 2 * s / (std::sqrt(3.0) * (3 - s));
    if (coneFit_ == "triaxialExtension")
        return 2 * s / (std::sqrt(3.0) * (3 + s));
    const double t = std::tan(dilatancyAngle_);
    return t / std::sqrt(9 + 12 * t * t);
}

void MohrCoulombDruckerPrager::finish() {
    const std::string who = className();
    require(density > 0, who, ": density is required; give density in Mg/m3");
    elasticity_.finish(who);
    require(!std::isnan(cohesion_), who, ": cohesion is required; give cohesion in kPa (0 for sand)");
    require(!std::isnan(frictionAngle_), who,
            ": frictionAngle is required; give it in radians (0 for undrained clay)");
    require(cohesion_ > 0 || frictionAngle_ > 0, who,
            ": cohesion and frictionAngle are both 0, which is a fluid; "
            "give one of them a positive value");
    require(dilatancyAngle_ <= frictionAngle_, who, ": dilatancyAngle = ", dilatancyAngle_,
            " exceeds frictionAngle = ", frictionAngle_,
            "; give 0 <= dilatancyAngle <= frictionAngle (radians)");

    Constants k;
    k.lambda = elasticity_.lambda(), k.mu = elasticity_.mu(), k.bulk = elasticity_.bulk();
    k.sinPhi = std::sin(frictionAngle_), k.cCosPhi = cohesion_ * std::cos(frictionAngle_);
    k.largestA = std::sqrt(1 + k.sinPhi * k.sinPhi / 3);
    k.apex = frictionAngle_ > 0 ? cohesion_ / std::tan(frictionAngle_) : infinity;
    k.beta = beta();
    k.dilatancyLimit = orInfinity(dilatancyLimit_), k.tensionCutOff = orInfinity(tensionCutOff_);
    k.shearCompliance = 1 / (std::sqrt(3.0) * k.mu), k.bulkCompliance = 1 / k.bulk;
    require(std::isnan(tensionCutOff_) || tensionCutOff_ <= k.apex, who, ": tensionCutOff = ", tensionCutOff_,
            " kPa lies beyond the apex of the cone, c cot(phi) = ", k.apex, " kPa; lower it or leave it out");
    constants_ = k;
}

// The plane-strain tensors in closed form. With g = dt L and D2 = det(I + g/2), Cayley-Hamilton gives
// g (I + g/2)^-1 = (g + det(g)/2 I)/D2, and R rotates by the angle whose half has the tangent spin/D2.
void MohrCoulombDruckerPrager::planeStrain(const MaterialPoints<2>& points) const {
    const Constants k = constants_;
    const double dt = points.dt, third = 1.0 / 3, major = (1 + k.sinPhi) / 2, minor = (1 - k.sinPhi) / 2;
    auto L = points.velocityGradient;
    const double *L11 = L[0], *L12 = L[1], *L21 = L[2], *L22 = L[3];
    double *xx = points.stress[0], *xy = points.stress[1], *yx = points.stress[3], *yy = points.stress[4],
           *zz = points.stress[8];
    double *plasticShear = points.state[0], *plasticVolumetric = points.state[1];
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const double g11 = dt * L11[i], g12 = dt * L12[i], g21 = dt * L21[i], g22 = dt * L22[i];
        const double detG = g11 * g22 - g12 * g21, D2 = 1 + 0.5 * (g11 + g22) + 0.25 * detG;
        const double spin = 0.25 * (g12 - g21), D4 = D2 * D2, norm = D4 + spin * spin;
        const double overD2 = 1 / D2, overNorm = 1 / norm;
        const double cosR = (D4 - spin * spin) * overNorm, sinR = 2 * spin * D2 * overNorm;
        // Of the double angle; this form keeps cos2^2 + sin2^2 = 1 best, hence the norm of the stress.
        const double cos2 = 1 - 2 * sinR * sinR, sin2 = 2 * sinR * cosR;

        // Trial stress as mean and half difference in the plane, shear, and out of plane.
        const double half0 = 0.5 * (xx[i] - yy[i]), shear0 = xy[i];
        const double volumetric = (g11 + g22 + detG) * overD2;
        const double dHalf = k.mu * (g11 - g22) * overD2, dShear = k.mu * (g12 + g21) * overD2;
        const double mean = 0.5 * (xx[i] + yy[i]) + (k.lambda + k.mu) * volumetric;
        const double half = half0 * cos2 + shear0 * sin2 + dHalf * cosR + dShear * sinR;
        const double shear = shear0 * cos2 - half0 * sin2 + dShear * cosR - dHalf * sinR;
        const double out = zz[i] + k.lambda * volumetric;

        // Principal deviators a + r, a - r and -2a: no Lode angle needed.
        const double a = third * (mean - out), p = mean - a;
        const double r2 = half * half + shear * shear, r = std::sqrt(r2), q = std::sqrt(r2 + 3 * a * a);
        const double s1 = a + r > -2 * a ? a + r : -2 * a, s3 = a - r < -2 * a ? a - r : -2 * a;
        const double qA = major * s1 - minor * s3; // (s1 - s3)/2 + (s1 + s3)/2 sin(phi)

        const Returned back = returnMap(k, p, q, qA, plasticVolumetric[i]);
        xx[i] = back.p + back.scale * (a + half);
        yy[i] = back.p + back.scale * (a - half);
        zz[i] = back.p - back.scale * 2 * a;
        xy[i] = yx[i] = back.scale * shear;
        plasticShear[i] += (1 - back.scale) * q * k.shearCompliance;
        plasticVolumetric[i] += (p - back.p) * k.bulkCompliance;
    }
}

void MohrCoulombDruckerPrager::solid(const MaterialPoints<3>& points) const {
    const Constants k = constants_;
    const Mat<3> I = Mat<3>::Identity();
    for (int i = 0; i < points.count; ++i) {
        const Mat<3> g = points.dt * gather<3>(points.velocityGradient, i);
        const Mat<3> G = g * (I + 0.5 * g).inverse();
        const Mat<3> D = 0.5 * (G + G.transpose()), W = 0.5 * (G - G.transpose());
        // Half rotation: W/2 holds the tangent of half the angle of R, w/2 that of a quarter.
        const Mat<3> w = W / (1 + std::sqrt(1 + 0.125 * W.squaredNorm()));
        const Mat<3> r = I + (w + 0.5 * w * w) / (1 + 0.125 * w.squaredNorm());

        Mat<3> trial = r * gatherSymmetric(points.stress, i) * r.transpose() + 2 * k.mu * D;
        trial = (r * trial * r.transpose()).eval();
        trial.diagonal().array() += k.lambda * D.trace();
        const double p = trial.trace() / 3;
        const Mat<3> s = trial - p * I;
        const double J2 = 0.5 * s.squaredNorm(), q = std::sqrt(J2);

        double qA = q * k.largestA; // enough to tell that a stress is elastic
        if (qA + p * k.sinPhi > k.cCosPhi)
            qA = lodeStrength(s, J2, k.sinPhi);
        const Returned back = returnMap(k, p, q, qA, points.state[1][i]);
        scatterSymmetric(back.scale * s + back.p * I, points.stress, i);
        points.state[0][i] += (1 - back.scale) * q * k.shearCompliance;
        points.state[1][i] += (p - back.p) * k.bulkCompliance;
    }
}

MPM_REGISTER(Material, MohrCoulombDruckerPrager);

} // namespace
} // namespace mpm
