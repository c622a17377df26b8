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

#include "mpm/contact/rigid/RigidContactPoint.hpp"
#include "mpm/scene/Scene.hpp"

#include <optional>

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
    // slope: gets those of the means as the box moves, 1/m; nullptr: no one asks.
    template <int Dim>
    HatMeans(const Grid<Dim>& grid, int axis, double x, double from, double to, double* slope = nullptr) {
        const int nearest = int(grid.inCells(x, axis) + 0.5);
        const double start = grid.inCells(from, axis), end = grid.inCells(to, axis);
        first = std::clamp(int(start), nearest - 1, nearest);
        const double a = start - first, b = end - first; // hats are straight on either side of b = 1
        if (slope) {
            slope[0] = (std::min(a, 1.0) - std::min(b, 1.0)) / (to - from);
            slope[2] = std::max(0.0, b - 1) - std::max(0.0, a - 1);
            slope[2] /= to - from;
            slope[1] = -slope[0] - slope[2];
        }
        if (b <= 1) {
            mean[1] = 0.5 * (a + b);
            mean[0] = 1 - mean[1];
            mean[2] = 0;
            return;
        }
        const double before = std::max(0.0, grid.line(axis, first + 1) - from) / (to - from);
        const double inFirst = 0.5 * (a + 1), inSecond = 0.5 * (std::max(a, 1.0) + b) - 1;
        mean[0] = before * (1 - inFirst);
        mean[1] = before * inFirst + (1 - before) * (1 - inSecond);
        mean[2] = (1 - before) * inSecond;
    }
};

// H(d) of a place at d from the centre of box p, inside of it.
template <int Dim> class BoxHats {
  public:
    // slopes: of the means along each axis, where they are asked for.
    BoxHats(const Body<Dim>& soil, const Grid<Dim>& grid, int p, const Vec3& d, double (*slopes)[3] = nullptr)
        : grid_(grid) {
        const Vec<Dim> l = soil.domains->boxes()->halfSize();
        for (int k = 0; k < Dim; ++k) {
            const double x = soil.particles.position.plane(k)[p], half = std::max(0.0, l[k] - std::abs(d[k]));
            along_[k] = HatMeans(grid, k, x, x + d[k] - half, x + d[k] + half, slopes ? slopes[k] : nullptr);
        }
    }

    // f(node, H and its gradient in four lanes) for the nodes of a box around its centre.
    template <class F> void forSlopes(const double (*slopes)[3], F&& f) const {
        const auto lanes = [&](int k, int i) {
            const double H = along_[k].mean[i], own = slopes[k][i];
            return Quad{H, k == 0 ? own : H, k == 1 ? own : H, k == 2 ? own : H};
        };
        for (int z = 0; z < (Dim == 2 ? 1 : 3); ++z)
            for (int y = 0; y < 3; ++y)
                for (int x = 0; x < 3; ++x) {
                    Quad weight = lanes(0, x) * lanes(1, y);
                    int node = along_[0].first + x + (along_[1].first + y) * grid_.strides[1];
                    if constexpr (Dim == 3) {
                        weight = weight * lanes(2, z);
                        node += (along_[2].first + z) * grid_.strides[2];
                    }
                    if (weight[0] != 0) f(node, weight);
                }
    }

    // f(node, H).
    template <class F> void forNodes(F&& f) const {
        for (int n = 0; n < (Dim == 2 ? 3 : 9); ++n) {
            int row = along_[0].first;
            double across = 1;
            for (int k = 1, rest = n; k < Dim; ++k, rest /= 3) {
                row += (along_[k].first + rest % 3) * grid_.strides[k];
                across *= along_[k].mean[rest % 3];
            }
            if (across == 0) continue;
            for (int i = 0; i < 3; ++i)
                if (along_[0].mean[i] != 0) f(row + i, across * along_[0].mean[i]);
        }
    }

  private:
    const Grid<Dim>& grid_;
    HatMeans along_[Dim];
};

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

