// SPDX-License-Identifier: GPL-2.0-or-later
// What the nodes hold: sums from the particles, the motion that the grid solver finds, and who holds them.
#pragma once

#include "mpm/base/parallel/WorkPartition.hpp"
#include "mpm/base/require.hpp"
#include "mpm/base/simd/Pack.hpp"
#include "mpm/base/simd/largePages.hpp"
#include "mpm/base/types.hpp"

#include <cassert>
#include <vector>

namespace mpm {

// One value for each node, in memory of its own or in the second half of that of another field.
template <class T> class NodeArray {
  public:
    NodeArray() = default;
    NodeArray(NodeArray&&) = default;
    NodeArray& operator=(NodeArray&&) = default;
    NodeArray(const NodeArray&) = delete;

    // halves: 2 leaves room for another field.
    void assign(int nodes, const T& value, int halves = 1) {
        own_.assign(size_t(halves) * nodes, value);
        data_ = own_.data();
        size_ = nodes;
    }
    void beSecondHalfOf(NodeArray& first) {
        own_ = {};
        data_ = first.data_ + first.size_;
        size_ = first.size_;
    }
    int size() const { return size_; }
    T* data() { return data_; }
    const T* data() const { return data_; }
    T& operator[](size_t node) { return data_[node]; }
    const T& operator[](size_t node) const { return data_[node]; }

  private:
    std::vector<T, OnLargePages<T>> own_;
    T* data_ = nullptr;
    int size_ = 0;
};

// Nodal data of one velocity field. Bodies that share a velocity field stick together; where there is a
// Contact, each group of bodies has its own.
template <int Dim> struct NodalField {
    // What the particles give: momentum, mass, weight mass (mass without inertial scaling), and force. In 2D
    // component k of the force is the sum of two lanes (base/simd/Lanes.hpp): forceOf() reads it, addForce()
    // adds to it.
    using Sum = Pack<8>;
    static constexpr int momentum = 0, mass = Dim, weightMass = Dim == 2 ? 3 : 7;
    static constexpr int lane(int k) { return Dim == 2 ? 2 * k : k; }
    static constexpr int force(int k) { return 4 + lane(k); }
    static Vec<Dim> forceOf(const Sum& sum) {
        Vec<Dim> f;
        for (int k = 0; k < Dim; ++k) f[k] = Dim == 2 ? sum[force(k)] + sum[force(k) + 1] : sum[force(k)];
        return f;
    }
    // Of the particles, at the start of the step; the node has mass.
    static double velocityAtStart(const Sum& sum, int k) { return sum[momentum + k] / sum[mass]; }
    static void addForce(Sum& sum, int k, double f) { sum.set(force(k), sum[force(k)] + f); }

    // Velocity and acceleration of the solution, which the particles take: component k in lane k, and in lane
    // Dim + k.
    using Motion = Pack<Dim == 2 ? 4 : 8>;
    static constexpr int velocity = 0, acceleration = Dim;

    // Vectors for the equation of motion, with component k in lane(k), in 2D also in the next.
    MPM_INLINE static Quad momentumLanes(const Sum& sum) {
        const Quad p = sum.part[0];
        return Dim == 2 ? Quad{p[0], p[0], p[1], p[1]} : Quad{p[0], p[1], p[2], 0};
    }
    MPM_INLINE static Quad forceLanes(const Sum& sum) {
        const Quad f = sum.part[1];
        return Dim == 2 ? f + Quad{f[1], f[0], f[3], f[2]} : Quad{f[0], f[1], f[2], 0};
    }
    // Not lane by lane: the vector would be read before it is in memory.
    MPM_INLINE static void setComponent(Quad& vector, int k, double value) {
        const auto in = [&](int l) { return (Dim == 2 ? l / 2 : l) == k ? value : vector[l]; };
        vector = Quad{in(0), in(1), in(2), in(3)};
    }
    MPM_INLINE static void setMotion(Motion& motion, const Quad& v, const Quad& a) {
        if constexpr (Dim == 2) {
            motion.part[0] = evenLanes(v, a);
        } else {
            motion.part[0] = Quad{v[0], v[1], v[2], a[0]};
            motion.part[1] = Quad{a[1], a[2], 0, 0};
        }
    }

    NodeArray<Sum> sum;
    NodeArray<Motion> motion;

    // The velocity that strains the particles and moves the vertices. Where it is mapped back from the
    // particles (MUSL, USF) the same memory holds their momentum before, and 1/mass beside it: one line of
    // the cache for all three, and each under its own name. The engine that has filled it says in `straining`
    // what it holds.
    using Velocity = Pack<4>;
    using Momentum = Pack<4>;
    enum class Straining { nothing, noMomentum, momentum, velocity };
    Straining straining = Straining::nothing;

    MPM_INLINE void clearMomentum(int node, double overMass) {
        straining_[node].part[0] = Dim == 2 ? Quad{0, 0, overMass, 0} : Quad{0, 0, 0, overMass};
    }
    // For the particles to add to.
    Momentum* momenta() {
        assert(straining == Straining::noMomentum);
        return straining_.data();
    }
    // Returns whether the node has mass.
    MPM_INLINE bool momentumToVelocity(int node) {
        const double overMass = straining_[node][Dim];
        straining_[node] = overMass * straining_[node];
        return overMass > 0;
    }
    MPM_INLINE void setVelocity(int node, const Quad& lanes) {
        straining_[node].part[0] = Dim == 2 ? evenLanes(lanes, Quad{}) : lanes;
    }
    void setVelocity(int node, int k, double v) { straining_[node].set(k, v); }
    double velocityOf(int node, int k) const { return straining_[node][k]; }
    const Velocity* velocities() const {
        require(
            straining == Straining::velocity,
            "DomainUpdater: the nodes hold no velocity that strains the particles, for VelocityRemap "
            "(MUSL, USF) or GridSolver (USL) is left out; set dead=False, or leave DomainUpdater out, too");
        return straining_.data();
    }

    // Which constraint holds each component of a node, -1: none. Fixed sets of nodes are entered by
    // Scene::prepare(), driven ones anew in every step by ParticleToGrid (see step/Driving.hpp).
    using Holders = std::array<short, Dim>;
    std::vector<Holders> holder;
    static constexpr size_t bytesOfNode = sizeof(Sum) + sizeof(Motion) + sizeof(Velocity) + sizeof(Holders);
    static Holders free() {
        Holders none;
        none.fill(-1);
        return none;
    }
    bool isHeld(int node) const {
        bool held = false;
        for (short h : holder[node]) held |= h >= 0;
        return held;
    }

    // The part of each slab that particles touched in this step: a box in the other axes.
    struct Extent {
        Index<Dim> first, last; // inclusive; first > last: none

        Extent() {
            first.fill(1 << 30);
            last.fill(-(1 << 30));
        }
        void include(const Extent& other) {
            for (int k = 0; k < Dim; ++k) {
                first[k] = std::min(first[k], other.first[k]);
                last[k] = std::max(last[k], other.last[k]);
            }
        }
    };
    std::vector<Extent> extents;
    WorkPartition partition; // of the slabs, by the number of their touched nodes

    // halves: 2 for a field whose soil has a second one, see PartedSoils.
    void setSize(int nodes, int slabs, int halves) {
        this->halves = halves;
        sum.assign(nodes, Sum::zero(), halves);
        motion.assign(nodes, Motion::zero(), halves);
        straining_.assign(nodes, Velocity::zero(), halves);
        holder.assign(nodes, free());
        extents.resize(slabs);
        forgetExtents();
    }
    // Node n of this one is node n + (number of nodes) of the first: particles reach it by that number.
    void beSecondHalfOf(NodalField& first) {
        halves = 0;
        sum.beSecondHalfOf(first.sum);
        motion.beSecondHalfOf(first.motion);
        straining_.beSecondHalfOf(first.straining_);
        holder.assign(first.sum.size(), free());
        extents.resize(first.extents.size());
        forgetExtents();
    }
    int halves = 0; // of its memory, that are its own
    void forgetExtents() { std::fill(extents.begin(), extents.end(), Extent()); }
    void partitionNodes() {
        partition.set(int(extents.size()), [&](int slab) {
            double n = 1;
            for (int k = 0; k < Dim - 1; ++k)
                n *= std::max(0, extents[slab].last[k] - extents[slab].first[k] + 1);
            return n;
        });
    }

  private:
    NodeArray<Velocity> straining_;
};

} // namespace mpm
