# SPDX-License-Identifier: GPL-2.0-or-later
"""Hourglass control resists what a domain's pattern differs from that of the undeformed one by. Where all
of these are parallelograms there is
nothing to compare with, and the deformation gradient is not asked."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import elastic

EDGE = 0.06
SOIL = elastic(1e3)


def emptyScene(dim):
    return mpm.Scene((0,) * dim, (2,) * dim, 0.1, threads=1)


def meshOf(dim, n, unevenness):
    """A mesh of n domains in each direction whose vertices are off a lattice by a part of the edge: points,
    cells."""
    body = emptyScene(dim).add(
        "lattice", mpm.box((8 * EDGE,) * dim, ((8 + n) * EDGE,) * dim), SOIL, mpm.APDI(size=EDGE)
    )
    return 0.5 - 8 * EDGE + body.vertices + EDGE * np.random.default_rng(1).uniform(
        -unevenness, unevenness, body.vertices.shape
    ), body.cells


def largestForce(points, cells, deform=None, push=0.0):
    """Of a node, kN, without stress; the body may be deformed before, by F in all points alike, and one
    vertex in its middle be pushed by a part of the edge."""
    dim = points.shape[1]
    scene = emptyScene(dim)
    body = scene.add("soil", (points, cells), SOIL, mpm.APDI(hourglass=1))
    if deform is not None:
        body.vertices[...] = 0.5 + (body.vertices - 0.5) @ deform.T
        body.deformationGradient[:, :dim, :dim] = deform
    middle = np.argmin(np.linalg.norm(body.vertices - body.vertices.mean(axis=0), axis=1))
    body.vertices[middle] += push * EDGE
    scene.dt = 2e-4
    for engine in scene.engines[1:]:
        engine.dead = True
    scene.run(steps=1, progress=False)
    return np.abs(scene._core.nodalValues()["force"]).max()


@pytest.mark.parametrize("unevenness", [0, 0.15])
@pytest.mark.parametrize("dim, n", [(2, 11), (3, 5)])
def test_what_is_not_deformed_or_deformed_evenly_is_not_resisted(dim, n, unevenness):
    points, cells = meshOf(dim, n, unevenness)
    F = np.eye(dim) + 0.2 * np.random.default_rng(3).uniform(-1, 1, (dim, dim))
    pushed = largestForce(points, cells, push=0.01)
    assert pushed > 1e-3  # control: a pattern is resisted
    assert largestForce(points, cells) < 1e-10 * pushed
    assert largestForce(points, cells, F) < 1e-10 * pushed
    assert largestForce(points, cells, F, push=0.01) > 0.01 * pushed  # control
