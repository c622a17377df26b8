// SPDX-License-Identifier: GPL-2.0-or-later
// The impulse that two groups exchange where they are in contact. With the relative velocity w = (v_a - v_b)
// . n and the mobility 1/m_a + 1/m_b,
//     J_n = [w - max(g, 0)/dt] / (1/m_a + 1/m_b) where that is positive,   |J_t| <= mu J_n + adhesion A dt:
// surfaces may close a gap but not cross, and do not pull. Adhesion acts where the gap is closed. Where shared cells
// press the surfaces together with a force P (scene/SharedCells.hpp), it counts for friction, and the surfaces do not
// part before it is used up: J_n >= -P dt.
#pragma once

#include "mpm/contact/ContactNode.hpp"

#include <algorithm>

namespace mpm {

// A normal without the axes along which constraints hold both groups, isHeld(axis): there they do not push each other,
// and the impulse that stops what the normal sees of them would grow without bound. Zero where hardly any is left.
template <int Dim, class IsHeld> Vec<Dim> freePart(const Vec<Dim>& normal, IsHeld&& isHeld) {
    constexpr double least = 0.1; // below, what is left is how surfaces happen to tilt, no direction
    Vec<Dim> free = normal;
    for (int k = 0; k < Dim; ++k)
        if (free[k] != 0 && isHeld(k)) free[k] = 0;
    return free == normal ? normal : unit<Dim>(free, least);
}

struct FrictionLaw {
    double friction;         // -
    double adhesion;         // kPa
    bool slip;               // false: no slip whatever the friction
    bool separation;         // false: surfaces hold together, gap or not
    double impactLoss;       // -, part of the velocity with which groups meet that particles lose
    bool mayBeThree = false; // groups on a node

    // The impulses on the second group. mobility: of both groups together; zero where they are held. start, w:
    // relative velocities at the start and of the solution. startMobility: by the masses of the nodes alone, for
    // the start; implicit bodies have another one in the solution.
    template <int Dim>
    Impulses<Dim> impulses(const ContactSite<Dim>& site, double dt, const Mat<Dim>& mobility,
                           const Mat<Dim>& startMobility, const Vec<Dim>& start, const Vec<Dim>& w) const;

    // Whether there is no impulse where there was none, for the relative velocity w of the solution.
    template <int Dim> bool isApart(const ContactSite<Dim>& site, double dt, const Vec<Dim>& w) const {
        return separation && !site.presses && !(excess(site, w, dt) > 0) && !adheres(site) &&
               !(site.carried > 0);
    }

