// SPDX-License-Identifier: GPL-2.0-or-later
// Water slows a body down. The water itself is not moved.
#include "mpm/base/parallel/OrderedSum.hpp"
#include "mpm/base/parallel/ParallelRegion.hpp"
#include "mpm/scene/Scene.hpp"

#include <cmath>

namespace mpm {

class Drag : public EngineOf<Drag> {
  public:
    std::string body;
    double rate = 0;

    std::string className() const override { return "Drag"; }
    std::string doc() const override {
        return "Drag of a fluid at rest on a body: v <- v exp(-rate dt).\n\n"
               "Stands behind DomainUpdater. The energy that it takes counts as damped.";
    }
    std::vector<Parameter> attributes() override {
        return {
            {"body", "", "Name of the body.", &body},
            {"rate", "1/s", "Part of the velocity that is lost in a second.", &rate, Range::notNegative()}};
    }

    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        Body<Dim>& slowed = *scene.body(body);
        Particles<Dim>& particles = slowed.particles;
        const int count = particles.size();
        const double factor = std::exp(-rate * scene.dt);
        const double* mass = particles.mass.plane();
        energy_.clear(count);
        parallel(scene.threads, [&](ParallelRegion& region) {
            region.chunks(count, [&](int begin, int end) {
                double lost = 0;
                for (int k = 0; k < Dim; ++k) {
                    double* v = particles.velocity.plane(k);
                    for (int p = begin; p < end; ++p) {
                        lost += mass[p] * v[p] * v[p];
                        v[p] *= factor;
                    }
                }
                energy_.of(begin) = lost;
            });
        });
        const double inertia = slowed.inertiaScale;
        scene.energies.damping += 0.5 * inertia * (1 - factor * factor) * energy_.total();
    }

  private:
    OrderedSum energy_; // twice the kinetic energy before, per chunk of particles

    template <int Dim> void check(Scene<Dim>& scene) {
        require(!body.empty(), "Drag: body is required; give the name of a body of the scene");
        scene.body(body); // throws for an unknown one
    }
};

MPM_REGISTER(Engine, Drag);

} // namespace mpm
