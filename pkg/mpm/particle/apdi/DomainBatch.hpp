// SPDX-License-Identifier: GPL-2.0-or-later
// Batches of APDI domains: what their corners hold, and their shapes, number by number across the batch, so
// that the loops over it vectorise. Arrays of a batch begin at a cache line: no vector of eight lies across
// two.
#pragma once

#include "mpm/base/simd/forEachSimd.hpp"
#include "mpm/particle/apdi/RingShape.hpp"
#include "mpm/state/Field.hpp"

namespace mpm {

// Consecutive domains. In a straight row every corner has the next number in the next domain, as along a row
// of a regular mesh: what its corners hold lies side by side in memory.
template <int Dim> struct Batch {
    static constexpr int NC = corners<Dim>;
    static constexpr int most = Dim == 2 ? 96 : 32, leastStraight = 8;

    int first, count;
    bool isStraight;
    const int* corner; // NC per domain

    // From domain `first` on, before `end`: in a straight row a part of what is left of it (all parts are
    // about as long, for a short batch takes hardly less time), else to the next row that is not short.
    // rowEnd: for every domain the end of its straight row.
    Batch(int first, int end, const std::vector<int>& corners, const std::vector<int>& rowEnd)
        : first(first), corner(corners.data() + NC * first) {
        count = std::min(rowEnd[first], end) - first;
        isStraight = count >= leastStraight;
        if (isStraight) {
            const int parts = (count + most - 1) / most;
            count = std::min(count, (count / parts + 7) / 8 * 8);
            return;
        }
        const int last = std::min(end, first + most);
        int stop = first + count;
        while (stop < last && rowEnd[stop] - stop < leastStraight) stop = std::min(rowEnd[stop], last);
        count = stop - first;
    }

    static std::vector<int> rowEnds(const std::vector<int>& corners) {
        const int n = int(corners.size()) / NC;
        std::vector<int> ends(n, n);
        for (int p = n - 2; p >= 0; --p) {
            bool isNext = true;
            for (int a = 0; a < NC; ++a) isNext &= corners[NC * (p + 1) + a] == corners[NC * p + a] + 1;
            ends[p] = isNext ? ends[p + 1] : p + 1;
        }
        return ends;
    }

    // plane k of corner a of each domain p += value(a, k, p), corner by corner: no copy of the loops for each.
    template <size_t n, class Value>
    MPM_INLINE void addToCorners(const std::array<double*, n>& plane, Value&& value) const {
        for (int a = 0; a < NC; ++a)
            if (isStraight) {
                std::array<double*, n> at = plane;
                for (double*& x : at) x += corner[a];
                forEachSimd(count, [&](int p) MPM_INLINE_LAMBDA {
                    MPM_UNROLL
                    for (size_t k = 0; k < n; ++k) at[k][p] += value(a, int(k), p);
                });
            } else {
                double given[n][most];
#pragma omp simd
                for (int p = 0; p < count; ++p) MPM_UNROLL
                for (size_t k = 0; k < n; ++k) given[k][p] = value(a, int(k), p);
                for (int p = 0; p < count; ++p) MPM_UNROLL
                for (size_t k = 0; k < n; ++k) plane[k][corner[NC * p + a]] += given[k][p];
            }
    }
};

// What n planes hold at the corners of a batch: x[a][k][p] for corner a, plane k, domain p. Where the batch
// is straight that is the planes themselves, else a copy.
template <int Dim, int n> class AtCorners {
  public:
    static constexpr int NC = corners<Dim>;
    const double* x[NC][n];

    template <class Number> AtCorners(const Batch<Dim>& batch, const std::array<Number*, n>& plane) {
        for (int a = 0; a < NC; ++a)
            for (int k = 0; k < n; ++k) x[a][k] = batch.isStraight ? plane[k] + batch.corner[a] : copy_[a][k];
        for (int p = 0; p < batch.count && !batch.isStraight; ++p) MPM_UNROLL
        for (int a = 0; a < NC; ++a) {
            const int v = inRegister(batch.corner[NC * p + a]); // plain loads
            MPM_UNROLL
            for (int k = 0; k < n; ++k) copy_[a][k][p] = plane[k][v];
        }
    }
    AtCorners(const AtCorners&) = delete;

    // The first Dim planes: a vector at the corners of domain p.
    MPM_INLINE CornerNumbers<Dim> at(int p) const {
        CornerNumbers<Dim> X;
        MPM_UNROLL
        for (int a = 0; a < NC; ++a) MPM_UNROLL
        for (int k = 0; k < Dim; ++k) X[k][a] = x[a][k][p];
        return X;
    }

  private:
    alignas(64) double copy_[NC][n][Batch<Dim>::most];
};

template <int Dim> std::array<const double*, Dim> vectorPlanes(const Field& field) {
    std::array<const double*, Dim> plane;
    for (int k = 0; k < Dim; ++k) plane[k] = field.plane(k);
    return plane;
}

// Corner weights of a batch, from the skew that Shapes has found.
template <int Dim, bool isRound> struct alignas(64) BatchWeights {
    static constexpr int NC = corners<Dim>;
    using Skew = decltype(DomainShape<Dim, isRound>::skew);
    static constexpr int skews = int(std::tuple_size<Skew>());
    double w[NC][Batch<Dim>::most];

    BatchWeights(const Batch<Dim>& batch, const Field& skewField) {
        const double* skew[skews];
        for (int m = 0; m < skews; ++m) skew[m] = skewField.plane(m) + batch.first;
        auto one = [&](int p) MPM_INLINE_LAMBDA {
            Skew amount;
            MPM_UNROLL
            for (int m = 0; m < skews; ++m) amount[m] = skew[m][p];
            const auto all = DomainShape<Dim, isRound>::weights(amount);
            MPM_UNROLL
            for (int a = 0; a < NC; ++a) w[a][p] = all[a];
        };
        forEachSimd(batch.count, one);
    }
};

// Shapes of a batch; the skew of the weights is kept for BatchWeights.
template <int Dim, bool isRound> struct alignas(64) BatchShapes {
    static constexpr int NC = corners<Dim>, modes = hourglassModes<Dim>, most = Batch<Dim>::most;
    static constexpr int skews = BatchWeights<Dim, isRound>::skews;
    double w[NC][most], g[NC][Dim][most], pattern[modes][Dim][most];
    double hoop[isRound ? NC : 1][isRound ? most : 1];

    BatchShapes(const Batch<Dim>& batch, const Field& positions, Field& skewField) {
        const AtCorners<Dim, Dim> X(batch, vectorPlanes<Dim>(positions));
        double* skew[skews];
        for (int m = 0; m < skews; ++m) skew[m] = skewField.plane(m) + batch.first;
        auto one = [&](int p) MPM_INLINE_LAMBDA {
            const DomainShape<Dim, isRound> shape(X.at(p));
            MPM_UNROLL
            for (int a = 0; a < NC; ++a) {
                w[a][p] = shape.w[a];
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) g[a][k][p] = shape.g[a][k];
                if constexpr (isRound) hoop[a][p] = shape.hoop[a];
            }
            MPM_UNROLL
            for (int m = 0; m < skews; ++m) skew[m][p] = shape.skew[m];
            MPM_UNROLL
            for (int m = 0; m < modes; ++m) MPM_UNROLL
            for (int k = 0; k < Dim; ++k) pattern[m][k][p] = shape.pattern[m][k];
        };
        forEachSimd(batch.count, one);
    }
};

} // namespace mpm
