// SPDX-License-Identifier: GPL-2.0-or-later
// Step 1 and 2: where the particles are, and their mass, momentum and forces on the nodes.
#include "mpm/scene/Scene.hpp"
#include "mpm/step/Driving.hpp"
#include "mpm/step/EvenCover.hpp"
#include "mpm/step/nodes.hpp"
#include "mpm/step/pressedBoxes.hpp"

namespace mpm {

class ParticleToGrid : public EngineOf<ParticleToGrid> {
  public:
    std::string className() const override { return "ParticleToGrid"; }
    std::string doc() const override {
        return "Finds the particles in the grid and sums their mass, momentum and forces on the nodes.\n\n"
               "m_i = sum phi m_p,  p_i = sum phi m_p v_p,  f_i = - sum V_p sigma_p grad phi + sum "
               "phi m_p b_p.\n"
               "Before that, uGIMP particles that are too long are cut in two (UGIMP: splitAt). "
               "Raises RuntimeError when a particle or vertex is outside the grid.";
    }

    template <int Dim> void act(Scene<Dim>& scene) {
        for (auto& body : scene.bodies)
            if (auto* boxes = body->domains->boxes(); boxes && boxes->splitStretched()) body->massesChanged();
        even_.act(scene);
        const bool arePressed = scene.template role<PressingOnBoxes>();
        if (!arePressed) scene.state.pressed.parts.clear();
        const bool withForce = !scene.scheme->stressFirst;
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& body : scene.bodies) refuseNoMatter(region, *body, scene.step);
            locateParticles(region, scene, true);
            if (region.failed()) return;
            locateCells(region, scene);
            if (arePressed) region.once([&] { findBoxParts(scene); });
            sumOnNodes(region, scene, withForce ? &cells_ : nullptr, scene.state.sharedCells->isWanted);
            if (arePressed && withForce) region.once([&] { addBoxParts(scene); });
        });
        for (auto& field : scene.grid.fields) field.straining = NodalField<Dim>::Straining::nothing;
        holdDrivenNodes(scene, drivenMass_);
    }

  private:
    // A callback may have written what no matter has, and the next stress update would hide it.
    template <int Dim> static void refuseNoMatter(ParallelRegion& region, Body<Dim>& body, long step) {
        const double *mass = body.particles.mass.plane(), *volume = body.particles.volume.plane();
        region.chunksNoWait(body.particles.size(), [&](int begin, int end) {
            int64_t right = 0; // as wide as the numbers: in vectors
            for (int p = begin; p < end; ++p) right += (mass[p] > 0) & (volume[p] > 0);
            if (right == end - begin) return;
            const auto isWrong = [&](int p) { return !(mass[p] > 0 && volume[p] > 0); };
            int p = begin;
            while (!isWrong(p)) ++p;
            const bool isMass = !(mass[p] > 0);
            throw RunError(
                message("step ", step, ": body '", body.name, "': ", isMass ? "mass" : "volume", " = ",
                        isMass ? mass[p] : volume[p], " of entry ", p,
                        " is not positive. Either something has written it, or the particle was "
                        "turned inside out: then look at the last frames, and lower dt (F-bar, closing "
                        "and splitAt keep soil whole that flows far)"));
        });
    }

    std::vector<double> drivenMass_;
    std::vector<CellForces> cells_; // of each body
    EvenCover even_;
};

MPM_REGISTER(Engine, ParticleToGrid);

} // namespace mpm
