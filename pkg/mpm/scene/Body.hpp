// SPDX-License-Identifier: GPL-2.0-or-later
// A named set of particles with one particle type and one material.
#pragma once

#include "mpm/material/Material.hpp"
#include "mpm/particle/Domains.hpp"
#include "mpm/scene/CellAverage.hpp"
#include "mpm/state/VelocityGradient.hpp"

namespace mpm {

template <int Dim> class Body {
  public:
    std::string name;
    std::shared_ptr<Material> material;
    std::shared_ptr<ParticleType> type;
    Particles<Dim> particles;
    std::unique_ptr<Domains<Dim>> domains;
    double inertiaScale = 1;        // factor on the inertial mass, not on the weight
    bool isDamped = true;           // whether the local damping of the scene acts on it
    bool isImplicit = false;        // whether its elastic forces enter the solution (step/ImplicitBodies.hpp)
    bool fbar = false;              // one increment of volumetric strain and one linear mean stress per cell
    CellAverage<Dim> cellAverage;   // for fbar; as the particles lie at the start of the step
    std::string group = "main";     // bodies of one group stick together; between groups there may be contact
    int velocityField = 0;          // which of the grid's velocity fields the body moves with
    Body* convertsTo = nullptr;     // takes the particles of domains that became too distorted
    int converted = 0;              // domains converted so far
    double internalWork = 0;        // kJ (2D: per metre), int V sigma : D dt
    double lastInternalWork = 0;    // its part of the last step
    double largestInertialMass = 0; // Mg
    double time = 0;                // s, of the scene at the start of the step, as laws see it
    int64_t step = 0;

    Body(const std::string& name, std::shared_ptr<Material> material, std::shared_ptr<ParticleType> type,
         const Grid<Dim>& grid);
    Body(const Body&) = delete;

    // Makes the particles from a lattice or a mesh, at rest and free of stress.
    void build(const Geometry<Dim>& geometry) {
        domains->build(geometry);
        initialise(0);
        massesChanged();
    }

    // Mass and state variables of the particles from number `first` on.
    void initialise(int first);

    void massesChanged() {
        largestInertialMass = 0;
        for (int p = 0; p < particles.size(); ++p)
            largestInertialMass = std::max(largestInertialMass, inertiaScale * particles.mass.plane()[p]);
    }

    // Particles [begin, end) as their material sees them: with axial symmetry N = 3 and the zeros of VelocityGradient for
    // an update, else as in plane strain. state: room for a pointer to each state variable.
    template <int N = Dim>
    MaterialPoints<N> points(int begin, int end, double dt, double** state,
                             const double* zeros = VelocityGradient<N>::none) {
        MaterialPoints<N> points{};
        points.count = end - begin;
        points.dt = dt;
        points.time = time;
        points.step = step;
        points.body = name.c_str();
        points.id = particles.id.integers() + begin;
        points.hasFbar = fbar;
        points.isRing = N > Dim;
        points.volume = particles.volume.plane() + begin;
        points.initialVolume = particles.initialVolume.plane() + begin;
        for (int k = 0; k < N; ++k)
            points.position[k] = k < Dim ? particles.position.plane(k) + begin : zeros;
        const VelocityGradient<N> L(particles, begin, zeros);
        std::copy(L.plane, L.plane + N * N, points.velocityGradient);
        for (int c = 0; c < 9; ++c) {
            points.deformationGradient[c] = particles.deformationGradient.plane(c) + begin;
            points.stress[c] = particles.stress.plane(c) + begin;
        }
        for (size_t k = 0; k < particles.state.size(); ++k) state[k] = particles.state[k].plane() + begin;
        points.state = state;
        return points;
    }

    // Lame constants of particles [begin, end), kPa.
    void stiffness(int begin, int end, double* lambda, double* mu) {
        std::vector<double*> state(particles.state.size());
        material->stiffness(points(begin, end, 0, state.data()), lambda, mu);
    }

    // Shear stress that particles [begin, end) can bear, kPa.
    void shearStrength(int begin, int end, double* strength) {
        std::vector<double*> state(particles.state.size());
        material->shearStrength(points(begin, end, 0, state.data()), strength);
    }

    // Elastic energy of all particles, kJ.
    double storedEnergy();

    // Gives particle p a Cauchy stress, and the material's state that belongs to it.
    void setStress(int p, const double stress[9]);

    // Checks the parameters of each particle, and gives it the state variables that belong to them.
    void takeParameters();

  private:
    // Edge of a square or cube as large as the cell of the grid around a particle, m.
    double cellSizeAt(int p) const {
        return std::pow(grid_.sizeAt(vectorAt<Dim>(particles.position, p)).prod(), 1.0 / Dim);
    }

    const Grid<Dim>& grid_;
};

// Whether rates of volume change and mean stress of a body act by the cells of the grid: of boxes, and of meshes that
// fill cells together with boxes.
template <int Dim> bool actsByCells(const Body<Dim>& body) {
    return body.fbar && body.cellAverage.actByCells();
}

} // namespace mpm
