// SPDX-License-Identifier: GPL-2.0-or-later
// Rigid bodies touch the scene by a penalty: a point (uGIMP box, boundary vertex of a mesh) that stands for the area A and
// overlaps by -g gets
//     F = A [(-kappa g) n - kappa_t s],   |kappa_t s| <= mu (-kappa g)
// with the slip s of the history (Cundall & Strack 1979). One thread does all of it, in the order of the points' numbers: the
// same bits for any number of threads, and after a restart.
//
// Vertices pass a force on with their own hat functions. A box with its centre at x_p has its surface at x_c = x_p + d, d against
// the normal. It moves with the particle and its velocity gradient, hence a force there goes to the nodes by
//     f_i = (phi_i + q grad phi_i . d) F_n + (phi_i + grad phi_i . d) F_t
// Friction acts where the normal leaves the box. q |d| is how far from x_p the gap sees strain: the extent of the ball, as long as strain
// is small. (With friction at the ball pairs of boxes stuck below the edges of a wedge, and slipped off.) So sum f_i = F and
// sum x_i x f_i = x_c x F (d x F_n = 0): force and moment balance to round-off, and both springs see the motion that their force does
// work on. With a gap that follows x_p alone and F_n at x_c the stiffness matrix is not symmetric, and a bouncing disc gains energy.
#include "mpm/contact/rigid/RigidContact.hpp"

namespace mpm {

namespace {

// v, which is normal to `from`, under the smallest rotation that takes `from` to `to` (unit vectors).
Vec3 turned(const Vec3& v, const Vec3& from, const Vec3& to) {
    const double c = from.dot(to);
    return c > -0.99 ? Vec3(v - to.dot(v) / (1 + c) * (from + to)) : Vec3(v - to.dot(v) * to);
}

bool isBefore(const RigidTouch& a, const RigidTouch& b) {
    return std::tie(a.soil, a.id, a.body) < std::tie(b.soil, b.id, b.body);
}
bool isSamePair(const RigidTouch& a, const RigidTouch& b) { return !isBefore(a, b) && !isBefore(b, a); }

constexpr double roundOff = 1e-12; // of a cell; a body that touches flat ground gets no force
constexpr double sameSide = 0.5;   // cosine between normals above which two touches of a pair are one

template <int Dim> Mat<3> gradientOf(const Body<Dim>& soil, int p) {
    Mat<3> L = Mat<3>::Zero();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) L(i, j) = soil.particles.velocityGradient.plane(Dim * i + j)[p];
    return L;
}

// From a particle to where it would be had it moved with the velocity that strains it. That one is mapped back from the particles
// (MUSL, USF), the one that moves them is not; under FLIP what lies between them adds up to dt (v_p - sum phi_i v_i).
template <int Dim> Vec3 toStrainedPlace(const Scene<Dim>& scene, const Body<Dim>& soil, int p) {
    using NF = NodalField<Dim>;
    Vec3 straining = Vec3::Zero(), own = Vec3::Zero();
    if (soil.type->isMeshed() || scene.scheme == Scheme::USL) return own;
    const auto& field = scene.grid.fields[soil.velocityField];
    const double least = scene.leastMass();
    soil.domains->weights(p, [&](int node, double phi, const Vec<Dim>&) {
        const auto& sum = field.sum[node];
        if (sum[NF::mass] <= least) return;
        for (int k = 0; k < Dim; ++k) {
            const int c = field.holder[node][k];
            straining[k] +=
                phi * (c < 0 ? sum[NF::momentum + k] / sum[NF::mass] : scene.prescribed(c, k, scene.time));
        }
    });
    for (int k = 0; k < Dim; ++k) own[k] = soil.particles.velocity.plane(k)[p];
    return scene.dt * (straining - own);
}

// Where the surface of a point is, d from it, and the part q of its strain along d that the gap sees.
struct Arm {
    Vec3 d;
    double q;
};

// How far the place where friction acts has moved since the last step. A particle's own part is taken from its place: under FLIP its
// velocity is another one.
template <int Dim>
Vec3 movedSince(const Body<Dim>& soil, int index, const RigidTouch& t, const Arm& arm, double dt) {
    const Vec3 moved = t.point - t.before;
    if (soil.type->isMeshed()) return moved;
    return moved + dt * (gradientOf(soil, index) * arm.d);
}

// WorkPartition of a normal and a friction force, see above.
template <int Dim>
void addForce(const Body<Dim>& soil, int index, const Arm& arm, const Vec3& normal, const Vec3& friction,
              typename NodalField<Dim>::Sum* nodes) {
    using NF = NodalField<Dim>;
    if (soil.type->isMeshed())
        return soil.domains->addVertexForce(index, Vec<Dim>((normal + friction).template head<Dim>()), nodes);
    soil.domains->weights(index, [&](int node, double phi, const Vec<Dim>& gradient) {
        const double shift = gradient.dot(arm.d.head<Dim>());
        for (int k = 0; k < Dim; ++k)
            nodes[node].set(NF::force(k), nodes[node][NF::force(k)] + (phi + arm.q * shift) * normal[k] +
                                              (phi + shift) * friction[k]);
    });
}

} // namespace

