// SPDX-License-Identifier: GPL-2.0-or-later
// Which nodes strain each particle of a body, and how: the elastic energy of particle p that moves by u is
//     1/2 V [lambda (tr e)^2 + 2 mu e : e] + 1/2 control sum_m |h_m|^2,
//     e = sym sum_n u_n (x) g_n,  h_m = sum_n gamma_nm u_n.
#pragma once

#include "mpm/scene/Body.hpp"

namespace mpm {

template <int Dim> class StrainedNodes {
  public:
    static constexpr int patterns = Mesh<Dim>::patterns;

    struct Entry {
        int node;
        double g[Dim], gamma[patterns], mass; // 1/m; -; Mg, of the particle, inertial
    };
    struct Strained {
        int begin, end;             // of its entries; each node is there once
        double lambda, mu, control; // times the volume, kN m (2D: per m)
    };
    std::vector<Entry> entries;
    std::vector<Strained> particles;

    // isIn(node): whether a node counts. place: scratch, -1 for every node on entry and exit.
    template <class IsIn> void find(Body<Dim>& body, std::vector<int>& place, IsIn&& isIn) {
        entries.clear();
        particles.resize(body.particles.size());
        double lambda[chunkSize], mu[chunkSize];
        for (int p = 0; p < body.particles.size(); ++p) {
            if (p % chunkSize == 0)
                body.stiffness(p, std::min(p + chunkSize, body.particles.size()), lambda, mu);
            const double volume = body.particles.volume.plane()[p];
            particles[p] = {int(entries.size()), 0, volume * lambda[p % chunkSize],
                            volume * mu[p % chunkSize], 0};
            findOf(body, p, place, isIn);
            particles[p].end = int(entries.size());
        }
        for (const Entry& entry : entries) place[entry.node] = -1;
    }

  private:
    template <class IsIn> void findOf(Body<Dim>& body, int p, std::vector<int>& place, IsIn&& isIn) {
        const auto entryOf = [&](int node) -> Entry& {
            int& at = place[node];
            if (at < particles[p].begin) { // none yet, or of a particle before
                at = int(entries.size());
                entries.push_back({node, {}, {}, 0});
            }
            return entries[at];
        };
        const double mass = body.inertiaScale * body.particles.mass.plane()[p];
        body.domains->weights(p, [&](int node, double phi, const Vec<Dim>& gradient) {
            if (!isIn(node)) return;
            Entry& entry = entryOf(node);
            entry.mass += phi * mass;
            for (int k = 0; k < Dim; ++k) entry.g[k] += gradient[k];
        });
        if (const auto* mesh = body.domains->mesh())
            particles[p].control = mesh->hourglassStiffness(p, [&](int node, const double* gamma) {
                if (!isIn(node)) return;
                Entry& entry = entryOf(node);
                for (int m = 0; m < patterns; ++m) entry.gamma[m] += gamma[m];
            });
    }
};

} // namespace mpm
