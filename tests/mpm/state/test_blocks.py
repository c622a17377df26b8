# SPDX-License-Identifier: GPL-2.0-or-later
"""Particles grouped by blocks of the grid: what two threads add to the nodes at a time lies apart, along
every axis but the first."""

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.io import checkpoint

H, CELLS, WIDTH = 0.5, 22, 4  # m, cells along each axis but the first, nodes across a block


def flying(dim, axis=1, particles=None):
    """A block of soil that flies along an axis of a grid of three tiles and a part across; scene and body."""
    upper = [2.0] + [CELLS * H] * (dim - 1)
    lower, top = np.full(dim, 0.5), np.array([1.5] + [2.5] * (dim - 1))
    scene = mpm.Scene((0.0,) * dim, upper, H, threads=1)
    body = scene.add(
        "flying",
        mpm.box(lower, top),
        mpm.LinearElastic(density=1.5, young=1e3, poisson=0.3),
        particles or mpm.UGIMP(),
    )
    body.velocity = np.eye(dim)[axis] * 10.0
    scene.dt, scene.allowUnstable = 1e-3, True
    return scene, body


def places(body, first):
    """Of every particle, in the order of its blocks: rows of nodes from the first of its block to the first
    of its support, per axis but the first.

    Blocks are numbered by tiles of two along each axis, tiles with axis 1 fastest."""
    dim = first.shape[1]
    tiles = -(-(CELLS + 5) // (2 * WIDTH))
    start = np.array(body._core.tables()["blockStart"])
    assert len(start) - 1 == (2 * tiles) ** (dim - 1)
    block = np.repeat(np.arange(len(start) - 1), np.diff(start))
    tile, within = block >> (dim - 1), block % 2 ** (dim - 1)
    return np.stack(
        [
            first[:, k] - WIDTH * (2 * (tile // tiles ** (k - 1) % tiles) + (within >> (k - 1)) % 2)
            for k in range(1, dim)
        ],
        axis=1,
    )


@pytest.mark.parametrize("dim, axis", [(2, 1), (3, 1), (3, 2)])
def test_particles_stay_within_a_node_of_their_block(dim, axis):
    scene, body = flying(dim, axis)
    widest = 0
    for _ in range(80):  # 8 m, 16 cells
        scene.run(steps=10, progress=False)
        where = places(body, np.floor(body.position / H + 2 - 0.5).astype(int))
        assert where.min() >= -1 and where.max() <= WIDTH
        widest = max(widest, where.max())
    assert body.position[:, axis].min() > 8 and widest == WIDTH, "no particle ever was out of its block"


@pytest.mark.parametrize("particles", [mpm.UGIMP(), mpm.APDI(size=H / 2)])
def test_a_checkpoint_with_other_blocks_goes_on(tmp_path, particles):
    """Earlier versions cut the grid otherwise: particles are grouped again, and the run differs by
    round-off."""
    scene, body = flying(3, particles=particles)
    body.stress = np.diag([3.0, -2.0, 5.0])
    scene.run(steps=5, progress=False)
    scene.save(tmp_path / "a.h5")
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        tables = file["bodies/0/tables"]
        last = tables["blockStart"][-1]
        del tables["blockStart"]
        tables["blockStart"] = np.array([0, last], np.int32)
    checkpoint.seal(tmp_path / "a.h5")
    other = mpm.load(tmp_path / "a.h5")
    assert len(other["flying"]._core.tables()["blockStart"]) == len(body._core.tables()["blockStart"])
    for one in (scene, other):
        one.run(steps=20, progress=False)
    order, otherOrder = np.argsort(body.id), np.argsort(other["flying"].id)
    assert np.abs(body.position[order] - other["flying"].position[otherOrder]).max() < 1e-12
    assert np.abs(body.stress[order] - other["flying"].stress[otherOrder]).max() < 1e-9
