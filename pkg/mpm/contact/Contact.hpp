// SPDX-License-Identifier: GPL-2.0-or-later
// Frictional contact between groups of bodies. See Contact.cpp; derived in doc/explanation/contact.md.
#pragma once

#include "mpm/contact/CarriedForces.hpp"
#include "mpm/contact/ContactImpulses.hpp"
#include "mpm/contact/FacetImpulses.hpp"
#include "mpm/contact/PressedSites.hpp"
#include "mpm/scene/Scene.hpp"

#include <map>

namespace mpm {

class Contact : public EngineOf<Contact>, public VelocityCoupling, public LookingAhead {
  public:
    double friction = 0, adhesion = 0, impactLoss = 1, frictionWork = 0;
    bool separation = true, slip = true, sharedCells = true;
    std::vector<double> cells, gaps; // see SharedCells
    std::string constraints = "auto";
    struct PairLaw { // of two groups, by their numbers
        int first = 0, second = 0;
        double friction = 0, adhesion = 0;

        template <class Self, class Visit> static void members(Self& row, Visit&& visit) {
            visit("first", "", row.first);
            visit("second", "", row.second);
            visit("friction", "-", row.friction);
            visit("adhesion", "kPa", row.adhesion);
        }
    };
    std::vector<PairLaw> pairs;
    std::vector<double> impulses;      // time integrals of the forces since the start
    std::vector<double> facetImpulses; // see FacetImpulses
    EdgeMotions edgeMotions;
    PressedSites pressed; // for USF

    // Of the last step.
    std::vector<ContactRecord> table;
    std::vector<double> forces;                  // on group b by group a < b, kN, from 3 pairOf(a, b) on
    double largestPenetration = 0, gridLoss = 0; // m; kJ
    int sliding = 0, reduced = 0, unsettled = 0;

    std::string className() const override { return "Contact"; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void finish() override;
    bool separatesGroups() const override { return true; }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }
    void couple(Scene<2>& scene) override { tie(scene); }
    void couple(Scene<3>& scene) override { tie(scene); }
    void lookAhead(const Scene<2>& scene) override { findAhead(scene); }
    void lookAhead(const Scene<3>& scene) override { findAhead(scene); }

    void stepped(double dt) override;

    template <int Dim> void act(Scene<Dim>& scene);

  private:
    template <int Dim> struct State {
        ContactSearch<Dim> search;
        ContactImpulses<Dim> impulses;
        CarriedForces<Dim> carried;
        FacetImpulses<Dim> facets;
        long solved = -1; // step that act() was called in
        // What implicit bodies answer on their own side of each contact node, for velocities made anew.
        struct Own {
            bool is[2] = {false, false};
            Mat<Dim> answer[2];
        };
        std::vector<Own> own;
        // Of a group on a node, by their numbers: the velocity of the start as the pairs so far have left it.
        std::map<std::pair<int, int>, Vec<Dim>> starts;
    };
    std::tuple<State<2>, State<3>> states_;
    double flip_ = 1;                                     // of the particles, in this step
    std::tuple<SharedCells<2>*, SharedCells<3>*> shared_; // of the scene

    template <int Dim> void check(Scene<Dim>& scene);
    OwnedFacets ownedFacets() const;
    SearchRule rule() const { return {separation, ownedFacets(), &edgeMotions}; }
    template <int Dim> void findAhead(const Scene<Dim>& scene) {
        auto& search = std::get<State<Dim>>(states_).search;
        if (!search.isFound(scene)) search.find(scene, rule());
    }
    template <int Dim> State<Dim>& found(const Scene<Dim>& scene);
    template <int Dim> static void touch(Scene<Dim>& scene, const ContactSearch<Dim>& search);
    template <int Dim> void addToFacets(const Scene<Dim>& scene, State<Dim>& state);
    template <int Dim> void recordShared(const Scene<Dim>& scene);
    template <int Dim> void tie(Scene<Dim>& scene);
    template <int Dim>
    void addFriction(ContactSearch<Dim>& search, const ContactPair<Dim>& pair, double loss);
    template <int Dim>
    void change(Scene<Dim>& scene, const Vec<Dim>& gravity, const ContactNode<Dim>& contact, int side,
                const Mat<Dim>& answer, const Impulses<Dim>& J);
    template <int Dim>
    void exchange(Scene<Dim>& scene, const Vec<Dim>& gravity, ContactNode<Dim>& contact,
                  const NodeMotion<Dim>& node);
    template <int Dim>
    void record(Scene<Dim>& scene, const ContactNode<Dim>& contact, const NodeMotion<Dim>& node);
    FrictionLaw lawOf(int a, int b) const;
    // What particles lose of the velocities with which groups meet; nothing where these move as one body.
    double loss() const { return separation || slip ? impactLoss : 0; }
};

} // namespace mpm
