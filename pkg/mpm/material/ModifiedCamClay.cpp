// SPDX-License-Identifier: GPL-2.0-or-later
// Modified Cam-Clay: elasticity and strength that follow the mean pressure, and a yield surface that hardens and softens
// with the volume.
#include "mpm/material/Material.hpp"
#include "mpm/material/criticalState.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/opening.hpp"
#include "mpm/material/undrained.hpp"

namespace mpm {
namespace {

// Elastic pressure: p = p_s exp(e/c) with c = kappa/v, where e is the elastic volumetric strain (compression
// positive) from the smallest pressure p_s on; below that the stiffness is the one at p_s, and there is no tension.
struct Swelling {
    double smallest, c;

    double pressure(double e) const {
        return e > 0 ? smallest * std::exp(e / c) : std::max(0.0, smallest * (1 + e / c));
    }
    double strain(double p) const {
        return p > smallest ? c * std::log(p / smallest) : c * (p / smallest - 1);
    }
    double energy(double p) const { // int p de
        const double least = std::clamp(p, 0.0, smallest);
        return c * (0.5 * least * least / smallest + std::max(p - smallest, 0.0));
    }
    double stiffness(double p) const { return std::max(p, smallest) / c; } // dp/de
};

// From a trial state beyond yield back to the surface, pressures positive in compression. Unknown are the multiplier
// and the plastic volumetric strain x = multiplier (2 p - pc), with
//     p of the elastic strain e - x,  pc = pc_0 exp(plastic x),  q = q_trial/(1 + 6 mu multiplier/M^2)
struct Return {
    Swelling swelling;
    double e, qTrial, pcBefore, mu, M2; // strain of the trial; kPa; M^2
    double plastic;                     // v/(lambda - kappa)
    double x = 0, p = swelling.pressure(e), pc = pcBefore, shrink = 1;
    double size = std::max(p, swelling.smallest);