// What the nodes get from each rigid body, added up on nodes of its own, against what the body gets.
template <int Dim> class RigidContact::Balance {
  public:
    using NF = NodalField<Dim>;

    Balance(const Scene<Dim>& scene, int bodies) : scene_(scene), nodes_(bodies) {}

    void add(const Body<Dim>& soil, int body, int index, const Arm& arm, const Vec3& normal,
             const Vec3& friction) {
        if (nodes_[body].empty()) nodes_[body].assign(scene_.grid.count, NF::Sum::zero());
        addForce(soil, index, arm, normal, friction, nodes_[body].data());
    }

    void check(const RigidContact& engine) const {
        for (size_t b = 0; b < nodes_.size(); ++b) {
            Vec3 force = vectorAt<3>(engine.forces, int(b)), torque = vectorAt<3>(engine.torques, int(b));
            double size = 0, moments = 0;
            for (int node = 0; node < int(nodes_[b].size()); ++node) {
                Vec3 f = Vec3::Zero(), x = Vec3::Zero();
                for (int k = 0; k < Dim; ++k) f[k] = NF::forceOf(nodes_[b][node], k);
                if (f.isZero(0)) continue;
                x.head<Dim>() = scene_.grid.nodePosition(node);
                const Vec3 arm = x - engine.state_[b].position;
                force += f, torque += arm.cross(f);
                size += f.norm(), moments += arm.norm() * f.norm();
            }
            if (force.norm() <= 1e-12 * size && torque.norm() <= 1e-12 * moments) continue;
            throw RunError(message("step ", scene_.step, ": RigidContact: rigid body ", b,
                                   " and the nodes differ by ", force.norm(), " kN of ", size, " and ",
                                   torque.norm(), " kN m of ", moments, "; this is an error in the solver"));
        }
    }

  private:
    const Scene<Dim>& scene_;
    std::vector<std::vector<typename NF::Sum>> nodes_;
};

std::string RigidContact::doc() const {
    return "Frictional contact of rigid bodies with all bodies of the scene: penalty, Coulomb friction with history.\n\n"
           "Force of a point with area A, gap g < 0 and slip s: A (-kappa g n - kappa_t s), friction at most mu times the\n"
           "normal part, no attraction. Points are uGIMP boxes and boundary vertices of APDI domains. Stands between\n"
           "ParticleToGrid (USF: DomainUpdater) and GridSolver. Sources: Cundall & Strack 1979; doc/rigid-contact.md.";
}

std::vector<Parameter> RigidContact::attributes() {
    return {
        {"friction", "-", "Friction coefficient of each rigid body; 0: exactly none.", &friction,
         Range::notNegative()},
        {"stiffness", "kPa/m",
         "Normal stiffness per area; left out: stiffnessFactor m/(A dt^2) of the lightest point.", &stiffness,
         Range::positive()},
        {"stiffnessFactor",
         "-",
         "Stiffness of the contact of the lightest point over m/dt^2. Stable for certain up to "
         "4 [1 - (dt/dtCritical)^2] over the larger of 1 + 2 l/h and shearRatio (1 + 2 Dim l/h), l the half size of a "
         "box, h the cell (vertices: over 1).",
         &stiffnessFactor,
         {0, 1, true, false}},
        {"shearRatio", "-", "Tangential over normal stiffness.", &shearRatio, {0, 1, true, false}},
        {"normalDamping", "-", "Viscous damping of the normal motion over the critical one of a point.",
         &normalDamping, Range::between(0, 1)},
        {"checkBalance", "",
         "Compare force and moment of every rigid body with the sum over the nodes in every step.",
         &checkBalance},
        {"frictionWork", "kJ", "Work lost to friction since the start.", &frictionWork},
        {"shapes", "", "Shapes of the rigid bodies, 12 numbers each; made by addBody.", &shapes},
        {"states", "", "Position, orientation, velocity and angular velocity, 13 numbers per rigid body.",
         &states},
        {"history", "", "Contacts of the last step, 16 numbers each.", &history},
        {"sizes", "", "Particles of each body of the scene in the last step.", &sizes},
        {"impulses", "", "Integrals of force and torque over time, 6 numbers per rigid body.", &impulses}};
}

