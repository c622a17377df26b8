// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic-perfectly plastic c-phi soil: Mohr-Coulomb yield surface, Drucker-Prager plastic potential.
#include "mpm/base/simd/forEachSimdPair.hpp"
#include "mpm/material/Strength.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/lode.hpp"
#include "mpm/material/opening.hpp"
#include "mpm/material/required.hpp"
#include "mpm/material/spareStrength.hpp"
#include "mpm/material/stiffening.hpp"

#include <limits>

namespace mpm {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

double orInfinity(double limit) { return std::isnan(limit) ? infinity : limit; }

// The cone: numbers, or one of each particle.
template <class Number> struct Cone {
    Number sinPhi, cCosPhi; // f = q A(theta) + p sin(phi) - c cos(phi)
    Number apex;            // mean stress c cot(phi)
    Number beta;            // g = q + 3 beta p
};

// What the loops need, from the parameters.
struct Constants {
    double dilatancyLimit; // of the plastic volumetric strain
    double tensionCutOff;
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
template <bool limited, class Number, class Its, class Elastic>
MPM_INLINE Returned<Number> returnMap(const Constants& k, const Moduli<Elastic>& C, const Cone<Its>& cone,
                                      Number p, Number q, Number qA, Number plasticVolumetric) {
    const Number f = qA + (p * cone.sinPhi - cone.cCosPhi), volumetric = 3 * C.bulk * cone.beta * q;
    const Number freely = C.mu * qA + volumetric * cone.sinPhi;
    Number excess = f, slope = freely, room = 0;
    const auto ifPasses = [&](Number then, Number otherwise) MPM_INLINE_LAMBDA {
        return limited ? whereGreater(volumetric * f, room * freely, then, otherwise) : otherwise;
    };
    if constexpr (limited) {
        const Number left = k.dilatancyLimit - plasticVolumetric;
        room = whereGreater(left, 0, C.bulk * left, 0);
        excess = ifPasses(f - room * cone.sinPhi, f);
        slope = ifPasses(C.mu * qA, freely);
    }
    const Number ratio = excess / slope;
    const Number dlamOverQ = whereGreater(ratio, 0, ratio, 0);
    const Number scale = 1 - C.mu * dlamOverQ, dilated = ifPasses(p - room, p - volumetric * dlamOverQ);
    const Number pBack = whereGreater(0, scale, cone.apex, dilated);
    return {whereGreater(scale, 0, scale, 0), whereGreater(pBack, k.tensionCutOff, k.tensionCutOff, pBack)};
}

// Plastic shear strain per unit loss of q.
template <class Number> MPM_INLINE Number shearCompliance(const Number& mu) {
    return 1 / (std::sqrt(3.0) * mu);
}

// Where the cones of particles are taken from: `at` reads a plane.
struct OneCone {
    Cone<double> cone;
    template <class At> MPM_INLINE Cone<double> operator()(At&&) const { return cone; }
};
struct ConeOfEach {
    Cone<const double*> planes;
    template <class At> MPM_INLINE auto operator()(At&& at) const {
        using Number = std::decay_t<decltype(at(planes.beta) + 0.0)>;
        return Cone<Number>{at(planes.sinPhi), at(planes.cCosPhi), at(planes.apex), at(planes.beta)};
    }
};

template <bool limited, class Cones, class Number>
void returnToYield(const Constants& constants, const Moduli<Number>& moduli, const Cones& cones,
                   const MaterialPoints<2>& points) {
    const Constants k = constants;
    const Moduli<Number> C = moduli;
    const Cones coneOf = cones;
    const double third = 1.0 / 3;
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
        const auto cone = coneOf(at);
        const auto major = (1 + cone.sinPhi) / 2, minor = (1 - cone.sinPhi) / 2;
        const auto qA = major * s1 - minor * s3; // (s1 - s3)/2 + (s1 + s3)/2 sin(phi)

        const auto its = C.at(at);
        const auto back = returnMap<limited>(k, its, cone, p, q, qA, at(plasticVolumetric));
        at.set(xx, back.p + back.scale * (a + half));
        at.set(yy, back.p + back.scale * (a - half));
        at.set(zz, back.p - back.scale * 2 * a);
        const auto scaled = back.scale * shear;
        at.set(xy, scaled);
        at.set(yx, scaled);
        at.set(plasticShear, at(plasticShear) + (1 - back.scale) * q * shearCompliance(its.mu));
        at.set(plasticVolumetric, at(plasticVolumetric) + (p - back.p) * (1 / its.bulk));
    });
}

