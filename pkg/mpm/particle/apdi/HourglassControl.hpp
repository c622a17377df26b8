// SPDX-License-Identifier: GPL-2.0-or-later
// Forces against the hourglass patterns of the vertices, which the averaged gradient of a domain does not
// see: the stiffness form of Flanagan & Belytschko 1981, from an energy,
//     U = 1/2 sum_m k_m |h_m|^2,   k_m = coefficient (2/3)(E/(1 - nu^2) + mu) V q_m,
//     f_a = -sum_m k_m h_m gamma_am.
// h is the pattern of the domain less that of the undeformed one, deformed; its rate is sum_a gamma_am v_a,
// and the vertices get the work that U loses:
//     h_m = pattern_m(X) - F pattern_m(X0),   gamma_am = G_am / 2^Dim - g_a . F pattern_m(X0).
// V and the steepness q_m are those of the undeformed domain. A pattern is bending: across it the domain is free
// of stress, as a plate is. With lambda + 2 mu in place of E/(1 - nu^2) = 4 mu (lambda + mu)/(lambda + 2 mu) a
// square would, with coefficient 1, be the exactly integrated bilinear element, which locks near
// incompressibility. q makes a cube as stiff against the patterns of its faces, so that plane strain is a slab
// between rollers. Soil that yields bears no more: the stress of the
// patterns, k |h| / (V sqrt(q)), stays below a part of the strength that the material has beside its stress
// (material/spareStrength.hpp), else the load of a footing would grow with the elastic modulus.
#pragma once

#include "mpm/particle/apdi/DomainMesh.hpp"
#include "mpm/state/Particles.hpp"

