# SPDX-License-Identifier: GPL-2.0-or-later
"""Element tests in one line give what the laws say in closed form."""

import numpy as np
import pytest
import yade_mpm as mpm

PHI, PSI, C = np.radians(32), np.radians(8), 5.0
SAND = dict(density=1.8, young=3e4, poisson=0.3, cohesion=C, frictionAngle=PHI, dilatancyAngle=PSI)
CLAY = dict(
    density=1.7,
    compression=0.2,
    swelling=0.04,
    frictionAngle=np.radians(25),
    initialVoidRatio=1.0,
    poisson=0.2,
    overconsolidationRatio=1.0,
)
M = 6 * np.sin(np.radians(25)) / (3 - np.sin(np.radians(25)))


@pytest.mark.parametrize("law", ["MohrCoulomb", "MohrCoulombDruckerPrager"])
@pytest.mark.parametrize("sign", [1, -1], ids=["compression", "extension"])
def testDrainedTriaxialOfSand(law, sign):
    curve = mpm.elementTest.triaxial(getattr(mpm, law)(**SAND), 100.0, sign * 0.03, steps=150)
    k = (1 + np.sin(PHI)) / (1 - np.sin(PHI))
    axial = 100 * k + 2 * C * np.sqrt(k) if sign > 0 else (100 - 2 * C * np.sqrt(k)) / k
    assert curve.q[-1] == pytest.approx(axial - 100, rel=1e-6)
    np.testing.assert_allclose(curve.stress[:, 0, 0], -100, rtol=1e-7)


def testDilatancyOfSandInTriaxialCompression():
    """Slope of the volume over axial strain: -2 sin(psi)/(1 - sin(psi)), of a potential of Mohr-Coulomb's
    shape."""
    curve = mpm.elementTest.triaxial(mpm.MohrCoulomb(**SAND), 100.0, 0.03, steps=150)
    slope = (curve.volume[-1] - curve.volume[-51]) / (curve.strain[-1] - curve.strain[-51])
    assert slope == pytest.approx(-2 * np.sin(PSI) / (1 - np.sin(PSI)), rel=1e-3)


def testTriaxialTestsOfClayEndAtTheCriticalState():
    clay = mpm.ModifiedCamClay(**CLAY)
    drained = mpm.elementTest.triaxial(clay, 100.0, 1.2, steps=1000)
    assert drained.q[-1] == pytest.approx(3 * M * 100 / (3 - M), rel=2e-3)
    undrained = mpm.elementTest.triaxial(clay, 100.0, 0.3, drained=False, steps=1000)
    assert undrained.q[-1] == pytest.approx(M * 100 * 0.5**0.8, rel=1e-3)
    assert np.abs(undrained.volume).max() < 1e-9


def testAnOedometerFindsTheCompressionLine():
    curve = mpm.elementTest.oedometer(mpm.ModifiedCamClay(**CLAY), 0.2, pressure=50.0, steps=800)
    e = 2.0 * np.exp(-curve.volume) - 1
    late = slice(-200, None)
    slope = np.polyfit(np.log(curve.p[late]), e[late], 1)[0]
    assert slope == pytest.approx(-0.2, rel=0.02)


def testShearOfClayAndCyclesOfIt():
    clay = mpm.Tresca(
        density=1.7, young=5e3, poisson=0.49, undrainedStrength=10, remouldedRatio=0.3, softeningStrain=2.0
    )
    first = mpm.elementTest.simpleShear(clay, 50.0, 0.1, drained=False)
    assert first.q.max() == pytest.approx(10, rel=0.02)
    cycles = mpm.elementTest.simpleShear(clay, 50.0, [0.2, -0.2] * 6, drained=False)
    assert abs(cycles.q[-1]) < 0.4 * 10  # nearly remoulded
    assert "nan" not in repr(cycles)


def testWhatNoMaterialFollowsIsTold():
    with pytest.raises(ValueError, match="pressure = -5"):
        mpm.elementTest.triaxial(mpm.MohrCoulomb(**SAND), -5.0, 0.1)
    with pytest.raises(ValueError, match="steps = 0"):
        mpm.elementTest.triaxial(mpm.MohrCoulomb(**SAND), 5.0, 0.1, steps=0)
    with pytest.raises(TypeError, match="give a material"):
        mpm.elementTest.triaxial("sand", 5.0, 0.1)
    with pytest.raises(ValueError, match="preconsolidatio'; did you mean 'preconsolidation'"):
        mpm.elementTest.triaxial(mpm.ModifiedCamClay(**CLAY), 5.0, 0.1, state={"preconsolidatio": 3})


def testStrainsOfATestAddUp():
    """Drained, elastic: q is Young's modulus times the logarithmic strain, whatever the steps."""
    soil = mpm.LinearElastic(density=1.8, young=1e4, poisson=0.3)
    law = mpm.MohrCoulomb(density=1.8, young=1e4, poisson=0.3, cohesion=1e6, frictionAngle=0.1)
    curve = mpm.elementTest.triaxial(law, 100.0, 0.1, steps=10)
    assert curve.q[-1] == pytest.approx(1000, rel=2e-5)  # of second order in the step
    assert mpm.elementTest.oedometer(soil, 0.1, steps=10).volume[-1] == pytest.approx(0.1, rel=1e-12)
