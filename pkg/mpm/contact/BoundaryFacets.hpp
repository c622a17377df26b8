// SPDX-License-Identifier: GPL-2.0-or-later
// The boundary of a meshed body.
#pragma once

#include "mpm/particle/Domains.hpp"
#include "mpm/state/facets.hpp"

#include <algorithm>
#include <map>

namespace mpm {

// Facets of a mesh that belong to one domain only, less those where fine domains meet a coarse one.
template <int Dim> class BoundaryFacets {
  public:
    static constexpr int size = cornersOfFacet<Dim>;
    using Facet = std::array<int, size>;
    std::vector<Facet> facets;

    void find(Domains<Dim>& domains) {
        std::map<Facet, std::pair<Facet, int>> count; // by sorted vertices
        const std::vector<int>& corner = domains.mesh()->cornerTable();
        for (size_t first = 0; first < corner.size(); first += corners<Dim>)
            for (int f = 0; f < facetsOfCell<Dim>; ++f) {
                Facet facet;
                for (int a = 0; a < size; ++a) facet[a] = corner[first + FacetCorners<Dim>::of[f][a]];
                Facet key = facet;
                std::sort(key.begin(), key.end());
                auto& entry = count[key];
                entry.first = facet;
                ++entry.second;
            }
        facets.clear();
        const Hanging hanging(domains, count);
        for (auto& [key, entry] : count)
            if (entry.second == 1 && !hanging.isInterface(key)) facets.push_back(entry.first);
    }

  private:
    // The vertices of a facet between fine and coarse domains are, or hang on, exactly the corners of one
    // coarse facet.
    struct Hanging {
        static constexpr int mastersOfSlave = 4; // in the table of the domains, filled up with -1
        std::map<int, std::vector<int>> masters;
        std::vector<std::vector<int>> coarse;

        // facets: of the domains, by sorted vertices.
        template <class Facets> Hanging(Domains<Dim>& domains, const Facets& facets) {
            std::vector<int> slaves, all;
            for (auto& [name, table] : domains.tables()) {
                if (name == "slaves") slaves = *table;
                if (name == "masters") all = *table;
            }
            for (size_t s = 0; s < slaves.size(); ++s) {
                std::vector<int> mine;
                for (int m = 0; m < mastersOfSlave; ++m)
                    if (const int master = all[mastersOfSlave * s + m]; master >= 0) mine.push_back(master);
                std::sort(mine.begin(), mine.end());
                if (Facet key; int(mine.size()) == size) {
                    std::copy(mine.begin(), mine.end(), key.begin());
                    if (facets.count(key)) coarse.push_back(mine);
                }
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
