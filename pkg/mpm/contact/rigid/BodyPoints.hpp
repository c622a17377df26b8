// SPDX-License-Identifier: GPL-2.0-or-later
// The points of a body that a rigid body can touch: the boxes of uGIMP particles, or the boundary vertices of
// a mesh. And the broad phase: the points are kept in the cells of the grid, and a shape is asked for its
// distance once per cell.
#pragma once

#include "mpm/contact/BoundaryFacets.hpp"
#include "mpm/contact/rigid/RigidShape.hpp"
#include "mpm/scene/Scene.hpp"
#include "mpm/state/Bins.hpp"

namespace mpm {

template <int Dim> class BodyPoints {
  public:
    // Least inertial mass of a point over the area it stands for, Mg/m2: what bounds the stiffness of
    // contact.
    double massPerArea() const { return massPerArea_; }

    // Largest area that a point stands for, m2 (2D: m).
    double largestArea() const { return largestArea_; }

    // Once per step.
    void update(Body<Dim>& body, const Grid<Dim>& grid) {
        isMeshed_ = body.type->isMeshed();
        const bool isNew =
            body_ != &body || body.particles.size() != particles_ || body.inertiaScale != inertiaScale_;
        body_ = &body;
        if (isNew) weighsByHats_ = body.type->className() == "UGIMP";
        particles_ = body.particles.size();
        inertiaScale_ = body.inertiaScale;
        half_ = isMeshed_ ? Vec<Dim>(Vec<Dim>::Zero()) : body.domains->boxes()->halfSize();
        for (int k = 0; k < 3 && !isMeshed_; ++k) overHalf_[k] = 1 / half(k);
        position_ = isMeshed_ ? &body.domains->mesh()->vertexPositions() : &body.particles.position;
        if (isNew) isMeshed_ ? takeVertices() : takeBoxes();
        if (isMeshed_) takeAreas(*position_);
        if (isNew || haveDrifted()) fillCells(grid);
    }

    int count() const { return isMeshed_ ? int(vertex_.size()) : particles_; }
    // What the solver knows point i by, and what it keeps for good.
    int index(int i) const { return isMeshed_ ? vertex_[i] : i; }
    int64_t id(int i) const { return isMeshed_ ? vertex_[i] : body_->particles.id.integers()[i]; }
    double mass(int i) const {
        return isMeshed_ ? mass_[i] : inertiaScale_ * body_->particles.mass.plane()[i];
    }
    Vec3 position(int i) const { return spatial(*position_, index(i)); }

    // Whether the weight of a node is the mean of its hat function over the box.
    bool weighsByHats() const { return weighsByHats_; }

    // Along n from the centre to the surface of the ellipsoid inscribed in a box, m; a vertex has no extent.
    // A body that touches a flat row of boxes overlaps with none of their ellipsoids, but with the corners of
    // those beside the place.
    double halfAlong(const Vec3& n) const {
        if (isMeshed_) return 0;
        return 1 / n.cwiseProduct(overHalf_).norm();
    }

    // From the centre to where a normal force acts on a box of that stretch along n: within the box.
    Vec3 armAlong(const Vec3& n, double stretch) const { return -std::min(stretch, 1.0) * halfAlong(n) * n; }

    // How wide a point is along n, m: a vertex as wide as its share of the facets.
    double width(int i, const Vec3& n) const {
        return isMeshed_ ? std::pow(area_[i], 1.0 / (Dim - 1)) : 2 * halfAlong(n);
    }

    // Along n from the centre to the surface of the box itself, m: half the edge along an axis, more on a
    // diagonal.
    double exitAlong(const Vec3& n) const {
        if (isMeshed_) return 0;
        double s = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k) s = std::min(s, half(k) / std::abs(n[k]));
        return s;
    }

    // How much thicker than at first a box may be that stays in touch: contact looks for points so far away.
    static constexpr double mostStretch = 0.5;

    // How far from its centre a point may touch what is up to `near` beyond it, m.
    double mostReach(double near) const { return near + (1 + mostStretch) * half_.maxCoeff(); }

