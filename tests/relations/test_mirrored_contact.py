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


def shoved(sign):
    """Scene and soil, parted by a wall that is pushed along x, with its foot in the soil and its faces
    between lines of the grid; order of the particles by their places, mirrored with sign = -1."""
    scene = mpm.Scene((0, 0), (6, 4.5), 0.5, threads=1)
    wall = box((2.75, 1), (3.25, 3.5))
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.8, young=3e4, poisson=0.3, cohesion=0.5, frictionAngle=0.5, dilatancyAngle=0
    )
    soil = scene.add("soil", box((0, 0), (6, 3)) - wall, sand, mpm.UGIMP(perCell=2), group="soil", fbar=True)
    stiff = mpm.LinearElastic(density=1.8, young=1e6, poisson=0)
    sheet = scene.add("wall", wall, stiff, mpm.APDI(size=0.25), group="wall")
    scene.initialStress(surface=3, K0=0.5, bodies=[soil])
    drive = mpm.Drive(sheet, velocity=(0.2 * sign, 0), ramp=0.05)
    contact = mpm.Contact(friction=0.2)
    solver = dict(gravity=(0, -9.81), damping=0.2, roller=("left", "right"), fixed="bottom")
    scene.engines = chain(contact=contact, drive=drive, **solver)
    places = soil.byId("reference")
    return scene, soil, np.lexsort(((places - (3, 0)) * (sign, 1)).T)


def test_a_wall_that_parts_soil_moves_it_to_both_sides_alike():
    """At both corners of the foot the normal took the mean motion of the soil on one side alone: after five
    steps the images differed by 7 % of the largest velocity."""
    moved = []
    for sign in (-1, 1):
        scene, soil, order = shoved(sign)
        scene.run(steps=8, progress=False)
        assert scene._core.partedWalls
        moved.append(soil.byId("velocity")[order] * (sign, 1))
    assert np.abs(moved[0] - moved[1]).max() < 1e-4 * np.abs(moved[1]).max()
