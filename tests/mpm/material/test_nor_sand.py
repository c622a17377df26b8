# SPDX-License-Identifier: GPL-2.0-or-later
"""NorSand at a point, against its own equations.

Set-up: element tests of sand from loose to very dense. Reference: the rate equations of Jefferies & Shuttle
2005 along the path of a drained triaxial test, integrated here in 20 000 steps of plastic strain; the
critical state; the steady state of loose sand at constant volume; the limit of dilatancy. Tolerance: 0.5 %
of the largest stress against the rate equations in 1000 steps, 0.1 % at critical states. Controls:
dilatancy and coupling 5 % off are told apart.
"""

import numpy as np
import pytest
import scipy.optimize
import yade_mpm as mpm

PHI, GAMMA, LAMBDA, CHI, COUPLING, HARDENING, G = np.radians(31), 0.817, 0.014, 4.0, 0.3, 100.0, 5e4
M = 6 * np.sin(PHI) / (3 - np.sin(PHI))
SAND = dict(
    density=1.6,
    shearModulus=G,
    poisson=0.2,
    frictionAngle=PHI,
    criticalVoidRatio=GAMMA - LAMBDA * np.log(100),
    compression=LAMBDA,
    dilatancy=CHI,
    volumetricCoupling=COUPLING,
    hardening=HARDENING,
)
K_OVER_G = 2 * 1.2 / (3 * 0.6)


def critical(p):
    return GAMMA - LAMBDA * np.log(p)


def drained(psi, p0, strain, steps=20000, chi=CHI, coupling=COUPLING):
    """Axial strain, q and volumetric strain by the rate equations."""
    p, q, pi, ev, eq, rows = p0, 0.0, p0 / np.e, 0.0, 0.0, []
    e0, step = critical(p0) + psi, strain / steps

    def imageState(pi, ev):
        psiImage = (1 + e0) * np.exp(-ev) - 1 - critical(pi)
        return psiImage, M * (1 - coupling * chi * abs(psiImage) / M)

    def beyond(p, Mi, pi):
        return 3 * (p - p0) - Mi * p * (1 + np.log(pi / p))

    while eq + ev / 3 < strain:
        psiImage, Mi = imageState(pi, ev)
        limit = np.exp(-chi * psiImage / M)
        pi = min(pi, limit * p)
        D = Mi - q / p
        pi *= np.exp(HARDENING * Mi / M * (p / pi) ** 2 * (limit - pi / p) * step)
        Mi = imageState(pi, ev + D * step)[1]
        before = p
        p = scipy.optimize.brentq(beyond, 0.5 * p, 2 * p, (Mi, pi))
        q = 3 * (p - p0)
        stiffness = G * np.sqrt(0.5 * (p + before) / 100)
        ev += D * step + (p - before) / (K_OVER_G * stiffness)
        eq += step + (p - before) / stiffness
        rows.append((eq + ev / 3, q, ev))
    return np.array(rows).T


@pytest.mark.parametrize("psi", [-0.2, -0.1, 0.0, 0.05])
def testDrainedTriaxialTestsFollowTheRateEquations(psi):
    curve = mpm.elementTest.triaxial(mpm.NorSand(**SAND, stateParameter=psi), 200.0, 0.12, steps=1000)
    strain, q, volume = drained(psi, 200.0, 0.12, steps=6000)
    found = np.interp(strain, curve.strain, curve.q), np.interp(strain, curve.strain, curve.volume)
    late = strain > 0.005
    assert np.abs(found[0] - q)[late].max() < 0.005 * q.max()
    assert np.abs(found[1] - volume).max() < 0.0005
    if psi == -0.2:
        for off in (dict(chi=1.05 * CHI), dict(coupling=1.05 * COUPLING)):
            _, other, _ = drained(psi, 200.0, 0.12, steps=6000, **off)
            assert abs(other.max() - q.max()) > 0.005 * q.max()


def testDenseSandDilatesAsItsStateParameterAllows():
    law = mpm.NorSand(**SAND, stateParameter=-0.15)
    curve = mpm.elementTest.triaxial(law, 200.0, 0.1, steps=2000)
    peak = np.argmax(curve.q)
    image = curve.p[peak] * np.exp(curve.q[peak] / curve.p[peak] / M)  # about p_i, for psi_i alone
    psi = (1 + critical(200) - 0.15) * np.exp(-curve.volume[peak]) - 1 - critical(image)
    shear = curve.strain - curve.volume / 3
    dilatancy = np.gradient(curve.volume, shear)[peak - 40 : peak].min()
    assert dilatancy == pytest.approx(CHI * psi, rel=0.03)


