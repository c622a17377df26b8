# SPDX-License-Identifier: GPL-2.0-or-later
"""The mean stress of meshes beside boxes: a domain in two cells carries none from one to the other."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, softSoil
from yade_mpm import box

CELL = 0.2


def test_a_domain_across_two_cells_keeps_its_mean_stress():
    """A mesh has moved by 0.6 of a cell with boxes. In one step of no length nothing strains."""
    scene = mpm.Scene((0, 0), (6, 4), 0.5, threads=1, gravity=0)
    clay = mpm.MohrCoulombDruckerPrager(density=2.0, young=5e3, poisson=0.3, cohesion=10.0, frictionAngle=0.0)
    boxes = scene.add("boxes", box((1, 1), (2, 3)), clay, mpm.UGIMP(perCell=2))
    mesh = scene.add("mesh", box((2, 1), (4, 3)), clay, mpm.APDI(size=0.5))
    for body in (boxes, mesh):
        body.velocity[:, 0] = 1.0
    scene.run(until=0.3, progress=False)
    for body, perCell in ((boxes, 2), (mesh, 1)):
        sign = (-1.0) ** np.floor(2 * perCell * (body.position[:, 0] - 0.3))
        body.stress = 1e-6 * sign[:, None, None] * np.eye(3)
    before = [body.byId("stress").copy() for body in (boxes, mesh)]
    scene.dt = 1e-6
    scene.run(steps=1, progress=False)
    changes = [np.abs(body.byId("stress") - old).max() for body, old in zip((boxes, mesh), before)]
    assert changes[1] < 1e-12
    assert changes[0] > 1e-6  # control: boxes of a cell share theirs


def test_a_footing_keeps_its_load_where_the_mesh_beside_boxes_flows():
    """Half of a rough strip on weightless soil, boxes below it and a mesh beyond, to a settlement of 0.12 of
    the half width. With stress that leaks from domain to domain the load fell to 0.83 of its largest."""
    half, width, depth = 6.5 * CELL, 14.4, 5.6
    scene = mpm.Scene((0, 0), (width, depth + 3 * CELL), CELL, threads=1)
    angles = dict(frictionAngle=radians(30), dilatancyAngle=radians(30))
    soil = softSoil(cohesion=8.5, density=1.53, young=16400.0, poisson=0.3, **angles)
    zone = box((0, depth - 5 * CELL), (10 * CELL, depth))
    steel = mpm.LinearElastic(density=2.0, young=1e6, poisson=0.2)
    near = scene.add("near", zone, soil, mpm.UGIMP(perCell=2))
    scene.add("far", box((0, 0), (width, depth)) - zone, soil, mpm.APDI(size=CELL, matched=near))
    plate = scene.add("plate", box((0, depth), (6 * CELL, depth + 2 * CELL)), steel, mpm.UGIMP(perCell=2))
    strip = mpm.Drive(plate, velocity=(0, -0.04 * half), ramp=0.3, name="strip")
    history = mpm.History(period=0.03)
    solver = dict(damping=0.3, roller=("left", "right"), fixed="bottom", drive=strip)
    scene.engines = [*chain(**solver), history]
    scene.run(until=3.15, progress=False)
    load = [part.mean() for part in np.array_split(-history["strip.fy"], 10)]
    assert np.mean(load[-3:]) > 0.93 * max(load)
    assert max(load) / half == pytest.approx(256, rel=0.13)
