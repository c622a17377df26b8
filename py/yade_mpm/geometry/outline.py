# SPDX-License-Identifier: GPL-2.0-or-later
"""The outline of a region as facets, one in each lattice cell that it cuts: marching squares or cubes without
connectivity.

What the corners of the cells are decides; the outline crosses an edge between an inner and an outer corner,
at a place found by bisection. The part of each face of a cell that is inside follows, and by the theorem of
Gauss the area vector of the outline in the cell: minus the sum over its faces. So the facets of a body close
exactly. Corners of the outline within a cell are cut off.
"""

from itertools import product

import numpy as np

# of the spacing; corners are asked that far inside their cell, so that outlines on the lattice lie between
# cells
_INSET = 1e-6
_LEAST = 1e-3  # of a face; smaller facets are left out
_SMALL = 0.2  # of a face; smaller facets are joined to the next
_ROUNDS = 30  # of bisection
_BULGE = 0.1  # of the spacing; how far the middle of a facet may be from the outline in its cell


def outlineFacets(region, lower, spacing, numbers):
    """Facets of a region's outline in the cells of a lattice.

    region: Region. lower, spacing: (dim,) corner of the lattice and edges of a cell, m. numbers: (M, dim)
    int, all cells of a block of the lattice that holds the region, first axis fastest. Returns for each facet
    the row of its cell in `numbers` (K,), its middle (K, dim), m, and its area vector (K, dim), outward, m2
    (2D: m).
    """
    dim, shape = region.dim, np.ptp(numbers, axis=0) + 1
    corners = np.array(list(product((0, 1), repeat=dim)))
    inside = np.concatenate(
        [
            region.contains(
                _cornerPoints(lower, spacing, some, corners).reshape(-1, dim), closed=False
            ).reshape(len(some), -1)
            for some in np.array_split(numbers, 1 + len(numbers) // 10**5)
        ]
    )
    mixed = np.flatnonzero(inside.any(axis=1) & ~inside.all(axis=1))
    crossing = _crossings(
        region, _cornerPoints(lower, spacing, numbers[mixed], corners), inside[mixed], corners
    )
    area, moment = _faces(
        inside, mixed, crossing, corners
    )  # of the part inside of each face, in units of the face
    faceArea = np.prod(spacing) / spacing

    outward = np.stack([area[mixed, k, 0] - area[mixed, k, 1] for k in range(dim)], axis=1) * faceArea
    middle = np.nanmean(crossing.reshape(len(mixed), dim * 2 ** (dim - 1), dim), axis=1)
    rows, middles, outwards = [mixed], [lower + (numbers[mixed] + middle) * spacing], [outward]
    for k, side in product(range(dim), (0, 1)):  # outlines on the faces between cells
        other, there = (
            _shifted(area[:, k, 1 - side], k, side, shape),
            _shifted(moment[:, k, 1 - side], k, side, shape),
        )
        bare = np.flatnonzero(area[:, k, side] - other > _LEAST)
        share = (area[:, k, side] - other)[bare]
        at = np.clip((moment[:, k, side] - there)[bare] / share[:, None], 0, 1)
        at[:, k] = side
        rows.append(bare), middles.append(lower + (numbers[bare] + at) * spacing)
        outwards.append(np.where(np.arange(dim) == k, 2 * side - 1, 0) * (share * faceArea[k])[:, None])
    rows, middles, outwards = map(np.concatenate, (rows, middles, outwards))
    seen = np.linalg.norm(outwards, axis=1) > _LEAST * faceArea.min()
    rows, middles, outwards = _joined(rows[seen], middles[seen], outwards[seen], _SMALL * faceArea.min())
    return rows, _ontoOutline(region, middles, outwards, spacing), outwards


def _cornerPoints(lower, spacing, numbers, corners):
    return lower + (numbers[:, None] + _INSET + (1 - 2 * _INSET) * corners) * spacing


def _crossings(region, points, inside, corners):
    """Where the outline crosses the edges of cells, in units of the cell (M, dim, edges along an axis, dim);
    nan: nowhere."""
    dim = corners.shape[1]
    found = np.full((len(points), dim, 2 ** (dim - 1), dim), np.nan)
    for k in range(dim):
        for e, first in enumerate(np.flatnonzero(corners[:, k] == 0)):
            second = first + 2 ** (dim - 1 - k)
            cut = np.flatnonzero(inside[:, first] != inside[:, second])
            inner, outer = (np.where(inside[cut, first] == isFirst, 0.0, 1.0) for isFirst in (True, False))
            for _ in range(_ROUNDS):
                half = 0.5 * (inner + outer)
                within = region.contains(
                    points[cut, first] + half[:, None] * (points[cut, second] - points[cut, first]),
                    closed=False,
                )
                inner, outer = np.where(within, half, inner), np.where(within, outer, half)
            found[cut, k, e] = corners[first]
            found[cut, k, e, k] = 0.5 * (inner + outer)
    return found


def _faces(inside, mixed, crossing, corners):
    """Area (M, dim, 2) and first moment (M, dim, 2, dim) of the part inside of each face of each cell, in
    units of the cell."""
    count, dim = len(inside), corners.shape[1]
    area = np.broadcast_to(np.where(inside.all(axis=1), 1.0, 0.0)[:, None, None], (count, dim, 2)).copy()
    moment = area[..., None] * 0.5 * (1 - np.eye(dim))[:, None]
    for k, side in product(range(dim), (0, 1)):
        outline = _boundary(inside[mixed], crossing, corners, k, side)
        area[mixed, k, side], moment[mixed, k, side] = (
            _lengths(outline, k) if dim == 2 else _polygons(outline, k)
        )
    return area, moment


def _boundary(inside, crossing, corners, k, side):
    """Corners that are inside and crossings round a face (M, slots, dim), nan where there are none."""
    dim, slots = corners.shape[1], []
    ring = [int(np.flatnonzero((corners == c).all(axis=1))[0]) for c in _ring(dim, k, side)]
    for a, b in zip(ring, ring[1:] + ring[:1]):
        slots.append(np.where(inside[:, a, None], corners[a], np.nan))
        along = int(np.flatnonzero(corners[a] != corners[b])[0])
        slots.append(crossing[:, along, list(np.flatnonzero(corners[:, along] == 0)).index(min(a, b))])
    return np.stack(slots, axis=1)


def _ring(dim, k, side):
    """Corners of a face, each next to the one before."""
    across = [(0,), (1,)] if dim == 2 else [(0, 0), (1, 0), (1, 1), (0, 1)]
    return [(*c[:k], side, *c[k:]) for c in across]


def _lengths(points, k):
    """Length of the part inside of edges, and its first moment."""
    along = points[:, :, 1 - k]
    first, last = np.fmin.reduce(along, axis=1), np.fmax.reduce(along, axis=1)
    length = np.nan_to_num(last - first)
    moment = np.zeros((len(points), 2))
    moment[:, 1 - k] = length * np.nan_to_num(0.5 * (first + last))
    return length, moment


def _polygons(points, k):
    """Area of the part inside of square faces, and its first moment."""
    u, v = (axis for axis in range(3) if axis != k)
    points = points.copy()
    for _ in range(2):  # slots without a point repeat the one before
        for s in range(points.shape[1]):
            empty = np.isnan(points[:, s, 0])
            points[empty, s] = points[empty, s - 1]
    points = np.nan_to_num(points)
    ahead = np.roll(points, -1, axis=1)
    cross = points[:, :, u] * ahead[:, :, v] - points[:, :, v] * ahead[:, :, u]
    moment = ((points + ahead) * cross[..., None]).sum(axis=1) / 6
    area = 0.5 * cross.sum(axis=1)
    moment *= np.sign(area)[:, None]
    moment[:, k] = 0
    return np.abs(area), moment


def _shifted(values, k, side, shape):
    """Those of the next cell along an axis; zero beyond the last."""
    grid = values.reshape(*shape[::-1], *values.shape[1:])
    axis, moved = len(shape) - 1 - k, np.zeros_like(grid)
    low, high = [slice(None)] * len(shape), [slice(None)] * len(shape)
    low[axis], high[axis] = slice(None, -1), slice(1, None)
    if side:
        moved[tuple(low)] = grid[tuple(high)]
    else:
        moved[tuple(high)] = grid[tuple(low)]
    return moved.reshape(values.shape)


def _joined(rows, middles, outwards, small):
    """Facets, those smaller than `small` joined to the next that faces the same way: their direction is not
    well known."""
    from scipy.spatial import cKDTree  # late: 0.1 s, and few need it

    size = np.linalg.norm(outwards, axis=1)
    large, few = size >= small, np.flatnonzero(size < small)
    if not large.any():
        return rows, middles, outwards
    into = np.flatnonzero(large)[cKDTree(middles[large]).query(middles[few])[1]]
    alike = (outwards[few] * outwards[into]).sum(axis=1) > 0.5 * size[few] * size[into]
    kept, few, into = np.ones(len(rows), bool), few[alike], into[alike]
    kept[few] = False
    middles, outwards, weight = middles * size[:, None], outwards.copy(), size.copy()
    for values in (middles, outwards, weight):
        np.add.at(values, into, values[few])
    return rows[kept], (middles / weight[:, None])[kept], outwards[kept]


def _ontoOutline(region, points, outward, spacing):
    """Points moved along a direction onto the outline, where it is near."""
    n = outward / np.maximum(np.linalg.norm(outward, axis=1), 1e-300)[:, None]
    reach = _BULGE * spacing.min()
    inner, outer = np.full(len(points), -reach), np.full(len(points), reach)
    ends = [region.contains(points + t[:, None] * n, closed=False) for t in (inner, outer)]
    for _ in range(_ROUNDS):
        half = 0.5 * (inner + outer)
        within = region.contains(points + half[:, None] * n, closed=False)
        inner, outer = np.where(within, half, inner), np.where(within, outer, half)
    return points + np.where(ends[0] & ~ends[1], 0.5 * (inner + outer), 0)[:, None] * n
