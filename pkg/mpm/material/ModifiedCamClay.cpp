// SPDX-License-Identifier: GPL-2.0-or-later
// Modified Cam-Clay: elasticity and strength that follow the mean pressure, and a yield surface that hardens and softens
// with the volume.
#include "mpm/material/Material.hpp"
#include "mpm/material/criticalState.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/logarithm.hpp"
#include "mpm/material/opening.hpp"
#include "mpm/material/undrained.hpp"

namespace mpm {
namespace {

// Elastic pressure: dp/de = p/c with c = kappa/v, where e is the elastic volumetric strain (compression positive), down to
// the smallest pressure p_s; below that the stiffness is the one at p_s, and there is no tension.
struct Swelling {
    double smallest, c;

    // Pressure by a strain e from another pressure on.
    double pressure(double before, double e) const {
        const double p = before * std::exp(e / c);
        if (before > smallest && p > smallest) return p;
        e += strain(before);
        return e > 0 ? smallest * std::exp(e / c) : std::max(0.0, smallest * (1 + e / c));
    }
    double strain(double p) const { // from p_s on
        return p > smallest ? c * std::log(p / smallest) : c * (p / smallest - 1);
    }
    double energy(double p) const { // int p de
        const double least = std::clamp(p, 0.0, smallest);
        return c * (0.5 * least * least / smallest + std::max(p - smallest, 0.0));
    }
    double stiffness(double p) const { return p > 0 ? std::max(p, smallest) / c : 0; } // dp/de
};

// From a trial state beyond yield back to the surface, pressures positive in compression. Unknown are the multiplier
// and the plastic volumetric strain x = multiplier (2 p - pc), with
//     p of the elastic strain e - x,  pc = pc_0 exp(plastic x),  q = q_trial/(1 + 6 mu multiplier/M^2)
// solveAll() does the usual ones side by side, solve() the others.
struct Return {
    Swelling swelling;
    double pBefore, compressed, qTrial, pcBefore, mu, M2; // kPa; strain; kPa; M^2
    double plastic;                                       // v/(lambda - kappa)
    double pTrial = swelling.pressure(pBefore, compressed);
    double x = 0, p = pTrial, pc = pcBefore, shrink = 1;
    bool isSolved = qTrial * qTrial / M2 + p * (p - pc) <= 0;

    double size() const { return std::max(pTrial, swelling.smallest); }
    // Newton's method for the multiplier within a bracket, and for x at each multiplier.
    void solve() {
        double low = 0, high = std::numeric_limits<double>::infinity(), multiplier = 0, slope;
        x = 0;
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

  private:
    // Yield function at a multiplier, over size^2; its slope over the multiplier.
    double at(double multiplier, double& slope) {
        double steep = 1; // of x - multiplier (2 p - pc), which rises with x
        for (int n = 0; n < 50; ++n) {
            p = swelling.pressure(pBefore, compressed - x);
            pc = pcBefore * std::exp(plastic * x);
            const double left = x - multiplier * (2 * p - pc);
            steep = 1 + multiplier * (2 * swelling.stiffness(p) + plastic * pc);
            const double step = left / steep;
            x -= step;
            if (std::abs(step) <= 1e-15) break;
        }
        shrink = 1 / (1 + 6 * mu * multiplier / M2);
        const double q = qTrial * shrink, perMultiplier = (2 * p - pc) / steep, scale = 1 / (size() * size());
        slope = scale * (-12 * mu * q * q * shrink / (M2 * M2) -
                         perMultiplier * ((2 * p - pc) * swelling.stiffness(p) + p * plastic * pc));
        return scale * (q * q / M2 + p * (p - pc));
    }
};

// Newton's method for x and multiplier at once, with lengths over pTrial and only while p > p_s: then p = pTrial exp(-x/c),
// and the exponents are small in a usual step.
class Returns {
  public:
    // Filled up to whole vectors, so that a particle is treated alike at each place of a run.
    explicit Returns(int count) : count_((count + 15) / 16 * 16), planes_(all, std::vector<double>(count_)) {}

    void set(int i, const Return& one) {
        const double perM = one.qTrial / one.pTrial;
        const double values[] = {perM * perM / one.M2, one.pcBefore / one.pTrial, 1 / one.swelling.c,
                                 one.plastic, 6 * one.mu / (one.M2 * one.pTrial)};
        for (int k = 0; k < given; ++k) planes_[k][i] = values[k];
    }
    void solve() {
        const double *square = planes_[0].data(), *pcs = planes_[1].data(), *elastic = planes_[2].data(),
                     *plastic = planes_[3].data(), *softer = planes_[4].data();
        double *xs = planes_[5].data(), *ps = planes_[6].data(), *pcAfter = planes_[7].data(),
               *shrinks = planes_[8].data(), *errors = planes_[9].data();
#pragma omp simd
        for (int i = 0; i < count_; ++i) {
            double x = 0, multiplier = 0, p = 1, pc = pcs[i], error = 0;
            for (int n = 0; n < rounds; ++n) {
                const double shrink = 1 / (1 + softer[i] * multiplier), q2 = square[i] * shrink * shrink;
                const double f = q2 + p * (p - pc), wet = 2 * p - pc, left = x - multiplier * wet;
                error = std::max(std::abs(f), std::abs(left));
                const double K = elastic[i] * p, hardening = plastic[i] * pc;
                const double steep = 1 + multiplier * (2 * K + hardening);
                const double byMultiplier = -2 * softer[i] * q2 * shrink,
                             byStrain = -(K * wet + p * hardening);
                const double over = 1 / (steep * byMultiplier + wet * byStrain);
                x -= (byMultiplier * left + wet * f) * over;
                multiplier -= (steep * f - byStrain * left) * over;
                p = smallExponential(-elastic[i] * x);
                pc = pcs[i] * smallExponential(plastic[i] * x);
            }
            xs[i] = x;
            ps[i] = p;
            pcAfter[i] = pc;
            shrinks[i] = 1 / (1 + softer[i] * multiplier);
            errors[i] = error;
        }
    }
    // Whether the solution was found, and not another root; `one` takes it.
    bool give(int i, Return& one) const {
        const double least = one.swelling.smallest, shrink = planes_[8][i];
        const double x = planes_[5][i], p = one.pTrial * planes_[6][i];
        const bool isSmall = std::abs(x) * std::max(planes_[2][i], planes_[3][i]) <= exponentialLimit;
        const bool isFlow = shrink > 0 && shrink <= 1; // along the deviator, not against it
        if (!(planes_[9][i] <= 1e-9 && isSmall && isFlow && std::min(p, one.pTrial) > least)) return false;
        one.x = x;
        one.p = p;
        one.pc = one.pTrial * planes_[7][i];
        one.shrink = shrink;
        return true;
    }

