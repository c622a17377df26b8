// SPDX-License-Identifier: GPL-2.0-or-later
// A piece of a beam between two cross-sections, the sides 0-3 and 1-2 of a quadrilateral: what the positions of
// its corners x strain, and the energy
//     U = 1/2 sum_r k_r e_r^2
// with the rows e_r: strain and curvature of the middle line, shear, stretch of both cross-sections, and with axial
// symmetry strain and curvature round the axis. The angles theta of the cross-sections count from the chord, so that a
// rigid motion strains nothing, however large:
//     curvature (theta_B - theta_A)/L,  shear -(theta_A + theta_B)/2,  1/(G A) + L^2/(12 E I) its compliance,
// which makes the straight element exact (MacNeal 1978). Hinges at its ends turn the sections by theta_A + psi_A and
// theta_B - psi_B instead.
#pragma once

#include "mpm/particle/apdi/APDIShape.hpp"
#include "mpm/state/SectionStiffness.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

class BeamElement {
  public:
    enum Row { axial, curvature, shear, pinchA, pinchB, hoop, hoopCurvature, rows };
    using Point = Vec<2>;
    using Gradient = std::array<Point, 4>; // over the positions of the corners

    struct Strained {
        std::array<double, rows> e{};
        std::array<Gradient, rows> gradient;
    };

    // X: corners without strain.
    BeamElement(const Corners<2>& X, const SectionStiffness& section, bool isRound) : start_(X) {
        length_ = start_.chord.norm();
        radius_ = start_.middle[0];
        const double width = isRound ? 2 * M_PI * radius_ : 1; // m
        volume_ = width * length_;
        const double G = 1 / (1 / section.GA + length_ * length_ / (12 * section.EI));
        stiffness_ = {section.EA, section.EI, G, 0.5 * section.EA, 0.5 * section.EA};
        if (isRound) stiffness_[hoop] = section.EA, stiffness_[hoopCurvature] = section.EI;
        for (double& k : stiffness_) k *= volume_;
        limit_ = section.limitMoment * width;
    }

    double stiffness(int row) const { return stiffness_[row]; } // kN m (2D: per m)
    // Of a row: force in the section per metre of its width from k e, kN or kN m.
    double overVolume() const { return 1 / volume_; }

    // Of a spring that holds a point of an end section on its line, as stiff as the section against its stretch, kN/m.
    double stiffnessAtEnd() const { return stiffness_[pinchA] / start_.across[0].squaredNorm(); }

    // What the corners strain; hinges: angles psi at both ends.
    Strained strained(const Corners<2>& x, const double hinges[2]) const {
        const Place now(x);
        Strained s;
        for (auto& row : s.gradient) row.fill(Point::Zero());
        const double ell = now.chord.norm();
        s.e[axial] = ell / length_ - 1;
        addChord(s.gradient[axial], now.chord / (ell * length_));
        double theta[2];
        for (int end = 0; end < 2; ++end) {
            const Point d = now.across[end];
            theta[end] = now.angle(end) - start_.angle(end) + (end == 0 ? hinges[0] : -hinges[1]);
            const double t = start_.across[end].norm();
            s.e[pinchA + end] = d.norm() / t - 1;
            addAcross(s.gradient[pinchA + end], end, d / (d.norm() * t));
            // of the angle: that of the section less that of the chord
            Gradient turned;
            turned.fill(Point::Zero());
            addAcross(turned, end, Point(-d[1], d[0]) / d.squaredNorm());
            addChord(turned, Point(now.chord[1], -now.chord[0]) / now.chord.squaredNorm());
            for (int a = 0; a < 4; ++a) {
                s.gradient[curvature][a] += (end == 0 ? -1 : 1) / length_ * turned[a];
                s.gradient[shear][a] -= 0.5 * turned[a];
            }
        }
        s.e[curvature] = (theta[1] - theta[0]) / length_;
        s.e[shear] = -0.5 * (theta[0] + theta[1]);
        if (stiffness_[hoop] > 0) strainRing(now, s);
        return s;
    }

