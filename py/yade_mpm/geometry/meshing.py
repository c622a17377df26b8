# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of boxes that fill a region, and their refinement near particles."""

from itertools import product

import numpy as np

from ..base.wording import shown
from .lattice import asSpacing, cellsInside, firstNear, requireRoom
from .mesh import CORNERS, MAX_MASTERS, Mesh

_BYTES = {2: 300, 3: 630}  # of memory for each cell, while they are made


def meshRegion(region, lower, upper, size, name):
    """Mesh of equal boxes whose centres are inside a region.

    region: Region. lower, upper: (dim,) corners of the grid; the mesh is anchored at lower.
    size: edge of a cell, a number or (dim,). name: of the body, for errors.
    Vertices and cells are ordered row by row, first axis fastest. Raises errors as `latticePoints` does.
    """
    size = asSpacing(size, region.dim, name)
    numbers = cellsInside(region, lower, upper, size, name)
    _requireRoom(f"body '{name}'", len(numbers), region.dim)
    vertices, cells = _numberVertices(numbers[:, None] + CORNERS[region.dim])
    return Mesh(np.asarray(lower, float) + vertices * size, cells)


def meshThrough(numbers, positions, edges):
    """Mesh of lattice cells whose corners have moved, each with its cell.

    numbers: (N, dim) int, of the cells in their lattice. positions: (N, dim) centres, m. edges: (N, dim,
    dim), m; column k is edge k of a cell. A vertex is where the cells that meet there have it in the mean.
    Returns the mesh, cells in the order given, and how far each cell had a corner from its vertex (N,), m.
    """
    corners = CORNERS[numbers.shape[1]]
    _, cells = _numberVertices(numbers[:, None] + corners)
    own = positions[:, None] + np.einsum("pij,cj->pci", edges, corners - 0.5)
    at = cells.ravel()
    points = np.stack([np.bincount(at, x) for x in own.reshape(len(at), -1).T], axis=1)
    points /= np.bincount(at)[:, None]
    return Mesh(points, cells), np.linalg.norm(own - points[cells], axis=2).max(axis=1)


def refineNear(mesh, positions, halfSize, distance, ratio=2):
    """Mesh of which the cells close to given particles are split into ratio x ratio (x ratio).

    mesh: equal boxes, as `meshRegion` makes it. positions: (N, dim) particle centres. halfSize: of
    the particle boxes, a number, (dim,) or (N, dim). distance: cells closer than this are split, a
    cell exactly this far (within 1e-6 of the cell edge) is not. ratio: 1, 2, 3 ...
    Hanging vertices become slaves of the coarse edge (2 masters) or face (4 masters) they sit on.
    Vertices and cells are ordered row by row, the cells by centre. Raises ValueError if the mesh
    is refined already or not of equal boxes, or if distance or ratio are out of range.
    """
    if ratio != int(ratio) or ratio < 1:
        raise ValueError(f"refineNear: ratio = {shown(ratio)} must be a whole number from 1 up")
    if not 0 < distance < np.inf:
        raise ValueError(
            f"refineNear: distance = {shown(distance)} must be positive and finite; "
            "one coarse cell edge splits one ring of cells"
        )
    ratio = int(ratio)
    origin, size, numbers = _boxLattice(mesh)
    centres = origin + (numbers + 0.5) * size
    isSplit = firstNear(centres, size / 2, positions, halfSize, distance - 1e-6 * size.min()) >= 0
    if ratio == 1 or not np.any(isSplit):
        return mesh
    # From here on coordinates are whole numbers in units of the fine edge.
    corners = CORNERS[mesh.dim]
    _requireRoom("refineNear", len(numbers) + isSplit.sum() * (float(ratio) ** mesh.dim - 1), mesh.dim)
    coarse = (numbers[~isSplit, None] + corners) * ratio
    children = np.array(list(product(range(ratio), repeat=mesh.dim)))
    fine = (numbers[isSplit, None] * ratio + children).reshape(-1, 1, mesh.dim) + corners
    cellCorners = np.concatenate([coarse, fine])
    cellCorners = cellCorners[np.lexsort(cellCorners.sum(axis=1).T)]  # by centre
    vertices, cells = _numberVertices(cellCorners)
    slaves, masters, weights = _hangingVertices(vertices, coarse[:, 0], ratio)
    points = origin + vertices * (size / ratio)
    points[_find(vertices, _coarseVertices(mesh, numbers) * ratio)] = mesh.points  # to the last bit
    points[slaves] = np.einsum("sm,smd->sd", weights, points[masters])
    return Mesh(points, cells, slaves, masters, weights)