// Sizes follow the number of bodies, which is that of the friction coefficients.
void RigidContact::finish() {
    require(shapes.size() % RigidShape::size == 0, "RigidContact: shapes has ", shapes.size(),
            " entries; use addBody");
    require(int(states.size()) == RigidState::size * bodies() && int(impulses.size()) == 6 * bodies() &&
                history.size() % RigidTouch::size == 0,
            "RigidContact: friction has ", bodies(), " entries for ", states.size() / RigidState::size,
            " rigid bodies; give one per body");
    if (forces.size() != bodies()) forces.resize(bodies()), torques.resize(bodies());
    shape_.clear();
    for (size_t s = 0; s < shapes.size(); s += RigidShape::size) shape_.emplace_back(&shapes[s], 3);
}

void RigidContact::setStates(const std::vector<double>& positions, const std::vector<double>& orientations,
                             const std::vector<double>& velocities,
                             const std::vector<double>& angularVelocities) {
    const std::vector<double>* const given[] = {&positions, &orientations, &velocities, &angularVelocities};
    const char* const name[] = {"positions", "orientations", "velocities", "angularVelocities"};
    for (int g = 0; g < 4; ++g) {
        const int width = g == 1 ? 4 : 3;
        require(int(given[g]->size()) == width * bodies(), "RigidContact: ", name[g], " has ",
                given[g]->size(), " numbers; give (", bodies(), ", ", width, "), a row for each rigid body");
    }
    std::vector<double> rows;
    for (int b = 0; b < bodies(); ++b)
        for (int g = 0; g < 4; ++g) {
            const int width = g == 1 ? 4 : 3;
            rows.insert(rows.end(), given[g]->begin() + width * b, given[g]->begin() + width * (b + 1));
        }
    for (int b = 0; b < bodies(); ++b) checkState(b, &rows[RigidState::size * b]);
    for (int b = 0; b < bodies(); ++b) setState(b, &rows[RigidState::size * b]);
}

void RigidContact::setState(int body, const double* state) {
    checkState(body, state);
    double* to = &states[RigidState::size * body];
    std::copy(state, state + RigidState::size, to);
    Eigen::Map<Eigen::Vector4d>(to + 3).normalize();
}

void RigidContact::checkState(int body, const double* state) const {
    static const char* const name[] = {"position", "orientation", "velocity", "angular velocity"};
    for (int k = 0; k < RigidState::size; ++k)
        require(std::isfinite(state[k]), "RigidContact: the ",
                name[k < 3    ? 0
                     : k < 7  ? 1
                     : k < 10 ? 2
                              : 3],
                " of rigid body ", body, " is not finite; give numbers");
    const double norm = Eigen::Map<const Eigen::Vector4d>(state + 3).norm();
    require(std::abs(norm - 1) < 1e-6, "RigidContact: the orientation of rigid body ", body, " has the norm ",
            norm, "; give a unit quaternion (w, x, y, z)");
}