template <bool limited, class Cones, class Number>
void returnToYield(const Constants& constants, const Moduli<Number>& moduli, const Cones& cones,
                   const MaterialPoints<3>& points) {
    const Constants k = constants;
    const Moduli<Number> C = moduli;
    const Cones coneOf = cones;
    const double third = 1.0 / 3;
    const auto stress = planes<9>(points.stress);
    double *plasticShear = points.state[0], *plasticVolumetric = points.state[1];
    const int count = points.count;
    const auto first = coneOf([](const double* plane) { return plane[0]; });
    const double sinPhi = first.sinPhi, cCosPhi = first.cCosPhi, apex = first.apex, beta = first.beta;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const Symmetric trial = gatherUpper(stress, i);
        const double p = third * trace(trial);
        const Symmetric s = plusSpherical(trial, -p);
        const double J2 = halfSquare(s), q = std::sqrt(J2);

        Cone<double> cone{sinPhi, cCosPhi, apex, beta};
        if constexpr (!std::is_same_v<Cones, OneCone>)
            cone = coneOf([i](const double* plane) MPM_INLINE_LAMBDA { return plane[i]; });
        const Moduli<double> its = C.at(i);
        const Returned<double> back =
            returnMap<limited>(k, its, cone, p, q, lodeStrength(s, J2, q, cone.sinPhi), plasticVolumetric[i]);
        scatter(plusSpherical(back.scale * s, back.p), stress, i);
        plasticShear[i] += (1 - back.scale) * q * shearCompliance(its.mu);
        plasticVolumetric[i] += (p - back.p) * (1 / its.bulk);
    }
}

