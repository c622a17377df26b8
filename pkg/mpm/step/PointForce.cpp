// SPDX-License-Identifier: GPL-2.0-or-later
// A force on a point of a body, over time.
#include "mpm/step/NodalForces.hpp"
#include "mpm/step/timeTable.hpp"

#include <tuple>

namespace mpm {

class PointForce : public EngineOf<PointForce> {
  public:
    std::string body;
    std::vector<double> at, table, ids, parts;
    std::vector<double> force, impulse; // that a run finds
    double work = 0;

    std::string className() const override { return "PointForce"; }
    std::string doc() const override {
        return "Force on a point of a body, constant or over time.\n\n"
               "Stands between ParticleToGrid and GridSolver.";
    }
    std::vector<Parameter> attributes() override {
        return {
            {"body", "", "Name of the body.", &body},
            {"at", "m", "Point of the body that it acts on.", &at},
            {"table", "s, kN",
             "Rows (time, one component per axis), linear between them and constant outside (plane strain: kN per "
             "metre; axisymmetric: of the whole circumference).",
             &table},
            {"ids", "", "Particles of the body that it acts on, by id.", &ids},
            {"parts", "-", "Parts of the force that they take.", &parts},
            {"force", "kN", "Force in the last step.", &force},
            {"impulse", "kN s", "Time integral of the force.", &impulse},
            {"work", "kJ", "Work done on the body.", &work}};
    }
    void finish() override {
        require(ids.size() == parts.size(), "PointForce: ids and parts differ in number");
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        auto& [end, given] = std::get<State<Dim>>(states_);
        given.begin(scene);
        end.find(*scene.body(body), ids, parts, "PointForce '" + label + "'", scene.step);
        force = rowAt(table, 1 + Dim, scene.time + scene.dt);
        const Vec<Dim> all = vectorOf<Dim>(force);
        auto& to = given;
        const int field = end.field();
        end.forNodes([&](int node, double weight) { to.add(field, node, weight * all); });
    }
    void stepped(double dt) override {
        impulse.resize(force.size());
        for (size_t k = 0; k < force.size(); ++k) impulse[k] += dt * force[k];
        std::apply([&](auto&... state) { ((work += state.given.finish(dt)), ...); }, states_);
    }

  private:
    template <int Dim> struct State {
        Attachment<Dim> end;
        NodalForces<Dim> given;
    };
    std::tuple<State<2>, State<3>> states_;

    template <int Dim> void check(Scene<Dim>& scene) {
        if (dead) return;
        require(!ids.empty(), "PointForce '", label,
                "': it acts on no particle; make it by mpm.Force(body, at, ...)");
        require(!table.empty(), "PointForce '", label, "': table is empty; give rows (time, force ...)");
        checkTable("PointForce", "table", table, 1 + Dim);
        scene.body(body);
    }
};

MPM_REGISTER(Engine, PointForce);

} // namespace mpm
