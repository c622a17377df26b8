# SPDX-License-Identifier: GPL-2.0-or-later
"""A strutted diaphragm wall beside PLAXIS: 30 m deep, dug to 20 m, elastic clay on sand, dry.

Reference: PLAXIS' results for its tutorial "Submerged construction of an excavation", dry and with
elastic soil, as they stand with the tests of Kratos Multiphysics (GeoMechanicsApplication,
comparison_data_dry). There the wall is a plate without thickness; here it is a Beam drawn 1 m thick, bonded
to the soil, in cells of 0.5 m. Tolerance: 10 %, for the lever of the shear on its faces. Control: a wall of
a tenth of the stiffness has half of the moment.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

GRAVITY, TOP, THICKNESS, CELL = 9.81, 50, 1.0, 0.5
CLAY = mpm.LinearElastic(density=16 / GRAVITY, young=12e3, poisson=0.15)
SAND = mpm.LinearElastic(density=17 / GRAVITY, young=120e3, poisson=0.2)


def dug(depths, stiffness=1e6):
    """Force of the strut (compression positive) and moments of the wall at rest, of each depth."""
    scene = mpm.Scene((0, 0), (65, 54), CELL, gravity=GRAVITY, damping=0.5, threads=1)
    scene.fix("bottom")
    scene.roller("left", "right")
    weight = (10 + 16.5 * THICKNESS) / GRAVITY  # the plate's 10 kN/m2, and the soil's that it stands for
    sheet = mpm.Beam(
        [(50, 20), (50, TOP)], EI=stiffness, EA=7.5e6, GA=3.1e6, weight=weight, thickness=THICKNESS
    )
    clay = scene.add("clay", box((0, 30), (65, TOP)) - sheet.region, CLAY, mpm.APDI(size=CELL))
    sand = scene.add("sand", box((0, 0), (65, 30)) - sheet.region, SAND, mpm.APDI(size=CELL))
    wall = scene.add("wall", sheet)
    scene.groundStress(K0={clay: 0.5774, sand: 0.4701}, bodies=[clay, sand])
    scene.attach(mpm.SurfaceLoad(clay, (43, 48), pressure=5))
    scene.run(until=1.5, progress=False)
    strut, found = None, {}
    for depth in depths:
        scene.remove(clay, region=box((50 + THICKNESS / 2, TOP - depth), (65, 54)))
        scene.run(until=scene.time + (1.5 if strut is None else 3.0), progress=False)
        found[depth] = (-strut.force if strut else 0.0, mpm.sectionForces(wall, "y").M)
        if strut is None:
            strut = scene.attach(
                mpm.Spring(wall, at=(50, 49), to=(65, 49), stiffness=4e5 / 15, label="strut")
            )
    return found


@pytest.mark.verifies("Strutted diaphragm wall: strut and moments", reference="PLAXIS", tolerance=0.1)
def testTheWallHasTheForcesOfPlaxis(verified):
    found = dug((2, 10, 20))
    strut, moment = found[20]
    verified(found[10][0], 154.0)
    verified(strut, 320.0)
    verified(-moment.min(), 1390.0)  # between strut and pit
    verified(moment.max(), 1710.0)  # below the pit's floor


@pytest.mark.slow
def testControlASoftWallHasHalfTheMoment():
    _, moment = dug((2, 20), stiffness=1e5)[20]
    assert np.abs(moment).max() < 0.6 * 1710
