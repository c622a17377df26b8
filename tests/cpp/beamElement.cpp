// SPDX-License-Identifier: GPL-2.0-or-later
// The element of a beam: what strains it, its gradients, and its hinges.
#include "mpm/particle/apdi/BeamElement.hpp"

#include <gtest/gtest.h>

namespace mpm {
namespace {

Corners<2> quadrilateral() {
    Corners<2> X;
    X << 1.0, 1.9, 2.0, 1.1, 0.2, 0.3, 0.8, 0.6; // a trapezoid
    return X;
}

Corners<2> turned(const Corners<2>& X, double angle) {
    Mat<2> R;
    R << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    return (R * X).colwise() + Vec<2>(0.7, -0.4);
}

Corners<2> deformed() {
    Corners<2> x = turned(quadrilateral(), 0.8);
    x(0, 2) += 0.03;
    x(1, 1) -= 0.02;
    x(1, 3) += 0.01;
    return x;
}

TEST(BeamElement, RowsAreTheGradientsOfItsStrains) {
    const SectionStiffness section{1e3, 20, 400};
    for (bool isRound : {false, true}) {
        const BeamElement element(quadrilateral(), section, isRound);
        const BeamElement::Plastic hinges = {0.01, -0.02};
        const double step = 1e-6;
        const auto s = element.strained(deformed(), hinges);
        for (int a = 0; a < 4; ++a)
            for (int k = 0; k < 2; ++k) {
                Corners<2> more = deformed(), less = deformed();
                more(k, a) += step;
                less(k, a) -= step;
                const auto up = element.strained(more, hinges), down = element.strained(less, hinges);
                for (int r = 0; r < BeamElement::rows; ++r)
                    EXPECT_NEAR(s.gradient[r][a][k], (up.e[r] - down.e[r]) / (2 * step), 1e-8)
                        << "row " << r << ", corner " << a << ", axis " << k;
            }
    }
}

TEST(BeamElement, TurningAndMovingDoNotStrainIt) {
    const BeamElement::Plastic none = {0, 0};
    const BeamElement element(quadrilateral(), {1e3, 20}, false);
    for (double angle : {0.3, 1.7, 3.1, -2.5})
        for (double e : element.strained(turned(quadrilateral(), angle), none).e) EXPECT_NEAR(e, 0, 1e-14);
    EXPECT_GT(element.energy(element.strained(deformed(), none)), 0.01); // control
}

// Clamped at A and moved across at B by w: 12 E I w^2/(2 L^3), as by cubic shape functions.
TEST(BeamElement, AStraightOneIsExact) {
    const BeamElement::Plastic none = {0, 0};
    const double L = 2, EI = 30, w = 1e-4;
    Corners<2> X, x;
    X << 0, L, L, 0, 0, 0, 0.5, 0.5;
    x = X;
    x(1, 1) += w;
    x(1, 2) += w;
    const BeamElement element(X, {1e3, EI}, false);
    EXPECT_NEAR(element.energy(element.strained(x, none)), 6 * EI * w * w / (L * L * L), 1e-5 * EI * w * w);
}

TEST(BeamElement, HingesTurnUntilNoEndHasMoreThanTheLimit) {
    const double L = 2, EI = 30, limit = 0.05;
    Corners<2> X, x;
    X << 0, L, L, 0, 0, 0, 0.5, 0.5;
    x = X;
    x(1, 1) += 0.1;
    x(1, 2) += 0.1;
    const BeamElement element(X, {1e3, EI, SectionStiffness::none, limit}, false);
    BeamElement::Plastic hinges = {0, 0}, none = {0, 0};
    const double before = element.energy(element.strained(x, none));
    element.yield(element.strained(x, none), hinges);
    const auto s = element.strained(x, hinges);
    const double Q = element.stiffness(BeamElement::shear) * s.e[BeamElement::shear] * element.overVolume();
    const double M =
        element.stiffness(BeamElement::curvature) * s.e[BeamElement::curvature] * element.overVolume();
    EXPECT_NEAR(std::abs(Q) * L / 2 + std::abs(M), limit, 1e-9);
    EXPECT_GT(before, element.energy(s) + limit * (std::abs(hinges[0]) + std::abs(hinges[1])));
    BeamElement::Plastic again = hinges;
    element.yield(s, again);
    EXPECT_EQ(again, hinges);
}

} // namespace
} // namespace mpm
