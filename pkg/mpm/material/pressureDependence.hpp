// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic moduli over the pressure, from an energy (Houlsby, Amorosi & Rojas 2005, Geotechnique 55, 383-392). With the
// elastic strain e, W(e) the energy of constant moduli K, G/(1 - m) and P0 = sqrt(2 K W), the stress is that of the
// constant moduli times P/P0, where dP/dP0 = (P/p_ref)^m. P is sqrt(p^2 + (1 - m) K J2/G). At isotropic stress K and G
// are then the given ones times (p/p_ref)^m; where m is 1, the form has no strain at p = 0, and G is so at p_ref.
// Pressure is positive in compression here.
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

    // Of a law that has its stress alone, and no energy: the factor on its moduli at a pressure, and in a step from p with
    // the elastic volumetric strain e, by what the pressure gains over bulk e.
    double power(double p) const { return law().stiffness(p); }
    double overStep(double bulk, double p, double e) const {
        const PressureStiffness its{bulk, reference, exponent, smallest};
        if (e == 0) return power(p);
        if (p <= smallest && its.strain(p) + e <= 0) return power(0);
        const double part = 1 - exponent, gain = its.stiffness(p) * e / p;
        if (p > smallest && part * gain > -1) { // the form without cancellation
            const double grown = std::expm1(part == 0 ? gain : std::log1p(part * gain) / part);
            if (p * (1 + grown) >= smallest) return p * grown / (bulk * e);
        }
        return (its.pull(its.strain(p) + e) - p) / (bulk * e);
    }

  private:
    PressureStiffness law() const { return {1, reference, exponent, smallest}; }
};

// The energy of a law with the moduli K and G. shear: G' of W.
class PressureEnergy {
  public:
    double bulk, shear;

    PressureEnergy(const PressureDependence& given, double K, double G)
        : bulk(K), law_{1, given.reference, given.exponent, given.smallest},
          rise_((given.exponent == 1 ? 1 : 1 - given.exponent) * law_.stiffness(0) / given.smallest),
          core_(std::max(1 - given.exponent, softest) * law_.stiffness(0)), end_(given.smallest / core_) {
        const double P = std::max(given.reference, given.smallest);
        shear = tangent(P) / secant(linear(P)) * G;
    }

    // P of a stress, P0 of one of constant moduli, by its mean and J2.
    double size(double mean, double J2) const { return std::sqrt(mean * mean + bulk / shear * J2); }
    double tangent(double P) const { // dP/dP0
        return P < law_.smallest ? core_ : raised(P / law_.reference, law_.power);
    }
    double pressure(double P0) const {
        if (P0 < end_) return core_ * P0;
        const double rise = rise_ * (P0 - end_);
        return law_.smallest * (law_.power == 1 ? std::exp(rise) : raised(1 + rise, 1 / (1 - law_.power)));
    }
    double linear(double P) const { // P0
        if (P < law_.smallest) return P / core_;
        const double ratio = P / law_.smallest;
        return end_ + (law_.power == 1 ? std::log(ratio) : raised(ratio, 1 - law_.power) - 1) / rise_;
    }
    double secant(double P0) const { return P0 > 0 ? pressure(P0) / P0 : core_; }
    double secantAt(double P) const { return P > 0 ? P / linear(P) : core_; }
    double density(double P) const { // of energy: the integral of P dP0/K
        const double least = std::min(P, law_.smallest);
        return (law_.energy(P) + 0.5 * least * (least / core_ - least / law_.stiffness(0))) / bulk;
    }

  private:
    // The power law has 1/(1 - m) of the strain up to the smallest pressure that its modulus there tells, and so has the
    // line that stands for it. Near m = 1 the line is no softer than this: with half and twice of it, G at m = 1 is
    // off its power by 10 and 31 % at p_ref/10 (19 %).
    static constexpr double softest = 0.1;
    PressureStiffness law_;
    double rise_;       // how fast (P/smallest)^(1 - m), of m = 1 its logarithm, grows with P0
    double core_, end_; // modulus of the line, and P0 at its end

    // std::pow costs as much as a law, and sand has m = 1/2.
    static double raised(double x, double power) {
        return power == 0.5 ? std::sqrt(x) : power == 2 ? x * x : std::pow(x, power);
    }
};

} // namespace mpm
