# SPDX-License-Identifier: GPL-2.0-or-later
"""A smooth strip footing on undrained Modified Cam-Clay (waterBulk).

Set-up: weightless clay under 100 kPa, half of the problem, footing and mesh as in test_strength_with_depth.
Reference: (2 + pi) su, with su = M p_f/sqrt(3) in plane strain and p_f = p0 (R/2)^((lambda - kappa)/lambda)
at the critical state; at constant volume the effective path of the law is closed. Tolerance: 5 % (1.2 % too
high for R = 1 and 0.7 % too low for R = 2 found). Controls: su of triaxial compression, M p_f/2, is 13 %
off; drained clay, which compresses, resists with less than 0.7 of it.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

CONFINED, HALF, CELL = 100.0, 3.0, 0.4  # kPa, m, m
WIDTH, DEPTH = 16.0, 8.0  # m
LAMBDA, KAPPA, PHI = 0.2, 0.01, np.radians(25)
M = 6 * np.sin(PHI) / (3 - np.sin(PHI))


def footing(ratio, until, **options):
    """Clay of an overconsolidation ratio, and the mean pressure on it over the last 0.5 s, kPa."""
    clay = mpm.ModifiedCamClay(
        density=2.0,
        compression=LAMBDA,
        swelling=KAPPA,
        frictionAngle=PHI,
        initialVoidRatio=1.0,
        overconsolidationRatio=ratio,
        **options,
    )
    scene = mpm.Scene((0, 0), (WIDTH, DEPTH + 4 * CELL), cell=CELL, threads=1)
    body = scene.add("clay", mpm.box((0, 0), (WIDTH, DEPTH)), clay, mpm.APDI(size=CELL))
    body.setStress(-CONFINED * np.eye(3))
    nodes = mpm.box((-CELL, DEPTH - 0.1 * CELL), (HALF - 0.4 * CELL, DEPTH + 3 * CELL))
    plate = mpm.Hold(nodes, velocity=(None, -0.03), ramp=0.3, name="footing")
    scene.engines = chain(roller=("left", "right"), fixed="bottom", hold=plate, damping=0.5)
    scene.attach(mpm.SurfaceLoad(body, (0, WIDTH), pressure=CONFINED))
    scene.run(until=until - 0.5, progress=False)
    before = plate.impulse[1]
    scene.run(until=until, progress=False)
    return body, abs(plate.impulse[1] - before) / 0.5 / HALF


@pytest.mark.filterwarnings("ignore:.*is a mesh and flows")
@pytest.mark.parametrize("ratio, until", [(1, 5.0), (2, 5.0)])
@pytest.mark.verifies(
    "Strip footing on undrained Cam-Clay: limit load", reference="Prandtl, with su of the law", tolerance=0.05
)
def testAFootingBearsTheUndrainedStrengthOfCamClay(ratio, until, verified):
    critical = CONFINED * (ratio / 2) ** ((LAMBDA - KAPPA) / LAMBDA)
    strength = M * critical / np.sqrt(3)
    body, pressure = footing(ratio, until, waterBulk=1e6)
    verified(pressure, (2 + np.pi) * strength)
    assert pressure < 0.92 * (2 + np.pi) * M * critical * 0.65
    assert np.abs(body.volume / body.initialVolume - 1).max() < 1e-3
    yielding = body.plasticShearStrain > 0.05
    assert yielding.any()
    assert body.effectivePressure[yielding] == pytest.approx(critical, rel=0.05)


def testControlDrainedClayGivesWay():
    assert footing(2, 5.0)[1] < 0.7 * (2 + np.pi) * M * CONFINED / np.sqrt(3)
