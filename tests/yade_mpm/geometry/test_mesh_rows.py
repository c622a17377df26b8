# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbering in rows changes the numbers of a mesh, and nothing else."""

import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import yade_mpm as mpm
from setups import shearedSoil
from yade_mpm.geometry.mesh import Mesh, cellVolumes
from yade_mpm.geometry.meshing import meshRegion, refineNear
from yade_mpm.geometry.meshInput import meshFromArrays

FACE = [(0, 0), (1, 0), (1, 1), (0, 1)]
CORNERS = {2: np.array(FACE), 3: np.array([(*xy, z) for z in (0, 1) for xy in FACE])}
# Ways to begin the corners of a cell elsewhere: once round each axis.
TURNS = {2: [[1, 2, 3, 0]], 3: [[1, 2, 3, 0, 5, 6, 7, 4], [3, 2, 6, 7, 0, 1, 5, 4], [4, 0, 3, 7, 5, 1, 2, 6]]}


def block(counts):
    """Points and cells of a block, row by row, uneven so that no two cells are alike."""
    counts = np.array(counts)
    strides = np.concatenate(([1], np.cumprod(counts[:-1] + 1)))
    points = np.array(list(product(*[range(n + 1) for n in counts[::-1]])), float)[:, ::-1]
    points += 0.02 * np.sin(3.0 * points[:, ::-1] + points)
    cells = np.array(list(product(*[range(n) for n in counts[::-1]])))[:, ::-1]
    return points, (cells[:, None] + CORNERS[len(counts)]) @ strides


def shuffled(points, cells, seed=3):
    """The same mesh with points and cells in any order, and each cell begun at any corner."""
    rng = np.random.default_rng(seed)
    number = rng.permutation(len(points))
    moved = np.empty_like(points)
    moved[number] = points
    cells = number[cells][rng.permutation(len(cells))]
    for turn in TURNS[points.shape[1]]:
        for _ in range(3):
            turns = rng.random(len(cells)) < 0.5
            cells[turns] = cells[turns][:, turn]
    return moved, cells


def rows(cells):
    """Lengths of the stretches in which each corner has the next number in the next cell."""
    ends = np.flatnonzero(~np.all(np.diff(cells, axis=0) == 1, axis=1))
    return np.diff(np.concatenate(([-1], ends, [len(cells) - 1])))


def assertSame(mesh, points, cells):
    """The cells of a mesh are these cells, under other numbers."""
    order = mesh.cellNumbers
    assert np.array_equal(np.sort(order), np.arange(len(cells)))
    centres = points[cells].mean(axis=1)[order]
    assert np.abs(mesh.points[mesh.cells].mean(axis=1) - centres).max() < 1e-14 * np.abs(points).max()
    for mine, given in zip(mesh.points[mesh.cells], points[cells][order]):
        assert np.array_equal(mine[np.lexsort(mine.T)], given[np.lexsort(given.T)])
    volumes = cellVolumes(mesh.points, mesh.cells)
    assert np.abs(volumes - cellVolumes(points, cells)[order]).max() < 1e-13 * volumes.max()  # not mirrored


@pytest.mark.parametrize("counts", [(9, 5), (4, 13), (7, 5, 4), (1, 1), (1, 1, 1), (1, 6)])
def test_a_shuffled_block_gets_its_rows_back(counts):
    points, cells = block(counts)
    mesh = mpm.inRows(meshFromArrays(*shuffled(points, cells), "soil"))
    assert rows(mesh.cells).tolist() == [counts[0]] * int(np.prod(counts[1:]))
    assertSame(mesh, *shuffled(points, cells))
    first = mesh.points[mesh.cells[0]]
    assert np.array_equal(first, points[cells[0]])  # along the axes, from the lowest corner
    if len(cells) > 10:
        assert np.mean(rows(shuffled(points, cells)[1])) < 1.1  # control: there were none


def test_what_is_no_mesh_is_refused():
    with pytest.raises(TypeError, match="inRows: got a tuple; give a Mesh, as meshFromArrays"):
        mpm.inRows(block((2, 2)))
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    with pytest.raises(ValueError, match="'inRows': cell 0 names vertices"):
        mpm.inRows(mpm.Mesh(square, [[0, 1, 2, 2**30]]))
    assert mpm.inRows(mpm.Mesh(square, [[0, 1, 2, 3]])).cells.tolist() == [[0, 1, 3, 2]]  # lists will do


def star(n):
    """Three blocks of n x n cells round a vertex, as in a mesh that a generator paved."""
    points, cells = block((n, n))
    points = points / n
    patches = []
    for k in range(3):
        angle = np.pi / 6 + 2 * np.pi / 3 * k
        a, b = (np.array([np.cos(t), np.sin(t)]) for t in (angle, angle + 2 * np.pi / 3))
        u, v = np.array(list(product(range(n + 1), repeat=2)))[:, ::-1].T[:, :, None] / n
        patches.append(u * a + v * b - 0.2 * u * v * (a + b))
    allPoints, place = np.unique(np.concatenate(patches).round(9), axis=0, return_inverse=True)
    return allPoints, place.ravel()[np.concatenate([cells + k * len(points) for k in range(3)])]


