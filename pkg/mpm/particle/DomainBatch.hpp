// SPDX-License-Identifier: GPL-2.0-or-later
// Shapes of a batch of APDI domains, number by number across the batch, so that the loops over it vectorise.
#pragma once

#include "mpm/particle/APDIShape.hpp"
#include "mpm/state/Field.hpp"

namespace mpm {

template <int Dim> struct DomainBatch {
    static constexpr int NC = corners<Dim>;
        static constexpr int batch = Dim == 2 ? 64 : 32; // domains whose shapes are held at once
        static constexpr int modes = hourglassModes<Dim>;

        using Skew = decltype(ClosedShape<Dim>::skew);
        static constexpr int skews = int(std::tuple_size<Skew>());

        static std::array<double*, skews> planesFrom(Field& skew, int first) {
        std::array<double*, skews> planes;
        for (int m = 0; m < skews; ++m) planes[m] = skew.plane(m) + first;
        return planes;
    }

    // A vector at the corners of a batch of domains, from a field over the vertices.
        struct Corner {
            double x[NC][Dim][batch];

            Corner(const int* corner, const Field& field, int count) {
                const double* plane[Dim];
                for (int k = 0; k < Dim; ++k) plane[k] = field.plane(k);
                for (int p = 0; p < count; ++p)
                    MPM_UNROLL
                    for (int a = 0; a < NC; ++a) {
                        int v = corner[NC * p + a];
                        asm("" : "+r"(v)); // plain loads: without this GCC makes vectors of the numbers and takes twice as long
                        MPM_UNROLL
                        for (int k = 0; k < Dim; ++k) x[a][k][p] = plane[k][v];
                    }
            }
            MPM_INLINE CornerNumbers<Dim> at(int p) const {
                CornerNumbers<Dim> X;
                MPM_UNROLL
                for (int a = 0; a < NC; ++a)
                    MPM_UNROLL
                    for (int k = 0; k < Dim; ++k) X[k][a] = x[a][k][p];
                return X;
            }
        };

        // Corner weights of a batch of domains.
        struct Weights {
            const int* corner; // NC per domain
            double w[NC][batch];

            Weights(const std::vector<int>& corners, Field& skewField, int first, int count) : corner(corners.data() + NC * first) {
                const auto skew = planesFrom(skewField, first);
                auto one = [&](int p) __attribute__((always_inline)) {
                    Skew amount;
                    MPM_UNROLL
                    for (int m = 0; m < skews; ++m) amount[m] = skew[m][p];
                    const auto all = ClosedShape<Dim>::weights(amount);
                    MPM_UNROLL
                    for (int a = 0; a < NC; ++a) w[a][p] = all[a];
                };
    #pragma omp simd
                for (int p = 0; p < count; ++p) one(p);
            }
        };

        // Shapes of a batch of domains.
        struct Shapes {
            const int* corner; // NC per domain
            double w[NC][batch], g[NC][Dim][batch], volume[batch], pattern[modes][Dim][batch];

            Shapes(const std::vector<int>& corners, const Field& positions, Field& skewField, int first, int count)
                : corner(corners.data() + NC * first) {
                const Corner X(corner, positions, count);
                const auto skew = planesFrom(skewField, first);
                auto one = [&](int p) __attribute__((always_inline)) {
                    const ClosedShape<Dim> shape(X.at(p));
                    volume[p] = shape.volume;
                    MPM_UNROLL
                    for (int a = 0; a < NC; ++a) {
                        w[a][p] = shape.w[a];
                        MPM_UNROLL
                        for (int k = 0; k < Dim; ++k) g[a][k][p] = shape.g[a][k];
                    }
                    MPM_UNROLL
                    for (int m = 0; m < skews; ++m) skew[m][p] = shape.skew[m];
                    MPM_UNROLL
                    for (int m = 0; m < modes; ++m)
                        MPM_UNROLL
                        for (int k = 0; k < Dim; ++k) pattern[m][k][p] = shape.pattern[m][k];
                };
    #pragma omp simd
                for (int p = 0; p < count; ++p) one(p);
            }
        };

        // The corners after they have moved.
        MPM_INLINE static CornerNumbers<Dim> moved(const Corner& X, const Corner& V, double dt, int p) {
            CornerNumbers<Dim> x;
            MPM_UNROLL
            for (int a = 0; a < NC; ++a)
                MPM_UNROLL
                for (int k = 0; k < Dim; ++k) x[k][a] = X.x[a][k][p] + dt * V.x[a][k][p];
            return x;
        }
};

} // namespace mpm
