// SPDX-License-Identifier: GPL-2.0-or-later
// A weakly compressible liquid of constant viscosity.
#include "mpm/material/liquid.hpp"

namespace mpm {
namespace {

class NewtonianLiquid : public ViscousOf<NewtonianLiquid> {
  public:
    std::string className() const override { return "NewtonianLiquid"; }
    std::string doc() const override {
        return R"(Weakly compressible liquid of constant viscosity: water, oil, remoulded soil as a fluid.

    dp/dt = -K tr D,  s + (eta/G) ds/dt = 2 eta dev D,  p = -tr(sigma)/3,  ds/dt of Jaumann

K is the bulk modulus, eta the dynamic viscosity; the relaxation time eta/G is short beside the flow where G,
the shearModulus, is 30 times the largest shear stress. The time step does not depend on eta. The
liquid does not resist a mean stress above tensileStrength: it opens, and closes before there is pressure
again (in bodies with F-bar).

Source: Maxwell 1867, Phil. Trans. R. Soc. 157, 49-88 (spring and dashpot in series); Monaghan 1994, J. Comput. Phys.
110, 399-406 (weakly compressible water).)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()},
            {"viscosity", "kPa s", "dynamic viscosity eta; water has 1e-6", &viscosity_,
             Range::notNegative()}};
        for (auto& p : liquid_.parameters()) all.push_back(p);
        for (auto& p : pressure_.parameters()) all.push_back(p);
        return all;
    }
    void finish() override { liquid_.check(className(), density); }

    std::array<double, 2> elastic() const { return liquid_.elastic(); }
    double most() const { return liquid_.tension; }
    double strengthAt(double) const { return 0; }
    template <int Dim, class Number>
    void flow(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        const double viscosity = viscosity_, dt = points.dt;
        flowFrom(moduli, most(), points,
                 [=](double trial, double, double mu) { return viscosity / (viscosity + mu * dt) * trial; });
    }

  private:
    double viscosity_ = 1e-6;
    Liquid liquid_;
};

MPM_REGISTER(Material, NewtonianLiquid);

} // namespace
} // namespace mpm
