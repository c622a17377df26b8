// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic-plastic c-phi soil: the Mohr-Coulomb surface with its edges and apex, and a potential of the same shape.
#include "mpm/material/Strength.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/opening.hpp"
#include "mpm/material/principal.hpp"
#include "mpm/material/required.hpp"
#include "mpm/material/spareStrength.hpp"
#include "mpm/material/stiffening.hpp"

namespace mpm {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

// Of one particle. Plane of the major and the minor stress: f = s1 (1 + sin phi) - s3 (1 - sin phi) - 2 c cos(phi), and
// the potential alike with psi.
struct Surface {
    double lambda, mu, sinPhi, sinPsi, twiceCCosPhi, apex;

    double yield(double major, double minor) const {
        return (1 + sinPhi) * major - (1 - sinPhi) * minor - twiceCCosPhi;
    }
    // Change of f of one plane by a unit of flow on another, whose directions have the inner product `both`.
    double slope(double both) const { return 4 * lambda * sinPhi * sinPsi + 2 * mu * both; }

    // From a trial stress beyond the surface back along D : dg/ds. To a plane, else to the edge where two meet (s1 = s2
    // or s2 = s3), else to the apex. Inline always: which of its products are fused, hence the last digit, hangs on it.
    MPM_INLINE void returnTo(double s[3]) const {
        const double trial[] = {s[0], s[1], s[2]}, f = yield(s[0], s[2]);
        flow(s, f / slope(2 * (1 + sinPhi * sinPsi)), 0, 2);
        if (s[0] >= s[1] && s[1] >= s[2]) return;
        const bool isMajor = s[1] > s[0]; // the edge s1 = s2
        std::copy(trial, trial + 3, s);
        const double other = isMajor ? yield(s[1], s[2]) : yield(s[0], s[1]);
        const double own = slope(2 * (1 + sinPhi * sinPsi)),
                     both = slope(isMajor ? (1 - sinPhi) * (1 - sinPsi) : (1 + sinPhi) * (1 + sinPsi));
        const double determinant = own * own - both * both;
        flow(s, (own * f - both * other) / determinant, 0, 2);
        flow(s, (own * other - both * f) / determinant, isMajor ? 1 : 0, isMajor ? 2 : 1);
        const double mean = (s[0] + s[1] + s[2]) / 3;
        if (mean > apex || s[0] < s[2])
            std::fill_n(s, 3, apex);
        else if (isMajor)
            s[0] = s[1] = 0.5 * (s[0] + s[1]); // equal but for round-off
        else
            s[1] = s[2] = 0.5 * (s[1] + s[2]);
    }

