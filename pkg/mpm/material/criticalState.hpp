// SPDX-License-Identifier: GPL-2.0-or-later
// Parameters that laws of critical states share, and what they require.
#pragma once

#include "mpm/material/Material.hpp"
#include "mpm/material/required.hpp"
#include "mpm/material/spareStrength.hpp"

#include <cmath>

namespace mpm {

inline Parameter criticalFriction(double* phi) {
    return {"frictionAngle",
            "rad",
            "required: friction angle at the critical state, triaxial compression",
            phi,
            Range{0, std::acos(-1.0) / 2, true, true},
            {},
            true};
}
// M of triaxial compression.
inline double criticalRatio(double phi) { return 6 * std::sin(phi) / (3 - std::sin(phi)); }

inline Parameter leastPressure(double* p, const char* doc = "mean pressure below which the stiffness stays") {
    return {"smallestPressure", "kPa", doc, p, Range::positive()};
}

// Mean pressure of particle i, compression positive and not below zero.
template <int Dim> double pressureOf(const MaterialPoints<Dim>& points, int i) {
    return std::max(0.0, -(points.stress[0][i] + points.stress[4][i] + points.stress[8][i]) / 3);
}
// Shear stress at the critical state.
template <int Dim> void criticalStrength(double M, const MaterialPoints<Dim>& points, double* strength) {
    for (int i = 0; i < points.count; ++i)
        strength[i] =
            spareStrength(M * pressureOf(points, i) / std::sqrt(3.0), 0, std::sqrt(invariants(points, i).J2));
}
inline double shearModulus(double bulk, double poisson) {
    return 1.5 * bulk * (1 - 2 * poisson) / (1 + poisson);
}
// {lambda, mu}
inline std::array<double, 2> lameOf(double bulk, double poisson) {
    const double mu = shearModulus(bulk, poisson);
    return {bulk - 2.0 / 3 * mu, mu};
}
// Of each particle, from its lameAt(i).
template <int Dim, class Lame>
void fillStiffness(const MaterialPoints<Dim>& points, double* lambda, double* mu, Lame&& lameAt) {
    for (int i = 0; i < points.count; ++i) {
        const std::array<double, 2> now = lameAt(i);
        lambda[i] = now[0];
        mu[i] = now[1];
    }
}

// Density of sand, by the void ratio or by the state parameter.
struct SandDensity {
    static constexpr double least = 0.05;        // void ratio
    double voidRatio = notGiven, psi = notGiven; // psi = e - e_c(p)

    Parameter ratioParameter() {
        return {"initialVoidRatio",
                "-",
                "void ratio of the sand as it is placed; or give stateParameter",
                &voidRatio,
                Range::positive(),
                {},
                false,
                true};
    }
    Parameter stateParameter() {
        return {"stateParameter", "-",
                "psi = e - e_c(p) at the stress that a body is given; not given: by initialVoidRatio", &psi,
                Range{-0.5, 0.5, false, false}};
    }
    void check(const std::string& who, bool varies) const {
        const bool byRatio = !std::isnan(voidRatio) || varies;
        require(byRatio != !std::isnan(psi), who, ": initialVoidRatio and stateParameter ",
                byRatio ? "are both given" : "are both missing", "; give one of them");
    }
    // Void ratio where the critical one is as given; `given`: what the particle has, if any.
    double at(double critical, double given) const {
        return std::isnan(psi) ? given : std::max(critical + psi, least);
    }
    StateVariable variable(double critical) const {
        return {"initialVoidRatio", "-", "void ratio of the sand as it was placed", at(critical, voidRatio)};
    }
};

} // namespace mpm
