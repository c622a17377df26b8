// SPDX-License-Identifier: GPL-2.0-or-later
// The velocity that strains the particles, from their own momentum: behind GridToParticle under MUSL, behind
// ParticleToGrid under USF. The scene puts it into the chain.
#include "mpm/step/nodes.hpp"

namespace mpm {

class VelocityRemap : public EngineOf<VelocityRemap>, public TakingMomenta {
  public:
    std::string className() const override { return "VelocityRemap"; }
    std::string doc() const override;
    template <int Dim> void act(Scene<Dim>& scene);
};

namespace {

// Before the particles add their momentum.
template <int Dim>
void clearMomentum(ParallelRegion& region, const Scene<Dim>& scene, NodalField<Dim>& field) {
    const double least = scene.leastMass();
    forActiveNodes(region, scene, field, [&](int node) {
        const double m = field.sum[node][NodalField<Dim>::mass];
        field.clearMomentum(node, m > least ? 1 / m : 0);
    });
}

// What particles gave to the images of nodes behind rollers.
template <int Dim> void foldMomenta(Scene<Dim>& scene) {
    for (size_t f = 0; f < scene.grid.fields.size(); ++f) {
        auto& field = scene.grid.fields[f];
        scene.state.mirrors.foldValues(
            int(f), [&](int ghost, int k) { return field.velocityOf(ghost, k); },
            [&](int node, int k, double p) { field.setVelocity(node, k, field.velocityOf(node, k) + p); });
    }
}

// With what is prescribed: at the end of the step, or at its start.
template <int Dim>
void momentumToVelocity(ParallelRegion& region, const Scene<Dim>& scene, NodalField<Dim>& field) {
    const bool isStart = scene.scheme->stressFirst;
    forActiveNodes(region, scene, field, [&](int node) {
        const bool isMoved = field.momentumToVelocity(node);
        if (!isMoved || !field.isHeld(node)) return;
        for (int k = 0; k < Dim; ++k)
            if (const int c = field.holder[node][k]; c >= 0)
                field.setVelocity(node, k,
                                  isStart ? scene.heldAtStart(c, k, field.velocityOf(node, k))
                                          : scene.heldAtEnd(c, k));
    });
}

} // namespace

std::string VelocityRemap::doc() const {
    return "Maps the momentum of the particles back to the nodes: the velocity that strains them "
           "(MUSL, USF).\n\n"
           "v_i <- sum phi m_p v_p / m_i with the weights of the step's start (Sulsky et al. 1995), "
           "then what is\n"
           "prescribed and what Contact asks for. The scene puts it behind GridToParticle (USF: behind\n"
           "ParticleToGrid); give it only where something shall stand between the two. Behind "
           "GridToParticle itself the\n"
           "particles have given their momentum while they were moved.";
}

template <int Dim> void VelocityRemap::act(Scene<Dim>& scene) {
    using Straining = typename NodalField<Dim>::Straining;
    auto& fields = scene.grid.fields;
    const bool isGiven = fields.front().straining == Straining::momentum;                // by GridToParticle
    const bool isCleared = isGiven || fields.front().straining == Straining::noMomentum; // by GridSolver
    for (auto& field : fields)
        if (!isCleared) field.straining = Straining::noMomentum;
    if (!isCleared) scene.state.mirrors.fold(scene.grid, gravityOf(scene));
    parallel(scene.threads, [&](ParallelRegion& region) {
        for (auto& field : fields)
            if (!isCleared) clearMomentum(region, scene, field);
        for (auto& body : scene.bodies)
            if (!isGiven)
                body->domains->move(region, nullptr, fields[body->velocityField].momenta(),
                                    {scene.dt, 1, 0, body->inertiaScale});
        region.once([&] {
            foldMomenta(scene);
            scene.state.parted.bondMomenta(scene);
        });
        for (auto& field : fields) momentumToVelocity(region, scene, field);
    });
    for (auto& field : fields) field.straining = Straining::velocity;
    scene.template forRoles<VelocityCoupling>([&](VelocityCoupling& coupling) { coupling.couple(scene); });
    if (auto* implicit = scene.template role<ImplicitMotion<Dim>>()) implicit->strainNeighbours(scene);
    scene.state.parted.tellVelocity(scene);
    for (size_t f = 0; f < fields.size(); ++f) reflectVelocity(scene, int(f));
}

MPM_REGISTER(Engine, VelocityRemap);

} // namespace mpm
