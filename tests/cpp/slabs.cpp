// SPDX-License-Identifier: GPL-2.0-or-later
// A body that is cut in two slabs, each with a grid of its own, as processes with memories of their own would have
// them: what they must exchange after ParticleToGrid is a sum over the rows of nodes that both reach.
#include "mpm/scene/Scene.hpp"

#include <gtest/gtest.h>

namespace mpm {

namespace {

constexpr double h = 0.5, cut = 2.0; // m: cell; height of the cut, on a line of nodes
constexpr int wide = 8, high = 12;   // particles

// The rows [first, last) of particles of a block, alone on the grid of the whole, after ParticleToGrid.
class Slab {
  public:
    Slab(const std::string& type, int first, int last) {
        const auto soil = Registry<Material>::make("LinearElastic");
        soil->set("density", 1.6);
        soil->set("lame", std::vector<double>{1e4, 8e3});
        soil->finish();
        scene.bodies.push_back(
            std::make_unique<Body<2>>(type, soil, Registry<ParticleType>::make(type), scene.grid));
        Body<2>& body = *scene.bodies.back();
        body.build(type == "APDI" ? mesh(first, last) : boxes(first, last));
        for (int p = 0; p < body.particles.size(); ++p) start(body, p);
        for (auto* name :
             {"ParticleToGrid", "GridSolver", "GridToParticle", "VelocityRemap", "DomainUpdater"})
            scene.engines.push_back(Registry<Engine>::make(name));
        scene.dt = 1e-9;
        scene.prepare();
        scene.actAlone(*scene.engines.front());
    }
    // Momentum, mass and force of a node.
    std::array<double, 5> sums(int node) const {
        const auto& sum = scene.grid.fields.front().sum[node];
        const Vec<2> force = NodalField<2>::forceOf(sum);
        return {sum[0], sum[1], sum[NodalField<2>::mass], force[0], force[1]};
    }
    Scene<2> scene{Vec<2>(0, 0), Vec<2>(3, 4), Vec<2>(h, h)};

  private:
    static double place(int i) { return 0.25 * i + 0.5; }
    static Geometry<2> boxes(int first, int last) {
        Geometry<2> g;
        g.halfSize.setConstant(0.125);
        for (int j = first; j < last; ++j)
            for (int i = 0; i < wide; ++i) g.positions.emplace_back(place(i) + 0.125, place(j) + 0.125);
        return g;
    }
    static Geometry<2> mesh(int first, int last) {
        Geometry<2> g;
        for (int j = first; j <= last; ++j)
            for (int i = 0; i <= wide; ++i) g.points.emplace_back(place(i), place(j));
        for (int j = 0; j < last - first; ++j)
            for (int i = 0; i < wide; ++i)
                for (int corner : {0, 1, wide + 2, wide + 1}) g.cells.push_back((wide + 1) * j + i + corner);
        return g;
    }
    static void start(Body<2>& body, int p) {
        const Vec<2> x = vectorAt<2>(body.particles.position, p);
        const double shear = 7 * x[0] * x[1];
        const double stress[9] = {-50 - x[1], shear, 0, shear, -20 + x[0], 0, 0, 0, -30};
        body.setStress(p, stress);
        body.particles.velocity.plane(0)[p] = std::sin(3 * x[1]);
        body.particles.velocity.plane(1)[p] = std::cos(2 * x[0]);
    }
};

class SlabsOf : public testing::TestWithParam<const char*> {};

TEST_P(SlabsOf, addUpToTheWholeAndShareOneRowOnEachSideOfTheCut) {
    const int rows = int(std::lround((cut - 0.5) / 0.25));
    const Slab whole(GetParam(), 0, high), lower(GetParam(), 0, rows), upper(GetParam(), rows, high);
    const auto& grid = whole.scene.grid;
    int shared = 0;
    for (int node = 0; node < grid.count; ++node) {
        const auto all = whole.sums(node), below = lower.sums(node), above = upper.sums(node);
        for (int k = 0; k < 5; ++k) EXPECT_NEAR(below[k] + above[k], all[k], 1e-12) << "node " << node;
        if (below[2] == 0 || above[2] == 0) continue;
        ++shared;
        const double fromCut = (grid.indices(node)[1] - grid.ghost) * h - cut; // m
        EXPECT_LE(std::abs(fromCut), h + 1e-12) << "node " << node;
    }
    EXPECT_GT(shared, wide / 2);
}

INSTANTIATE_TEST_SUITE_P(Types, SlabsOf, testing::Values("UGIMP", "APDI"));

} // namespace

} // namespace mpm
