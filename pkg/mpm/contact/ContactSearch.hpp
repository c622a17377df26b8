// SPDX-License-Identifier: GPL-2.0-or-later
// Where groups of bodies are in contact, found once per step, and how their surfaces lie there: normal, gap,
// area.
#pragma once

#include "mpm/contact/PairSearch.hpp"

namespace mpm {

template <int Dim> class ContactSearch {
  public:
    std::vector<ContactNode<Dim>> nodes;
    std::vector<ContactPoint<Dim>> points;
    std::vector<ContactPair<Dim>> pairs;

    void prepare(const Scene<Dim>& scene);
    void find(const Scene<Dim>& scene, const SearchRule& rule);
    bool isFound(const Scene<Dim>& scene) const { return step_ == scene.step; }
    // Whether a group is of meshes alone, as it was last found; and the surface of a body.
    bool isOfMeshes(int group) const { return isExplicit_[group] && !hasOutline_[group]; }
    const ExplicitSurface<Dim>& surfaceOf(int body) const { return pair_.surfaces[body]; }

  private:
    long step_ = -1;
    PairSearch<Dim> pair_;                      // the one in work
    std::vector<bool> isExplicit_, hasOutline_; // of groups, see PairSearch

    void look(const Scene<Dim>& scene);
    void findPair(int a, int b, const SearchRule& rule);
    bool findFields(ContactPair<Dim>& pair, int a, int b, const SearchRule& rule);
    void findTwins(const ContactPair<Dim>& pair);
    void clear();
};

} // namespace mpm
