// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/scene/Body.hpp"

namespace mpm {

template <int Dim>
Body<Dim>::Body(const std::string& name, std::shared_ptr<Material> material,
                std::shared_ptr<ParticleType> type, const Grid<Dim>& grid)
    : name(name), material(material), type(type), domains(type->make(particles, grid)), grid_(grid) {
    domains->bodyName = name;
    particles.isAxisymmetric = grid.isAxisymmetric;
    domains->stiffness = [this](int begin, int end, double* lambda, double* mu) {
        stiffness(begin, end, lambda, mu);
    };
    domains->shearStrength = [this](int begin, int end, double* strength) {
        shearStrength(begin, end, strength);
    };
    domains->section = material->section();
    for (const StateVariable& v : material->allStateVariables())
        particles.state.emplace_back(v.name, v.unit, v.doc);
}

template <int Dim> void Body<Dim>::initialise(int first) {
    const auto variables = material->allStateVariables();
    for (int p = first; p < particles.size(); ++p) {
        particles.mass.plane()[p] = material->density * particles.initialVolume.plane()[p];
        for (size_t k = 0; k < variables.size(); ++k)
            particles.state[k].plane()[p] = variables[k].isCellSize ? cellSizeAt(p) : variables[k].initial;
    }
}

template <int Dim> double Body<Dim>::storedEnergy() {
    std::vector<double> energy(particles.size());
    std::vector<double*> state(particles.state.size());
    material->storedEnergy(points(0, particles.size(), 0, state.data()), energy.data());
    double sum = 0;
    for (int p = 0; p < particles.size(); ++p) sum += energy[p] * particles.volume.plane()[p];
    return sum;
}

template <int Dim> void Body<Dim>::setStress(int p, const double stress[9]) {
    std::vector<double> state(particles.state.size() + 1);
    for (size_t k = 0; k < particles.state.size(); ++k) state[k] = particles.state[k].plane()[p];
    material->startState(stress, state.data());
    for (int c = 0; c < 9; ++c) // planes that stay zero are not touched: they take no memory
        if (double& component = particles.stress.plane(c)[p]; component != stress[c]) component = stress[c];
    for (size_t k = 0; k < particles.state.size(); ++k) particles.state[k].plane()[p] = state[k];
}

template <int Dim> void Body<Dim>::takeParameters() {
    std::vector<double> state(particles.state.size() + 1);
    for (int p = 0; p < particles.size(); ++p) {
        for (size_t k = 0; k < particles.state.size(); ++k) state[k] = particles.state[k].plane()[p];
        try {
            material->startState(nullptr, state.data());
        } catch (const InputError& error) {
            throw InputError(message("body '", name, "': particle ", particles.id.integers()[p], " at ",
                                     place(vectorAt<Dim>(particles.position, p)), ": ", error.what()));
        }
        for (size_t k = 0; k < particles.state.size(); ++k) particles.state[k].plane()[p] = state[k];
    }
}

template class Body<2>;
template class Body<3>;

} // namespace mpm
