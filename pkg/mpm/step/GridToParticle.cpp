// SPDX-License-Identifier: GPL-2.0-or-later
// Step 4: the particles take the motion of the nodes; under MUSL the new momentum is mapped back at once.
#include "mpm/scene/Engine.hpp"
#include "mpm/step/nodes.hpp"

namespace mpm {

class GridToParticle : public EngineOf<GridToParticle> {
  public:
    double flip = 1;

    std::string className() const override { return "GridToParticle"; }
    std::string doc() const override {
        return "Moves the particles with the nodes, and under MUSL maps their new momentum back to the nodes.\n\n"
               "v_p <- flip (v_p + dt sum phi a_i) + (1 - flip) sum phi v_i,  x_p <- x_p + dt sum phi v_i;\n"
               "MUSL: v_i <- sum phi m_p v_p / m_i with the weights of the step's start (Sulsky et al. 1995).";
    }
    std::vector<Parameter> attributes() override {
        return {{"flip", "-", "Blend: 1 is FLIP, 0 is PIC.", &flip, Range::between(0, 1)}};
    }

    template <int Dim> void act(Scene<Dim>& scene) {
        const bool remaps = scene.scheme == Scheme::MUSL;
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& body : scene.bodies) {
                auto& field = scene.grid.fields[body->velocityField];
                const Move how{scene.dt, flip, body->isDamped ? scene.damping : 0, body->inertiaScale};
                body->domains->move(region, field.motion.data(), remaps ? field.velocity.data() : nullptr,
                                    how);
            }
            if (remaps) velocityFromMomentum(region, scene, scene.time + scene.dt);
            if (scene.scheme == Scheme::USF)
                for (auto& body : scene.bodies) body->domains->advance(region, scene.dt);
        });
        if (remaps)
            for (auto& engine : scene.engines)
                if (!engine->dead) engine->remapped(scene);
        for (auto& body : scene.bodies) scene.energies.damping += body->domains->dampedEnergy();
    }
};

MPM_REGISTER(Engine, GridToParticle);

} // namespace mpm
