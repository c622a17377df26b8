// SPDX-License-Identifier: GPL-2.0-or-later
// Sand under cycles: a bounding surface, a dilatancy surface, and a memory of the fabric.
#include "mpm/material/Material.hpp"
#include "mpm/material/criticalState.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/opening.hpp"
#include "mpm/material/pressureStiffness.hpp"

namespace mpm {
namespace {

double dot(const Symmetric& a, const Symmetric& b) {
    return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2 * (a.xy * b.xy + a.xz * b.xz + a.yz * b.yz);
}
double norm(const Symmetric& a) { return std::sqrt(dot(a, a)); }

// What a particle remembers, and its stress: s = deviator, compression positive, over its pressure p.
struct SandState {
    // Pressure. Below `least`, smallestPressure or what there was, it does not fall but by dilation from outside.
    double p, least;
    Symmetric s, alpha, fabric, reversal;
    double shear = 0, volumetric = 0; // plastic strain of the step
};

class Sanisand : public MaterialOf<Sanisand> {
  public:
    std::string className() const override { return "Sanisand"; }
    std::string doc() const override {
        return R"(Sand under cycles: cyclic mobility, liquefaction, and critical states.

    f = |s - p alpha| - sqrt(2/3) m p,  n = (s/p - alpha)/|s/p - alpha|,  psi = e - e_c,  e_c = e_0 - lambda (p/p_ref)^xi
    alpha_b = sqrt(2/3) [g M exp(-n_b psi) - m],  alpha_d = sqrt(2/3) [g M exp(n_d psi) - m]
    d alpha = 2/3 L h (alpha_b n - alpha),  h = G_0 h_0 (1 - c_h e) (p/p_ref)^-1/2/((alpha - alpha_in):n)
    de_v = L A_0 (1 + <z:n>) (alpha_d - alpha:n),  dz = -c_z <-de_v> (z_max n + z)
    G = G_0 p_ref (2.97 - e)^2/(1 + e) (p/p_ref)^k,  M = 6 sin(phi)/(3 - sin(phi))

Strains and pressures are positive in compression; stress is effective stress. alpha is the back stress ratio, alpha_in
its value at the last reversal, z the fabric, g(theta) the shape between compression and extension, L the plastic
multiplier. Defaults are those of Toyoura sand. A step is cut into parts whose elastic stress is at most one percent of
the pressure; each returns from its trial once, and the yield surface follows the stress. Grains without pressure part,
and close before they resist again (in bodies with F-bar). The law does not yield in compression at a constant ratio.

Source: Dafalias & Manzari 2004, J. Eng. Mech. 130, 622-634.)";
    }
    std::vector<Parameter> parameters() override {
        return {
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()},
            {"shearFactor", "-", "G_0: elastic shear modulus, see above", &shear_, Range::positive()},
            {"poisson", "-", "Poisson's ratio", &poisson_, Range::inside(-1, 0.5)},
            {"pressureExponent", "-", "exponent k of the shear modulus over the pressure", &power_,
             Range{0, 1, false, false}},
            {"referencePressure", "kPa", "pressure p_ref", &reference_, Range::positive()},
            criticalFriction(&phi_),
            {"extensionRatio", "-", "c: M of triaxial extension over that of compression", &c_,
             Range{0.5, 1, false, false}},
            {"criticalVoidRatio", "-", "required: critical void ratio e_0 at no pressure", &e0_,
             Range::positive()},
            {"compression", "-", "required: lambda of the critical states", &lambda_, Range::positive()},
            {"criticalExponent", "-", "xi of the critical states", &xi_, Range::positive()},
            {"yieldRatio", "-", "m: radius of the yield surface, a stress ratio", &m_,
             Range{0.001, 0.2, false, false}},
            {"hardening", "-", "h_0: plastic hardening", &h0_, Range::positive()},
            {"hardeningDensity", "-", "c_h: how the hardening falls with the void ratio", &ch_,
             Range::notNegative()},
            {"bounding", "-", "n_b: how the peak grows with the density", &nb_, Range::notNegative()},
            {"dilatancy", "-", "A_0: dilatancy", &A0_, Range::notNegative()},
            {"phaseTransformation", "-", "n_d: how dilation comes earlier with the density", &nd_,
             Range::notNegative()},
            {"fabricLimit", "-", "z_max: largest fabric", &zMost_, Range::notNegative()},
            {"fabricRate", "-", "c_z: how fast dilation makes fabric", &cz_, Range::notNegative()},
            density_.ratioParameter(),
            density_.stateParameter(),
            leastPressure(&smallest_, "least pressure of grains that touch"),
        };
    }
    void finish() override {
        const std::string who = className();
        requireDensity(who, density);
        requireGiven(who, {{phi_, "frictionAngle"}, {e0_, "criticalVoidRatio"}, {lambda_, "compression"}});
        density_.check(who, varies("initialVoidRatio"));
        M_ = criticalRatio(phi_);
    }
    std::vector<StateVariable> stateVariables() const override {
        std::vector<StateVariable> all = {
            {"plasticShearStrain", "-", "accumulated plastic shear strain, sum of sqrt(2/3 de:de)"},
            {"plasticVolumetricStrain", "-", "plastic volumetric strain, dilation positive"},
            openingVariable(),
            density_.variable(critical(smallest_))};
        for (const auto& [name, doc] : {std::pair{"backStress", "back stress ratio, compression positive"},
                                        {"reversal", "back stress ratio at the last reversal"},
                                        {"fabric", "fabric tensor"}})
            for (const char* component : {"XX", "YY", "XY", "XZ", "YZ"})
                all.push_back({std::string(name) + component, "-", doc});
        return all;
    }
    bool yields() const override { return true; }
    VolumeRecord volumeRecord() const override { return {1, 2}; }
    std::array<double, 2> lame() const override {
        return lameAt(smallest_, std::isnan(density_.voidRatio) ? 0.7 : density_.voidRatio);
    }

