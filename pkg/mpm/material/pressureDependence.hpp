// SPDX-License-Identifier: GPL-2.0-or-later
// An option of laws with constant elastic moduli: E = E_ref (p/p_ref)^m, of the pressure at the start of a step. A run is
// then treated particle by particle, each with moduli of its own.
#pragma once

#include "mpm/material/Material.hpp"

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
    // What the moduli are multiplied by at a mean stress.
    double factor(double mean) const {
        return isGiven() ? std::pow(std::max(-mean, smallest) / reference, exponent) : 1;
    }
    template <int Dim>
    void find(const std::array<double, 2>& lame, const MaterialPoints<Dim>& points, double* lambda,
              double* mu) const {
        for (int i = 0; i < points.count; ++i) {
            const double its = factor(invariants(points, i).mean);
            lambda[i] = its * lame[0];
            mu[i] = its * lame[1];
        }
    }
    // f(factor, points) for all at once where the moduli are constant, else for each particle.
    template <int Dim, class F> void forEach(int states, const MaterialPoints<Dim>& points, F&& f) const {
        if (!isGiven()) return f(1.0, points);
        std::vector<double*> planes(states);
        for (int i = 0; i < points.count; ++i)
            f(factor(invariants(points, i).mean), points.part(i, i + 1, planes));
    }
};

} // namespace mpm