namespace mpm {

template <int Dim> class HourglassControl {
  public:
    static constexpr int NC = corners<Dim>, modes = hourglassModes<Dim>;

    // Part of the shear strength: soil ten times as stiff then carries the same footing (a part of 1: 1.4 % more,
    // without a limit 11 %).
    static constexpr double bearable = 0.3;

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

    template <bool isRound> void restored(const DomainMesh<Dim>& mesh) {
        const int domains = mesh.domains();
        isPatterned_ = false;
        for (int i = 0; i < reference.components(); ++i)
            isPatterned_ |= std::any_of(reference.plane(i), reference.plane(i) + reference.size(),
                                        [](double h) { return h != 0; });
        modulus_.resize(domains);
        limit_.resize(domains);
        volume_.resize(domains);
        steepness_.resize(domains);
        for (int p = 0; p < domains; ++p) {
            const DomainShape<Dim, isRound> shape(numbersOf<Dim>(mesh.cornersOf(p, mesh.vertices.reference)));
            volume_[p] = shape.volume;
            for (int m = 0; m < modes; ++m) steepness_.plane(m)[p] = shape.steepness[m];
        }
    }
    bool isPatterned() const { return isPatterned_; } // any undeformed domain
    size_t bytes() const {
        return reference.bytes() + steepness_.bytes() + 3 * volume_.size() * sizeof(double);
    }

    // What the deformation makes of the patterns of the undeformed domains.
    struct DeformedPattern {
        const double *F[Dim][Dim], *pattern[modes][Dim];

        DeformedPattern(const HourglassControl& control, const Particles<Dim>& particles) {
            for (int i = 0; i < Dim; ++i) {
                for (int j = 0; j < Dim; ++j) F[i][j] = particles.deformationGradient.plane(3 * i + j);
                for (int m = 0; m < modes; ++m) pattern[m][i] = control.reference.plane(Dim * m + i);
            }
        }
        MPM_INLINE double at(int m, int i, int p) const {
            double sum = 0;
            MPM_UNROLL
            for (int j = 0; j < Dim; ++j) sum += F[i][j][p] * pattern[m][j][p];
            return sum;
        }
    };

    // Of a batch: the patterns of the undeformed domains, deformed (empty where there are none), and the
    // forces against h, times gamma.
    struct alignas(64) OfBatch {
        static constexpr int most = Batch<Dim>::most;
        double undeformed[modes][Dim][most], force[modes][Dim][most];

        void take(const Batch<Dim>& batch, const DeformedPattern& deformed) {
            auto one = [&](int p) MPM_INLINE_LAMBDA {
                MPM_UNROLL
                for (int m = 0; m < modes; ++m) MPM_UNROLL
                for (int k = 0; k < Dim; ++k) undeformed[m][k][p] = deformed.at(m, k, batch.first + p);
            };
            forEachSimd(batch.count, one);
        }
        template <bool isPatterned, class Shapes>
        MPM_INLINE double gamma(const Shapes& d, int m, int a, int p) const {
            double sum = hourglassSign(Dim, m, a) / NC;
            if constexpr (isPatterned) {
                MPM_UNROLL
                for (int j = 0; j < Dim; ++j) sum -= d.g[a][j][p] * undeformed[m][j][p];
            }
            return sum;
        }
    };

    // Of domains [begin, end), whose material is asked once per step: a call for every batch takes 6 % of it.
    template <class Stiffness, class Strength>
    void takeStiffness(int begin, int end, const Stiffness& stiffness, const Strength& strength) {
        double lambda[chunkSize], mu[chunkSize];
        stiffness(begin, end, lambda, mu);
        strength(begin, end, limit_.data() + begin);
        for (int p = begin; p < end; ++p) {
            const double l = lambda[p - begin], G = mu[p - begin];
            const double bending = G > 0 ? 4 * G * (l + G) / (l + 2 * G) : 0.0;
            modulus_[p] = coefficient_ * (2.0 / 3.0) * (bending + G);
            limit_[p] *= bearable;
        }
    }

    // The forces of a batch against the patterns as they are.
    template <bool isPatterned, class Shapes>
    void resist(const Batch<Dim>& batch, const Shapes& d, OfBatch& out) const {
        const Constants c(*this, batch.first);
        const double* limit = limit_.data() + batch.first;
        auto one = [&](int p) MPM_INLINE_LAMBDA {
            double h[modes][Dim], square = 0; // of the strain of the patterns
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) {
                double sum = 0;
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) {
                    h[m][k] = d.pattern[m][k][p];
                    if constexpr (isPatterned) h[m][k] -= out.undeformed[m][k][p];
                    sum += h[m][k] * h[m][k];
                }
                square += c.steepness[m][p] * sum;
            }
            const double stress = c.modulus[p] * std::sqrt(square);
            const double share = stress > limit[p] ? limit[p] / stress : 1.0;
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) {
                const double k = share * c.stiffness(m, p);
                MPM_UNROLL
                for (int i = 0; i < Dim; ++i) out.force[m][i][p] = -k * h[m][i];
            }
        };
        forEachSimd(batch.count, one);
    }

    // Those against the rates of the patterns over unit time, without a limit; V: velocities at the corners.
    template <bool isPatterned, class Shapes, int n>
    void resistRates(const Batch<Dim>& batch, const Shapes& d, const AtCorners<Dim, n>& V,
                     OfBatch& out) const {
        const Constants c(*this, batch.first);
        for (int p = 0; p < batch.count; ++p)
            for (int m = 0; m < modes; ++m)
                for (int k = 0; k < Dim; ++k) {
                    double rate = 0;
                    for (int a = 0; a < NC; ++a)
                        rate += out.template gamma<isPatterned>(d, m, a, p) * V.x[a][k][p];
                    out.force[m][k][p] = -c.stiffness(m, p) * rate;
                }
    }

    // k of pattern m of domain p, kN/m (2D: per m), and what the velocity of corner a gives to the rate of h.
    double stiffnessOf(int p, int m) const { return Constants(*this, p).stiffness(m, 0); }
    template <class Closed>
    double gammaOf(const Closed& shape, const DeformedPattern& deformed, int p, int m, int a) const {
        double sum = hourglassSign(Dim, m, a) / NC;
        for (int j = 0; j < Dim; ++j) sum -= shape.g[a][j] * deformed.at(m, j, p);
        return sum;
    }

    // How far domain p is from a linear deformation: of each pattern and axis, m.
    HourglassAmplitude<Dim> amplitude(const DomainMesh<Dim>& mesh, const DeformedPattern& deformed,
                                      int p) const {
        HourglassAmplitude<Dim> h = hourglassPattern<Dim>(mesh.cornersOf(p));
        for (int m = 0; m < modes; ++m)
            for (int k = 0; k < Dim; ++k) h(k, m) -= deformed.at(m, k, p);
        return h;
    }
    // Largest hourglass amplitude over the mean edge of its domain.
    double largestAmplitude(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles,
                            const Grid<Dim>& grid) const {
        double largest = 0; // its 2 Dim-th power: no root in the loop
        const DeformedPattern deformed(*this, particles);
        for (int p = 0; p < particles.size(); ++p) {
            const HourglassAmplitude<Dim> h = amplitude(mesh, deformed, p);
            const double square = h.colwise().squaredNorm().maxCoeff();
            const double volume =
                particles.volume.plane()[p] / grid.thicknessAt(particles.position.plane(0)[p]);
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
            double square = 0;
            for (int m = 0; m < modes; ++m) square += steepness_.plane(m)[p] * h.col(m).squaredNorm();
            total += volume_[p] * energyDensity(p, std::sqrt(square));
        }
        return total;
    }

  private:
    // Of domains from `first` on.
    struct Constants {
        const double *modulus, *volume, *steepness[modes];

        Constants(const HourglassControl& of, int first)
            : modulus(of.modulus_.data() + first), volume(of.volume_.data() + first) {
            for (int m = 0; m < modes; ++m) steepness[m] = of.steepness_.plane(m) + first;
        }
        MPM_INLINE double stiffness(int m, int p) const { return modulus[p] * volume[p] * steepness[m][p]; }
    };

    // The stress of the pattern grows with its strain up to the limit and stays there.
    double energyDensity(int p, double strain) const {
        const double M = modulus_[p];
        if (!(M > 0)) return 0;
        const double first = std::min(strain, limit_[p] / M);
        return 0.5 * M * first * first + (strain > first ? limit_[p] * (strain - first) : 0);
    }

    const double coefficient_;
    std::vector<double> modulus_, limit_; // kPa, of the stress of the patterns over their strain; at most
    std::vector<double> volume_;          // of the undeformed domains
    Field steepness_{"hourglassSteepness", "1/m2", "Square of the strain of unit patterns.", {modes}};
    bool isPatterned_ = true;
};

} // namespace mpm
