// SPDX-License-Identifier: GPL-2.0-or-later
// A spring between a body and a fixed point or another body: a prop, a strut, the free length of an anchor.
#include "mpm/step/NodalForces.hpp"

#include <tuple>

namespace mpm {

class Spring : public EngineOf<Spring> {
  public:
    std::string body, toBody, only;
    std::vector<double> at, to, ids, parts, toIds, toParts;
    double stiffness = notGiven, prestress = 0, limit = notGiven, besides = 0;
    // What a run finds:
    std::vector<double> starts; // m, middles of the particles at both ends when it began
    double length = 0, slip = 0, force = 0, impulse = 0, work = 0;

    std::string className() const override { return "Spring"; }
    std::string doc() const override {
        return "Spring from a point of a body to a fixed point or to a point of another body.\n\n"
               "force = prestress + stiffness (elongation - slip), tension positive, along the line between both points "
               "as\n"
               "they are now. Stands between ParticleToGrid and GridSolver.";
    }
    std::vector<Parameter> attributes() override {
        return {{"body", "", "Name of the body.", &body},
                {"at", "m", "Point of the body that it acts on.", &at},
                {"to", "m", "Its other end.", &to},
                {"toBody", "", "Name of the body that the other end belongs to; none: it is fixed.", &toBody},
                {"stiffness", "kN/m",
                 "Force over elongation (plane strain: per metre; axisymmetric: of the whole circumference).",
                 &stiffness, Range::positive()},
                {"prestress", "kN", "Force when it begins, tension positive.", &prestress},
                {"limit", "kN", "Largest force, tension or compression, at which it yields; None: no limit.",
                 &limit, Range::positive()},
                {"only",
                 "",
                 "'tension' or 'compression': it bears nothing else.",
                 &only,
                 {},
                 {"", "tension", "compression"}},
                {"besides", "kN/m", "Stiffness of the other springs at the same particles.", &besides},
                {"ids", "", "Particles of the body that it acts on, by id.", &ids},
                {"parts", "-", "Parts of the force that they take.", &parts},
                {"toIds", "", "Those of the other body.", &toIds},
                {"toParts", "-", "And their parts.", &toParts},
                {"starts", "m", "Middles of these particles when it began.", &starts},
                {"length", "m", "Its length without force.", &length},
                {"slip", "m", "Elongation that stays, since it has yielded.", &slip},
                {"force", "kN", "Force in the last step, tension positive.", &force},
                {"impulse", "kN s", "Time integral of the force.", &impulse},
                {"work", "kJ", "Work done on the bodies.", &work}};
    }
    void finish() override {
        require(!std::isnan(stiffness) || ids.empty(), "Spring: stiffness is missing; give kN/m");
        require(ids.size() == parts.size() && toIds.size() == toParts.size(),
                "Spring: ids and parts differ in number");
        require(starts.empty() || starts.size() == 6, "Spring: starts has ", starts.size(),
                " numbers; give six, or none");
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        auto& state = std::get<State<Dim>>(states_);
        const std::string who = "Spring '" + label + "'";
        state.given.begin(scene);
        state.ends[0].find(*scene.body(body), ids, parts, who, scene.step);
        if (hasOther()) state.ends[1].find(*scene.body(toBody), toIds, toParts, who, scene.step);
        if (starts.empty()) begin(state);
        const Vec<Dim> along = line(state);
        const double now = along.norm();
        if (!(now > 0)) throw RunError(message("step ", scene.step, ": ", who, ": its ends meet"));
        checkStep(scene, state, who);
        force = law(now - length);
        const Vec<Dim> pull = force / now * along;
        for (int end = 0; end < (hasOther() ? 2 : 1); ++end)
            state.ends[end].forNodes([&](int node, double weight) {
                state.given.add(state.ends[end].field(), node, (end == 0 ? weight : -weight) * pull);
            });
    }
    void stepped(double dt) override {
        impulse += dt * force;
        std::apply([&](auto&... state) { ((work += state.given.finish(dt)), ...); }, states_);
    }

  private:
    template <int Dim> struct State {
        Attachment<Dim> ends[2];
        NodalForces<Dim> given;
    };
    std::tuple<State<2>, State<3>> states_;

    bool hasOther() const { return !toBody.empty(); }

    template <int Dim> void check(Scene<Dim>& scene) {
        if (dead) return;
        require(!ids.empty(), "Spring '", label,
                "': it acts on no particle; make it by mpm.Spring(body, at, ...)");
        require(at.size() == Dim && to.size() == Dim, "Spring '", label, "': at and to have ", at.size(),
                " and ", to.size(), " components; give ", Dim);
        scene.body(body);
        if (hasOther()) scene.body(toBody);
    }

    template <int Dim> void begin(const State<Dim>& state) {
        starts.assign(6, 0.0);
        for (int end = 0; end < (hasOther() ? 2 : 1); ++end) {
            const Vec<Dim> x = state.ends[end].position();
            for (int k = 0; k < Dim; ++k) starts[3 * end + k] = x[k];
        }
        length = line(state).norm() - prestress / stiffness;
    }

    // From the point of the body to the other end, m.
    template <int Dim> Vec<Dim> line(const State<Dim>& state) const {
        Vec<Dim> from = vectorOf<Dim>(at) + state.ends[0].position() - vectorOf<Dim>(starts);
        Vec<Dim> end = vectorOf<Dim>(to);
        if (hasOther()) end += state.ends[1].position() - vectorOf<Dim>(starts, 3);
        return end - from;
    }

    double law(double elongation) {
        double F = stiffness * (elongation - slip);
        if ((only == "tension" && F < 0) || (only == "compression" && F > 0))
            return 0; // and what is slack does not yield
        if (!std::isnan(limit) && std::abs(F) > limit) {
            const double most = F > 0 ? limit : -limit;
            slip += (F - most) / stiffness;
            F = most;
        }
        return F;
    }

    // The force acts with the position at the start of the step: nodes that it moves have to follow.
    template <int Dim>
    void checkStep(const Scene<Dim>& scene, const State<Dim>& state, const std::string& who) {
        constexpr double most = 1; // k dt^2 / m; a free mass is stable up to 4
        double inverse = 0;
        for (int end = 0; end < (hasOther() ? 2 : 1); ++end) inverse += state.ends[end].inverseMass(scene);
        const double stiffest = most / (inverse * scene.dt * scene.dt);
        if (stiffness + besides > stiffest)
            throw RunError(message(
                "step ", scene.step, ": ", who, ": stiffness = ", stiffness, " kN/m",
                besides > 0
                    ? message(", with other springs at the same place ", stiffness + besides, " kN/m,")
                    : "",
                " is more than the nodes at its ends can follow at dt = ", scene.dt, " s, which is ",
                stiffest,
                " kN/m; lower dt or stiffness (a prop ten times as stiff as the wall behind "
                "it is as good as rigid), or spread it by width"));
    }
};

MPM_REGISTER(Engine, Spring);

} // namespace mpm