  private:
    // With an error of 1e-9 before the last round, it leaves round-off.
    static constexpr int given = 5, all = 10, rounds = 5;
    int count_;
    std::vector<std::vector<double>> planes_;
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
        const int count = points.count;
        std::vector<double> excess(count), mu(count), lambda(count), mean(count);
        for (int i = 0; i < count; ++i) {
            excess[i] = undrained_.takeOut(points, i, effective);
            mean[i] = invariants(points, i).mean;
            mu[i] = lameAt(-mean[i], specificVolume(points, i))[1];
            lambda[i] = mu[i] / 3; // of bulk modulus mu: the mean of the stress tells the change of volume
        }
        trialStress(lambda.data(), mu.data(), points);
        std::vector<Return> returns;
        Returns usual(count);
        for (int i = 0; i < count; ++i) {
            returns.push_back(returnOf(points, i, mean[i], mu[i]));
            usual.set(i, returns.back());
        }
        usual.solve();
        for (int i = 0; i < count; ++i) {
            Return& back = returns[i];
            if (!back.isSolved && !usual.give(i, back)) back.solve();
            take(points, i, back);
            undrained_.putBack(points, i, effective, excess[i]);
        }
    }
    template <int Dim> void findStiffness(const MaterialPoints<Dim>& points, double* l, double* mu) const {
        fillStiffness(points, l, mu, [&](int i) {
            const auto soil = lameAt(undrained_.pressure(points, i, effective), specificVolume(points, i));
            return std::array<double, 2>{soil[0] + undrained_.bulk, soil[1]};
        });
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
        return lameOf(v * std::max(p, smallest_) / kappa_, poisson_);
    }
    template <int Dim> double specificVolume(const MaterialPoints<Dim>& points, int i) const {
        return (1 + voidRatio_) * points.volume[i] / points.initialVolume[i] * std::exp(-points.state[2][i]);
    }
    // From the trial stress; closes what had opened.
    template <int Dim>
    Return returnOf(const MaterialPoints<Dim>& points, int i, double meanBefore, double mu) const {
        const auto [mean, J2] = invariants(points, i);
        const double v = specificVolume(points, i), change = std::clamp((meanBefore - mean) / mu, -0.5, 0.5);
        const double closed = points.hasFbar ? std::clamp(change, 0.0, points.state[2][i]) : 0;
        points.state[2][i] -= closed;
        points.state[1][i] -= closed;
        return {Swelling{smallest_, kappa_ / v},
                std::max(0.0, -meanBefore),
                change - closed,
                std::sqrt(3 * J2),
                points.state[3][i],
                mu,
                M_ * M_,
                v / (lambda_ - kappa_)};
    }
    // Stress and state at the end of the step.
    template <int Dim> void take(const MaterialPoints<Dim>& points, int i, const Return& back) const {
        double *const *s = points.stress, *const *state = points.state;
        const double mean = invariants(points, i).mean;
        for (int c : {0, 4, 8}) s[c][i] = back.shrink * (s[c][i] - mean) - back.p;
        s[1][i] = s[3][i] = back.shrink * s[1][i];
        if (Dim == 3) {
            s[2][i] = s[6][i] = back.shrink * s[2][i];
            s[5][i] = s[7][i] = back.shrink * s[5][i];
        }
        const double gap = back.p > 0 ? 0
                                      : back.swelling.strain(0) - back.swelling.strain(back.pBefore) -
                                            back.compressed + back.x;
        state[0][i] += (1 - back.shrink) * back.qTrial / (3 * back.mu);
        state[1][i] += gap - back.x;
        if (points.hasFbar) state[2][i] += gap;
        state[3][i] = std::max(back.pc, smallest_);
    }

    double lambda_ = notGiven, kappa_ = notGiven, poisson_ = 0.3, phi_ = notGiven, voidRatio_ = notGiven;
    double pc_ = notGiven, ratio_ = notGiven, smallest_ = 1;
    double M_ = 0;
    Undrained undrained_;
};

MPM_REGISTER(Material, ModifiedCamClay);

} // namespace
} // namespace mpm
