// SPDX-License-Identifier: GPL-2.0-or-later
// A mesh that resists like a beam or, in 3D, a plate: elements between fibres, with the state of their material
// (material/BeamSection.cpp). A fibre is a row of vertices from the right face to the left one (BeamTies.hpp). The
// vertices are first those of the fibres, one fibre after the other; all others hang on the fibres round them. An element
// has a stack of domains at each of its fibres, two along the line, in 3D four round the rectangle. Its domains follow
// each other stack by stack, each stack from the right face to the left one.
#pragma once

#include "mpm/particle/apdi/BeamElement.hpp"
#include "mpm/particle/apdi/BeamTies.hpp"
#include "mpm/particle/apdi/PlateElement.hpp"
#include "mpm/state/Particles.hpp"

#include <set>
#include <vector>

namespace mpm {

template <int Dim> class Beam {
  public:
    using Element = std::conditional_t<Dim == 2, BeamElement, PlateElement>;
    using Vertices = std::array<int, Element::corners>;

    bool isHere() const { return !parts_.empty(); }

    void restored(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles,
                  const SectionStiffness& section, bool isRound) {
        parts_.clear();
        ties_.clear();
        const HangingVertices& hanging = mesh.vertices.hanging;
        if (hanging.count() == 0) return;
        const int perFibre = hanging.masters[1] - hanging.masters[0], across = perFibre - 1;
        const int ofFibres = hanging.slaves[0], ofElement = stacks * across;
        require(across > 0 && ofFibres % perFibre == 0 && mesh.domains() % ofElement == 0,
                "Beam: its mesh is not one of domains between cross-sections; make it by mpm.Beam");
        // Fibres that have their ties. The element whose first fibre it is gives a fibre its ties, if there is one.
        std::set<int> tied;
        for (int first = 0; first < mesh.domains(); first += ofElement) {
            Vertices corner;
            for (int f = 0; f < stacks; ++f) {
                const int right = mesh.corner[Element::corners * (first + f * across) + f];
                require(right < ofFibres && right % perFibre == 0, "Beam: domain ", first,
                        " has no fibre of its mesh where one is needed; make it by mpm.Beam");
                setFibre(corner, f, right, right + across);
            }
            parts_.push_back({Element(at(mesh.vertices.reference, corner), section, isRound), corner, first,
                              first + ofElement});
            tied.insert(corner[0]);
        }
        for (const Part& part : parts_)
            for (int f = 0; f < stacks; ++f) {
                const int right = part.corner[f];
                if (f > 0 && !tied.insert(right).second) continue;
                for (int i = 1; i < across; ++i)
                    ties_.add({part.first + f * across + i, right + i, right, right + across,
                               double(i) / across, part.element.stiffnessAtEnd()});
            }
        energy_ = energyOf(mesh, particles);
    }

    const BeamTies<Dim>& ties() const { return ties_; }

    // Forces of the elements on the vertices, kN.
    void addForces(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles,
                   double* const force[Dim]) const {
        ties_.addForces(mesh, force);
        for (const Part& part : parts_) {
            const auto s = strained(mesh, particles, part);
            for (int r = 0; r < Element::rows; ++r)
                for (int a = 0; a < Element::corners; ++a)
                    for (int k = 0; k < Dim; ++k)
                        force[k][part.corner[a]] -= part.element.stiffness(r) * s.e[r] * s.gradient[r][a][k];
        }
    }

    // Momentum of the domains, which turn with their section: particles hold that of their middles alone, and sections
    // would have to be turned anew in every step.
    void addSpin(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles, double inertiaScale,
                 double* const momentum[Dim]) const {
        for (int p = 0; p < mesh.domains(); ++p) {
            const Corners<Dim> x = mesh.cornersOf(p);
            const Vec<Dim> middle = x.rowwise().mean();
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j) {
                    if (i == j) continue;
                    const double turned = 0.5 * (particles.velocityGradient.plane(Dim * i + j)[p] -
                                                 particles.velocityGradient.plane(Dim * j + i)[p]);
                    const double spin = turned / Element::corners * inertiaScale * particles.mass.plane()[p];
                    for (int a = 0; a < Element::corners; ++a)
                        momentum[i][mesh.corner[Element::corners * p + a]] += spin * (x(j, a) - middle[j]);
                }
        }
    }

