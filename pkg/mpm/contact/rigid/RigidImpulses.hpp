// SPDX-License-Identifier: GPL-2.0-or-later
// The contact of rigid bodies without softness: impulses J_c at the sites, the points in touch, after which
// no surface approaches its body. With the velocities v_i that the nodes would have without contact, the
// weights S_ci of a force at a site, the inverse masses Y_i of the nodes (zero where they are held) and Y_b of
// the body (6 x 6; zero where it does not yield), and V_b at the site,
//     u_c = sum_i S_ci v_i - V_b,    v_i += Y_i S_ci J_c,    V_b -= Y_b J_c,
//     0 <= J_n  perp  n . u_c + gap/dt >= 0,    |J_t| <= mu J_n + c_a A dt, else u_t = 0.
// Of an overlap, and of the slip that friction has not stopped, `returned` goes back in a step. No site comes
// before another: each takes (D is the sum of its row of couplings, so that the sum of all never goes too far)
//     J_c <- limited(J_c - (u_c - wanted)/D_c),    D_c = sum_i S_ci Y_i sum_c' S_c'i,
// from most of the impulses of the step before on, until no more than `settled` of them changes. The velocity that
// strains the soil, mapped back from the particles (MUSL), is tied by the same rule: what pressed in the step
// does not part, what stuck does not slip. Without it surfaces would give way to their pressure, and gain its work.
#pragma once

#include "mpm/contact/rigid/RigidMass.hpp"
#include "mpm/scene/Scene.hpp"

namespace mpm {

// A point in touch. impulse: on the soil; in: that of the step before.
struct RigidSite {
    int body = 0;
    Vec3 normal = Vec3::Zero(), arm = Vec3::Zero(); // m, from the position of the body
    Vec3 slip = Vec3::Zero(), impulse = Vec3::Zero();
    double gap = 0, friction = 0, borne = 0; // borne: by adhesion, kN s
    bool slides = false;

