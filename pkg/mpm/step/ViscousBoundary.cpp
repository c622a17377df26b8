// SPDX-License-Identifier: GPL-2.0-or-later
// A face of the grid behind which the ground goes on: waves leave through it, and a motion may come in.
#include "mpm/step/NodalForces.hpp"
#include "mpm/step/timeTable.hpp"

#include <map>
#include <tuple>

namespace mpm {

class ViscousBoundary : public EngineOf<ViscousBoundary>, public JoiningNodes, public VelocityCoupling {
  public:
    int face = 0;
    double density = notGiven, normal = notGiven, shear = notGiven, work = 0;
    std::vector<double> motion, column, dashpots, held;

    std::string className() const override { return "ViscousBoundary"; }
    std::string doc() const override {
        return "A face of the grid behind which the ground goes on: dashpots let waves out, and a motion in.\n\n"
               "traction = -impedance (v - 2 v_in), for pressure waves across the face and shear waves along it, v at "
               "the end\n"
               "of the step (Lysmer & Kuhlemeyer 1969; Joyner & Chen 1975). What the face bears when the engine begins "
               "stays.\n"
               "Beside a free field v_in is half of the velocity of its column, whose forces act on the face, too.";
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
            {"column", "s, m/s, kN",
             "Rows of a free field: the time, and of each row of nodes from below the velocity and the force.",
             &column},
            {"dashpots", "kN s/m", "Of each row of nodes from below beside a free field, along each axis.",
             &dashpots},
            {"held", "kN", "Rows (group, node, components) of what the face bears besides.", &held},
            {"work", "kJ", "Work done on the soil.", &work}};
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    void join(Scene<2>& scene) override { resist(scene); }
    void join(Scene<3>& scene) override { resist(scene); }
    void couple(Scene<2>& scene) override { strain(scene); }
    void couple(Scene<3>& scene) override { strain(scene); }

    // What the face bears. GridSolver calls join() for the dashpots once all forces are on the nodes.
    template <int Dim> void act(Scene<Dim>& scene) {
        using NF = NodalField<Dim>;
        auto& [given, bears, nodes] = std::get<State<Dim>>(states_);
        const bool begins = held.empty();
        given.begin(scene);
        nodes.clear();
        const int line = face % 2 ? scene.grid.ghost + scene.grid.cells[face / 2] : scene.grid.ghost;
        const Vec<Dim> gravity = gravityOf(scene);
        const std::vector<double> free = freeField(scene.time, scene.dt);
        for (int f = 0; f < int(scene.grid.fields.size()); ++f) {
            const auto& field = scene.grid.fields[f];
            forFace(scene, field, face / 2, line, [&](int node) {
                const auto& sum = field.sum[node];
                const int row = Dim * (scene.grid.indices(node)[Dim - 1] - scene.grid.ghost);
                const bool isGhost = row < 0 || row + Dim > int(dashpots.size());
                if (!(sum[NF::mass] > scene.leastMass()) || (!free.empty() && isGhost)) return;
                if (begins) bears[{f, node}] = -(NF::forceOf(sum) + sum[NF::weightMass] * gravity);
                const auto kept = bears.find({f, node});
                Vec<Dim> force = kept == bears.end() ? Vec<Dim>::Zero() : kept->second;
                if (!free.empty()) force += vectorOf<Dim>(free, 2 * row + Dim);
                given.add(f, node, force);
                nodes.push_back({f, node, row, Vec<Dim>::Zero()});
            });
        }
        if (begins) keep<Dim>(bears);
    }
    void stepped(double dt) override {
        std::apply([&](auto&... state) { ((work += state.given.finish(dt), state.nodes.clear()), ...); },
                   states_);
    }

  private:
    template <int Dim> struct Place {
        int field, node, row; // of a free field
        Vec<Dim> stiffness;   // dashpots times dt over the mass
    };
    template <int Dim> struct State {
        NodalForces<Dim> given;
        std::map<std::pair<int, int>, Vec<Dim>> bears; // by group and node
        std::vector<Place<Dim>> nodes;
    };
    std::tuple<State<2>, State<3>> states_;

    template <int Dim> void check(Scene<Dim>&) {
        if (dead) return;
        require(face >= 0 && face < 2 * Dim && !std::isnan(density + normal + shear),
                "ViscousBoundary: made by scene.viscous(side)");
        checkTable("ViscousBoundary", "motion", motion, 1 + Dim);
        checkTable("ViscousBoundary", "column", column, 1 + 2 * dashpots.size());
        auto& bears = std::get<State<Dim>>(states_).bears;
        bears.clear();
        for (size_t i = 0; i + 1 + Dim < held.size(); i += 2 + Dim)
            bears[{int(held[i]), int(held[i + 1])}] = vectorOf<Dim>(held, i + 2);
    }
    // The velocity is that at the end of the step, so stiff dashpots are stable.
    template <int Dim> void resist(Scene<Dim>& scene) {
        using NF = NodalField<Dim>;
        auto& state = std::get<State<Dim>>(states_);
        const int axis = face / 2,
                  cell = face % 2 ? scene.grid.ghost + scene.grid.cells[axis] - 1 : scene.grid.ghost;
        const double half = 0.5 * scene.grid.cellSize(axis, cell), time = scene.time + scene.dt;
        const std::vector<double> in =
            motion.empty() ? std::vector<double>(Dim, 0.0) : rowAt(motion, 1 + Dim, time);
        const std::vector<double> free = freeField(time, scene.dt);
        const Vec<Dim> gravity = gravityOf(scene);
        for (auto& [f, node, row, stiffness] : state.nodes) {
            const auto& sum = scene.grid.fields[f].sum[node];
            const Vec<Dim> driving = NF::forceOf(sum) + sum[NF::weightMass] * gravity;
            Vec<Dim> force;
            for (int k = 0; k < Dim; ++k) {
                const double impedance =
                    (k == axis ? normal : shear) * sum[NF::weightMass] / (density * half);
                const double dashpot = free.empty() ? impedance : dashpots[row + k]; // kN s/m
                const double outside = free.empty() ? 2 * in[k] : free[2 * row + k];
                stiffness[k] = dashpot * scene.dt / sum[NF::mass];
                const double own = NF::velocityAtStart(sum, k) + scene.dt * driving[k] / sum[NF::mass];
                force[k] = -dashpot * (own - outside) / (1 + stiffness[k]);
            }
            state.given.add(f, node, force);
        }
    }
    // Stiff dashpots hold the nodes, so what strains the soil there is the velocity that they leave.
    template <int Dim> void strain(Scene<Dim>& scene) {
        for (const auto& [f, node, row, stiffness] : std::get<State<Dim>>(states_).nodes) {
            auto& field = scene.grid.fields[f];
            for (int k = 0; k < Dim; ++k)
                field.setVelocity(node, k,
                                  (field.velocityOf(node, k) + stiffness[k] * field.motion[node][k]) /
                                      (1 + stiffness[k]));
        }
    }
    // Velocities and forces of the free field at a time, empty without one.
    std::vector<double> freeField(double time, double step) const {
        const size_t width = 1 + 2 * dashpots.size();
        if (column.empty()) return {};
        require(time <= step + column[column.size() - width], label, ": the free field ends at ",
                column[column.size() - width], " s; give scene.freeField(..., until=...) a later end");
        return rowAt(column, width, time);
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
