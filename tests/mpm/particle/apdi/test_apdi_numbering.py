# SPDX-License-Identifier: GPL-2.0-or-later
"""Rows of a mesh are read and written as vectors, other domains one by one: how a mesh is numbered must not
matter."""

from itertools import product

import numpy as np
import pytest
from setups import shearedSoil


def meshOf(dim, n):
    """An uneven mesh of n domains in each direction, numbered row by row: points, cells."""
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    if dim == 3:
        corners = [(*c, z) for z in (0, 1) for c in corners]
    strides = (n + 1) ** np.arange(dim)
    points = np.array(list(product(np.arange(n + 1.0), repeat=dim)))[:, ::-1] * 0.06
    points += np.random.default_rng(1).uniform(-0.01, 0.01, points.shape)
    cells = np.array(list(product(range(n), repeat=dim)))[:, ::-1]
    return points + 0.5, (cells[:, None] + corners) @ strides


def shear(points, cells):
    """Stress and position of the particles of a block that is sheared."""
    body = shearedSoil((points, cells), points.shape[1], 2)
    return body.stress.copy(), body.position.copy()


@pytest.mark.parametrize("dim, n", [(2, 21), (3, 9)])
def test_the_numbering_of_a_mesh_does_not_matter(dim, n):
    points, cells = meshOf(dim, n)
    random = np.random.default_rng(2)
    order, number = random.permutation(len(cells)), random.permutation(len(points))
    shuffled = np.empty_like(points)
    shuffled[number] = points
    stress, position = shear(points, cells)
    other, moved = shear(shuffled, number[cells][order])
    assert np.abs(stress).max() > 1  # kPa
    assert np.abs(other - stress[order]).max() < 1e-10 * np.abs(stress).max()
    assert np.abs(moved - position[order]).max() < 1e-13
    assert np.abs(other - stress).max() > 0.1  # control: in another order they differ
