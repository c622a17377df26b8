// SPDX-License-Identifier: GPL-2.0-or-later
// Dense granular flow: friction that grows with the inertial number.
#include "mpm/material/required.hpp"
#include "mpm/material/viscous.hpp"

namespace mpm {
namespace {

class MuI : public ViscousOf<MuI> {
  public:
    std::string className() const override { return "MuI"; }
    std::string doc() const override {
        return R"(Dense granular flow, mu(I): friction that grows with the rate of shear over the pressure.

    tau = mu(I) p,  mu(I) = mu_s + (mu_2 - mu_s)/(1 + I_0/I),  I = rate d sqrt(rho_s/p)
    tau = sqrt(s:s/2),  p = -tr(sigma)/3,  rate = sqrt(2 D:D) of the flow

Below mu_s p the grains are an elastic solid; flow keeps the volume, and grains without pressure part: they
close before they resist again (in bodies with F-bar). In plane strain mu_s is the sine of the friction angle
of MohrCoulomb without dilatancy. The stress at the end of a step solves tau + G dt rate = tau_trial
in closed form, and the time step is that of the elastic grains.

Source: Jop, Forterre & Pouliquen 2006, Nature 441, 727-730; GDR MiDi 2004, Eur. Phys. J. E 14, 341-365.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{{"density", "Mg/m3", "required: mass density of grains and voids, initial",
                                    &density, Range::positive()}};
        for (auto& p : elasticity_.parameters()) all.push_back(p);
        for (auto& p : pressure_.parameters()) all.push_back(p);
        for (auto& p : std::vector<Parameter>{
                 {"staticFriction", "-", "required: friction coefficient mu_s of grains that begin to flow",
                  &static_, Range::positive()},
                 {"fastFriction", "-", "required: friction coefficient mu_2 of the fastest flow", &fast_,
                  Range::positive()},
                 {"inertialNumber", "-", "I_0 at which friction is half way from one to the other", &I0_,
                  Range::positive()},
                 {"grainSize", "m", "required: diameter d of the grains", &size_, Range::positive()},
                 {"grainDensity", "Mg/m3", "density rho_s of the grains alone; not given: density/0.6",
                  &grainDensity_, Range::positive()}})
            all.push_back(p);
        return all;
    }
    void finish() override {
        const std::string who = className();
        requireDensity(who, density);
        elasticity_.finish(who);
        requireGiven(who, {{static_, "staticFriction"}, {fast_, "fastFriction"}, {size_, "grainSize"}});
        require(fast_ >= static_, who, ": fastFriction = ", fast_, " is below staticFriction = ", static_,
                "; friction grows with the rate: give at least that");
    }

    std::array<double, 2> elastic() const { return {elasticity_.bulk(), elasticity_.mu()}; }
    double most() const { return 0; }
    double strengthAt(double pressure) const { return static_ * std::max(pressure, 0.0); }
    // Of tau = tau_trial - B rate with B = G dt and the rate a = I_0/(d sqrt(rho_s/p)) at half way:
    //   B rate^2 + (B a + (mu_2 - mu_s) p - excess) rate - excess a = 0,  excess = tau_trial - mu_s p
    template <int Dim, class Number>
    void flow(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        const double still = static_, more = fast_ - static_, dt = points.dt;
        const double grains = std::isnan(grainDensity_) ? density / 0.6 : grainDensity_;
        const double perSpeed = I0_ / size_, overDensity = 1 / grains;
        flowFrom(moduli, most(), points, [=](double trial, double p, double mu) {
            const double B = mu * dt, excess = std::max(trial - still * p, 0.0),
                         a = perSpeed * std::sqrt(p * overDensity);
            const double half = 0.5 * (B * a + more * p - excess),
                         root = std::sqrt(half * half + B * excess * a);
            // B rate, by the form without cancellation
            const double falls = half > 0 ? excess * a * B / std::max(half + root, 1e-300) : root - half;
            return trial - falls;
        });
    }

  private:
    Elasticity elasticity_;
    double static_ = notGiven, fast_ = notGiven, I0_ = 0.279, size_ = notGiven, grainDensity_ = notGiven;
};

MPM_REGISTER(Material, MuI);

} // namespace
} // namespace mpm
