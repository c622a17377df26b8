// SPDX-License-Identifier: GPL-2.0-or-later
// The impulses of a step at all sites of contact, found together. All sites answer the same velocities at once, so
// their order does not count: mirror images of a scene have mirrored impulses, and several groups on a node are one
// problem. Each iteration is a step of an accelerated projected gradient (Nesterov 1983; restarts: O'Donoghue & Candes
// 2015): with the relative velocity w of impulses Y, and D, what a site answers if all sites push alike (the sum of its
// row of the Delassus matrix),
//     J' = law(Y + w(Y)/D),   Y' = J' + beta (J' - J).
#pragma once

#include "mpm/contact/ContactSearch.hpp"
#include "mpm/contact/FrictionLaw.hpp"
#include "mpm/contact/ImplicitSides.hpp"

#include <map>

namespace mpm {

// What the groups of a pair have exchanged on a contact node.
template <int Dim> struct NodeMotion {
    int group[2];       // numbers of their motions
    Impulses<Dim> J[2]; // what the first one loses, and what the second one gets
};

template <int Dim> class ContactImpulses {
  public:
    std::vector<GroupMotion<Dim>> groups; // each that a pair moves on a node of the grid
    std::vector<NodeMotion<Dim>> nodes;   // a row for each contact node of the search
    ImplicitSides<Dim> implicit;

    const Vec<Dim>& velocityOf(const NodeMotion<Dim>& node, int side) const {
        return groups[node.group[side]].v;
    }

    // The groups on the nodes of the search, at rest.
    void place(const ContactSearch<Dim>& search);
    // lawOf(pair, site): the friction law there. Returns whether the iterations have come to an end of their own.
    template <class LawOf> bool solve(ContactSearch<Dim>& search, double dt, LawOf&& lawOf);
    // Energy, kJ, that the impulses take from the motion of the nodes: J . w - J . mobility J / 2, w from before the
    // exchange. Frictionless iterations never give any, finished ones neither. Adhesion and friction that come and go
    // between iterations might: then `isReduced`, and the part of all impulses is left that takes most.
    double limitEnergy(bool& isReduced);

  private:
    // Iterations; some 20 are taken, a hundred and more where a body is light and stiff.
    static constexpr int most = 300;
    // Size of a step of the gradient over that of the impulses, by energy, below which they are done.
    static constexpr double convergence = 1e-4;

    static constexpr double roundOff = 1e-9;

    // The motion of the surface of a group at a site: S times that of the group; negative for the first group.
    struct Part {
        int group;
        double S;
    };
    // A site, and its mobility: D. Relative velocities are those of the first group against the second.
    struct Row {
        ContactSite<Dim>* site; // has Y while iterations go on
        FrictionLaw law;
        int begin, end; // of its parts
        Vec<Dim> D, startD;
        Vec<Dim> free;             // velocity before all impulses
        Impulses<Dim> J, next;     // of the last two iterations,
        Vec<Dim> w, nextW, wOfY;   // and the velocities that they leave:
        Vec<Dim> start, nextStart; // of the solution and of the start
    };
    std::vector<Row> rows_;
    std::vector<Part> parts_;

    template <class LawOf> void findRows(ContactSearch<Dim>& search, LawOf&& lawOf);
    bool isDecoupled() const;
    void weigh();
    void project(double dt, double beta, double scale);
    void move();
    Vec<Dim> velocityAt(const Row& row, Vec<Dim> GroupMotion<Dim>::* velocity) const {
        Vec<Dim> w = Vec<Dim>::Zero();
        for (int p = row.begin; p < row.end; ++p) w -= parts_[p].S * (groups[parts_[p].group].*velocity);
        return w;
    }
    void tellNodes(ContactSearch<Dim>& search);
};

template <int Dim> void ContactImpulses<Dim>::place(const ContactSearch<Dim>& search) {
    groups.clear();
    nodes.assign(search.nodes.size(), {});
    std::map<std::pair<int, int>, int> known; // by velocity field and node
    for (size_t i = 0; i < nodes.size(); ++i)
        for (int side = 0; side < 2; ++side) {
            const int field = search.nodes[i].field[side], node = search.nodes[i].node;
            int number = int(groups.size());
            if (search.pairs.size() > 1) number = known.try_emplace({field, node}, number).first->second;
            if (number == int(groups.size())) {
                groups.emplace_back();
                groups.back().field = field;
                groups.back().node = node;
            }
            nodes[i].group[side] = number;
        }
}

template <int Dim>
template <class LawOf>
void ContactImpulses<Dim>::findRows(ContactSearch<Dim>& search, LawOf&& lawOf) {
    rows_.clear();
    parts_.clear();
    const auto add = [&](ContactSite<Dim>& site, const FrictionLaw& law, const SiteNodes<Dim>& at) {
        Row row;
        row.site = &site;
        row.law = law;
        row.begin = int(parts_.size());
        for (int i = 0; i < at.count; ++i)
            for (int side = 0; side < 2; ++side)
                if (const double S = at.S[side][i]; S != 0)
                    parts_.push_back({nodes[at.at[i]].group[side], side == 0 ? -S : S});
        row.end = int(parts_.size());
        rows_.push_back(row);
    };
    const double one = 1;
    for (const ContactPair<Dim>& pair : search.pairs) {
        for (int i = int(pair.firstNode); i < int(pair.endNode); ++i)
            if (auto& node = search.nodes[i]; !node.isLeftOut)
                add(node, lawOf(pair, node), {1, &i, {&one, &one}});
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) {
            auto& point = search.points[i];
            const FrictionLaw law = lawOf(pair, point);
            // Else what shares a node stays together, and nothing crosses between nodes.
            if (law.separation) add(point, law, point.sites());
        }
    }
}