    void stateFromStress(const double stress[9], double* state) const override {
        const double p = std::max(smallest_, -(stress[0] + stress[4] + stress[8]) / 3);
        const Symmetric s{stress[0], stress[4], stress[8], stress[1], stress[2], stress[5]};
        const Symmetric ratio = (-1 / p) * plusSpherical(s, -(s.xx + s.yy + s.zz) / 3);
        state[3] = density_.at(critical(p), state[3]);
        std::fill_n(state, 3, 0.0);
        const double components[5] = {ratio.xx, ratio.yy, ratio.xy, ratio.xz, ratio.yz};
        for (int k = 0; k < 5; ++k) state[4 + k] = state[9 + k] = components[k], state[14 + k] = 0;
    }

    template <int Dim> void stress(const MaterialPoints<Dim>& points) const {
        for (int i = 0; i < points.count; ++i) advance(points, i);
    }
    template <int Dim> void findStiffness(const MaterialPoints<Dim>& points, double* l, double* mu) const {
        fillStiffness(points, l, mu,
                      [&](int i) { return lameAt(pressureOf(points, i), voidRatio(points, i)); });
    }
    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        criticalStrength(M_, points, strength);
    }
    template <int Dim> void findStoredEnergy(const MaterialPoints<Dim>& points, double* energy) const {
        for (int i = 0; i < points.count; ++i) {
            const double p = pressureOf(points, i), e = voidRatio(points, i);
            energy[i] = elastic(e).energy(p) + 0.5 * invariants(points, i).J2 / lameAt(p, e)[1];
        }
    }

  private:
    double critical(double p) const { return e0_ - lambda_ * std::pow(p / reference_, xi_); }
    PressureStiffness elastic(double e) const {
        const double G = shear_ * reference_ * (2.97 - e) * (2.97 - e) / (1 + e);
        return {2 * G * (1 + poisson_) / (3 * (1 - 2 * poisson_)), reference_, power_, smallest_};
    }
    std::array<double, 2> lameAt(double p, double e) const {
        return lameOf(elastic(e).stiffness(p), poisson_);
    }
    template <int Dim> double voidRatio(const MaterialPoints<Dim>& points, int i) const {
        const double solid = points.volume[i] / points.initialVolume[i] * std::exp(-points.state[2][i]);
        return std::clamp((1 + points.state[3][i]) * solid - 1, SandDensity::least, 2.5);
    }
    // Tensor of state that begins at a variable, in the axes at the end of the step.
    template <int Dim>
    static Symmetric turned(const MaterialPoints<Dim>& points, int first, int i, const Tensor& rotation) {
        const auto at = [&](int k) { return points.state[first + k][i]; };
        return congruence(rotation, Symmetric{at(0), at(1), -at(0) - at(1), at(2), at(3), at(4)});
    }
    template <int Dim>
    static void keep(const MaterialPoints<Dim>& points, int first, int i, const Symmetric& a) {
        const double components[5] = {a.xx, a.yy, a.xy, a.xz, a.yz};
        for (int k = 0; k < 5; ++k) points.state[first + k][i] = components[k];
    }

    template <int Dim> void advance(const MaterialPoints<Dim>& points, int i) const {
        const Increment step = incrementOf(points, i);
        const Symmetric before = congruence(step.rotation, stressOf(points, i));
        const double mean = (before.xx + before.yy + before.zz) / 3;
        double dilation = step.strain.xx + step.strain.yy + step.strain.zz, *opening = points.state[2] + i;
        const Symmetric shear = -1.0 * plusSpherical(step.strain, -dilation / 3);
        const double closed = points.hasFbar ? std::clamp(-dilation, 0.0, *opening) : 0;
        *opening -= closed;
        points.state[1][i] -= closed;
        dilation += closed;

        const double p = std::max(-mean, 0.0);
        SandState now{p,
                      std::min(p, smallest_),
                      -1.0 * plusSpherical(before, -mean),
                      turned(points, 4, i, step.rotation),
                      turned(points, 14, i, step.rotation),
                      turned(points, 9, i, step.rotation)};
        const double gap = strain(now, shear, -dilation, voidRatio(points, i));
        if (points.hasFbar) *opening += gap;
        points.state[0][i] += now.shear;
        points.state[1][i] += gap - now.volumetric;
        keep(points, 4, i, now.alpha);
        keep(points, 9, i, now.reversal);
        keep(points, 14, i, now.fabric);

        setStress(points, i, plusSpherical(-1.0 * now.s, -now.p));
    }

    // Strains a state in parts; the dilation that opens a gap. What is left of a long step is spread over the last
    // hundred: loose grains that are torn apart would dilate more in one long part than they are, and push each other
    // away.
    double strain(SandState& now, const Symmetric& shear, double compressed, double e) const {
        const PressureStiffness law = elastic(e);
        double left = 1, gap = 0;
        for (int n = 0; left > 0; ++n) {
            const double K = law.stiffness(now.p), G = shearModulus(K, poisson_);
            const double size = (2 * G * norm(shear) + K * std::abs(compressed)) / std::max(now.p, smallest_);
            const double least = n < mostParts - lastParts ? 0 : left / std::max(1, mostParts - n);
            const double part = std::min(left, std::max(largestPart / std::max(size, 1e-300), least));
            gap += advancePart(now, part * shear, part * compressed, e, law);
            left -= part;
        }
        return gap;
    }

    double advancePart(SandState& now, const Symmetric& shear, double compressed, double e,
                       const PressureStiffness& law) const {
        const double K = law.stiffness(now.p), G = shearModulus(K, poisson_),
                     radius = std::sqrt(2.0 / 3) * m_;
        const Symmetric trial = now.s + 2 * G * shear;
        const double pTrial = law.pull(law.strain(now.p) + compressed);
        Symmetric away = trial - pTrial * now.alpha;
        const double size = norm(away), beyond = size - radius * std::max(pTrial, 0.0);
        now.s = trial;
        now.p = pTrial;
        if (beyond > 0) flow(now, direction(away, beyond), beyond, K, G, e);
        if (now.p >= now.least) return 0;
        // The grains hardly touch: the stress ratio stays. What pulls them apart takes the rest of the pressure, too.
        const double soft = law.stiffness(smallest_), missing = (now.least - now.p) / soft,
                     pulled = std::clamp(-compressed, 0.0, missing), left = now.least - soft * pulled;
        away = now.s - now.p * now.alpha;
        now.p = now.least = std::max(0.0, left);
        const double far = norm(away);
        now.s = now.p * now.alpha + std::min(1.0, radius * now.p / std::max(far, 1e-300)) * away;
        return std::max(0.0, -left) / soft;
    }

    // Shape of the surfaces between compression and extension in direction n, and the flow B n - C dev(n^2) there.
    struct Shape {
        double g, B, C, trace3;
        Symmetric n2;
    };
    Shape shapeAt(const Symmetric& n) const {
        Shape at;
        at.n2 = square(n);
        at.trace3 = dot(n, at.n2);
        const double cos3 = std::clamp(std::sqrt(6.0) * at.trace3, -1.0, 1.0);
        at.g = 2 * c_ / (1 + c_ - (1 - c_) * cos3);
        at.B = 1 + 1.5 * (1 - c_) / c_ * at.g * cos3;
        at.C = 3 * std::sqrt(1.5) * (1 - c_) / c_ * at.g;
        return at;
    }
    // Direction of the flow that ends at the yield surface, from a trial beyond it. Beside compression the flow turns
    // 2.8 times as far as the trial: by the trial's own direction n, a part as long as the yield surface is wide would
    // turn the stress over, and resist shear with a negative stiffness. One iteration turns back too far in parts that
    // are longer; 0.4 of n and 0.6 of it keep the stiffness positive in parts of any length.
    Symmetric direction(const Symmetric& away, double beyond) const {
        const Symmetric n = (1 / norm(away)) * away;
        const Shape at = shapeAt(n);
        const Symmetric end = away + beyond * at.C * plusSpherical(at.n2, -1.0 / 3);
        const Symmetric mean = 0.4 * n + (0.6 / norm(end)) * end;
        return (1 / norm(mean)) * mean;
    }

    // Plastic flow from a trial beyond the yield surface; then the surface is moved to the stress.
    void flow(SandState& now, const Symmetric& n, double beyond, double K, double G, double e) const {
        const double p = std::max(now.p, smallest_), root = std::sqrt(2.0 / 3);
        const double start = dot(now.alpha, n);
        double travelled = start - dot(now.reversal, n);
        if (travelled < 0) now.reversal = now.alpha, travelled = 0;
        const auto [g, B, C, trace3, n2] = shapeAt(n);
        const double psi = e - critical(p);
        const double bound = root * (g * M_ * std::exp(-nb_ * psi) - m_);
        const double transformed = root * (g * M_ * std::exp(nd_ * psi) - m_);
        const double b0 = shear_ * h0_ * std::max(1 - ch_ * e, 0.01) / std::sqrt(p / reference_);
        // In the middle of the way of the back stress: h falls fast after a reversal.
        const double first = 2.0 / 3 * p * b0 * std::max(bound - start, 0.0) / std::max(travelled, 1e-6);
        const double half = 0.5 * beyond / p * first / (first + 2 * G), along = start + half;
        const double D = A0_ * (1 + std::max(dot(now.fabric, n), 0.0)) * (transformed - along);
        const double h = b0 / std::max(travelled + half, 1e-6), harder = 2.0 / 3 * p * h * (bound - along);
        const double stiff = harder + 2 * G * (B - C * trace3) - K * D * (start + root * m_);
        const double L = beyond / std::max(stiff, 0.2 * G);

        now.s = now.s - 2 * G * L * (B * n - C * plusSpherical(n2, -1.0 / 3));
        now.p -= K * L * D;
        // A part in which the pressure falls far does not take the stress ratio beyond the bounding surface.
        const double most = now.p * (std::max(bound, norm(now.alpha)) + root * m_), size = norm(now.s);
        if (now.p > 0 && size > most) now.s = (most / size) * now.s;
        now.alpha = now.alpha + std::min(2.0 / 3 * L * h, 1.0) * (bound * n - now.alpha);
        now.fabric = now.fabric - std::min(cz_ * std::max(-L * D, 0.0), 1.0) * (zMost_ * n + now.fabric);
        now.shear += L * root * norm(B * n - C * plusSpherical(n2, -1.0 / 3));
        now.volumetric += L * D;
        if (now.p < 1e-3 * smallest_) return;
        const Symmetric away = (1 / now.p) * now.s - now.alpha;
        now.alpha = (1 / now.p) * now.s - root * m_ / std::max(norm(away), 1e-300) * away;
    }

    // Elastic stress of a part over the pressure; the most parts of a step, and those of equal length at its end.
    static constexpr double largestPart = 0.01;
    static constexpr int mostParts = 1000, lastParts = 100;

    double shear_ = 125, poisson_ = 0.05, power_ = 0.5, reference_ = 101, phi_ = notGiven, c_ = 0.712,
           e0_ = notGiven, lambda_ = notGiven, xi_ = 0.7, m_ = 0.01, h0_ = 7.05, ch_ = 0.968, nb_ = 1.1,
           A0_ = 0.704, nd_ = 3.5, zMost_ = 4, cz_ = 600, smallest_ = 0.5;
    double M_ = 0;
    SandDensity density_;
};

MPM_REGISTER(Material, Sanisand);

} // namespace
} // namespace mpm
