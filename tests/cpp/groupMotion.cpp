// SPDX-License-Identifier: GPL-2.0-or-later
// Three groups on a node: the energy that contact counts for velocities of the start.
#include "mpm/contact/ContactImpulses.hpp"

#include <gtest/gtest.h>

namespace mpm {

TEST(GroupMotion, countsTheEnergyThatParticlesOfThreeGroupsLose) {
    const double mass[3] = {2.0, 1e-4, 0.3};
    const Vec<2> first[3] = {Vec<2>(1, 0.2), Vec<2>(-3, 0.5), Vec<2>(0.4, -2)};
    const Vec<2> agreeing[3] = {Vec<2>(3e-4, 1e-4), Vec<2>(0.2, 0.3), Vec<2>(-0.2003, -0.3001)};
    for (const double part : {0.0, 0.3, 0.5, 1.0}) {
        double counted = 0, lost = 0;
        for (int group = 0; group < 3; ++group) {
            GroupMotion<2> motion;
            motion.startInverseMass.setConstant(1 / mass[group]);
            motion.first = first[group];
            motion.agreeing = agreeing[group];
            counted += motion.lostByStart(part);
            const Vec<2> left = first[group] + part / mass[group] * agreeing[group];
            lost += 0.5 * mass[group] * (first[group].squaredNorm() - left.squaredNorm());
        }
        EXPECT_NEAR(counted, lost, 1e-10) << "part " << part;
    }
}

} // namespace mpm
