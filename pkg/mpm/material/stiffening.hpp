// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic moduli that follow the pressure, for any law with constant ones: StiffeningOf stands between MaterialOf and the
// law, whose equations do not change.
//
// The stress is k times that of the elastic strain with constant moduli, k = P/P0 (PressureDependence). A law with a
// potential knows its strain. Of a law whose stress is the memory the elastic strain is that of sigma/k at the start of
// the step; it then finds the stress with the moduli k C from k times that, where k is the one of the stress that it
// finds: yield, flow and opening are those of the law at the end of the step.
#pragma once

#include "mpm/material/FollowingPressure.hpp"
#include "mpm/material/hypoelastic.hpp"
#include "mpm/material/pressureDependence.hpp"
#include "mpm/material/rootOfFactor.hpp"

namespace mpm {

// A law has
//     std::array<double, 2> moduli() const                                 {lambda, mu}
//     void setModuli(double lambda, double mu)
//     template <int Dim> void respond(const MaterialPoints<Dim>&) const    the stress, with these moduli
// in place of lame() and stress(), lists pressure_.parameters(), and has either the trial stress of hypoelastic.hpp, or
// hasPotential = true and
//     template <int Dim> void linearEnergy(const MaterialPoints<Dim>&, double*) const    by the current volume
// and divides an initial stress by secantAt(stress), for the strain by linearModuli().
template <class Derived> class StiffeningOf : public MaterialOf<Derived>, public FollowingPressure {
  public:
    static constexpr bool hasPotential = false;

    // With a potential the stress comes from the strain in each step.
    bool followsPressure() const override { return pressure_.isGiven() && !Derived::hasPotential; }
    void findFactors(const MaterialPoints<2>& points, double* factor) const override {
        factorsOf(points, factor);
    }
    void findFactors(const MaterialPoints<3>& points, double* factor) const override {
        factorsOf(points, factor);
    }
    void addMean(const MaterialPoints<2>& points, double* change) const override {
        addMeanTo(points, change);
    }
    void addMean(const MaterialPoints<3>& points, double* change) const override {
        addMeanTo(points, change);
    }

    std::array<double, 2> lame() const override {
        return pressure_.isGiven() ? boundAt(energyForm(), 0, 0) : self().moduli();
    }
    template <int N> void stress(const MaterialPoints<N>& points) const {
        if (!pressure_.isGiven()) return self().template respond<N>(points);
        if constexpr (Derived::hasPotential)
            scaleStress(points);
        else
            eachWithItsModuli(points);
    }
    template <int N> void findStiffness(const MaterialPoints<N>& points, double* lambda, double* mu) const {
        const std::array<double, 2> constants = self().moduli();
        std::fill_n(lambda, points.count, constants[0]);
        std::fill_n(mu, points.count, constants[1]);
        if (!pressure_.isGiven()) return;
        const PressureEnergy form = energyForm();
        forSizes(points, [&](int i, double P, double share) {
            const auto its = boundAt(form, P, share);
            lambda[i] = its[0];
            mu[i] = its[1];
        });
    }
    template <int N> void findStoredEnergy(const MaterialPoints<N>& points, double* energy) const {
        if (!pressure_.isGiven()) {
            if constexpr (Derived::hasPotential)
                return self().template linearEnergy<N>(points, energy);
            else
                return MaterialOf<Derived>::template findStoredEnergy<N>(points, energy);
        }
        const PressureEnergy form = energyForm();
        forSizes(points, [&](int i, double P, double) {
            energy[i] = form.density(P);
            if (Derived::hasPotential) energy[i] *= points.initialVolume[i] / points.volume[i];
        });
    }

  protected:
    PressureDependence pressure_;

    // Of the energy W.
    std::array<double, 2> linearModuli() const {
        if (!pressure_.isGiven()) return self().moduli();
        const PressureEnergy form = energyForm();
        return {form.bulk - 2.0 / 3 * form.shear, form.shear};
    }
    // k of a stress.
    double secantAt(const double stress[9]) const {
        if (!pressure_.isGiven()) return 1;
        const double mean = (stress[0] + stress[4] + stress[8]) / 3;
        double square = 0;
        for (int c = 0; c < 9; ++c) square += std::pow(stress[c] - (c % 4 == 0 ? mean : 0), 2);
        const PressureEnergy form = energyForm();
        return form.secantAt(form.size(mean, 0.5 * square));
    }

  private:
    const Derived& self() const { return static_cast<const Derived&>(*this); }
    PressureEnergy energyForm() const {
        const auto [lambda, mu] = self().moduli();
        return {pressure_, lambda + 2.0 / 3 * mu, mu};
    }

    // f(energy with the parameters of particle i, i)
    template <int N, class F> void forForms(const MaterialPoints<N>& points, F&& f) const {
        if (this->outside_.empty()) {
            const PressureEnergy form = energyForm();
            for (int i = 0; i < points.count; ++i) f(form, i);
            return;
        }
        Derived its(self());
        const std::vector<double*> targets = its.targetsOutside();
        double* const* values = points.state + self().stateVariables().size();
        for (int i = 0; i < points.count; ++i) {
            for (size_t k = 0; k < targets.size(); ++k) *targets[k] = values[k][i];
            its.finish();
            f(its.energyForm(), i);
        }
    }
    template <int N> void factorsOf(const MaterialPoints<N>& points, double* factor) const {
        forForms(points, [&](const PressureEnergy& form, int i) {
            const auto [mean, J2] = invariants(points, i);
            factor[i] = form.secantAt(form.size(mean, J2));
        });
    }
    template <int N> void addMeanTo(const MaterialPoints<N>& points, double* change) const {
        forForms(points, [&](const PressureEnergy& form, int i) {
            if (change[i] == 0) return;
            const auto [mean, J2] = invariants(points, i);
            const double k = form.secantAt(form.size(mean, J2)),
                         now = form.secant(form.size(mean / k + change[i], J2 / (k * k)));
            setStress(points, i, plusSpherical(now / k * stressOf(points, i), now * change[i]));
            change[i] /= form.bulk;
        });
    }

    // Lame constants that bound the tangent k C' + (t - k) n n, n along the strain; share: of the deviator in P^2. With
    // x^2 + y^2 = 1 and any split, (x u + y v)^2 <= (x^2 + |x y|) u^2 + (y^2 + |x y|) v^2.
    static std::array<double, 2> boundAt(const PressureEnergy& form, double P, double share) {
        const double t = form.tangent(P), k = form.secantAt(P), both = std::sqrt(share * (1 - share));
        const double mu = (k + (t - k) * (share + both)) * form.shear,
                     K = (k + (t - k) * (1 - share + both)) * form.bulk;
        return {K - 2.0 / 3 * mu, mu};
    }

    template <int N> void scaleStress(const MaterialPoints<N>& points) const {
        const Derived its = linearLaw();
        its.template respond<N>(points);
        const PressureEnergy form = energyForm();
        const std::vector<double> linear = linearSizes(its, form.bulk, points);
        for (int i = 0; i < points.count; ++i)
            setStress(points, i, form.secant(linear[i]) * stressOf(points, i));
    }
    // The law with the constant moduli of W.
    Derived linearLaw() const {
        const auto [lambda, mu] = linearModuli();
        Derived its(self());
        its.pressure_.exponent = 0;
        its.setModuli(lambda, mu);
        return its;
    }
    // P0 of particles with the stress of the linear law.
    template <int N>
    std::vector<double> linearSizes(const Derived& linear, double bulk,
                                    const MaterialPoints<N>& points) const {
        std::vector<double> all(points.count);
        linear.template linearEnergy<N>(points, all.data());
        for (int i = 0; i < points.count; ++i)
            all[i] = std::sqrt(2 * bulk * std::max(0.0, all[i]) * points.volume[i] / points.initialVolume[i]);
        return all;
    }

    template <int N> void eachWithItsModuli(const MaterialPoints<N>& points) const {
        const int count = points.count;
        const std::array<double, 2> C = linearModuli();
        const PressureEnergy form = energyForm();
        const auto sizeOf = [&](const MaterialPoints<N>& of, int i) {
            const auto [mean, J2] = invariants(of, i);
            return form.size(mean, J2);
        };
        std::vector<Symmetric> start(count);
        std::vector<double> factor(count);
        for (int i = 0; i < count; ++i) {
            start[i] = (1 / form.secantAt(sizeOf(points, i))) * stressOf(points, i);
            setStress(points, i, start[i]);
        }
        trialStress(C[0], C[1], points);
        for (int i = 0; i < count; ++i) factor[i] = form.secant(sizeOf(points, i));

        Derived its = linearLaw();
        const size_t states = self().stateVariables().size();
        std::vector<double*> planes(states);
        std::vector<double> before(states);
        for (int i = 0; i < count; ++i) {
            const auto one = points.part(i, i + 1, planes);
            for (size_t s = 0; s < states; ++s) before[s] = *planes[s];
            rootOfFactor(factor[i], form.tangent(0), [&](double k) {
                for (size_t s = 0; s < states; ++s) *planes[s] = before[s];
                setStress(one, 0, k * start[i]);
                its.setModuli(k * C[0], k * C[1]);
                its.template respond<N>(one);
                return form.secant(sizeOf(one, 0) / k);
            });
        }
    }

    // f(i, P, share of the deviator in P^2). With a potential it comes from the strain: the law answers a step of no
    // length.
    template <int N, class F> void forSizes(const MaterialPoints<N>& points, F&& f) const {
        const PressureEnergy form = energyForm();
        const auto give = [&](const auto& its, int i, auto&& pressure) {
            const auto [mean, J2] = invariants(its, i);
            const double P = form.size(mean, J2);
            f(i, pressure(P), P > 0 ? std::min(1.0, form.bulk / form.shear * J2 / (P * P)) : 0);
        };
        if constexpr (!Derived::hasPotential) {
            for (int i = 0; i < points.count; ++i) give(points, i, [](double P) { return P; });
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
            const Derived linear = linearLaw();
            linear.template respond<3>(its);
            const std::vector<double> sizes = linearSizes(linear, form.bulk, its);
            for (int i = 0; i < points.count; ++i)
                give(its, i, [&](double) { return form.pressure(sizes[i]); });
        }
    }
};

} // namespace mpm
