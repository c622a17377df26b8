// SPDX-License-Identifier: GPL-2.0-or-later
// Optional interface of Domains: the corners of domains are vertices, shared with their neighbours, that move
// with the nodes.
#pragma once

#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/state/Field.hpp"
#include "mpm/state/NodalField.hpp"

#include <functional>

namespace mpm {

template <int Dim> class Mesh {
  public:
    using NF = NodalField<Dim>;

    // --- the step: before takeGradient(), and last --------------------------------------------------
    virtual void takeVelocity(ParallelRegion& region, const typename NF::Velocity* nodes) = 0;
    virtual void advance(ParallelRegion& region, double dt) = 0;
    // What takeGradient() costs for particles [begin, end), in units of one box.
    virtual double workOf(int begin, int end) const = 0;

    // --- besides the step ---------------------------------------------------------------------------
    virtual const std::vector<int>& cornerTable() const = 0; // of every domain (VTK order)
    virtual Field& vertexPositions() = 0;
    virtual Field& vertexVelocities() = 0;
    // Node += share of a force on one vertex.
    virtual void addVertexForce(int vertex, const Vec<Dim>& force, typename NF::Sum* nodes) const = 0;
    // What strains domain p: each(node, phi, gradient, hoop, gamma), a node once for each vertex that feels it. hoop:
    // what its radial velocity adds to v_r/r, zero but for axial symmetry; gamma:
    // what unit velocity of the node adds to the rate of each hourglass pattern, `patterns` numbers;
    // `stiffness`: what the domain resists each with, kN/m (2D: per m).
    static constexpr int patterns = Dim == 2 ? 1 : 4;
    using EachStrain = std::function<void(int, double, const Vec<Dim>&, double, const double*)>;
    virtual void strains(int p, const EachStrain& each, double* stiffness) const = 0;
    // And how far the domain is from a linear deformation, what they resist: of each pattern and axis, m.
    virtual void amplitude(int p, double (*h)[Dim]) const = 0;
    // Of a beam, what strains domain p besides: a row of numbers r for each way e_r = sum_n row_rn . u_n in which it is
    // strained, each(node, rows); `rows`: the stiffness of each, kN m, and k_r e_r as it is. Returns their number.
    static constexpr int mostRows = 7;
    struct Rows {
        double stiffness[mostRows], force[mostRows];
    };
    using EachRow = std::function<void(int, const double (*)[Dim])>;
    virtual int beamRows(int p, const EachRow& each, Rows& rows) const = 0;
    // Longest edge of domain p, m, and what it was when the displacement was zero.
    virtual double longestEdge(int p) const = 0;
    virtual double initialEdge(int p) const = 0;

  protected:
    ~Mesh() = default;
};

} // namespace mpm
