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

    // Factor on the moduli at a pressure.
    double tangent(double p) const { return of(1).stiffness(p); }
    // Factor on the moduli in a step from the pressure p with the elastic volumetric strain e: what the pressure gains
    // over bulk e, exactly, so that the same strains backwards lead back to p.
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

    // For a law with a potential W(strain). With constant moduli P_0 = sqrt(2 K W) is the size of its stress: of a linear
    // law P_0^2 = p^2 + K/mu J2. pressure() is the size P with this dependence at the same strain, linear() P_0 of P.
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
