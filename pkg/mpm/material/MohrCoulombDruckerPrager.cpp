// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic-perfectly plastic c-phi soil: Mohr-Coulomb yield surface, Drucker-Prager plastic potential.
#include "mpm/base/simd/forEachSimdPair.hpp"
#include "mpm/material/Material.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/tensors.hpp"

#include <limits>

namespace mpm {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const double pi = std::acos(-1.0);

double orInfinity(double limit) { return std::isnan(limit) ? infinity : limit; }

// What the loops need, from the parameters.
struct Constants {
    double lambda, mu, bulk;
    double sinPhi, cCosPhi; // f = q A(theta) + p sin(phi) - c cos(phi)
    double apex;            // mean stress c cot(phi)
    double beta;            // g = q + 3 beta p
    double dilatancyLimit;  // of the plastic volumetric strain
    double tensionCutOff;
    double shearCompliance; // plastic shear strain per unit loss of q, 1/(sqrt(3) mu)
    double bulkCompliance;  // 1/K
};

template <class Number> struct Returned {
    Number scale, p; // s = scale s_trial, mean stress p
};

// Along the plastic potential back to the cone. q = sqrt(J2) and qA = q A(theta) of the trial stress; scaling
// s keeps theta, hence the yield function falls linearly and one step is exact. Free of branches and of a
// division by q: q = 0 gives -inf or NaN (elastic, dlam = 0) or +inf, which is the apex.
//
// Dilation may lower p by no more than `room`, K times what is left up to the limit. A return that would pass
// it (volumetric f/slope > room) goes along the potential down to there and on at constant p, in one division.
// Where it would end beyond the apex, so would the return without limit, and both go there.
template <bool limited, class Number>
MPM_INLINE Returned<Number> returnMap(const Constants& k, Number p, Number q, Number qA,
                                      Number plasticVolumetric) {
    const Number f = qA + (p * k.sinPhi - k.cCosPhi), volumetric = 3 * k.bulk * k.beta * q;
    const Number freely = k.mu * qA + volumetric * k.sinPhi;
    Number excess = f, slope = freely, room = 0;
    const auto ifPasses = [&](Number then, Number otherwise) MPM_INLINE_LAMBDA {
        return limited ? whereGreater(volumetric * f, room * freely, then, otherwise) : otherwise;
    };
    if constexpr (limited) {
        const Number left = k.dilatancyLimit - plasticVolumetric;
        room = whereGreater(left, 0, k.bulk * left, 0);
        excess = ifPasses(f - room * k.sinPhi, f);
        slope = ifPasses(k.mu * qA, freely);
    }
    const Number ratio = excess / slope;
    const Number dlamOverQ = whereGreater(ratio, 0, ratio, 0);
    const Number scale = 1 - k.mu * dlamOverQ, dilated = ifPasses(p - room, p - volumetric * dlamOverQ);
    const Number pBack = whereGreater(0, scale, k.apex, dilated);
    return {whereGreater(scale, 0, scale, 0), whereGreater(pBack, k.tensionCutOff, k.tensionCutOff, pBack)};
}

// Trial stress in, stress out. The mean stress of soil that is open is that at which it opened, until what the
// trial stress closes, (mostTension - p)/K, has used the opening up.
template <int Dim> void closeUp(const Constants& constants, const MaterialPoints<Dim>& points) {
    const Constants k = constants;
    const double most = std::min(k.apex, k.tensionCutOff);
    double *xx = points.stress[0], *yy = points.stress[4], *zz = points.stress[8];
    double *plasticVolumetric = points.state[1], *opening = points.state[2];
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const double below = (most - (xx[i] + yy[i] + zz[i]) / 3) * k.bulkCompliance;
        const double closed = std::min(std::max(below, 0.0), opening[i]), p = k.bulk * closed;
        xx[i] += p;
        yy[i] += p;
        zz[i] += p;
        plasticVolumetric[i] -= closed;
        opening[i] -= closed;
    }
}

// After closeUp(): what takes the mean stress of a trial beyond the apex or the tension cut-off opens the soil.
template <int Dim> void openUp(const Constants& constants, const MaterialPoints<Dim>& points) {
    const Constants k = constants;
    const double most = std::min(k.apex, k.tensionCutOff);
    const double *xx = points.stress[0], *yy = points.stress[4], *zz = points.stress[8];
    double* opening = points.state[2];
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i)
        opening[i] += std::max((xx[i] + yy[i] + zz[i]) / 3 - most, 0.0) * k.bulkCompliance;
}

