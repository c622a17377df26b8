# SPDX-License-Identifier: GPL-2.0-or-later
"""Empty cells inside of a body with F-bar: what flows out of one is taken by the cells beside it, and their
pressure acts on its corners."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

pytestmark = pytest.mark.filterwarnings("ignore:.*stick together")
CELLS = 7  # along each axis; those in the middle are empty
CLAY = dict(density=1.5, cohesion=10.0, frictionAngle=0, dilatancyAngle=0)
MIDDLE = np.array([CELLS / 2] * 3)


def holed(dim, lame=(1e-3, 1e-3), length=1, halves=False, filled=False):
    """A closed box full of clay but for `length` cells in its middle, along x."""
    scene = mpm.Scene((0,) * dim, (CELLS,) * dim, 1.0)
    low, high = (MIDDLE - 0.5)[:dim], (MIDDLE + 0.5)[:dim] + np.eye(dim)[0] * (length - 1)
    soil = box((0,) * dim, (CELLS,) * dim) - box(low, high)
    left = box((0,) * dim, (CELLS / 2, *[CELLS] * (dim - 1)))
    parts = {"left": soil & left, "right": soil - left} if halves else {"clay": soil}
    clay = mpm.MohrCoulombDruckerPrager(lame=lame, **CLAY)
    bodies = [scene.add(name, part, clay, mpm.UGIMP(perCell=2)) for name, part in parts.items()]
    if filled:
        soft = mpm.LinearElastic(density=1.5, lame=(1e-3, 1e-3))
        scene.add("block", box(low, high), soft, mpm.UGIMP(), group="block")
    walls = ("left", "right", "bottom", "top", "front", "back")[: 2 * dim]
    scene.engines = chain(roller=walls)
    return scene, bodies


def speed(bodies):
    return max(np.abs(body.velocity).max() for body in bodies)


@pytest.mark.parametrize("dim, halves", [(2, False), (3, False), (2, True)])
def test_the_same_pressure_everywhere_moves_nothing(dim, halves):
    scene, bodies = holed(dim, (1e4, 1e3), halves=halves)
    for body in bodies:
        body.setStress(-100 * np.eye(3))
    scene.run(steps=1, progress=False)
    assert speed(bodies) < 1e-12


@pytest.mark.parametrize("what", [dict(length=2), dict(filled=True)])
def test_control_soil_moves_into_a_cavity_and_a_cell_that_is_another_bodys(what):
    scene, bodies = holed(2, (1e4, 1e3), **what)
    bodies[0].setStress(-100 * np.eye(3))
    scene.run(steps=1, progress=False)
    assert speed(bodies) > 1e-2


def growth(scene, bodies, rate=1e-3):
    """Of the sum of the volumes in a step, where particles flow towards the middle: by `rate` and less and
    less; over what flows into the hole."""
    for body in bodies:
        offset = body.position - MIDDLE[: body.position.shape[1]]
        body.velocity[...] = -rate * offset * np.exp(-((offset**2).sum(axis=1)) / 2)[:, None]
    scene.dt = 1e-3
    before = sum(body.volume.sum() for body in bodies)
    scene.run(steps=1, progress=False)
    return (sum(body.volume.sum() for body in bodies) - before) / (rate * scene.dt)


@pytest.mark.parametrize("dim, halves", [(2, False), (3, False), (2, True)])
def test_what_flows_into_a_hole_is_taken_from_the_cells_beside(dim, halves):
    assert abs(growth(*holed(dim, halves=halves))) < 1e-6


def test_control_what_flows_where_another_body_may_be_is_not():
    assert growth(*holed(2, filled=True)) > 0.5
