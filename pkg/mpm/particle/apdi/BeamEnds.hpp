// SPDX-License-Identifier: GPL-2.0-or-later
// The ends of a beam: the vertices between both faces stand by themselves, so that the nodes there have mass, and soil
// finds the end. Springs k hold them on the line between the faces,
//     U = 1/2 k |g|^2,  g = x_v - (1 - y) x_right - y x_left.
#pragma once

#include "mpm/particle/apdi/DomainMesh.hpp"

#include <vector>

namespace mpm {

class BeamEnds {
  public:
    struct Tie {
        int domain, vertex;                                            // one of a domain
        int right, left;                                               // vertices of the section
        double y, k;                                                   // place between them, -; kN/m
        double part(int side) const { return side == 0 ? y - 1 : -y; } // of the gap over the right, left one
    };

    void clear() { ties_.clear(); }
    // Vertices of domain p from `first` on that stand by themselves, between the ends of its section.
    void find(const DomainMesh<2>& mesh, int p, int first, const std::array<int, 4>& corner, double k) {
        for (int a = 0; a < 4; ++a) {
            const int v = mesh.corner[4 * p + a];
            if (v < first || mesh.vertices.hanging.isSlave(v)) continue;
            const auto known =
                std::find_if(ties_.begin(), ties_.end(), [&](const Tie& t) { return t.vertex == v; });
            if (known != ties_.end()) {
                known->domain = p;
                continue;
            }
            const auto at = [&](int vertex) { return vectorAt<2>(mesh.vertices.reference, vertex); };
            for (auto [right, left] : {std::pair{corner[0], corner[3]}, std::pair{corner[1], corner[2]}}) {
                const Vec<2> across = at(left) - at(right), d = at(v) - at(right);
                const double y = d.dot(across) / across.squaredNorm();
                if ((d - y * across).norm() < onLine * across.norm())
                    ties_.push_back({p, v, right, left, y, k});
            }
        }
    }
    void found() {
        std::sort(ties_.begin(), ties_.end(), [](const Tie& a, const Tie& b) { return a.domain < b.domain; });
    }

    static Vec<2> gap(const DomainMesh<2>& mesh, const Tie& tie) {
        const auto at = [&](int vertex) { return vectorAt<2>(mesh.vertices.position, vertex); };
        return at(tie.vertex) + tie.part(0) * at(tie.right) + tie.part(1) * at(tie.left);
    }
    double energy(const DomainMesh<2>& mesh) const {
        double sum = 0;
        for (const Tie& tie : ties_) sum += 0.5 * tie.k * gap(mesh, tie).squaredNorm();
        return sum;
    }
    void addForces(const DomainMesh<2>& mesh, double* const force[2]) const {
        for (const Tie& tie : ties_) {
            const Vec<2> f = -tie.k * gap(mesh, tie);
            for (int k = 0; k < 2; ++k) {
                force[k][tie.vertex] += f[k];
                force[k][tie.right] += tie.part(0) * f[k];
                force[k][tie.left] += tie.part(1) * f[k];
            }
        }
    }
    // f(tie) if domain p has one.
    template <class F> void ifTied(int p, F&& f) const {
        const auto tie = std::lower_bound(ties_.begin(), ties_.end(), p,
                                          [](const Tie& one, int domain) { return one.domain < domain; });
        if (tie != ties_.end() && tie->domain == p) f(*tie);
    }

  private:
    static constexpr double onLine = 1e-6; // of the thickness: round-off
    std::vector<Tie> ties_;
};

} // namespace mpm
