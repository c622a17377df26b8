// SPDX-License-Identifier: GPL-2.0-or-later
// The velocity that strains the particles, from their own momentum: behind GridToParticle under MUSL, behind
// ParticleToGrid under USF. The scene puts it into the chain.
#pragma once

#include "mpm/scene/Scene.hpp"

namespace mpm {

class VelocityRemap : public EngineOf<VelocityRemap> {
  public:
    std::string className() const override { return "VelocityRemap"; }
    std::string doc() const override;
    template <int Dim> void act(Scene<Dim>& scene);
};

} // namespace mpm
