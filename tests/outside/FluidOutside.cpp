// SPDX-License-Identifier: GPL-2.0-or-later
// The pressure of a fluid without viscosity, sigma = K (J - 1) I.
#include <mpm/material/Material.hpp>

namespace {

class FluidOutside : public mpm::MaterialOf<FluidOutside> {
  public:
    double bulk = mpm::notGiven;

    std::string className() const override { return "FluidOutside"; }
    std::string doc() const override { return "Compressible fluid without viscosity, from a plugin."; }
    std::vector<mpm::Parameter> parameters() override {
        return {{"density", "Mg/m3", "required: mass density, initial", &density, mpm::Range::positive()},
                {"bulk", "kPa", "required: bulk modulus", &bulk, mpm::Range::positive()}};
    }
    void finish() override { mpm::require(bulk > 0, className(), ": bulk is required; give it in kPa"); }
    std::array<double, 2> lame() const override { return {bulk, 0.0}; }
    void stateFromStress(const double stress[9], double*) const override {
        mpm::require(stress[0] == 0, className(), ": an initial stress cannot be given, it follows from J");
    }

    template <int Dim> void stress(const mpm::MaterialPoints<Dim>& points) const {
        for (int i = 0; i < 3; ++i)
            for (int p = 0; p < points.count; ++p)
                points.stress[4 * i][p] = bulk * (points.volume[p] / points.initialVolume[p] - 1);
    }
};

MPM_REGISTER(mpm::Material, FluidOutside);

} // namespace
