# SPDX-License-Identifier: GPL-2.0-or-later
"""Vertices of fine domains on the edges of coarse ones: what they hold goes to the nodes by way of their
masters, once."""

import numpy as np
import pytest
import yade_mpm as mpm
from nodalTables import giveAnything, givenTo, gotBy, numbersOf
from setups import chain, elastic
from yade_mpm.geometry.mesh import Mesh
from yade_mpm.geometry.meshing import meshRegion, refineNear

EDGE = 1.0


def block(dim, hourglass):
    """A block of coarse domains with fine ones in its middle, its free vertices out of order; scene and
    body."""
    scene = mpm.Scene((0,) * dim, (8,) * dim, EDGE, threads=1)
    region = mpm.box((2,) * dim, (6,) * dim)
    mesh = refineNear(
        meshRegion(region, scene.lower, scene.upper, EDGE, "block"), np.full((1, dim), 3.7), 0.1, 0.5
    )
    assert len(mesh.slaves) >= 4 and len(mesh.cells) > 4**dim
    points = mesh.points + 0.05 * np.random.default_rng(1).uniform(-1, 1, mesh.points.shape) + 0.1
    mesh = Mesh(onMasters(points, mesh), mesh.cells, mesh.slaves, mesh.masters, mesh.masterWeights)
    body = scene.add("block", mesh, elastic(1e3), mpm.APDI(hourglass=hourglass))
    scene.engines = chain()
    scene.dt, scene.allowUnstable = 1e-4, True
    return scene, body


def onMasters(values, mesh):
    """Values at the vertices, those of slaves the means of their masters."""
    values = values.copy()
    values[mesh.slaves] = np.einsum("sm,smd->sd", mesh.masterWeights, values[mesh.masters])
    return values


def hats(scene, points):
    """S_i (nodes, points): products of hats of one cell's width."""
    return np.maximum(1 - np.abs(scene.nodePositions()[:, None] - points) / EDGE, 0).prod(axis=2)


@pytest.mark.parametrize("dim", [2, 3])
def test_nodes_get_what_the_weights_say(dim):
    scene, body = block(dim, hourglass=0)
    giveAnything(body, dim)
    expected, found = givenTo(scene, body), gotBy(scene)
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()
    assert found[:, 0].sum() == pytest.approx(body.mass.sum(), rel=1e-14)


@pytest.mark.parametrize("dim", [2, 3])
def test_vertices_get_the_work_that_hourglass_control_loses(dim):
    """-f u = dU/dt for any velocities u of the nodes, in a mesh of uneven domains that is deformed: its
    vertices move by their hats, and F by L = sum u (x) grad phi."""
    scene, body = block(dim, hourglass=0.1)
    rng = np.random.default_rng(2)
    body.vertices[...] = onMasters(body.vertices + 0.1 * rng.uniform(-1, 1, body.vertices.shape), body.mesh)
    body.deformationGradient[:, :dim, :dim] += 0.2 * rng.uniform(-1, 1, (body.count, dim, dim))
    number = numbersOf(scene)
    u, L = rng.normal(size=(len(number), dim)), np.zeros((body.count, 3, 3))
    for p in range(body.count):
        for x, _, gradient in body.weights(p):
            L[p, :dim, :dim] += np.outer(u[number[tuple(np.round(x, 6))]], gradient)
    power = (gotBy(scene)[:, 1 + dim :] * u).sum()
    start, F = body.vertices.copy(), body.deformationGradient.copy()
    velocity, energies = onMasters(hats(scene, start).T @ u, body.mesh), []
    for dt in 1e-5, -1e-5:
        body.vertices[...] = start + dt * velocity
        body.deformationGradient[...] = F + dt * L @ F
        energies.append(body.hourglassEnergy)
    assert abs(power) > 0.01 * energies[0]  # control
    assert -power == pytest.approx((energies[0] - energies[1]) / 2e-5, rel=1e-6)