template <bool limited> void returnToYield(const Constants& constants, const MaterialPoints<2>& points) {
    const Constants k = constants;
    const double third = 1.0 / 3, major = (1 + k.sinPhi) / 2, minor = (1 - k.sinPhi) / 2;
    double *xx = points.stress[0], *xy = points.stress[1], *yx = points.stress[3], *yy = points.stress[4],
           *zz = points.stress[8];
    double *plasticShear = points.state[0], *plasticVolumetric = points.state[1];
    forEachSimdPair(points.count, [&](auto at) MPM_INLINE_LAMBDA {
        // Principal deviators a + r, a - r and -2a: no Lode angle needed.
        const auto mean = 0.5 * (at(xx) + at(yy)), half = 0.5 * (at(xx) - at(yy)), shear = at(xy);
        const auto a = third * (mean - at(zz)), p = mean - a;
        const auto r2 = half * half + shear * shear, r = root(r2), q = root(r2 + 3 * a * a);
        const auto s1 = whereGreater(a + r, -2 * a, a + r, -2 * a),
                   s3 = whereGreater(-2 * a, a - r, a - r, -2 * a);
        const auto qA = major * s1 - minor * s3; // (s1 - s3)/2 + (s1 + s3)/2 sin(phi)

        const auto back = returnMap<limited>(k, p, q, qA, at(plasticVolumetric));
        at.set(xx, back.p + back.scale * (a + half));
        at.set(yy, back.p + back.scale * (a - half));
        at.set(zz, back.p - back.scale * 2 * a);
        const auto scaled = back.scale * shear;
        at.set(xy, scaled);
        at.set(yx, scaled);
        at.set(plasticShear, at(plasticShear) + (1 - back.scale) * q * k.shearCompliance);
        at.set(plasticVolumetric, at(plasticVolumetric) + (p - back.p) * k.bulkCompliance);
    });
}

// q A(theta) = q (cos(theta) - sin(theta) sin(phi)/sqrt(3)) of a deviator s with q^2 = J2. cos(3 theta) comes
// from the part of s^2 orthogonal to I and s, adj(s) + J2/3 I - 3 J3/(2 J2) s, whose norm is the root of the
// discriminant: from sin(3 theta) alone, half the digits would be lost near triaxial states.
//
// c = cos(theta) is the root of 4 c^3 - 3 c = cos(3 theta) in [sqrt(3)/2, 1], where the slope of the cubic
// lies in [6, 9]. From the parabola through the roots at cos(3 theta) = 0, 1/2 and 1, a step of Halley gets
// within 3e-10, and a step d of Newton to round-off. Then sin(theta) = sin(3 theta)/(4 c^2 - 1), three over
// the slope.
MPM_INLINE double lodeStrength(const Symmetric& s, double J2, double q, double sinPhi) {
    const double third = 1.0 / 3, root3 = std::sqrt(3.0);
    const double J4 = J2 * J2, overJ4 = 1 / (J4 + 1e-150); // q < 1e-37: none
    const Symmetric adj = adjugate(s);
    const double J3 = determinant(s, adj);
    const Symmetric orthogonal = plusSpherical(J2 * adj, third * J4) + (-1.5 * J3) * s;
    const double cos3 = std::sqrt(3 * halfSquare(orthogonal)) * overJ4;
    const double sin3 = -1.5 * root3 * (overJ4 * (q * J3));

    const double cos30 = 0.5 * root3, cos20 = 0.93969262078590838, bend = 2 - 4 * cos20 + 2 * cos30;
    const double guess = cos30 + cos3 * (1 - cos30 - bend + bend * cos3);
    const double error = (4 * guess * guess - 3) * guess - cos3, steep = 12 * guess * guess - 3;
    const double c = guess - error * steep / (steep * steep - 12 * guess * error);
    const double overSlope = 1 / (12 * c * c - 3), d = ((4 * c * c - 3) * c - cos3) * overSlope;
    const double sine = 3 * sin3 * overSlope * (1 + 24 * c * d * overSlope);
    return q * (c - d - sine * (sinPhi / root3));
}

template <bool limited> void returnToYield(const Constants& constants, const MaterialPoints<3>& points) {
    const Constants k = constants;
    const double third = 1.0 / 3;
    const auto stress = planes<9>(points.stress);
    double *plasticShear = points.state[0], *plasticVolumetric = points.state[1];
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const Symmetric trial = gatherUpper(stress, i);
        const double p = third * trace(trial);
        const Symmetric s = plusSpherical(trial, -p);
        const double J2 = halfSquare(s), q = std::sqrt(J2);

        const Returned<double> back =
            returnMap<limited>(k, p, q, lodeStrength(s, J2, q, k.sinPhi), plasticVolumetric[i]);
        scatter(plusSpherical(back.scale * s, back.p), stress, i);
        plasticShear[i] += (1 - back.scale) * q * k.shearCompliance;
        plasticVolumetric[i] += (p - back.p) * k.bulkCompliance;
    }
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

