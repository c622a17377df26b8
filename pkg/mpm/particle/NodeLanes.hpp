// SPDX-License-Identifier: GPL-2.0-or-later
// Between the lanes of the nodes and planes, plane[k] being an array: as in NodalField::Velocity, the force
// of NodalField::Sum, and NodalField::Motion.
#pragma once

#include "mpm/base/parallel/WorkPartition.hpp"
#include "mpm/base/simd/transpose.hpp"
#include "mpm/state/NodalField.hpp"

namespace mpm {

template <int Dim> struct NodeLanes {
    using NF = NodalField<Dim>;

    static constexpr double none[chunkSize] = {};
    template <class Planes> static void packMomenta(const Planes& plane, int count, Quad* out) {
        interleave({plane[0], plane[1], Dim == 2 ? none : plane[Dim - 1], none}, count, out);
    }
    template <class Planes> static void packForces(const Planes& plane, int count, Quad* out) {
        interleave({plane[0], Dim == 2 ? none : plane[1], plane[Dim - 1], none}, count, out);
    }
    static void unpackVelocity(const typename NF::Velocity* in, int count,
                               const std::array<double*, Dim>& plane) {
        separate(in->part, 1, count, plane);
    }
    template <class Planes>
    static void unpackMotion(const typename NF::Motion* in, int count, Planes& plane) {
        constexpr int parts = sizeof(typename NF::Motion) / sizeof(Quad);
        separate(in->part, parts, count, std::array<double*, 4>{plane[0], plane[1], plane[2], plane[3]});
        if constexpr (Dim == 3)
            separate(in->part + 1, parts, count, std::array<double*, 2>{plane[4], plane[5]});
    }
};

} // namespace mpm
