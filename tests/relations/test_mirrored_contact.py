# SPDX-License-Identifier: GPL-2.0-or-later
"""A symmetric block that is pulled up moves the soil on its left and right alike.

Its faces lie on lines of the grid, to round-off: 1.2 is no multiple of the number 0.2. Where a face lies a
hair beyond a line, the sites of contact there were others than at the mirrored face, and the shared cell
beside it was closed by a face that does not touch it. Sweeps end at 1e-6 of the motion; 1e-3 of the largest
velocity leaves room for what soil that yields makes of that in 60 steps (0.1 to 1 with the faults).
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box, geotech


def lifted(cell, left, base, width):
    """Scene and soil: a block of four cells that is pulled out of clay, whose surface is 2 m high."""
    top, upper = base + 4 * cell, 2.0
    scene = mpm.Scene((0, 0), (width, 14 * cell), cell, threads=1)
    clay = mpm.Tresca(density=1.8, young=3e3, poisson=0.49, undrainedStrength=10.0)
    ground = box((0, 0), (width, upper)) - box((left, base), (width - left, top))
    soil = scene.add("soil", ground, clay, mpm.UGIMP(perCell=2), group="soil", fbar=True)
    soil.setStress(18 * (soil.position[:, 1] - upper)[:, None, None] * np.eye(3))
    axes = (np.linspace(left, width - left, 9), np.linspace(base, top, 9))
    stiff = mpm.LinearElastic(density=1.8, young=3e3, poisson=0.3)
    mesh = geotech.quadrilaterals(*np.meshgrid(*axes))
    block = scene.add("block", mesh, stiff, mpm.APDI(), group="block")
    drive = mpm.Drive(block, velocity=(0, 0.4), ramp=0.05)
    walls = ("left", "right", "bottom")
    contact = mpm.Contact(friction=0.0)
    scene.engines = chain(contact=contact, drive=drive, roller=walls, gravity=(0, -10))
    return scene, soil


@pytest.mark.parametrize(
    "cell, left, base, width",
    [(0.2, 1.2, 1.4, 3.2), (0.25, 1.5, 1.25, 4.0)],
    ids=["on lines to round-off", "on lines"],
)
def test_a_lifted_block_moves_the_soil_on_both_sides_alike(cell, left, base, width):
    scene, soil = lifted(cell, left, base, width)

    def order(x):
        return np.lexsort(np.round(x.T / cell * 64).astype(int))

    places = soil.byId("position")
    own, mirrored = order(places), order(places * (-1, 1) + (width, 0))
    scene.run(steps=60, progress=False)
    velocity = soil.byId("velocity")
    difference = np.abs(velocity[own] - velocity[mirrored] * (-1, 1)).max()
    assert difference < 1e-3 * np.abs(velocity).max()
