// SPDX-License-Identifier: GPL-2.0-or-later
// The element of a plate: what strains it, its gradients, and what it is exact for.
#include "mpm/particle/apdi/PlateElement.hpp"

#include "mpm/particle/apdi/BeamElement.hpp"

#include <gtest/gtest.h>

namespace mpm {
namespace {

const PlateElement::Plastic none{};
constexpr double A = 2, B = 1.5, T = 0.4, EA = 1e3, EI = 20, Nu = 0.3;
constexpr double rigid = SectionStiffness::none;
// A ninth of the stiffness along the width, and Poisson's ratio.
const SectionStiffness orthotropic{EA, EI, rigid, rigid, EA / 9, EI / 9, Nu};

// 1/2 (k0^2 D0 + k1^2 D1 + 2 nu S k0 k1 + 2 (1 - nu) S k2^2), with D over 1 - nu^2, and S the root of D0 D1.
double byHand(const Vec<3>& k, double along, double across, double nu) {
    const double S = std::sqrt(along * across);
    return 0.5 *
           (along * k[0] * k[0] + across * k[1] * k[1] + 2 * nu * S * k[0] * k[1] +
            2 * (1 - nu) * S * k[2] * k[2]) /
           (1 - nu * nu);
}

// Fibres at the corners of a rectangle, each with its middle and the slope of its end.
template <class Middle, class Normal> Corners<3> plate(Middle&& middle, Normal&& normal) {
    Corners<3> x;
    for (int f = 0; f < 4; ++f) {
        const double u = f == 1 || f == 2 ? A : 0, v = f > 1 ? B : 0;
        x.col(f) = middle(u, v) - 0.5 * T * normal(u, v).normalized();
        x.col(f + 4) = middle(u, v) + 0.5 * T * normal(u, v).normalized();
    }
    return x;
}

Corners<3> flat() {
    return plate([](double u, double v) { return Vec<3>(u, v, 0); },
                 [](double, double) { return Vec<3>(0, 0, 1); });
}

// Bent to the deflection w = 1/2 (k0 u^2 + k1 v^2) + k2 u v.
Corners<3> bent(double k0, double k1, double k2) {
    return plate(
        [=](double u, double v) { return Vec<3>(u, v, 0.5 * (k0 * u * u + k1 * v * v) + k2 * u * v); },
        [=](double u, double v) { return Vec<3>(-k0 * u - k2 * v, -k1 * v - k2 * u, 1); });
}

Corners<3> turned(const Corners<3>& X, double angle) {
    const Mat<3> R = Eigen::AngleAxis<double>(angle, Vec<3>(1, 2, -0.5).normalized()).toRotationMatrix();
    return (R * X).colwise() + Vec<3>(0.7, -0.4, 0.2);
}

Corners<3> deformed() {
    Corners<3> x = turned(bent(0.1, -0.05, 0.08), 0.8);
    for (int a = 0; a < 8; ++a)
        x.col(a) += 0.02 * Vec<3>(std::sin(3 * a), std::cos(2 * a), std::sin(5 * a + 1));
    return x;
}

double energy(const PlateElement& element, const Corners<3>& x) {
    return element.energy(element.strained(x, none));
}

TEST(PlateElement, RowsAreTheGradientsOfItsStrains) {
    const PlateElement element(flat(), {EA, EI, 400, rigid, EA / 9, EI / 9, Nu}, false);
    const double step = 1e-6;
    const auto s = element.strained(deformed(), none);
    for (int a = 0; a < 8; ++a)
        for (int k = 0; k < 3; ++k) {
            Corners<3> more = deformed(), less = deformed();
            more(k, a) += step;
            less(k, a) -= step;
            const auto up = element.strained(more, none), down = element.strained(less, none);
            for (int r = 0; r < PlateElement::rows; ++r)
                EXPECT_NEAR(s.gradient[r][a][k], (up.e[r] - down.e[r]) / (2 * step), 1e-7)
                    << "row " << r << ", corner " << a << ", axis " << k;
        }
}

TEST(PlateElement, TurningAndMovingDoNotStrainIt) {
    const PlateElement element(flat(), {EA, EI}, false);
    for (double angle : {0.3, 1.7, 3.1, -2.5})
        for (double e : element.strained(turned(flat(), angle), none).e) EXPECT_NEAR(e, 0, 1e-14);
    EXPECT_GT(energy(element, deformed()), 0.01); // control
}

TEST(PlateElement, ConstantCurvaturesAndTwistAreExact) {
    for (const auto& section : {SectionStiffness{EA, EI}, {EA, EI, 100.0}, orthotropic}) {
        const PlateElement element(flat(), section, false);
        const double small = 1e-4;
        for (const auto& k : {Vec<3>(1, 0, 0), Vec<3>(0, 1, 0), Vec<3>(0, 0, 1), Vec<3>(0.3, -0.7, 0.5)}) {
            const double across = section.poisson > 0 ? EI / 9 : EI;
            const double exact = byHand(k, EI, across, section.poisson) * A * B * small * small;
            EXPECT_NEAR(energy(element, bent(small * k[0], small * k[1], small * k[2])), exact, 1e-6 * exact);
        }
    }
}

TEST(PlateElement, ConstantStrainsOfTheMembraneAreExact) {
    const PlateElement element(flat(), orthotropic, false);
    const double small = 1e-6;
    for (const auto& e : {Vec<3>(1, 0, 0), Vec<3>(0, 1, 0), Vec<3>(0, 0, 1), Vec<3>(0.3, -0.7, 0.5)}) {
        const auto middle = [&](double u, double v) {
            return Vec<3>(u + small * (e[0] * u + 0.5 * e[2] * v), v + small * (e[1] * v + 0.5 * e[2] * u),
                          0);
        };
        const Corners<3> x = plate(middle, [](double, double) { return Vec<3>(0, 0, 1); });
        const double exact = byHand({e[0], e[1], 0.5 * e[2]}, EA, EA / 9, Nu) * A * B * small * small;
        EXPECT_NEAR(energy(element, x), exact, 1e-5 * exact);
    }
}

// Bent in its own plane, by the ends of the line: E t B^3/12 times the square of the curvature.
TEST(PlateElement, BendingInItsPlaneIsThatOfADeepBeam) {
    const PlateElement element(flat(), {EA, EI}, false);
    const double k = 1e-6;
    const auto middle = [&](double u, double v) {
        return Vec<3>(u - k * (u - 0.5 * A) * (v - 0.5 * B), v + 0.5 * k * u * (u - A), 0);
    };
    const Corners<3> x = plate(middle, [](double, double) { return Vec<3>(0, 0, 1); });
    const double exact = 0.5 * EA * B * B * B / 12 * k * k * A;
    EXPECT_NEAR(energy(element, x), exact, 1e-4 * exact);
}

// In a plane it is the beam, with any motion of that: the same energy by the width.
TEST(PlateElement, InAPlaneItIsTheElementOfABeam) {
    const SectionStiffness section{EA, EI, 300};
    Corners<2> X, x;
    X << 0, A, A, 0, -T / 2, -T / 2, T / 2, T / 2;
    x = X;
    x.row(0) += Eigen::RowVector4d(0.01, 0.03, -0.02, 0.02);
    x.row(1) += Eigen::RowVector4d(0.02, 0.2, 0.18, -0.01);
    const auto drawn = [](const Corners<2>& flat) { // along y
        Corners<3> all;
        for (int f = 0; f < 4; ++f) {
            const bool isEnd = f == 1 || f == 2;
            all.col(f) = Vec<3>(flat(0, isEnd ? 1 : 0), f > 1 ? B : 0, flat(1, isEnd ? 1 : 0));
            all.col(f + 4) = Vec<3>(flat(0, isEnd ? 2 : 3), f > 1 ? B : 0, flat(1, isEnd ? 2 : 3));
        }
        return all;
    };
    const BeamElement beam(X, section, false);
    const PlateElement element(drawn(X), section, false);
    const double exact = B * beam.energy(beam.strained(x, {0, 0}));
    EXPECT_GT(exact, 0.1);
    EXPECT_NEAR(energy(element, drawn(x)), exact, 1e-13 * exact);
}

PlateElement::Plastic plastic() {
    PlateElement::Plastic all;
    for (size_t i = 0; i < all.size(); ++i) all[i] = 0.03 * std::sin(2.0 * i);
    return all;
}

// Its gradient over the plastic curvatures is minus the moment.
TEST(PlateElement, MomentsAtTheGaussPointsAreTheGradientsOfTheEnergy) {
    for (const SectionStiffness& section : {SectionStiffness{EA, EI}, orthotropic}) {
        const PlateElement element(flat(), section, false);
        const double step = 1e-5;
        const auto s = element.strained(deformed(), plastic());
        for (int f = 0; f < 4; ++f) {
            double moment[3];
            element.forces(s, f, [&](SectionState what, double value) {
                if (what == bendingMoment) moment[0] = -value;
                if (what == hoopMoment) moment[1] = -value;
                if (what == twistingMoment) moment[2] = -2 * value; // by both of its components
            });
            for (int i = 0; i < 3; ++i) {
                auto more = plastic(), less = plastic();
                more[3 * f + i] += step;
                less[3 * f + i] -= step;
                const double up = element.energy(element.strained(deformed(), more));
                const double down = element.energy(element.strained(deformed(), less));
                EXPECT_NEAR((down - up) / (2 * step), moment[i] * A * B / 4, 1e-6);
            }
        }
    }
}

TEST(PlateElement, NoPrincipalMomentIsBeyondTheLimit) {
    const double limit = 0.5;
    for (double nu : {0.0, Nu}) {
        const PlateElement element(flat(), {EA, EI, rigid, limit, EA, EI, nu}, false);
        auto all = plastic();
        const double before = element.energy(element.strained(deformed(), all));
        element.yield(element.strained(deformed(), all), all);
        const auto s = element.strained(deformed(), all);
        int atLimit = 0;
        for (int f = 0; f < 4; ++f) {
            double m[3];
            element.forces(s, f, [&](SectionState what, double value) {
                for (auto [its, k] : {std::pair(bendingMoment, 0), {hoopMoment, 1}, {twistingMoment, 2}})
                    if (what == its) m[k] = value;
            });
            const double largest = std::abs(m[0] + m[1]) / 2 + std::hypot((m[0] - m[1]) / 2, m[2]);
            EXPECT_LE(largest, limit * (1 + 1e-9));
            atLimit += largest > limit * (1 - 1e-9);
        }
        EXPECT_EQ(atLimit, 4);
        EXPECT_LT(element.energy(s), before);
        auto again = all;
        element.yield(s, again);
        EXPECT_EQ(again, all);
    }
}

// Bent to a cylinder, the plastic part is one, too: no curvature across that the moment nu M would have to hold.
TEST(PlateElement, WhatYieldsBendsAcrossTheMomentThatIsAtItsLimit) {
    const double limit = 0.05, k = 0.01;
    const PlateElement element(flat(), {EA, EI, rigid, limit, EA, EI, Nu}, false);
    PlateElement::Plastic all{};
    element.yield(element.strained(bent(k, 0, 0), all), all);
    const double elastic = limit * (1 - Nu * Nu) / EI;
    for (int f = 0; f < 4; ++f) {
        EXPECT_NEAR(all[3 * f], k - elastic, 1e-3 * k);
        EXPECT_NEAR(all[3 * f + 1], 0, 1e-3 * k);
    }
}

} // namespace
} // namespace mpm
