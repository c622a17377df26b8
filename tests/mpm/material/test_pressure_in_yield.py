# SPDX-License-Identifier: GPL-2.0-or-later
"""pressureExponent where soil yields: a step is that of constant moduli with the factor of its end.

Set-up: particles under random stress and rates, some of which yield, in one body; each against a point with
constant moduli. Tolerance: 1e-11 of the stress. Control: with the factor of the start it differs by 1e-5.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import strainUnderPressure

BULK, SHEAR = 2e4, 1.2e4
SOFT = dict(cohesion=1.0, frictionAngle=0.25, dilatancyAngle=0.1)
GRAINS = dict(staticFriction=0.25, fastFriction=0.6, grainSize=0.01, density=2.0)
YIELDING = {
    "MohrCoulomb": lambda **C: mpm.MohrCoulomb(**SOFT, density=2.0, **C),
    "MohrCoulombDruckerPrager": lambda **C: mpm.MohrCoulombDruckerPrager(**SOFT, density=2.0, **C),
    "Tresca": lambda **C: mpm.Tresca(undrainedStrength=12.0, density=2.0, **C),
    "MuI": lambda **C: mpm.MuI(**GRAINS, **C),
    "HerschelBulkley": lambda lame, **C: mpm.HerschelBulkley(
        bulk=lame[0] + 2 / 3 * lame[1],
        shearModulus=lame[1],
        yieldStress=12.0,
        consistency=1.0,
        density=2.0,
        **C,
    ),
}


@pytest.mark.parametrize("law", YIELDING)
@pytest.mark.parametrize("m", [0.5, 0.7, 1.0])
def testAStepIsThatOfConstantModuliWithTheFactorOfItsEnd(law, m):
    """Particles that yield beside others that do not, each against a point."""
    made = YIELDING[law](lame=(BULK - 2 / 3 * SHEAR, SHEAR), pressureExponent=m)
    scene = mpm.Scene((0, 0), (8, 8), cell=1.0, threads=1)
    body = scene.add("soil", mpm.box((1, 1), (7, 7)), made, mpm.UGIMP(perCell=2), fbar=False)
    rng = np.random.default_rng(3)
    half = rng.normal(size=(body.count, 3, 3)) * 1.5
    half[:, 2, :2] = half[:, :2, 2] = 0
    before = half + half.transpose(0, 2, 1) - 40 * np.eye(3)
    body.stress = before
    body.velocity[...] = rng.normal(size=body.velocity.shape) * 3
    scene.dt = 1e-3
    scene.run(steps=1, progress=False)
    assert 0.1 < np.mean(body.plasticShearStrain > 0) < 0.9
    ofStart = 0.0
    for i in range(0, body.count, 3):
        L = np.zeros((3, 3))
        L[:2, :2] = body.velocityGradient[i]
        first, last = (strainUnderPressure(s[i], BULK, SHEAR, m)[1:] for s in (before, body.stress))
        for k in (last[0], first[0]):
            lame = (k * (BULK - 2 / 3 * last[1] * SHEAR), k * last[1] * SHEAR)
            point = mpm.MaterialPoint(YIELDING[law](lame=lame), k / first[0] * before[i])
            error = np.abs(point.gradient(L, scene.dt) - body.stress[i]).max() / np.abs(body.stress[i]).max()
            if k == last[0]:
                assert error < 1e-11
                sheared = point.state["plasticShearStrain"]
                assert sheared == pytest.approx(body.plasticShearStrain[i], rel=1e-9, abs=1e-15)
            else:
                ofStart = max(ofStart, error)
    assert ofStart > 1e-5
