// SPDX-License-Identifier: GPL-2.0-or-later
// Mud, debris and slurry: solid up to a yield stress, and a liquid above it.
#include "mpm/material/liquid.hpp"

namespace mpm {
namespace {

class HerschelBulkley : public ViscousOf<HerschelBulkley> {
  public:
    std::string className() const override { return "HerschelBulkley"; }
    std::string doc() const override {
        return R"(Mud, debris, slurry: elastic up to a yield stress, a liquid above it (Bingham where flowIndex is 1).

    tau = tau_y + k rate^n,  tau = sqrt(s:s/2),  rate = sqrt(2 D:D) of the flow,  dp/dt = -K tr D

tau_y is the yieldStress, k the consistency (kPa s^n), n the flowIndex. Below tau_y the matter is an
elastic solid of the shear modulus G; a plug moves as a whole. The stress at the end of a step solves
tau + G dt rate = tau_trial: the time step depends neither on k nor on n. The mean stress stays below
tensileStrength, as of NewtonianLiquid.

Source: Herschel & Bulkley 1926, Kolloid-Zeitschrift 39, 291-300; Bingham 1922, Fluidity and Plasticity; Perzyna 1966,
Adv. Appl. Mech. 9, 243-377 (rate of the stress beyond yield).)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()},
            {"yieldStress", "kPa", "required: shear stress tau_y above which it flows", &yield_,
             Range::notNegative()},
            {"consistency", "kPa s^n", "required: k; the viscosity of a Bingham liquid", &consistency_,
             Range::positive()},
            {"flowIndex", "-", "exponent n of the rate; 1: Bingham, below 1: thinner when sheared faster",
             &n_, Range{0.1, 2, false, false}}};
        for (auto& p : liquid_.parameters()) all.push_back(p);
        for (auto& p : pressure_.parameters()) all.push_back(p);
        return all;
    }
    void finish() override {
        liquid_.check(className(), density);
        require(!std::isnan(yield_), className(), ": yieldStress is required; give it in kPa");
        require(!std::isnan(consistency_), className(), ": consistency is required; give it in kPa s^n");
    }

    std::array<double, 2> elastic() const { return liquid_.elastic(); }
    double most() const { return liquid_.tension; }
    double strengthAt(double) const { return yield_; }
    template <int Dim, class Number>
    void flow(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        const double dt = points.dt;
        if (n_ == 1) {
            const double consistency = consistency_, yield = yield_;
            flowFrom(moduli, most(), points, [=](double trial, double, double mu) {
                const double scale = consistency / (consistency + mu * dt);
                return yield + scale * (trial - yield);
            });
        } else
            flowFrom(moduli, most(), points, [&](double trial, double, double mu) {
                return yield_ + overstress(trial - yield_, mu * dt);
            });
    }

  private:
    // x = tau - tau_y of x + perRate (x/k)^(1/n) = excess where n < 1, else of the rate r = (x/k)^(1/n): both are
    // convex, and Newton's method comes down from above without a bracket.
    double overstress(double excess, double perRate) const {
        if (excess <= 0 || perRate <= 0) return excess;
        const double power = n_ < 1 ? 1 / n_ : n_;
        const double a = n_ < 1 ? 1 : perRate,
                     b = n_ < 1 ? perRate * std::pow(consistency_, -power) : consistency_;
        double x = std::min(excess / a, std::pow(excess / b, 1 / power)); // a x + b x^power = excess
        for (int k = 0; k < 60; ++k) {
            const double high = b * std::pow(x, power), left = a * x + high - excess;
            const double step = left / (a + power * high / x);
            x -= step;
            if (std::abs(step) <= 1e-15 * x) break;
        }
        return n_ < 1 ? x : excess - perRate * x;
    }

    double yield_ = notGiven, consistency_ = notGiven, n_ = 1;
    Liquid liquid_;
};

MPM_REGISTER(Material, HerschelBulkley);

} // namespace
} // namespace mpm