    // Once per step, when the vertices have moved: sections yield, the particles are told the forces in their sections.
    // Returns the work of the step, kJ: the solution for the nodes knows no hinges, so that until they turn the beam is
    // elastic, and what it loses then has gone into them.
    double finishStep(const DomainMesh<Dim>& mesh, Particles<Dim>& particles) {
        const double before = energy_, until = energyOf(mesh, particles);
        for (const Part& part : parts_) {
            auto plastic = plasticOf(particles, part);
            part.element.yield(strained(mesh, particles, part), plastic);
            forStacks(part, [&](int f, int begin, int end) {
                for (int i = 0; i < Element::ofStack; ++i) {
                    double* all = particles.state[Element::firstPlastic + i].plane();
                    std::fill(all + begin, all + end, plastic[Element::placeOf(f, i)]);
                }
            });
            tell(part, strained(mesh, particles, part), particles);
        }
        energy_ = energyOf(mesh, particles);
        return until - before;
    }

    // f(element, its vertices, what strains it, first row, end) if domain p has rows of an element to tell: in 2D all of
    // them, in 3D a quarter for the first domain of each stack.
    template <class F>
    void ifTells(int p, const DomainMesh<Dim>& mesh, const Particles<Dim>& particles, F&& f) const {
        const auto after = std::upper_bound(parts_.begin(), parts_.end(), p,
                                            [](int domain, const Part& one) { return domain < one.first; });
        const Part& part = *std::prev(after);
        const int across = (part.end - part.first) / stacks, set = (p - part.first) / across;
        if ((p - part.first) % across != 0 || set >= Element::rowSets) return;
        constexpr int each = (Element::rows + Element::rowSets - 1) / Element::rowSets;
        f(part.element, part.corner, strained(mesh, particles, part), each * set,
          std::min(each * (set + 1), int(Element::rows)));
    }

  private:
    static constexpr int stacks = Element::corners / 2; // of the domains of an element, each at a fibre

    struct Part {
        Element element;
        Vertices corner;
        int first, end; // of its domains
    };
    std::vector<Part> parts_;
    BeamTies<Dim> ties_;
    double energy_ = 0; // elastic, kJ

    // Of fibre f the ends in the order of the corners: counter-clockwise in 2D, of a hexahedron in 3D.
    static void setFibre(Vertices& corner, int f, int right, int left) {
        corner[f] = right;
        corner[Dim == 2 ? Element::corners - 1 - f : Element::corners / 2 + f] = left;
    }
    static Corners<Dim> at(const Field& positions, const Vertices& corner) {
        Corners<Dim> x;
        for (int a = 0; a < Element::corners; ++a)
            for (int k = 0; k < Dim; ++k) x(k, a) = positions.plane(k)[corner[a]];
        return x;
    }
    // f(number, first domain, end) for the stacks of an element.
    template <class F> static void forStacks(const Part& part, F&& f) {
        const int across = (part.end - part.first) / stacks;
        for (int stack = 0; stack < stacks; ++stack)
            f(stack, part.first + stack * across, part.first + (stack + 1) * across);
    }
    static typename Element::Plastic plasticOf(const Particles<Dim>& particles, const Part& part) {
        typename Element::Plastic plastic;
        forStacks(part, [&](int f, int begin, int) {
            for (int i = 0; i < Element::ofStack; ++i)
                plastic[Element::placeOf(f, i)] = particles.state[Element::firstPlastic + i].plane()[begin];
        });
        return plastic;
    }

    typename Element::Strained strained(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles,
                                        const Part& part) const {
        return part.element.strained(at(mesh.vertices.position, part.corner), plasticOf(particles, part));
    }

    double energyOf(const DomainMesh<Dim>& mesh, const Particles<Dim>& particles) const {
        double sum = ties_.energy(mesh);
        for (const Part& part : parts_) sum += part.element.energy(strained(mesh, particles, part));
        return sum;
    }

    static void tell(const Part& part, const typename Element::Strained& s, Particles<Dim>& particles) {
        const double energy = part.element.energy(s) * part.element.overVolume();
        forStacks(part, [&](int f, int begin, int end) {
            const auto set = [&](SectionState what, double value) {
                double* all = particles.state[what].plane();
                std::fill(all + begin, all + end, value);
            };
            part.element.forces(s, f, set);
            set(elasticEnergy, energy);
        });
    }
};

} // namespace mpm
