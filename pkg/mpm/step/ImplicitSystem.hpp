// SPDX-License-Identifier: GPL-2.0-or-later
// The nodes that implicit bodies move together, their elastic stiffness K, and the solution of
//     (M + dt^2 K) v = p + dt f - dt^2 K v_held
// for the free components. Nodes are numbered along the axis that makes the band narrowest. The factor of the matrix
// is a band; K itself acts particle by particle.
#pragma once

#include "mpm/scene/Scene.hpp"
#include "mpm/step/BandMatrix.hpp"
#include "mpm/step/ImpulseResponse.hpp"
#include "mpm/step/StrainedNodes.hpp"

namespace mpm {

template <int Dim> class ImplicitSystem {
  public:
    using NF = NodalField<Dim>;

    int field = -1; // velocity field
    std::vector<int> nodes;

    // Begins anew, in the memory that it has.
    void reset(int velocityField);
    // Some particles of its bodies, which the caller keeps until the next step.
    void addMember(StrainedNodes<Dim>& member) { members_.push_back(&member); }
    // `nodes`, each of which is there once, into the order of the unknowns.
    void sortNodes(const Grid<Dim>& grid);
    // Tells the particles their unknowns. number: of each node, its place in `nodes`.
    void place(const std::vector<int>& number);

    // On a node, kN s, and the change of its velocity that the particles do not take, m/s.
    struct Impulse {
        int node;
        Vec<Dim> given, unfelt;
    };

    // Replaces the explicit motion of the nodes; returns whether the matrix is positive definite.
    bool solve(Scene<Dim>& scene, const Vec<Dim>& gravity);

    // Tells those nodes of a response that belong to the system, number `body`, their unknowns. number: of nodes.
    void place(ImpulseResponse<Dim>& response, int body, const std::vector<int>& number) const;
    // Starts a way along it from the last unknown to `first`; a site of contact has unknowns less than `span` apart.
    void start(const Scene<Dim>& scene, ImpulseSweep& sweep, int first, int span);
    // Changes of the velocities of the nodes of a response that are its own, as system number `body`, by impulses on them.
    void answer(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                const std::vector<Vec<Dim>>& impulses, std::vector<Vec<Dim>>& changes);
    // Lets the same impulses strain the bodies, and no more.
    void strain(Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                const std::vector<Vec<Dim>>& impulses);
    // Adds what impulses on nodes change in the motion of all.
    void take(Scene<Dim>& scene, const Vec<Dim>& gravity, const std::vector<Impulse>& impulses,
              const std::vector<int>& number);

    // What the solution took out of the motion that the nodes have now.
    void addEnergies(Scene<Dim>& scene);

    int unknowns() const { return Dim * int(nodes.size()); }

  private:
    std::vector<StrainedNodes<Dim>*> members_;
    BandMatrix factor_;
    bool isFactorised_ = false;
    int band_ = 0;
    std::vector<double> velocity_, force_, solved_, unfelt_; // of the unknowns, and zeros behind them
    std::vector<double> straining_;                          // what only strains, m/s
    using Entry = typename StrainedNodes<Dim>::Entry;
    using Strained = typename StrainedNodes<Dim>::Strained;
    std::vector<const Entry*> order_; // of the particle in work
    std::vector<Vec<Dim>> atStart_,
        weight_; // of the bodies: force of their stress at the start of the step; kN

    short holderOf(const NF& nodal, int unknown) const {
        return nodal.holder[nodes[unknown / Dim]][unknown % Dim];
    }
    // f(place in the response, axis, unknown) for the unknowns that may move.
    template <class F>
    void forUnknowns(const NF& nodal, const ImpulseResponse<Dim>& response, int body, F&& f) const {
        for (size_t n = 0; n < response.nodes.size(); ++n)
            for (int k = 0; k < Dim && response.nodes[n].body == body; ++k)
                if (const int i = response.nodes[n].unknown + k; holderOf(nodal, i) < 0) f(n, k, i);
    }
    void solveFor(const Scene<Dim>& scene, const ImpulseResponse<Dim>& response, int body,
                  const std::vector<Vec<Dim>>& impulses);
    // v and a of a node; returns what gravity gains, kW.
    double change(Scene<Dim>& scene, const Vec<Dim>& gravity, int unknown, double v, double a) const;
    // solved_ <- the velocities by the momenta that it has; returns whether that was possible.
    bool findVelocities(const Scene<Dim>& scene);
    // By iteration, where that costs less than a factor that nobody else asks for.
    bool iterate(const Scene<Dim>& scene);
    bool mayMeetOthers(const Scene<Dim>& scene) const;
    bool factorise(const Scene<Dim>& scene);
    void requireFactor(const Scene<Dim>& scene);
    // factor_ = dt^2 K.
    void assemble(double square);
    void add(double square, const StrainedNodes<Dim>& strained, const Strained& particle);
    void addBeam(double square, const StrainedNodes<Dim>& strained, const Strained& particle);
    // force = K x.
    void multiply(const std::vector<double>& x, std::vector<double>& force) const;
    void addForce(const StrainedNodes<Dim>& strained, const Strained& particle, const double* x,
                  double* force) const;
    void addBeamForce(const StrainedNodes<Dim>& strained, const Strained& particle, const double* x,
                      double* force) const;
    void react(Scene<Dim>& scene, int unknown, double force) const;
};

} // namespace mpm
