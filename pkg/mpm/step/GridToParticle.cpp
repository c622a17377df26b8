// SPDX-License-Identifier: GPL-2.0-or-later
// Step 4: the particles take the motion of the nodes. Where VelocityRemap comes next they give their new
// momentum back in the same loop, batch by batch: the weights serve twice. A loop of its own took 11 % more
// time per step with uGIMP and 3 % more with APDI (2D, Mohr-Coulomb, 20000 particles, one thread), and gave
// the same bits.
#include "mpm/step/GridSolver.hpp"
#include "mpm/step/VelocityRemap.hpp"
#include "mpm/step/nodes.hpp"

namespace mpm {

class GridToParticle : public EngineOf<GridToParticle> {
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

    template <int Dim> void act(Scene<Dim>& scene) {
        using Straining = typename NodalField<Dim>::Straining;
        auto& fields = scene.grid.fields;
        const bool givesMomentum = fields.front().straining == Straining::noMomentum &&
                                   scene.template isFollowedBy<VelocityRemap>(*this);
        const double damping = dampingOf(scene);
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& body : scene.bodies) {
                auto& field = fields[body->velocityField];
                const Move how{scene.dt, flip, body->isDamped ? damping : 0, body->inertiaScale};
                body->domains->move(region, field.motion.data(), givesMomentum ? field.momenta() : nullptr,
                                    how);
            }
            if (scene.scheme->stressFirst)
                for (auto& body : scene.bodies)
                    if (auto* mesh = body->domains->mesh()) mesh->advance(region, scene.dt);
        });
        for (auto& field : fields)
            if (givesMomentum) field.straining = Straining::momentum;
        for (auto& body : scene.bodies) scene.energies.damping += body->domains->dampedEnergy();
    }
};

MPM_REGISTER(Engine, GridToParticle);

} // namespace mpm
