// SPDX-License-Identifier: GPL-2.0-or-later
// Step 3: the equation of motion on the nodes.
#include "mpm/step/nodes.hpp"

namespace mpm {

class GridSolver : public EngineOf<GridSolver>, public SolvingMotion {
  public:
    std::vector<double> gravity;
    double damping = 0;

    std::string className() const override { return "GridSolver"; }
    std::string doc() const override;
    std::vector<Parameter> attributes() override;
    void prepare(Scene<2>& scene) override { checkGravity(scene); }
    void prepare(Scene<3>& scene) override { checkGravity(scene); }
    double gravityAlong(int axis) const override { return gravity[axis]; }
    double dampingOfParticles() const override { return damping; }

    template <int Dim> void act(Scene<Dim>& scene);

  private:
    // Reaction, moment and work of one constraint in one slab; the last entry of a slab collects energies.
    struct Tally {
        double force[3] = {0, 0, 0}, moment[3] = {0, 0, 0}, work = 0, gravity = 0;
        int nodes = 0;
    };
    std::vector<Tally> partial_;
    double flip_ = 1; // of GridToParticle

    template <int Dim> void checkGravity(Scene<Dim>&);
    template <int Dim>
    Quad solve(const Scene<Dim>& scene, NodalField<Dim>& field, int node, Quad g, double least,
               Tally* tally) const;
    template <int Dim>
    void hold(const Scene<Dim>& scene, const NodalField<Dim>& field, int node, const Quad& weight, Quad& v,
              Quad& a, Tally* tally) const;
    template <int Dim>
    static void react(const Scene<Dim>& scene, int constraint, int node, int axis, double force, double v,
                      Tally& tally);
    template <int Dim> void addUp(Scene<Dim>& scene);
};

std::string GridSolver::doc() const {
    return "Solves the equation of motion on the nodes, with gravity, local damping and prescribed "
           "velocities.\n\n"
           "a = f/m,  v <- v + dt a.  Local damping (Cundall 1987, in the form of YADE) acts on the "
           "acceleration that\n"
           "the particles take from the nodes, a_k <- a_k [1 - damping sgn(a_k v_k)] per component, "
           "v at mid-step: nodal\n"
           "forces that no particle feels would otherwise drag, see doc/development/decisions/0006.";
}

std::vector<Parameter> GridSolver::attributes() {
    return {{"gravity", "m/s2", "Acceleration of gravity, one component per axis; acts on the unscaled mass.",
             &gravity},
            {"damping", "-", "Local non-viscous damping coefficient.", &damping, Range{0, 1, false, true}}};
}

template <int Dim> void GridSolver::checkGravity(Scene<Dim>&) {
    if (gravity.empty()) gravity.assign(Dim, 0.0);
    require(int(gravity.size()) == Dim, "GridSolver: gravity has ", gravity.size(), " components; give ", Dim,
            " for this scene");
}

template <int Dim> void GridSolver::act(Scene<Dim>& scene) {
    using NF = NodalField<Dim>;
    flip_ = flipOf(scene);
    const int slabs = scene.grid.slabs(), n = int(scene.constraints.size());
    partial_.resize(size_t(slabs) * (n + 1));
    scene.template forRoles<ActingAhead>([&](ActingAhead& ahead) { ahead.actAhead(scene); });
    scene.state.mirrors.fold(scene.grid, gravityOf(scene));
    scene.state.parted.bond(scene);
    scene.template forRoles<JoiningNodes>([&](JoiningNodes& joining) { joining.join(scene); });
    const double least = scene.leastMass();
    Quad g{};
    for (int k = 0; k < Dim; ++k) NF::setComponent(g, k, gravity[k]);
    parallel(scene.threads, [&](ParallelRegion& region) {
        for (auto& field : scene.grid.fields)
            region.forPieces(field.partition, [&](int slab) {
                Tally* tally = &partial_[size_t(slab) * (n + 1)];
                if (&field == &scene.grid.fields.front()) std::fill(tally, tally + n + 1, Tally{});
                Quad power{};
                scene.grid.forNodes(field, slab,
                                    [&](int node) { power += solve(scene, field, node, g, least, tally); });
                for (int k = 0; k < Dim; ++k) tally[n].gravity += power[NF::lane(k)] * scene.dt;
            });
    });
    for (auto& field : scene.grid.fields)
        field.straining =
            scene.scheme->remapsSolution() ? NF::Straining::noMomentum : NF::Straining::velocity;
    addUp(scene);
}

// Returns the power of gravity.
template <int Dim>
MPM_INLINE Quad GridSolver::solve(const Scene<Dim>& scene, NodalField<Dim>& field, int node, Quad g,
                                  double least, Tally* tally) const {
    using NF = NodalField<Dim>;
    const auto& sum = field.sum[node];
    const double m = sum[NF::mass];
    Quad v{}, a{}, weight{};
    double overMass = 0;
    if (m > least) {
        overMass = 1 / m;
        weight = sum[NF::weightMass] * g;
        a = overMass * (NF::forceLanes(sum) + weight);
        v = overMass * NF::momentumLanes(sum) + scene.dt * a;
        if (field.isHeld(node)) hold(scene, field, node, weight, v, a, tally);
    }
    NF::setMotion(field.motion[node], v, a);
    if (scene.scheme->remapsSolution())
        field.clearMomentum(node, overMass);
    else
        field.setVelocity(node, v);
    return weight * (v + (-0.5 * scene.dt) * a);
}

// The particles take the whole change of the velocity of a node that is held: what is held has the velocity that is
// prescribed, and the impulse is the change of its momentum. A wall stops the nodes; particles beside it keep the share
// `flip` of their velocity.
template <int Dim>
void GridSolver::hold(const Scene<Dim>& scene, const NodalField<Dim>& field, int node, const Quad& weight,
                      Quad& v, Quad& a, Tally* tally) const {
    using NF = NodalField<Dim>;
    const auto& sum = field.sum[node];
    const Vec<Dim> force = NF::forceOf(sum);
    for (int k = 0; k < Dim; ++k)
        if (const int c = field.holder[node][k]; c >= 0) {
            const double after = scene.heldAtEnd(c, k), own = NF::velocityAtStart(sum, k);
            const double change = (after - own) / scene.dt;
            const double kept = scene.constraints[c]->isWall ? flip_ : 0;
            NF::setComponent(v, k, after);
            NF::setComponent(a, k, scene.constraints[c]->isWall ? 0 : change);
            react(scene, c, node, k, (1 - kept) * sum[NF::mass] * change - (force[k] + weight[NF::lane(k)]),
                  scene.heldMean(c, k, own), tally[c]);
        }
}

template <int Dim>
void GridSolver::react(const Scene<Dim>& scene, int constraint, int node, int axis, double force, double v,
                       Tally& tally) {
    addReaction<Dim>(scene.grid.nodePosition(node), scene.constraints[constraint]->centre, axis, force,
                     tally.force, tally.moment);
    tally.work += force * v * scene.dt;
    ++tally.nodes;
}

template <int Dim> void GridSolver::addUp(Scene<Dim>& scene) {
    const int n = int(scene.constraints.size());
    for (int c = 0; c <= n; ++c) {
        Tally total;
        for (size_t i = c; i < partial_.size(); i += n + 1) {
            for (int k = 0; k < 3; ++k) {
                total.force[k] += partial_[i].force[k];
                total.moment[k] += partial_[i].moment[k];
            }
            total.work += partial_[i].work;
            total.gravity += partial_[i].gravity;
            total.nodes += partial_[i].nodes;
        }
        if (c == n) {
            scene.energies.gravity += total.gravity;
            continue;
        }
        Constraint& constraint = *scene.constraints[c];
        std::copy(total.force, total.force + 3, constraint.reaction);
        std::copy(total.moment, total.moment + 3, constraint.moment);
        constraint.work += total.work;
        constraint.heldNodes = total.nodes;
    }
}

MPM_REGISTER(Engine, GridSolver);

} // namespace mpm
