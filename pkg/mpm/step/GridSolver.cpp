// SPDX-License-Identifier: GPL-2.0-or-later
// Step 3: the equation of motion on the nodes.
#include "mpm/scene/Engine.hpp"
#include "mpm/step/nodes.hpp"

namespace mpm {

class GridSolver : public EngineOf<GridSolver> {
  public:
    std::vector<double> gravity;
    double damping = 0;

    std::string className() const override { return "GridSolver"; }
    std::string doc() const override {
        return "Solves the equation of motion on the nodes, with gravity, local damping and prescribed velocities.\n\n"
               "a = f/m,  v <- v + dt a.  Local damping (Cundall 1987, in the form of YADE) acts on the acceleration that\n"
               "the particles take from the nodes, a_k <- a_k [1 - damping sgn(a_k v_k)] per component, v at mid-step: nodal\n"
               "forces that no particle feels would otherwise drag, see doc/decisions/0006.";
    }
    std::vector<Parameter> attributes() override {
        return {
            {"gravity", "m/s2", "Acceleration of gravity, one component per axis; acts on the unscaled mass.",
             &gravity},
            {"damping", "-", "Local non-viscous damping coefficient.", &damping, Range{0, 1, false, true}}};
    }

    void prepare(Scene<2>& scene) override { checkGravity(scene); }
    void prepare(Scene<3>& scene) override { checkGravity(scene); }

    template <int Dim> void act(Scene<Dim>& scene) {
        scene.damping = damping;
        for (int k = 0; k < Dim; ++k) scene.gravity[k] = gravity[k];
        const int slabs = scene.grid.slabs(), n = int(scene.constraints.size());
        partial_.resize(size_t(slabs) * (n + 1));
        const double least = scene.leastMass();
        Quad g{};
        for (int k = 0; k < Dim; ++k) NodalField<Dim>::setComponent(g, k, gravity[k]);
        parallel(scene.threads, [&](ParallelRegion& region) {
            for (auto& field : scene.grid.fields)
                region.forPieces(field.partition, [&](int slab) {
                    Tally* tally = &partial_[size_t(slab) * (n + 1)];
                    if (&field == &scene.grid.fields.front()) std::fill(tally, tally + n + 1, Tally{});
                    Quad power{};
                    scene.grid.forNodes(
                        field, slab, [&](int node) { power += solve(scene, field, node, g, least, tally); });
                    for (int k = 0; k < Dim; ++k)
                        tally[n].gravity += power[NodalField<Dim>::lane(k)] * scene.dt;
                });
        });
        addUp(scene);
    }

  private:
    // Reaction, moment and work of one constraint in one slab; the last entry of a slab collects energies.
    struct Tally {
        double force[3] = {0, 0, 0}, moment[3] = {0, 0, 0}, work = 0, gravity = 0;
        int nodes = 0;
    };
    std::vector<Tally> partial_;

    template <int Dim> void checkGravity(Scene<Dim>&) {
        if (gravity.empty()) gravity.assign(Dim, 0.0);
        require(int(gravity.size()) == Dim, "GridSolver: gravity has ", gravity.size(), " components; give ",
                Dim, " for this scene");
    }

    // Returns the power of gravity.
    template <int Dim>
    MPM_INLINE Quad solve(const Scene<Dim>& scene, NodalField<Dim>& field, int node, Quad g, double least,
                          Tally* tally) const {
        using NF = NodalField<Dim>;
        const auto& sum = field.sum[node];
        const double m = sum[NF::mass];
        Quad v{}, a{}, weight{};
        double overMass = 0;
        if (m > least) {
            overMass = 1 / m;
            weight = sum[NF::weightMass] * g;
            a = overMass * (NF::forceIn(sum) + weight);
            v = overMass * NF::momentumIn(sum) + scene.dt * a;
            if (field.isHeld(node)) hold(scene, field, node, weight, v, a, tally);
        }
        NF::setMotion(field.motion[node], v, a);
        // Under MUSL this velocity is summed up anew from the particles.
        field.velocity[node] = scene.scheme == Scheme::MUSL ? NF::noMomentum(overMass) : NF::velocityOf(v);
        return weight * v;
    }

    // Momentum and force are both replaced where a node is held, or the FLIP increment leaks.
    template <int Dim>
    static void hold(const Scene<Dim>& scene, const NodalField<Dim>& field, int node, const Quad& weight,
                     Quad& v, Quad& a, Tally* tally) {
        using NF = NodalField<Dim>;
        const auto& sum = field.sum[node];
        for (int k = 0; k < Dim; ++k)
            if (const int c = field.holder[node][k]; c >= 0) {
                const double after = scene.prescribed(c, k, scene.time + scene.dt);
                const double change = (after - scene.prescribed(c, k, scene.time)) / scene.dt;
                NF::setComponent(v, k, after), NF::setComponent(a, k, change);
                react(scene, c, node, k, sum[NF::mass] * change - (NF::forceOf(sum, k) + weight[NF::lane(k)]),
                      after, tally[c]);
            }
    }

    template <int Dim>
    static void react(const Scene<Dim>& scene, int constraint, int node, int axis, double force, double v,
                      Tally& t) {
        addReaction<Dim>(scene.grid.nodePosition(node), scene.constraints[constraint]->centre, axis, force,
                         t.force, t.moment);
        t.work += force * v * scene.dt;
        ++t.nodes;
    }

    template <int Dim> void addUp(Scene<Dim>& scene) {
        const int n = int(scene.constraints.size());
        for (int c = 0; c <= n; ++c) {
            Tally total;
            for (size_t i = c; i < partial_.size(); i += n + 1) {
                for (int k = 0; k < 3; ++k)
                    total.force[k] += partial_[i].force[k], total.moment[k] += partial_[i].moment[k];
                total.work += partial_[i].work, total.gravity += partial_[i].gravity;
                total.nodes += partial_[i].nodes;
            }
            if (c == n) {
                scene.energies.gravity += total.gravity;
                continue;
            }
            Constraint& constraint = *scene.constraints[c];
            std::copy(total.force, total.force + 3, constraint.reaction);
            std::copy(total.moment, total.moment + 3, constraint.moment);
            constraint.work += total.work, constraint.heldNodes = total.nodes;
        }
    }
};

MPM_REGISTER(Engine, GridSolver);

} // namespace mpm
