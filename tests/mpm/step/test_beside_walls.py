# SPDX-License-Identifier: GPL-2.0-or-later
"""Particles beside a fixed face, whose nodes do not feel them, are no faster than the nodes that move them:
what they have beyond goes to these nodes, and the face takes no part in it."""

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


def test_a_heap_that_has_come_to_rest_keeps_no_motion():
    """A column of sand runs out. 0.077 kJ stayed where particles keep what the floor does not feel."""
    scene = mpm.Scene((0, 0), (4, 1.5), 0.1, gravity=9.81, threads=1)
    scene.fix("bottom")
    scene.roller("left", "right")
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.8, young=5e3, poisson=0.3, cohesion=0, frictionAngle=radians(28), dilatancyAngle=0
    )
    heap = scene.add("sand", box((0, 0), (0.5, 1)), sand, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=1, K0=0.5)
    scene.run(until=2.5, progress=False)
    low = heap.position[:, 1] < 0.1
    assert mpm.diagnostics.kineticEnergy(scene) < 0.01  # found: 0.0044, above the lowest row
    assert 0.5 * (heap.mass[low] @ heap.velocity[low] ** 2).sum() < 1e-4
    assert np.quantile(heap.position[:, 0], 0.99) > 2.3  # it has run out as far as without: 2.49, now 2.62


@everyType
@pytest.mark.parametrize("scheme", ["MUSL", "USL"])
def test_the_face_takes_what_the_stresses_give_and_no_more(kind, scheme):
    """Particles of random velocities: their momentum changes by the impulse of the floor, within round-off,
    and they lose energy."""
    scene, body = layer(kind, scheme=scheme)
    rng = np.random.default_rng(1)
    body.velocity = rng.normal(0, 0.1, body.velocity.shape)
    before, energy = body.mass @ body.velocity, mpm.diagnostics.kineticEnergy(scene)
    scene.run(steps=1, progress=False)
    assert body.mass @ body.velocity == pytest.approx(before, abs=1e-12), (
        "there is no stress in the first step"
    )
    assert mpm.diagnostics.kineticEnergy(scene) < 0.99 * energy
    scene.run(steps=20, progress=False)
    (floor,) = scene.constraints
    assert np.abs(floor.impulse).max() > 1e-3
    assert body.mass @ body.velocity - before == pytest.approx(floor.impulse, abs=1e-12)


@everyType
@pytest.mark.parametrize("dim", [2, 3])
def test_ground_that_shears_over_a_fixed_floor_is_not_braked(kind, dim):
    """Velocities that grow from 0 at the floor are those of the nodes."""
    scene, body = layer(kind, dim)
    body.velocity[:, 0] = 0.1 * body.position[:, -1]
    start = body.byId("velocity")
    scene.run(steps=1, progress=False)
    assert body.byId("velocity") == pytest.approx(start, abs=1e-14)


@everyType
def test_what_a_fixed_floor_does_not_feel_goes_to_the_nodes_above(kind):
    """The lowest particles alone move: the floor stops nothing of it, and those beside them take it over."""
    scene, body = layer(kind)
    lowest = body.position[:, 1] < 0.2
    body.velocity[lowest, 0] = 0.1
    scene.run(steps=1, progress=False)
    middle = np.abs(body.position[:, 0] - 2) < 0.5
    assert body.velocity[lowest & middle, 0].max() < 0.09
    assert body.velocity[~lowest & middle & (body.position[:, 1] < 0.7), 0].min() > 0.001
