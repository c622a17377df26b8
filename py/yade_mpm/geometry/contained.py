# SPDX-License-Identifier: GPL-2.0-or-later
"""Which points lie inside domains: boxes, quadrilaterals or hexahedra."""

import numpy as np

from .lattice import firstNear
from .mesh import FACETS

AT_ONCE = 2_000_000  # pairs of a point and a cell that are looked at in one go


def insideBoxes(points, centres, halfSize):
    """Whether each point (N, dim) is inside a box around one of `centres` (M, dim), half edges (dim,)."""
    return firstNear(points, 0.0, centres, halfSize, 0.0) >= 0


def insideCells(points, corners):
    """Whether each point (N, dim) is inside one of the cells, corners (M, 4 or 8, dim).

    A point is inside where it is behind all facets; those of hexahedra are taken as flat.
    """
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    found = firstNear(points, 0.0, 0.5 * (lower + upper), 0.5 * (upper - lower), 0.0) >= 0
    centres, areas = _facets(corners)
    near = np.flatnonzero(found)
    few = max(1, AT_ONCE // max(1, len(corners)))
    for some in (near[k : k + few] for k in range(0, len(near), few)):
        x = points[some][:, None]
        point, cell = np.nonzero(np.all((x >= lower) & (x <= upper), axis=2))
        ahead = np.einsum("pfk,pfk->pf", points[some][point][:, None] - centres[cell], areas[cell])
        found[some] = False
        found[some[point[np.all(ahead <= 0, axis=1)]]] = True
    return found


def _facets(corners):
    """Centres and outward area vectors of the facets of cells, (M, facets, dim) each."""
    dim = corners.shape[2]
    at = corners[:, FACETS[dim]]
    if dim == 2:
        edge = at[:, :, 1] - at[:, :, 0]
        return at.mean(axis=2), np.stack([edge[..., 1], -edge[..., 0]], axis=-1)
    return at.mean(axis=2), 0.5 * np.cross(at[:, :, 2] - at[:, :, 0], at[:, :, 3] - at[:, :, 1])
