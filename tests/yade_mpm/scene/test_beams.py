# SPDX-License-Identifier: GPL-2.0-or-later
"""Thin beams that the grid bends are warned of."""

import time
import warnings

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import warningsOf
from setups import chain
from yade_mpm import box

ELASTIC = dict(density=2.0, young=1e4, poisson=0.3)


# --- beams ----------------------------------------------------------------------------------------------
def warned(scene):
    return warningsOf(scene.prepare, "bending stiffness")


def beam(height=0.5, perCell=1, **solver):
    scene = mpm.Scene((0, 0), (6, 4), 0.5, threads=1)
    scene.add("beam", box((0, 2), (4, 2 + height)), mpm.LinearElastic(**ELASTIC), mpm.UGIMP(perCell=perCell))
    scene.engines = chain(**solver)
    return scene


@pytest.mark.parametrize(
    "where, load, isBent",
    [
        (box((0, 2.4), (4, 2.6)), dict(pressure=1.0), True),
        (box((0, 2.4), (4, 2.6)), dict(pressureTable=[[0, 0], [1, 5]]), True),
        (box((0, 2.4), (4, 2.6)), dict(tractionTable=[[0, 0, 0], [1, 0, -5]]), True),
        (box((0, 2.4), (4, 2.6)), dict(traction=(0, -1)), True),
        (box((3.9, 2), (4.1, 2.5)), dict(pressure=1.0), False),  # at the end
        (box((3.9, 2), (4.1, 2.5)), dict(tractionTable=[[0, 0, 0], [1, 5, 0]]), False),
        (None, dict(pressure=1.0), False),  # all round
    ],
)
def test_loads_across_a_beam_alone_bend_it_and_axial_ones_do_not(where, load, isBent):
    assert len(warned(loadedBeam((where, load))[0])) == isBent


TOP, BELOW = box((0, 2.4), (4, 2.6)), box((0, 1.9), (4, 2.1))


@pytest.mark.parametrize(
    "loads, isBent",
    [
        ([(TOP, dict(pressure=1.0)), (BELOW, dict(pressure=1.0))], False),
        ([(TOP, dict(pressure=1.0)), (BELOW, dict(pressure=2.0))], True),
        ([(TOP, dict(traction=(1, 0))), (BELOW, dict(traction=(-1, 0)))], True),  # a moment without a force
        ([(box((0, 2.4), (2, 2.6)) + box((2, 1.9), (4, 2.1)), dict(pressure=1.0))], True),  # and another one
        ([(TOP, dict(pressureTable=[[0, 1], [1, 1]])), (BELOW, dict(pressureTable=[[0, 1], [1, 2]]))], True),
        ([(TOP, dict(pressure=1.0, ramp=1.0)), (BELOW, dict(pressure=1.0, ramp=1.0))], False),
        ([(TOP, dict(pressure=1.0, ramp=1.0)), (BELOW, dict(pressure=1.0))], True),
        # equal at 0 s, 1 s and from then on, but one is quadratic in between
        (
            [
                (TOP, dict(pressureTable=[[0, 0], [1, 1]], ramp=1.0)),
                (BELOW, dict(pressureTable=[[0, 0], [1, 1]])),
            ],
            True,
        ),
    ],
)
def test_loads_that_balance_each_other_bend_a_beam_if_they_have_a_moment(loads, isBent):
    assert len(warned(loadedBeam(*loads)[0])) == isBent


def loadedBeam(*loads):
    """Held at its left end; loads: where, and the load."""
    scene = mpm.Scene((0, 0), (6, 4), 0.5, threads=1)
    body = scene.add("beam", box((0, 2), (4, 2.5)), mpm.LinearElastic(**ELASTIC), mpm.APDI(size=0.5))
    scene.engines = chain(*(mpm.BoundaryLoad(body, where, **load) for where, load in loads), fixed="left")
    return scene, body


def test_a_load_that_is_off_bends_nothing_and_one_on_boxes_is_no_error():
    assert warned(loadedBeam((TOP, dict(pressure=1.0, dead=True)))[0]) == []
    scene, body = loadedBeam((TOP, dict(pressure=1.0)))
    body.convert(box((2, 2), (4, 2.5)), mpm.UGIMP(perCell=1))
    scene.remove(scene.bodies[-1])
    warned(scene)


