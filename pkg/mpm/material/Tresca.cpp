// SPDX-License-Identifier: GPL-2.0-or-later
// Undrained clay: Tresca's surface with associated flow, a strength of each particle that falls as the clay is remoulded
// and rises with the rate of shear.
#include "mpm/material/Strength.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/principal.hpp"
#include "mpm/material/required.hpp"
#include "mpm/material/stiffening.hpp"

namespace mpm {
namespace {

// Largest shear strain rate d1 - d3, 1/s.
inline double shearRate(const MaterialPoints<2>& points, int i) {
    auto L = points.velocityGradient;
    const double mean = 0.5 * (L[0][i] + L[3][i]), half = 0.5 * (L[0][i] - L[3][i]),
                 shear = 0.5 * (L[1][i] + L[2][i]), radius = std::sqrt(half * half + shear * shear),
                 third = points.hoopRate ? points.hoopRate[i] : 0;
    return std::max(mean + radius, third) - std::min(mean - radius, third);
}
inline double shearRate(const MaterialPoints<3>& points, int i) {
    Symmetric D = 0.5 * plusTransposed(gather(points.velocityGradient, i));
    D = plusSpherical(D, -(D.xx + D.yy + D.zz) / 3);
    const double J2 = halfSquare(D), q = std::sqrt(J2);
    const Lode lode = lodeOf(D, J2, q);
    return 2 * q * (lode.cosine - lode.correction);
}

class Tresca : public StiffeningOf<Tresca> {
  public:
    std::string className() const override { return "Tresca"; }
    std::string doc() const override {
        return R"(Undrained clay: Tresca's yield surface, associated flow, softening and rate dependence.

    f = s1 - s3 - 2 su
    su = su_0 (d + (1 - d) exp(-3 xi/xi_95)) (1 + m log10(max(rate, rate_ref)/rate_ref))

su_0 is the undrainedStrength of a particle as it was placed: a number, a function of position, a profile or an
array. d is the remouldedRatio (one over the sensitivity), xi the plasticShearStrain, sum of de1 - de3 (with
softeningLength a mean over neighbours); m the rateFactor for each factor of ten of the rate of shear d1 - d3.
Stress is total, and so is the pressure of pressureExponent; the volume changes elastically (give poisson = 0.49). With
rigidity in place of young, mu = rigidity su_0 of each particle. The return to the hexagon is exact, edges included.

Source: Einav & Randolph 2005, Int. J. Numer. Methods Eng. 63, 1991-2016; Zhou & Randolph 2009, Int. J. Geomech. 9,
173-182.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters()) all.push_back(p);
        all.push_back({"rigidity", "-",
                       "shear modulus over undrainedStrength, together with poisson in place of young",
                       &rigidity_, Range::positive()});
        for (auto& p : pressure_.parameters()) all.push_back(p);
        all.push_back({"undrainedStrength",
                       "kPa",
                       "required: undrained shear strength su_0 at the reference rate",
                       &strength_,
                       Range::positive(),
                       {},
                       false,
                       true});
        all.push_back(
            {"remouldedRatio",
             "-",
             "strength of fully remoulded clay over undrainedStrength, together with softeningStrain",
             &remouldedRatio_,
             {0, 1, true, false}});
        for (auto& p : softening_.parameters()) all.push_back(p);
        all.push_back({"rateFactor", "-", "gain of strength for each factor of ten of the rate of shear",
                       &rateFactor_, Range::notNegative()});
        all.push_back({"referenceRate", "1/s",
                       "rate of shear up to which su is undrainedStrength, with rateFactor", &referenceRate_,
                       Range::positive()});
        return all;
    }
    void finish() override {
        const std::string who = className();
        requireDensity(who, density);
        finishElasticity(who);
        require(
            !std::isnan(strength_) || varies("undrainedStrength"), who,
            ": undrainedStrength is required; give su in kPa, a number, a function of position or a profile");
        require(softening_.isGiven() == !std::isnan(remouldedRatio_), who, ": ",
                softening_.isGiven() ? "softeningStrain" : "remouldedRatio", " is given without ",
                softening_.isGiven() ? "remouldedRatio" : "softeningStrain", "; give both");
        softening_.check(who);
        require((rateFactor_ > 0) == !std::isnan(referenceRate_), who, ": rateFactor = ", rateFactor_,
                " and referenceRate belong together; give both (1/s), or none");
    }
    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all{
            {"plasticShearStrain", "-", "accumulated plastic shear strain, sum of de1 - de3"},
            {"undrainedStrength", "kPa", "undrained shear strength of the clay as it was placed", strength_}};
        for (auto& variable : softening_.stateVariables()) all.push_back(variable);
        return all;
    }
    NeighbourMean neighbourMean() const override { return softening_.neighbourMean(0, 2); }
    static constexpr bool takesHoopRate = true;
    bool yields() const override { return true; }
    // Of varying strength without a particle: no stiffness.
    std::array<double, 2> moduli() const { return moduliAt(std::isnan(strength_) ? 0 : strength_); }
    // Any Cauchy stress may be given; one beyond yield returns to the surface in the first step.
    void stateFromStress(const double*, double* state) const override {
        state[0] = 0;
        if (neighbourMean().length > 0) state[2] = 0;
    }