template <int Dim> void RigidContact::check(Scene<Dim>& scene) {
    require(bodies() > 0, "RigidContact: there is no rigid body; add one with addBody(shapes=[...])");
    bool isAnyMeshed = false;
    for (auto& soil : scene.bodies) isAnyMeshed |= soil->type->isMeshed();
    shape_.clear();
    for (size_t s = 0; s < shapes.size(); s += RigidShape::size) {
        shape_.emplace_back(&shapes[s], Dim);
        require(!isAnyMeshed || !shape_.back().isThin() || shape_.back().thickness() > 0,
                "RigidContact: a facet of rigid body ", shape_.back().body,
                " has no thickness, and vertices of APDI bodies would slip through; give it a thickness");
        require(Dim == 3 || shape_.back().kind != RigidShape::Triangle, "RigidContact: rigid body ",
                shape_.back().body, " has a facet with three vertices in a 2D scene; give two");
    }
    for (int b = 0; Dim == 2 && b < bodies(); ++b) {
        const double* s = &states[RigidState::size * b];
        require(std::abs(s[4]) + std::abs(s[5]) < 1e-9, "RigidContact: rigid body ", b,
                " is turned out of the plane; a 2D scene takes rotation about z only");
    }
}

// kappa = factor min(m/A)/dt^2. By Jensen's inequality the nodes see no higher frequency than the points alone, for any number
// of contacts at once: omega^2 <= kappa A/m, for boxes of half size l times 1 + 2 l/h; of friction kappa_t A/m (1 + 2 Dim l/h).
template <int Dim>
double RigidContact::chooseStiffness(const Scene<Dim>& scene,
                                     const std::vector<TouchPoints<Dim>>& points) const {
    double least = 1e300;
    for (auto& p : points)
        if (p.count() > 0) least = std::min(least, p.massPerArea());
    const double most = least / (scene.dt * scene.dt);
    if (std::isnan(stiffness)) return stiffnessFactor * most;
    require(stiffness <= most, "RigidContact: stiffness = ", stiffness, " kPa/m is unstable; give at most ",
            most, " for dt = ", scene.dt, " s, or lower dt");
    return stiffness;
}

template <int Dim>
Reach RigidContact::reachOf(const Scene<Dim>& scene, const std::vector<TouchPoints<Dim>>& points) const {
    const double far = std::numeric_limits<double>::infinity();
    Reach reach{Vec3::Constant(-far), Vec3::Constant(far), scene.grid.cell.maxCoeff()};
    reach.lower.template head<Dim>().setConstant(far), reach.upper.template head<Dim>().setConstant(-far);
    for (auto& p : points) p.widen(scene.grid, reach.lower, reach.upper);
    return reach;
}

// Points that overlap or nearly do.
template <int Dim>
std::vector<RigidTouch> RigidContact::find(const Scene<Dim>& scene,
                                           const std::vector<TouchPoints<Dim>>& points) const {
    const double near = TouchPoints<Dim>::mostShift * scene.grid.cell.minCoeff();
    std::vector<RigidTouch> touches;
    touches.reserve(2 * history.size() / RigidTouch::size + 16);
    for (const RigidShape& shape : shape_) {
        const RigidState& at = state_[shape.body];
        const Mat<3> R = at.orientation.toRotationMatrix();
        for (int soil = 0; soil < int(points.size()); ++soil)
            points[soil].near(shape, at, scene.grid, [&](int i) {
                const Vec3 x = points[soil].position(i);
                const Vec3 local = R.transpose() * (x - at.position);
                double gap = -1e300;
                Vec3 n;
                shape.directions(local, [&](const Surface& s) {
                    const Vec3 normal = R * s.normal;
                    const double clear = s.distance - points[soil].halfAlong(normal);
                    if (clear > gap) gap = clear, n = normal;
                });
                const double half = points[soil].halfAlong(n);
                if (gap >= near + TouchPoints<Dim>::mostStretch * half) return;
                gap -= half * (points[soil].stretch(i, n).factor - 1);
                if (gap >= near) return;
                const Surface s = shape.nearest(local);
                touches.push_back({soil, shape.body, points[soil].id(i), n, Vec3::Zero(), x, gap,
                                   Vec3::Zero(), i, int(&shape - shape_.data()),
                                   local - s.distance * s.normal, Vec3::Zero(), Vec3::Constant(notGiven)});
            });
    }
    return touches;
}

// Of points that nearly overlap, those that do.
template <int Dim>
void RigidContact::moveToStrainedPlaces(const Scene<Dim>& scene, std::vector<RigidTouch>& touches) const {
    const double least = roundOff * scene.grid.cell.minCoeff();
    for (RigidTouch& t : touches) {
        const Vec3 shift = toStrainedPlace(scene, *scene.bodies[t.soil], t.place);
        t.point += shift, t.gap += t.normal.dot(shift);
    }
    touches.erase(
        std::remove_if(touches.begin(), touches.end(), [&](const RigidTouch& t) { return t.gap >= -least; }),
        touches.end());
}

