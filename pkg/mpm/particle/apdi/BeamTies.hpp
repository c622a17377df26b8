// SPDX-License-Identifier: GPL-2.0-or-later
// The vertices of a beam between its faces stand by themselves: what follows others gives no mass to the nodes round it,
// and soil or water would find nothing there. Springs k hold them on the line between the faces,
//     U = 1/2 k |g|^2,  g = x_v - (1 - y) x_right - y x_left.
#pragma once

#include "mpm/particle/apdi/DomainMesh.hpp"

#include <vector>

namespace mpm {

template <int Dim> class BeamTies {
  public:
    struct Tie {
        int domain, vertex;                                            // one of a domain
        int right, left;                                               // vertices of the fibre
        double y, k;                                                   // place between them, -; kN/m
        double part(int side) const { return side == 0 ? y - 1 : -y; } // of the gap over the right, left one
    };

    void clear() { ties_.clear(); }
    // In the order of their domains.
    void add(const Tie& tie) { ties_.push_back(tie); }

    static Vec<Dim> gap(const DomainMesh<Dim>& mesh, const Tie& tie) {
        const auto at = [&](int vertex) { return vectorAt<Dim>(mesh.vertices.position, vertex); };
        return at(tie.vertex) + tie.part(0) * at(tie.right) + tie.part(1) * at(tie.left);
    }
    double energy(const DomainMesh<Dim>& mesh) const {
        double sum = 0;
        for (const Tie& tie : ties_) sum += 0.5 * tie.k * gap(mesh, tie).squaredNorm();
        return sum;
    }
    void addForces(const DomainMesh<Dim>& mesh, double* const force[Dim]) const {
        for (const Tie& tie : ties_) {
            const Vec<Dim> f = -tie.k * gap(mesh, tie);
            for (int k = 0; k < Dim; ++k) {
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
    std::vector<Tie> ties_;
};

} // namespace mpm