beta is 0 once the plastic volumetric strain is dilatancyLimit, or ln((1 + e_c)/(1 + e_0)) by the void ratios
(incompressible grains). The step that reaches the limit is split there. Opening at the apex and at the tension
cut-off is not dilatancy: it counts, for soil that opened is loose, but it is never held back, for the stress
could not come back to the yield surface. With `closing`, the default in bodies with F-bar, the opening is a
variable of state, and compression uses it up at constant mean stress before the soil bears pressure: what
parted and meets again has its volume. `closing=False` is the elastic-perfectly plastic law.

Source: the definition is this project's; Drucker & Prager 1952, Q. Appl. Math. 10, 157-165; Hughes & Winget
1980, Int. J. Numer. Methods Eng. 15, 1862-1867; the limit: the dilatancy cut-off of the
Hardening Soil model in the PLAXIS Material Models Manual; non-associated flow: Vermeer & de Borst 1984, Heron 29 (3).)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters()) all.push_back(p);
        const Range acute{0, pi / 2, false, true};
        all.push_back({"cohesion", "kPa", "required: cohesion c", &cohesion_, Range::notNegative()});
        all.push_back(
            {"frictionAngle", "rad", "required: friction angle phi", &frictionAngle_, acute, {}, true});
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
                       &tensionCutOff_, Range::notNegative()});
        all.push_back({"dilatancyLimit", "-",
                       "plastic volumetric strain from which on psi is 0; not given: off", &dilatancyLimit_,
                       Range::notNegative()});
        all.push_back(
            {"initialVoidRatio", "-",
             "void ratio e_0 at the start, together with criticalVoidRatio in place of dilatancyLimit",
             &initialVoidRatio_, Range::positive()});
        all.push_back({"criticalVoidRatio", "-",
                       "void ratio e_c from which on psi is 0, at least initialVoidRatio",
                       &criticalVoidRatio_, Range::positive()});
        all.push_back(
            {"closing", "",
             "whether soil that has opened, at the apex or the tension cut-off, closes before it bears "
             "pressure again; not given: in bodies with F-bar",
             &closing_});
        return all;
    }
    void finish() override;

    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all{
            {"plasticShearStrain", "-", "accumulated plastic shear strain, sum of sqrt(2/3 de:de)"},
            {"plasticVolumetricStrain", "-", "plastic volumetric strain, dilation positive"}};
        if (closing_.value_or(true))
            all.push_back(
                {"opening", "-",
                 "volumetric strain by which the soil stands open, at the apex or the tension cut-off"});
        return all;
    }
    bool yields() const override { return true; }
    int opening() const override { return closing_.value_or(true) && !std::isinf(mostMeanStress()) ? 2 : -1; }
    void shared(const MaterialPoints<2>& points, const double* change) const override {
        bookOpening(points, change);
    }
    void shared(const MaterialPoints<3>& points, const double* change) const override {
        bookOpening(points, change);
    }
    std::array<double, 2> lame() const override { return {elasticity_.lambda(), elasticity_.mu()}; }
    void mixed(const MaterialPoints<2>& points, const double* change) const override {
        exchangeVolume(points, change);
    }
    void mixed(const MaterialPoints<3>& points, const double* change) const override {
        exchangeVolume(points, change);
    }

    void shearStrength(const MaterialPoints<2>& points, double* strength) const override {
        strengthAtMeanStress(points, strength);
    }
    void shearStrength(const MaterialPoints<3>& points, double* strength) const override {
        strengthAtMeanStress(points, strength);
    }

    // Any Cauchy stress may be given; one beyond yield returns to the surface in the first step.
    void stateFromStress(const double*, double* state) const override {
        std::fill_n(state, stateVariables().size(), 0.0);
    }

    template <int Dim> void stress(const MaterialPoints<Dim>& points) const {
        trialStress(constants_.lambda, constants_.mu, points);
        if (closes(points.hasFbar)) {
            closeUp(constants_, points);
            openUp(constants_, points);
        }
        std::isinf(constants_.dilatancyLimit) ? returnToYield<false>(constants_, points)
                                              : returnToYield<true>(constants_, points);
    }

  private:
    bool closes(bool hasFbar) const { return opening() >= 0 && closing_.value_or(hasFbar); }

    template <int Dim> void bookOpening(const MaterialPoints<Dim>& points, const double* change) const {
        for (int i = 0; i < points.count; ++i) points.state[1][i] += change[i];
    }
    template <int Dim> void exchangeVolume(const MaterialPoints<Dim>& points, const double* change) const {
        for (int i = 0; i < points.count; ++i) points.state[1][i] -= change[i] * constants_.bulkCompliance;
    }

    template <int Dim> void strengthAtMeanStress(const MaterialPoints<Dim>& points, double* strength) const {
        for (int i = 0; i < points.count; ++i) {
            const double p = (points.stress[0][i] + points.stress[4][i] + points.stress[8][i]) / 3;
            strength[i] = std::max(0.0, constants_.cCosPhi - p * constants_.sinPhi);
        }
    }

    double mostMeanStress() const { return std::min(constants_.apex, constants_.tensionCutOff); }
    double beta() const;
    double limitOfDilatancy() const;

    Elasticity elasticity_;
    double cohesion_ = notGiven, frictionAngle_ = notGiven, dilatancyAngle_ = 0;
    std::string coneFit_ = "planeStrain";
    double tensionCutOff_ = notGiven, dilatancyLimit_ = notGiven;
    double initialVoidRatio_ = notGiven, criticalVoidRatio_ = notGiven;
    std::optional<bool> closing_; // not given: where there is F-bar
    Constants constants_{};
};

