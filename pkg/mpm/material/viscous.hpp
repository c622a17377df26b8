// SPDX-License-Identifier: GPL-2.0-or-later
// Flowing matter: the shear stress is that of a rate of shear, and the volume is elastic. A spring G in series with the
// flow makes it so: of a trial shear stress tau_tr, tau + G dt rate(tau) = tau_tr is left. The step is stable whatever
// the viscosity, for the tangent is never stiffer than the spring. State: 0 plastic shear strain, 1 plastic volumetric
// strain, 2 opening.
#pragma once

#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/opening.hpp"
#include "mpm/material/spareStrength.hpp"
#include "mpm/material/stiffening.hpp"

namespace mpm {

// Trial stress in, stress out. resistance(trial shear stress, pressure, shear modulus): shear stress sqrt(J2) that is
// left, kPa.
template <class Number, class Resistance, int Dim>
void flowFrom(Moduli<Number> moduli, double most, const MaterialPoints<Dim>& points, Resistance resistance) {
    const auto stress = planes<9>(points.stress);
    double *shear = points.state[0], *volumetric = points.state[1];
    const int count = points.count;
#pragma omp simd
    for (int i = 0; i < count; ++i) {
        const double mu = modulus(OneNumber{i}, moduli.mu), bulk = modulus(OneNumber{i}, moduli.bulk);
        const double perShear = 1 / (std::sqrt(3.0) * mu), compliance = 1 / bulk;
        Symmetric s{stress[0][i], stress[4][i], stress[8][i], stress[1][i], 0, 0};
        if constexpr (Dim == 3) s.xz = stress[2][i], s.yz = stress[5][i];
        const double mean = (s.xx + s.yy + s.zz) / 3, after = std::min(mean, most);
        s = plusSpherical(s, -mean);
        const double trial = std::sqrt(halfSquare(s)), left = std::min(resistance(trial, -after, mu), trial);
        const double scale = trial > 0 ? left / trial : 1;
        s = plusSpherical(scale * s, after);
        stress[0][i] = s.xx;
        stress[4][i] = s.yy;
        stress[8][i] = s.zz;
        stress[1][i] = stress[3][i] = s.xy;
        if constexpr (Dim == 3) {
            stress[2][i] = stress[6][i] = s.xz;
            stress[5][i] = stress[7][i] = s.yz;
        }
        shear[i] += (trial - left) * perShear;
        volumetric[i] += (mean - after) * compliance;
    }
}

// What the flowing laws have in common. Derived has elastic() = {bulk, mu}, most(), the highest mean stress,
// flow(points, moduli): from the trial stress to the stress, and strengthAt(pressure) of matter at rest.
template <class Derived> class ViscousOf : public StiffeningOf<Derived> {
  public:
    std::vector<StateVariable> stateVariables() const override {
        return {{"plasticShearStrain", "-", "accumulated shear strain of the flow, sum of sqrt(2/3 de:de)"},
                {"plasticVolumetricStrain", "-", "volumetric strain that opened a gap, dilation positive"},
                openingVariable()};
    }
    bool yields() const override { return true; }
    VolumeRecord volumeRecord() const override { return {1, std::isinf(self().most()) ? -1 : 2}; }
    std::array<double, 2> moduli() const { return {bulk() - 2 * mu() / 3, mu()}; }
    void stateFromStress(const double*, double* state) const override { std::fill_n(state, 3, 0.0); }

    Moduli<double> constants() const { return {bulk() - 2 * mu() / 3, mu(), bulk()}; }
    template <int Dim, class Number>
    void respond(const MaterialPoints<Dim>& points, const Moduli<Number>& moduli) const {
        trialStress(moduli.lambda, moduli.mu, points);
        if (volumeRecord().opening >= 0 && points.hasFbar) {
            const auto most = [limit = self().most()](int) { return limit; };
            const auto bulk = [moduli](int i) { return moduli.at(i).bulk; };
            closeUp(bulk, most, points);
            openUp(bulk, most, points);
        }
        self().flow(points, moduli);
    }
    template <int Dim> void findStrength(const MaterialPoints<Dim>& points, double* strength) const {
        for (int i = 0; i < points.count; ++i) {
            const auto [mean, J2] = invariants(points, i);
            strength[i] = spareStrength(self().strengthAt(-mean), self().strengthAt(0), std::sqrt(J2));
        }
    }

  private:
    const Derived& self() const { return static_cast<const Derived&>(*this); }
    double bulk() const { return self().elastic()[0]; }
    double mu() const { return self().elastic()[1]; }
};

} // namespace mpm
