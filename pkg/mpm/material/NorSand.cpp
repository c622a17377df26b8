// SPDX-License-Identifier: GPL-2.0-or-later
// Sand whose strength and dilatancy follow its density: critical states and a state parameter.
#include "mpm/material/Material.hpp"
#include "mpm/material/criticalState.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/logarithm.hpp"
#include "mpm/material/opening.hpp"
#include "mpm/material/pressureStiffness.hpp"

namespace mpm {
namespace {

// From a trial state back to the yield surface q = M p (1 - u), u = ln(p/pi), pressures positive in compression. Unknown
// is the plastic shear strain g of the step:
//     q = q_trial - 3 mu g,  p of the elastic strain e - g M u,  ln(pi/pi_0) = h g e^u (limit e^u - 1)
// with the dilatancy M u and the hardening towards pi/p = limit. SandReturns does the usual ones side by side, solve() the
// others: for a g, u is found by Newton's method within a bracket.
struct SandReturn {
    PressureStiffness elastic;
    double e, qTrial, pi0, mu, M, h, limit;
    double pTrial = elastic.pressure(e), p = pTrial, u = std::log(std::max(p, least()) / pi0), g = 0;

    bool parts() const { return pTrial <= least(); } // the grains
    bool yields() const { return !parts() && qTrial > M * pTrial * (1 - std::log(pTrial / pi0)); }
    double least() const { return 1e-6 * elastic.smallest; }
    double q() const { return std::max(qTrial - 3 * mu * g, 0.0); }
    double pi() const { return p * std::exp(-u); }
    // q less what is borne, kPa; falls with g.
    double excess(double multiplier) {
        g = multiplier;
        double low = -std::numeric_limits<double>::infinity(), high = -low;
        for (int n = 0; n < 60; ++n) {
            const double pressure = std::max(elastic.pressure(e - g * M * u), least()), grown = std::exp(u);
            const double stiffness = pressure > least() ? elastic.stiffness(pressure) : 0;
            const double left =
                std::log(pi0 / pressure) + u + h * g * grown * (limit * grown - 1); // rises with u
            const double slope = 1 + h * g * grown * (2 * limit * grown - 1) + g * M * stiffness / pressure;
            const double step = std::clamp(left / std::max(slope, 0.2), -0.5, 0.5);
            (left > 0 ? high : low) = u;
            u -= step;
            if (std::abs(step) <= 1e-14) break;
            if (!(u > low && u < high)) u = 0.5 * (low + high);
        }
        p = std::max(elastic.pressure(e - g * M * u), least());
        return q() - M * p * (1 - u);
    }
    // Secants within a bracket (Anderson & Bjorck 1973).
    void solve() {
        double low = 0, fLow = excess(0), high = qTrial / (3 * mu) + 1e-9, fHigh = excess(high);
        const double scale = 1e-14 * std::max(p, elastic.smallest);
        for (int n = 0; fHigh > 0 && n < 40; ++n) low = high, fLow = fHigh, fHigh = excess(high *= 2);
        for (int n = 0; n < 100 && high - low > 1e-16 * high; ++n) {
            double next = (low * fHigh - high * fLow) / (fHigh - fLow);
            if (!(next > low && next < high)) next = 0.5 * (low + high);
            const double f = excess(next);
            if (std::abs(f) <= scale) return;
            if (f > 0) {
                const double factor = 1 - f / fLow;
                if (n > 0) fHigh *= factor > 0 ? factor : 0.5;
                low = next, fLow = f;
            } else {
                const double factor = 1 - f / fHigh;
                if (n > 0) fLow *= factor > 0 ? factor : 0.5;
                high = next, fHigh = f;
            }
        }
    }
};

// Newton's method for g and u at once, with lengths over the trial pressure P and only while p is above the smallest
// pressure: then ln(p/P) = b ln(1 - a g M u), and the exponents are small in a usual step.
class SandReturns {
  public:
    // Filled up to whole vectors, so that a particle is treated alike at each place of a run.
    explicit SandReturns(int count)
        : count_((count + 15) / 16 * 16), planes_(all, std::vector<double>(count_)) {}

