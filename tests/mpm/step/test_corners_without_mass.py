# SPDX-License-Identifier: GPL-2.0-or-later
"""Cells of a mesh with F-bar whose corners no vertex is near: what walls give is what the soil gets."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box


def leaningMesh(left):
    """A mesh in the corner of a closed box, its left edge at `left` from below to its top; boxes on it."""
    scene = mpm.Scene((0, 0), (4, 3), 0.5, threads=1)
    clay = mpm.MohrCoulombDruckerPrager(density=1.6, young=2e4, poisson=0.3, cohesion=500.0, frictionAngle=0)
    heights = [0, 0.25, 0.51, 0.75, 1.0]
    points = [[x + (4 - x) * i / 8, y] for x, y in zip(left, heights) for i in range(9)]
    cells = [[9 * j + i + corner for corner in (0, 1, 10, 9)] for j in range(4) for i in range(8)]
    mesh = scene.add("mesh", (np.array(points), np.array(cells)), clay, mpm.APDI())
    boxes = scene.add("boxes", box((0, 1), (4, 2)), clay, mpm.UGIMP(perCell=2))
    for body in (mesh, boxes):
        body.setStress(-50 * np.eye(3))
    lid = mpm.Hold("top", (None, None))
    scene.engines = chain(roller=("left", "right", "bottom"), hold=lid)
    scene.dt = 1e-4
    return scene


@pytest.mark.parametrize(
    "left", [(0.55, 0.51, 0.25, 0.05, 0), (0.8, 0.6, 0.4, 0.2, 0)], ids=["steep", "flat"]
)
def test_the_momentum_is_what_the_walls_gave(left):
    """The pressure of cells at the wall went to nodes without mass, where it was lost: 12.5 kN/m."""
    scene = leaningMesh(left)
    scene.run(steps=100, progress=False)
    momentum = sum(body.mass @ body.velocity for body in scene.bodies)
    given = [np.array(constraint._core.impulse)[:2] for constraint in scene.constraints]
    assert momentum == pytest.approx(sum(given), abs=1e-12 * np.abs(given).sum())