    // Area that point i stands for under a normal n: of a vertex its share of the facets, of a box volume
    // over extent.
    double area(int i, const Vec3& n) const {
        return isMeshed_ ? area_[i] : body_->particles.initialVolume.plane()[i] / (2 * halfAlong(n));
    }

    // Makes a box so large that it holds all points and their extents.
    void widen(const Grid<Dim>& grid, Vec3& lower, Vec3& upper) const {
        if (count() == 0) return;
        const double reach = this->reach(grid);
        for (int k = 0; k < Dim; ++k) {
            lower[k] = std::min(lower[k], cells_.lowerEnd(grid, k) - reach);
            upper[k] = std::max(upper[k], cells_.upperEnd(grid, k) + reach);
        }
    }

    // f(i) for the points that may touch a shape; others, too.
    template <class F>
    void near(const RigidShape& shape, const RigidState& at, const Grid<Dim>& grid, F&& f) const {
        const double reach = this->reach(grid);                        // of a point,
        const double radius = 0.5 * grid.largestCell().norm() + reach; // and of a cell with its points
        const Eigen::Quaterniond back = at.orientation.conjugate();
        Vec3 lower, upper;
        shape.bounds(at, lower, upper);
        lower.array() -= reach;
        upper.array() += reach;
        Index<Dim> first, last;
        if (!cells_.range(grid, lower.head<Dim>(), upper.head<Dim>(), first, last)) return;
        bool isSmall = true; // few cells could be left out then
        for (int k = 0; k < Dim; ++k) isSmall &= last[k] - first[k] < cellsAskedAlways;
        const Bins& bins = cells_.bins();
        CellBins<Dim>::anyOf(grid, first, last, [&](int bin, const Index<Dim>& cell) {
            if (bins.begin(bin) == bins.end(bin)) return false;
            Vec3 x = Vec3::Zero();
            x.head<Dim>() = CellBins<Dim>::centre(grid, cell);
            const Vec3 local = back * (x - at.position);
            if (!isSmall && shape.isBeyond(local, radius)) return false;
            const Clearance clear = shape.clearance(local, radius - reach, reach);
            const Vec3 up = at.orientation * clear.up;
            for (int j = bins.begin(bin); j < bins.end(bin); ++j) {
                bool isNear = true;
                double over = clear.over;
                for (int k = 0; k < Dim; ++k) {
                    isNear &= inBin_[k][j] >= lower[k] && inBin_[k][j] <= upper[k];
                    over += up[k] * (inBin_[k][j] - x[k]);
                }
                if (isNear && over <= clear.most) f(bins.point(j));
            }
            return false;
        });
    }

    // How far from a point contact may look for it, in cells: particles get ahead of the strain by less.
    static constexpr double mostShift = 0.01;

  private:
    const Body<Dim>* body_ = nullptr;
    const Field* position_ = nullptr;
    bool isMeshed_ = false, weighsByHats_ = false;
    int particles_ = -1;
    double inertiaScale_ = 0, massPerArea_ = 0, largestArea_ = 0;
    Vec<Dim> half_ = Vec<Dim>::Zero();
    Vec3 overHalf_ = Vec3::Zero(); // 1/m, of boxes

    // Of a mesh.
    BoundaryFacets<Dim> boundary_;
    std::vector<int> vertex_, place_; // boundary vertices, and the place of each vertex among them
    std::vector<double> area_, mass_;

    // Range of cells along each axis up to which they are not asked one by one: the points in them are asked
    // as quickly.
    static constexpr int cellsAskedAlways = 4;
    // How far a point may move before the cells are filled anew, in cells.
    static constexpr double mostDrift = 0.1;

    // As the points stood when the cells were filled.
    CellBins<Dim> cells_;
    std::vector<double> filledAt_[Dim], inBin_[Dim]; // in the order of the points, and of the bins