// Of the touches of a pair that look the same way only the deepest counts (flush boxes of a clump, neighbouring facets), and none
// at an edge that is hidden in the surface of a shape which is touched more deeply.
void RigidContact::dropRepeats(std::vector<RigidTouch>& touches) const {
    std::vector<const RigidTouch*> sorted; // a touch is too large to be sorted itself
    for (const RigidTouch& t : touches) sorted.push_back(&t);
    std::sort(sorted.begin(), sorted.end(), [](const RigidTouch* a, const RigidTouch* b) {
        const auto key = [](const RigidTouch* t) {
            return std::tie(t->soil, t->id, t->body, t->gap, t->shape);
        };
        return key(a) < key(b);
    });
    std::vector<RigidTouch> kept;
    kept.reserve(touches.size());
    for (const RigidTouch* t : sorted) {
        bool isRepeat = false;
        for (size_t k = kept.size(); k-- > 0 && isSamePair(kept[k], *t);)
            isRepeat |= kept[k].normal.dot(t->normal) > sameSide ||
                        shape_[kept[k].shape].nearest(t->edge).distance < -kept[k].gap;
        if (!isRepeat) kept.push_back(*t);
    }
    touches.swap(kept);
}

// Vertices have new numbers after domains were converted; particles keep theirs.
template <int Dim> void RigidContact::forgetRenumbered(const Scene<Dim>& scene) {
    std::vector<double> now, kept;
    for (auto& soil : scene.bodies) now.push_back(soil->particles.size());
    if (now == sizes) return;
    for (auto row = history.begin(); row != history.end(); row += RigidTouch::size) {
        const int soil = int(*row);
        if (sizes.at(soil) == now[soil] || !scene.bodies[soil]->type->isMeshed())
            kept.insert(kept.end(), row, row + RigidTouch::size);
    }
    history.swap(kept);
    sizes = now;
}

// Slip and last place of touches that were there in the step before; the slip turns with the normal.
void RigidContact::remember(std::vector<RigidTouch>& touches) const {
    const auto key = [](const double* row) {
        return std::make_tuple(int(row[0]), int64_t(row[2]), int(row[1]));
    };
    const double *row = history.data(), *const end = row + history.size();
    for (RigidTouch& t : touches) {
        const auto mine = std::make_tuple(t.soil, t.id, t.body);
        while (row != end && key(row) < mine) row += RigidTouch::size;
        double nearest = sameSide;
        for (const double* same = row; same != end && key(same) == mine; same += RigidTouch::size) {
            const Vec3 normal = Vec3::Map(same + 3);
            if (normal.dot(t.normal) <= nearest) continue;
            nearest = normal.dot(t.normal);
            t.slip = turned(Vec3::Map(same + 6), normal, t.normal), t.before = Vec3::Map(same + 9),
            t.forceBefore = Vec3::Map(same + 13);
            t.gapBefore = same[12];
        }
    }
}

// Where the points of the scene and the rigid bodies are.
template <int Dim> std::vector<TouchPoints<Dim>>& RigidContact::look(Scene<Dim>& scene) {
    auto& points = std::get<Points<Dim>>(points_).of;
    points.resize(scene.bodies.size());
    for (size_t s = 0; s < points.size(); ++s) points[s].update(*scene.bodies[s], scene.grid);
    state_.clear();
    for (int b = 0; b < bodies(); ++b) state_.emplace_back(&states[RigidState::size * b]);
    return points;
}

template <int Dim> std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<Dim>& scene) {
    std::vector<Overlap> deepest;
    for (int b = 0; b < bodies(); ++b) deepest.push_back({b, 0, 0.0});
    std::vector<RigidTouch> touches = find(scene, look(scene));
    dropRepeats(touches);
    for (const RigidTouch& t : touches)
        if (-t.gap > deepest[t.body].depth) deepest[t.body] = {t.body, t.soil, -t.gap};
    deepest.erase(
        std::remove_if(deepest.begin(), deepest.end(), [](const Overlap& o) { return o.depth == 0; }),
        deepest.end());
    return deepest;
}

