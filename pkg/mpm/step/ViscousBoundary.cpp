// SPDX-License-Identifier: GPL-2.0-or-later
// A face of the grid behind which the ground goes on: waves leave through it, and a motion may come in.
#include "mpm/step/GridSolver.hpp"
#include "mpm/step/NodalForces.hpp"
#include "mpm/step/timeTable.hpp"

#include <map>
#include <tuple>

namespace mpm {

class ViscousBoundary : public EngineOf<ViscousBoundary> {
  public:
    int face = 0;
    double density = notGiven, normal = notGiven, shear = notGiven, work = 0;
    std::vector<double> motion, held;

    std::string className() const override { return "ViscousBoundary"; }
    std::string doc() const override {
        return "A face of the grid behind which the ground goes on: dashpots let waves out, and a motion in.\n\n"
               "traction = -impedance (v - 2 v_in), for pressure waves across the face and shear waves along it, v at "
               "the end\n"
               "of the step (Lysmer & Kuhlemeyer 1969; Joyner & Chen 1975). What the face bears when the engine begins "
               "stays.";
    }
    std::vector<Parameter> attributes() override {
        return {
            {"face", "", "Number of the face: twice the axis, and one for the upper of both.", &face},
            {"density", "Mg/m3", "Of the soil, by which the area of a node follows from its mass.", &density,
             Range::positive()},
            {"normal", "kPa s/m", "Impedance across the face: density and speed of pressure waves behind it.",
             &normal, Range::notNegative()},
            {"shear", "kPa s/m", "Impedance along the face: density and speed of shear waves behind it.",
             &shear, Range::notNegative()},
            {"motion", "s, m/s", "Rows (time, one component per axis) of the wave that comes in.", &motion},
            {"held", "kN", "Rows (group, node, components) of what the face bears besides.", &held},
            {"work", "kJ", "Work done on the soil.", &work}};
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        using NF = NodalField<Dim>;
        auto& [given, bears] = std::get<State<Dim>>(states_);
        const bool begins = held.empty();
        given.begin(scene);
        const int axis = face / 2,
                  line = face % 2 ? scene.grid.ghost + scene.grid.cells[axis] : scene.grid.ghost;
        const double half = 0.5 * scene.grid.cellSize(axis, face % 2 ? line - 1 : line);
        const Vec<Dim> gravity = gravityOf(scene);
        std::vector<double> in(Dim, 0.0);
        if (!motion.empty()) in = rowAt(motion, 1 + Dim, scene.time + 0.5 * scene.dt);
        for (int f = 0; f < int(scene.grid.fields.size()); ++f) {
            const auto& field = scene.grid.fields[f];
            forFace(scene, field, axis, line, [&](int node) {
                const auto& sum = field.sum[node];
                const double m = sum[NF::mass];
                if (!(m > scene.leastMass())) return;
                const Vec<Dim> driving = NF::forceOf(sum) + sum[NF::weightMass] * gravity;
                if (begins) bears[{f, node}] = -driving;
                const auto kept = bears.find({f, node});
                const Vec<Dim> still = kept == bears.end() ? Vec<Dim>::Zero() : kept->second;
                Vec<Dim> force;
                for (int k = 0; k < Dim; ++k) {
                    const double dashpot =
                        (k == axis ? normal : shear) * sum[NF::weightMass] / (density * half); // kN s/m
                    const double free =
                        NF::velocityAtStart(sum, k) + 0.5 * scene.dt * (driving[k] + still[k]) / m;
                    force[k] = still[k] - dashpot * (free - 2 * in[k]) / (1 + 0.5 * dashpot * scene.dt / m);
                }
                given.add(f, node, force);
            });
        }
        if (begins) keep<Dim>(bears);
    }
    void stepped(double dt) override {
        std::apply([&](auto&... state) { ((work += state.given.finish(dt)), ...); }, states_);
    }

  private:
    template <int Dim> struct State {
        NodalForces<Dim> given;
        std::map<std::pair<int, int>, Vec<Dim>> bears; // by group and node
    };
    std::tuple<State<2>, State<3>> states_;

    template <int Dim> void check(Scene<Dim>&) {
        if (dead) return;
        require(face >= 0 && face < 2 * Dim && !std::isnan(density + normal + shear),
                "ViscousBoundary: made by scene.viscous(side)");
        checkTable("ViscousBoundary", "motion", motion, 1 + Dim);
        auto& bears = std::get<State<Dim>>(states_).bears;
        bears.clear();
        for (size_t i = 0; i + 1 + Dim < held.size(); i += 2 + Dim)
            bears[{int(held[i]), int(held[i + 1])}] = vectorOf<Dim>(held, i + 2);
    }
    template <int Dim> void keep(const std::map<std::pair<int, int>, Vec<Dim>>& bears) {
        for (const auto& [place, force] : bears) {
            held.insert(held.end(), {double(place.first), double(place.second)});
            for (int k = 0; k < Dim; ++k) held.push_back(force[k]);
        }
    }
    // f(node) for those of a face that particles touch.
    template <int Dim, class F>
    static void forFace(const Scene<Dim>& scene, const NodalField<Dim>& field, int axis, int line, F&& f) {
        for (int slab = 0; slab < scene.grid.slabs(); ++slab)
            scene.grid.forNodes(field, slab, [&](int node) {
                if (scene.grid.indices(node)[axis] == line) f(node);
            });
    }
};

MPM_REGISTER(Engine, ViscousBoundary);

} // namespace mpm