def test_a_long_table_of_a_load_is_looked_at_in_no_time():
    rows = np.column_stack((np.arange(20000), np.zeros(20000)))
    rows[-1, 1] = 1.0
    scene, _ = loadedBeam((TOP, dict(pressureTable=rows)))
    began = time.process_time()
    assert len(warned(scene)) == 1
    assert time.process_time() - began < 2  # 150 s when each row was looked at alone


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_square_section_bends_both_ways(axis):
    scene = mpm.Scene((0, 0, 0), (6, 3, 4), 0.5, threads=1)
    region = box((0, 1, 2), (4, 1.5, 2.5))
    body = scene.add("beam", region, mpm.LinearElastic(**ELASTIC), mpm.APDI(size=0.5))
    force = np.eye(3)[axis]
    pushing = mpm.BoundaryLoad(body, where=box((3.9, 0, 0), (4.1, 3, 4)), traction=force)
    scene.engines = chain(pushing, fixed="left")
    assert len(warned(scene)) == (axis > 0)


@pytest.mark.parametrize("solver, isBent", [(dict(fixed="left"), True), ({}, False)])
def test_a_beam_that_flies_across_bends_where_it_is_held(solver, isBent):
    scene = beam(**solver)
    scene["beam"].velocity[:, 1] = 1.0
    assert len(warned(scene)) == isBent


@pytest.mark.parametrize("axis", [0, 1])
def test_a_body_force_across_a_beam_alone_bends_it(axis):
    scene = beam(fixed="left")
    scene["beam"].bodyForce[:, axis] = 1.0
    assert len(warned(scene)) == (axis == 1)


def test_a_beam_alone_of_one_particle_across_is_warned_of_where_something_bends_it():
    (text,) = warned(beam(gravity=(0, -9.81), fixed="left"))
    assert text.startswith("body 'beam' is one particle wide: its bending stiffness is wrong")
    assert warned(beam(gravity=(0, -9.81), fixed="left", height=1.0)) == []
    assert warned(beam(gravity=(-9.81, 0), fixed="left")) == []  # a bar
    pushed = beam(fixed="left")
    pushed["beam"].velocity[:, 1] = pushed["beam"].position[:, 0]
    assert len(warned(pushed)) == 1


def test_a_beam_that_is_bent_only_later_is_warned_of_then():
    scene = beam(roller="left")
    solver = scene.engines[1]
    scene.run(steps=2, progress=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.run(steps=2, progress=False)
    solver.gravity = (0, -9.81)
    with pytest.warns(UserWarning, match="body 'beam' is one particle wide"):
        scene.run(steps=2, progress=False)
    solver.gravity = (0, -5)
    assert warned(scene) == []  # once


def test_a_beam_that_rigid_bodies_may_hit_and_one_far_from_another_are_alone():
    struck = beam(fixed="left")
    ball = mpm.RigidContact()
    ball.addBody(mpm.rigid.Sphere(0.2), friction=0.4, position=(3.0, 3.0), velocity=(0, -1.0))
    assert warned(struck) == []
    struck.engines = [struck.engines[0], ball, *struck.engines[1:]]
    assert len(warned(struck)) == 1
    for x, isAlone in ((5.0, True), (4.0, False)):
        two = beam(gravity=(0, -9.81), fixed="left")
        two.add("other", box((x, 2), (6, 4)), mpm.LinearElastic(**ELASTIC), mpm.UGIMP())
        assert len(warned(two)) == isAlone


def test_a_column_of_one_particle_between_rollers_is_no_beam():
    scene = mpm.Scene((0, 0), (0.5, 6), 0.5, threads=1)
    scene.add("column", box((0, 0), (0.5, 4)), mpm.LinearElastic(**ELASTIC), mpm.UGIMP(perCell=1))
    scene["column"].velocity[:, 0] = 1e-3 * scene["column"].position[:, 1]
    scene.engines = chain(gravity=(0, -9.81), roller=("left", "right"), fixed="bottom")
    assert warned(scene) == []
