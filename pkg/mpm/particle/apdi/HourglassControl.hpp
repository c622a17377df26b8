// SPDX-License-Identifier: GPL-2.0-or-later
// Forces against the hourglass patterns of the vertices, which the averaged gradient of a domain does not
// see: the stiffness form of Flanagan & Belytschko 1981,
//     f_a = -k h gamma_a,   gamma_a = G_a / 2^Dim - g_a . (pattern of X),
//     k = coefficient (2/3)(lambda + 3 mu) V sum |g|^2,
// so that it does no work in a linear field. With coefficient 1 a square is as stiff against the pattern as
// the exactly integrated bilinear element. What is resisted is the pattern of the domain less that of the
// undeformed one, deformed. Soil that yields bears no more: the stress of the pattern, k |h| / (V sqrt(sum |g|^2)),
// stays below a part of the shear strength, else the load of a footing would grow with the elastic modulus.
#pragma once

#include "mpm/particle/apdi/DomainMesh.hpp"
#include "mpm/state/Particles.hpp"

namespace mpm {

template <int Dim> class HourglassControl {
  public:
    using Shapes = BatchShapes<Dim>;
    static constexpr int NC = corners<Dim>, modes = Shapes::modes;
    using Forces = double[modes][Dim][Batch<Dim>::most]; // of a batch, times gamma

    // Part of the shear strength: soil ten times as stiff then carries the same footing (a part of 1: 1.4 % more,
    // without a limit 11 %).
    static constexpr double bearable = 0.3;
    // Part of the elastic stiffness that stays where soil bears nothing, so that its patterns do not drift.
    static constexpr double leastShare = 0.02;

    explicit HourglassControl(double coefficient) : coefficient_(coefficient) {}

    Field reference{"hourglassReference", "m", "Hourglass pattern of the undeformed domain.", {modes, Dim}};

    // Of domain p, undeformed with the corners X; what is round-off is zero, for parallelograms have no
    // pattern.
    void setReference(int p, const Corners<Dim>& X) {
        const HourglassAmplitude<Dim> h = hourglassPattern<Dim>(X);
        const double roundOff = 4 * std::numeric_limits<double>::epsilon() * X.cwiseAbs().maxCoeff();
        for (int i = 0; i < h.size(); ++i)
            if (std::abs(h.data()[i]) > roundOff) reference.plane(i)[p] = h.data()[i];
    }

    void restored() {
        isPatterned_ = false;
        for (int i = 0; i < reference.components(); ++i)
            isPatterned_ |= std::any_of(reference.plane(i), reference.plane(i) + reference.size(),
                                        [](double h) { return h != 0; });
    }
    bool isPatterned() const { return isPatterned_; } // any undeformed domain

    // What the deformation makes of the patterns of the undeformed domains.
    struct DeformedPattern {
        const double *F[Dim][Dim], *pattern[modes][Dim];

        DeformedPattern(const HourglassControl& control, const Particles<Dim>& particles) {
            for (int i = 0; i < Dim; ++i) {
                for (int j = 0; j < Dim; ++j) F[i][j] = particles.deformationGradient.plane(3 * i + j);
                for (int m = 0; m < modes; ++m) pattern[m][i] = control.reference.plane(Dim * m + i);
            }
        }
        MPM_INLINE void takeFrom(double (*h)[Dim], int p) const {
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) MPM_UNROLL
            for (int i = 0; i < Dim; ++i) {
                double sum = 0;
                MPM_UNROLL
                for (int j = 0; j < Dim; ++j) sum += F[i][j][p] * pattern[m][j][p];
                h[m][i] -= sum;
            }
        }
    };

    // What a linear field does not show of pattern m at corner a.
    MPM_INLINE static double gamma(const Shapes& d, int m, int a, int p) {
        double sum = hourglassSign(Dim, m, a) / NC;
        MPM_UNROLL
        for (int j = 0; j < Dim; ++j) sum -= d.g[a][j][p] * d.pattern[m][j][p];
        return sum;
    }

    void resize(int domains) {
        modulus_.resize(domains);
        limit_.resize(domains);
    }

    // Of domains [begin, end), whose material is asked once per step: a call for every batch takes 6 % of it.
    template <class Stiffness, class Strength>
    void takeStiffness(int begin, int end, const Stiffness& stiffness, const Strength& strength) {
        double lambda[chunkSize], mu[chunkSize];
        stiffness(begin, end, lambda, mu);
        strength(begin, end, limit_.data() + begin);
        for (int p = begin; p < end; ++p) {
            modulus_[p] = coefficient_ * (2.0 / 3.0) * (lambda[p - begin] + 3 * mu[p - begin]);
            limit_[p] *= bearable;
        }
    }

