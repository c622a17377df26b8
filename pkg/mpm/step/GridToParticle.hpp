// SPDX-License-Identifier: GPL-2.0-or-later
// Step 4: the particles take the motion of the nodes.
#pragma once

#include "mpm/particle/AffineVelocity.hpp"
#include "mpm/scene/Scene.hpp"

namespace mpm {

class GridToParticle : public EngineOf<GridToParticle> {
  public:
    double flip = 1;
    std::string transfer = "flip";

    std::string className() const override { return "GridToParticle"; }
    std::string doc() const override {
        return "Moves the particles with the nodes.\n\n"
               "v_p <- flip (v_p + dt sum phi a_i) + (1 - flip) sum phi v_i,  x_p <- x_p + dt sum phi v_i.\n"
               "Under MUSL their new momentum is mapped back to the nodes at once: VelocityRemap.\n"
               "With transfer='affine' what spins keeps its angular momentum.";
    }
    std::vector<Parameter> attributes() override {
        return {{"flip", "-", "Blend: 1 is FLIP, 0 is PIC.", &flip, Range::between(0, 1)},
                {"transfer",
                 "-",
                 "What particles give of their velocity to the nodes: 'flip', that of their centre, or "
                 "'affine', the linear velocity v + L (x - x_p) with their velocity gradient L, which keeps "
                 "angular momentum.",
                 &transfer,
                 {},
                 {"flip", "affine"}}};
    }
    void prepare(Scene<2>& scene) override { setTransfer(scene); }
    void prepare(Scene<3>& scene) override { setTransfer(scene); }

    template <int Dim> void act(Scene<Dim>& scene);

  private:
    template <int Dim> void setTransfer(Scene<Dim>& scene) const {
        const bool asked = !dead && transfer == "affine";
        require(
            !asked || !scene.scheme->stressFirst,
            "GridToParticle: transfer = \"affine\" is not possible under ", scene.scheme->name,
            ", which is first order in time: what spins gains angular momentum; give scheme='MUSL' or 'USL', "
            "or transfer=\"flip\"");
        for (auto& body : scene.bodies) {
            auto* affine = dynamic_cast<AffineVelocity*>(body->domains.get());
            require(affine || !asked, "GridToParticle: transfer = \"affine\" is not possible for ",
                    body->type->className(), " of '", body->name,
                    "', which has no linear velocities; give transfer=\"flip\", or that body another type");
            if (affine) affine->isAffine = asked;
        }
    }
};

// How much of their own velocity the particles of a scene keep: 1 is FLIP; 1 where nothing moves them.
template <int Dim> double flipOf(const Scene<Dim>& scene) {
    const auto* mover = scene.template find<GridToParticle>();
    return mover ? mover->flip : 1;
}

// Whether the velocities of its particles are linear in their domains.
template <int Dim> bool movesAffinely(const Scene<Dim>& scene) {
    const auto* mover = scene.template find<GridToParticle>();
    return mover && mover->transfer == "affine";
}

} // namespace mpm
