// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/check/ElasticOperator.hpp"

#include "mpm/step/Driving.hpp"
#include "mpm/step/nodes.hpp"

#include <algorithm>
#include <numeric>

namespace mpm {

namespace {

// The nodes that a body reaches, or will once it has moved by a quarter of a cell.
template <int Dim> std::vector<char> reachOf(const Grid<Dim>& grid, const Body<Dim>& body) {
    auto* mesh = body.domains->mesh();
    auto* boxes = body.domains->boxes();
    const Field& points = mesh ? mesh->vertexPositions() : body.particles.position;
    const Vec<Dim> reach =
        0.25 * grid.smallestCell() + (boxes ? boxes->halfSize() : Vec<Dim>(Vec<Dim>::Zero()));
    const int n = points.size();
    std::vector<char> isReached(grid.count, 0);
    for (int a = 0; a < corners<Dim>; ++a) {
        std::vector<int> cells(n, 0);
        for (int k = 0; k < Dim; ++k) {
            std::vector<double> moved(points.plane(k), points.plane(k) + n);
            for (double& x : moved) x += cornerSign(a, k) * reach[k];
            grid.addCells(k, moved.data(), n, cells.data());
        }
        for (int cell : cells)
            for (int b = 0; b < corners<Dim>; ++b) isReached[cornerOf(grid, cell, b)] = 1;
    }
    return isReached;
}

template <int Dim> std::vector<int> allOf(const Body<Dim>& body) {
    std::vector<int> all(body.particles.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

void join(std::vector<char>& all, const std::vector<char>& more) {
    for (size_t i = 0; i < all.size(); ++i) all[i] |= more[i];
}
bool meet(const std::vector<char>& a, const std::vector<char>& b) {
    for (size_t i = 0; i < a.size(); ++i)
        if (a[i] && b[i]) return true;
    return false;
}

} // namespace

// The stand-ins are in place as long as this lives.
template <int Dim> class ElasticOperator<Dim>::Exchanged {
  public:
    explicit Exchanged(ElasticOperator& of) : of_(of) { swap(); }
    ~Exchanged() { swap(); }
    Exchanged(const Exchanged&) = delete;

  private:
    ElasticOperator& of_;
    void swap() {
        for (auto* all : {&of_.gradient_, &of_.vertices_})
            for (StandIn& standIn : *all) std::swap(*standIn.field, standIn.own);
    }
};

template <int Dim>
ElasticOperator<Dim>::ElasticOperator(Scene<Dim>& scene, bool explicitAlone) : scene_(scene) {
    parallel(scene.threads, [&](ParallelRegion& region) {
        locateParticles(region, scene, false);
        if (!region.failed()) sumOnNodes<Dim>(region, scene, nullptr, false);
    });
    std::vector<double> scratch;
    holdDrivenNodes(scene, scratch);
    freeSharedNodes(explicitAlone);
    scene.state.mirrors.fold(scene.grid, Vec<Dim>::Zero());
    scene.state.parted.bond(scene);
    findDofs();
    for (size_t f = 0; f < scene.grid.fields.size(); ++f) {
        const auto makeRoom = [&](auto& all, const auto& zero) {
            const int first = scene.groupOf[f];
            auto& own = all.emplace_back();
            first == int(f) ? own.assign(scene.grid.count, zero, scene.grid.fields[f].halves)
                            : own.beSecondHalfOf(all[first]);
        };
        makeRoom(velocity_, NF::Velocity::zero());
        makeRoom(force_, NF::Sum::zero());
        makeRoom(motion_, NF::Motion::zero());
    }
    for (auto& body : scene.bodies) {
        isIn_.push_back(!explicitAlone || !isSolvedImplicitly(scene, *body));
        stress_.emplace_back("elasticStress", "kPa", "", std::vector<int>{3, 3});
        stress_.back().resize(body->particles.size());
        gradient_.emplace_back(body->particles.velocityGradient);
        if (scene.grid.isAxisymmetric) gradient_.emplace_back(body->particles.hoopRate);
        vertices_.emplace_back(body->particles.velocity);
        if (auto* mesh = body->domains->mesh()) vertices_.emplace_back(mesh->vertexVelocities());
    }
    if (explicitAlone && scene.scheme->remapsSolution()) findSolved();
}

// A drive holds a node only while half of its mass is driven. Where the driven body pokes over a line of the
// grid the nodes behind it are free and feel its stiffness: those that it shares with other bodies count,
// wherever it is now. Where it shares none it may meet one anywhere before the next look: all of its nodes
// count.
template <int Dim> void ElasticOperator<Dim>::freeSharedNodes(bool explicitAlone) {
    std::vector<double> own(scene_.grid.count);
    std::vector<int> touched;
    for (const auto& drive : scene_.constraints) {
        if (!drive->drivesBody() || !drive->active) continue;
        const Body<Dim>& body = *scene_.body(drive->body);
        if (explicitAlone && isSolvedImplicitly(scene_, body)) continue;
        const auto isOther = [&](const auto& other) {
            return other.get() != &body && other->velocityField == body.velocityField;
        };
        if (std::none_of(scene_.bodies.begin(), scene_.bodies.end(), isOther)) continue;
        std::fill(own.begin(), own.end(), 0.0);
        touched.clear();
        body.domains->addQuantity(body.particles.mass.plane(), allOf(body), own.data(), touched);
        auto& field = scene_.grid.fields[body.velocityField];
        const auto isShared = [&](int node) {
            return body.inertiaScale * own[node] < (1 - 1e-9) * field.sum[node][NF::mass];
        };
        const bool isApart = std::none_of(touched.begin(), touched.end(), isShared);
        for (auto held = scene_.state.driven.rbegin(); held != scene_.state.driven.rend(); ++held)
            if (held->field == body.velocityField && own[held->node] > 0 && (isApart || isShared(held->node)))
                field.holder[held->node][held->axis] = held->before;
    }
}

template <int Dim> void ElasticOperator<Dim>::findDofs() {
    const double least = scene_.leastMass();
    for (auto& field : scene_.grid.fields)
        for (int slab = 0; slab < scene_.grid.slabs(); ++slab)
            scene_.grid.forNodes(field, slab, [&](int node) {
                const double m = field.sum[node][NF::mass];
                for (int k = 0; k < Dim; ++k)
                    if (m > least && field.holder[node][k] < 0) {
                        dofs_.push_back({int(&field - scene_.grid.fields.data()), node, k});
                        mass_.push_back(m);
                    }
            });
}

// Where a body reaches no other one it may meet one anywhere before the next look: all nodes count.
template <int Dim> void ElasticOperator<Dim>::findSolved() {
    std::vector<std::vector<char>> isShared(scene_.grid.fields.size());
    for (size_t field = 0; field < isShared.size(); ++field) {
        if (!mixesImplicit(scene_, int(field))) continue;
        std::vector<char> others(scene_.grid.count, 0);
        for (auto& body : scene_.bodies)
            if (body->velocityField == int(field) && !isSolvedImplicitly(scene_, *body))
                join(others, reachOf(scene_.grid, *body));
        isShared[field].assign(scene_.grid.count, 0);
        for (auto& body : scene_.bodies)
            if (body->velocityField == int(field) && isSolvedImplicitly(scene_, *body)) {
                const std::vector<char> own = reachOf(scene_.grid, *body);
                if (meet(own, others))
                    join(isShared[field], own);
                else
                    isShared[field].assign(own.size(), 1);
            }
    }
    std::vector<double> others;
    for (const Dof& dof : dofs_) {
        isSolved_.push_back(!isShared[dof.field].empty() && isShared[dof.field][dof.node]);
        others.push_back(!isSolved_.back());
    }
    if (std::count(isSolved_.begin(), isSolved_.end(), 1) == 0) return isSolved_.clear();
    passAll(others, toSolved_); // and to what is held, as if it were of these: on the safe side
    for (double& share : toSolved_) share = 1 - share;
}

template <int Dim> void ElasticOperator<Dim>::apply(const std::vector<double>& x, std::vector<double>& y) {
    const Exchanged exchanged(*this);
    take(x);
    parallel(scene_.threads, [&](ParallelRegion& region) { strain(region); });
    parallel(scene_.threads, [&](ParallelRegion& region) { sumForces(region); });
    for (size_t f = 0; f < force_.size(); ++f)
        scene_.state.mirrors.foldValues(
            int(f), [&](int ghost, int k) { return NF::forceOf(force_[f][ghost])[k]; },
            [&](int node, int k, double force) { NF::addForce(force_[f][node], k, force); });
    scene_.state.parted.forBonded(
        [&](int first, int second, int node) { force_[first][node] += force_[second][node]; });
    readForces(y);
}

template <int Dim>
void ElasticOperator<Dim>::passThroughParticles(const std::vector<double>& x, std::vector<double>& y) {
    if (isSolved_.empty()) return passAll(x, y);
    std::vector<double> others(x);
    for (int i = 0; i < size(); ++i)
        if (isSolved_[i]) others[i] = 0;
    std::vector<double> ofOthers;
    passAll(others, ofOthers);
    passAll(x, y);
    for (int i = 0; i < size(); ++i)
        y[i] = 2 * (isSolved_[i] ? x[i] : ofOthers[i] + toSolved_[i] * x[i]) - y[i];
}

template <int Dim> void ElasticOperator<Dim>::passAll(const std::vector<double>& x, std::vector<double>& y) {
    const Exchanged exchanged(*this);
    for (size_t f = 0; f < motion_.size(); ++f)
        for (int slab = 0; slab < scene_.grid.slabs(); ++slab)
            scene_.grid.forNodes(scene_.grid.fields[f], slab, [&](int node) {
                motion_[f][node] = NF::Motion::zero();
                velocity_[f][node] = NF::Velocity::zero();
            });
    setValues(motion_, x);
    // Particles that take all of the velocity (PIC), and no time in which anything else could happen.
    parallel(scene_.threads, [&](ParallelRegion& region) {
        for (auto& body : scene_.bodies)
            body->domains->move(region, motion_[body->velocityField].data(),
                                velocity_[body->velocityField].data(), {0, 0, 0, body->inertiaScale});
    });
    for (size_t f = 0; f < velocity_.size(); ++f)
        scene_.state.mirrors.foldValues(
            int(f), [&](int ghost, int k) { return velocity_[f][ghost][k]; },
            [&](int node, int k, double p) { velocity_[f][node].set(k, velocity_[f][node][k] + p); });
    scene_.state.parted.forBonded([&](int first, int second, int node) {
        for (int k = 0; k < Dim; ++k)
            velocity_[first][node].set(k, velocity_[first][node][k] + velocity_[second][node][k]);
    });
    y.resize(size());
    for (int i = 0; i < size(); ++i)
        y[i] = velocity_[dofs_[i].field][dofs_[i].node][dofs_[i].axis] / mass_[i];
}

template <int Dim> void ElasticOperator<Dim>::sumForces(ParallelRegion& region) {
    for (size_t b = 0; b < scene_.bodies.size(); ++b) {
        auto& body = *scene_.bodies[b];
        if (!isIn_[b]) continue;
        const double* planes[9];
        for (int c = 0; c < 9; ++c) planes[c] = stress_[b].plane(c);
        body.domains->addForce(region, force_[body.velocityField].data(), planes);
    }
}

template <int Dim> void ElasticOperator<Dim>::readForces(std::vector<double>& y) const {
    y.resize(size());
    for (int i = 0; i < size(); ++i) {
        const Dof& dof = dofs_[i];
        y[i] = -NF::forceOf(force_[dof.field][dof.node])[dof.axis] / mass_[i];
    }
}

template <int Dim> void ElasticOperator<Dim>::take(const std::vector<double>& x) {
    for (size_t f = 0; f < force_.size(); ++f)
        for (int slab = 0; slab < scene_.grid.slabs(); ++slab)
            scene_.grid.forNodes(scene_.grid.fields[f], slab, [&](int node) {
                velocity_[f][node] = NF::Velocity::zero();
                force_[f][node] = NF::Sum::zero();
            });
    setValues(velocity_, x);
}

template <int Dim>
template <class Values>
void ElasticOperator<Dim>::setValues(Values& values, const std::vector<double>& x) const {
    for (int i = 0; i < size(); ++i) values[dofs_[i].field][dofs_[i].node].set(dofs_[i].axis, x[i]);
    scene_.state.parted.forBonded(
        [&](int first, int second, int node) { values[second][node] = values[first][node]; });
    for (size_t f = 0; f < values.size(); ++f)
        scene_.state.mirrors.reflectValues(
            int(f), [&](int node, int k) { return values[f][node][k]; },
            [&](int ghost, int k, double v) { values[f][ghost].set(k, v); });
}

template <int Dim> void ElasticOperator<Dim>::strain(ParallelRegion& region) {
    for (size_t b = 0; b < scene_.bodies.size(); ++b) {
        if (!isIn_[b]) continue;
        auto& body = *scene_.bodies[b];
        const auto* nodes = velocity_[body.velocityField].data();
        if (auto* mesh = body.domains->mesh()) mesh->takeVelocity(region, nodes);
        region.chunks(body.particles.size(), [&](int begin, int end) {
            body.domains->takeGradient(begin, end, nodes, 0);
            scene_.grid.inGeometry([&](auto isRound) {
                elasticStress<strainedAxes<Dim, isRound>>(body, stress_[b], begin, end);
            });
        });
    }
}

template <int Dim>
template <int N>
void ElasticOperator<Dim>::elasticStress(Body<Dim>& body, Field& stress, int begin, int end) {
    double lambda[chunkSize], mu[chunkSize];
    body.stiffness(begin, end, lambda, mu);
    const VelocityGradient<N> L(body.particles, begin);
    for (int p = 0; p < end - begin; ++p) {
        double trace = 0;
        for (int k = 0; k < N; ++k) trace += L(k, k, p);
        for (int i = 0; i < N; ++i)
            for (int j = i; j < N; ++j)
                stress.plane(3 * i + j)[begin + p] =
                    (i == j ? lambda[p] * trace : 0) + mu[p] * (L(i, j, p) + L(j, i, p));
    }
}

template <int Dim> std::string ElasticOperator<Dim>::stiffest() const {
    double most = -1;
    std::string name;
    const bool isRound = scene_.grid.isAxisymmetric;
    const int each = isRound ? 2 : 1; // fields of a body
    for (size_t b = 0; b < scene_.bodies.size(); ++b) {
        const auto& particles = scene_.bodies[b]->particles;
        double power = 0;
        for (int p = 0; p < particles.size(); ++p)
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j)
                    power += particles.volume.plane()[p] *
                             stress_[b].plane(3 * std::min(i, j) + std::max(i, j))[p] *
                             gradient_[b * each].own.plane(Dim * i + j)[p];
        for (int p = 0; isRound && p < particles.size(); ++p)
            power +=
                particles.volume.plane()[p] * stress_[b].plane(8)[p] * gradient_[b * each + 1].own.plane()[p];
        if (power > most) {
            most = power;
            name = scene_.bodies[b]->name;
        }
    }
    return name;
}

template class ElasticOperator<2>;
template class ElasticOperator<3>;

} // namespace mpm
