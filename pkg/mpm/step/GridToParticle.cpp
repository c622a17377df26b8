// SPDX-License-Identifier: GPL-2.0-or-later
// Step 4: the particles take the motion of the nodes.
//
// Where VelocityRemap comes next the particles give their new momentum back in the same loop, batch by batch:
// the weights serve twice. A loop of its own took 11 % more time per step with uGIMP and 3 % more with APDI
// (2D, Mohr-Coulomb, 20000 particles, one thread), and gave the same bits.
#include "mpm/step/BesideWalls.hpp"
#include "mpm/step/Conversion.hpp"
#include "mpm/step/nodes.hpp"

namespace mpm {

class GridToParticle : public EngineOf<GridToParticle>, public MovingParticles {
  public:
    double flip = 1;

    std::string className() const override { return "GridToParticle"; }
    std::string doc() const override {
        return "Moves the particles with the nodes.\n\n"
               "v_p <- flip (v_p + dt sum phi a_i) + (1 - flip) sum phi v_i,  x_p <- x_p + dt sum phi v_i.\n"
               "Under MUSL their new momentum is mapped back to the nodes at once: VelocityRemap.";
    }
    std::vector<Parameter> attributes() override {
        return {{"flip", "-", "Blend: 1 is FLIP, 0 is PIC.", &flip, Range::between(0, 1)}};
    }
    double keptVelocity() const override { return flip; }
    template <int Dim> void act(Scene<Dim>& scene);
};

namespace {

// What rollers do where particles reach ghost nodes: the momentum that these lack, for what they are given counts twice,
// at the node and mirrored.
template <int Dim> void reactMirrored(Scene<Dim>& scene, double flip) {
    using NF = NodalField<Dim>;
    for (const auto& image : scene.state.mirrors.images()) {
        const auto& motion = scene.grid.fields[image.field].motion[image.ghost];
        const double m = image.sum[NF::mass];
        const Vec<Dim> given = NF::forceOf(image.sum), x = scene.grid.nodePosition(image.ghost),
                       weight = image.sum[NF::weightMass] * gravityOf(scene);
        for (int k = 0; k < Dim; ++k) {
            const int c = scene.state.mirrors.rollerOf(scene.grid, image, k);
            if (c < 0) continue;
            const double v = motion[NF::velocity + k], a = motion[NF::acceleration + k];
            const double taken = flip * m * a + (1 - flip) * (m * v - image.sum[NF::momentum + k]) / scene.dt;
            Constraint& roller = *scene.constraints[c];
            addReaction<Dim>(x, roller.centre, k, 2 * (taken - given[k] - weight[k]), roller.reaction,
                             roller.moment);
            scene.energies.gravity += 2 * weight[k] * (v - 0.5 * scene.dt * a) * scene.dt;
        }
    }
}

// The images behind rollers move as the nodes before them.
template <int Dim> void reflectMotion(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    for (int f = 0; f < int(scene.grid.fields.size()); ++f) {
        auto& field = scene.grid.fields[f];
        for (int first : {int(NF::velocity), int(NF::acceleration)})
            scene.state.mirrors.reflectValues(
                f, [&](int node, int k) { return field.motion[node][first + k]; },
                [&](int ghost, int k, double value) { field.motion[ghost].set(first + k, value); });
        if (field.straining == NF::Straining::velocity) reflectVelocity(scene, f);
    }
}

} // namespace

template <int Dim> void GridToParticle::act(Scene<Dim>& scene) {
    using Straining = typename NodalField<Dim>::Straining;
    scene.state.parted.tellMotion(scene);
    if (scene.grid.fields.front().straining == Straining::velocity) scene.state.parted.tellVelocity(scene);
    reflectMotion(scene);
    reactMirrored(scene, flip);
    BesideWalls<Dim>(scene).brake(flip);
    auto& fields = scene.grid.fields;
    const bool givesMomentum =
        fields.front().straining == Straining::noMomentum && scene.template nextRole<TakingMomenta>(*this);
    const double damping = dampingOf(scene);
    parallel(scene.threads, [&](ParallelRegion& region) {
        for (auto& body : scene.bodies) {
            auto& field = fields[body->velocityField];
            // Particles that are damped move otherwise than the solution strains them.
            const bool isDamped = body->isDamped && !isSolvedImplicitly(scene, *body);
            const Move how{scene.dt, flip, isDamped ? damping : 0, body->inertiaScale};
            body->domains->move(region, field.motion.data(), givesMomentum ? field.momenta() : nullptr, how);
        }
    });
    for (auto& field : fields)
        if (givesMomentum) field.straining = Straining::momentum;
    for (auto& body : scene.bodies) {
        const MovedEnergy energy = body->domains->movedEnergy();
        scene.energies.damping += energy.damped;
        scene.energies.gravity += energy.byBodyForce;
    }
    if (scene.scheme->stressFirst) convertDistorted(scene);
}

template void GridToParticle::act(Scene<2>&);
template void GridToParticle::act(Scene<3>&);

MPM_REGISTER(Engine, GridToParticle);

} // namespace mpm