    double reach(const Grid<Dim>& grid) const { // of a point, m
        return (1 + mostStretch) * half_.maxCoeff() + mostShift * grid.smallestCell().minCoeff() +
               drift(grid);
    }
    // Out of the plane: for a body beside it.
    double half(int k) const { return k < Dim ? half_[k] : half_.maxCoeff(); }
    static double drift(const Grid<Dim>& grid) { return mostDrift * grid.smallestCell().minCoeff(); }
    static Vec3 spatial(const Field& field, int i) {
        Vec3 x = Vec3::Zero();
        for (int k = 0; k < Dim; ++k) x[k] = field.plane(k)[i];
        return x;
    }

    void takeBoxes() {
        const double least = half_.minCoeff();
        massPerArea_ = std::numeric_limits<double>::max();
        largestArea_ = 0;
        for (int p = 0; p < particles_; ++p) {
            const double V = body_->particles.initialVolume.plane()[p];
            massPerArea_ = std::min(massPerArea_, mass(p) * 2 * least / V);
            largestArea_ = std::max(largestArea_, V / (2 * least));
        }
    }

    void takeVertices() {
        boundary_.find(*body_->domains);
        place_.assign(position_->size(), -1);
        vertex_.clear();
        for (auto& facet : boundary_.facets)
            for (int v : facet) place_[v] = 0;
        for (int v = 0; v < int(place_.size()); ++v) {
            if (place_[v] < 0) continue;
            place_[v] = int(vertex_.size());
            vertex_.push_back(v);
        }
        mass_.assign(vertex_.size(), 0.0);
        const std::vector<int>& corner = body_->domains->mesh()->cornerTable();
        for (size_t a = 0; a < corner.size(); ++a)
            if (const int i = place_[corner[a]]; i >= 0)
                mass_[i] += inertiaScale_ * body_->particles.mass.plane()[a / corners<Dim>] / corners<Dim>;
        for (Field* field : body_->domains->fields()) // a restart finds the same stiffness
            if (field->name == "vertexReference") takeAreas(*field);
        massPerArea_ = std::numeric_limits<double>::max();
        largestArea_ = 0;
        for (size_t i = 0; i < vertex_.size(); ++i) {
            massPerArea_ = std::min(massPerArea_, mass_[i] / area_[i]);
            largestArea_ = std::max(largestArea_, area_[i]);
        }
    }

    // Each facet's area in equal parts to its vertices, which are at `position`.
    void takeAreas(const Field& position) {
        area_.assign(vertex_.size(), 0.0);
        for (auto& facet : boundary_.facets) {
            Vec3 X[4];
            for (int a = 0; a < boundary_.size; ++a) X[a] = spatial(position, facet[a]);
            const double area =
                Dim == 2 ? (X[1] - X[0]).norm() : 0.5 * (X[2] - X[0]).cross(X[3] - X[1]).norm();
            for (int v : facet) area_[place_[v]] += area / boundary_.size;
        }
    }

    bool haveDrifted() const {
        const double allowed = drift(body_->domains->grid) / std::sqrt(double(Dim));
        for (int k = 0; k < Dim; ++k) {
            const double *x = position_->plane(k), *before = filledAt_[k].data();
            double most = 0;
            if (isMeshed_)
                for (int i = 0; i < count(); ++i) most = std::max(most, std::abs(x[vertex_[i]] - before[i]));
            else
#pragma omp simd reduction(max : most)
                for (int i = 0; i < particles_; ++i) most = std::max(most, std::abs(x[i] - before[i]));
            if (most > allowed) return true;
        }
        return false;
    }

    void fillCells(const Grid<Dim>& grid) {
        const int n = count();
        for (int k = 0; k < Dim; ++k) {
            filledAt_[k].resize(n);
            for (int i = 0; i < n; ++i) filledAt_[k][i] = position_->plane(k)[index(i)];
        }
        cells_.fill(grid, n, [&](int i, int k) { return filledAt_[k][i]; });
        for (int k = 0; k < Dim; ++k) {
            inBin_[k].resize(n);
            for (int j = 0; j < n; ++j) inBin_[k][j] = filledAt_[k][cells_.bins().point(j)];
        }
    }
};

} // namespace mpm
