// SPDX-License-Identifier: GPL-2.0-or-later
// How a force on the surface of a box goes to the nodes, and how fast that surface moves. A force at d
// from the centre is spread evenly over the largest box around that place which lies within the particle's
// own:
//     w_i(d) = phi_i + H_i(d) - H_i(0),
//     H_i(d) = prod_k mean of hat_i over [x_k + d_k - s_k, x_k + d_k + s_k],    s_k = l_k - |d_k|
// H(0) = phi with uGIMP. On a face, d = -l n, w is the hat function at the face then, averaged along it.
// The stress of boxes that tile the space has the same weight there, so a uniform pressure on them leaves
// no force at the nodes. Sum w_i = 1 and sum w_i x_i = x + d: force and moment are those at the place, to
// round-off.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

template <int Dim> Mat<3> velocityGradientOf(const Body<Dim>& soil, int p) {
    Mat<3> L = Mat<3>::Zero();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) L(i, j) = soil.particles.velocityGradient.plane(Dim * i + j)[p];
    return L;
}

// Means of the hat functions of three nodes along an axis, the first of them `first`, over [from, to]: of
// nodes that a box of at most one cell around x reaches.
struct HatMeans {
    int first = 0;
    double mean[3];

    HatMeans() = default;
    template <int Dim> HatMeans(const Grid<Dim>& grid, int axis, double x, double from, double to) {
        const int nearest = int(grid.inCells(x, axis) + 0.5);
        first = std::clamp(int(grid.inCells(from, axis)), nearest - 1, nearest);
        const double line = grid.line(axis, first + 1); // hats are straight on either side of it
        const double before = to > line ? std::max(0.0, line - from) / (to - from) : 1;
        const double a = grid.inCells(0.5 * (from + std::min(to, line)), axis) - first;
        const double b = before < 1 ? grid.inCells(0.5 * (std::max(from, line) + to), axis) - first - 1 : 0;
        mean[0] = before * (1 - a);
        mean[1] = before * a + (1 - before) * (1 - b);
        mean[2] = (1 - before) * b;
    }
};

// f(node, H(d)) of a place at d from the centre of box p, inside of it.
template <int Dim, class F>
void forMeansInBox(const Body<Dim>& soil, const Grid<Dim>& grid, int p, const Vec3& d, F&& f) {
    const Vec<Dim> l = soil.domains->boxes()->halfSize();
    HatMeans along[Dim];
    for (int k = 0; k < Dim; ++k) {
        const double x = soil.particles.position.plane(k)[p], half = std::max(0.0, l[k] - std::abs(d[k]));
        along[k] = HatMeans(grid, k, x, x + d[k] - half, x + d[k] + half);
    }
    for (int n = 0; n < (Dim == 2 ? 9 : 27); ++n) {
        int node = 0;
        double weight = 1;
        for (int k = 0, rest = n; k < Dim; ++k, rest /= 3) {
            node += (along[k].first + rest % 3) * grid.strides[k];
            weight *= along[k].mean[rest % 3];
        }
        if (weight != 0) f(node, weight);
    }
}

// f(node, w(d) - phi), in two parts.
template <int Dim, class F>
void forShiftOfWeights(const Body<Dim>& soil, const Grid<Dim>& grid, int p, const Vec3& d, F&& f) {
    forMeansInBox(soil, grid, p, d, f);
    forMeansInBox(soil, grid, p, Vec3::Zero(), [&](int node, double mean) { f(node, -mean); });
}

// Velocity of a node that is mapped from the particles, at the start of the step.
template <int Dim> Vec3 mappedVelocity(const Scene<Dim>& scene, const Body<Dim>& soil, int node) {
    using NF = NodalField<Dim>;
    const auto& field = scene.grid.fields[soil.velocityField];
    const auto& sum = field.sum[node];
    Vec3 velocity = Vec3::Zero();
    if (sum[NF::mass] <= scene.leastMass()) return velocity;
    for (int k = 0; k < Dim; ++k) {
        const double v = NF::velocityAtStart(sum, k);
        const int c = field.holder[node][k];
        velocity[k] = c < 0 ? v : scene.heldAtStart(c, k, v);
    }
    return velocity;
}

// How fast the place at d from the centre of box p moves against the centre: by the velocities that strain
// the box, with the weights of a force there, so that the force does work on this motion.
template <int Dim> Vec3 strainVelocity(const Scene<Dim>& scene, const Body<Dim>& soil, int p, const Vec3& d) {
    Vec3 v =
        velocityGradientOf(soil, p) * d; // what is left has no slope: half of the box is in the next cell
    soil.domains->weights(p, [&](int node, double, const Vec<Dim>& gradient) {
        v -= gradient.dot(d.head<Dim>()) * mappedVelocity(scene, soil, node);
    });
    forShiftOfWeights(soil, scene.grid, p, d,
                      [&](int node, double weight) { v += weight * mappedVelocity(scene, soil, node); });
    return v;
}

} // namespace mpm