    template <int Dim, class Number>
    void respond(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        if (!isRigid()) return respondWith(points, moduli);
        std::vector<double> lambda(points.count), mu(points.count);
        findStiffness(points, lambda.data(), mu.data());
        respondWith(points, Moduli<const double*>{lambda.data(), mu.data(), nullptr});
    }
    template <int Dim>
    void findStiffness(const MaterialPoints<Dim>& points, double* lambda, double* mu) const {
        if (!isRigid()) return StiffeningOf::findStiffness(points, lambda, mu);
        for (int i = 0; i < points.count; ++i) {
            const auto its = moduliAt(points.state[1][i]);
            lambda[i] = its[0];
            mu[i] = its[1];
        }
    }
    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        for (int i = 0; i < points.count; ++i) strength[i] = strengthOf(points, i, 0);
    }

  private:
    bool isRigid() const { return !std::isnan(rigidity_); }
    template <int Dim, class Number>
    void respondWith(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        trialStress(moduli.lambda, moduli.mu, points);
        for (int i = 0; i < points.count; ++i) {
            PrincipalStress<Dim> principal(points, i);
            double* s = principal.value;
            const double su = strengthOf(points, i, rateFactor_ > 0 ? shearRate(points, i) : 0),
                         excess = s[0] - s[2] - 2 * su;
            if (excess <= 0) {
                mirror(points, i);
                continue;
            }
            // Half sums of major and minor deviator from -su/3 to su/3 lie on a plane of the hexagon, others beyond an
            // edge.
            const double p = (s[0] + s[1] + s[2]) / 3,
                         middle = std::clamp(0.5 * (s[0] + s[2]) - p, -su / 3, su / 3);
            s[0] = p + middle + su;
            s[1] = p - 2 * middle;
            s[2] = p + middle - su;
            principal.write();
            points.state[0][i] += excess / (2 * modulus(OneNumber{i}, moduli.mu));
        }
    }
    void finishElasticity(const std::string& who) {
        if (!isRigid()) return elasticity_.finish(who);
        require(!pressure_.isGiven(), who, ": rigidity = ", rigidity_,
                " and pressureExponent = ", pressure_.exponent,
                " are given together; the stiffness follows the strength or the pressure");
        require(elasticity_.lame.empty() && std::isnan(elasticity_.young), who, ": rigidity = ", rigidity_,
                " is given with ", elasticity_.lame.empty() ? "young" : "lame", "; give one of them");
        require(!std::isnan(elasticity_.poisson), who, ": rigidity = ", rigidity_,
                " is given without poisson; give both, e.g. poisson = 0.49");
    }
    // Of particles with the strength su_0.
    std::array<double, 2> moduliAt(double strength) const {
        if (!isRigid()) return {elasticity_.lambda(), elasticity_.mu()};
        const double mu = rigidity_ * strength, nu = elasticity_.poisson;
        return {2 * mu * nu / (1 - 2 * nu), mu};
    }
    template <int Dim> double strengthOf(const MaterialPoints<Dim>& points, int i, double rate) const {
        double su = points.state[1][i];
        if (softening_.isGiven()) {
            const double own = softening_.hasState() ? points.state[2][i] : 0;
            su *= remouldedRatio_ + (1 - remouldedRatio_) * softening_.left(points.state[0][i], own);
        }
        if (rate > referenceRate_) su *= 1 + rateFactor_ * std::log10(rate / referenceRate_);
        return su;
    }

    Elasticity elasticity_;
    double rigidity_ = notGiven, strength_ = notGiven, remouldedRatio_ = notGiven, rateFactor_ = 0,
           referenceRate_ = notGiven;
    Softening softening_;
};

MPM_REGISTER(Material, Tresca);

} // namespace
} // namespace mpm
