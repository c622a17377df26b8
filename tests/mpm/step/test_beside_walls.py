# SPDX-License-Identifier: GPL-2.0-or-later
"""A fixed face stops nodes and not the particles beside it. What of their velocity moves nothing ends on a
way of a cell where the soil comes to rest, and the face takes its momentum; soil that flows keeps it."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

everyType = pytest.mark.parametrize(
    "kind",
    [mpm.UGIMP(perCell=2), mpm.APDI(size=0.25), mpm.BSpline(perCell=2)],
    ids=["boxes", "mesh", "splines"],
)


def layer(kind, dim=2, scheme="MUSL"):
    """Soft ground of three cells on a fixed floor, without gravity."""
    scene = mpm.Scene((0,) * dim, (4,) * (dim - 1) + (3,), 0.5, scheme=scheme, threads=1)
    scene.fix("bottom")
    region = box((1,) * (dim - 1) + (0,), (3,) * (dim - 1) + (1.5,))
    body = scene.add("layer", region, mpm.LinearElastic(density=2.0, young=1e3, poisson=0.3), kind)
    scene.dt = 1e-3
    return scene, body


def heap(until):
    """A column of sand that runs out."""
    scene = mpm.Scene((0, 0), (4, 1.5), 0.1, gravity=9.81, threads=1)
    scene.fix("bottom")
    scene.roller("left", "right")
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.8, young=5e3, poisson=0.3, cohesion=0, frictionAngle=radians(28), dilatancyAngle=0
    )
    body = scene.add("sand", box((0, 0), (0.5, 1)), sand, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=1, K0=0.5)
    scene.run(until=until, progress=False)
    return scene, body


def test_a_heap_that_has_come_to_rest_keeps_no_motion():
    """0.077 kJ stayed for good, all of it in the lowest cell, where particles keep what the floor stops."""
    scene, body = heap(2.5)
    assert mpm.diagnostics.kineticEnergy(scene) < 0.03
    assert np.quantile(body.position[:, 0], 0.99) == pytest.approx(2.49, rel=0.05)  # as far as without
    scene.run(until=5, progress=False)
    low = body.position[:, 1] < 0.1
    assert mpm.diagnostics.kineticEnergy(scene) < 0.01
    assert 0.5 * (body.mass[low] @ body.velocity[low] ** 2).sum() < 0.005  # half of it one grain that falls


@everyType
@pytest.mark.parametrize("scheme", ["MUSL", "USL"])
def test_the_face_takes_the_momentum(kind, scheme):
    """Particles of random velocities: their momentum changes by the impulse of the floor, within round-off,
    and they lose energy."""
    scene, body = layer(kind, scheme=scheme)
    rng = np.random.default_rng(1)
    body.velocity = rng.normal(0, 0.1, body.velocity.shape)
    before, energy = body.mass @ body.velocity, mpm.diagnostics.kineticEnergy(scene)
    scene.run(steps=1, progress=False)
    assert (
        0 < 1 - mpm.diagnostics.kineticEnergy(scene) / energy < 1e-3
    )  # there is no stress in the first step
    scene.run(steps=20, progress=False)
    (floor,) = scene.constraints
    assert np.abs(floor.impulse).max() > 1e-3
    assert body.mass @ body.velocity - before == pytest.approx(floor.impulse[:2], abs=1e-12)


@pytest.mark.parametrize("sides", [("left", "bottom"), ("right", "top")])
def test_a_face_takes_from_none_that_does_not_reach_it(sides):
    """Boxes a cell away from the side: all that they lose goes to the face that they lie on."""
    scene = mpm.Scene((0, 0), (4, 4), 0.5, threads=1)
    scene.fix(*sides)
    x, y = ((0.5, 1), (0, 0.5)) if "left" in sides else ((3, 3.5), (3.5, 4))
    law = mpm.LinearElastic(density=2.0, young=1e3, poisson=0.3)
    body = scene.add("row", box((x[0], y[0]), (x[1], y[1])), law, mpm.UGIMP(perCell=2))
    outer = np.abs(body.position[:, 1] - 2) > 1.75
    body.velocity[:, 0] = np.where(outer, 0.3, -0.1)  # the nodes rest
    before = body.mass @ body.velocity
    scene.dt = 1e-3
    scene.run(steps=1, progress=False)
    side, other = scene.constraints
    assert np.abs(side.impulse).max() == 0
    assert np.abs(other.impulse).max() > 1e-6
    assert body.mass @ body.velocity - before == pytest.approx(other.impulse[:2], abs=1e-12)


@everyType
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("profile", [lambda z: z, lambda z: 1 + 0 * z], ids=["shears", "slides"])
def test_ground_that_flows_over_a_fixed_floor_is_not_braked(kind, dim, profile):
    scene, body = layer(kind, dim)
    body.velocity[:, 0] = 0.1 * profile(body.position[:, -1])
    start = body.byId("velocity")
    scene.run(steps=1, progress=False)
    assert body.byId("velocity") == pytest.approx(start, abs=1e-14)


@pytest.mark.parametrize("dt", [1e-3, 1e-2])
def test_what_moves_nothing_ends_on_a_way_of_a_cell(dt):
    """Two rows of boxes in the lowest cell, with the weights phi on the floor, move against each other so
    that the node above rests: e' = -phi e^2 / h."""
    scene, body = layer(mpm.UGIMP(perCell=2))
    scene.dt = dt
    body.inertiaScale = 1e6  # no stress moves it
    lowest, next_ = body.position[:, 1] < 0.25, np.abs(body.position[:, 1] - 0.375) < 0.1
    phi = np.array([0.75, 0.25])
    body.velocity[lowest, 0], body.velocity[next_, 0] = 0.3, -0.1
    scene.run(until=0.1, progress=False)
    middle = np.abs(body.position[:, 0] - 2) < 0.3
    left = np.array([body.velocity[lowest & middle, 0].mean(), -body.velocity[next_ & middle, 0].mean()])
    start = np.array([0.3, 0.1])
    assert start - left == pytest.approx(start - start / (1 + phi * start * scene.time / 0.5), rel=0.08)
