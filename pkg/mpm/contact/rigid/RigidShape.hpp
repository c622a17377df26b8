// SPDX-License-Identifier: GPL-2.0-or-later
// Shapes of rigid bodies as signed distances: distance(x) < 0 inside, and its gradient, the outward normal.
// All that contact needs of a shape is this function in the frame of its body, and a box around it in space.
// Distances of box and triangle: Ericson 2005, Real-Time Collision Detection, ch. 5. In 2D z = 0 everywhere:
// a sphere is a disc, a capsule a segment.
#pragma once

#include "mpm/base/require.hpp"
#include "mpm/contact/rigid/HeightSurface.hpp"
#include "mpm/contact/rigid/RigidState.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <memory>

namespace mpm {

// What a shape is given by; members that its kind does not have stay zero. In the frame of the body.
struct ShapeRecord {
    int body = 0;
    std::string kind;                 // Sphere, Box, Wall, Capsule or Triangle
    Vec3 centre = Vec3::Zero();       // m; of a wall a point on its surface
    Vec3 halfSize = Vec3::Zero();     // m, half edges of a box
    Vec3 normal = Vec3::Zero();       // outward, of a wall
    Mat<3> vertices = Mat<3>::Zero(); // m, in columns: ends of a capsule, corners of a triangle
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity(); // of a box
    double radius = 0;                                               // m; of a triangle half its thickness

    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("body", "", row.body);
        visit("kind", "", row.kind);
        visit("centre", "m", row.centre);
        visit("halfSize", "m", row.halfSize);
        visit("normal", "-", row.normal);
        visit("vertices", "m", row.vertices);
        visit("orientation", "-", row.orientation);
        visit("radius", "m", row.radius);
    }
};

// Of a shape that is filled uniformly: its size (m3, m2 in 2D), and the integral of x x^T over it.
struct SecondMoment {
    double size = 0;
    Mat<3> moment = Mat<3>::Zero();
    SecondMoment& operator+=(const SecondMoment& other) {
        size += other.size;
        moment += other.moment;
        return *this;
    }
};

class RigidShape {
  public:
    enum Kind { Sphere, Box, Wall, Capsule, Triangle, HeightField };

    int body;
    Kind kind;

    // dim: of the scene; in 2D z is zero.
    RigidShape(const ShapeRecord& given, int dim)
        : body(given.body), kind(kindOf(given.kind)), point_{given.centre, Vec3::Zero(), Vec3::Zero()},
          radius_(given.radius) {
        if (kind == Capsule || kind == Triangle)
            for (int v = 0; v < 3; ++v) point_[v] = given.vertices.col(v);
        if (kind == Box) {
            point_[1] = given.halfSize;
            turn_ = given.orientation.normalized();
        }
        if (kind == Wall) point_[1] = given.normal.normalized();
        if (dim == 3) return;
        for (Vec3& p : point_) p[2] = 0;
        if (kind == Box) point_[1][2] = endless;
    }

    RigidShape(const HeightRecord& given, const double* heights)
        : body(given.body), kind(HeightField), point_{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()},
          ground_(std::make_shared<HeightSurface>(given, heights)) {}

    static Kind kindOf(const std::string& name) {
        static const char* const names[] = {"Sphere", "Box", "Wall", "Capsule", "Triangle"};
        for (int k = Sphere; k <= Triangle; ++k)
            if (name == names[k]) return Kind(k);
        throw InputError("RigidContact: a shape of the kind '" + name +
                         "' is not known; give Sphere, Box, Wall, Capsule or Triangle");
    }

    // Radius of a sphere around the position of the body that holds the shape, and whether all turns of the
    // body look the same.
    double extent() const {
        const double far =
            std::max(point_[0].norm(),
                     kind == Triangle ? std::max(point_[1].norm(), point_[2].norm()) : point_[1].norm());
        switch (kind) {
        case Wall:
        case HeightField:
            return std::numeric_limits<double>::infinity();
        case Box:
            return point_[0].norm() + point_[1].norm();
        case Sphere:
            return point_[0].norm() + radius_;
        default:
            return far + radius_;
        }
    }
    bool isCentredSphere() const { return kind == Sphere && point_[0].isZero(0); }

