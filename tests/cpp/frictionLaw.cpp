// SPDX-License-Identifier: GPL-2.0-or-later
// The law of contact where an implicit body answers an impulse along one axis by a velocity along others, too.
#include "mpm/contact/FrictionLaw.hpp"

#include <gtest/gtest.h>

namespace mpm {

namespace {

// The impulse after rounds of Gauss-Seidel at this one site, and the relative velocity it leaves of w.
template <int Dim>
std::pair<Vec<Dim>, Vec<Dim>> exchanged(const FrictionLaw& law, const Vec<Dim>& normal,
                                        const Mat<Dim>& mobility, const Vec<Dim>& w) {
    ContactSite<Dim> site;
    site.normal = normal;
    for (int round = 0; round < 200; ++round)
        site.J = law.impulses<Dim>(site, 1e-3, mobility, Mat<Dim>::Identity(), Vec<Dim>::Zero(), w);
    return {site.J.all, w - mobility * site.J.all};
}

const Mat<2> skew = (Mat<2>() << 2.0, 0.9, 0.9, 1.0).finished();
const Mat<3> skewInSpace = (Mat<3>() << 2.0, 0.9, 0.5, 0.9, 1.0, 0.4, 0.5, 0.4, 1.5).finished();
const Vec<2> tilted(0.6, 0.8), along(0.8, -0.6);

} // namespace

TEST(FrictionLaw, surfacesThatSlideNeitherCrossNorPartWhateverTheAnswer) {
    for (const double friction : {0.0, 0.1, 0.3}) {
        const FrictionLaw law{friction, 0, true, true, 1};
        const auto [J, w] = exchanged<2>(law, tilted, skew, Vec<2>(1.5, 0.7));
        EXPECT_GT(J.dot(tilted), 0.1);
        EXPECT_NEAR(w.dot(tilted), 0, 1e-12);
        EXPECT_NEAR(std::abs(J.dot(along)), friction * J.dot(tilted), 1e-12);
        EXPECT_GE(w.dot(along) * J.dot(along), -1e-12); // friction brakes
    }
}

TEST(FrictionLaw, surfacesThatStickDoNotMove) {
    const FrictionLaw rough{2.0, 0, true, true, 1};
    const auto [J, w] = exchanged<2>(rough, tilted, skew, Vec<2>(1.5, 0.7));
    EXPECT_GT(J.norm(), 0.1);
    EXPECT_NEAR(w.norm(), 0, 1e-12);
    const auto [JInSpace, wInSpace] =
        exchanged<3>(rough, Vec<3>(0.6, 0, 0.8), skewInSpace, Vec<3>(1.5, 0.7, 1));
    EXPECT_GT(JInSpace.norm(), 0.1);
    EXPECT_NEAR(wInSpace.norm(), 0, 1e-12);
}

// Else the last bit of the slip tells whether velocities that are made anew stick.
TEST(FrictionLaw, surfacesWithoutFrictionDoNotStickWhenTheySlipByNothing) {
    for (const double friction : {0.0, 0.3}) {
        const FrictionLaw law{friction, 0, true, true, 1};
        ContactSite<2> site;
        site.normal = tilted;
        const auto J = law.impulses<2>(site, 1e-3, Mat<2>::Identity(), Mat<2>::Identity(), Vec<2>::Zero(),
                                       Vec<2>(0.3 * tilted));
        EXPECT_GT(J.all.dot(tilted), 0.1);
        EXPECT_EQ(J.sticks, friction > 0);
    }
}

TEST(FrictionLaw, adhesionActsWhereSurfacesTouchThoughTheyPartInThisStep) {
    const FrictionLaw law{0, 50, true, true, 1};
    const double dt = 1e-3;
    ContactSite<2> site;
    site.normal = tilted;
    site.area = 0.5;
    const Vec<2> parting = -0.2 * tilted + 3 * along;
    const auto exchanged = [&](double gap) {
        site.gap = gap;
        return law.impulses<2>(site, dt, Mat<2>::Identity(), Mat<2>::Identity(), Vec<2>::Zero(), parting).all;
    };
    EXPECT_NEAR((exchanged(0) - law.adhesion * site.area * dt * along).norm(), 0, 1e-12);
    EXPECT_FALSE(law.isApart(site, dt, parting));
    EXPECT_EQ(exchanged(1e-6).norm(), 0); // control: apart
    EXPECT_TRUE(law.isApart(site, dt, parting));
}

TEST(FrictionLaw, surfacesThatSharedCellsPressTogetherDoNotPartAndBearFriction) {
    const double dt = 1e-3, carried = 50, friction = 0.3; // kN, whatever the area of the site
    const FrictionLaw law{friction, 0, true, true, 1};
    ContactSite<2> site;
    site.normal = tilted;
    site.area = 0.5;
    site.carried = carried;
    const auto exchanged = [&](const Vec<2>& w) {
        return law.impulses<2>(site, dt, Mat<2>::Identity(), Mat<2>::Identity(), Vec<2>::Zero(), w).all;
    };
    const double most = carried * dt;
    const Vec<2> slow =
        exchanged(-0.4 * most * tilted + 3 * along); // parting: held, and friction by what is left
    EXPECT_NEAR(slow.dot(tilted), -0.4 * most, 1e-15);
    EXPECT_NEAR(slow.dot(along), friction * 0.6 * most, 1e-15);
    const Vec<2> fast =
        exchanged(-3 * most * tilted + 3 * along); // no more than presses, and then no friction
    EXPECT_NEAR(fast.dot(tilted), -most, 1e-15);
    EXPECT_NEAR(fast.dot(along), 0, 1e-15);
    const Vec<2> meeting = exchanged(2 * most * tilted + 3 * along);
    EXPECT_NEAR(meeting.dot(tilted), 2 * most, 1e-15);
    EXPECT_NEAR(meeting.dot(along), friction * 3 * most, 1e-15);
}

// Whatever the rounds, what is left of the velocities of the start is not more than they were.
template <int Dim>
void expectThatStartsLoseEnergy(const Vec<Dim>& normal, const Mat<Dim>& mobility, const Vec<Dim>& start,
                                const Vec<Dim>& w) {
    const FrictionLaw rough{0.5, 0, true, true, 1};
    ContactSite<Dim> site;
    site.normal = normal.normalized();
    for (int round = 0; round < 5; ++round) {
        site.J = rough.impulses<Dim>(site, 1e-3, mobility, mobility, start, w);
        const Vec<Dim> left = start - mobility * site.J.agreeing;
        EXPECT_LE(left.norm(), 1.0001 * start.norm())
            << "normal " << normal.transpose() << ", round " << round;
    }
}

TEST(FrictionLaw, velocitiesOfTheStartLoseEnergyAtHeldNodesToo) {
    for (int i = 1; i <= 40; ++i) { // after the first round all that slips is round-off
        const double tilt = 1e-4 * i;
        expectThatStartsLoseEnergy<2>({tilt, 1}, Vec<2>(0, 11815).asDiagonal(), Vec<2>(0, -0.0097),
                                      Vec<2>(0, 0.0697));
        expectThatStartsLoseEnergy<2>({tilt, 1}, Vec<2>(0, 11815).asDiagonal(), Vec<2>(0, 0.0097),
                                      Vec<2>(0, 0.0697));
        // The start slips along another axis than the solution, which hardly answers along its own.
        expectThatStartsLoseEnergy<3>({0.1 * tilt, 0, 1}, Vec<3>(0, 500, 500).asDiagonal(), Vec<3>(0, 0.3, 0),
                                      Vec<3>(0, 1e-9, 0.07));
    }
}

TEST(FrictionLaw, startsOfSurfacesThatPartDoNotAgree) {
    const double dt = 1e-3, carried = 50;
    const FrictionLaw elastic{0, 0, true, true, 0};
    ContactSite<2> site;
    site.normal = tilted;
    site.carried = carried;
    const auto exchanged = [&](double parting) {
        const Vec<2> w = -parting * carried * dt * tilted;
        return elastic.impulses<2>(site, dt, Mat<2>::Identity(), Mat<2>::Identity(), 0.5 * w, w);
    };
    EXPECT_FALSE(exchanged(0.9).parts);
    EXPECT_NEAR(exchanged(0.9).agreeing.dot(tilted), -0.45 * carried * dt, 1e-15);
    EXPECT_TRUE(exchanged(1.1).parts);
    EXPECT_EQ(exchanged(1.1).agreeing.norm(), 0);
}

// Velocities made again have no gap to close: what parts there was pressed together by the stress of this step.
TEST(FrictionLaw, surfacesThatPressedStayTogetherWhateverImpactsLose) {
    for (const double impactLoss : {0.0, 0.5, 1.0}) {
        const FrictionLaw law{0, 0, true, true, impactLoss};
        ContactSite<2> site;
        site.normal = tilted;
        const auto parting = [&] {
            return law
                .impulses<2>(site, 1e-3, Mat<2>::Identity(), Mat<2>::Identity(), Vec<2>::Zero(),
                             Vec<2>(-0.2 * tilted))
                .all;
        };
        EXPECT_EQ(parting().norm(), 0); // control: they have not pressed
        site.presses = true;
        EXPECT_NEAR((parting() + 0.2 * tilted).norm(), 0, 1e-15);
    }
}

TEST(FrictionLaw, normalsHaveNoPartAlongAxesThatAreHeldOnBothSides) {
    const auto isUp = [](int axis) { return axis == 1; };
    const auto tiltedBy = [&](double x) { return freePart<2>({x, std::sqrt(1 - x * x)}, isUp); };
    EXPECT_EQ(tiltedBy(0.2), Vec<2>(1, 0));
    EXPECT_EQ(tiltedBy(0.05), Vec<2>(0, 0)); // too little is left
    EXPECT_EQ(freePart<2>(tilted, [](int) { return false; }), tilted);
    EXPECT_EQ(freePart<2>({1, 0}, isUp), Vec<2>(1, 0));
}

TEST(FrictionLaw, oneBodyDoesNotMoveInItself) {
    const auto [J, w] =
        exchanged<3>({0, 0, false, false, 1}, Vec<3>::UnitX(), skewInSpace, Vec<3>(1.5, 0.7, -2));
    EXPECT_GT(J.norm(), 0.1);
    EXPECT_NEAR(w.norm(), 0, 1e-12);
}

} // namespace mpm
