// SPDX-License-Identifier: GPL-2.0-or-later
// Box particles that have become too long for their box are cut in two, so that a stretched body stays whole.
//
// The domain of a particle is its box, mapped by D = F S. The share S is one when the body is made; the
// longest stretch of D is |D m| = s with D m = s n. A cut across n halves the domain along it: D <- (I - n
// n^T/2) D, that is S <- S (I - m m^T/2). The halves stand at x +- d, d = s l n/2 with the half length l of
// the box along m, so that the second moment of the mass stays. Velocity, F, stress and state are those of
// the particle that was cut: mass, volume, centre of mass, momentum, angular momentum, kinetic and elastic
// energy stay. (With v +- L d the halves would be on the linear velocity field, at the price of a kinetic
// energy m |L d|^2/2 from nowhere; results were the same.) The halves have boxes as large as before. A limit of
// 2 makes a half as long as its box; boxes that overlap do less harm than gaps between them: 1.3 keeps a body
// whole that falls apart at 2 (doc/explanation/numerical-fracture.md).
//
// No particle is cut more than five times, to 1/32 of its mass: by then its domain was 40 times as long as at the
// start, and what is torn that far is dust beside a body. Without the limit dust was cut to 1e-9 of a particle.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/base/simd/compiler.hpp"
#include "mpm/base/spectrum.hpp"
#include "mpm/particle/CutBoxes.hpp"
#include "mpm/particle/Outline.hpp"

namespace mpm {

template <int Dim> class Splitting {
  public:
    explicit Splitting(double limit) : limit_(limit) {}

    Field share{"splitShare",
                "-",
                "What the cuts left of the domain of a particle, in the frame of the undeformed body.",
                {Dim, Dim}};

    bool isOn() const { return !std::isnan(limit_); }

    void start(int count) {
        share.resize(count);
        for (int k = 0; k < Dim; ++k) std::fill_n(share.plane((Dim + 1) * k), count, 1.0);
    }

    // Notes whether one of the particles [begin, end), a chunk, is too long.
    void look(const Particles<Dim>& particles, int begin, int end) {
        double least = 1;
#pragma omp simd reduction(min : least)
        for (int p = begin; p < end; ++p)
            least = std::min(least, mayBeCut(p) ? margin(domain(particles, p)) : 1.0);
        isSuspect_[begin / chunkSize] = !(least > 0);
    }
    void expect(int count) { isSuspect_.resize(chunksOf(count), 1); } // before the threads look
    void forget() { isSuspect_.clear(); }

    void permute(const std::vector<int>& order) {
        std::vector<double> scratch;
        share.permute(order, scratch);
        forget();
    }

    const std::vector<CutBox<Dim>>& justCut() const { return justCut_; }

    // Cuts what is too long; the new halves come last. Facets of the outline go with the half that is nearer.
    // Returns whether there were any.
    bool cut(Particles<Dim>& particles, const Vec<Dim>& halfSize, Outline<Dim>& outline) {
        const std::vector<Cut> cuts = find(particles, halfSize);
        justCut_.clear();
        if (cuts.empty()) return false;
        const int first = particles.size();
        const int64_t* ids = particles.id.integers();
        int64_t next = *std::max_element(ids, ids + first) + 1;
        particles.resize(first + int(cuts.size()));
        share.resize(particles.size());
        for (size_t i = 0; i < cuts.size(); ++i) {
            const int p = cuts[i].particle, other = first + int(i);
            halve(particles, cuts[i]);
            for (Field* field : particles.fields()) copy(*field, p, other);
            copy(share, p, other);
            particles.id.integers()[other] = next++;
            justCut_.push_back({particles.id.integers()[p], particles.id.integers()[other], cuts[i].offset});
            for (const auto& [half, offset] :
                 {std::pair(p, cuts[i].offset), std::pair(other, Vec<Dim>(-cuts[i].offset))})
                shift(particles, half, offset);
            outline.split(p, particles.id.integers()[other], cuts[i].reference);
        }
        forget();
        return true;
    }

  private:
    struct Cut {
        int particle;
        Vec<Dim> along, offset, reference; // m; d; F^-1 d
    };

    // Each cut halves the determinant of the share.
    MPM_INLINE bool mayBeCut(int p) const {
        constexpr double least = 1.5 / 32;
        return shareOf(p).determinant() > least;
    }

    MPM_INLINE Mat<Dim> shareOf(int p) const {
        Mat<Dim> S;
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) S(i, j) = share.plane(Dim * i + j)[p];
        return S;
    }

