// SPDX-License-Identifier: GPL-2.0-or-later
// Rates of volume change by cells, and the forces of their mean stress, its transpose: both see the same nodes,
// also where corners of cells have no mass.
#include "mpm/scene/Scene.hpp"

#include <gtest/gtest.h>

namespace mpm {

namespace {

// A mesh whose left edge is inclined in the corner of the grid, with boxes bonded to its top.
class LeaningMesh : public testing::Test {
  protected:
    static constexpr double pressure = 50; // kPa, in the mean
    Scene<2> scene{Vec<2>(0, 0), Vec<2>(4, 3), Vec<2>(0.5, 0.5)};

    void SetUp() override {
        const auto clay = Registry<Material>::make("MohrCoulombDruckerPrager");
        clay->set("density", 1.6);
        clay->set("lame", std::vector<double>{1e4, 8e3});
        clay->set("cohesion", 500.0);
        clay->set("frictionAngle", 0.0);
        clay->set("frictionAngle", 0.0);
        clay->finish();
        const auto add = [&](const std::string& type, const Geometry<2>& geometry) {
            scene.bodies.push_back(
                std::make_unique<Body<2>>(type, clay, Registry<ParticleType>::make(type), scene.grid));
            scene.bodies.back()->fbar = true;
            scene.bodies.back()->build(geometry);
        };
        add("APDI", mesh());
        Geometry<2> boxes;
        boxes.halfSize.setConstant(0.125);
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 16; ++i) boxes.positions.emplace_back(0.25 * i + 0.125, 0.25 * j + 1.125);
        add("UGIMP", boxes);
        scene.scheme = Registry<Scheme>::make("USL");
        for (auto* name : {"ParticleToGrid", "GridSolver", "DomainUpdater"})
            scene.engines.push_back(Registry<Engine>::make(name));
        scene.dt = 1e-9;
        scene.prepare();
    }
    static Geometry<2> mesh() {
        const double left[] = {.55, .51, .25, .05, 0}, y[] = {0, .25, .51, .75, 1};
        Geometry<2> g;
        for (int j = 0; j < 5; ++j)
            for (int i = 0; i < 9; ++i) g.points.emplace_back(left[j] + (4 - left[j]) * i / 8, y[j]);
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 8; ++i)
                for (int corner : {0, 1, 10, 9}) g.cells.push_back(9 * j + i + corner);
        return g;
    }
    template <class F> void forParticles(F&& f) {
        for (auto& body : scene.bodies)
            for (int p = 0; p < body->particles.size(); ++p) f(*body, p);
    }
    // f(node) for those with mass; the others are told of by the number of them with force.
    template <class F> int forMassive(F&& f) {
        int massless = 0;
        const auto& field = scene.grid.fields.front();
        for (int slab = 0; slab < scene.grid.slabs(); ++slab)
            scene.grid.forNodes(field, slab, [&](int node) {
                const bool hasMass = field.sum[node][NodalField<2>::mass] > scene.leastMass();
                if (hasMass) f(node);
                massless += !hasMass;
            });
        return massless;
    }
};

TEST_F(LeaningMesh, forcesOnNodesWithMassAddUpToNothing) {
    forParticles([&](Body<2>& body, int p) {
        const double p_c = pressure * (1 + 0.1 * body.particles.position.plane(0)[p]);
        const double stress[9] = {-p_c, 0, 0, 0, -p_c, 0, 0, 0, -p_c};
        body.setStress(p, stress);
    });
    scene.actAlone(*scene.engines[0]);
    Vec<2> sum = Vec<2>::Zero();
    double size = 0;
    const int massless = forMassive([&](int node) {
        const Vec<2> force = NodalField<2>::forceOf(scene.grid.fields.front().sum[node]);
        sum += force;
        size += force.norm();
    });
    EXPECT_GT(massless, 0);
    EXPECT_LT(sum.norm(), 1e-13 * size);
}

TEST_F(LeaningMesh, uniformMotionChangesNoVolume) {
    forParticles([](Body<2>& body, int p) {
        body.particles.velocity.plane(0)[p] = 2;
        body.particles.velocity.plane(1)[p] = 1;
    });
    for (auto& engine : scene.engines) scene.actAlone(*engine);
    forParticles([&](Body<2>& body, int p) {
        const double rate = body.particles.stress.plane(0)[p] / (1e4 * scene.dt);
        EXPECT_LT(std::abs(rate), 1e-6) << body.name << " " << p; // 1/s
    });
}

} // namespace

} // namespace mpm
