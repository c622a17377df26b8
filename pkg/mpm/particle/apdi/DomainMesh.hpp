// SPDX-License-Identifier: GPL-2.0-or-later
// The mesh of APDI domains: its vertices, and which of them are the corners of every domain.
#pragma once

#include "mpm/particle/apdi/DomainBatch.hpp"
#include "mpm/particle/apdi/MeshVertices.hpp"

namespace mpm {

template <int Dim> class DomainMesh {
  public:
    static constexpr int NC = corners<Dim>;

    DomainMesh(const Grid<Dim>& grid, BlockOrder<Dim>& order) : vertices(grid, order) {}

    MeshVertices<Dim> vertices;
    std::vector<int> corner; // 2^Dim per domain
    std::vector<int> rowEnd; // see Batch

    int domains() const { return int(corner.size()) / NC; }

    // After vertices or corners were set.
    void restored() {
        vertices.restored();
        rowEnd = Batch<Dim>::rowEnds(corner);
    }

    Corners<Dim> cornersOf(int p) const { return cornersOf(p, vertices.position); }
    Corners<Dim> cornersOf(int p, const Field& positions) const {
        Corners<Dim> x;
        for (int a = 0; a < NC; ++a)
            for (int k = 0; k < Dim; ++k) x(k, a) = positions.plane(k)[corner[NC * p + a]];
        return x;
    }
    CornerNumbers<Dim> cornerNumbersOf(int p) const { return numbersOf<Dim>(cornersOf(p)); }

    // Square of the longest edge of domain p, with the vertices at the given positions.
    double longestSquare(int p, const Field& positions) const {
        double longest = 0;
        for (int a = 0; a < NC; ++a)
            for (int b = 0; b < a; ++b) {
                int differing = 0;
                for (int k = 0; k < Dim; ++k) differing += cornerSign(a, k) != cornerSign(b, k);
                if (differing != 1) continue;
                double square = 0;
                for (int k = 0; k < Dim; ++k) {
                    const double d =
                        positions.plane(k)[corner[NC * p + a]] - positions.plane(k)[corner[NC * p + b]];
                    square += d * d;
                }
                longest = std::max(longest, square);
            }
        return longest;
    }

    // f(batch) for domains [begin, end).
    template <class F> void forBatches(int begin, int end, F&& f) const {
        for (int first = begin; first < end;) {
            const Batch<Dim> batch(first, end, corner, rowEnd);
            f(batch);
            first += batch.count;
        }
    }

    // A batch takes about as long as 16 domains more than it has, and twice as long where it has to copy.
    double workOf(int begin, int end) const {
        constexpr int batchCost = 16;
        double work = 0;
        forBatches(begin, end, [&](const Batch<Dim>& batch) {
            work += batchCost + (batch.isStraight ? 1 : 2) * batch.count;
        });
        return work;
    }
};

} // namespace mpm
