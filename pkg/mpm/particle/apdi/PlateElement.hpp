// SPDX-License-Identifier: GPL-2.0-or-later
// A rectangle of a plate or wall between four fibres, whose right ends are the corners 0 to 3 of a hexahedron, and
// whose left ones 4 to 7: what the positions x of these strain, and the energy
//     U = 1/2 sum_r k_r e_r^2.
// Along the line of the wall, 0 to 1, and along its width, 0 to 3, it is bent and stretched like a beam: each strain of
// BeamEdge varies linearly from one edge to the other, so its mean counts in full, and half of the difference by a
// third. Besides there are, with the edges a and b of the middle plane, its corners m and its warp w,
//     membrane shear a.b/(a0 b0),  twist w.(a x b)/(a0 b0)^2,  w = m0 - m1 + m2 - m3,
// and the stretch of the fibres. Where GA lets the plate shear, the fibres twist by other angles than the middle plane:
// the twist adds the difference of the shear strain between opposite edges, by the share of GA in it. A beam as wide as
// the plate bends as that of BeamElement; constant curvatures and twist are exact.
//
// So the curvatures vary linearly along their directions, by the shear, and across. U is the sum over four Gauss points,
// one by each fibre, of a quarter of a0 b0 kappa : M/2, with the moments M of SectionStiffness, and where they have a
// principal value beyond the limit, a curvature of the point becomes plastic until they have not. Poisson's ratio
// couples pairs of rows, e_a and e_b: k_b (e_b + m e_a)^2, with less of k_a, is the same energy in rows that stand alone.
#pragma once

#include "mpm/particle/apdi/BeamEdge.hpp"
#include "mpm/state/SectionState.hpp"

#include <algorithm>

namespace mpm {

class PlateElement {
    using Edge = BeamEdge<3>;

  public:
    static constexpr int corners = 8;
    // Plastic curvature along line and width and plastic twist of each Gauss point, 1/m.
    static constexpr int ofStack = 3, firstPlastic = plasticCurvature;
    static constexpr int placeOf(int stack, int variable) { return ofStack * stack + variable; }
    using Plastic = std::array<double, 4 * ofStack>;
    static constexpr int rowSets = 4; // each the task of another domain
    // Rows of direction k, 0 along the line and 1 along the width: rowOf(k, Edge::Row, part); part 0: the mean of both
    // edges, 1: half of the first edge less the second.
    enum Row { twist = 4 * Edge::rows, membrane, pinch, rows = pinch + 4 };
    static constexpr int rowOf(int direction, int strain, int part) {
        return (2 * direction + part) * Edge::rows + strain;
    }
    using Point = Vec<3>;
    using Gradient = std::array<Point, corners>; // over the positions of the corners

    struct Strained {
        std::array<double, rows> e{};
        std::array<Gradient, rows> gradient;
        std::array<double, 4> twistBeyond; // of the Gauss points, elastic, beyond their mean
    };

    // X: corners without strain.
    PlateElement(const Corners<3>& X, const SectionStiffness& section, bool)
        : edges_{edge(X, 0), edge(X, 1), edge(X, 2), edge(X, 3)} {
        const Middle start(X);
        const SectionStiffness::Plate membraneOf = section.membrane();
        bending_ = section.bending();
        poisson_ = section.poisson;
        for (int k = 0; k < 2; ++k) length_[k] = start.edge[k].norm();
        area_ = length_[0] * length_[1];
        for (int k = 0; k < 2; ++k)
            for (int part = 0; part < 2; ++part) {
                const double weight = part == 0 ? area_ : area_ / 3;
                const double EI = bending_.along[k], G = Edge::shearStiffness(section.GA, EI, length_[k]);
                stiffness_[rowOf(k, Edge::axial, part)] = weight * membraneOf.along[k];
                stiffness_[rowOf(k, Edge::curvature, part)] = weight * EI;
                stiffness_[rowOf(k, Edge::shear, part)] = weight * G;
                sheared_[k] = G / section.GA / length_[1 - k];
                slope_[k] = 0.5 * length_[k] * G / EI;
            }
        limit_ = section.limitMoment;
        stiffness_[twist] = 2 * area_ * bending_.sheared;
        stiffness_[membrane] = 0.5 * area_ * membraneOf.sheared;
        couple(membraneOf.cross);
        for (int f = 0; f < 4; ++f) {
            stiffness_[pinch + f] = 0.25 * area_ * section.EA;
            thickness_[f] = (X.col(f + 4) - X.col(f)).norm();
        }
    }