    double pushed() const { return impulse.dot(normal); }
};

template <int Dim> class RigidImpulses {
  public:
    using NF = NodalField<Dim>;

    void begin(const Scene<Dim>& scene, const std::vector<RigidState>& states,
               const std::vector<RigidMass>& masses) {
        scene_ = &scene;
        gravity_ = gravityOf(scene);
        asked_ = 0;
        sites_.clear();
        parts_.clear();
        for (const Node& node : nodes_) place_[node.field][node.number] = -1; // of the step before
        nodes_.clear();
        place_.resize(scene.grid.fields.size());
        for (auto& of : place_) of.resize(scene.grid.count, -1);
        bodies_.resize(states.size());
        for (size_t b = 0; b < states.size(); ++b)
            bodies_[b] = {states[b].velocity,
                          states[b].angularVelocity,
                          masses[b].inverse,
                          masses[b].inverseInertiaAt(states[b].orientation),
                          0.0,
                          0.0};
    }

    // Adds a site whose forces reach nodes of that field: forNodes(f) calls f(node, weight of a normal force,
    // of a tangential one), a node as often as it likes. Returns its number; -1: it is not pressed in this
    // step, and would not be.
    template <class ForNodes> int add(RigidSite site, int field, ForNodes&& forNodes) {
        const int first = int(parts_.size()), number = ++asked_;
        forNodes([&](int node, double normal, double sideways) {
            const int at = placeOf(field, node);
            Node& there = nodes_[at];
            if (there.site != number) {
                there.site = number;
                there.part = int(parts_.size());
                parts_.push_back({at, 0, 0});
            }
            parts_[there.part].normal += normal;
            parts_[there.part].sideways += sideways;
        });
        sites_.push_back({site, first, int(parts_.size()), 0.0, Vec3::Zero(), false, false});
        Row& row = sites_.back();
        const bool approaches = scene_->dt * rateOf(row).dot(site.normal) + site.gap < 0;
        if (approaches || site.impulse.dot(site.normal) > 0) return int(sites_.size()) - 1;
        sites_.pop_back();
        parts_.resize(first);
        return -1;
    }

    void solve() {
        scale();
        for (Row& row : sites_) {
            row.site.impulse *= remembered;
            give(row, row.site.impulse);
        }
        sweep([&](Row& row) { return better(row); });
    }

    const RigidSite& operator[](int site) const { return sites_[site].site; }

    // Of the velocities that strain the soil. The bodies have theirs.
    void tie(Scene<Dim>& scene) {
        for (Node& node : nodes_) {
            for (int k = 0; k < Dim; ++k)
                node.v[k] = scene.grid.fields[node.field].velocityOf(node.number, k);
            node.load = 0;
        }
        for (Moving& body : bodies_) {
            body.inverse = body.count = body.arms = 0;
            body.inverseInertia.setZero();
        }
        for (Row& row : sites_) {
            row.isPressed = row.site.pushed() > 0;
            row.sticks = row.isPressed && !row.site.slides && row.site.friction + row.site.borne > 0;
            row.site.impulse.setZero();
        }
        scale();
        sweep([&](Row& row) { return tied(row); });
        for (const Node& node : nodes_)
            for (int k = 0; k < Dim; ++k)
                scene.grid.fields[node.field].setVelocity(node.number, k, node.v[k]);
    }

  private:
    static constexpr int mostSweeps = 20;
    static constexpr double settled = 1e-3, returned = 0.2;
    // Part of the impulses of the step before that a step begins with: what no motion of the nodes tells apart fades.
    static constexpr double remembered = 0.9;

    struct Node {
        int field, number;
        Vec3 v, inverse;        // m/s; 1/Mg
        double load = 0;        // sum of the weights of all sites
        int site = 0, part = 0; // that has reached it last
    };
    struct Part {
        int node;
        double normal, sideways;
        double size() const { return std::max(std::abs(normal), std::abs(sideways)); }
    };
    struct Row {
        RigidSite site;
        int first, last; // of parts_
        double scale = 0;
        Vec3 next = Vec3::Zero();
        bool isPressed = false, sticks = false; // in this step
    };
    struct Moving {
        Vec3 v, w;
        double inverse;
        Mat<3> inverseInertia;
        double count, arms; // of its sites
    };
    const Scene<Dim>* scene_ = nullptr;
    Vec<Dim> gravity_;
    int asked_ = 0; // times that a site was added in this step
    std::vector<Row> sites_;
    std::vector<Part> parts_;
    std::vector<Node> nodes_;
    std::vector<Moving> bodies_;
    std::vector<std::vector<int>> place_; // of the nodes of each field in nodes_, -1: not there

    // The node with the velocity that the solver would give it without contact.
    int placeOf(int field, int number) {
        int& at = place_[field][number];
        if (at >= 0) return at;
        at = int(nodes_.size());
        const auto& of = scene_->grid.fields[field];
        const auto& sum = of.sum[number];
        Node node{field, number, Vec3::Zero(), Vec3::Zero(), 0.0, 0, 0};
        const bool isThere = sum[NF::mass] > scene_->leastMass();
        const Vec<Dim> force = NF::forceOf(sum);
        for (int k = 0; k < Dim && isThere; ++k) {
            const double all = force[k] + sum[NF::weightMass] * gravity_[k];
            const int holder = of.holder[number][k];
            node.v[k] = holder < 0 ? NF::velocityAtStart(sum, k) + scene_->dt * all / sum[NF::mass]
                                   : scene_->heldAtEnd(holder, k);
            node.inverse[k] = holder < 0 ? 1 / sum[NF::mass] : 0;
        }
        nodes_.push_back(node);
        return at;
    }

    // How fast the soil moves against the body.
    Vec3 rateOf(const Row& row) const {
        Vec3 normal = Vec3::Zero(), sideways = Vec3::Zero();
        for (int i = row.first; i < row.last; ++i) {
            const Vec3& v = nodes_[parts_[i].node].v;
            normal += parts_[i].normal * v;
            sideways += parts_[i].sideways * v;
        }
        const Moving& body = bodies_[row.site.body];
        const Vec3& n = row.site.normal;
        return sideways + n.dot(normal - sideways) * n - body.v - body.w.cross(row.site.arm);
    }

    void give(Row& row, const Vec3& impulse) {
        const Vec3 normal = row.site.normal.dot(impulse) * row.site.normal, sideways = impulse - normal;
        for (int i = row.first; i < row.last; ++i) {
            Node& node = nodes_[parts_[i].node];
            node.v += node.inverse.cwiseProduct(parts_[i].normal * normal + parts_[i].sideways * sideways);
        }
        Moving& body = bodies_[row.site.body];
        if (body.inverse == 0) return;
        body.v -= body.inverse * impulse;
        body.w -= body.inverseInertia * row.site.arm.cross(impulse);
    }

    template <class Better> void sweep(Better&& better) {
        for (int sweep = 0; sweep < mostSweeps; ++sweep) {
            double change = 0, all = 0;
            for (Row& row : sites_) {
                row.next = better(row);
                change += (row.next - row.site.impulse).squaredNorm();
                all += row.next.squaredNorm();
            }
            for (Row& row : sites_) {
                give(row, row.next - row.site.impulse);
                row.site.impulse = row.next;
            }
            if (change <= settled * settled * all) break;
        }
    }

    // The sums of the rows.
    void scale() {
        for (const Row& row : sites_) {
            for (int i = row.first; i < row.last; ++i) nodes_[parts_[i].node].load += parts_[i].size();
            bodies_[row.site.body].count += 1;
            bodies_[row.site.body].arms += row.site.arm.norm();
        }
        for (Row& row : sites_) {
            const Moving& body = bodies_[row.site.body];
            row.scale = body.inverse * body.count +
                        body.inverseInertia.cwiseAbs().maxCoeff() * row.site.arm.norm() * body.arms;
            for (int i = row.first; i < row.last; ++i) {
                const Node& node = nodes_[parts_[i].node];
                row.scale += parts_[i].size() * node.load * node.inverse.maxCoeff();
            }
        }
    }

    // m/s along the normal.
    double wanted(const RigidSite& site) const {
        return (site.gap > 0 ? -1 : -returned) * site.gap / scene_->dt;
    }
    static Vec3 along(const RigidSite& site, const Vec3& v) { return v - site.normal.dot(v) * site.normal; }

    Vec3 better(Row& row) const {
        RigidSite& site = row.site;
        if (!(row.scale > 0)) return Vec3::Zero(); // held on both sides
        const Vec3 rate = rateOf(row);
        const double pushed =
            std::max(0.0, site.pushed() + (wanted(site) - site.normal.dot(rate)) / row.scale);
        const bool touches = pushed > 0 || site.gap <= 0;
        const double most = site.friction * pushed + (touches ? site.borne : 0);
        site.slides = false;
        if (most == 0) return pushed * site.normal;
        Vec3 dragged = along(site, site.impulse - (rate + returned / scene_->dt * site.slip) / row.scale);
        const double size = dragged.norm();
        site.slides = size > most;
        if (site.slides) dragged *= most / size;
        return pushed * site.normal + dragged;
    }

    Vec3 tied(const Row& row) const {
        const RigidSite& site = row.site;
        if (!(row.scale > 0)) return Vec3::Zero();
        const Vec3 rate = rateOf(row);
        const double pushed = site.pushed() + (wanted(site) - site.normal.dot(rate)) / row.scale;
        const Vec3 normal = (row.isPressed ? pushed : std::max(0.0, pushed)) * site.normal;
        if (!row.sticks) return normal;
        return normal + along(site, site.impulse - (rate + returned / scene_->dt * site.slip) / row.scale);
    }
};

} // namespace mpm