  private:
    void flow(double s[3], double multiplier, int major, int minor) const {
        for (int k = 0; k < 3; ++k) s[k] -= multiplier * 2 * lambda * sinPsi;
        s[major] -= multiplier * 2 * mu * (1 + sinPsi);
        s[minor] += multiplier * 2 * mu * (1 - sinPsi);
    }
};

class MohrCoulomb : public StiffeningOf<MohrCoulomb> {
  public:
    std::string className() const override { return "MohrCoulomb"; }
    std::string doc() const override {
        return R"(Elastic-plastic soil: Mohr-Coulomb yield surface and a plastic potential of the same shape.

    f = s1 - s3 + (s1 + s3) sin(phi) - 2 c cos(phi)
    g = s1 - s3 + (s1 + s3) sin(psi)
    s1 >= s2 >= s3 principal Cauchy stresses, tension positive
    x = x_r + (x_0 - x_r) exp(-3 xi/xi_95),  x = c, phi, psi,  xi the plastic shear strain, or its mean (softeningLength)

Flow is associated where psi = phi; the law is Tresca's where phi = 0. Trial stress and finite rotation are those
of MohrCoulombDruckerPrager, and so is the opening of soil in bodies with F-bar (`closing`). The return goes to a
plane, to an edge or to the apex in closed form; with tensileStrength no principal stress is above it (Rankine).
Both laws give the same strength in plane strain and in triaxial states; between them MohrCoulombDruckerPrager
dissipates less (0.928 for phi = 0 at a Lode angle of 15 degrees), and circular loads are 5 % lower.

Source: Clausen, Damkilde & Andersen 2006, Comput. Struct. 84, 2123-2134 (return to planes, edges and apex);
softening: Einav & Randolph 2005, Int. J. Numer. Methods Eng. 63, 1991-2016.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& p : elasticity_.parameters()) all.push_back(p);
        for (auto& p : pressure_.parameters()) all.push_back(p);
        for (auto& p : strength_.parameters()) all.push_back(p);
        all.push_back({"tensileStrength", "kPa", "highest principal stress; not given: off",
                       &tensileStrength_, Range::notNegative()});
        all.push_back(
            {"closing", "",
             "whether soil that has opened, at the apex or at tensileStrength, closes before it bears pressure "
             "again; not given: in bodies with F-bar",
             &closing_});
        return all;
    }
    void finish() override {
        requireDensity(className(), density);
        elasticity_.finish(className());
        strength_.finish(*this);
    }

    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all{
            {"plasticShearStrain", "-", "accumulated plastic shear strain, sum of sqrt(2/3 de:de)"},
            {"plasticVolumetricStrain", "-", "plastic volumetric strain, dilation positive"},
            openingVariable()};
        for (auto& variable : strength_.stateVariables()) all.push_back(variable);
        return all;
    }
    static constexpr bool takesHoopRate = true;
    bool yields() const override { return true; }
    NeighbourMean neighbourMean() const override { return strength_.neighbourMean(0, ofStrength); }
    VolumeRecord volumeRecord() const override { return {1, opens() ? 2 : -1}; }
    std::array<double, 2> moduli() const { return {elasticity_.lambda(), elasticity_.mu()}; }
    // Any Cauchy stress may be given; one beyond yield returns to the surface in the first step.
    void stateFromStress(const double*, double* state) const override {
        std::fill_n(state, ofStrength, 0.0);
        if (neighbourMean().length > 0) state[neighbourMean().mean] = 0;
    }

    template <int Dim, class Number>
    void respond(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        trialStress(moduli.lambda, moduli.mu, points);
        const std::vector<Surface> surfaces = surfacesOf(points, moduli);
        if (opens() && closing_.value_or(points.hasFbar)) {
            const auto most = [&](int i) { return std::min(surfaces[i].apex, cutOff()); };
            const auto bulk = [=](int i) { return moduli.at(i).bulk; };
            closeUp(bulk, most, points);
            openUp(bulk, most, points);
        }
        for (int i = 0; i < points.count; ++i) returnToYield(points, i, surfaces[i]);
    }
    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        const std::vector<Surface> surfaces = surfacesOf(points, constants());
        for (int i = 0; i < points.count; ++i) {
            const auto [p, J2] = invariants(points, i);
            const double cohesion = 0.5 * surfaces[i].twiceCCosPhi;
            strength[i] =
                spareStrength(std::max(0.0, cohesion - p * surfaces[i].sinPhi), cohesion, std::sqrt(J2));
        }
    }

  private:
    static constexpr int ofStrength = 3; // first state variable of the strength

    bool opens() const {
        const bool isBounded =
            !strength_.isUniform() || strength_.frictionAngle > 0 || !std::isnan(tensileStrength_);
        return closing_.value_or(true) && isBounded;
    }
    double cutOff() const { return std::isnan(tensileStrength_) ? unbounded : tensileStrength_; }

    template <int Dim, class Number>
    std::vector<Surface> surfacesOf(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        std::vector<Surface> all;
        const auto add = [&](int count, double c, double phi, double psi) {
            all.insert(all.end(), count,
                       {0, 0, std::sin(phi), std::sin(psi), 2 * c * std::cos(phi),
                        phi > 0 ? c / std::tan(phi) : unbounded});
        };
        if (strength_.isUniform())
            add(points.count, strength_.cohesion, strength_.frictionAngle, strength_.dilatancyAngle);
        else {
            StrengthRun run(points.count);
            strength_.find(points.count, points.state + ofStrength, points.state[0], run);
            for (int i = 0; i < points.count; ++i)
                add(1, run.cohesion[i], run.frictionAngle[i], run.dilatancyAngle[i]);
        }
        for (int i = 0; i < points.count; ++i) {
            all[i].lambda = moduli.at(i).lambda;
            all[i].mu = moduli.at(i).mu;
        }
        return all;
    }

    template <int Dim>
    void returnToYield(const MaterialPoints<Dim>& points, int i, const Surface& surface) const {
        PrincipalStress<Dim> principal(points, i);
        double* s = principal.value;
        const double trial[] = {s[0], s[1], s[2]};
        if (surface.yield(s[0], s[2]) <= 0 && s[0] <= cutOff()) return mirror(points, i);
        if (surface.yield(s[0], s[2]) > 0) surface.returnTo(s);
        const double before[] = {s[0], s[1], s[2]};
        for (int k = 0; k < 3; ++k) s[k] = std::min(s[k], cutOff());
        if (surface.lambda < 0 && s[0] < before[0]) flowOfRankine(surface, before, s);
        principal.write();
        double lost[3], mean = 0, square = 0;
        for (int k = 0; k < 3; ++k) mean += (lost[k] = trial[k] - s[k]) / 3;
        for (int k = 0; k < 3; ++k) square += (lost[k] - mean) * (lost[k] - mean);
        points.state[0][i] += std::sqrt(2.0 / 3 * square) / (2 * surface.mu);
        points.state[1][i] += mean / (surface.lambda + 2.0 / 3.0 * surface.mu);
    }

    // The cut alone strains the other axes, too, by minus Poisson's ratio. Where that is negative, as with
    // pressureExponent, that is against pressure and would make energy: there the strain is along what is cut alone.
    void flowOfRankine(const Surface& surface, const double before[3], double s[3]) const {
        for (int cut = 1; cut <= 3; ++cut) {
            double excess = 0;
            for (int k = 0; k < cut; ++k) excess += before[k] - cutOff();
            const double volume = excess / (2 * surface.mu + cut * surface.lambda); // plastic strain
            for (int k = 0; k < 3; ++k) s[k] = k < cut ? cutOff() : before[k] - surface.lambda * volume;
            if (cut == 3 || s[cut] <= cutOff()) return;
        }
    }

    Elasticity elasticity_;
    Strength strength_;
    double tensileStrength_ = notGiven;
    std::optional<bool> closing_; // not given: where there is F-bar
};

MPM_REGISTER(Material, MohrCoulomb);

} // namespace
} // namespace mpm
