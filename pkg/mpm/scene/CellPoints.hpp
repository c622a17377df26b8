// SPDX-License-Identifier: GPL-2.0-or-later
// The points by which the particles of a body belong to cells of the grid: their centres, or those of the 2^Dim parts of
// each domain of a mesh that lies in more than one cell. By their centres alone domains of the size of a cell would
// cover one twice and the next one not at all once they have moved.
#pragma once

#include "mpm/base/parallel/WorkPartition.hpp"
#include "mpm/particle/Domains.hpp"
#include "mpm/state/Grid.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace mpm {

template <int Dim> class CellPoints {
  public:
    // Before place(), by one thread. mesh: whose domains count in parts; nullptr: particles count by their centres.
    void start(const Particles<Dim>& particles, Mesh<Dim>* mesh) {
        mesh_ = mesh;
        most_ = mesh ? corners<Dim> : 1;
        particles_ = particles.size();
        per_.resize(mesh ? particles_ : 0);
        for (int k = 0; k < Dim; ++k) {
            centre_[k] = particles.position.plane(k);
            parts_[k].resize(mesh ? size() : 0);
        }
    }
    // Of particles [begin, end), a chunk: cells[point - at(begin)] for all points of theirs.
    void place(const Grid<Dim>& grid, int begin, int end, int* cells) {
        if (mesh_) return placeParts(grid, begin, end, cells);
        std::fill(cells, cells + (end - begin), 0);
        for (int k = 0; k < Dim; ++k) grid.addCells(k, centre_[k] + begin, end - begin, cells);
    }

    bool isInParts() const { return mesh_; }
    int size() const { return most_ * particles_; }
    // The points of particle p are [at(p), at(p) + per(p)).
    int at(int p) const { return most_ * p; }
    int particleOf(int point) const { return mesh_ ? point / most_ : point; }
    int per(int p) const { return mesh_ ? per_[p] : 1; }
    double partPer(int p) const { return mesh_ ? 1.0 / per_[p] : 1; } // of the particle
    double position(int p, int point, int axis) const {
        return per(p) == 1 ? centre_[axis][p] : parts_[axis][point];
    }

  private:
    static constexpr int NC = corners<Dim>;

    void placeParts(const Grid<Dim>& grid, int begin, int end, int* cells) {
        const int count = end - begin;
        const int* const corner = mesh_->cornerTable().data() + NC * begin;
        char isDivided[chunkSize] = {};
        std::fill(cells, cells + NC * count, 0);
        for (int k = 0; k < Dim; ++k) {
            int index[chunkSize] = {};
            grid.addCells(k, centre_[k] + begin, count, index, 1);
            const double* const x = mesh_->vertexPositions().plane(k);
            const int stride = grid.strides[k];
            for (int i = 0; i < count; ++i) {
                double at[NC];
                for (int a = 0; a < NC; ++a) at[a] = x[corner[NC * i + a]];
                halve(at);
                const double low = grid.line(k, index[i]), high = grid.line(k, index[i] + 1);
                for (int a = 0; a < NC; ++a) {
                    const int beside = (at[a] >= high) - (at[a] < low);
                    cells[NC * i + a] += (index[i] + beside) * stride;
                    isDivided[i] |= beside != 0;
                    parts_[k][NC * (begin + i) + a] = at[a];
                }
            }
        }
        for (int i = 0; i < count; ++i) per_[begin + i] = isDivided[i] ? NC : 1;
    }
    // From values at the corners of a domain to those half-way between them and its centre.
    static void halve(double* x) {
        for (int k = 0; k < Dim; ++k)
            for (int pair = 0; pair < NC / 2; ++pair) {
                const auto [a, b] = edges[k * NC / 2 + pair];
                const double low = x[a], high = x[b];
                x[a] = 0.75 * low + 0.25 * high;
                x[b] = 0.25 * low + 0.75 * high;
            }
    }
    // The corners at the ends of the edges along each axis (VTK order).
    static constexpr int edges2[4][2] = {{0, 1}, {3, 2}, {0, 3}, {1, 2}};
    static constexpr int edges3[12][2] = {{0, 1}, {3, 2}, {4, 5}, {7, 6}, {0, 3}, {1, 2},
                                          {4, 7}, {5, 6}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    static constexpr const int (*edges)[2] = Dim == 2 ? edges2 : edges3;

    Mesh<Dim>* mesh_ = nullptr;
    int most_ = 1, particles_ = 0; // points per particle
    std::vector<char> per_;        // of each particle
    std::array<const double*, Dim> centre_{};
    std::array<std::vector<double>, Dim> parts_;
};

// Whether no domain of a mesh was larger than a cell when its displacement was zero.
template <int Dim>
bool fitInCells(const Particles<Dim>& particles, const Grid<Dim>& grid, const Mesh<Dim>& mesh) {
    constexpr double tolerated = 1.05;
    bool is = true;
    for (int p = 0; p < particles.size() && is; ++p) {
        const Vec<Dim> cell = grid.sizeAt(vectorAt<Dim>(particles.reference, p));
        is = mesh.initialEdge(p) <= tolerated * cell.maxCoeff() &&
             particles.initialVolume.plane()[p] <=
                 tolerated * cell.prod() * grid.thicknessAt(particles.reference.plane(0)[p]);
    }
    return is;
}

} // namespace mpm
