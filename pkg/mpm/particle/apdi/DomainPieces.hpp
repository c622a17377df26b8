// SPDX-License-Identifier: GPL-2.0-or-later
// Domains in pieces of work for the stage between domains and vertices. Pieces that share a vertex take
// turns.
#pragma once

#include "mpm/particle/apdi/DomainMesh.hpp"

namespace mpm {

template <int Dim> class DomainPieces {
  public:
    int count() const { return int(start_.size()) - 1; }

    // After the mesh has changed. Longer pieces need fewer colours: in a regular mesh two are enough once a
    // piece is as long as a row; where no length is enough, a middle one stays. In a large mesh pieces are
    // longer, so that few vertices lie between two.
    void cut(const DomainMesh<Dim>& mesh) {
        constexpr int lengths[] = {128, 256, 512, 256}; // domains, tried in turn
        constexpr int piecesOfLargeMesh = 64, longest = 2048;
        constexpr int fewColours = 2;
        const int longer = std::min(mesh.domains() / piecesOfLargeMesh, longest);
        for (int least : lengths) {
            cutAtRows(mesh, std::max(least, longer));
            if (coloured_.graph(neighbours(mesh)) <= fewColours) break;
        }
        coloured_.partition.set(count(),
                                [&](int piece) { return mesh.workOf(start_[piece], start_[piece + 1]); });
    }

    // f(batch, piece) for batches of domains.
    template <class F> void forBatches(ParallelRegion& region, const DomainMesh<Dim>& mesh, F&& f) {
        region.forColoured(coloured_, [&](int piece) {
            mesh.forBatches(start_[piece], start_[piece + 1],
                            [&](const Batch<Dim>& batch) { f(batch, piece); });
        });
    }

  private:
    static constexpr int NC = corners<Dim>;
    std::vector<int> start_; // first domain of each piece, and one past the last
    ColouredPieces coloured_;

    // At the ends of rows, where these are not too long: no piece is twice as long as `least`.
    void cutAtRows(const DomainMesh<Dim>& mesh, int least) {
        const int n = mesh.domains();
        start_ = {0};
        while (start_.back() < n) {
            const int start = start_.back();
            start_.push_back(std::min(mesh.rowEnd[std::min(start + least, n) - 1], start + 2 * least));
        }
    }

    std::vector<std::vector<int>> neighbours(const DomainMesh<Dim>& mesh) const {
        std::vector<std::vector<int>> neighbours(count());
        std::vector<std::vector<int>> at(mesh.vertices.size()); // pieces at a vertex
        int piece = 0;
        for (size_t slot = 0; slot < mesh.corner.size(); ++slot) {
            if (int(slot) / NC == start_[piece + 1]) ++piece;
            auto& here = at[mesh.corner[slot]];
            if (std::find(here.begin(), here.end(), piece) != here.end()) continue;
            for (int other : here) {
                neighbours[piece].push_back(other);
                neighbours[other].push_back(piece);
            }
            here.push_back(piece);
        }
        for (auto& list : neighbours) {
            std::sort(list.begin(), list.end());
            list.erase(std::unique(list.begin(), list.end()), list.end());
        }
        return neighbours;
    }
};

} // namespace mpm
