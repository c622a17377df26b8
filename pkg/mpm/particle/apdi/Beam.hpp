// SPDX-License-Identifier: GPL-2.0-or-later
// A mesh that resists like a beam: elements between cross-sections, with the state of their material
// (material/BeamSection.cpp). The vertices are first those of the sections, along the line, each from its right face to
// its left one (BeamTies.hpp). All others hang on those of the sections before and behind them. The domains of an
// element follow each other, row by row across it.
#pragma once

#include "mpm/particle/apdi/BeamElement.hpp"
#include "mpm/particle/apdi/BeamTies.hpp"
#include "mpm/state/Particles.hpp"

#include <vector>

namespace mpm {

class Beam {
  public:
    using Vertices = std::array<int, 4>;
    static constexpr int along = 2; // domains between two sections

    bool isHere() const { return !parts_.empty(); }

    void restored(const DomainMesh<2>& mesh, const Particles<2>& particles, const SectionStiffness& section,
                  bool isRound) {
        parts_.clear();
        ties_.clear();
        const HangingVertices& hanging = mesh.vertices.hanging;
        if (hanging.count() == 0) return;
        const int perSection = hanging.masters[1] - hanging.masters[0], across = perSection - 1;
        const int sections = perSection > 1 ? hanging.slaves[0] / perSection : 0;
        const int elements = perSection > 1 ? mesh.domains() / (along * across) : 0;
        require(sections > 1 && (elements == sections - 1 || elements == sections) &&
                    elements * along * across == mesh.domains(),
                "Beam: its mesh is not one of domains between cross-sections; make it by mpm.Beam");
        for (int e = 0; e < elements; ++e) {
            const int start = perSection * e, end = perSection * ((e + 1) % sections);
            const Vertices corner = {start, end, end + across, start + across};
            const int first = along * across * e, last = first + (along - 1) * across;
            parts_.push_back({BeamElement(at(mesh.vertices.reference, corner), section, isRound), corner,
                              first, last + across});
            const double k = parts_.back().element.stiffnessAtEnd();
            for (int i = 1; i < across; ++i)
                ties_.add({first + i, start + i, start, start + across, double(i) / across, k});
            for (int i = 1; i < across && e == sections - 2 && elements < sections; ++i)
                ties_.add({last + i, end + i, end, end + across, double(i) / across, k});
        }
        energy_ = energyOf(mesh, particles);
    }

    const BeamTies& ties() const { return ties_; }

    // Forces of the elements on the vertices, kN.
    void addForces(const DomainMesh<2>& mesh, const Particles<2>& particles, double* const force[2]) const {
        ties_.addForces(mesh, force);
        for (const Part& part : parts_) {
            const auto s = strained(mesh, particles, part);
            for (int r = 0; r < BeamElement::rows; ++r)
                for (int a = 0; a < 4; ++a)
                    for (int k = 0; k < 2; ++k)
                        force[k][part.corner[a]] -= part.element.stiffness(r) * s.e[r] * s.gradient[r][a][k];
        }
    }

    // Momentum of the domains, which turn with their section: particles hold that of their middles alone, and sections
    // would have to be turned anew in every step.
    void addSpin(const DomainMesh<2>& mesh, const Particles<2>& particles, double inertiaScale,
                 double* const momentum[2]) const {
        const double *xy = particles.velocityGradient.plane(1), *yx = particles.velocityGradient.plane(2);
        for (int p = 0; p < mesh.domains(); ++p) {
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
        for (const Part& part : parts_) {
            double turned[2] = {particles.state[hingeStart].plane()[part.first],
                                particles.state[hingeEnd].plane()[part.first]};
            part.element.yield(strained(mesh, particles, part), turned);
            for (int p = part.first; p < part.end; ++p)
                for (int end = 0; end < 2; ++end) particles.state[hingeStart + end].plane()[p] = turned[end];
            tell(part, strained(mesh, particles, part), particles);
        }
        energy_ = energyOf(mesh, particles);
        return until - before;
    }

    // f(element, its vertices, what strains it) if domain p is the first of an element.
    template <class F>
    void ifFirst(int p, const DomainMesh<2>& mesh, const Particles<2>& particles, F&& f) const {
        const auto part = std::lower_bound(parts_.begin(), parts_.end(), p,
                                           [](const Part& one, int domain) { return one.first < domain; });
        if (part != parts_.end() && part->first == p)
            f(part->element, part->corner, strained(mesh, particles, *part));
    }

  private:
    // Places in BeamSection::stateVariables().
    enum { normalForce, shearForce, bendingMoment, hingeStart, hingeEnd, hoopForce, hoopMoment };

    struct Part {
        BeamElement element;
        Vertices corner;
        int first, end; // of its domains
    };
    std::vector<Part> parts_;
    BeamTies ties_;
    double energy_ = 0; // elastic, kJ

    static Corners<2> at(const Field& positions, const Vertices& corner) {
        Corners<2> x;
        for (int a = 0; a < 4; ++a)
            for (int k = 0; k < 2; ++k) x(k, a) = positions.plane(k)[corner[a]];
        return x;
    }

    BeamElement::Strained strained(const DomainMesh<2>& mesh, const Particles<2>& particles,
                                   const Part& part) const {
        const double hinges[2] = {particles.state[hingeStart].plane()[part.first],
                                  particles.state[hingeEnd].plane()[part.first]};
        return part.element.strained(at(mesh.vertices.position, part.corner), hinges);
    }

    double energyOf(const DomainMesh<2>& mesh, const Particles<2>& particles) const {
        double sum = ties_.energy(mesh);
        for (const Part& part : parts_) sum += part.element.energy(strained(mesh, particles, part));
        return sum;
    }

    // With the signs of sectionForces: Q along the normal to the right of the line, M with tension to its left.
    static void tell(const Part& part, const BeamElement::Strained& s, Particles<2>& particles) {
        const auto set = [&](int variable, double sign, int row) {
            const double force = sign * part.element.stiffness(row) * s.e[row] * part.element.overVolume();
            double* all = particles.state[variable].plane();
            std::fill(all + part.first, all + part.end, force);
        };
        set(normalForce, 1, BeamElement::axial);
        set(shearForce, -1, BeamElement::shear);
        set(bendingMoment, -1, BeamElement::curvature);
        set(hoopForce, 1, BeamElement::hoop);
        set(hoopMoment, -1, BeamElement::hoopCurvature);
    }
};

} // namespace mpm
