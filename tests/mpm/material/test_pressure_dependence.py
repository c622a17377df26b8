# SPDX-License-Identifier: GPL-2.0-or-later
"""pressureExponent: elastic moduli that grow with a power of the pressure.

Set-up: isotropic compression and triaxial tests of soil too strong to yield, and a block under pressure.
Reference: dp/de = K_ref (p/p_ref)^m in closed form; the critical step falls with the root of the present
moduli. Tolerance: 0.5 % of the pressure in 400 steps of the first order; 1e-9 of the step.
Controls: constant moduli are told apart, and a yielding test ends at the strength of constant moduli.
"""

import numpy as np
import pytest
import yade_mpm as mpm

STRONG = dict(density=2.0, young=3e4, poisson=0.25, cohesion=1e6, frictionAngle=0.0)
SAND = dict(STRONG, cohesion=1.0, frictionAngle=0.55, dilatancyAngle=0.1)
BULK = 3e4 / (3 * 0.5)
CLAY = dict(density=2.0, young=3e4, poisson=0.25)
laws = pytest.mark.parametrize("law", ["MohrCoulomb", "MohrCoulombDruckerPrager"])


@laws
@pytest.mark.parametrize("m", [0.5, 1.0])
def testCompressionFollowsThePowerLaw(law, m):
    point = mpm.MaterialPoint(getattr(mpm, law)(**STRONG, pressureExponent=m), -50 * np.eye(3))
    for _ in range(400):
        stress = point.strain(-0.01 / 3 / 400 * np.eye(3))
    strain = 0.01 * BULK / 100**m
    exact = (50 ** (1 - m) + (1 - m) * strain) ** (1 / (1 - m)) if m < 1 else 50 * np.exp(strain)
    assert -stress[0, 0] == pytest.approx(exact, rel=0.005)
    constant = mpm.MaterialPoint(getattr(mpm, law)(**STRONG), -50 * np.eye(3)).strain(-0.01 / 3 * np.eye(3))
    assert -stress[0, 0] != pytest.approx(-constant[0, 0], rel=0.02)


@laws
def testShearIsOfThePressureAndStrengthIsNot(law):
    kind = getattr(mpm, law)
    soft, stiff = (
        mpm.elementTest.triaxial(kind(**SAND, pressureExponent=0.5), p, 0.06, steps=300) for p in (25, 400)
    )
    assert stiff.q[1] / soft.q[1] == pytest.approx(4, rel=0.05)
    constant = mpm.elementTest.triaxial(kind(**SAND), 400, 0.06, steps=300)
    assert stiff.q[-1] == pytest.approx(constant.q[-1], rel=1e-6)


@laws
def testTheCriticalStepFollowsThePresentStiffness(law):
    steps = []
    for pressure in (25.0, 400.0):
        scene = mpm.Scene((0, 0), (8, 8), cell=1.0, threads=1)
        soil = scene.add(
            "soil",
            mpm.box((1, 1), (7, 7)),
            getattr(mpm, law)(**STRONG, pressureExponent=0.5),
            mpm.UGIMP(perCell=2),
        )
        soil.stress = -pressure * np.tile(np.eye(3), (soil.count, 1, 1))
        steps.append(scene.criticalTimeStep())
    assert steps[0] / steps[1] == pytest.approx(2, rel=1e-9)


@pytest.mark.parametrize("m", [0.5, 1.0])
def testClayInTotalStressStiffensAlike(m):
    point = mpm.MaterialPoint(mpm.Tresca(**CLAY, undrainedStrength=1e3, pressureExponent=m), -50 * np.eye(3))
    for _ in range(400):
        stress = point.strain(-0.01 / 3 / 400 * np.eye(3))
    strain = 0.01 * BULK / 100**m
    exact = (50 ** (1 - m) + (1 - m) * strain) ** (1 / (1 - m)) if m < 1 else 50 * np.exp(strain)
    assert -stress[0, 0] == pytest.approx(exact, rel=0.005)
    assert point.stiffness[1] == pytest.approx(1.2e4 * (exact / 100) ** m, rel=0.005)


def testTheStrengthOfClayIsNotThatOfThePressure():
    for p in (25, 400):
        law = mpm.Tresca(**CLAY, undrainedStrength=20, pressureExponent=0.5)
        curve = mpm.elementTest.triaxial(law, p, 0.06, drained=False, steps=300)
        assert curve.q[-1] == pytest.approx(40, rel=1e-9)
        assert curve.q[1] == pytest.approx(3 * 1.2e4 * (p / 100) ** 0.5 * 0.06 / 300, rel=1e-3)


def testClayIsStiffByItsStrengthOrByItsPressure():
    with pytest.raises(ValueError, match="rigidity = 100 and pressureExponent = 0.5 are given together"):
        mpm.Tresca(density=2, poisson=0.3, rigidity=100, undrainedStrength=20, pressureExponent=0.5)


def testTheExponentOfSanisandIsThatOfItsStiffness():
    given = dict(density=1.5, frictionAngle=0.54, criticalVoidRatio=0.934, compression=0.019)
    for power in (0.5, 0.8):
        law = mpm.Sanisand(**given, initialVoidRatio=0.8, pressureExponent=power)
        low, high = (mpm.MaterialPoint(law, -p * np.eye(3)).stiffness for p in (50.0, 200.0))
        assert high[1] / low[1] == pytest.approx(4**power, rel=1e-12)