    // Of the shape as seen from where it is seen largest, m2 (2D: m): what the soil can touch at once. Of
    // a shape without end zero: not known.
    double facingArea(int dim) const {
        if (isEndless()) return 0;
        const RigidState unmoved;
        Vec3 lower, upper;
        bounds(unmoved, lower, upper);
        Vec3 size = upper - lower;
        if (dim == 2) return std::max(size[0], size[1]);
        std::sort(size.data(), size.data() + 3);
        return size[1] * size[2];
    }

    // Of a facet as of a plate that is no thinner than a thousandth of its size; of a shape without end nothing.
    SecondMoment secondMoment(int dim) const {
        if (isEndless()) return {};
        Vec3 centre = point_[0];
        Mat<3> about = Mat<3>::Zero(); // mean of x x^T about the centre
        double size = 0;
        if (kind == Box) {
            Vec3 half = point_[1];
            if (dim == 2) half[2] = 0;
            const Mat<3> R = turn_.toRotationMatrix();
            about = R * Vec3(half.cwiseAbs2() / 3).asDiagonal() * R.transpose();
            size = dim == 2 ? half[0] * half[1] : half.prod();
            size *= 1 << dim;
        } else if (kind == Sphere) {
            about.diagonal().head(dim).setConstant(radius_ * radius_ / (dim + 2));
            size = dim == 2 ? M_PI * radius_ * radius_ : 4.0 / 3 * M_PI * radius_ * radius_ * radius_;
        } else {
            const int corners = kind == Capsule ? 2 : 3;
            centre.setZero();
            for (int v = 0; v < corners; ++v) centre += point_[v] / corners;
            for (int v = 0; v < corners; ++v)
                about += (point_[v] - centre) * (point_[v] - centre).transpose() / (kind == Capsule ? 6 : 12);
            const double edge = std::sqrt(about.trace()), thick = std::max(radius_, 1e-3 * edge);
            about.diagonal().head(dim).array() += thick * thick / 3;
            size = 2 * thick *
                   (kind == Capsule ? (point_[1] - point_[0]).norm()
                                    : 0.5 * (point_[1] - point_[0]).cross(point_[2] - point_[0]).norm());
        }
        return {size, size * (about + centre * centre.transpose())};
    }

    double thickness() const { return 2 * radius_; }
    bool isThin() const { return kind == Capsule || kind == Triangle; }
    bool isEndless() const { return kind == Wall || kind == HeightField; }

    // Whether all of the shape is further than `radius` from x; asked before the distance where that takes longer.
    bool isBeyond(const Vec3& x, double radius) const {
        return kind == HeightField ? ground_->isBeyond(x, radius) : nearest(x).distance > radius;
    }

    // What lies so far above a height field; of other shapes nothing is known.
    Clearance clearance(const Vec3& x, double around, double radius) const {
        return kind == HeightField ? ground_->clearance(x, around, radius) : Clearance();
    }

    // within: further away the distance is only known to be larger.
    Surface nearest(const Vec3& x, double within = std::numeric_limits<double>::infinity()) const {
        switch (kind) {
        case Sphere:
            return around(x, point_[0], Vec3::UnitY());
        case Wall:
            return {point_[1].dot(x - point_[0]), point_[1]};
        case Box:
            return nearestOfBox(x);
        case Capsule:
            return around(x, onSegment(x, point_[0], point_[1]), sideOfSegment());
        case HeightField:
            return ground_->nearest(x, within);
        default:
            return around(x, onTriangle(x), sideOfTriangle());
        }
    }

    // f(surface) for the directions in which a box of some extent can be clear of the shape: that of the
    // nearest point, and the flat sides. A box beside an edge is clear along a side although its corner, seen
    // along the diagonal, is not.
    template <class F> void directions(const Vec3& x, const Surface& nearest, F&& f) const {
        f(nearest);
        if (nearest.distance <= 0) return;
        if (kind == Box) {
            const Vec3 local = turn_.conjugate() * (x - point_[0]);
            for (int k = 0; k < 3; ++k)
                f(Surface{std::abs(local[k]) - point_[1][k],
                          turn_ * Vec3((local[k] < 0 ? -1 : 1) * Vec3::Unit(k))});
        }
        if (isThin()) {
            const Vec3 side = kind == Capsule ? sideOfSegment() : sideOfTriangle();
            const double height = side.dot(x - point_[0]);
            f(Surface{std::abs(height) - radius_, height < 0 ? Vec3(-side) : side});
        }
    }

