// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic moduli that follow the pressure, for any law with constant ones: StiffeningOf stands between MaterialOf and the
// law, whose equations do not change.
//
// A law with a potential W(strain) gets the potential Phi(W), hence its stress times Phi'(W): closed cycles leave no
// energy (as Houlsby, Amorosi & Rojas 2005, Geotechnique 55, 383-392). A law whose stress is the memory is hypoelastic,
// with moduli of each step; where the shear stress goes at another pressure than it came at, a closed cycle makes or
// loses energy (Zytynski et al. 1978, Int. J. Numer. Anal. Methods Geomech. 2, 87-93).
#pragma once

#include "mpm/material/FollowingPressure.hpp"
#include "mpm/material/Material.hpp"
#include "mpm/material/pressureDependence.hpp"

namespace mpm {

// Volumetric strain of particle i in the step, dilation positive: tr [g (I + g/2)^-1] with g = dt L, as hypoelastic trial
// stresses have it.
template <int N> double volumetricStrain(const MaterialPoints<N>& points, int i) {
    double h[9] = {};
    for (int j = 0; j < N; ++j)
        for (int k = 0; k < N; ++k) h[3 * j + k] = 0.5 * points.dt * points.velocityGradient[N * j + k][i];
    if (N == 2 && points.hoopRate) h[8] = 0.5 * points.dt * points.hoopRate[i];
    const double first = h[0] + h[4] + h[8], xx = h[4] * h[8] - h[5] * h[7],
                 second = h[0] * h[4] - h[1] * h[3] + h[0] * h[8] - h[2] * h[6] + xx,
                 third = h[0] * xx - h[1] * (h[3] * h[8] - h[5] * h[6]) + h[2] * (h[3] * h[7] - h[4] * h[6]);
    return 2 * (first + 2 * second + 3 * third) / (1 + first + second + third);
}

// A law has
//     std::array<double, 2> moduli() const                                 {lambda, mu}
//     template <int Dim> void respond(const MaterialPoints<Dim>&) const    the stress, with these moduli
// in place of lame() and stress(), lists pressure_.parameters(), and has either
//     void setModuli(double lambda, double mu)
// or hasPotential = true and
//     template <int Dim> void linearEnergy(const MaterialPoints<Dim>&, double*) const    by the current volume
// and divides an initial stress by secantAt(stress).
template <class Derived> class StiffeningOf : public MaterialOf<Derived>, public FollowingPressure {
  public:
    static constexpr bool hasPotential = false;

    // With a potential the stress comes from the strain in each step.
    bool followsPressure() const override { return pressure_.isGiven() && !Derived::hasPotential; }
    std::array<double, 2> lame() const override {
        const double factor = pressure_.isGiven() ? pressure_.tangent(0) : 1;
        return {factor * self().moduli()[0], factor * self().moduli()[1]};
    }
    template <int N> void stress(const MaterialPoints<N>& points) const {
        if (!pressure_.isGiven()) return self().template respond<N>(points);
        if constexpr (Derived::hasPotential)
            scaleStress(points);
        else
            eachWithItsModuli(points);
    }
    // Of each particle at its present pressure. With a potential no direction is stiffer: across the stress the secant
    // acts, which is at most the tangent.
    template <int N> void findStiffness(const MaterialPoints<N>& points, double* lambda, double* mu) const {
        const std::array<double, 2> moduli = self().moduli();
        std::fill_n(lambda, points.count, moduli[0]);
        std::fill_n(mu, points.count, moduli[1]);
        if (!pressure_.isGiven()) return;
        const std::vector<double> pressure = pressures(points);
        for (int i = 0; i < points.count; ++i) {
            const double factor = pressure_.tangent(pressure[i]);
            lambda[i] *= factor;
            mu[i] *= factor;
        }
    }
    template <int N> void findStoredEnergy(const MaterialPoints<N>& points, double* energy) const {
        if (!pressure_.isGiven()) {
            if constexpr (Derived::hasPotential)
                return self().template linearEnergy<N>(points, energy);
            else
                return MaterialOf<Derived>::template findStoredEnergy<N>(points, energy);
        }
        const std::vector<double> pressure = pressures(points);
        for (int i = 0; i < points.count; ++i) {
            energy[i] = pressure_.energy(bulk(), pressure[i]);
            if (Derived::hasPotential)
                energy[i] *= points.initialVolume[i] / points.volume[i];
            else
                energy[i] += 0.5 * invariants(points, i).J2 / (pressure_.tangent(pressure[i]) * shear());
        }
    }

  protected:
    PressureDependence pressure_;

    // Factor on the moduli of particle i in the step; points still have the stress at its start.
    template <int N> double factorOf(const MaterialPoints<N>& points, int i) const {
        if (!pressure_.isGiven()) return 1;
        return pressure_.overStep(bulk(), -invariants(points, i).mean, -volumetricStrain(points, i));
    }
    // The factor P/P_0 that is in this stress, of a law with a potential.
    double secantAt(const double stress[9]) const {
        if (!pressure_.isGiven()) return 1;
        const double mean = (stress[0] + stress[4] + stress[8]) / 3;
        double square = 0;
        for (int c = 0; c < 9; ++c) square += std::pow(stress[c] - (c % 4 == 0 ? mean : 0), 2);
        return secant(pressure_.linear(bulk(), std::sqrt(mean * mean + 0.5 * square * bulk() / shear())));
    }

  private:
    const Derived& self() const { return static_cast<const Derived&>(*this); }
    double shear() const { return self().moduli()[1]; }
    double bulk() const { return self().moduli()[0] + 2.0 / 3 * self().moduli()[1]; }
    double secant(double linear) const {
        return linear > 0 ? pressure_.pressure(bulk(), linear) / linear : pressure_.tangent(0);
    }

    template <int N> void eachWithItsModuli(const MaterialPoints<N>& points) const {
        Derived its(self());
        its.pressure_.exponent = 0;
        std::vector<double*> planes(self().stateVariables().size());
        for (int i = 0; i < points.count; ++i) {
            const double factor = factorOf(points, i);
            its.setModuli(factor * self().moduli()[0], factor * self().moduli()[1]);
            its.template respond<N>(points.part(i, i + 1, planes));
        }
    }
    template <int N> void scaleStress(const MaterialPoints<N>& points) const {
        self().template respond<N>(points);
        const std::vector<double> linear = linearPressures(points);
        for (int i = 0; i < points.count; ++i) {
            const double factor = secant(linear[i]);
            for (int c : {0, 1, 3, 4, 8}) points.stress[c][i] *= factor;
            if (N == 3)
                for (int c : {2, 5, 6, 7}) points.stress[c][i] *= factor;
        }
    }
    // P_0 of particles with the stress of the law itself.
    template <int N> std::vector<double> linearPressures(const MaterialPoints<N>& points) const {
        std::vector<double> all(points.count);
        self().template linearEnergy<N>(points, all.data());
        for (int i = 0; i < points.count; ++i)
            all[i] =
                std::sqrt(2 * bulk() * std::max(0.0, all[i]) * points.volume[i] / points.initialVolume[i]);
        return all;
    }
    // The pressure that the moduli of each particle follow. With a potential it comes from the strain: the law answers a
    // step of no length.
    template <int N> std::vector<double> pressures(const MaterialPoints<N>& points) const {
        std::vector<double> all(points.count);
        if constexpr (!Derived::hasPotential) {
            for (int i = 0; i < points.count; ++i) all[i] = -invariants(points, i).mean;
        } else {
            const std::vector<double> none(points.count, 0.0);
            std::vector<double> stress(9 * size_t(points.count), 0.0);
            MaterialPoints<3> its{};
            its.count = points.count;
            its.body = points.body;
            its.id = points.id;
            its.hasFbar = points.hasFbar;
            its.volume = points.volume;
            its.initialVolume = points.initialVolume;
            its.state = points.state;
            for (auto& plane : its.position) plane = none.data();
            for (int c = 0; c < 9; ++c) {
                its.velocityGradient[c] = none.data();
                its.deformationGradient[c] = points.deformationGradient[c];
                its.stress[c] = &stress[c * size_t(points.count)];
            }
            self().template respond<3>(its);
            all = linearPressures(its);
            for (double& p : all) p = pressure_.pressure(bulk(), p);
        }
        return all;
    }
};

} // namespace mpm