    MPM_INLINE Mat<Dim> domain(const Particles<Dim>& particles, int p) const {
        Mat<Dim> D;
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) {
                double sum = 0;
                for (int k = 0; k < Dim; ++k)
                    sum += particles.deformationGradient.plane(3 * i + k)[p] * share.plane(Dim * k + j)[p];
                D(i, j) = sum;
            }
        return D;
    }

    // Positive where all stretches are below the limit: the least leading minor of limit^2 I - D^T D is.
    MPM_INLINE double margin(const Mat<Dim>& D) const {
        const Mat<Dim> rest = limit_ * limit_ * Mat<Dim>::Identity() - D.transpose() * D;
        const double least = std::min(rest(0, 0), rest(0, 0) * rest(1, 1) - rest(0, 1) * rest(1, 0));
        return Dim == 2 ? least : std::min(least, rest.determinant());
    }

    std::vector<Cut> find(const Particles<Dim>& particles, const Vec<Dim>& halfSize) const {
        std::vector<Cut> cuts;
        for (int p = 0; p < particles.size(); ++p) {
            if (p % chunkSize == 0 && !isSuspect_.empty())
                while (p < particles.size() && !isSuspect_[p / chunkSize]) p += chunkSize;
            if (p >= particles.size()) break;
            const Mat<Dim> D = domain(particles, p);
            if (margin(D) > 0 || !mayBeCut(p)) continue;
            const Spectrum<Dim> stretches = spectrumOf<Dim>(D.transpose() * D);
            const double stretch = std::sqrt(stretches.values[Dim - 1]);
            if (!(stretch > limit_)) continue;
            const Vec<Dim> along = stretches.vectors.col(Dim - 1);
            const double half = 0.5 * along.cwiseProduct(halfSize).norm();
            const Vec<Dim> offset = half * D * along;
            const double part = partInside(particles, p, offset[0]);
            cuts.push_back({p, along, part * offset, part * half * shareOf(p) * along});
        }
        return cuts;
    }

    // With axial symmetry, what of an offset leaves the inner half between the axis and its middle.
    static double partInside(const Particles<Dim>& particles, int p, double offset) {
        const double most = 0.5 * particles.position.plane(0)[p];
        return particles.isAxisymmetric && std::abs(offset) > most ? most / std::abs(offset) : 1;
    }

    void halve(Particles<Dim>& particles, const Cut& cut) {
        const int p = cut.particle;
        for (Field* extensive : {&particles.mass, &particles.volume, &particles.initialVolume})
            extensive->plane()[p] *= 0.5;
        for (int i = 0; i < Dim; ++i) {
            double along = 0; // (S m)_i
            for (int j = 0; j < Dim; ++j) along += share.plane(Dim * i + j)[p] * cut.along[j];
            for (int j = 0; j < Dim; ++j) share.plane(Dim * i + j)[p] -= 0.5 * along * cut.along[j];
        }
    }

    static void copy(Field& field, int from, int to) {
        for (int c = 0; field.size() > 0 && c < field.components(); ++c)
            std::memcpy(field.plane(c) + to, field.plane(c) + from, sizeof(double));
    }

    static void shift(Particles<Dim>& particles, int p, const Vec<Dim>& offset) {
        if (particles.isAxisymmetric) // the outer half is the longer ring
            for (Field* extensive : {&particles.mass, &particles.volume, &particles.initialVolume})
                extensive->plane()[p] *= 1 + offset[0] / particles.position.plane(0)[p];
        for (int k = 0; k < Dim; ++k) {
            particles.position.plane(k)[p] += offset[k];
            particles.reference.plane(k)[p] += offset[k];
        }
    }

    const double limit_; // stretch of a domain; not a number: never
    std::vector<CutBox<Dim>> justCut_;
    std::vector<char> isSuspect_; // chunks of particles with one that may be too long; empty: not known
};

} // namespace mpm
