// SPDX-License-Identifier: GPL-2.0-or-later
// An elastic soil whose stiffness grows with its pressure p: K = p/kappa, mu = K/2, dp = -K tr D dt.
#include <algorithm>
#include <cmath>
#include <mpm/material/Material.hpp>

namespace {

class StiffeningOutside : public mpm::MaterialOf<StiffeningOutside> {
  public:
    double kappa = mpm::notGiven;

    std::string className() const override { return "StiffeningOutside"; }
    std::string doc() const override { return "Soil that stiffens with its pressure, from a plugin."; }
    std::vector<mpm::Parameter> parameters() override {
        return {{"density", "Mg/m3", "required: mass density, initial", &density, mpm::Range::positive()},
                {"kappa", "-", "required: compressibility, p/K", &kappa, mpm::Range::positive()}};
    }
    void finish() override { mpm::require(kappa > 0, className(), ": kappa is required"); }
    std::array<double, 2> lame() const override { return lameAt(leastPressure); }
    void stiffness(const mpm::MaterialPoints<2>& points, double* lambda, double* mu) const override {
        presentLame(points, lambda, mu);
    }
    void stiffness(const mpm::MaterialPoints<3>& points, double* lambda, double* mu) const override {
        presentLame(points, lambda, mu);
    }
    void stateFromStress(const double*, double*) const override {}

    template <int Dim> void stress(const mpm::MaterialPoints<Dim>& points) const {
        for (int i = 0; i < points.count; ++i) {
            double rate = 0;
            for (int k = 0; k < Dim; ++k) rate += points.velocityGradient[(Dim + 1) * k][i];
            const double before = pressure(points, i), mu = lameAt(before)[1];
            const double gained = before * (std::exp(-points.dt * rate / kappa) - 1);
            for (int k = 0; k < 3; ++k) points.stress[4 * k][i] -= gained + 2.0 / 3 * mu * points.dt * rate;
            for (int j = 0; j < Dim; ++j)
                for (int k = 0; k < Dim; ++k)
                    points.stress[3 * j + k][i] +=
                        mu * points.dt *
                        (points.velocityGradient[Dim * j + k][i] + points.velocityGradient[Dim * k + j][i]);
        }
    }

  private:
    static constexpr double leastPressure = 1; // kPa

    std::array<double, 2> lameAt(double p) const {
        const double bulk = std::max(p, leastPressure) / kappa, mu = 0.5 * bulk;
        return {bulk - 2.0 / 3 * mu, mu};
    }
    template <int Dim> static double pressure(const mpm::MaterialPoints<Dim>& points, int i) {
        return -(points.stress[0][i] + points.stress[4][i] + points.stress[8][i]) / 3;
    }
    template <int Dim>
    void presentLame(const mpm::MaterialPoints<Dim>& points, double* lambda, double* mu) const {
        for (int i = 0; i < points.count; ++i) {
            const std::array<double, 2> now = lameAt(pressure(points, i));
            lambda[i] = now[0];
            mu[i] = now[1];
        }
    }
};

MPM_REGISTER(mpm::Material, StiffeningOutside);

} // namespace
