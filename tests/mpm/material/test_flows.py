# SPDX-License-Identifier: GPL-2.0-or-later
"""MuI, HerschelBulkley and NewtonianLiquid at a point: the shear stress of a steady rate of shear is the
law's.

Set-up: a point sheared at constant volume, 40 relaxation times long, under a pressure, in plane and turned
directions. Reference: the laws in their own words. Tolerance: 1e-3, that of the Jaumann rate at a shear
stress of a thirtieth of the shear modulus; 1e-9 where a step is one rate alone. Controls: a rate 3 % higher
and an exponent of 1 in place of 0.5 are told apart.
"""

import numpy as np
import pytest
import yade_mpm as mpm

STILL, FAST, I0, SIZE, GRAINS = 0.38, 0.64, 0.279, 0.001, 2.5
SAND = dict(
    density=1.5,
    young=2e4,
    poisson=0.3,
    staticFriction=STILL,
    fastFriction=FAST,
    inertialNumber=I0,
    grainSize=SIZE,
    grainDensity=GRAINS,
)
MUD = dict(density=1.5, bulk=1e4, yieldStress=0.5, consistency=0.2)


def sheared(material, rate, pressure=0.0, dt=1e-3, steps=2000):
    """Shear stress and pressure after steady shear in the plane."""
    point = mpm.MaterialPoint(material, -pressure * np.eye(3))
    L = np.array([[0, rate, 0], [0, 0, 0], [0, 0, 0]])
    for _ in range(steps):
        stress = point.gradient(L, dt)
    return np.sqrt(0.5 * ((stress - np.trace(stress) / 3 * np.eye(3)) ** 2).sum()), -np.trace(stress) / 3


@pytest.mark.parametrize("rate", [1e-3, 0.1, 10.0, 300.0])
@pytest.mark.parametrize("pressure", [0.01, 5.0])
def testFrictionGrowsWithTheInertialNumber(rate, pressure):
    tau, p = sheared(mpm.MuI(**SAND), rate, pressure, dt=0.02 / max(rate, 0.1), steps=4000)
    inertia = rate * SIZE / np.sqrt(p / GRAINS)
    mu = STILL + (FAST - STILL) / (1 + I0 / inertia)
    assert p == pytest.approx(pressure, rel=1e-2)
    assert tau == pytest.approx(mu * p, rel=1e-3)


def testGrainsAtRestBearTheirStaticFriction():
    tau, p = sheared(mpm.MuI(**SAND), 1e-9, 5.0, dt=1e4)
    assert tau == pytest.approx(STILL * p, rel=1e-3)
    tau, _ = sheared(mpm.MuI(**SAND), 1e-6, 5.0, dt=1.0, steps=100)
    assert tau == pytest.approx(2e4 / 2.6 * 1e-4, rel=1e-6)  # elastic


@pytest.mark.parametrize("n", [0.5, 1, 1.5])
@pytest.mark.parametrize("rate", [0.01, 1.0, 20.0])
def testMudHasItsYieldStressAndConsistency(n, rate):
    mud = mpm.HerschelBulkley(**MUD, flowIndex=n, shearModulus=1e3)
    tau, _ = sheared(mud, rate, 10.0, dt=0.01 / max(rate, 0.1), steps=4000)
    assert tau == pytest.approx(0.5 + 0.2 * rate**n, rel=1e-3)
    assert rate < 1 or tau != pytest.approx(0.5 + 0.2 * (1.03 * rate) ** n, rel=2e-3)


@pytest.mark.parametrize("n", [0.3, 0.5, 0.9, 1.1, 2.0])
def testOneStepOfMudSolvesItsEquation(n):
    """tau + G dt rate(tau) = tau_trial, for trials from just above yield to a thousand times it."""
    mud, G, dt = mpm.HerschelBulkley(**MUD, flowIndex=n, shearModulus=1e3), 1e3, 1e-3
    for trial in 0.5 * (1 + np.geomspace(1e-5, 1e3, 60)):
        stress = trial * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]]) - 1e4 * np.eye(3)
        tau = mpm.MaterialPoint(mud, stress).gradient(np.zeros((3, 3)), dt)[0, 1]
        rate = ((tau - 0.5) / 0.2) ** (1 / n)
        assert tau + G * dt * rate == pytest.approx(trial, rel=1e-9)


def testOneStepOfGrainsSolvesItsEquation():
    sand, dt = mpm.MuI(**SAND), 1e-4
    G = 2e4 / 2.6
    for p in (1e-6, 1e-2, 10.0):
        for trial in STILL * p * (1 + np.geomspace(1e-6, 1e4, 40)):
            stress = trial * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]]) - p * np.eye(3)
            tau = mpm.MaterialPoint(sand, stress).gradient(np.zeros((3, 3)), dt)[0, 1]
            inertia = (trial - tau) / (G * dt) * SIZE / np.sqrt(p / GRAINS)
            assert tau == pytest.approx(p * (STILL + (FAST - STILL) * inertia / (I0 + inertia)), rel=1e-9)


def testALiquidHasItsViscosityAndNoTension():
    oil = mpm.NewtonianLiquid(density=0.9, viscosity=1e-3, bulk=1e4)
    assert sheared(oil, 50.0, 10.0, steps=50)[0] == pytest.approx(0.05, rel=1e-5)
    water = mpm.NewtonianLiquid(density=1.0, bulk=2.2e6)
    assert sheared(water, 1.0, 10.0, steps=5)[0] == pytest.approx(1e-6, rel=1e-6)
    point = mpm.MaterialPoint(water, -5 * np.eye(3))
    assert abs(np.trace(point.strain(1e-5 * np.eye(3)))) < 1e-12
    assert point.state["plasticVolumetricStrain"] == pytest.approx(3e-5 - 5 / 2.2e6, rel=1e-4)
    hanging = mpm.MaterialPoint(mpm.NewtonianLiquid(density=1.0, bulk=1e4, tensileStrength=8))
    assert hanging.strain(1e-4 * np.eye(3))[1, 1] == pytest.approx(3, rel=1e-3)
    assert hanging.strain(1e-2 * np.eye(3))[1, 1] == pytest.approx(8, rel=1e-12)


def testGrainsWithoutPressureBearNothing():
    point = mpm.MaterialPoint(mpm.MuI(**SAND), -1 * np.eye(3))
    assert np.abs(point.strain(1e-3 * np.eye(3) + 1e-3 * np.diag([1, -1, 0]))).max() == 0
    assert point.strain(-1e-5 * np.eye(3))[0, 0] < 0


@pytest.mark.parametrize(
    "law, given, error",
    [
        ("MuI", {**SAND, "fastFriction": 0.3}, "fastFriction = 0.3 is below staticFriction"),
        ("MuI", {k: v for k, v in SAND.items() if k != "grainSize"}, "grainSize is required"),
        ("HerschelBulkley", {**MUD, "flowIndex": 3}, "flowIndex"),
        ("HerschelBulkley", {"density": 1, "bulk": 1e3, "consistency": 1}, "yieldStress is required"),
        ("NewtonianLiquid", {"density": 1}, "bulk is required"),
        ("NewtonianLiquid", {"density": 1, "bulk": 1, "viscosity": -1}, "viscosity"),
    ],
)
def testWhatDoesNotFitIsRefused(law, given, error):
    with pytest.raises(ValueError, match=error):
        getattr(mpm, law)(**given)
