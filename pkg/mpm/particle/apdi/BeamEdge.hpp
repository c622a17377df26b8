// SPDX-License-Identifier: GPL-2.0-or-later
// The line between two cross-sections A and B of a beam or plate, each a fibre from its right end to its left one:
// strain and curvature of the line, and shear. The angles theta of the fibres count from the chord, so that a rigid
// motion strains nothing, however large:
//     curvature (theta_B - theta_A)/L,  shear -(theta_A + theta_B)/2.
// Hinges at the ends turn the fibres by theta_A + psi_A and theta_B - psi_B instead.
#pragma once

#include "mpm/particle/apdi/APDIShape.hpp"
#include "mpm/state/SectionStiffness.hpp"

#include <Eigen/Geometry>

#include <cmath>

namespace mpm {

template <int Dim> class BeamEdge {
  public:
    enum Row { axial, curvature, shear, rows };
    using Point = Vec<Dim>;
    using Ends = std::array<Point, 4>;     // right ends of A and B, left ends of B and A
    using Gradient = std::array<Point, 4>; // over them

    struct Strained {
        std::array<double, rows> e{};
        std::array<Gradient, rows> gradient;
    };
    struct Place {
        Point across[2], chord; // of A and B, between their middles

        explicit Place(const Ends& x)
            : across{x[3] - x[0], x[2] - x[1]}, chord(0.5 * (x[1] + x[2] - x[0] - x[3])) {}
        double angle(int end) const { return std::atan2(-chord.dot(across[end]), turn(end).sine); }
        // Of the chord to a fibre.
        auto turn(int end) const {
            if constexpr (Dim == 2)
                return InPlane{chord[0] * across[end][1] - chord[1] * across[end][0]};
            else
                return InSpace(chord.cross(across[end]));
        }
    };

    // X: without strain.
    explicit BeamEdge(const Ends& X) : start_(X), length_(start_.chord.norm()) {}

    double length() const { return length_; }
    // Stiffness in shear of a piece of the length L, kN/m: with this compliance a straight one is exact.
    static double shearStiffness(double GA, double EI, double L) { return 1 / (1 / GA + L * L / (12 * EI)); }
    const Place& start() const { return start_; }

    // hinges: angles psi at both ends.
    Strained strained(const Ends& x, const double* hinges) const {
        const Place now(x);
        Strained s;
        for (auto& row : s.gradient) row.fill(Point::Zero());
        const double ell = now.chord.norm();
        s.e[axial] = ell / length_ - 1;
        addChord(s.gradient[axial], now.chord / (ell * length_));
        double theta[2];
        for (int end = 0; end < 2; ++end) {
            const Point& d = now.across[end];
            theta[end] = now.angle(end) - start_.angle(end);
            if (hinges) theta[end] += end == 0 ? hinges[0] : -hinges[1];
            // of the angle: that of the fibre less that of the chord
            Gradient turned;
            turned.fill(Point::Zero());
            const auto turn = now.turn(end);
            addAcross(turned, end, turn.of(d) / d.squaredNorm());
            addChord(turned, -turn.of(now.chord) / now.chord.squaredNorm());
            for (int a = 0; a < 4; ++a) {
                s.gradient[curvature][a] += (end == 0 ? -1 : 1) / length_ * turned[a];
                s.gradient[shear][a] -= 0.5 * turned[a];
            }
        }
        s.e[curvature] = (theta[1] - theta[0]) / length_;
        s.e[shear] = -0.5 * (theta[0] + theta[1]);
        return s;
    }

    static void addChord(Gradient& to, const Point& g) {
        for (int a = 0; a < 4; ++a) to[a] += (a == 1 || a == 2 ? 0.5 : -0.5) * g;
    }
    static void addAcross(Gradient& to, int end, const Point& g) {
        to[end == 0 ? 3 : 2] += g;
        to[end == 0 ? 0 : 1] -= g;
    }

  private:
    // How vectors move that turn from the chord to the fibre.
    struct InPlane {
        double sine; // times both lengths
        Point of(const Point& v) const { return Point(-v[1], v[0]); }
    };
    struct InSpace {
        double sine;
        Point axis;
        explicit InSpace(const Point& product) : sine(product.norm()), axis(product / sine) {}
        Point of(const Point& v) const { return axis.cross(v); }
    };

    Place start_;
    double length_;
};

} // namespace mpm