def ring(n, layers):
    angles = 2 * np.pi * np.arange(n) / n
    points = np.concatenate(
        [r * np.stack([np.cos(angles), np.sin(angles)], axis=1) for r in 2 + np.arange(layers + 1)]
    )
    here = np.arange(n * layers)
    next_ = here // n * n + (here + 1) % n
    return points, np.stack([here, here + n, next_ + n, next_], axis=1)


@pytest.mark.parametrize("mesh, least", [(star(12), 0.8), (ring(24, 6), 0.9)], ids=["star", "ring"])
def test_meshes_without_a_lattice(mesh, least):
    points, cells = shuffled(*mesh)
    numbered = mpm.inRows(meshFromArrays(points, cells, "soil"))
    assertSame(numbered, points, cells)
    long = rows(numbered.cells)
    assert long[long >= 8].sum() >= least * len(cells)  # those the solver takes several at a time of
    assert rows(cells).max() < 8  # control


def test_hanging_vertices_hang_on_the_same_edges():
    mesh = refineNear(
        meshRegion(mpm.box((0, 0), (6, 4)), (0, 0), (6, 4), 1, "soil"), np.array([(3.0, 2.0)]), 0.5, 1.0
    )
    numbered = mpm.inRows(mesh)
    assertSame(numbered, mesh.points, mesh.cells)
    assert len(mesh.slaves) > 4
    slaves = numbered.points[numbered.slaves]
    assert np.array_equal(slaves, mesh.points[mesh.slaves])
    assert np.array_equal(numbered.masters < 0, mesh.masters < 0)
    assert (
        np.abs(
            np.einsum("sm,smd->sd", numbered.masterWeights, numbered.points[numbered.masters]) - slaves
        ).max()
        < 1e-15
    )


def test_numbers_of_cells_are_told_through_two_numberings():
    points, cells = shuffled(*block((5, 4)))
    once = mpm.inRows(meshFromArrays(points, cells, "soil"))
    other = Mesh(*shuffled(once.points, once.cells), cellNumbers=once.cellNumbers)
    twice = mpm.inRows(Mesh(once.points, once.cells[::-1], cellNumbers=once.cellNumbers[::-1]))
    assertSame(twice, points, cells)
    with pytest.raises(AssertionError):  # control: cells that have other numbers
        assertSame(mpm.inRows(other), points, cells)


@pytest.mark.parametrize("counts", [(21, 20), (9, 8, 7)])
def test_a_mesh_file_is_numbered_in_rows_and_the_motion_is_the_same(tmp_path, counts):
    meshio = pytest.importorskip("meshio")
    dim = len(counts)
    points, cells = shuffled(*block(counts))
    points = 0.5 + 0.06 * points
    path = tmp_path / "ground.vtk"
    meshio.Mesh(np.pad(points, ((0, 0), (0, 3 - dim))), [({2: "quad", 3: "hexahedron"}[dim], cells)]).write(
        path
    )
    given, filed = (shearedSoil(mesh, dim, 3, pressure=5.0) for mesh in ((points, cells), str(path)))
    assert given.mesh.cellNumbers is None and np.array_equal(given.mesh.cells, cells)
    assert rows(filed.mesh.cells).tolist() == [counts[0]] * int(np.prod(counts[1:]))
    order = filed.mesh.cellNumbers
    assert np.abs(given.stress).max() > 1  # kPa
    assert np.abs(filed.stress - given.stress[order]).max() < 1e-10 * np.abs(given.stress).max()
    assert np.abs(filed.position - given.position[order]).max() < 1e-13
    assert np.abs(filed.stress - given.stress).max() > 0.1  # control: in another order they differ


def test_the_benchmark_times_both_numberings(tmp_path):
    """doc/explanation/performance.md has what it finds."""
    meshio = pytest.importorskip("meshio")
    points, cells = shuffled(*block((12, 10)))
    meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), [("quad", cells)]).write(tmp_path / "soil.vtk")
    script = Path(__file__).resolve().parents[3] / "scripts" / "bench_mesh.py"

    def bench(*arguments):
        return subprocess.run([sys.executable, script, *arguments], capture_output=True, text=True)

    done = bench(tmp_path / "soil.vtk", "--seconds", "0.1")
    assert done.returncode == 0, done.stderr
    name, domains, given, inRows = done.stdout.splitlines()[-1].split()
    assert Path(name).name == "soil.vtk"
    assert int(domains) == 120
    assert float(inRows) > 0 and float(given) > 0  # ns; how many depends on the machine
    lost = bench(tmp_path / "sand.vtk")
    assert lost.returncode == 1 and "there is no file" in lost.stderr and "Traceback" not in lost.stderr