template <int Dim> void RigidContact::act(Scene<Dim>& scene) {
    const auto& points = look(scene);
    reach = reachOf(scene, points);
    stiffnessUsed = chooseStiffness(scene, points);
    std::vector<RigidTouch> touches = find(scene, points);
    moveToStrainedPlaces(scene, touches);
    dropRepeats(touches);
    forgetRenumbered(scene);
    remember(touches);

    forces.fill(0), torques.fill(0), largestPenetration = 0, sliding = 0;
    Balance<Dim> balance(scene, checkBalance ? bodies() : 0);
    for (RigidTouch& t : touches) push(scene, points[t.soil], t, balance);
    if (checkBalance) balance.check(*this);
    pack(touches);
    for (int b = 0; b < bodies(); ++b) {
        for (int k = 0; k < 3; ++k) {
            impulses[6 * b + k] += scene.dt * forces.plane(k)[b];
            impulses[6 * b + 3 + k] += scene.dt * torques.plane(k)[b];
        }
        state_[b].advance(scene.dt, &states[RigidState::size * b]);
    }
}

// The force of one touch, on the nodes and on the rigid body.
template <int Dim>
void RigidContact::push(Scene<Dim>& scene, const TouchPoints<Dim>& points, RigidTouch& t,
                        Balance<Dim>& balance) {
    const Body<Dim>& soil = *scene.bodies[t.soil];
    const RigidState& rigid = state_[t.body];
    const int index = points.index(t.place);
    const Vec3 n = t.normal;
    const double out = points.exitAlong(n);
    const Arm arm{-out * n, out > 0 ? points.stretch(t.place, n).rate * points.halfAlong(n) / out : 0};
    const Vec3 at = points.position(t.place) + arm.d; // where the nodes find it
    const double area = points.area(t.place, n), kn = stiffnessUsed * area, kt = shearRatio * kn;

    const bool isOld = t.before.allFinite();
    const Vec3 carried = scene.dt * rigid.velocityAt(at);
    const Vec3 slid = isOld ? Vec3(movedSince(soil, index, t, arm, scene.dt) - carried) : Vec3(Vec3::Zero());
    const double opened = isOld ? t.gap - t.gapBefore : 0;
    const double viscous = 2 * normalDamping * std::sqrt(kn * points.mass(t.place)) * opened / scene.dt;
    const double normal = std::max(0.0, -kn * t.gap - viscous);
    const Vec3 along = slid - slid.dot(n) * n;
    t.slip += along;
    if (const double most = friction[t.body] * normal / kt, length = t.slip.norm(); length > most) {
        frictionWork += kt * most * (length - most);
        t.slip *= most / length, ++sliding;
    }
    const Vec3 pushed = normal * n, dragged = -kt * t.slip;
    t.force = pushed + dragged;

    addForce(soil, index, arm, pushed, dragged, scene.grid.fields[soil.velocityField].sum.data());
    if (checkBalance) balance.add(soil, t.body, index, arm, pushed, dragged);
    const Vec3 torque = (at - rigid.position).cross(t.force);
    for (int k = 0; k < 3; ++k) forces.plane(k)[t.body] -= t.force[k], torques.plane(k)[t.body] -= torque[k];
    if (isOld) scene.energies.loads += 0.5 * (t.forceBefore + t.force).dot(opened * n + along + carried);
    largestPenetration = std::max(largestPenetration, -t.gap);
}

void RigidContact::pack(const std::vector<RigidTouch>& touches) {
    history.resize(RigidTouch::size * touches.size());
    double* row = history.data();
    for (const RigidTouch& t : touches) {
        row[0] = t.soil, row[1] = t.body, row[2] = double(t.id);
        Vec3::Map(row + 3) = t.normal, Vec3::Map(row + 6) = t.slip, Vec3::Map(row + 9) = t.point;
        row[12] = t.gap, Vec3::Map(row + 13) = t.force;
        row += RigidTouch::size;
    }
}

template void RigidContact::act<2>(Scene<2>&);
template void RigidContact::act<3>(Scene<3>&);
template std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<2>&);
template std::vector<RigidContact::Overlap> RigidContact::overlaps(Scene<3>&);

MPM_REGISTER(Engine, RigidContact);

} // namespace mpm