double MohrCoulombDruckerPrager::beta() const {
    const double s = std::sin(dilatancyAngle_);
    if (coneFit_ == "triaxialCompression") return 2 * s / (std::sqrt(3.0) * (3 - s));
    if (coneFit_ == "triaxialExtension") return 2 * s / (std::sqrt(3.0) * (3 + s));
    const double t = std::tan(dilatancyAngle_);
    return t / std::sqrt(9 + 12 * t * t);
}

// The plastic volumetric strain is logarithmic: 1 + e = (1 + e_0) exp(eps_v^p).
double MohrCoulombDruckerPrager::limitOfDilatancy() const {
    const bool byInitial = !std::isnan(initialVoidRatio_), byCritical = !std::isnan(criticalVoidRatio_);
    if (!byInitial && !byCritical) return orInfinity(dilatancyLimit_);
    const std::string who = className();
    require(byInitial && byCritical, who, ": ", byInitial ? "initialVoidRatio" : "criticalVoidRatio", " = ",
            byInitial ? initialVoidRatio_ : criticalVoidRatio_, " is given without ",
            byInitial ? "criticalVoidRatio" : "initialVoidRatio", "; give both, or dilatancyLimit");
    require(std::isnan(dilatancyLimit_), who, ": dilatancyLimit = ", dilatancyLimit_,
            " and initialVoidRatio = ", initialVoidRatio_, ", criticalVoidRatio = ", criticalVoidRatio_,
            " are given together; give either the limit or the void ratios");
    require(initialVoidRatio_ <= criticalVoidRatio_, who, ": initialVoidRatio = ", initialVoidRatio_,
            " exceeds criticalVoidRatio = ", criticalVoidRatio_,
            "; soil that loose does not dilate: give dilatancyAngle = 0 and leave the void ratios out");
    return std::log1p((criticalVoidRatio_ - initialVoidRatio_) / (1 + initialVoidRatio_));
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
    k.lambda = elasticity_.lambda();
    k.mu = elasticity_.mu();
    k.bulk = elasticity_.bulk();
    k.sinPhi = std::sin(frictionAngle_);
    k.cCosPhi = cohesion_ * std::cos(frictionAngle_);
    k.apex = frictionAngle_ > 0 ? cohesion_ / std::tan(frictionAngle_) : infinity;
    k.beta = beta();
    k.dilatancyLimit = limitOfDilatancy();
    k.tensionCutOff = orInfinity(tensionCutOff_);
    k.shearCompliance = 1 / (std::sqrt(3.0) * k.mu);
    k.bulkCompliance = 1 / k.bulk;
    require(std::isnan(tensionCutOff_) || tensionCutOff_ <= k.apex, who, ": tensionCutOff = ", tensionCutOff_,
            " kPa lies beyond the apex of the cone, c cot(phi) = ", k.apex, " kPa; lower it or leave it out");
    constants_ = k;
}

MPM_REGISTER(Material, MohrCoulombDruckerPrager);

} // namespace
} // namespace mpm