    // Against each pattern of domain p, kN/m (2D: per m).
    double stiffnessOf(int p, const ClosedShape<Dim>& shape) const {
        double sum = 0;
        for (int a = 0; a < NC; ++a)
            for (int k = 0; k < Dim; ++k) sum += shape.g[a][k] * shape.g[a][k];
        return modulus_[p] * shape.volume * sum;
    }
    static double gamma(const ClosedShape<Dim>& shape, int m, int a) {
        double sum = hourglassSign(Dim, m, a) / NC;
        for (int j = 0; j < Dim; ++j) sum -= shape.g[a][j] * shape.pattern[m][j];
        return sum;
    }

    // The forces of a batch. h, per mode and axis, is what they resist: the pattern of a domain, which
    // resisted(p, h) may change.
    template <class Resisted>
    void resist(const Batch<Dim>& batch, const Shapes& d, Forces& forces, Resisted&& resisted) const {
        const double *modulus = modulus_.data() + batch.first, *limit = limit_.data() + batch.first;
        auto one = [&](int p) MPM_INLINE_LAMBDA {
            double h[modes][Dim], sum = 0;
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) MPM_UNROLL
            for (int k = 0; k < Dim; ++k) h[m][k] = d.pattern[m][k][p];
            resisted(p, h);
            MPM_UNROLL
            for (int a = 0; a < NC; ++a) MPM_UNROLL
            for (int k = 0; k < Dim; ++k) sum += d.g[a][k][p] * d.g[a][k][p];
            double square = 0;
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) MPM_UNROLL
            for (int k = 0; k < Dim; ++k) square += h[m][k] * h[m][k];
            const double stress = modulus[p] * std::sqrt(sum * square);
            const double most = std::max(limit[p], leastShare * stress);
            const double share = stress > most ? most / stress : 1.0;
            const double stiffness = share * modulus[p] * d.volume[p] * sum;
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) MPM_UNROLL
            for (int k = 0; k < Dim; ++k) forces[m][k][p] = -stiffness * h[m][k];
        };
        forEachSimd(batch.count, one);
    }

    // How far domain p is from a linear deformation: of each pattern and axis, m.
    HourglassAmplitude<Dim> amplitude(const DomainMesh<Dim>& mesh, const DeformedPattern& deformed,
                                      int p) const {
        HourglassAmplitude<Dim> h = hourglassPattern<Dim>(mesh.cornersOf(p));
        deformed.takeFrom(reinterpret_cast<double(*)[Dim]>(h.data()), p);
        return h;
    }
    // Largest hourglass amplitude over the mean edge of its domain.
    double largestAmplitude(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles) const {
        double largest = 0; // its 2 Dim-th power: no root in the loop
        const DeformedPattern deformed(*this, particles);
        for (int p = 0; p < particles.size(); ++p) {
            const HourglassAmplitude<Dim> h = amplitude(mesh, deformed, p);
            const double square = h.colwise().squaredNorm().maxCoeff();
            const double volume = particles.volume.plane()[p];
            largest = std::max(largest, (Dim == 2 ? 1 : square) * square * square / (volume * volume));
        }
        return std::pow(largest, 0.5 / Dim);
    }

    // Work that bringing the patterns of domains [begin, end) to where they are takes, kJ; their stiffness and
    // strength as last taken.
    double energy(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles, int begin, int end) const {
        const DeformedPattern deformed(*this, particles);
        double total = 0;
        for (int p = begin; p < end; ++p) {
            const HourglassAmplitude<Dim> h = amplitude(mesh, deformed, p);
            const Shape<Dim> shape(numbersOf<Dim>(mesh.cornersOf(p)));
            double sum = 0;
            for (const Vec<Dim>& g : shape.g) sum += g.squaredNorm();
            total += shape.volume * energyDensity(p, std::sqrt(sum * h.squaredNorm()));
        }
        return total;
    }

  private:
    // The stress of the pattern grows with its strain up to the limit, stays there, and grows on where a part
    // of the elastic stress exceeds it.
    double energyDensity(int p, double strain) const {
        const double M = modulus_[p];
        if (!(M > 0)) return 0;
        const double first = std::min(strain, limit_[p] / M);
        const double second = std::clamp(limit_[p] / (leastShare * M), first, strain);
        return 0.5 * M * first * first + (second > first ? limit_[p] * (second - first) : 0) +
               0.5 * leastShare * M * (strain * strain - second * second);
    }

    const double coefficient_;
    std::vector<double> modulus_; // kPa
    std::vector<double> limit_;   // kPa, of the stress against the patterns
    bool isPatterned_ = true;
};

} // namespace mpm