    double energy(const Strained& s) const {
        double sum = 0;
        for (int r = 0; r < rows; ++r) sum += 0.5 * stiffness_[r] * s.e[r] * s.e[r];
        return sum;
    }

    // Turns the hinges until no end has a larger moment than the section can take.
    void yield(const Strained& s, double hinges[2]) const {
        if (std::isinf(limit_)) return;
        const double M = stiffness_[curvature] * s.e[curvature] / length_,
                     Q = 0.5 * stiffness_[shear] * s.e[shear];
        const std::array<double, 2> back = excess({-M - Q, M - Q});
        hinges[0] -= back[0];
        hinges[1] += back[1];
    }

  private:
    static constexpr double roundOff = 1e-12; // of the limit

    // By which angles the ends turn back so that the moments m, of their angles theta, keep to the limit: one end
    // alone if that is enough, else both.
    std::array<double, 2> excess(const std::array<double, 2>& m) const {
        const double bending = stiffness_[curvature] / (length_ * length_),
                     sideways = 0.25 * stiffness_[shear];
        const double own = sideways + bending, other = sideways - bending; // dm/dtheta
        const auto beyond = [&](double moment) {
            const double more = std::abs(moment) - limit_;
            return more > roundOff * limit_ ? std::copysign(more, moment) : 0.0;
        };
        const double alone[2] = {beyond(m[0]), beyond(m[1])};
        if (alone[0] == 0 && alone[1] == 0) return {0, 0};
        double over[2] = {alone[0], alone[1]};
        for (int end = 0; end < 2; ++end) {
            const double back = alone[end] / own, rest = beyond(m[1 - end] - other * back);
            if (back != 0 && rest == 0)
                return end == 0 ? std::array<double, 2>{back, 0} : std::array<double, 2>{0, back};
            if (back != 0 && alone[1 - end] == 0) over[1 - end] = m[1 - end] - std::copysign(limit_, rest);
        }
        const double det = own * own - other * other;
        return {(own * over[0] - other * over[1]) / det, (own * over[1] - other * over[0]) / det};
    }

    struct Place {
        Point across[2], chord, middle; // of the ends A and B, between their middles, of all

        explicit Place(const Corners<2>& x)
            : across{x.col(3) - x.col(0), x.col(2) - x.col(1)},
              chord(0.5 * (x.col(1) + x.col(2) - x.col(0) - x.col(3))), middle(x.rowwise().mean()) {}
        // Of the normal of a section, from the chord.
        double angle(int end) const {
            const Point& d = across[end];
            return std::atan2(-chord.dot(d), chord[0] * d[1] - chord[1] * d[0]);
        }
    };

    static void addChord(Gradient& to, const Point& g) {
        for (int a = 0; a < 4; ++a) to[a] += (a == 1 || a == 2 ? 0.5 : -0.5) * g;
    }
    static void addAcross(Gradient& to, int end, const Point& g) {
        to[end == 0 ? 3 : 2] += g;
        to[end == 0 ? 0 : 1] -= g;
    }

    // A ring of radius r whose normal has the radial part n: u/r0 and (n - n0)/r0.
    void strainRing(const Place& now, Strained& s) const {
        s.e[hoop] = now.middle[0] / radius_ - 1;
        for (auto& g : s.gradient[hoop]) g = Point(0.25 / radius_, 0);
        for (int end = 0; end < 2; ++end) {
            const Point &d = now.across[end], &d0 = start_.across[end];
            const double t = d.norm();
            s.e[hoopCurvature] += 0.5 / radius_ * (d[0] / t - d0[0] / d0.norm());
            addAcross(s.gradient[hoopCurvature], end,
                      0.5 / (radius_ * t) * (Point::Unit(0) - d[0] / (t * t) * d));
        }
    }

    Place start_;
    double length_, radius_, volume_, limit_;
    std::array<double, rows> stiffness_{};
};

} // namespace mpm
