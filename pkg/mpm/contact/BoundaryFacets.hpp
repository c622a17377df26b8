// SPDX-License-Identifier: GPL-2.0-or-later
// The boundary of a meshed body.
#pragma once

#include "mpm/particle/Domains.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>

namespace mpm {

// Facets of a mesh that belong to one domain only, less those where fine domains meet a coarse one.
template <int Dim> class BoundaryFacets {
  public:
    static constexpr int size = Dim == 2 ? 2 : 4; // vertices of a facet
    using Facet = std::array<int, size>;
    std::vector<Facet> facets;

    void find(Domains<Dim>& domains) {
        static const int table[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
        std::map<Facet, std::pair<Facet, int>> count; // by sorted vertices
        const std::vector<int>& corner = *domains.cornerTable();
        for (size_t first = 0; first < corner.size(); first += corners<Dim>)
            for (int f = 0; f < 2 * Dim; ++f) {
                Facet facet;
                for (int a = 0; a < size; ++a)
                    facet[a] = corner[first + (Dim == 2 ? (f + a) % 4 : table[f][a])];
                Facet key = facet;
                std::sort(key.begin(), key.end());
                auto& entry = count[key];
                entry.first = facet, ++entry.second;
            }
        facets.clear();
        const Hanging hanging(domains);
        for (auto& [key, entry] : count)
            if (entry.second == 1 && !hanging.isInterface(key)) facets.push_back(entry.first);
    }

  private:
    // The vertices of a facet between fine and coarse domains are, or hang on, exactly the corners of one coarse facet.
    struct Hanging {
        std::map<int, std::vector<int>> masters;
        std::vector<std::vector<int>> coarse;

        explicit Hanging(Domains<Dim>& domains) {
            std::vector<int> slaves, all;
            for (auto& [name, table] : domains.tables()) {
                if (name == "slaves") slaves = *table;
                if (name == "masters") all = *table;
            }
            for (size_t s = 0; s < slaves.size(); ++s) {
                std::vector<int> mine;
                for (int m = 0; m < 4; ++m)
                    if (all[4 * s + m] >= 0) mine.push_back(all[4 * s + m]);
                std::sort(mine.begin(), mine.end());
                if (int(mine.size()) == size) coarse.push_back(mine);
                masters[slaves[s]] = mine;
            }
            std::sort(coarse.begin(), coarse.end());
        }
        bool isInterface(const Facet& facet) const {
            std::vector<int> carriers;
            for (int v : facet) {
                const auto found = masters.find(v);
                if (found == masters.end())
                    carriers.push_back(v);
                else
                    carriers.insert(carriers.end(), found->second.begin(), found->second.end());
            }
            std::sort(carriers.begin(), carriers.end());
            carriers.erase(std::unique(carriers.begin(), carriers.end()), carriers.end());
            return std::binary_search(coarse.begin(), coarse.end(), carriers);
        }
    };
};

} // namespace mpm
