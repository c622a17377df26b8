// SPDX-License-Identifier: GPL-2.0-or-later
// Three groups on a node, pair after pair: what contact books of the velocities of the start.
#include "mpm/contact/ContactImpulses.hpp"

#include <gtest/gtest.h>

namespace mpm {

TEST(NodeMotion, pairsBookTheEnergyThatParticlesOfThreeGroupsLose) {
    const double mass[3] = {2.0, 1e-4, 0.3};
    const Vec<2> first[3] = {Vec<2>(1, 0.2), Vec<2>(-3, 0.5), Vec<2>(0.4, -2)};
    const int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    const Vec<2> agreeing[3] = {Vec<2>(3e-4, 1e-4), Vec<2>(0.2, 0.3), Vec<2>(-1e-4, 2e-4)};
    for (const double part : {0.0, 0.3, 0.5, 1.0}) {
        Vec<2> start[3] = {first[0], first[1], first[2]}, ofParticles[3] = {first[0], first[1], first[2]};
        double booked = 0, lost = 0;
        for (int pair = 0; pair < 3; ++pair) {
            NodeMotion<2> motion;
            for (int side = 0; side < 2; ++side) {
                const int group = pairs[pair][side];
                motion.inverseMass[side] = motion.startInverseMass[side] = Mat<2>::Identity() / mass[group];
                motion.first[side] = first[group];
                motion.start[side] = motion.v[side] = start[group];
            }
            for (int side = 0; side < 2; ++side) motion.take(side, {agreeing[pair], agreeing[pair]}, 1);
            booked += motion.lostByStart(part);
            for (int side = 0; side < 2; ++side) {
                const int group = pairs[pair][side];
                start[group] = motion.start[side];
                ofParticles[group] += (side == 0 ? -1 : 1) * part / mass[group] * agreeing[pair];
            }
        }
        for (int group = 0; group < 3; ++group)
            lost += 0.5 * mass[group] * (first[group].squaredNorm() - ofParticles[group].squaredNorm());
        EXPECT_NEAR(booked, lost, 1e-13) << "part " << part;
    }
}

} // namespace mpm