    void set(int i, const SandReturn& one) {
        const double P = one.pTrial, power = 1 - one.elastic.power;
        const double values[] = {
            one.qTrial / P, 3 * one.mu / P, one.M,       one.h,
            one.limit,      one.u,          P / one.pi0, power * one.elastic.stiffness(P) / P,
            1 / power};
        for (int k = 0; k < given; ++k) planes_[k][i] = values[k];
    }
    void solve() {
        const double *qs = planes_[0].data(), *softer = planes_[1].data(), *Ms = planes_[2].data(),
                     *hs = planes_[3].data(), *limits = planes_[4].data(), *starts = planes_[5].data(),
                     *ratios = planes_[6].data(), *as = planes_[7].data(), *bs = planes_[8].data();
        double *gs = planes_[9].data(), *us = planes_[10].data(), *ps = planes_[11].data(),
               *errors = planes_[12].data();
#pragma omp simd
        for (int i = 0; i < count_; ++i) {
            const double M = Ms[i], h = hs[i], limit = limits[i], start = starts[i];
            double g = 0, u = start, y = 0, p = 1, error = 0; // y = ln p
            for (int n = 0; n < rounds; ++n) {
                const double grown = ratios[i] * smallExponential(u - start), beyond = limit * grown - 1;
                const double hardening = u - start - y + h * g * grown * beyond;
                const double yield = qs[i] - softer[i] * g - M * p * (1 - u);
                error = std::max(std::abs(hardening), std::abs(yield));
                const double steep = as[i] * bs[i] * M / (1 - as[i] * g * M * u),
                             own = M * p * (1 - u) * steep;
                const double hardeningByG = steep * u + h * grown * beyond,
                             hardeningByU = 1 + steep * g + h * g * grown * (beyond + limit * grown);
                const double yieldByG = own * u - softer[i], yieldByU = M * p + own * g;
                const double over = 1 / (hardeningByG * yieldByU - hardeningByU * yieldByG);
                g -= (yieldByU * hardening - hardeningByU * yield) * over;
                u -= (hardeningByG * yield - yieldByG * hardening) * over;
                y = bs[i] * logOnePlus(-as[i] * g * M * u);
                p = smallExponential(y);
            }
            gs[i] = g;
            us[i] = u;
            ps[i] = p;
            errors[i] = error;
        }
    }
    // Whether the solution was found; `one` takes it.
    bool give(int i, SandReturn& one) const {
        const double g = planes_[9][i], u = planes_[10][i], p = one.pTrial * planes_[11][i];
        const bool isSmall = std::abs(u - planes_[5][i]) <= exponentialLimit &&
                             std::abs(std::log(planes_[11][i])) <= exponentialLimit;
        if (!(planes_[12][i] <= 1e-9 && isSmall && g >= 0 && 3 * one.mu * g <= one.qTrial &&
              std::min(p, one.pTrial) > one.elastic.smallest))
            return false;
        one.g = g;
        one.u = u;
        one.p = p;
        return true;
    }