class MohrCoulombDruckerPrager : public StiffeningOf<MohrCoulombDruckerPrager> {
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
        for (auto& p : pressure_.parameters()) all.push_back(p);
        for (auto& p : strength_.parameters()) all.push_back(p);
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
        if (closing_.value_or(true)) all.push_back(openingVariable());
        for (auto& variable : strength_.stateVariables()) all.push_back(variable);
        return all;
    }
    static constexpr bool takesHoopRate = true;
    bool yields() const override { return true; }
    NeighbourMean neighbourMean() const override { return strength_.neighbourMean(0, ofStrength()); }
    VolumeRecord volumeRecord() const override { return {1, opens() ? 2 : -1}; }
    std::array<double, 2> moduli() const { return {elasticity_.lambda(), elasticity_.mu()}; }
    // Any Cauchy stress may be given; one beyond yield returns to the surface in the first step.
    void stateFromStress(const double*, double* state) const override {
        std::fill_n(state, ofStrength(), 0.0);
        if (neighbourMean().length > 0) state[neighbourMean().mean] = 0;
    }

    template <int Dim, class Number>
    void respond(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        trialStress(moduli.lambda, moduli.mu, points);
        if (strength_.isUniform()) return finishStress(moduli, OneCone{cone_}, points);
        StrengthRun run(points.count);
        strength_.find(points.count, points.state + ofStrength(), points.state[0], run);
        std::vector<double> sinPhi(points.count), cCosPhi(sinPhi), apex(sinPhi), beta(sinPhi);
        for (int i = 0; i < points.count; ++i) {
            const Cone<double> cone = coneOf(run.cohesion[i], run.frictionAngle[i], run.dilatancyAngle[i]);
            sinPhi[i] = cone.sinPhi;
            cCosPhi[i] = cone.cCosPhi;
            apex[i] = cone.apex;
            beta[i] = cone.beta;
        }
        finishStress(moduli, ConeOfEach{{sinPhi.data(), cCosPhi.data(), apex.data(), beta.data()}}, points);
    }

    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        const bool isUniform =
            strength_.isUniform(); // then no cone is made for each: two sines and a tangent
        StrengthRun run(isUniform ? 0 : points.count);
        if (!isUniform) strength_.find(points.count, points.state + ofStrength(), points.state[0], run);
        for (int i = 0; i < points.count; ++i) {
            const auto [p, J2] = invariants(points, i);
            const Cone<double> cone =
                isUniform ? cone_ : coneOf(run.cohesion[i], run.frictionAngle[i], run.dilatancyAngle[i]);
            const double atPressure = std::max(0.0, cone.cCosPhi - p * cone.sinPhi);
            strength[i] = spareStrength(atPressure, cone.cCosPhi, std::sqrt(J2));
        }
    }

  private:
    bool opens() const { return closing_.value_or(true) && !std::isinf(mostMeanStress()); }
    bool closes(bool hasFbar) const { return opens() && closing_.value_or(hasFbar); }
    int ofStrength() const { return closing_.value_or(true) ? 3 : 2; } // first state variable of the strength

    template <class Cones, class Number, int Dim>
    void finishStress(const Moduli<Number>& moduli, const Cones& cones,
                      const MaterialPoints<Dim>& points) const {
        if (closes(points.hasFbar)) {
            const double cutOff = constants_.tensionCutOff;
            const auto most = [cones, cutOff](int i) {
                return std::min(cones([i](const double* plane) { return plane[i]; }).apex, cutOff);
            };
            const auto bulk = [moduli](int i) { return moduli.at(i).bulk; };
            closeUp(bulk, most, points);
            openUp(bulk, most, points);
        }
        std::isinf(constants_.dilatancyLimit) ? returnToYield<false>(constants_, moduli, cones, points)
                                              : returnToYield<true>(constants_, moduli, cones, points);
    }

    // Highest mean stress of all particles.
    double mostMeanStress() const {
        return std::min(strength_.isUniform() ? cone_.apex : std::numeric_limits<double>::max(),
                        constants_.tensionCutOff);
    }
    Cone<double> coneOf(double cohesion, double frictionAngle, double dilatancyAngle) const {
        return {std::sin(frictionAngle), cohesion * std::cos(frictionAngle),
                frictionAngle > 0 ? cohesion / std::tan(frictionAngle) : infinity, beta(dilatancyAngle)};
    }
    double beta(double dilatancyAngle) const;
    double limitOfDilatancy() const;

    Elasticity elasticity_;
    Strength strength_;
    std::string coneFit_ = "planeStrain";
    double tensionCutOff_ = notGiven, dilatancyLimit_ = notGiven;
    double initialVoidRatio_ = notGiven, criticalVoidRatio_ = notGiven;
    std::optional<bool> closing_; // not given: where there is F-bar
    Constants constants_{};
    Cone<double> cone_{}; // where all particles have one
};

double MohrCoulombDruckerPrager::beta(double dilatancyAngle) const {
    const double s = std::sin(dilatancyAngle);
    if (coneFit_ == "triaxialCompression") return 2 * s / (std::sqrt(3.0) * (3 - s));
    if (coneFit_ == "triaxialExtension") return 2 * s / (std::sqrt(3.0) * (3 + s));
    const double t = std::tan(dilatancyAngle);
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
    requireDensity(who, density);
    elasticity_.finish(who);
    strength_.finish(*this);

    constants_ = {limitOfDilatancy(), orInfinity(tensionCutOff_)};
    if (strength_.isUniform())
        cone_ = coneOf(strength_.cohesion, strength_.frictionAngle, strength_.dilatancyAngle);
    require(std::isnan(tensionCutOff_) || !strength_.isUniform() || tensionCutOff_ <= cone_.apex, who,
            ": tensionCutOff = ", tensionCutOff_,
            " kPa lies beyond the apex of the cone, c cot(phi) = ", cone_.apex,
            " kPa; lower it or leave it out");
}

MPM_REGISTER(Material, MohrCoulombDruckerPrager);

} // namespace
} // namespace mpm