    double stiffness(int row) const { return stiffness_[row]; } // kN m
    // Of a row: force in the section per metre of it from k e, kN or kN m.
    double overVolume() const { return 1 / area_; }
    // Of a spring that holds a point of a fibre on its line, as stiff as that is against its stretch, kN/m.
    double stiffnessAtEnd() const { return stiffness_[pinch] / (thickness_[0] * thickness_[0]); }

    // What the corners strain, beyond what is plastic.
    Strained strained(const Corners<3>& x, const Plastic& plastic) const {
        Strained s;
        for (auto& row : s.gradient) row.fill(Point::Zero());
        for (int k = 0; k < 2; ++k)
            for (int side = 0; side < 2; ++side) {
                const auto line = edges_[2 * k + side].strained(ends(x, 2 * k + side), nullptr);
                for (int strain = 0; strain < Edge::rows; ++strain)
                    for (int part = 0; part < 2; ++part) {
                        const double share = part == 1 && side == 1 ? -0.5 : 0.5;
                        const int row = rowOf(k, strain, part);
                        s.e[row] += share * line.e[strain];
                        for (int a = 0; a < 4; ++a)
                            s.gradient[row][cornersOf(2 * k + side)[a]] += share * line.gradient[strain][a];
                    }
            }
        strainMiddle(x, s);
        for (int f = 0; f < 4; ++f) {
            const Point d = x.col(f + 4) - x.col(f);
            s.e[pinch + f] = d.norm() / thickness_[f] - 1;
            s.gradient[pinch + f][f + 4] = d / (d.norm() * thickness_[f]);
            s.gradient[pinch + f][f] = -s.gradient[pinch + f][f + 4];
        }
        takeOff(plastic, s);
        for (const Coupled& pair : coupled_) {
            s.e[pair.second] += pair.share * s.e[pair.first];
            for (int a = 0; a < corners; ++a)
                s.gradient[pair.second][a] += pair.share * s.gradient[pair.first][a];
        }
        return s;
    }

    double energy(const Strained& s) const {
        double sum = 0;
        for (int r = 0; r < rows; ++r) sum += 0.5 * stiffness_[r] * s.e[r] * s.e[r];
        for (double beyond : s.twistBeyond) sum += 0.25 * area_ * bending_.sheared * beyond * beyond;
        return sum;
    }

    // each(what, force): the forces at the Gauss point by fibre f, per metre of the sections. Moments are positive with
    // tension on the left, the side of line x width.
    template <class Each> void forces(const Strained& s, int f, Each&& each) const {
        const auto atPoint = [&](int k, int strain) { // the half of the difference counts by a third
            const double mean = force(s, rowOf(k, strain, 0)), half = 3 * force(s, rowOf(k, strain, 1));
            return overVolume() * (mean - at(f, 1 - k) * half);
        };
        const Curvature M = moment(curvature(s, f));
        each(normalForce, atPoint(0, Edge::axial));
        each(shearForce, -atPoint(0, Edge::shear));
        each(bendingMoment, -M[0]);
        each(hoopForce, atPoint(1, Edge::axial));
        each(hoopMoment, -M[1]);
        each(hoopShear, -atPoint(1, Edge::shear));
        each(membraneShear, stiffness_[membrane] * overVolume() * s.e[membrane]);
        each(twistingMoment, -M[2]);
    }