// A box and the nodes round it: its weights, and H(0) where that is not the weight itself. Found once in a step.
template <int Dim> struct BoxNodes {
    static constexpr int most = Dim == 2 ? 9 : 27; // a kernel reaches three nodes along an axis at most
    int count = 0, node[most];
    Quad weight[most]; // phi, and its gradient
    std::optional<BoxHats<Dim>> inside;

    BoxNodes(const Body<Dim>& soil, const Grid<Dim>& grid, int p, bool weighsByHats) {
        if (weighsByHats) {
            double slopes[Dim][3];
            BoxHats<Dim>(soil, grid, p, Vec3::Zero(), slopes)
                .forSlopes(slopes, [this](int i, const Quad& all) {
                    node[count] = i;
                    weight[count++] = all;
                });
            return;
        }
        inside.emplace(soil, grid, p, Vec3::Zero());
        soil.domains->weights(p, [this](int i, double phi, const Vec<Dim>& slope) {
            node[count] = i;
            weight[count++] = Quad{phi, slope[0], slope[1], Dim == 3 ? slope[Dim - 1] : 0};
        });
    }

    double phi(int i) const { return weight[i][0]; }
    Vec<Dim> gradient(int i) const {
        Vec<Dim> slope;
        for (int k = 0; k < Dim; ++k) slope[k] = weight[i][k + 1];
        return slope;
    }
};

inline Vec3 vectorOfLanes(const Quad& lanes) { return {lanes[0], lanes[1], lanes[2]}; }

// Velocities of nodes that are mapped from the particles, found once in a step: boxes in touch share them.
template <int Dim> class MappedVelocities {
  public:
    void begin(const Scene<Dim>& scene) {
        scene_ = &scene;
        ofFields_.resize(scene.grid.fields.size());
        for (auto& all : ofFields_) all.resize(scene.grid.count, Pack<4>::zero());
        ++now_;
    }

    // In three lanes; the last one says in which step it was found.
    const Quad& of(const Body<Dim>& soil, int node) {
        Quad& there = ofFields_[soil.velocityField][node].part[0];
        if (there[3] != now_) {
            const Vec3 v = mappedVelocity(*scene_, soil, node);
            there = Quad{v[0], v[1], v[2], now_};
        }
        return there;
    }

  private:
    const Scene<Dim>* scene_ = nullptr;
    std::vector<std::vector<Pack<4>>> ofFields_;
    double now_ = 0; // number of the step
};

// How the nodes round a box strain it and carry it.
template <int Dim>
NodalMotion nodalMotionOf(MappedVelocities<Dim>& velocities, const Body<Dim>& soil, const BoxNodes<Dim>& box,
                          int p) {
    Quad centre{}, inBox{}, along[Dim]{};
    for (int i = 0; i < box.count; ++i) {
        const Quad& v = velocities.of(soil, box.node[i]);
        centre += box.phi(i) * v;
        for (int k = 0; k < Dim; ++k) along[k] += box.weight[i][k + 1] * v;
    }
    if (box.inside)
        box.inside->forNodes([&](int node, double H) { inBox += H * velocities.of(soil, node); });
    else
        inBox = centre;
    NodalMotion motion{vectorOfLanes(centre), vectorOfLanes(inBox), velocityGradientOf(soil, p)};
    for (int k = 0; k < Dim; ++k) motion.excess.col(k) -= vectorOfLanes(along[k]);
    return motion;
}

// How fast the place at d from the centre of a box moves against the centre: by the velocities that strain
// the box, with the weights of a force there, so that the force does work on this motion. L d less its part that
// has a slope: half of the box is in the next cell. hats: of d.
template <int Dim>
Vec3 strainVelocity(MappedVelocities<Dim>& velocities, const Body<Dim>& soil,
                    const RigidContactPoint& contact, const BoxHats<Dim>& hats, const Vec3& d) {
    if (contact.bend.allFinite()) return velocityGradientOf(soil, contact.place) * d + contact.bend;
    Quad v{};
    hats.forNodes([&](int node, double H) { v += H * velocities.of(soil, node); });
    return contact.motion.excess * d - contact.motion.inBox + vectorOfLanes(v);
}

// The part of it that is not L d, by the velocities that strain the box in this step. hats: of d.
template <int Dim>
Vec3 bendOf(const NodalField<Dim>& field, const BoxNodes<Dim>& box, const BoxHats<Dim>& hats, const Vec3& d) {
    Vec<Dim> sum = Vec<Dim>::Zero();
    const auto add = [&](int node, double weight) {
        for (int k = 0; k < Dim; ++k) sum[k] += weight * field.velocityOf(node, k);
    };
    hats.forNodes(add);
    for (int i = 0; i < box.count; ++i)
        add(box.node[i], -box.gradient(i).dot(d.template head<Dim>()) - (box.inside ? 0 : box.phi(i)));
    if (box.inside) box.inside->forNodes([&](int node, double H) { add(node, -H); });
    Vec3 bend = Vec3::Zero();
    bend.template head<Dim>() = sum;
    return bend;
}

} // namespace mpm