    // Box in space around the shape.
    void bounds(const RigidState& at, Vec3& lower, Vec3& upper) const {
        const double far = std::numeric_limits<double>::infinity();
        if (isEndless()) {
            lower.setConstant(-far);
            upper.setConstant(far);
            return;
        }
        const Eigen::Matrix3d R = at.orientation.toRotationMatrix();
        lower.setConstant(far);
        upper.setConstant(-far);
        for (int v = 0; v < (kind == Triangle ? 3 : kind == Capsule ? 2 : 1); ++v) {
            const Vec3 x = at.position + R * point_[v];
            lower = lower.cwiseMin(x);
            upper = upper.cwiseMax(x);
        }
        Vec3 reach = Vec3::Constant(radius_);
        if (kind == Box) reach = (R * turn_.toRotationMatrix()).cwiseAbs() * point_[1];
        lower -= reach;
        upper += reach;
    }

  private:
    static constexpr double endless = 1e150; // m, of a 2D box along z; its square is still a number

    Vec3 point_[3]; // centre or vertices; of a box its half edges second, of a wall its normal
    Eigen::Quaterniond turn_ = Eigen::Quaterniond::Identity();
    double radius_ = 0;
    std::shared_ptr<const HeightSurface> ground_; // of a height field

    // Rounded by radius_ about the point c of a core; `side`: the normal where x lies on the core.
    Surface around(const Vec3& x, const Vec3& c, const Vec3& side) const {
        const Vec3 away = x - c;
        const double r = away.norm();
        return {r - radius_, r > 0 ? Vec3(away / r) : side};
    }

    Surface nearestOfBox(const Vec3& x) const {
        const Vec3 local = turn_.conjugate() * (x - point_[0]), over = local.cwiseAbs() - point_[1];
        Vec3 normal;
        double distance = over.maxCoeff();
        if (distance > 0) {
            normal = over.cwiseMax(0.0);
            distance = normal.norm();
            normal /= distance;
        } else { // inside: the nearest face
            normal.setZero();
            int face;
            over.maxCoeff(&face);
            normal[face] = 1;
        }
        for (int k = 0; k < 3; ++k)
            if (local[k] < 0) normal[k] = -normal[k];
        return {distance, turn_ * normal};
    }

    Vec3 sideOfSegment() const {
        const Vec3 along = point_[1] - point_[0], side = along.cross(Vec3::UnitZ());
        return side.norm() > 0 ? side.normalized() : Vec3(Vec3::UnitX());
    }

    Vec3 sideOfTriangle() const { return (point_[1] - point_[0]).cross(point_[2] - point_[0]).normalized(); }

    static Vec3 onSegment(const Vec3& x, const Vec3& a, const Vec3& b) {
        const double t = (x - a).dot(b - a) / (b - a).squaredNorm();
        return a + std::clamp(t, 0.0, 1.0) * (b - a);
    }

    Vec3 onTriangle(const Vec3& x) const {
        const Vec3 &a = point_[0], &b = point_[1], &c = point_[2];
        const Vec3 n = (b - a).cross(c - a), foot = x - n.dot(x - a) / n.squaredNorm() * n;
        const auto isInside = [&](const Vec3& p, const Vec3& q) {
            return n.dot((q - p).cross(foot - p)) >= 0;
        };
        if (isInside(a, b) && isInside(b, c) && isInside(c, a)) return foot;
        Vec3 best = onSegment(x, a, b);
        for (const Vec3& other : {onSegment(x, b, c), onSegment(x, c, a)})
            if ((x - other).squaredNorm() < (x - best).squaredNorm()) best = other;
        return best;
    }
};

} // namespace mpm
