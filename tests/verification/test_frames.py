# SPDX-License-Identifier: GPL-2.0-or-later
"""Beams whose line turns by 90 degrees beside frame theory, and the same drawn along a width in 3D.

Reference: the stiffness matrix of straight beams that are rigidly joined. Four to eight elements a leg, any
thickness of the mesh up to two cells, any place of the corner in its cell. Control: with all domains a cell
long, so that sections are nearer than that on the inner side of the turn, the L is up to 33 % too stiff.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

EI, EA, WEIGHT, FORCE = 2000.0, 4e6, 0.1, 1e-3
L, U = ((0, 0), (0, 2), (2, 2)), ((0, 0), (0, 2), (1.5, 2), (3, 2), (3, 0))


def frame(points, fixed, force):
    """Displacements (N, 3), m and rad, of joints of straight beams with a force (N, 2), kN, on each."""
    points = np.array(points, float)
    K = np.zeros((3 * len(points),) * 2)
    for a in range(len(points) - 1):
        along = points[a + 1] - points[a]
        length = np.linalg.norm(along)
        c, s = along / length
        T = np.kron(np.eye(2), [[c, s, 0], [-s, c, 0], [0, 0, 1]])
        axial = EA / length * np.array([[1, -1], [-1, 1]])
        x = length
        bending = (
            EI
            / x**3
            * np.array(
                [
                    [12, 6 * x, -12, 6 * x],
                    [6 * x, 4 * x * x, -6 * x, 2 * x * x],
                    [-12, -6 * x, 12, -6 * x],
                    [6 * x, 2 * x * x, -6 * x, 4 * x * x],
                ]
            )
        )
        local = np.zeros((6, 6))
        local[np.ix_([0, 3], [0, 3])], local[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = axial, bending
        K[3 * a : 3 * a + 6, 3 * a : 3 * a + 6] += T.T @ local @ T
    free = np.repeat([k not in fixed for k in range(len(points))], 3)
    u, f = np.zeros(K.shape[0]), np.zeros((len(points), 3))
    f[:, :2] = force
    u[free] = np.linalg.solve(K[np.ix_(free, free)], f.ravel()[free])
    return u.reshape(-1, 3)


def standing(points, at, force, cell, thickness, off, wide=None):
    """Displacement of the section at a point of a folded beam whose feet stand on a fixed base."""
    points = np.array(points, float) + (1.5 + off * cell, 0)
    dim = 2 if wide is None else 3
    section = dict(EI=EI, EA=EA, weight=WEIGHT, thickness=thickness * cell)
    if wide:
        points = np.insert(points, 1, 0.5, axis=1)  # along y
        force, section["width"] = np.insert(np.array(force) * wide, 1, 0), (0, wide, 0)
    scene = mpm.Scene((0,) * dim, (6, 4) if dim == 2 else (6, 1.5, 4), cell, threads=1)
    body = scene.add("frame", mpm.Beam(points, **section))
    place = points[at] if wide is None else points[at] + (0, wide / 2, 0)
    push = mpm.Force(body, tuple(place), tuple(force), width=None if wide is None else 1.01 * max(wide, cell))
    scene.engines = chain(push, gravity=(0,) * dim, fixed="bottom")
    scene.dt = 10.0  # s: each step is a solution of statics
    scene.run(steps=15, progress=False)
    start = np.asarray(body._core.view("vertexReference", True))
    return (body.vertices - start)[np.abs(start[:, 0] - place[0]) < 1e-9].mean(axis=0)


@pytest.mark.parametrize("off", [0, 0.1, 0.5])
@pytest.mark.parametrize("thickness", [0.25, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("cell", [0.5, 0.25])
@pytest.mark.verifies("Beam: L-frame", reference="frame theory", tolerance=0.01)
def test_an_l_frame_gives_way_as_by_frame_theory(cell, thickness, off, verified):
    found = standing(L, 2, (0, -FORCE), cell, thickness, off)
    verified(found[1], frame(L, [0], [(0, 0), (0, 0), (0, -FORCE)])[2, 1])


@pytest.mark.parametrize("thickness, off", [(0.5, 0), (1.0, 0.3), (1.5, 0.5), (2.0, 0.1)])
@pytest.mark.parametrize("cell", [0.5, 0.25])
@pytest.mark.verifies("Beam: U-frame", reference="frame theory", tolerance=0.01)
def test_a_u_frame_sways_as_by_frame_theory(cell, thickness, off, verified):
    force = np.zeros((5, 2))
    force[2, 0] = FORCE
    found = standing(U, 2, (FORCE, 0), cell, thickness, off)
    verified(found[0], frame(U, [0, 4], force)[2, 0])


@pytest.mark.parametrize("thickness, off", [(0.5, 0), (1.0, 0.3), (2.0, 0.1)])
@pytest.mark.verifies("Plate: folded strip", reference="frame theory", tolerance=0.01)
def test_a_folded_strip_in_3d_gives_way_as_by_frame_theory(thickness, off, verified):
    found = standing(L, 2, (0, -FORCE), 0.25, thickness, off, wide=0.5)
    verified(found[-1], frame(L, [0], [(0, 0), (0, 0), (0, -FORCE)])[2, 1])


def test_control_domains_of_a_cell_are_too_stiff_beside_a_corner(monkeypatch):
    monkeypatch.setattr(mpm.Beam, "_longerAtTurns", lambda self, line: np.zeros(len(line)))
    monkeypatch.setattr(mpm.Beam, "_checkFaces", lambda *_: None)
    found = standing(L, 2, (0, -FORCE), 0.5, 1.0, 0)
    assert found[1] / frame(L, [0], [(0, 0), (0, 0), (0, -FORCE)])[2, 1] < 0.75
