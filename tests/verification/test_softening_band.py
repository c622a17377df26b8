# SPDX-License-Identifier: GPL-2.0-or-later
"""Softening clay and soil resist alike in cells of half the size, by `softeningLength`.

Shear band: a layer of 1 m whose top is driven sideways, with nodes free to move sideways alone: the shear
stress is one number. The strength is least at one height, where a band forms. Cells of 0.1 and 0.05 m.
Reference: each other. Tolerance: 2 % of the work, 10 % of the width of the band.
Control: with the law of the particle alone the work falls by 8 and 14 %.

Block between smooth plates, compressed by a tenth, cells of 0.1 and 0.05 m: work within 5 %.
Control: with the law of the particle alone it falls by 21 %.

Strip footing on clay (3.5 and 7 cells per half width), and a slope of 4 m: work and run-out within 5 %.
Control: with the law of the particle alone the slope runs out by 21 % more in half the cell.
"""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

SPEED, TRAVEL, WIDTH = 0.1, 0.15, 0.6  # m/s, m, m


def leastAtMiddle(x):
    return 10 - 1.0 * np.exp(-(((x[:, 1] - 0.45) / 0.1) ** 2))


def material(law, **softening):
    given = dict(density=2.0, young=2e3, poisson=0.3, softeningStrain=1.0, **softening)
    if law == "Tresca":
        return mpm.Tresca(**given, undrainedStrength=leastAtMiddle, remouldedRatio=0.3)
    return mpm.MohrCoulomb(**given, cohesion=leastAtMiddle, frictionAngle=0.0, residualCohesion=3.0)


def layer(law, cell, **softening):
    """Mean shear stress (kPa) of each of 30 parts of the way of the top; width of the band (m) at the end."""
    scene = mpm.Scene((0, 0), (1, 1.2), cell=cell, threads=1)
    region = mpm.box((0.2, 0), (0.2 + WIDTH, 1))
    soil = scene.add("soil", region, material(law, **softening), mpm.UGIMP(perCell=2))
    sideways = mpm.Hold(mpm.everywhere(2), (None, 0.0), name="sideways")
    top = mpm.Drive(soil.above(0.9), (SPEED, 0.0), ramp=0.2)
    scene.engines = chain(hold=[sideways, mpm.Hold("bottom", (0.0, 0.0))], drive=top, damping=0.3)
    stress = []
    for end in np.linspace(0, TRAVEL / SPEED, 31)[1:]:
        impulse, time = top.impulse[0], scene.time
        scene.run(until=end, progress=False)
        stress.append(abs(top.impulse[0] - impulse) / (scene.time - time) / WIDTH)
    weight, y = soil.plasticShearStrain * soil.volume, soil.position[:, 1]
    middle = np.average(y, weights=weight)
    return np.array(stress), np.sqrt(12 * np.average((y - middle) ** 2, weights=weight))


@pytest.mark.parametrize("law", ["Tresca", "MohrCoulomb"])
@pytest.mark.verifies(
    "Shear band that softens, cells of 0.05 m: work", reference="cells of 0.1 m", tolerance=0.02
)
def testWorkOfABandIsThatOfTheSoilAndNotOfTheCell(law, verified):
    fine, width = layer(law, 0.05, softeningLength=0.15)
    coarse, widthInLarge = layer(law, 0.1, softeningLength=0.15)
    verified(fine.sum(), coarse.sum())
    assert width == pytest.approx(widthInLarge, rel=0.1)
    assert layer(law, 0.05)[0].sum() < 0.95 * layer(law, 0.1)[0].sum()


def compressed(cell, **softening):
    """Pressure in each of 20 parts of the way of a block whose top is driven down and free sideways, kPa."""
    scene = mpm.Scene((0, 0), (1.9, 1.4), cell=cell, threads=1)
    strength = dict(
        cohesion=10, frictionAngle=radians(20), residualCohesion=2, residualFrictionAngle=radians(10)
    )
    soil = mpm.MohrCoulomb(density=2.0, young=5e3, poisson=0.3, softeningStrain=0.2, **strength, **softening)
    block = scene.add("soil", mpm.box((0.7, 0), (1.2, 1)), soil, mpm.UGIMP(perCell=2))
    top = mpm.Drive(block.above(0.9), (None, -0.05), ramp=0.5)
    scene.engines = chain(roller="bottom", drive=top, damping=0.05)
    impulses = [0.0]
    for end in np.arange(1, 21) * 0.1:
        scene.run(until=end, progress=False)
        impulses.append(abs(top.impulse[1]))
    return np.diff(impulses) / 0.1 / 0.5


@pytest.mark.verifies(
    "Block that softens between smooth plates, half the cell: work",
    reference="the whole cell",
    tolerance=0.05,
)
def testTheWorkOnABlockBetweenPlatesIsNotOfTheCell(verified):
    coarse, fine = (compressed(cell, softeningLength=0.2) for cell in (0.1, 0.05))
    verified(fine.sum(), coarse.sum())
    strength = 2 * 10 * np.tan(np.pi / 4 + radians(10))
    assert fine.max() == pytest.approx(strength, rel=0.04) and fine[-1] < 0.3 * strength
    assert compressed(0.05).sum() < 0.85 * compressed(0.1).sum()


def footing(cell, **softening):
    """Mean pressure over the strength, in nine parts of the way of a strip footing that may slide."""
    half, width, depth = (np.floor(3.0 / cell - 0.5 + 1e-6) + 0.5) * cell, 16.0, 8.0
    strength = dict(undrainedStrength=100.0, remouldedRatio=0.3, softeningStrain=0.1)
    clay = mpm.Tresca(density=2.0, lame=(4e5 / 3, 1e5), **strength, **softening)
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
    coarse, fine = footing(0.8, softeningLength=1.6), footing(0.4, softeningLength=1.6)
    verified(fine.sum(), coarse.sum())
    assert fine.max() == pytest.approx(coarse.max(), rel=0.05)
    assert fine[-1] == pytest.approx(coarse[-1], rel=0.06)
    assert fine[-1] < 0.6 * fine.max()
    assert footing(0.8)[-1] < 0.9 * coarse[-1]


def runOut(cell, **softening):
    """How far the soil of a slope has come past its toe, m: 98 % of it."""
    strength = dict(
        cohesion=6.4, frictionAngle=radians(20), residualCohesion=1.3, residualFrictionAngle=radians(10)
    )
    soil = mpm.MohrCoulomb(density=2.0, young=2e3, poisson=0.3, softeningStrain=0.1, **strength, **softening)
    scene = mpm.Scene((0, 0), (20, 6), cell=cell, threads=1)
    slope = mpm.polygon([(0, 0), (20, 0), (20, 1), (9, 1), (6, 5), (0, 5)])
    body = scene.add("soil", slope, soil, mpm.UGIMP(perCell=2))
    scene.engines = chain(gravity=(0, -9.81), roller=("left", "right"), fixed="bottom")
    scene.run(until=4.0, progress=False)
    return np.quantile(body.position[body.reference[:, 1] > 1, 0], 0.98) - 9


@pytest.mark.verifies(
    "Run-out of a slope that softens, half the cell", reference="the whole cell", tolerance=0.05
)
def testTheRunOutOfASlopeIsNotOfTheCell(verified):
    verified(runOut(0.25, softeningLength=1.0), runOut(0.5, softeningLength=1.0))
    assert runOut(0.25) > 1.15 * runOut(0.5)