// Whether each group moves at one site alone.
template <int Dim> bool ContactImpulses<Dim>::isDecoupled() const {
    return implicit.isEmpty() && parts_.size() == groups.size();
}

// The sums of the rows of the Delassus matrix.
template <int Dim> void ContactImpulses<Dim>::weigh() {
    for (auto& group : groups) group.share = 0;
    for (const Part& part : parts_) groups[part.group].share += std::abs(part.S);
    implicit.weigh(groups);
    for (Row& row : rows_) {
        row.D = row.startD = Vec<Dim>::Zero();
        for (int p = row.begin; p < row.end; ++p) {
            const GroupMotion<Dim>& group = groups[parts_[p].group];
            const double weight = std::abs(parts_[p].S) * group.share;
            row.D += weight * group.inverseMass;
            row.startD += weight * group.startInverseMass;
        }
        row.J = row.next = {};
        row.free = row.w = row.nextW = velocityAt(row, &GroupMotion<Dim>::v);
        row.start = row.nextStart = velocityAt(row, &GroupMotion<Dim>::start);
    }
}

// The next impulses, from those and the velocities that lie beyond the last two by beta.
template <int Dim> void ContactImpulses<Dim>::project(double dt, double beta, double scale) {
    for (Row& row : rows_) {
        const auto beyond = [&](const Vec<Dim>& next, const Vec<Dim>& last) {
            return Vec<Dim>(next + beta * (next - last));
        };
        Impulses<Dim>& Y = row.site->J;
        Y.all = beyond(row.next.all, row.J.all);
        Y.agreeing = beyond(row.next.agreeing, row.J.agreeing);
        row.wOfY = beyond(row.nextW, row.w);
        const Vec<Dim> start = beyond(row.nextStart, row.start), D = scale * row.D;
        row.J = row.next;
        row.w = row.nextW;
        row.start = row.nextStart;
        row.next = {};
        if (Y.all.isZero(0) && row.law.isApart(*row.site, dt, row.wOfY)) continue;
        row.next = row.law.template impulses<Dim>(*row.site, dt, D.asDiagonal(), row.startD.asDiagonal(),
                                                  start + row.startD.cwiseProduct(Y.agreeing),
                                                  row.wOfY + D.cwiseProduct(Y.all));
    }
}

