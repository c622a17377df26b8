// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic moduli over the pressure: E = E_ref (p/p_ref)^m. Strain and pressure are positive in compression here.
#pragma once

#include "mpm/base/parameters.hpp"
#include "mpm/material/pressureStiffness.hpp"

namespace mpm {

class PressureDependence {
  public:
    double exponent = 0, reference = 100, smallest = 1; // -, kPa, kPa

    bool isGiven() const { return exponent > 0; }
    std::vector<Parameter> parameters() {
        return {
            {"pressureExponent", "-",
             "exponent m of the elastic moduli over the pressure: the given ones times (p/p_ref)^m; 0: constant",
             &exponent, Range{0, 1, false, false}},
            {"referencePressure", "kPa", "mean pressure p_ref at which the moduli are as given", &reference,
             Range::positive()},
            {"smallestPressure", "kPa", "mean pressure below which the moduli stay, with pressureExponent",
             &smallest, Range::positive()}};
    }

    // What the moduli are multiplied by at a pressure.
    double tangent(double p) const { return of(1).stiffness(p); }
    // The same, of a step from the pressure p with the elastic strain e: exactly what the pressure gains over bulk e, so
    // that it comes back along the same strains.
    double overStep(double bulk, double p, double e) const {
        const PressureStiffness law = of(bulk);
        if (e == 0) return tangent(p);
        if (p <= smallest && law.strain(p) + e <= 0) return tangent(0);
        const double power = 1 - exponent, gain = law.stiffness(p) * e / p;
        if (p > smallest && power * gain > -1) {
            const double grown = std::expm1(power == 0 ? gain : std::log1p(power * gain) / power);
            if (p * (1 + grown) >= smallest) return p * grown / (bulk * e);
        }
        return (law.pull(law.strain(p) + e) - p) / (bulk * e);
    }

    // Of a law with a potential W of the strain, that with its moduli constant gives the pressure P_0 = sqrt(2 K W): the
    // pressure on the same strain. It is a size of the stress, P^2 = p^2 + K/mu J2 of a linear law.
    double pressure(double bulk, double linear) const {
        const PressureStiffness law = of(bulk);
        return law.pull(linear / bulk - smallest / law.stiffness(smallest));
    }
    double linear(double bulk, double pressure) const {
        const PressureStiffness law = of(bulk);
        return bulk * (law.strain(pressure) + smallest / law.stiffness(smallest));
    }
    double energy(double bulk, double p) const { return of(bulk).energy(p); } // the integral of p dp/K

  private:
    PressureStiffness of(double bulk) const { return {bulk, reference, exponent, smallest}; }
};

} // namespace mpm
