// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic moduli that follow the pressure, for any law with constant ones: StiffeningOf stands between MaterialOf and the
// law, whose equations do not change.
//
// The stress is k times that of the elastic strain with constant moduli, k = P/P0 (PressureDependence). A law with a
// potential knows its strain. Of a law whose stress is the memory the elastic strain is that of sigma/k at the start of
// the step; it then finds the stress with the moduli k C from k times that, where k is the one of the stress that it
// finds: yield, flow and opening are those of the law at the end of the step.
#pragma once

#include "mpm/material/AskedAgain.hpp"
#include "mpm/material/FollowingPressure.hpp"
#include "mpm/material/Moduli.hpp"
#include "mpm/material/RootOfFactor.hpp"
#include "mpm/material/pressureDependence.hpp"

#include <numeric>

namespace mpm {

// A law has
//     std::array<double, 2> moduli() const                                 {lambda, mu}
// in place of lame(), lists pressure_.parameters(), and has in place of stress() either, with the trial stress of
// hypoelastic.hpp from rates, stress and state alone,
//     template <int Dim, class Number> void respond(const MaterialPoints<Dim>&, const Moduli<Number>&) const
// or hasPotential = true and
//     void setModuli(double lambda, double mu)
//     template <int Dim> void respond(const MaterialPoints<Dim>&) const    the stress, with moduli()
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
    bool findReached(const MaterialPoints<2>& points, double* now, double* strain) const override {
        return reached(points, now, strain);
    }
    bool findReached(const MaterialPoints<3>& points, double* now, double* strain) const override {
        return reached(points, now, strain);
    }

    std::array<double, 2> lame() const override {
        return pressure_.isGiven() ? boundAt(energyForm(), 0, 0) : self().moduli();
    }
    template <int N> void stress(const MaterialPoints<N>& points) const {
        if constexpr (Derived::hasPotential)
            pressure_.isGiven() ? scaleStress(points) : self().template respond<N>(points);
        else
            pressure_.isGiven() ? findRoots(points) : self().respond(points, self().constants());
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

    Moduli<double> constants() const {
        const auto [lambda, mu] = self().moduli();
        return {lambda, mu, lambda + 2.0 / 3.0 * mu};
    }
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

    template <int N> bool reached(const MaterialPoints<N>& points, double* now, double* strain) const {
        if (this->outside_.empty()) {
            if (pressure_.isGiven()) findReachedAlike(points, now, strain);
            return pressure_.isGiven();
        }
        Derived its(self());
        const std::vector<double*> targets = its.targetsOutside();
        double* const* values = points.state + self().stateVariables().size();
        std::vector<double*> planes(self().stateVariables().size() + targets.size());
        for (int i = 0; i < points.count; ++i) {
            for (size_t k = 0; k < targets.size(); ++k) *targets[k] = values[k][i];
            its.finish();
            its.StiffeningOf::findReachedAlike(points.part(i, i + 1, planes), now + i, strain + i);
        }
        return true;
    }
    // P0 is a norm of the elastic strain: it gains at most that of the strain that is added, and flow takes some away.
    template <int N>
    void findReachedAlike(const MaterialPoints<N>& points, double* now, double* strain) const {
        const PressureEnergy form = energyForm();
        const double stretched = std::sqrt(form.bulk * (form.bulk + 4.0 / 3 * form.shear));
        forSizes(points, [&](int i, double P, double) {
            now[i] = form.bulk * form.tangent(P);
            strain[i] = form.bulk * form.tangent(form.pressure(form.linear(P) + stretched * strain[i]));
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

    // The law answers all particles at once with the factors of their trial stress, then those again whose factors these
    // are not. A step that is elastic takes one answer.
    template <int N> void findRoots(const MaterialPoints<N>& points) const {
        const size_t count = points.count;
        const PressureEnergy form = energyForm();
        const auto sizeOf = [&](const MaterialPoints<N>& of, int i) {
            const auto [mean, J2] = invariants(of, i);
            return form.size(mean, J2);
        };
        std::vector<Symmetric> start(count);
        for (size_t i = 0; i < count; ++i) {
            start[i] = (1 / form.secantAt(sizeOf(points, i))) * stressOf(points, i);
            setStress(points, i, start[i]);
        }
        const double mu = form.shear, lambda = form.bulk - 2.0 / 3 * mu;
        trialStress(lambda, mu, points);
        std::vector<RootOfFactor> roots;
        roots.reserve(count);
        for (size_t i = 0; i < count; ++i)
            roots.emplace_back(form.secant(sizeOf(points, i)), form.tangent(0));

        std::vector<int> left(count);
        std::iota(left.begin(), left.end(), 0);
        std::vector<double> lambdas(count), mus(count), bulks(count);
        AskedAgain<N> again(points, self().stateVariables().size());
        for (bool isFirst = true; !left.empty(); isFirst = false) {
            const MaterialPoints<N>& its = isFirst ? points : again.pick(left);
            for (int j = 0; j < its.count; ++j) {
                const double k = roots[left[j]].factor();
                setStress(its, j, k * start[left[j]]);
                lambdas[j] = k * lambda;
                mus[j] = k * mu;
                bulks[j] = k * form.bulk;
            }
            self().respond(its, Moduli<const double*>{lambdas.data(), mus.data(), bulks.data()});
            size_t kept = 0;
            for (int j = 0; j < its.count; ++j) {
                const int i = left[j];
                if (!roots[i].endsWith(form.secant(sizeOf(its, j) / roots[i].factor())))
                    left[kept++] = i;
                else if (!isFirst)
                    again.giveBack(j, i);
            }
            left.resize(kept);
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