// The groups, by the next impulses.
template <int Dim> void ContactImpulses<Dim>::move() {
    for (auto& group : groups) group.taken = group.agreeing = Vec<Dim>::Zero();
    for (const Row& row : rows_)
        for (int p = row.begin; p < row.end; ++p) {
            GroupMotion<Dim>& group = groups[parts_[p].group];
            group.taken += parts_[p].S * row.next.all;
            group.agreeing += parts_[p].S * row.next.agreeing;
        }
    for (auto& group : groups) {
        group.start = group.first + group.startInverseMass.cwiseProduct(group.agreeing);
        if (group.responding < 0) group.v = group.free + group.inverseMass.cwiseProduct(group.taken);
    }
    implicit.move(groups);
}

template <int Dim>
template <class LawOf>
bool ContactImpulses<Dim>::solve(ContactSearch<Dim>& search, double dt, LawOf&& lawOf) {
    findRows(search, lawOf);
    weigh();
    const bool isOnce = isDecoupled();
    double t = 1, beta = 0, scale = 1;
    bool isSettled = false;
    for (int iteration = 0; iteration < most && !isSettled; ++iteration) {
        project(dt, beta, scale);
        move();
        double answered = 0, expected = 0, size = 0, turned = 0;
        for (Row& row : rows_) {
            row.nextW = velocityAt(row, &GroupMotion<Dim>::v);
            row.nextStart = velocityAt(row, &GroupMotion<Dim>::start);
            const Vec<Dim> step = row.next.all - row.site->J.all,
                           asExpected = scale * row.D.cwiseProduct(step);
            answered += step.dot(row.wOfY - row.nextW);
            expected += step.dot(asExpected);
            size += row.next.all.dot(row.free - row.nextW);
            turned -= asExpected.dot(row.next.all - row.J.all);
        }
        isSettled = isOnce || expected <= convergence * convergence * size;
        const double next = turned > 0 ? 1 : 0.5 * (1 + std::sqrt(1 + 4 * t * t)); // turned: begins anew
        beta = turned > 0 ? 0 : (t - 1) / next;
        t = next;
        // Bodies that answer more than D says: see ImpulseResponse::bound.
        if (answered > (1 + roundOff) * expected) scale *= answered / expected;
    }
    for (Row& row : rows_) row.site->J = row.next;
    tellNodes(search);
    return isSettled;
}

template <int Dim> double ContactImpulses<Dim>::limitEnergy(bool& isReduced) {
    double stopped = 0, answered = 0;
    for (const Row& row : rows_) {
        stopped += row.next.all.dot(row.free);
        answered += row.next.all.dot(row.free - row.nextW);
    }
    isReduced = !(stopped >= 0.5 * answered);
    if (!isReduced) return stopped - 0.5 * answered;
    const double part = stopped > 0 ? stopped / answered : 0;
    for (Row& row : rows_) {
        row.next.scale(part);
        row.site->J = row.next;
    }
    for (auto& node : nodes)
        for (auto& J : node.J) J.scale(part);
    move();
    return 0.5 * part * stopped;
}

template <int Dim> void ContactImpulses<Dim>::tellNodes(ContactSearch<Dim>& search) {
    const auto give = [&](int node, int side, double S, const Impulses<Dim>& J) {
        nodes[node].J[side].all += S * J.all;
        nodes[node].J[side].agreeing += S * J.agreeing;
    };
    for (const ContactPair<Dim>& pair : search.pairs) {
        for (size_t i = pair.firstNode; i < pair.endNode; ++i)
            for (int side = 0; side < 2; ++side) give(int(i), side, 1, search.nodes[i].J);
        for (size_t i = pair.firstPoint; i < pair.endPoint; ++i) {
            const SiteNodes<Dim> at = search.points[i].sites();
            for (int k = 0; k < at.count; ++k)
                for (int side = 0; side < 2; ++side) give(at.at[k], side, at.S[side][k], search.points[i].J);
        }
    }
}

} // namespace mpm