    // Lets curvatures become plastic until no point has a larger principal moment than the section can take, which is
    // alike along line and width: to the moments of the least energy, with curvatures of the same directions.
    void yield(const Strained& s, Plastic& plastic) const {
        if (std::isinf(limit_)) return;
        const double most = limit_ / bending_.along[0], nu = poisson_;
        const auto within = [&](double m) { return std::clamp(m, -most, most); };
        for (int f = 0; f < 4; ++f) {
            const Curvature kappa = curvature(s, f);
            const double half = 0.5 * (kappa[0] - kappa[1]);
            const double mean = (1 + nu) * 0.5 * (kappa[0] + kappa[1]);
            const double radius = (1 - nu) * std::hypot(half, kappa[2]);
            if (std::abs(mean) + radius <= (1 + roundOff) * most) continue;
            const double given[2] = {mean + radius, mean - radius}; // of the moments, by the stiffness
            double kept[2] = {within(given[0]), given[1]};
            for (int k : {1, 0, 1}) kept[k] = within(given[k] - nu * (given[1 - k] - kept[1 - k]));
            const double part = radius > 0 ? 0.5 * (kept[0] - kept[1]) / radius : 0;
            const double middle = 0.5 * (kept[0] + kept[1]) / (1 + nu);
            const Curvature left = {middle + part * half, middle - part * half, part * kappa[2]};
            for (int i = 0; i < ofStack; ++i) plastic[placeOf(f, i)] += kappa[i] - left[i];
        }
    }

  private:
    using Curvature = std::array<double, ofStack>; // along line and width, twist
    static constexpr double roundOff = 1e-12;      // of the limit
    struct Coupled {
        int first, second;
        double share; // of the first row in the second
    };

    // Rows whose curvatures at the Gauss points belong to each other: both constant, both along one direction, by the
    // curvature across or the shear, and both along and across; and the means of the stretch.
    void couple(double cross) {
        const auto pair = [&](int place, int first, int second, double stiffness) {
            const double share = stiffness / stiffness_[second];
            coupled_[place] = {first, second, share};
            stiffness_[first] -= share * stiffness;
        };
        const auto row = [](int k, int strain, int part) { return rowOf(k, strain, part); };
        const double each = area_ * bending_.cross;
        pair(0, row(0, Edge::axial, 0), row(1, Edge::axial, 0), area_ * cross);
        pair(1, row(0, Edge::curvature, 0), row(1, Edge::curvature, 0), each);
        for (int k = 0; k < 2; ++k)
            pair(2 + k, row(1 - k, Edge::curvature, 1), row(k, Edge::shear, 0), each * slope_[k] / 3);
        pair(4, row(0, Edge::shear, 1), row(1, Edge::shear, 1), each * slope_[0] * slope_[1] / 9);
    }
    // What a row would be without the other one of its pair.
    double alone(const Strained& s, int row) const {
        for (const Coupled& pair : coupled_)
            if (pair.second == row) return s.e[row] - pair.share * s.e[pair.first];
        return s.e[row];
    }
    // dU over that, kN m.
    double force(const Strained& s, int row) const {
        double sum = stiffness_[row] * s.e[row];
        for (const Coupled& pair : coupled_)
            if (pair.first == row) sum += pair.share * stiffness_[pair.second] * s.e[pair.second];
        return sum;
    }
    Curvature moment(const Curvature& kappa) const {
        return {bending_.along[0] * kappa[0] + bending_.cross * kappa[1],
                bending_.along[1] * kappa[1] + bending_.cross * kappa[0], bending_.sheared * kappa[2]};
    }

