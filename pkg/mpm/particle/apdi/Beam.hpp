// SPDX-License-Identifier: GPL-2.0-or-later
// A mesh with one domain across that resists like a beam: one element per domain, from the corners of the undeformed
// domains and the state of their material (material/BeamSection.cpp).
#pragma once

#include "mpm/particle/apdi/BeamElement.hpp"
#include "mpm/particle/apdi/DomainMesh.hpp"
#include "mpm/state/Particles.hpp"

#include <vector>

namespace mpm {

class Beam {
  public:
    bool isHere() const { return !elements_.empty(); }

    void restored(const DomainMesh<2>& mesh, const Particles<2>& particles, const SectionStiffness& section,
                  bool isRound) {
        elements_.clear();
        for (int p = 0; p < mesh.domains(); ++p)
            elements_.emplace_back(mesh.cornersOf(p, mesh.vertices.reference), section, isRound);
        energy_ = energyOf(mesh, particles);
    }

    // Forces of the elements on the vertices, kN.
    void addForces(const DomainMesh<2>& mesh, const Particles<2>& particles, double* const force[2]) const {
        for (int p = 0; p < int(elements_.size()); ++p) {
            const auto s = strained(mesh, particles, p);
            for (int r = 0; r < BeamElement::rows; ++r)
                for (int a = 0; a < 4; ++a)
                    for (int k = 0; k < 2; ++k)
                        force[k][mesh.corner[4 * p + a]] -=
                            elements_[p].stiffness(r) * s.e[r] * s.gradient[r][a][k];
        }
    }

    // Momentum of the cross-sections, which turn with the domains: particles hold that of their middles alone, and
    // sections would have to be turned anew in every step.
    void addSpin(const DomainMesh<2>& mesh, const Particles<2>& particles, double inertiaScale,
                 double* const momentum[2]) const {
        const double *xy = particles.velocityGradient.plane(1), *yx = particles.velocityGradient.plane(2);
        for (int p = 0; p < int(elements_.size()); ++p) {
            const Corners<2> x = mesh.cornersOf(p);
            const Vec<2> middle = x.rowwise().mean();
            const double spin = 0.5 * (yx[p] - xy[p]) * 0.25 * inertiaScale * particles.mass.plane()[p];
            for (int a = 0; a < 4; ++a) {
                momentum[0][mesh.corner[4 * p + a]] -= spin * (x(1, a) - middle[1]);
                momentum[1][mesh.corner[4 * p + a]] += spin * (x(0, a) - middle[0]);
            }
        }
    }

    // Once per step, when the vertices have moved: hinges turn, the particles are told the forces in their sections.
    // Returns the work of the step, kJ: the solution for the nodes knows no hinges, so that until they turn the beam is
    // elastic, and what it loses then has gone into them.
    double finishStep(const DomainMesh<2>& mesh, Particles<2>& particles) {
        const double before = energy_, until = energyOf(mesh, particles);
        for (int p = 0; p < int(elements_.size()); ++p) {
            double turned[2] = {particles.state[hingeStart].plane()[p], particles.state[hingeEnd].plane()[p]};
            elements_[p].yield(strained(mesh, particles, p), turned);
            for (int end = 0; end < 2; ++end) particles.state[hingeStart + end].plane()[p] = turned[end];
            tell(p, strained(mesh, particles, p), particles);
        }
        energy_ = energyOf(mesh, particles);
        return until - before;
    }

    const BeamElement& element(int p) const { return elements_[p]; }
    BeamElement::Strained strained(const DomainMesh<2>& mesh, const Particles<2>& particles, int p) const {
        const double hinges[2] = {particles.state[hingeStart].plane()[p],
                                  particles.state[hingeEnd].plane()[p]};
        return elements_[p].strained(mesh.cornersOf(p), hinges);
    }

  private:
    // Places in BeamSection::stateVariables().
    enum { normalForce, shearForce, bendingMoment, hingeStart, hingeEnd, hoopForce, hoopMoment };

    std::vector<BeamElement> elements_;
    double energy_ = 0; // elastic, kJ

    double energyOf(const DomainMesh<2>& mesh, const Particles<2>& particles) const {
        double sum = 0;
        for (int p = 0; p < int(elements_.size()); ++p)
            sum += elements_[p].energy(strained(mesh, particles, p));
        return sum;
    }

    // With the signs of sectionForces: Q along the normal to the right of the line, M with tension to its left.
    void tell(int p, const BeamElement::Strained& s, Particles<2>& particles) const {
        const auto set = [&](int variable, double sign, int row) {
            particles.state[variable].plane()[p] =
                sign * elements_[p].stiffness(row) * s.e[row] * elements_[p].overVolume();
        };
        set(normalForce, 1, BeamElement::axial);
        set(shearForce, -1, BeamElement::shear);
        set(bendingMoment, -1, BeamElement::curvature);
        set(hoopForce, 1, BeamElement::hoop);
        set(hoopMoment, -1, BeamElement::hoopCurvature);
    }
};

} // namespace mpm
