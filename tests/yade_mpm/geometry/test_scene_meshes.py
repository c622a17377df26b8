# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of scenes: surfaces, files, refinement."""

# SPDX-License-Identifier: GPL-2.0-or-later
import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.geometry.meshChecks import checkMesh

CORNERS = {2: np.array([(0, 0), (1, 0), (1, 1), (0, 1)])}
CORNERS[3] = np.array([(*xy, z) for z in (0, 1) for xy in CORNERS[2]])


# --- what the solver could not take -------------------------------------------------------------------------
SQUARES = np.array([(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)], float) * 0.5
TWO = np.array([(0, 1, 4, 3), (1, 2, 5, 4)])


def added(mesh):
    dim = np.shape(mesh.points if isinstance(mesh, mpm.Mesh) else mesh[0])[1]
    dim = min(dim, 3)
    scene = mpm.Scene((0,) * dim, (2,) * dim, 0.5)
    return scene.add("m", mesh, mpm.LinearElastic(density=1.0, lame=(1.0, 1.0)), mpm.APDI())


def hanging(**changes):
    """Two fine cells above a coarse one: vertex 6 hangs on the edge of it; changed by hand."""
    points = np.array([(0, 0), (1, 0), (1, 0.5), (0, 0.5), (0, 1), (1, 1), (0.5, 0.5), (0.5, 1)])
    cells = np.array([(0, 1, 2, 3), (3, 6, 7, 4), (6, 2, 5, 7)])
    parts = dict(points=points, cells=cells, slaves=np.array([6]), masters=np.array([(3, 2, -1, -1)]))
    return mpm.Mesh(**{**parts, "masterWeights": np.array([(0.5, 0.5, 0, 0)]), **changes})


def test_meshes_that_are_right_are_taken():
    assert added((SQUARES, TWO)).count == 2 and added(hanging()).count == 3


@pytest.mark.parametrize(
    "mesh, told",
    [
        (hanging(cells=np.array([(0, 1, 2, 2**30)])), "cell 0 names vertices .*count from zero"),
        (hanging(cells=np.array([(0, 1, 2, -1)])), "cell 0 names vertices"),
        (hanging(cells=np.zeros((0, 4), int)), "cells has the shape"),
        (hanging(cells=np.zeros((3, 8), int)), "cells has the shape"),
        (hanging(cells=np.array([(0, 1, 2, 3.5)])), "cells has the type float64; give vertex numbers"),
        (hanging(masters=np.zeros((0, 4), int)), "masters has 0 numbers, 4 for each of 1 slaves"),
        (hanging(masters=np.array([(-1, -1, -1, -1)])), "a slave has no master"),
        (hanging(masters=np.array([(3, 2**30, -1, -1)])), "masters has .1073741824."),
        (hanging(masters=np.array([(3, 6, -1, -1)])), "a master is a slave itself"),
        (hanging(slaves=np.array([99])), "slaves has .99., and from 0 to 7 is allowed"),
        (hanging(masterWeights=np.array([(0.5, np.nan, 0, 0)])), "masterWeights"),
        (hanging(masterWeights=np.array([(0.5, 0.6, 0, 0)])), "do not sum up to 1"),
        (hanging(masterWeights=np.array([(0.4, 0.6, 0, 0)])), "slave 6 at .* m away from the weighted mean"),
        (hanging(points=np.full((8, 2), np.nan)), "point .0. is not finite"),
        (hanging(points=np.zeros((8, 4))), "points has the shape"),
        ((SQUARES, np.array([TWO[0], TWO[0]])), "cell . at .* lies on another one"),
        ((SQUARES, np.array([TWO[0], np.roll(TWO[0], 1)])), "lies on another one"),
        ((np.concatenate([SQUARES, SQUARES]), np.concatenate([TWO, TWO + 6])), "lies on another one"),
        ((np.concatenate([SQUARES, SQUARES + 0.2]), np.concatenate([TWO, TWO + 6])), "lies on another one"),
        ((np.concatenate([SQUARES, SQUARES * 0.3]), np.concatenate([TWO, TWO + 6])), "lies on another one"),
        ((np.concatenate([SQUARES, [(0.4, 0.9)]]), np.array([*TWO, (0, 1, 4, 6)])), "lies on another one"),
    ],
)
def test_a_mesh_that_would_lead_the_solver_astray_is_refused(mesh, told):
    """Indices of 2^30 and slaves without masters were segmentation faults, cells twice there twice the
    mass."""
    with pytest.raises(ValueError, match=f"'m': .*{told}"):
        added(mesh)


