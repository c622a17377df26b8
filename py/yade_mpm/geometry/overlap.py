# SPDX-License-Identifier: GPL-2.0-or-later
"""Cells of a mesh that lie on each other, however thin they are.

Convex bodies are apart if some axis separates them: in 2D a normal of an edge, in 3D a normal of a facet or
of an edge of each (Gottschalk, Lin & Manocha 1996, doi:10.1145/237170.237244). Only pairs whose boxes overlap
are looked at.
"""

import numpy as np

from .mesh import FACETS

FEW = 48  # cells whose pairs are looked at one by one
MOST_PAIRS = 20_000  # that are looked at at once
SHRINKS, GROWS = 0.8, 1.4  # most of the cells that may be in one half, and in both, or halves are of no use
WARPS = 2  # times by which cells with warped facets may overlap


def overlappingCell(points, cells, tolerance):
    """Number of a cell that lies on another one; None if none does.

    Parameters
    ----------
    points, cells : as of `Mesh`; cells must be convex.
    tolerance : float, m, by which they may. In 3D the warp of their facets counts besides.
    """
    corners = points[cells]
    lower, upper = corners.min(axis=1), corners.max(axis=1) - tolerance
    warp = np.zeros(len(cells)) if points.shape[1] == 2 else WARPS * _warp(corners)
    stack = [np.arange(len(cells))]
    while stack:
        some = stack.pop()
        halves = _halves(some, lower, upper) if len(some) > FEW else None
        if halves:
            stack += halves
            continue
        for first, second in _pairs(some):
            isNear = (lower[first] < upper[second]).all(axis=1) & (lower[second] < upper[first]).all(axis=1)
            first, second = first[isNear], second[isNear]
            allowed = tolerance + warp[first] + warp[second]
            found = np.flatnonzero(_overlap(corners[first], corners[second], allowed))
            if len(found):
                return int(max(first[found[0]], second[found[0]]))
    return None


def _halves(some, lower, upper):
    """Cells on both sides of a plane, those that it cuts on both; None where no plane parts them."""
    best = None
    for k in range(lower.shape[1]):
        middle = np.median(0.5 * (lower[some, k] + upper[some, k]))
        halves = [some[lower[some, k] < middle], some[upper[some, k] > middle]]
        sizes = [len(half) for half in halves]
        isOfUse = max(sizes) <= SHRINKS * len(some) and sum(sizes) <= GROWS * len(some)
        if isOfUse and (best is None or sum(sizes) < sum(map(len, best))):
            best = halves
    return best


def _pairs(some):
    """All pairs of some cells, in pieces."""
    if len(some) <= 200:
        first, second = np.triu_indices(len(some), 1)
        yield some[first], some[second]
        return
    for k in range(len(some) - 1):
        others = some[k + 1 :]
        for begin in range(0, len(others), MOST_PAIRS):
            piece = others[begin : begin + MOST_PAIRS]
            yield np.full(len(piece), some[k]), piece


def _overlap(first, second, allowed):
    """Which of the pairs of cells overlap by more than is allowed, along every axis."""
    left = np.arange(len(first))
    for axes in _axes(first.shape[2]):
        if not len(left):
            break
        a, b = first[left], second[left]
        axis = axes(a, b)  # (pairs, axes, dim)
        size = np.linalg.norm(axis, axis=2)
        one, other = (np.einsum("pad,pcd->pac", axis, x) for x in (a, b))
        depth = np.minimum(one.max(2), other.max(2)) - np.maximum(one.min(2), other.min(2))
        separates = (depth <= allowed[left, None] * size) & (size > 0)  # zero: edges that are parallel
        left = left[~separates.any(axis=1)]
    found = np.zeros(len(first), bool)
    found[left] = True
    return found


def _axes(dim):
    """Functions (cells, cells) -> axes to try, the likely ones first."""
    yield lambda a, b: np.concatenate([_normals(a), _normals(b)], axis=1)
    if dim == 3:
        for edges in _EDGES:
            yield lambda a, b, e=edges: np.cross((a[:, e[1]] - a[:, e[0]])[:, None], _edges(b))


def _normals(corners):
    """Of the facets: in 3D of their diagonals."""
    if corners.shape[2] == 2:
        along = np.roll(corners, -1, axis=1) - corners
        return np.stack([along[..., 1], -along[..., 0]], axis=2)
    a, b, c, d = (corners[:, [facet[k] for facet in FACETS[3]]] for k in range(4))
    return np.cross(c - a, d - b)


_EDGES = sorted(
    {tuple(sorted((facet[k], facet[(k + 1) % 4]))) for facet in FACETS[3] for k in range(4)}
)  # of a hexahedron


def _edges(corners):
    return np.stack([corners[:, j] - corners[:, i] for i, j in _EDGES], axis=1)


def _warp(corners):
    """How far the corners of a facet are from its plane at most, m, of each cell."""
    normals = _normals(corners)
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-300)
    sides = [corners[:, facet[0]] - corners[:, facet[1]] for facet in FACETS[3]]
    return np.abs(np.einsum("cfd,cfd->cf", normals, np.stack(sides, axis=1))).max(axis=1)
