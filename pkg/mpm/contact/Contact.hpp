// SPDX-License-Identifier: GPL-2.0-or-later
// Frictional contact between groups of bodies. See Contact.cpp; the derivation is in doc/contact.md.
#pragma once

#include "mpm/contact/Meeting.hpp"
#include "mpm/scene/Engine.hpp"

namespace mpm {

class Contact : public EngineOf<Contact> {
  public:
    double friction = 0, adhesion = 0, impactLoss = 0, frictionWork = 0;
    bool separation = true, slip = true;
    std::string normals = "surface";
    std::vector<double> pairs;
    std::vector<double> impulses; // time integrals of the forces since the start

    // Of the last step.
    std::vector<double>
        table; // groups (2), node (3), normal (3), gap, area, force on the second group (3), slip rate (3)
    std::vector<double> forces;                  // on group b by group a < b, kN, from 3 pairOf(a, b) on
    double largestPenetration = 0, gridLoss = 0; // m; kJ
    int sliding = 0, reduced = 0;

    std::string className() const override { return "Contact"; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void finish() override;
    bool separatesGroups() const override { return true; }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }
    void remapped(Scene<2>& scene) override { tie(scene); }
    void remapped(Scene<3>& scene) override { tie(scene); }

    void stepped(double dt) override;

    template <int Dim> void act(Scene<Dim>& scene);

    // Numbers that stay when there are more groups.
    static size_t pairOf(int a, int b) { return size_t(b) * (b - 1) / 2 + a; }

  private:
    struct Law {
        double friction, adhesion;
        bool slip;
    };
    // Two groups on a node: inverse masses, velocities at the start and of the solution, what they have exchanged.
    template <int Dim> struct Pair {
        Vec<Dim> W[2], start[2], v[2];
        Impulses<Dim> J;
        void take(const Impulses<Dim>& more, double share) {
            J.all += share * more.all, J.agreeing += share * more.agreeing;
            for (int side = 0; side < 2; ++side) {
                const Vec<Dim> answer = (side == 0 ? -share : share) * W[side];
                v[side] += answer.cwiseProduct(more.all), start[side] += answer.cwiseProduct(more.agreeing);
            }
        }
    };
    std::tuple<Meeting<2>, Meeting<3>> meetings_;
    std::tuple<std::vector<Pair<2>>, std::vector<Pair<3>>> nodes_;

    template <int Dim> Meeting<Dim>& meeting(const Scene<Dim>& scene);
    template <int Dim, class LawOf>
    void settle(Meeting<Dim>& meeting, const Stretch& pair, double dt, LawOf&& lawOf);
    template <int Dim> double bound(Meeting<Dim>& meeting, const Stretch& pair);
    template <int Dim>
    bool renew(Site<Dim>& site, const Law& law, double dt, const int* at, const double* S, int count);
    template <int Dim> void check(Scene<Dim>& scene);
    template <int Dim> void tie(Scene<Dim>& scene);
    template <int Dim>
    double stopping(const Site<Dim>& site, const Vec<Dim>& answer, const Vec<Dim>& w, double dt) const;
    template <int Dim>
    Impulses<Dim> exchange(const Site<Dim>& site, const Law& law, double dt, const Vec<Dim>& answer,
                           const Vec<Dim>& start, const Vec<Dim>& w) const;
    template <int Dim>
    static void change(Scene<Dim>& scene, const Meet<Dim>& meet, int side, const Vec<Dim>& answer,
                       const Impulses<Dim>& J);
    template <int Dim> void addFriction(Meeting<Dim>& meeting, const Stretch& pair, double loss);
    template <int Dim> void tell(Scene<Dim>& scene, const Meet<Dim>& meet, const Vec<Dim>& slip);
    Law lawOf(int a, int b) const;
};

} // namespace mpm
