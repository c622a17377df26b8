# SPDX-License-Identifier: GPL-2.0-or-later
"""A shear band in softening clay and soil takes the same work in a cell of half the size, by `bandWidth`.

Set-up: a layer of 1 m whose top is driven sideways, with nodes free to move sideways alone: the shear stress
is one number. The strength is least at one height, where a band of one cell forms. Cells of 0.1 and 0.05 m.
Reference: each other; the residual strength at the end. Tolerance: 2 % of the work (0.7 % and 0.004 % found),
15 % of the residual strength. Control: without bandWidth the work falls by 17 and 21 %.

Under a footing and in a slope the soil that softens is wider than a cell, and the load does not follow the
cell: the work of a strip footing on softening clay (mesh, 3.5 and 7 cells per half width) is the same within
5 % without bandWidth (1.5 % found; peak 0.4 %), and 17 % too small in the larger cells with it.
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


def footing(cell, **softening):
    """Mean pressure over the strength, in nine parts of the way of a strip footing that may slide."""
    half, width, depth = (np.floor(3.0 / cell - 0.5 + 1e-6) + 0.5) * cell, 16.0, 8.0
    clay = mpm.Tresca(
        density=2.0, lame=(4e5 / 3, 1e5), undrainedStrength=100.0, remouldedRatio=0.3, **softening
    )
    scene = mpm.Scene((0, 0), (width, depth + 4 * cell), cell=cell, threads=1)
    scene.add("clay", mpm.box((0, 0), (width, depth)), clay, mpm.APDI(size=cell))
    nodes = mpm.box((-cell, depth - 0.1 * cell), (half - 0.4 * cell, depth + 3 * cell))
    plate = mpm.Hold(nodes, velocity=(None, -0.03), ramp=0.3, name="footing")
    scene.engines = chain(roller=("left", "right"), fixed="bottom", hold=plate, damping=0.5)
    impulses = [0.0]
    for end in np.arange(1, 10) * 0.5:
        scene.run(until=end, progress=False)
        impulses.append(abs(plate.impulse[1]))
    return np.diff(impulses) / 0.5 / half / 100.0


@pytest.mark.filterwarnings("ignore:.*is a mesh and flows")
@pytest.mark.verifies(
    "Strip footing on clay that softens, half the cell: work", reference="the whole cell", tolerance=0.05
)
def testTheLoadOfAFootingOnSofteningClayIsNotOfTheCell(verified):
    coarse, fine = footing(0.8, softeningStrain=0.3), footing(0.4, softeningStrain=0.3)
    verified(fine.sum(), coarse.sum())
    assert fine.max() == pytest.approx(coarse.max(), rel=0.05)
    assert fine[-1] < 0.6 * fine.max()
    assert footing(0.8, softeningStrain=0.3, bandWidth=0.4).sum() < 0.87 * fine.sum()
