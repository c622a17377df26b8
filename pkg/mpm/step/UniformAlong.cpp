// SPDX-License-Identifier: GPL-2.0-or-later
// Ground that is alike along an axis and has no end there: an infinite slope, a chute, a layer that is sheared.
#include "mpm/scene/Scene.hpp"

namespace mpm {

class UniformAlong : public EngineOf<UniformAlong> {
  public:
    std::string axis = "x";

    std::string className() const override { return "UniformAlong"; }
    std::string doc() const override {
        return "Makes the scene alike along an axis: all nodes of a row along it move as one.\n\n"
               "Stands between ParticleToGrid and GridSolver, for an infinite slope, a chute or a layer that is\n"
               "sheared, with a piece of the ground that is whole cells long. Momentum, mass and force are summed\n"
               "along each row, so stress at the ends of the piece pushes nothing. The piece itself moves on: leave\n"
               "room in the grid, or put position[:, axis] back in every step.";
    }
    std::vector<Parameter> attributes() override {
        return {{"axis", "", "Axis along which the scene is alike: x, y or z.", &axis, {}, {"x", "y", "z"}}};
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        using NF = NodalField<Dim>;
        const int k = axis[0] - 'x', stride = scene.grid.strides[k];
        std::vector<typename NF::Sum> rows(scene.grid.count, NF::Sum::zero());
        for (auto& field : scene.grid.fields) {
            const auto everyNode = [&](auto&& f) {
                for (int slab = 0; slab < scene.grid.slabs(); ++slab)
                    scene.grid.forNodes(
                        field, slab, [&](int node) { f(node, node - stride * scene.grid.indices(node)[k]); });
            };
            std::fill(rows.begin(), rows.end(), NF::Sum::zero());
            everyNode([&](int node, int row) { rows[row] += field.sum[node]; });
            everyNode([&](int node, int row) {
                const double mass = rows[row][NF::mass];
                if (mass > 0) field.sum[node] = field.sum[node][NF::mass] / mass * rows[row];
            });
        }
    }

  private:
    template <int Dim> void check(const Scene<Dim>&) {
        require(axis[0] - 'x' < Dim, "UniformAlong: axis = ", axis, " of a plane scene; give x or y");
    }
};

MPM_REGISTER(Engine, UniformAlong);

} // namespace mpm
