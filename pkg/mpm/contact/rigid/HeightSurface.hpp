// SPDX-License-Identifier: GPL-2.0-or-later
// Ground given by heights on a raster (2D: a profile), solid below. The surface is the bilinear one through the
// heights, averaged over a cell of the raster around each place: quadratic B-splines. So it has a normal
// everywhere, a plane stays a plane to round-off, and no distance takes longer than a few look-ups. Beyond the
// raster it goes on straight.
#pragma once

#include "mpm/base/require.hpp"
#include "mpm/base/types.hpp"
#include "mpm/contact/rigid/Surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace mpm {

// What a height field is given by, in the frame of its body: heights are along the last axis of the scene.
struct HeightRecord {
    int body = 0, columns = 0, rows = 1;                // rows: along the second axis; 1 in 2D
    Vec3 origin = Vec3::Zero(), spacing = Vec3::Ones(); // m; of the first height, between two

    template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
        visit("body", "", row.body);
        visit("columns", "", row.columns);
        visit("rows", "", row.rows);
        visit("origin", "m", row.origin);
        visit("spacing", "m", row.spacing);
    }
    size_t count() const { return size_t(columns) * rows; }
};

class HeightSurface {
  public:
    // heights: m, column by column (the second axis fastest).
    HeightSurface(const HeightRecord& given, const double* heights)
        : size_{given.columns, given.rows}, axes_(given.rows > 1 ? 2 : 1) {
        for (int k = 0; k < axes_; ++k) {
            origin_[k] = given.origin[k];
            spacing_[k] = given.spacing[k];
            overSpacing_[k] = 1 / given.spacing[k];
        }
        extend(heights);
        findCurvature();
    }

    // Whether all of the ground is further away than `radius` from a place above it: so near it is no further
    // from the tangent plane than by its curvature.
    bool isBeyond(const Vec3& x, double radius) const {
        return isAbove(x, at(x), radius + 0.5 * curvature_ * radius * radius);
    }

    // For the places no further than `around` from x: those are further than `radius` away that the tangent plane below
    // x, lifted for the curvature, says are.
    Clearance clearance(const Vec3& x, double around, double radius) const {
        const Place below = at(x);
        const double steepest = std::hypot(below.slope[0], below.slope[1]) + curvature_ * around;
        Vec3 up(-below.slope[0], -below.slope[1], 0);
        up[axes_] = 1;
        return {up, x[axes_] - below.height,
                0.5 * curvature_ * around * around +
                    (radius + 0.5 * curvature_ * radius * radius) * std::sqrt(1 + steepest * steepest)};
    }

    // The second foot of the perpendicular follows from the normal at the first: what is left of the error is
    // (distance over radius of curvature) squared, and nothing on a plane. Of a place further away than `within`
    // the first is enough.
    Surface nearest(const Vec3& x, double within = std::numeric_limits<double>::infinity()) const {
        const Place below = at(x);
        const Surface first = asPlane(x, x, below);
        if (first.distance > within + 0.5 * curvature_ * within * within) return first;
        const Vec3 foot = x - first.distance * first.normal;
        return asPlane(x, foot, at(foot));
    }

  private:
    struct Place {
        double height, slope[2];
        double steepness() const { return 1 + slope[0] * slope[0] + slope[1] * slope[1]; }
    };

    int size_[2], axes_;
    double origin_[2] = {0, 0}, spacing_[2] = {1, 1}, overSpacing_[2] = {1, 1};
    double curvature_ = 0;        // 1/m, bound of the second derivative of the heights along any line
    std::vector<double> heights_; // with a row more on every side

    double heightAt(int i, int j) const { return heights_[size_t(i + 1) * (size_[1] + 2) + j + 1]; }