    double yield() const { return qTrial * qTrial / M2 + p * (p - pc); } // of the trial
    // Yield function at a multiplier, over size^2; its slope over the multiplier.
    double at(double multiplier, double& slope) {
        double steep = 1; // of x - multiplier (2 p - pc), which rises with x
        for (int n = 0; n < 50; ++n) {
            p = swelling.pressure(e - x);
            pc = pcBefore * std::exp(plastic * x);
            const double left = x - multiplier * (2 * p - pc);
            steep = 1 + multiplier * (2 * swelling.stiffness(p) + plastic * pc);
            const double step = left / steep;
            x -= step;
            if (std::abs(step) <= 1e-15) break;
        }
        shrink = 1 / (1 + 6 * mu * multiplier / M2);
        const double q = qTrial * shrink, perMultiplier = (2 * p - pc) / steep, scale = 1 / (size * size);
        slope = scale * (-12 * mu * q * q * shrink / (M2 * M2) -
                         perMultiplier * ((2 * p - pc) * swelling.stiffness(p) + p * plastic * pc));
        return scale * (q * q / M2 + p * (p - pc));
    }
    // Newton's method within a bracket.
    void solve() {
        double low = 0, high = std::numeric_limits<double>::infinity(), multiplier = 0, slope;
        for (int n = 0; n < 100; ++n) {
            const double f = at(multiplier, slope);
            if (std::abs(f) <= 1e-14) return;
            (f > 0 ? low : high) = multiplier;
            double next = slope < 0 ? multiplier - f / slope : high;
            if (!(next > low && next < high))
                next =
                    std::isinf(high) ? 2 * multiplier + 1 / (mu + swelling.stiffness(p)) : 0.5 * (low + high);
            if (next == multiplier) return;
            multiplier = next;
        }
    }
};

class ModifiedCamClay : public MaterialOf<ModifiedCamClay> {
  public:
    std::string className() const override { return "ModifiedCamClay"; }
    std::string doc() const override {
        return R"(Modified Cam-Clay: an elliptic yield surface that hardens with the plastic volumetric strain.

    f = q^2/M^2 + p (p - pc),  p = -tr(sigma)/3,  q = sqrt(3 J2),  M = 6 sin(phi)/(3 - sin(phi)),  associated flow
    dp/p = v de_v^e/kappa,  dpc/pc = v de_v^p/(lambda - kappa),  v = (1 + e_0) V/V0,  strains positive in compression
    mu = 3 K (1 - 2 nu)/(2 (1 + nu)),  K = v p/kappa

Stress is effective stress (total where there is no pore pressure). pc, the preconsolidation pressure, is given by
preconsolidation (a number, a function of position, a profile or an array), or by overconsolidationRatio from the
stress that a body is given. Elastic pressure is integrated exactly over a step, mu is that of its start; the return
solves for plastic volumetric strain and multiplier (Newton). Below smallestPressure the stiffness stays.
There is no tension: soil that has opened closes before it resists again (in bodies with F-bar). With waterBulk the
soil is undrained: the stress is the total one, and the effective pressure a state variable; the initial stress has no
excess pore pressure. A frictionAngle is that of triaxial compression at the critical state; M does not depend on the
Lode angle.

Source: Roscoe & Burland 1968; Borja & Lee 1990, Comput. Methods Appl. Mech. Eng. 78, 49-72 (return); Wood 1990, Soil
Behaviour and Critical State Soil Mechanics.)";
    }
    std::vector<Parameter> parameters() override {
        return {
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()},
            {"compression", "-", "required: slope lambda of normal compression, e against ln p", &lambda_,
             Range::positive()},
            {"swelling", "-", "required: slope kappa of unloading, below compression", &kappa_,
             Range::positive()},
            {"poisson", "-", "Poisson's ratio", &poisson_, Range::inside(-1, 0.5)},
            criticalFriction(&phi_),
            {"initialVoidRatio", "-", "required: void ratio e_0 of the soil as it is placed", &voidRatio_,
             Range::positive()},
            {"preconsolidation",
             "kPa",
             "preconsolidation pressure pc; or give overconsolidationRatio",
             &pc_,
             Range::positive(),
             {},
             false,
             true},
            {"overconsolidationRatio",
             "-",
             "pc over that of the yield surface through the stress that a body is given; not given: pc is preconsolidation",
             &ratio_,
             {1, std::numeric_limits<double>::infinity(), false, false}},
            leastPressure(&smallest_),
            undrained_.parameter(),
        };
    }
    void finish() override {
        const std::string who = className();
        requireDensity(who, density);
        requireGiven(who, {{lambda_, "compression"},
                           {kappa_, "swelling"},
                           {phi_, "frictionAngle"},
                           {voidRatio_, "initialVoidRatio"}});
        require(kappa_ < lambda_, who, ": swelling = ", kappa_, " is not below compression = ", lambda_,
                "; unloading is stiffer than normal compression");
        const bool byValue = !std::isnan(pc_) || varies("preconsolidation");
        require(byValue != !std::isnan(ratio_), who, ": preconsolidation and overconsolidationRatio ",
                byValue ? "are both given" : "are both missing", "; give one of them");
        M_ = criticalRatio(phi_);
    }
    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all = {
            {"plasticShearStrain", "-", "accumulated plastic shear strain, sum of sqrt(2/3 de:de)"},
            {"plasticVolumetricStrain", "-", "plastic volumetric strain, dilation positive"},
            openingVariable(),
            {"preconsolidation", "kPa", "preconsolidation pressure pc",
             std::isnan(ratio_) ? pc_ : smallest_}};
        undrained_.addState(all);
        return all;
    }
    bool yields() const override { return true; }
    // Of undrained soil F-bar changes the pressure of the water.
    VolumeRecord volumeRecord() const override {
        return undrained_.isGiven() ? VolumeRecord{} : VolumeRecord{1, 2};
    }
    std::array<double, 2> lame() const override {
        const auto drained = lameAt(smallest_, 1 + voidRatio_);
        return {drained[0] + undrained_.bulk, drained[1]};
    }

    // A stress beyond yield takes pc along to its surface.
    void stateFromStress(const double stress[9], double* state) const override {
        const double xx = stress[0], yy = stress[4], zz = stress[8],
                     p = std::max(smallest_, -(xx + yy + zz) / 3);
        const double J2 = ((xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)) / 6 +
                          stress[1] * stress[1] + stress[2] * stress[2] + stress[5] * stress[5];
        const double through = p + 3 * J2 / (M_ * M_ * p);
        state[0] = state[1] = state[2] = 0;
        state[3] = std::isnan(ratio_) ? std::max(state[3], through) : ratio_ * through;
        if (undrained_.isGiven()) state[effective] = -(xx + yy + zz) / 3;
    }

    template <int Dim> void stress(const MaterialPoints<Dim>& points) const {
        std::array<double*, effective> state;
        for (int i = 0; i < points.count; ++i)
            undrained_.withEffective(points, i, effective,
                                     [&] { advance(one(points, i, state), specificVolume(points, i)); });
    }
    template <int Dim> void findStiffness(const MaterialPoints<Dim>& points, double* l, double* mu) const {
        for (int i = 0; i < points.count; ++i) {
            const auto now = lameAt(undrained_.pressure(points, i, effective), specificVolume(points, i));
            l[i] = now[0] + undrained_.bulk;
            mu[i] = now[1];
        }
    }
    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        for (int i = 0; i < points.count; ++i) {
            const double p = undrained_.pressure(points, i, effective);
            strength[i] = M_ * std::sqrt(std::max(0.0, p * (points.state[3][i] - p))) / std::sqrt(3.0);
        }
    }
    template <int Dim> void findStoredEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        for (int i = 0; i < points.count; ++i) {
            const double p = undrained_.pressure(points, i, effective), v = specificVolume(points, i);
            energy[i] = Swelling{smallest_, kappa_ / v}.energy(p) + undrained_.energy(points, i, effective) +
                        0.5 * invariants(points, i).J2 / lameAt(p, v)[1];
        }
    }

  private:
    static constexpr int effective = 4; // place of the effective pressure among the state variables

    std::array<double, 2> lameAt(double p, double v) const {
        const double K = v * std::max(p, smallest_) / kappa_,
                     mu = 1.5 * K * (1 - 2 * poisson_) / (1 + poisson_);
        return {K - 2.0 / 3 * mu, mu};
    }
    template <int Dim> double specificVolume(const MaterialPoints<Dim>& points, int i) const {
        return (1 + voidRatio_) * points.volume[i] / points.initialVolume[i] * std::exp(-points.state[2][i]);
    }
    // Particle i alone.
    template <int Dim>
    static MaterialPoints<Dim> one(const MaterialPoints<Dim>& points, int i,
                                   std::array<double*, effective>& state) {
        MaterialPoints<Dim> its = points;
        its.count = 1;
        for (auto& plane : its.velocityGradient) plane += i;
        for (auto& plane : its.stress) plane += i;
        for (size_t k = 0; k < state.size(); ++k) state[k] = points.state[k] + i;
        its.state = state.data();
        return its;
    }
    template <int Dim> void advance(const MaterialPoints<Dim>& point, double v) const {
        double *const *s = point.stress, *const *state = point.state;
        const auto mean = [&] { return (s[0][0] + s[4][0] + s[8][0]) / 3; };
        const Swelling swelling{smallest_, kappa_ / v};
        const double before = mean(), pBefore = std::max(0.0, -before), mu = lameAt(pBefore, v)[1];
        trialStress(mu / 3, mu,
                    point); // of bulk modulus mu: the mean of the stress tells the change of volume
        double compressed = std::clamp((before - mean()) / mu, -0.5, 0.5);
        const double closed = point.hasFbar ? std::clamp(compressed, 0.0, *state[2]) : 0;
        compressed -= closed;
        Return back{swelling,
                    swelling.strain(pBefore) + compressed,
                    deviator(s, mean()),
                    state[3][0],
                    mu,
                    M_ * M_,
                    v / (lambda_ - kappa_)};
        if (back.yield() > 0) back.solve();
        const double after = back.p, middle = mean();
        for (int c : {0, 1, 2, 4, 5, 8}) {
            if (Dim == 2 && (c == 2 || c == 5)) continue;
            const double spherical = c % 4 == 0 ? middle : 0;
            s[c][0] = back.shrink * (s[c][0] - spherical) - (c % 4 == 0 ? after : 0);
        }
        s[3][0] = s[1][0];
        if (Dim == 3) s[6][0] = s[2][0], s[7][0] = s[5][0];
        state[0][0] += (1 - back.shrink) * back.qTrial / (3 * mu);
        const double gap = std::max(swelling.strain(0) - (back.e - back.x), 0.0);
        state[1][0] += gap - closed - back.x;
        if (point.hasFbar) state[2][0] += gap - closed;
        state[3][0] = std::max(back.pc, smallest_);
    }
    // q = sqrt(3 J2) from the upper triangle.
    static double deviator(double* const* s, double mean) {
        double square = 0;
        for (int k = 0; k < 3; ++k) square += 0.5 * (s[4 * k][0] - mean) * (s[4 * k][0] - mean);
        for (int c : {1, 2, 5}) square += s[c][0] * s[c][0];
        return std::sqrt(3 * square);
    }

    double lambda_ = notGiven, kappa_ = notGiven, poisson_ = 0.3, phi_ = notGiven, voidRatio_ = notGiven;
    double pc_ = notGiven, ratio_ = notGiven, smallest_ = 1;
    double M_ = 0;
    Undrained undrained_;
};

MPM_REGISTER(Material, ModifiedCamClay);

} // namespace
} // namespace mpm
