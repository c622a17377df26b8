// SPDX-License-Identifier: GPL-2.0-or-later
// A roller is a plane of symmetry. A ghost node behind it is the image of the node as far before it: what particles
// give to the image goes to that node, mirrored, and the image moves as that node does, mirrored. So a half model
// with a roller is the full one. Ghost nodes of their own would have next to no mass, and whatever force is there
// would throw particles along the wall.
//
// One thread does it: the images are few.
#pragma once

#include "mpm/scene/Constraint.hpp"
#include "mpm/state/Grid.hpp"

#include <memory>

namespace mpm {

template <int Dim> class MirrorNodes {
  public:
    using NF = NodalField<Dim>;

    // A ghost node with mass. sign: -1 along the axes that it is mirrored along, else 1.
    struct Image {
        int field, ghost, node;
        Vec<Dim> sign;
        typename NF::Sum sum; // what the particles gave to it
    };
    const std::vector<Image>& images() const { return images_; }

    // Before a run: which faces of the grid have rollers.
    void findRollers(const Grid<Dim>& grid, const std::vector<std::shared_ptr<Constraint>>& constraints) {
        images_.clear();
        for (auto& sides : rollers_) sides.fill(-1);
        for (size_t c = 0; c < constraints.size(); ++c) {
            const int axis = rollerAxis(*constraints[c]);
            if (axis < 0) continue;
            const bool isUpper = grid.indices(constraints[c]->nodes.front())[axis] > grid.ghost;
            rollers_[axis][isUpper] = short(c);
        }
    }

    // Once the nodes have their sums. What something else than the roller holds is no image.
    const std::vector<Image>& find(const Grid<Dim>& grid) {
        images_.clear();
        for (int k = 0; k < Dim; ++k)
            for (int side = 0; side < 2; ++side)
                if (rollers_[k][side] >= 0)
                    for (size_t f = 0; f < grid.fields.size(); ++f) findBehind(grid, int(f), k, side);
        return images_;
    }

    // Finds the images, and gives what particles gave to them to the nodes before the rollers. The image of a weight
    // points along the mirrored gravity, m/s2.
    void fold(Grid<Dim>& grid, const Vec<Dim>& gravity) {
        for (const Image& image : find(grid)) {
            grid.fields[image.field].sum[image.ghost] = NF::Sum::zero();
            auto& sum = grid.fields[image.field].sum[image.node];
            const Vec<Dim> force = NF::forceOf(image.sum);
            for (int lane : {int(NF::mass), int(NF::weightMass)}) sum.set(lane, sum[lane] + image.sum[lane]);
            for (int k = 0; k < Dim; ++k) {
                const double s = image.sign[k], weight = image.sum[NF::weightMass] * gravity[k];
                sum.set(NF::momentum + k, sum[NF::momentum + k] + s * image.sum[NF::momentum + k]);
                NF::addForce(sum, k, s * force[k] + (s - 1) * weight);
            }
        }
    }

    // add(node, k, value of the image at [k] with its sign): of values that particles gave to the images.
    template <class Read, class Add> void foldValues(int field, Read&& read, Add&& add) const {
        for (const Image& image : images_)
            for (int k = 0; image.field == field && k < Dim; ++k)
                add(image.node, k, image.sign[k] * read(image.ghost, k));
    }
    // set(ghost, k, value of its node at [k] with the sign of the image).
    template <class Read, class Set> void reflectValues(int field, Read&& read, Set&& set) const {
        for (const Image& image : images_)
            for (int k = 0; image.field == field && k < Dim; ++k)
                set(image.ghost, k, image.sign[k] * read(image.node, k));
    }

    bool isRoller(int constraint) const {
        bool is = false;
        for (const auto& sides : rollers_)
            for (short roller : sides) is |= constraint >= 0 && roller == constraint;
        return is;
    }
    // The constraint that mirrors an image along an axis, -1: none.
    int rollerOf(const Grid<Dim>& grid, const Image& image, int axis) const {
        return image.sign[axis] > 0 ? -1 : rollers_[axis][grid.indices(image.ghost)[axis] > grid.ghost];
    }

  private:
    std::array<std::array<short, 2>, Dim>
        rollers_; // constraint at the lower and upper face of each axis, -1: none
    std::vector<Image> images_;

    // The axis across a roller; -1 for anything else.
    static int rollerAxis(const Constraint& constraint) {
        int axis = -1, held = 0;
        for (int k = 0; k < int(constraint.velocity.size()); ++k)
            if (!std::isnan(constraint.velocity[k])) {
                axis = k;
                ++held;
            }
        return constraint.isWall && constraint.active && held == 1 && !constraint.nodes.empty() ? axis : -1;
    }

    // The first line of ghost nodes behind a face; particles do not reach the second.
    static int lineBehind(const Grid<Dim>& grid, int axis, int side) {
        return side ? grid.ghost + grid.cells[axis] + 1 : grid.ghost - 1;
    }

    void findBehind(const Grid<Dim>& grid, int field, int axis, int side) {
        const int line = lineBehind(grid, axis, side);
        const auto& extents = grid.fields[field].extents;
        const bool isSlab = axis == Dim - 1;
        for (int slab = isSlab ? line : 0; slab < (isSlab ? line + 1 : grid.slabs()); ++slab) {
            auto extent = extents[slab];
            if (!isSlab) {
                if (line < extent.first[axis] || line > extent.last[axis]) continue;
                extent.first[axis] = extent.last[axis] = line;
            }
            grid.forNodes(extent, slab, [&](int ghost) { findImage(grid, field, ghost, axis); });
        }
    }

    // A ghost node behind two rollers is found behind the first. Particles that reach no node before it, for they lie
    // behind the roller themselves, have no image.
    void findImage(const Grid<Dim>& grid, int f, int ghost, int axis) {
        const auto& field = grid.fields[f];
        if (!(field.sum[ghost][NF::mass] > 0)) return;
        Index<Dim> index = grid.indices(ghost);
        Image image{f, ghost, ghost, Vec<Dim>::Ones(), field.sum[ghost]};
        for (int k = Dim - 1; k >= 0; --k)
            for (int side = 0; side < 2; ++side) {
                const short roller = rollers_[k][side];
                if (index[k] != lineBehind(grid, k, side) || roller < 0 || field.holder[ghost][k] != roller)
                    continue;
                const int step = side ? -2 : 2;
                index[k] += step;
                image.node += step * grid.strides[k];
                image.sign[k] = -1;
                break;
            }
        const auto& extent = field.extents[index[Dim - 1]];
        bool isImage = image.sign[axis] < 0;
        for (int k = 0; k < axis; ++k) isImage &= image.sign[k] > 0;
        for (int k = 0; k < Dim - 1; ++k)
            isImage &= index[k] >= extent.first[k] && index[k] <= extent.last[k];
        if (isImage) images_.push_back(image);
    }
};

} // namespace mpm