@pytest.mark.parametrize("psi", [-0.05, 0.03])
def testTestsEndAtTheCriticalState(psi):
    curve = mpm.elementTest.triaxial(mpm.NorSand(**SAND, stateParameter=psi), 100.0, 3.0, steps=1500)
    assert curve.q[-1] == pytest.approx(3 * M * 100 / (3 - M), rel=0.003)
    e = (1 + critical(100) + psi) * np.exp(-curve.volume[-1]) - 1
    assert e == pytest.approx(critical(curve.p[-1]), abs=2e-3)
    extension = mpm.elementTest.triaxial(mpm.NorSand(**SAND, stateParameter=0.0), 100.0, -1.0, steps=1000)
    assert -extension.q[-1] / extension.p[-1] == pytest.approx(3 * M / (3 + M), rel=0.02)


@pytest.mark.parametrize("psi, p0", [(0.05, 200.0), (0.03, 100.0)])
def testLooseSandLiquefiesToItsSteadyState(psi, p0):
    curve = mpm.elementTest.triaxial(
        mpm.NorSand(**SAND, stateParameter=psi), p0, 0.3, drained=False, steps=1000
    )
    pressure = p0 * np.exp(-psi / LAMBDA)
    assert curve.p[-1] == pytest.approx(pressure, rel=1e-3)
    assert curve.q[-1] == pytest.approx(M * pressure, rel=1e-3)
    assert curve.q.max() > 3 * curve.q[-1]  # a peak before


def testDenseSandGainsPressureAtConstantVolume():
    law = mpm.NorSand(**SAND, stateParameter=-0.05)
    curve = mpm.elementTest.triaxial(law, 100.0, 0.1, drained=False)
    assert curve.p[-1] > 1.5 * curve.p[0] > 2 * curve.p.min()


def testInitialStatesByOneCall():
    point = mpm.MaterialPoint(mpm.NorSand(**SAND, stateParameter=-0.1), -150 * np.eye(3))
    assert point.state["initialVoidRatio"] == pytest.approx(critical(150) - 0.1)
    assert point.state["imagePressure"] == pytest.approx(150 / np.e)
    law = mpm.NorSand(**SAND, initialVoidRatio=0.6, overconsolidationRatio=2)
    stress = -100 * np.diag([0.5, 1, 0.5])
    q, p = 50.0, 200 / 3
    point = mpm.MaterialPoint(law, stress)
    assert point.state["imagePressure"] == pytest.approx(2 * p * np.exp(q / p / M - 1))


def testSandWithoutPressurePartsAndResistsAgain():
    point = mpm.MaterialPoint(mpm.NorSand(**SAND, stateParameter=-0.1), -20 * np.eye(3))
    for _ in range(30):
        stress = point.strain(np.diag([1e-3, 1e-3, 5e-4]))
        assert np.linalg.eigvalsh(stress).max() < 1e-9 + 10
        assert np.trace(stress) <= 1e-12
    assert np.abs(stress).max() == 0
    for _ in range(300):
        stress = point.strain(np.diag([-1e-4, -1e-4, -2e-4]))
    assert -np.trace(stress) / 3 > 5


def testStepsOfAnySizeStayOnOneSideOfTheSurface():
    """Random steps up to a strain of 3 % end finite, without mean tension, at a possible stress ratio."""
    rng = np.random.default_rng(4)
    for _ in range(60):
        law = mpm.NorSand(**SAND, stateParameter=rng.uniform(-0.25, 0.06))
        point = mpm.MaterialPoint(law, -(10 ** rng.uniform(0, 3)) * np.eye(3))
        for _ in range(30):
            size = 10 ** rng.uniform(-6, -1.5)
            stress = point.gradient(size * rng.normal(size=(3, 3)), 1.0)
            p = -np.trace(stress) / 3
            q = np.sqrt(1.5 * ((stress + p * np.eye(3)) ** 2).sum())
            assert np.isfinite(stress).all() and p >= 0
            assert q <= 3.01 * M * max(p, 1)


@pytest.mark.parametrize(
    "given, error",
    [
        ({}, "both missing"),
        ({"stateParameter": 0.0, "initialVoidRatio": 0.7}, "both given"),
        ({"stateParameter": 0.7}, "stateParameter"),
        ({"stateParameter": 0.0, "pressureExponent": 2}, "pressureExponent"),
    ],
)
def testWhatDoesNotFitIsRefused(given, error):
    with pytest.raises(ValueError, match=error):
        mpm.NorSand(**SAND, **given)
    with pytest.raises(ValueError, match="shearModulus is required"):
        mpm.NorSand(**{k: v for k, v in SAND.items() if k != "shearModulus"}, stateParameter=0.0)
