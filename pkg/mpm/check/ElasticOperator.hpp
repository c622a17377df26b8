// SPDX-License-Identifier: GPL-2.0-or-later
// The elastic stiffness of a scene as it stands, as an operator on nodal velocities: K v is one gather of the velocity gradient,
// the elastic law, and one scatter of the force; K is never formed. Anti-locking is left out (its operator is not symmetric),
// hourglass stiffness is in. What it writes is its own: fields that particles and vertices keep from the last step stay.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

template <int Dim> class ElasticOperator {
  public:
    // Finds the particles in the grid and sums their mass; the nodes hold no sums of a step afterwards.
    // explicitAlone: of bodies that are solved for implicitly the mass is in, the stiffness is not.
    explicit ElasticOperator(Scene<Dim>& scene, bool explicitAlone = false);

    // Free components of nodes that have mass, and the mass of each, Mg.
    int size() const { return int(dofs_.size()); }
    const std::vector<double>& mass() const { return mass_; }

    // y = M^-1 K x, x a velocity (m/s) and y in m/s2 per s.
    void apply(const std::vector<double>& x, std::vector<double>& y);

    // y = M^-1 C x: what is left of a nodal velocity that the particles take and give back; C is the
    // consistent mass. Nodes that implicit bodies share with others are strained by what was solved for: there
    // 2 B - M^-1 C, the law of USL, B like M^-1 C but without what these nodes give to others and take from them.
    void passThroughParticles(const std::vector<double>& x, std::vector<double>& y);

    // Body with the largest elastic power in the motion applied last.
    std::string stiffest() const;

  private:
    using NF = NodalField<Dim>;
    struct Dof {
        int field, node, axis;
    };
    // Memory that stands in for a field of the scene while the operator is applied.
    struct StandIn {
        Field* field;
        Field own;
        StandIn(Field& field) : field(&field), own(field) { own.resize(field.size()); }
    };
    class Exchanged;

    Scene<Dim>& scene_;
    std::vector<char> isIn_; // each body, with its stiffness
    std::vector<Dof> dofs_;
    std::vector<double> mass_;
    std::vector<char>
        isSolved_; // of each, whether it is of a node that implicit bodies share; empty: none is
    std::vector<double> toSolved_;                           // of each, what its M^-1 C gives to these
    std::vector<NodeArray<typename NF::Velocity>> velocity_; // of the nodes of each velocity field
    std::vector<NodeArray<typename NF::Sum>> force_;
    std::vector<NodeArray<typename NF::Motion>> motion_;
    std::vector<Field> stress_;     // of each body
    std::vector<StandIn> gradient_; // of its velocity,
    std::vector<StandIn> vertices_; // of its particles, and of its vertices where it has some

    void freeSharedNodes(bool explicitAlone);
    void findDofs();
    void findSolved();
    void passAll(const std::vector<double>& x, std::vector<double>& y);
    void take(const std::vector<double>& x);
    // Of the free components, and of the images behind rollers.
    template <class Values> void setValues(Values& values, const std::vector<double>& x) const;
    void sumForces(ParallelRegion& region);
    void readForces(std::vector<double>& y) const;
    void strain(ParallelRegion& region);
    template <int N> static void elasticStress(Body<Dim>& body, Field& stress, int begin, int end);
};

} // namespace mpm