  private:
    // Whether adhesion acts whatever the approach: surfaces that touch shake, and part in many steps.
    template <int Dim> bool adheres(const ContactSite<Dim>& site) const {
        return adhesion > 0 && separation && site.gap <= 0 && !site.normal.isZero(0);
    }
    // What of the approach is faster than the gap allows in a step.
    template <int Dim> double excess(const ContactSite<Dim>& site, const Vec<Dim>& w, double dt) const {
        return w.dot(site.normal) - (separation ? std::max(site.gap + site.tolerated, 0.0) / dt : 0);
    }
    template <int Dim>
    double stopping(const ContactSite<Dim>& site, const Mat<Dim>& mobility, const Vec<Dim>& w,
                    double dt) const;
    // What keeps surfaces from parting, at most `carried`; an impulse on the second group, not positive.
    template <int Dim>
    static double holding(const ContactSite<Dim>& site, const Mat<Dim>& mobility, const Vec<Dim>& w,
                          double carried) {
        const double alongNormal = site.normal.dot(mobility * site.normal);
        return alongNormal > 0 ? std::clamp(w.dot(site.normal) / alongNormal, -carried, 0.0) : 0;
    }
};

// What stops an approach faster than the gap allows in a step, as an impulse on the second group. Surfaces that pressed
// on each other in this step do not part either in the velocities that are made anew: approach would strain nothing but
// parting would, and pressure times that rate is energy from nothing.
template <int Dim>
double FrictionLaw::stopping(const ContactSite<Dim>& site, const Mat<Dim>& mobility, const Vec<Dim>& w,
                             double dt) const {
    const double excess = this->excess(site, w, dt);
    const double alongNormal = site.normal.dot(mobility * site.normal);
    const bool isHeld = excess > 0 || !separation || site.presses;
    return isHeld && alongNormal > 0 ? excess / alongNormal : 0;
}

template <int Dim>
Impulses<Dim> FrictionLaw::impulses(const ContactSite<Dim>& site, double dt, const Mat<Dim>& mobility,
                                    const Mat<Dim>& startMobility, const Vec<Dim>& start,
                                    const Vec<Dim>& w) const {
    Impulses<Dim> J;
    if (!separation && !slip) { // one body
        J.all = site.J.all;
        for (int k = 0; k < Dim; ++k) {
            if (!(mobility(k, k) > 0)) continue;
            J.all[k] = 0; // Gauss-Seidel, for the components of an implicit body answer each other
            J.all[k] = (w[k] - mobility.row(k).dot(J.all)) / mobility(k, k);
            J.agreeing[k] = start[k] / startMobility(k, k);
        }
        J.sticks = true;
        return J;
    }
    const Vec<Dim>& n = site.normal;
    const auto across = [&](const Vec<Dim>& v) { return Vec<Dim>(v - v.dot(n) * n); };
    const Vec<Dim> borneSoFar = across(site.J.all); // by friction, which moves an implicit body along n, too
    const bool isFree = n.dot(mobility * n) > 0;
    const double carried = separation && isFree ? site.carried * dt : 0;
    double pushed = stopping(site, mobility, Vec<Dim>(w - mobility * borneSoFar), dt);
    if (pushed == 0 && carried > 0) {
        pushed = holding(site, mobility, Vec<Dim>(w - mobility * borneSoFar), carried);
        J.parts = pushed == -carried; // all of it, as holding() clamps it
    }
    if (pushed == 0 && carried == 0 && !adheres(site)) return J;
    // The starts of surfaces that part need not agree: with that, particles would not feel what holds them. Where they
    // take all of it (impactLoss = 1), it tells only what is lost; and beside a third group soil that parts from two
    // would get faster and faster.
    const bool mayDisagree = J.parts && impactLoss < 1 && !mayBeThree;
    const double agreed = mayDisagree                 ? 0
                          : pushed < 0 && carried > 0 ? holding(site, startMobility, start, -pushed)
                          : separation ? std::min(stopping(site, startMobility, start, dt), pushed)
                                       : stopping(site, startMobility, start, dt);
    J.all = pushed * n;
    J.agreeing = agreed * n;
    const Vec<Dim> slipping = across(w - mobility * (J.all + borneSoFar));
    // Twice, for of round-off the first leaves some of what is along n.
    const auto direction = [&](const Vec<Dim>& v) { return unit(across(unit(v, 0.0)), 0.0); };
    const Vec<Dim> t = direction(slipping.isZero(0) ? borneSoFar : slipping);
    const double along = t.dot(mobility * t); // 0: constraints hold both
    const double borne = adhesion * site.area * dt;
    const double limit = friction * std::max(pushed - (1 - impactLoss) * agreed + carried, 0.0) + borne;
    J.sticks =
        t.isZero(0) && (!slip || limit > 0); // without a limit nothing does, be its slip zero or round-off
    if (t.isZero(0) || !(along > 0 || slip)) return J;
    if (!(along > 0)) {
        J.all += limit * t;
        return J;
    }
    const Vec<Dim> stopped = borneSoFar + slipping / along;
    const Vec<Dim> slippingBefore = across(start - startMobility * J.agreeing);
    const Vec<Dim> tBefore = direction(slippingBefore);
    const double alongBefore = tBefore.dot(startMobility * tBefore);
    const Vec<Dim> stoppedBefore =
        alongBefore > 0 ? Vec<Dim>(slippingBefore / alongBefore) : Vec<Dim>(Vec<Dim>::Zero());
    J.sticks = !slip || (stopped.norm() <= friction * std::max(pushed + carried, 0.0) + borne &&
                         (stopped - (1 - impactLoss) * stoppedBefore).norm() <= limit);
    J.all += J.sticks ? stopped : Vec<Dim>(std::min(stopped.norm(), limit) * unit(stopped, 0.0));
    if (J.sticks) J.agreeing += stoppedBefore;
    return J;
}

} // namespace mpm