def bars(dim, *places):
    """Mesh of boxes, lower and upper corner each, that share no vertex."""
    corners = CORNERS[dim]
    points = np.concatenate([np.add(low, corners * np.subtract(high, low)) for low, high in places])
    return points, np.arange(len(points)).reshape(-1, len(corners))


CROSSING = {
    "2D": bars(2, ((0, 0.9), (2, 1)), ((0.4, 0), (0.5, 2))),
    "along": bars(2, ((0, 0), (1, 0.01)), ((0.95, 0), (1.95, 0.01))),
    "corner in a wide one": bars(2, ((0, 0), (2, 2)), ((1.9, 1.9), (1.95, 1.91))),
    "3D": bars(3, ((0, 0.9, 0.9), (2, 1, 1)), ((0.4, 0, 0.95), (0.5, 2, 1.05))),
    "plates": bars(3, ((0, 0, 0.9), (2, 2, 0.95)), ((0.9, 0, 0), (0.95, 2, 2))),
}


@pytest.mark.parametrize("name", CROSSING)
@pytest.mark.parametrize("angle", [0, 0.3])
def test_thin_cells_that_cross_are_found(name, angle):
    """Balls around their centres, which were looked at before, are apart."""
    points, cells = CROSSING[name]
    turn = np.eye(points.shape[1])
    turn[:2, :2] = [(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))]
    with pytest.raises(ValueError, match="'m': cell 1 at .* lies on another one"):
        checkMesh("m", mpm.Mesh(points @ turn, cells))


@pytest.mark.parametrize("dim, cells", [(2, 12), (3, 5)])
@pytest.mark.parametrize("seed", range(5))
def test_distorted_meshes_and_thin_cells_side_by_side_are_taken(dim, cells, seed):
    """Warped facets, cells of 1 to 50, and thin ones that touch; in 3D one mesh in its own frame, one
    turned."""
    random = np.random.default_rng(seed)
    whole = meshOf(dim, cells)
    edge = 1 / cells
    isInside = ((whole.points > 0.5 * edge) & (whole.points < 1 - 0.5 * edge)).all(axis=1)
    moved = whole.points + 0.22 * edge * random.uniform(-1, 1, whole.points.shape) * isInside[:, None]
    turn = np.linalg.qr(random.normal(size=(dim, dim)))[0]
    for points in (moved, whole.points * ((1, 0.02, 0.3)[:dim]) @ (turn * np.sign(np.linalg.det(turn)))):
        assert len(checkMesh("m", mpm.Mesh(points, whole.cells)).cells) == cells**dim


def meshOf(dim, cells):
    """A unit cube of boxes that share vertices."""
    points, corners = bars(
        dim, *((np.array(i) / cells, (np.array(i) + 1) / cells) for i in np.ndindex(*[cells] * dim))
    )
    shared, number = np.unique(points.round(9), axis=0, return_inverse=True)
    return mpm.Mesh(shared, number.ravel()[corners])


def test_cells_on_each_other_are_found_in_3d_and_meshes_of_regions_have_none():
    corners = np.array([(*xy, z) for z in (0, 1) for xy in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
    cell = np.arange(8)[None]
    assert added((corners, cell)).count == 1
    for shift in ((0, 0, 0), (0.5, 0, 0), (0, 0, 0.9)):
        twice = np.concatenate([corners, corners + shift])
        with pytest.raises(ValueError, match="lies on another one"):
            added((twice, np.concatenate([cell, cell + 8])))
    assert (
        added((np.concatenate([corners, corners + (1, 0, 0)]), np.concatenate([cell, cell + 8]))).count == 2
    )
