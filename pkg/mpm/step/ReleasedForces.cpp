// SPDX-License-Identifier: GPL-2.0-or-later
// What soil that was taken out gave to the nodes, released in increments: excavation without a shock.
//
// Nodal forces with the soil are measured before it goes, those without it behind that; the difference acts from
// then on, and fades.
#include "mpm/step/NodalForces.hpp"

#include <map>
#include <tuple>

namespace mpm {

class ReleasedForces : public EngineOf<ReleasedForces> {
  public:
    double over = 0, begins = 0, work = 0;
    int measured = 0;
    std::vector<double> held, force;

    std::string className() const override { return "ReleasedForces"; }
    std::string doc() const override {
        return "Forces of removed soil on the nodes, which fade linearly.\n\n"
               "f_i (1 - (t - begins) / over), f_i: internal forces and weight with the soil less those without it.\n"
               "Made by scene.remove(..., over=seconds). Stands between ParticleToGrid and GridSolver.";
    }
    std::vector<Parameter> attributes() override {
        return {{"over", "s", "Time in which the forces fade.", &over, Range::notNegative()},
                {"begins", "s", "Time of the removal.", &begins},
                {"measured", "", "How often forces were measured: 1, with the soil; 2, without it, too.",
                 &measured},
                {"held", "kN", "Rows (group, node, components) of the forces at the removal; empty: faded.",
                 &held},
                {"force", "kN", "Sum of the forces in the last step.", &force},
                {"work", "kJ", "Work done on the bodies.", &work}};
    }
    void prepare(Scene<2>& scene) override { check(scene); }
    void prepare(Scene<3>& scene) override { check(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        auto& state = std::get<State<Dim>>(states_);
        auto& [given, rows, with] = state;
        if (measured < 2) return measure(scene, state);
        given.begin(scene);
        force.assign(Dim, 0.0);
        const double part = 1 - (scene.time - begins) / over;
        if (!(part > 0)) rows.clear();
        dropMassless(scene, rows);
        for (const auto& row : rows) {
            given.add(row.field, row.node, part * row.force);
            for (int k = 0; k < Dim; ++k) force[k] += part * row.force[k];
        }
    }
    void stepped(double dt) override {
        std::apply([&](auto&... state) { ((work += state.given.finish(dt)), ...); }, states_);
    }

  private:
    template <int Dim> struct Row {
        int field, node;
        Vec<Dim> force;
    };
    template <int Dim> struct Found {
        Vec<Dim> force = Vec<Dim>::Zero();
        double mass = 0;
    };
    template <int Dim> using AtNodes = std::map<std::pair<int, int>, Found<Dim>>; // by group and node
    template <int Dim> struct State {
        NodalForces<Dim> given;
        std::vector<Row<Dim>> rows;
        AtNodes<Dim> with; // the soil, until it is gone
    };
    std::tuple<State<2>, State<3>> states_;

    // Between two steps, behind ParticleToGrid and the forces of earlier removals.
    template <int Dim> void measure(Scene<Dim>& scene, State<Dim>& state) {
        using NF = NodalField<Dim>;
        const Vec<Dim> gravity = gravityOf(scene);
        const double least = scene.leastMass();
        AtNodes<Dim> now;
        for (int f = 0; f < int(scene.grid.fields.size()); ++f) {
            const auto& field = scene.grid.fields[f];
            for (int slab = 0; slab < scene.grid.slabs(); ++slab)
                scene.grid.forNodes(field, slab, [&](int node) {
                    const auto& sum = field.sum[node];
                    if (sum[NF::mass] > least)
                        now[{f, node}] = {NF::forceOf(sum) + sum[NF::weightMass] * gravity, sum[NF::mass]};
                });
        }
        if (measured++ == 0)
            state.with = std::move(now);
        else
            compare(scene, state, now);
    }

    // What is left on a node goes on with the acceleration that it had: without contact that is balance. The rest of
    // the force is inertia that is gone, and what contact held: this another group takes over.
    template <int Dim> void compare(const Scene<Dim>& scene, State<Dim>& state, const AtNodes<Dim>& without) {
        constexpr double roundOff = 1e-12; // of the largest force: sums in another order differ by less
        AtNodes<Dim> given;
        double largest = 0;
        for (const auto& [place, with] : state.with) {
            const auto found = without.find(place);
            const Found<Dim> left = found == without.end() ? Found<Dim>() : found->second;
            const double part = std::min(1.0, left.mass / with.mass);
            largest = std::max(largest, with.force.norm());
            if (left.mass > 0) given[place].force += part * with.force - left.force;
            const int other = heaviestBeside(place, without);
            const auto& holder = scene.grid.fields[place.first].holder[place.second];
            for (int k = 0; k < Dim && other >= 0; ++k)
                if (holder[k] < 0) given[{other, place.second}].force[k] += (1 - part) * with.force[k];
        }
        state.with.clear();
        state.rows.clear();
        for (const auto& [place, all] : given)
            if (all.force.norm() > roundOff * largest)
                state.rows.push_back({place.first, place.second, all.force});
        keep(state.rows);
    }
    // Of the other groups on a node; -1: there is none.
    template <int Dim>
    static int heaviestBeside(const std::pair<int, int>& place, const AtNodes<Dim>& without) {
        int heaviest = -1;
        double most = 0;
        for (auto at = without.lower_bound({0, 0}); at != without.end();
             at = without.lower_bound({at->first.first + 1, 0})) {
            const int field = at->first.first;
            const auto other = without.find({field, place.second});
            if (field != place.first && other != without.end() && other->second.mass > most)
                most = other->second.mass, heaviest = field;
        }
        return heaviest;
    }

    // Forces on a node that its group has left are gone.
    template <int Dim> void dropMassless(const Scene<Dim>& scene, std::vector<Row<Dim>>& rows) {
        const auto isGone = [&, least = scene.leastMass()](const Row<Dim>& row) {
            if (row.field >= int(scene.grid.fields.size())) return true;
            const auto& nodal = scene.grid.fields[row.field];
            return !(scene.grid.mayHaveMass(nodal, row.node) &&
                     nodal.sum[row.node][NodalField<Dim>::mass] > least);
        };
        rows.erase(std::remove_if(rows.begin(), rows.end(), isGone), rows.end());
        if (held.size() != (2 + Dim) * rows.size()) keep(rows);
    }
    template <int Dim> void keep(const std::vector<Row<Dim>>& rows) {
        held.clear();
        for (const auto& row : rows) {
            held.insert(held.end(), {double(row.field), double(row.node)});
            for (int k = 0; k < Dim; ++k) held.push_back(row.force[k]);
        }
    }

    template <int Dim> void check(Scene<Dim>&) {
        if (dead) return;
        require(measured > 0 && over > 0 && held.size() % (2 + Dim) == 0,
                "ReleasedForces: made by scene.remove(..., over=seconds)");
        auto& rows = std::get<State<Dim>>(states_).rows;
        rows.clear();
        for (size_t i = 0; i < held.size(); i += 2 + Dim)
            rows.push_back({int(held[i]), int(held[i + 1]), vectorOf<Dim>(held, i + 2)});
    }
};

MPM_REGISTER(Engine, ReleasedForces);

} // namespace mpm