    // Place of the Gauss point by fibre f along direction k, from -1 to 1.
    static double at(int f, int k) { return 2 * Middle::along[k][f] / std::sqrt(3.0); }
    // Elastic curvature at the Gauss point by fibre f, 1/m.
    Curvature curvature(const Strained& s, int f) const {
        Curvature kappa;
        for (int k = 0; k < 2; ++k) {
            const double along = at(f, k), across = at(f, 1 - k);
            const auto row = [&](int strain) {
                return alone(s, rowOf(k, strain, 0)) - across * alone(s, rowOf(k, strain, 1));
            };
            kappa[k] = row(Edge::curvature) - along * slope_[k] * row(Edge::shear);
        }
        kappa[2] = s.e[twist] + s.twistBeyond[f];
        return kappa;
    }
    // Subtracts the plastic curvatures from the rows, by those parts of them that vary as the rows do.
    void takeOff(const Plastic& plastic, Strained& s) const {
        double twisted = 0;
        for (int f = 0; f < 4; ++f) {
            const double quarter = 0.25;
            for (int k = 0; k < 2; ++k) {
                const double part = quarter * plastic[placeOf(f, k)], along = at(f, k), across = at(f, 1 - k);
                s.e[rowOf(k, Edge::curvature, 0)] -= part;
                s.e[rowOf(k, Edge::curvature, 1)] += 3 * across * part;
                s.e[rowOf(k, Edge::shear, 0)] += 0.5 * length_[k] * along * part;
                s.e[rowOf(k, Edge::shear, 1)] -= 1.5 * length_[k] * along * across * part;
            }
            twisted += quarter * plastic[placeOf(f, 2)];
        }
        s.e[twist] -= twisted;
        for (int f = 0; f < 4; ++f) s.twistBeyond[f] = twisted - plastic[placeOf(f, 2)];
    }

    // Corners of the edges 0-1 and 3-2 along the line, 0-3 and 1-2 along the width, in the order of Edge::Ends.
    static constexpr std::array<int, 4> cornersOf(int edge) {
        constexpr int from[4] = {0, 3, 0, 1}, to[4] = {1, 2, 3, 2};
        return {from[edge], to[edge], to[edge] + 4, from[edge] + 4};
    }
    static Edge::Ends ends(const Corners<3>& x, int edge) {
        Edge::Ends ends;
        for (int a = 0; a < 4; ++a) ends[a] = x.col(cornersOf(edge)[a]);
        return ends;
    }
    static Edge edge(const Corners<3>& X, int number) { return Edge(ends(X, number)); }

    // Of the middle plane: edges along line and width, and its warp, by signs of its corners.
    struct Middle {
        static constexpr double along[2][4] = {{-0.5, 0.5, 0.5, -0.5}, {-0.5, -0.5, 0.5, 0.5}};
        static constexpr double warped[4] = {1, -1, 1, -1};
        Point edge[2] = {Point::Zero(), Point::Zero()}, warp = Point::Zero();

        explicit Middle(const Corners<3>& x) {
            for (int f = 0; f < 4; ++f) {
                const Point m = 0.5 * (x.col(f) + x.col(f + 4));
                for (int k = 0; k < 2; ++k) edge[k] += along[k][f] * m;
                warp += warped[f] * m;
            }
        }
    };

    void strainMiddle(const Corners<3>& x, Strained& s) const {
        const Middle now(x);
        const Point normal = now.edge[0].cross(now.edge[1]);
        s.e[membrane] = now.edge[0].dot(now.edge[1]) / area_;
        s.e[twist] = now.warp.dot(normal) / (area_ * area_);
        for (int f = 0; f < 4; ++f) {
            const double a = Middle::along[0][f], b = Middle::along[1][f];
            const Point sheared = (a * now.edge[1] + b * now.edge[0]) / area_;
            const Point twisted = (Middle::warped[f] * normal + a * now.edge[1].cross(now.warp) +
                                   b * now.warp.cross(now.edge[0])) /
                                  (area_ * area_);
            for (int end : {f, f + 4}) {
                s.gradient[membrane][end] = 0.5 * sheared;
                s.gradient[twist][end] = 0.5 * twisted;
            }
        }
        for (int k = 0; k < 2; ++k) {
            const int other = rowOf(k, Edge::shear, 1);
            s.e[twist] += sheared_[k] * s.e[other];
            for (int a = 0; a < corners; ++a) s.gradient[twist][a] += sheared_[k] * s.gradient[other][a];
        }
    }

    std::array<Edge, 4> edges_; // see cornersOf()
    double length_[2], area_, sheared_[2], slope_[2], thickness_[4], poisson_, limit_;
    SectionStiffness::Plate bending_;
    std::array<Coupled, 5> coupled_;
    std::array<double, rows> stiffness_{};
};

} // namespace mpm
