// SPDX-License-Identifier: GPL-2.0-or-later
// Which nodes strain some particles of a body, and how: the elastic energy of particle p that moves by u is
//     1/2 V [lambda (tr e)^2 + 2 mu e : e] + 1/2 sum_m control_m |h_m|^2,
//     e = sym sum_n u_n (x) g_n,  h_m = sum_n gamma_nm u_n,
// with axial symmetry also e_33 = sum_n hoop_n u_r.
#pragma once

#include "mpm/scene/Body.hpp"

namespace mpm {

template <int Dim> class StrainedNodes {
  public:
    static constexpr int patterns = Mesh<Dim>::patterns;

    struct Entry {
        int node, unknown;                  // the first of its unknowns in the system that it belongs to
        double g[Dim], gamma[patterns];     // 1/m; -
        double hoop = 0, trace[Dim] = {};   // 1/m; of tr e
        Vec<Dim> force;                     // kN, of the stress of the particle at the start
        Vec<Dim> weight = Vec<Dim>::Zero(); // kN, of gravity
    };
    struct Strained {
        int begin, end;           // of its entries; each node is there once
        double lambda, mu;        // times the volume, kN m (2D: per m)
        double control[patterns]; // kN/m (2D: per m)
        int rows = 0;             // in which a beam is strained
        double rowStiffness[Mesh<Dim>::mostRows] = {};

        // Domains of a beam that tell no rows do not.
        bool resists() const {
            bool any = rows > 0 || lambda != 0 || mu != 0;
            for (double k : control) any = any || k != 0;
            return any;
        }
    };
    struct BeamRows {
        double row[Mesh<Dim>::mostRows][Dim] = {}; // see Mesh::beamRows()
    };
    std::vector<Entry> entries;
    std::vector<BeamRows> beamRows; // of each entry, where the body is a beam
    std::vector<Strained> particles;

    // Of particles first to last - 1, at most chunkSize, that are strained. isIn(node): whether a node counts.
    template <class IsStrained, class IsIn>
    void find(Body<Dim>& body, int first, int last, const Vec<Dim>& gravity, IsStrained&& isStrained,
              IsIn&& isIn) {
        entries.clear();
        particles.clear();
        beamRows.clear();
        double lambda[chunkSize], mu[chunkSize];
        body.stiffness(first, last, lambda, mu);
        for (int p = first; p < last; ++p) {
            if (!isStrained(p)) continue;
            const double volume = body.domains->section ? 0 : body.particles.volume.plane()[p];
            particles.push_back(
                {int(entries.size()), 0, volume * lambda[p - first], volume * mu[p - first], {}});
            findOf(body, p, body.particles.mass.plane()[p] * gravity, isIn);
            particles.back().end = int(entries.size());
            if (particles.back().rows > 0) beamRows.resize(entries.size());
        }
    }

  private:
    template <class IsIn> void findOf(Body<Dim>& body, int p, const Vec<Dim>& weight, IsIn&& isIn) {
        Strained& particle = particles.back();
        const auto entryOf = [&](int node) -> Entry& {
            for (size_t e = particle.begin; e < entries.size(); ++e)
                if (entries[e].node == node) return entries[e];
            return entries.emplace_back(Entry{node, -1, {}, {}, 0, {}, Vec<Dim>::Zero()});
        };
        Mat<Dim> stress;
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j)
                stress(i, j) = body.particles.volume.plane()[p] * body.particles.stress.plane(3 * i + j)[p];
        const double ring = body.particles.volume.plane()[p] * body.particles.stress.plane(8)[p];
        const auto add = [&](int node, double phi, const Vec<Dim>& gradient, double hoop,
                             const double* gamma) {
            if (!isIn(node)) return;
            Entry& entry = entryOf(node);
            entry.weight += phi * weight;
            entry.force -= stress * gradient;
            entry.force[0] -= ring * hoop;
            entry.hoop += hoop;
            for (int k = 0; k < Dim; ++k) entry.g[k] += gradient[k];
            for (int k = 0; k < Dim; ++k) entry.trace[k] = entry.g[k];
            entry.trace[0] += entry.hoop;
            for (int m = 0; m < patterns && gamma; ++m) entry.gamma[m] += gamma[m];
        };
        if (const auto* mesh = body.domains->mesh()) {
            if (body.domains->section) findBeam(*mesh, p, entryOf, isIn);
            double h[patterns][Dim];
            mesh->strains(p, add, particle.control);
            mesh->amplitude(p, h);
            for (size_t e = particle.begin; e < entries.size(); ++e)
                for (int m = 0; m < patterns; ++m)
                    for (int k = 0; k < Dim; ++k)
                        entries[e].force[k] -= particle.control[m] * entries[e].gamma[m] * h[m][k];
            return;
        }
        const double overRadius = body.domains->overRadius(p);
        body.domains->weights(p, [&](int node, double phi, const Vec<Dim>& gradient) {
            add(node, phi, gradient, phi * overRadius, nullptr);
        });
    }

    template <class EntryOf, class IsIn>
    void findBeam(const Mesh<Dim>& mesh, int p, EntryOf&& entryOf, IsIn&& isIn) {
        Strained& particle = particles.back();
        typename Mesh<Dim>::Rows rows = {}; // a tie has fewer than an element
        particle.rows = mesh.beamRows(
            p,
            [&](int node, const double(*row)[Dim]) {
                if (!isIn(node)) return;
                const size_t e = &entryOf(node) - entries.data();
                beamRows.resize(entries.size());
                for (int r = 0; r < Mesh<Dim>::mostRows; ++r)
                    for (int k = 0; k < Dim; ++k) {
                        beamRows[e].row[r][k] += row[r][k];
                        entries[e].force[k] -= rows.force[r] * row[r][k];
                    }
            },
            rows);
        std::copy(rows.stiffness, rows.stiffness + particle.rows, particle.rowStiffness);
    }
};

} // namespace mpm
