// SPDX-License-Identifier: GPL-2.0-or-later
// Ground that repeats itself along an axis and has no end there: an infinite slope, a chute, a layer that is sheared, a
// model whose sides are tied.
#include "mpm/scene/Scene.hpp"

namespace mpm {

class UniformAlong : public EngineOf<UniformAlong>, public JoiningNodes, public VelocityCoupling {
  public:
    std::string axis = "x";
    int period = 1;

    std::string className() const override { return "UniformAlong"; }
    std::string doc() const override {
        return "Makes the scene alike along an axis: all nodes of a row along it move as one.\n\n"
               "For an infinite slope, a chute or a layer that is sheared, with a piece of the ground that is whole\n"
               "cells long. Momentum, mass and force are summed along each row, so stress at the ends of the piece\n"
               "pushes nothing. The piece itself moves on: leave room in the grid, or put position[:, axis] back in\n"
               "every step. With a period nodes that far apart move as one: what leaves at one side is felt at the\n"
               "other (`scene.tie`).";
    }
    std::vector<Parameter> attributes() override {
        return {{"axis", "", "Axis along which the scene is alike: x, y or z.", &axis, {}, {"x", "y", "z"}},
                {"period", "cells", "Length after which the scene repeats itself.", &period, Range{1}}};
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }
    void join(Scene<2>& scene) override { joinSums(scene); }
    void join(Scene<3>& scene) override { joinSums(scene); }
    void couple(Scene<2>& scene) override { joinVelocities(scene); }
    void couple(Scene<3>& scene) override { joinVelocities(scene); }

    // GridSolver calls join() once all forces are on the nodes.
    template <int Dim> void act(Scene<Dim>&) {}

  private:
    std::vector<double> rows_; // sums, at the first node of each row

    template <int Dim> void joinSums(Scene<Dim>& scene) {
        using NF = NodalField<Dim>;
        for (auto& field : scene.grid.fields)
            joinRows<8>(
                scene, field,
                [&](int node, double* row) {
                    for (int lane = 0; lane < 8; ++lane) row[lane] += field.sum[node][lane];
                },
                [&](int node, const double* row) {
                    auto& sum = field.sum[node];
                    const double part = row[NF::mass] > 0 ? sum[NF::mass] / row[NF::mass] : 0;
                    for (int lane = 0; lane < 8; ++lane) sum.set(lane, part * row[lane]);
                });
    }
    // Of the velocities that strain the particles.
    template <int Dim> void joinVelocities(Scene<Dim>& scene) {
        for (auto& field : scene.grid.fields)
            joinRows<Dim + 1>(
                scene, field,
                [&](int node, double* row) {
                    const double m = field.sum[node][NodalField<Dim>::mass];
                    for (int k = 0; k < Dim; ++k) row[k] += m * field.velocityOf(node, k);
                    row[Dim] += m;
                },
                [&](int node, const double* row) {
                    for (int k = 0; k < Dim && row[Dim] > 0; ++k)
                        field.setVelocity(node, k, row[k] / row[Dim]);
                });
    }

    // add(node, numbers of its row) for all nodes that are not alone in theirs, then take(node, the same).
    template <int size, int Dim, class Add, class Take>
    void joinRows(const Scene<Dim>& scene, const NodalField<Dim>& field, Add&& add, Take&& take) {
        const auto& grid = scene.grid;
        const int k = axis[0] - 'x', last = grid.nodes[k] - 1;
        const auto forRows = [&](auto&& f) {
            for (int slab = 0; slab < grid.slabs(); ++slab)
                grid.forNodes(field, slab, [&](int node) {
                    const int i = grid.indices(node)[k];
                    if (i >= period || i + period <= last)
                        f(node, &rows_[size_t(size) * (node - grid.strides[k] * (i - i % period))]);
                });
        };
        rows_.resize(size_t(8) * grid.count);
        forRows([&](int, double* row) { std::fill_n(row, size, 0.0); });
        forRows(add);
        forRows(take);
    }

    template <int Dim> void check(const Scene<Dim>&) {
        require(axis[0] - 'x' < Dim, "UniformAlong: axis = ", axis, " of a plane scene; give x or y");
    }
};

MPM_REGISTER(Engine, UniformAlong);

} // namespace mpm