  private:
    // With an error of 1e-9 before the last round, it leaves round-off.
    static constexpr int given = 9, all = 13, rounds = 5;
    int count_;
    std::vector<std::vector<double>> planes_;
};

class NorSand : public MaterialOf<NorSand> {
  public:
    std::string className() const override { return "NorSand"; }
    std::string doc() const override {
        return R"(NorSand: sand whose strength and dilatancy follow its density, with critical states.

    q = M_i p (1 + ln(p_i/p)),  p = -tr(sigma)/3,  q = sqrt(3 J2),  dilatancy de_v/de_q = M_i - q/p
    dp_i/p_i = H M_i/M (p/p_i)^2 [exp(-chi psi_i/M) - p_i/p] de_q,  M_i = M(theta) (1 - N chi |psi_i|/M)
    psi_i = e - e_c(p_i),  e_c = Gamma - lambda ln(p/p_ref),  M = 6 sin(phi)/(3 - sin(phi))
    M(theta) = M - M^2/(3 + M) cos(3 theta/2 + 45 deg),  G = G_ref (p/p_ref)^m

Strains and pressures are positive in compression; stress is effective stress. The density is given by
initialVoidRatio or by stateParameter, psi = e - e_c(p) at the initial stress: below zero dense, above zero loose.
The image pressure p_i starts on the surface through the initial stress, times overconsolidationRatio, and
stays below what the density allows, so that sand that is unloaded yields inwards. The return solves for
shear strain and pressure together; psi_i and theta are those of the trial. Grains without pressure part, and
close before they resist again (in bodies with F-bar). It does not know cycles: at constant volume sand liquefies in
monotonic loading alone.

Source: Jefferies 1993, Geotechnique 43, 91-103; Jefferies & Shuttle 2005, in Soil Constitutive Models (ASCE GSP 128),
204-236; Jefferies & Been 2016, Soil Liquefaction.)";
    }
    std::vector<Parameter> parameters() override {
        return {
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()},
            {"shearModulus", "kPa", "required: elastic shear modulus G_ref at referencePressure", &shear_,
             Range::positive()},
            {"poisson", "-", "Poisson's ratio", &poisson_, Range::inside(-1, 0.5)},
            {"pressureExponent", "-", "exponent m of the shear modulus over the pressure", &power_,
             Range{0, 1, false, false}},
            {"referencePressure", "kPa", "pressure p_ref of shearModulus and criticalVoidRatio", &reference_,
             Range::positive()},
            criticalFriction(&phi_),
            {"criticalVoidRatio", "-", "required: critical void ratio Gamma at referencePressure", &gamma_,
             Range::positive()},
            {"compression", "-", "required: slope lambda of the critical states, e against ln p", &lambda_,
             Range::positive()},
            {"dilatancy", "-", "chi: dilatancy at the peak over psi_i", &chi_, Range::notNegative()},
            {"volumetricCoupling", "-", "N: share of the dilatancy that raises the peak", &N_,
             Range{0, 1, false, true}},
            {"hardening", "-", "H: plastic hardening", &H_, Range::positive()},
            density_.ratioParameter(),
            density_.stateParameter(),
            {"overconsolidationRatio", "-",
             "image pressure over that of the surface through the initial stress", &ratio_,
             Range{1, std::numeric_limits<double>::infinity(), false, false}},
            leastPressure(&smallest_),
        };
    }
    void finish() override {
        const std::string who = className();
        requireDensity(who, density);
        requireGiven(who, {{shear_, "shearModulus"},
                           {phi_, "frictionAngle"},
                           {gamma_, "criticalVoidRatio"},
                           {lambda_, "compression"}});
        density_.check(who, varies("initialVoidRatio"));
        M_ = criticalRatio(phi_);
    }
    std::vector<StateVariable> stateVariables() const override {
        return {
            {"plasticShearStrain", "-", "accumulated plastic shear strain, sum of sqrt(2/3 de:de)"},
            {"plasticVolumetricStrain", "-", "plastic volumetric strain, dilation positive"},
            openingVariable(),
            {"imagePressure", "kPa", "pressure p_i at which the surface has the stress ratio M_i", smallest_},
            density_.variable(critical(smallest_))};
    }
    bool yields() const override { return true; }
    VolumeRecord volumeRecord() const override { return {1, 2}; }
    std::array<double, 2> lame() const override { return lameAt(smallest_); }

    void stateFromStress(const double stress[9], double* state) const override {
        const double xx = stress[0], yy = stress[4], zz = stress[8],
                     p = std::max(smallest_, -(xx + yy + zz) / 3);
        const Symmetric s{xx, yy, zz, stress[1], stress[2], stress[5]};
        const Symmetric deviator = plusSpherical(s, -(xx + yy + zz) / 3);
        const double q = std::sqrt(3 * halfSquare(deviator));
        state[4] = density_.at(critical(p), state[4]);
        const double M = frictionAt(deviator);
        state[0] = state[1] = state[2] = 0;
        state[3] = ratio_ * p * std::exp(std::min(q / (M * p), 2.0) - 1);
    }