    // The second derivatives are means of the second differences of the heights.
    void findCurvature() {
        double bent[2] = {0, 0}, twisted = 0; // along each axis, and both
        for (int i = 0; i < size_[0]; ++i)
            for (int j = 0; j < size_[1]; ++j) {
                const double here = 2 * heightAt(i, j);
                bent[0] = std::max(bent[0], std::abs(heightAt(i + 1, j) - here + heightAt(i - 1, j)));
                bent[1] = std::max(bent[1], std::abs(heightAt(i, j + 1) - here + heightAt(i, j - 1)));
                twisted = std::max(twisted, std::abs(heightAt(i + 1, j + 1) - heightAt(i + 1, j) -
                                                     heightAt(i, j + 1) + heightAt(i, j)));
            }
        const double x = spacing_[0], y = spacing_[1], both = twisted / (x * y);
        curvature_ = std::hypot(bent[0] / (x * x), bent[1] / (y * y), std::sqrt(2.0) * both);
    }

    void extend(const double* heights) {
        const int rows = size_[1] + 2;
        heights_.resize(size_t(size_[0] + 2) * rows);
        for (int i = 0; i < size_[0]; ++i) {
            double* row = &heights_[size_t(i + 1) * rows];
            std::copy_n(heights + size_t(i) * size_[1], size_[1], row + 1);
            row[0] = axes_ > 1 ? 2 * row[1] - row[2] : row[1];
            row[rows - 1] = axes_ > 1 ? 2 * row[rows - 2] - row[rows - 3] : row[1];
        }
        for (int j = 0; j < rows; ++j) {
            const auto of = [&](int i) -> double& { return heights_[size_t(i) * rows + j]; };
            of(0) = 2 * of(1) - of(2);
            of(size_[0] + 1) = 2 * of(size_[0]) - of(size_[0] - 1);
        }
    }

    struct Weights {
        int middle;
        double value[3], slope[3]; // slope: 1/m
        double beyond;             // m, from the raster
    };
    Weights weightsAt(double x, int axis) const {
        const double over = overSpacing_[axis], inCells = (x - origin_[axis]) * over;
        const double u = std::clamp(inCells, 0.0, size_[axis] - 1.0);
        const int middle = int(u + 0.5);
        const double t = u - middle, before = 0.5 - t, after = 0.5 + t;
        return {middle,
                {0.5 * before * before, 0.75 - t * t, 0.5 * after * after},
                {-before * over, -2 * t * over, after * over},
                (inCells - u) * spacing_[axis]};
    }

    // Whether a place is further than `radius` above the tangent plane at the ground below it, `here`.
    bool isAbove(const Vec3& x, const Place& here, double radius) const {
        const double over = x[axes_] - here.height;
        return over > 0 && over * over > radius * radius * here.steepness();
    }

    // The distance from the tangent plane at the ground above or below a place, `here`.
    Surface asPlane(const Vec3& x, const Vec3& place, const Place& here) const {
        const double along = 1 / std::sqrt(here.steepness());
        Vec3 normal(-here.slope[0] * along, -here.slope[1] * along, 0);
        normal[axes_] = along;
        Vec3 foot = place;
        foot[axes_] = here.height;
        return {normal.dot(x - foot), normal};
    }

    Place at(const Vec3& x) const {
        const Weights a = weightsAt(x[0], 0);
        if (axes_ == 1) {
            const double* h = &heights_[size_t(a.middle) * 3 + 1]; // of three equal rows
            const double slope = a.slope[0] * h[0] + a.slope[1] * h[3] + a.slope[2] * h[6];
            const double mean = a.value[0] * h[0] + a.value[1] * h[3] + a.value[2] * h[6];
            return {mean + a.beyond * slope, {slope, 0}};
        }
        const Weights b = weightsAt(x[1], 1);
        const size_t rows = size_[1] + 2;
        const double* h = &heights_[a.middle * rows + b.middle];
        Place here{0, {0, 0}};
        for (int i = 0; i < 3; ++i, h += rows) {
            const double across = b.value[0] * h[0] + b.value[1] * h[1] + b.value[2] * h[2];
            const double slope = b.slope[0] * h[0] + b.slope[1] * h[1] + b.slope[2] * h[2];
            here.height += a.value[i] * across;
            here.slope[0] += a.slope[i] * across;
            here.slope[1] += a.value[i] * slope;
        }
        here.height += a.beyond * here.slope[0] + b.beyond * here.slope[1];
        return here;
    }
};

} // namespace mpm
