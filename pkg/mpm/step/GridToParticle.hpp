// SPDX-License-Identifier: GPL-2.0-or-later
// Step 4: the particles take the motion of the nodes.
#pragma once

#include "mpm/scene/Scene.hpp"

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
    template <int Dim> void act(Scene<Dim>& scene);
};

// How much of their own velocity the particles of a scene keep: 1 is FLIP; 1 where nothing moves them.
template <int Dim> double flipOf(const Scene<Dim>& scene) {
    const auto* mover = scene.template find<GridToParticle>();
    return mover ? mover->flip : 1;
}

} // namespace mpm