    template <int Dim> void stress(const MaterialPoints<Dim>& points) const {
        std::vector<SandReturn> returns;
        SandReturns usual(points.count);
        for (int i = 0; i < points.count; ++i) {
            returns.push_back(returnOf(points, i));
            usual.set(i, returns.back());
        }
        usual.solve();
        for (int i = 0; i < points.count; ++i) {
            SandReturn& back = returns[i];
            const bool yields = back.yields();
            if (yields && !usual.give(i, back)) back.solve();
            take(points, i, back, yields);
        }
    }
    template <int Dim> void findStiffness(const MaterialPoints<Dim>& points, double* l, double* mu) const {
        fillStiffness(points, l, mu, [&](int i) { return lameAt(pressureOf(points, i)); });
    }
    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        criticalStrength(M_, points, strength);
    }
    template <int Dim> void findStoredEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        for (int i = 0; i < points.count; ++i) {
            const double p = pressureOf(points, i);
            energy[i] = elastic().energy(p) + 0.5 * invariants(points, i).J2 / lameAt(p)[1];
        }
    }

  private:
    double critical(double p) const { return gamma_ - lambda_ * std::log(p / reference_); }
    PressureStiffness elastic() const {
        return {2 * shear_ * (1 + poisson_) / (3 * (1 - 2 * poisson_)), reference_, power_, smallest_};
    }
    std::array<double, 2> lameAt(double p) const { return lameOf(elastic().stiffness(p), poisson_); }
    // M of the Lode angle of a deviator, tension positive: theta is 30 degrees in triaxial compression. With S = sin(3
    // theta), cos(3 theta/2 + 45 deg) is the root of (1 - S)/2; near S = 1 it comes from cos(3 theta), which lode.hpp
    // finds without the loss of half the digits.
    double frictionAt(const Symmetric& s) const {
        const double J2 = halfSquare(s), J4 = J2 * J2;
        if (!(J4 > 0)) return M_;
        const Symmetric adj = adjugate(s);
        const double J3 = determinant(Tensor(s), Tensor(adj)),
                     S = -1.5 * std::sqrt(3.0) * J3 / (J2 * std::sqrt(J2));
        const Symmetric orthogonal = plusSpherical(J2 * adj, J4 / 3) + (-1.5 * J3) * s;
        const double cos3 = std::sqrt(3 * halfSquare(orthogonal)) / J4;
        const double root = S > 0 ? cos3 / std::sqrt(2 * (1 + S)) : std::sqrt(std::max(1 - S, 0.0) / 2);
        return M_ - M_ * M_ / (3 + M_) * std::min(root, 1.0);
    }

    // Leaves the trial deviator as the stress, and closes what had opened.
    template <int Dim> SandReturn returnOf(const MaterialPoints<Dim>& points, int i) const {
        double* const* state = points.state;
        const Increment step = incrementOf(points, i);
        const Symmetric before = congruence(step.rotation, stressOf(points, i));
        const PressureStiffness law = elastic();
        const double mean = (before.xx + before.yy + before.zz) / 3, pBefore = std::max(-mean, 0.0);
        const double mu = lameAt(pBefore)[1], dilation = step.strain.xx + step.strain.yy + step.strain.zz;
        const double closed = points.hasFbar ? std::clamp(-dilation, 0.0, state[2][i]) : 0;
        state[2][i] -= closed;
        state[1][i] -= closed;
        const double solid = points.volume[i] / points.initialVolume[i] * std::exp(-state[2][i]);
        const double voidRatio = (1 + state[4][i]) * solid - 1;

        const Symmetric s = plusSpherical(before, -mean) + 2 * mu * plusSpherical(step.strain, -dilation / 3);
        setStress(points, i, s);
        double& image = state[3][i];
        const double psi = voidRatio - critical(image), M0 = frictionAt(s);
        const double M = M0 * std::max(1 - N_ * chi_ * std::abs(psi) / M_, 0.5);
        const double limit = std::exp(std::clamp(-chi_ * psi / M_, -0.9, 2.0));
        image = std::max(std::min(image, limit * std::max(pBefore, smallest_)), 0.1 * smallest_);
        const double e = law.strain(pBefore) - dilation - closed;
        return {law, e, std::sqrt(3 * halfSquare(s)), image, mu, M, H_ * M / M_, limit};
    }
    // Stress and state at the end of the step.
    template <int Dim>
    void take(const MaterialPoints<Dim>& points, int i, const SandReturn& back, bool yields) const {
        double* const* state = points.state;
        if (back.parts()) {
            const double gap = std::max(0.0, -back.e - smallest_ / back.elastic.stiffness(smallest_));
            if (points.hasFbar) state[2][i] += gap;
            state[1][i] += gap;
            state[0][i] += back.qTrial / (3 * back.mu);
            return setStress(points, i, Symmetric{});
        }
        if (yields) {
            state[1][i] -= back.g * back.M * back.u;
            state[3][i] = std::max(back.pi(), 0.1 * smallest_);
        }
        state[0][i] += (back.qTrial - back.q()) / (3 * back.mu);
        const double scale = back.qTrial > 0 ? back.q() / back.qTrial : 1;
        setStress(points, i, plusSpherical(scale * stressOf(points, i), -back.p));
    }
    double shear_ = notGiven, poisson_ = 0.2, power_ = 0.5, reference_ = 100, phi_ = notGiven,
           gamma_ = notGiven;
    double lambda_ = notGiven, chi_ = 3.5, N_ = 0.3, H_ = 100;
    double ratio_ = 1, smallest_ = 1, M_ = 0;
    SandDensity density_;
};

MPM_REGISTER(Material, NorSand);

} // namespace
} // namespace mpm
