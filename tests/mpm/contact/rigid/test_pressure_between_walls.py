# SPDX-License-Identifier: GPL-2.0-or-later
"""Boxes of soil between rigid walls: contact forces act where the stress of the boxes acts, and the gap
follows the motion that they do work on. With F-bar the mean stress acts once in each place, by a cell or by
the particles. So walls and soil have one stress, no force is left at the nodes that drives particles against
each other, soil keeps its strength, and no energy comes from nowhere.

Controls: walls that press with half of the pressure leave forces; B-splines have other weights, lose
strength, and are told.
"""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, elastic, restarted, softSoil
from yade_mpm import box, rigid

SIDE, PRESSURE = 0.4, 100.0  # m, kPa


def squeezed(dim, material, kind=mpm.UGIMP, at=0.3, overlap=0.0, cell=0.1, **options):
    """A block, its lower corner at `at`, between two walls along each axis: scene, body, contact."""
    scene = mpm.Scene((0,) * dim, (1,) * dim, cell, threads=1)
    body = scene.add("soil", box((0.3,) * dim, (0.7,) * dim), material, kind(perCell=2), **options)
    body.position += at - 0.3
    contact = mpm.RigidContact()
    for axis in range(dim):
        for sign in (-1, 1):
            half, place = np.full(dim, SIDE), np.full(dim, at + SIDE / 2)
            half[axis], place[axis] = 0.05, place[axis] + sign * (SIDE / 2 + 0.05 - overlap)
            contact.addBody(rigid.Box(tuple(half)), position=tuple(place))
    return scene, body, contact


def forceOfPressure(dim, at, share, steps=1, **options):
    """Largest nodal force of a block under a uniform pressure, of which the walls resist a share, over
    pressure times the face of a cell; in the last of some steps."""
    overlap, values = 1e-3, {}
    scene, body, contact = squeezed(dim, elastic(1e4), at=at, overlap=overlap, **options)
    contact.stiffness, scene.dt = share * PRESSURE / overlap, 1e-5
    engines = chain(contact)
    look = mpm.PyRunner(lambda: values.update(scene._core.nodalValues()), iterPeriod=1)
    scene.engines = [*engines[:2], look, *engines[2:]]
    for _ in range(steps):
        body.stress = -PRESSURE * np.eye(3)
        scene.step()
    return np.abs(values["force"]).max() / (PRESSURE * 0.1 ** (dim - 1))


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("at", [0.3, 0.31, 0.337])
def test_a_pressure_on_rows_of_boxes_leaves_no_force_at_the_nodes(dim, at):
    assert forceOfPressure(dim, at, 1.0) < 1e-9
    assert forceOfPressure(dim, at, 0.5) > 0.05, "control"


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("at", [0.31, 0.337])
def test_a_mean_stress_acts_once_where_boxes_lie_in_two_cells(dim, at):
    """With F-bar some of the cells act whole, and boxes of others reach into them. The first step finds what
    walls press."""
    assert forceOfPressure(dim, at, 1.0, steps=2, fbar=True) < 1e-4
    assert forceOfPressure(dim, at, 1.0, steps=1, fbar=True) > 0.05, "control"


def test_what_was_pressed_in_the_steps_before_is_forgotten():
    """Walls carry a block over a line of the grid; a scene that is loaded has seen no step before."""
    scene, body, contact = squeezed(2, elastic(1e4), at=0.31, overlap=1e-3, fbar=True)
    scene.engines, scene.dt = chain(contact), 5e-4
    motion = np.tile([1.0, 0.0, 0.0], (4, 1))
    body.velocity = (1.0, 0.0)
    contact.setStates(contact.positions, contact.orientations, motion, np.zeros_like(motion))
    scene.run(steps=200, progress=False)
    assert body.position[:, 0].min() > 0.41 and contact.contacts > 8  # control
    restarted(scene, 40)


def squeeze(
    dim, until, kind=mpm.UGIMP, rate=0.02, lateral=20.0, cohesion=2.0, friction=30, cell=0.1, **options
):
    """Presses along the last axis, with a slow servo that keeps the pressure along the others. Stress of the
    soil over the strength of Mohr-Coulomb; stress of the walls over that of the soil; the parts of the work
    that nodes do not see, and that came from nowhere."""
    strength = dict(cohesion=cohesion, frictionAngle=radians(friction), dilatancyAngle=0.0)
    soil = softSoil(density=2.0, young=1e4, poisson=0.3, **strength)
    scene, body, contact = squeezed(dim, soil, kind, cell=cell, **options)
    scene.dt = 3e-3 * cell
    scene.engines = chain(contact, damping=0.1)
    place, turn = contact.positions.copy(), contact.orientations.copy()
    sign = np.tile([-1.0, 1.0], dim)
    rows, axes = np.arange(2 * dim), np.repeat(np.arange(dim), 2)
    while scene.time < until:
        sides = place[rows, axes].reshape(dim, 2) @ [-1, 1] - 0.1
        pressure = sign * contact.forces[rows, axes] * sides[axes] / sides.prod()
        speed = np.clip(2e-3 * (lateral * min(1, scene.time / 0.1) - pressure), -0.2, 0.2)
        if scene.time >= 0.3:
            speed[-2:] = rate
        velocity = np.zeros_like(place)
        velocity[rows, axes] = -sign * speed
        contact.setStates(place, turn, velocity, np.zeros_like(place))
        scene.step()
        place += scene.dt * velocity
    d = mpm.diagnostics
    stress = -np.diagonal(body.stress.mean(axis=0))[:dim]
    Kp = np.tan(np.pi / 4 + radians(friction / 2)) ** 2
    strength = stress[:-1].mean() * (Kp - 1) + 2 * cohesion * np.sqrt(Kp)
    kept = d.internalWork(scene) + d.kineticEnergy(scene) + d.dampedEnergy(scene) + contact.springEnergy
    unseen = d.unseenEnergy(scene) / d.workDone(scene)
    return (
        (stress[-1] - stress[:-1].mean()) / strength,
        pressure[-2:].mean() / stress[-1],
        unseen,
        kept / contact.bodyWork - 1,
    )


CLAY = dict(friction=0, cohesion=20.0, cell=0.05)


@pytest.mark.parametrize(
    "dim, until, most, options",
    [(3, 0.95, 0.002, {}), (2, 1.45, 0.002, {"fbar": False}), (2, 1.3, 0.01, {}), (2, 0.833, 0.001, CLAY)],
)
def test_soil_squeezed_between_walls_keeps_its_strength(dim, until, most, options):
    """Strain of 6.5, 11.5, 10 and 8 %; most: of the work that nodes do not see."""
    rate = 0.03 if options is CLAY else 0.02
    strength, walls, unseen, made = squeeze(dim, until, rate=rate, **options)
    assert strength == pytest.approx(1, abs=0.02) and walls == pytest.approx(1, abs=0.01)
    assert unseen < most and abs(made) < 0.01


def test_motion_that_nodes_do_not_see_is_told():
    """B-spline particles lose strength, beyond the limit of `quasiStatic`, 1 %."""
    strength, _, unseen, _ = squeeze(2, 0.95, mpm.BSpline)
    assert strength < 0.95 and unseen > 0.01
