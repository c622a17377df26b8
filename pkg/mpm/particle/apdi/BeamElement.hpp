// SPDX-License-Identifier: GPL-2.0-or-later
// A piece of a beam between two cross-sections, the sides 0-3 and 1-2 of a quadrilateral: what the positions of
// its corners x strain, and the energy
//     U = 1/2 sum_r k_r e_r^2
// with the rows e_r: strain and curvature of the middle line, and shear (BeamEdge.hpp), stretch of both cross-sections,
// and with axial symmetry strain and curvature round the axis. The compliance 1/(G A) + L^2/(12 E I) of the shear makes
// the straight element exact (MacNeal 1978).
#pragma once

#include "mpm/particle/apdi/BeamEdge.hpp"
#include "mpm/state/SectionState.hpp"

#include <algorithm>

namespace mpm {

class BeamElement {
    using Edge = BeamEdge<2>;

  public:
    static constexpr int corners = 4;
    // Angles psi of its two hinges, which all of its domains have.
    static constexpr int ofStack = 2, firstPlastic = hingeStart;
    static constexpr int placeOf(int, int variable) { return variable; }
    using Plastic = std::array<double, ofStack>;
    static constexpr int rowSets = 1; // each the task of another domain
    enum Row { axial, curvature, shear, pinchA, pinchB, hoop, hoopCurvature, rows };
    using Point = Vec<2>;
    using Gradient = std::array<Point, corners>; // over the positions of the corners

    struct Strained {
        std::array<double, rows> e{};
        std::array<Gradient, rows> gradient;
    };

    // X: corners without strain.
    BeamElement(const Corners<2>& X, const SectionStiffness& section, bool isRound) : edge_(ends(X)) {
        length_ = edge_.length();
        radius_ = X.rowwise().mean()[0];
        const double width = isRound ? 2 * M_PI * radius_ : 1; // m
        volume_ = width * length_;
        const double G = Edge::shearStiffness(section.GA, section.EI, length_);
        stiffness_ = {section.EA, section.EI, G, 0.5 * section.EA, 0.5 * section.EA};
        if (isRound) stiffness_[hoop] = section.EA, stiffness_[hoopCurvature] = section.EI;
        for (double& k : stiffness_) k *= volume_;
        limit_ = section.limitMoment * width;
    }

    double stiffness(int row) const { return stiffness_[row]; } // kN m (2D: per m)
    // Of a row: force in the section per metre of its width from k e, kN or kN m.
    double overVolume() const { return 1 / volume_; }

    // Of a spring that holds a point of an end section on its line, as stiff as the section against its stretch, kN/m.
    double stiffnessAtEnd() const { return stiffness_[pinchA] / edge_.start().across[0].squaredNorm(); }

    // What the corners strain.
    Strained strained(const Corners<2>& x, const Plastic& hinges) const {
        const auto line = edge_.strained(ends(x), hinges.data());
        Strained s;
        for (auto& row : s.gradient) row.fill(Point::Zero());
        std::copy(line.e.begin(), line.e.end(), s.e.begin()); // the first rows of both are the same
        std::copy(line.gradient.begin(), line.gradient.end(), s.gradient.begin());
        const Edge::Place now(ends(x));
        for (int end = 0; end < 2; ++end) {
            const Point& d = now.across[end];
            const double t = edge_.start().across[end].norm();
            s.e[pinchA + end] = d.norm() / t - 1;
            Edge::addAcross(s.gradient[pinchA + end], end, d / (d.norm() * t));
        }
        if (stiffness_[hoop] > 0) strainRing(now, x.rowwise().mean()[0], s);
        return s;
    }

    double energy(const Strained& s) const {
        double sum = 0;
        for (int r = 0; r < rows; ++r) sum += 0.5 * stiffness_[r] * s.e[r] * s.e[r];
        return sum;
    }

    // each(what, force): the forces in the section per metre of its width, with the signs of sectionForces: Q along the
    // normal to the right of the line, M with tension to its left.
    template <class Each> void forces(const Strained& s, int, Each&& each) const {
        const auto one = [&](SectionState what, double sign, int row) {
            each(what, sign * stiffness_[row] * s.e[row] * overVolume());
        };
        one(normalForce, 1, axial);
        one(shearForce, -1, shear);
        one(bendingMoment, -1, curvature);
        one(hoopForce, 1, hoop);
        one(hoopMoment, -1, hoopCurvature);
    }

    // Turns the hinges until no end has a larger moment than the section can take.
    void yield(const Strained& s, Plastic& hinges) const {
        if (std::isinf(limit_)) return;
        const double M = stiffness_[curvature] * s.e[curvature] / length_,
                     Q = 0.5 * stiffness_[shear] * s.e[shear];
        const std::array<double, 2> back = excess({-M - Q, M - Q});
        hinges[0] -= back[0];
        hinges[1] += back[1];
    }

  private:
    static constexpr double roundOff = 1e-12; // of the limit

    static Edge::Ends ends(const Corners<2>& x) { return {x.col(0), x.col(1), x.col(2), x.col(3)}; }

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

    // A ring of radius r whose normal has the radial part n: u/r0 and (n - n0)/r0.
    void strainRing(const Edge::Place& now, double radius, Strained& s) const {
        s.e[hoop] = radius / radius_ - 1;
        for (auto& g : s.gradient[hoop]) g = Point(0.25 / radius_, 0);
        for (int end = 0; end < 2; ++end) {
            const Point &d = now.across[end], &d0 = edge_.start().across[end];
            const double t = d.norm();
            s.e[hoopCurvature] += 0.5 / radius_ * (d[0] / t - d0[0] / d0.norm());
            Edge::addAcross(s.gradient[hoopCurvature], end,
                            0.5 / (radius_ * t) * (Point::Unit(0) - d[0] / (t * t) * d));
        }
    }

    Edge edge_;
    double length_, radius_, volume_, limit_;
    std::array<double, rows> stiffness_{};
};

} // namespace mpm
