// SPDX-License-Identifier: GPL-2.0-or-later
// A mesh that resists like a beam: elements between cross-sections, with the state of their material
// (material/BeamSection.cpp). The vertices are first those on the right faces of the sections, along the line, then
// those on the left ones; all others hang on the four of an element, whose domains follow each other, but for those
// inside of the ends (BeamEnds.hpp).
#pragma once

#include "mpm/particle/apdi/BeamElement.hpp"
#include "mpm/particle/apdi/BeamEnds.hpp"
#include "mpm/state/Particles.hpp"

#include <vector>

namespace mpm {

class Beam {
  public:
    using Vertices = std::array<int, 4>;

    bool isHere() const { return !parts_.empty(); }

    void restored(const DomainMesh<2>& mesh, const Particles<2>& particles, const SectionStiffness& section,
                  bool isRound) {
        parts_.clear();
        ends_.clear();
        const std::vector<int>& masters = mesh.vertices.hanging.masters;
        const int sections =
            masters.empty() ? 0 : (*std::max_element(masters.begin(), masters.end()) + 1) / 2;
        for (int p = 0; p < mesh.domains(); ++p) {
            const Vertices corner = sectionsOf(mesh, p, sections);
            if (parts_.empty() || parts_.back().corner != corner)
                parts_.push_back(
                    {BeamElement(at(mesh.vertices.reference, corner), section, isRound), corner, p});
            parts_.back().end = p + 1;
            ends_.find(mesh, p, 2 * sections, corner, parts_.back().element.stiffnessAtEnd());
        }
        ends_.found();
        energy_ = energyOf(mesh, particles);
    }

    const BeamEnds& ends() const { return ends_; }

    // Forces of the elements on the vertices, kN.
    void addForces(const DomainMesh<2>& mesh, const Particles<2>& particles, double* const force[2]) const {
        ends_.addForces(mesh, force);
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
        int first, end = 0; // of its domains
    };
    std::vector<Part> parts_;
    BeamEnds ends_;
    double energy_ = 0; // elastic, kJ

    static Corners<2> at(const Field& positions, const Vertices& corner) {
        Corners<2> x;
        for (int a = 0; a < 4; ++a)
            for (int k = 0; k < 2; ++k) x(k, a) = positions.plane(k)[corner[a]];
        return x;
    }

    // The vertices of the element that domain p belongs to.
    static Vertices sectionsOf(const DomainMesh<2>& mesh, int p, int sections) {
        std::vector<int> found;
        for (int a = 0; a < 4; ++a)
            mesh.vertices.hanging.through(mesh.corner[4 * p + a], [&](int v, double) {
                if (v < 2 * sections) found.push_back(v);
            });
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        require(found.size() == 4 && found[1] < sections && found[2] >= sections, "Beam: domain ", p,
                " is not between two cross-sections; make the mesh by mpm.Beam");
        int start = found[0], end = found[1];
        if (end - start != 1) std::swap(start, end); // where a ring closes
        return {start, end, sections + end, sections + start};
    }

    BeamElement::Strained strained(const DomainMesh<2>& mesh, const Particles<2>& particles,
                                   const Part& part) const {
        const double hinges[2] = {particles.state[hingeStart].plane()[part.first],
                                  particles.state[hingeEnd].plane()[part.first]};
        return part.element.strained(at(mesh.vertices.position, part.corner), hinges);
    }

    double energyOf(const DomainMesh<2>& mesh, const Particles<2>& particles) const {
        double sum = ends_.energy(mesh);
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
