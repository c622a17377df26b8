# SPDX-License-Identifier: GPL-2.0-or-later
"""A shear band in softening clay and soil takes the same work in a cell of half the size, by `bandWidth`.

Set-up: a layer of 1 m whose top is driven sideways, with nodes free to move sideways alone: the shear stress
is one number. The strength is least at one height, where a band of one cell forms. Cells of 0.1 and 0.05 m.
Reference: each other; the residual strength at the end. Tolerance: 2 % of the work (0.7 % and 0.004 % found),
15 % of the residual strength. Control: without bandWidth the work falls by 17 and 21 %.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

SPEED, TRAVEL, WIDTH = 0.1, 0.15, 0.6  # m/s, m, m
RESIDUAL = 3.0  # kPa


def leastAtMiddle(x):
    return 10 - 0.2 * np.exp(-(((x[:, 1] - 0.55) / 0.1) ** 2))


def material(law, **softening):
    given = dict(density=2.0, young=2e3, poisson=0.3, softeningStrain=1.0, **softening)
    if law == "Tresca":
        return mpm.Tresca(**given, undrainedStrength=leastAtMiddle, remouldedRatio=RESIDUAL / 10)
    return mpm.MohrCoulomb(**given, cohesion=leastAtMiddle, frictionAngle=0.0, residualCohesion=RESIDUAL)


def shearStress(law, cell, **softening):
    """Mean shear stress (kPa) of each of 30 parts of the way of the top."""
    scene = mpm.Scene((0, 0), (1, 1.2), cell=cell, threads=1)
    region = mpm.box((0.2, 0), (0.2 + WIDTH, 1))
    soil = scene.add("soil", region, material(law, **softening), mpm.UGIMP(perCell=2))
    sideways = mpm.Hold(mpm.everywhere(2), (None, 0.0), name="sideways")
    top = mpm.Drive(soil.above(1 - cell), (SPEED, 0.0), ramp=0.2)
    scene.engines = chain(hold=[sideways, mpm.Hold("bottom", (0.0, 0.0))], drive=top, damping=0.3)
    stress = []
    for end in np.linspace(0, TRAVEL / SPEED, 31)[1:]:
        impulse, time = top.impulse[0], scene.time
        scene.run(until=end, progress=False)
        stress.append(abs(top.impulse[0] - impulse) / (scene.time - time) / WIDTH)
    return np.array(stress)


@pytest.mark.parametrize("law", ["Tresca", "MohrCoulomb"])
@pytest.mark.verifies(
    "Shear band that softens, cells of 0.05 m: work", reference="cells of 0.1 m", tolerance=0.02
)
def testWorkOfABandIsThatOfTheSoilAndNotOfTheCell(law, verified):
    fine, plain = shearStress(law, 0.05, bandWidth=0.1), shearStress(law, 0.05)
    coarse = shearStress(law, 0.1, bandWidth=0.1)
    verified(fine.sum(), coarse.sum())
    assert plain.sum() < 0.87 * coarse.sum()
    assert plain[-1] == pytest.approx(RESIDUAL, rel=0.15)