def _requireRoom(who, count, dim):
    requireRoom(who, count, _BYTES[dim], "cells of its mesh")


def _keys(numbers, counts):
    """One number per lattice point, in row order (first axis fastest)."""
    return numbers @ np.concatenate(([1], np.cumprod(counts[:-1])))


def _numberVertices(cellCorners):
    """Shared vertices (Nv, dim) in row order, and cells, from lattice corners (Nc, corners, dim)."""
    shift = cellCorners.min(axis=(0, 1))
    counts = cellCorners.max(axis=(0, 1)) - shift + 1
    _, first, cells = np.unique(_keys(cellCorners - shift, counts), return_index=True, return_inverse=True)
    return cellCorners.reshape(-1, cellCorners.shape[-1])[first], cells.reshape(cellCorners.shape[:2])


def _find(vertices, wanted):
    """Numbers of wanted lattice points among vertices, which are in row order; -1 where absent."""
    shift, counts = vertices.min(axis=0), np.ptp(vertices, axis=0) + 1
    keys, wantedKeys = _keys(vertices - shift, counts), _keys(wanted - shift, counts)
    at = np.minimum(np.searchsorted(keys, wantedKeys), len(keys) - 1)
    return np.where(keys[at] == wantedKeys, at, -1)


def _hangingVertices(vertices, coarse, ratio):
    """Slaves, masters, weights of vertices on edges or faces of unsplit cells, given by lower corner."""
    dim = vertices.shape[1]
    slaves = [np.zeros(0, int)]
    masters = [np.zeros((0, MAX_MASTERS), int)]
    weights = [np.zeros((0, MAX_MASTERS))]
    for local in np.array(list(product(range(ratio + 1), repeat=dim))):
        isInner = (local > 0) & (local < ratio)
        if np.all(isInner) or not np.any(isInner):
            continue
        found = _find(vertices, coarse + local)
        cells, found = coarse[found >= 0], found[found >= 0]
        weight = np.prod(np.where(CORNERS[dim] == 1, local / ratio, 1 - local / ratio), axis=1)
        active = np.flatnonzero(weight)
        corner = np.full((len(found), MAX_MASTERS), -1)
        corner[:, : len(active)] = _find(vertices, cells[:, None] + CORNERS[dim][active] * ratio)
        slaves.append(found)
        masters.append(corner)
        weights.append(np.tile(np.pad(weight[active], (0, MAX_MASTERS - len(active))), (len(found), 1)))
    # A vertex on an edge is met from every coarse cell round it, each time with the same masters.
    slaves, first = np.unique(np.concatenate(slaves), return_index=True)
    masters, weights = np.concatenate(masters)[first], np.concatenate(weights)[first]
    assert not np.any(np.isin(masters, slaves)), "a slave vertex has a slave as master"
    return slaves, masters, weights


def _boxLattice(mesh):
    """Origin, cell edges (dim,) and cell numbers (Nc, dim) of a mesh of equal boxes on a lattice."""
    corners = mesh.points[mesh.cells]
    lower, extent = corners.min(axis=1), np.ptp(corners, axis=1)
    origin, size = mesh.points.min(axis=0), extent[0]
    numbers = np.round((lower - origin) / size).astype(int)
    expected = origin + (numbers[:, None] + CORNERS[mesh.dim]) * size
    if len(mesh.slaves) or np.any(np.abs(corners - expected) > 1e-6 * size):
        raise ValueError(
            "refineNear: the mesh is not made of equal boxes with shared corners; "
            "give it as meshRegion() makes it, and refine once only"
        )
    return origin, size, numbers


def _coarseVertices(mesh, numbers):
    """Lattice coordinates (Nv, dim) of the vertices of a mesh of equal boxes."""
    coordinates = np.zeros((len(mesh.points), mesh.dim), int)
    coordinates[mesh.cells] = numbers[:, None] + CORNERS[mesh.dim]
    return coordinates
