# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact does the same work with a step and with an eighth of it.

A rough wedge of 90 degrees is pressed into Tresca soil by 0.3 m = three cells. One lip more or less on a
facet changes the work of a single run by some 5 %, so the mean over six places between two grid lines is
compared.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box
from yade_mpm.geotech.meshes import wedgedColumn

CELL, DEPTH, RATE, RAMP = 0.1, 0.3, 0.2, 0.05  # m, m, m/s, s
STEP = 1.2e-3  # s, 0.7 of the critical one
LAME = (5000.0, 1000.0)  # kPa


def works(x, dt, isElastic):
    """Work of the drive and of friction, kJ/m."""
    scene = mpm.Scene((-1.5, -1.5), (1.5, 1.0), CELL, threads=1)
    clay = mpm.MohrCoulombDruckerPrager(
        density=1.5, lame=LAME, cohesion=10.0, frictionAngle=0.0, dilatancyAngle=0.0
    )
    scene.add("soil", box((-1.5, -1.5), (1.5, 0)), clay, mpm.UGIMP(perCell=2), fbar=True)
    mesh = wedgedColumn(x, 0.005, 0.4, 0.7, 90.0, CELL / 2)
    steel = mpm.LinearElastic(density=1.5, young=1e6, poisson=0.3) if isElastic else None
    material = steel or mpm.LinearElastic(density=1.5, lame=LAME)
    wedge = scene.add("wedge", mesh, material, mpm.APDI(), group="wedge", implicit=isElastic)
    drive = mpm.Drive(wedge.above(0.35) if isElastic else wedge, velocity=(0, -RATE), ramp=RAMP)
    contact = mpm.Contact(friction=0.3, impactLoss=1.0)
    scene.engines = chain(
        contact=contact, drive=drive, damping=0.05, roller=("left", "right"), fixed="bottom"
    )
    scene.dt = dt
    scene.run(until=DEPTH / RATE + 0.5 * RAMP, progress=False)
    return drive.work, contact.frictionWork


@pytest.mark.parametrize("isElastic", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.verifies(
    "Wedge pressed into clay: work of the drive and of friction",
    reference="an eighth of the step",
    tolerance=0.03,
)
def test_the_work_of_contact_does_not_depend_on_the_step(isElastic, verified):
    places = (0.0, 0.013, 0.025, 0.037, 0.05, 0.07)
    long, short = (np.mean([works(x, dt, isElastic) for x in places], axis=0) for dt in (STEP, STEP / 8))
    verified(long, short)
    assert short[1] > 0.05 * short[0]  # there is friction to be compared
