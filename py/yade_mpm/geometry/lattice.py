# SPDX-License-Identifier: GPL-2.0-or-later
"""Regular lattices of particles inside regions, and the check that bodies do not overlap.

A region whose edges are not multiples of the particle spacing would silently overlap its
neighbour or leave a gap; it is refused here, before anything runs.
"""

from itertools import product

import numpy as np

from .. import _core
from ..base.wording import shown
from .numbers import floats, formatNumber, formatPoint
from .outline import outlineFacets
from .terrain import Layer

_EDGE_TOLERANCE = 1e-6  # of the spacing
_SAMPLES = {2: 64, 3: 16}  # per edge of a cell that a boundary cuts
_LEAST_SHARE = 0.01  # of a cell that is cut
_BYTES = 36  # of memory for each coordinate of a cell, while it is asked which cells are inside


def latticePoints(region, lower, upper, spacing, name):
    """Centres of the lattice cells inside a region, first axis fastest.

    region: Region. lower, upper: (dim,) corners of the grid; the lattice is anchored at lower.
    spacing: edge of a lattice cell, a number or (dim,). name: of the body, for errors.
    Returns (N, dim). Raises ValueError if the region reaches outside the grid, if one of its
    axis-aligned edges is not a multiple of the spacing from lower, or if no point is inside; MemoryError,
    before memory is taken, if the cells within the bounds of the region do not fit.
    """
    lower = np.asarray(lower, float)
    spacing = asSpacing(spacing, region.dim, name)
    return lower + (cellsInside(region, lower, upper, spacing, name) + 0.5) * spacing


def cellsInside(region, lower, upper, spacing, name):
    """Numbers (N, dim) int of the lattice cells whose centre is inside.

    Arguments, order and errors are those of `latticePoints`.
    """
    spacing = asSpacing(spacing, region.dim, name)
    lower, upper = _asGrid(lower, upper, region, name)
    numbers = _cellsRound(region, lower, upper, spacing, name)
    numbers = numbers[region.contains(lower + (numbers + 0.5) * spacing, closed=False)]
    return _notEmpty(numbers, region, spacing, name)


def cutCells(region, lower, upper, spacing, name):
    """Lattice cells, of which those that the boundary of the region cuts count with the part inside.

    Arguments, order and errors are those of `latticePoints`. Returns the centroids (N, dim) of the parts
    inside, their share of a cell (N,), from 64 x 64 or 16 x 16 x 16 samples, and the numbers (N, dim) of the
    cells. Parts below a hundredth of a cell are left out.
    """
    spacing = asSpacing(spacing, region.dim, name)
    lower, upper = _asGrid(lower, upper, region, name)
    numbers = _cellsRound(region, lower, upper, spacing, name)
    if isinstance(region, Layer):
        centroids, shares = region.shareOf(lower + (numbers + 0.5) * spacing, spacing)
    else:
        centroids, shares = _samples(region, lower, spacing, numbers, np.linspace(0, 1, 5))
        cut, n = (shares > 0) & (shares < 1), _SAMPLES[region.dim]
        centroids[cut], shares[cut] = _samples(region, lower, spacing, numbers[cut], (np.arange(n) + 0.5) / n)
    inside = _notEmpty(np.flatnonzero(shares >= _LEAST_SHARE), region, spacing, name)
    return centroids[inside], shares[inside], numbers[inside]


def cutOutline(region, lower, upper, spacing, name, numbers, centroids):
    """The outline of a region as facets, each carried by one of the cells that `cutCells` returns.

    The first arguments are those of `cutCells`. numbers, centroids: (N, dim), what it returns. Returns for
    each facet the row of its cell (K,), where its middle is from the centroid (K, dim), m, and its outward
    area vector (K, dim), m2 (2D: m).
    """
    from scipy.spatial import cKDTree  # late: 0.1 s, and few need it

    spacing = asSpacing(spacing, region.dim, name)
    lower, upper = _asGrid(lower, upper, region, name)
    block = _cellsRound(region, lower, upper, spacing, name)
    rows, middles, areas = outlineFacets(region, lower, spacing, block)
    strides = _strides(np.ptp(block, axis=0) + 1)
    carrierOf = np.full(len(block), -1)
    carrierOf[(numbers - block[0]) @ strides] = np.arange(len(numbers))
    carriers = carrierOf[rows]
    lost = carriers < 0  # in parts that were left out
    carriers[lost] = cKDTree(centroids).query(middles[lost])[1]
    return carriers, middles - centroids[carriers], areas


def _samples(region, lower, spacing, numbers, steps):
    """Centroids and shares of what is inside of some lattice cells, from samples at `steps` along each
    edge."""
    offsets = np.stack(np.meshgrid(*[steps] * region.dim, indexing="ij"), axis=-1).reshape(-1, region.dim)
    centroids, shares = np.zeros(numbers.shape), np.zeros(len(numbers))
    for chunk in np.array_split(np.arange(len(numbers)), 1 + len(numbers) * len(offsets) // 10**6):
        points = lower + (numbers[chunk, None] + offsets) * spacing
        inside = region.contains(points.reshape(-1, region.dim), closed=False).reshape(points.shape[:2])
        shares[chunk] = inside.mean(axis=1)
        centroids[chunk] = (points * inside[..., None]).sum(axis=1) / np.maximum(inside.sum(axis=1), 1)[
            :, None
        ]
    return centroids, shares


def _cellsRound(region, lower, upper, spacing, name):
    """Numbers (N, dim) int of all lattice cells within the bounds of a region."""
    _requireInside(region, lower, upper, spacing, name)
    for axis, coordinate in region.edges():
        _requireMultiple(region, axis, coordinate, lower[axis], spacing[axis], name)
    start, end = region.bounds()
    first = np.floor((start - lower) / spacing + _EDGE_TOLERANCE)
    last = np.ceil((end - lower) / spacing - _EDGE_TOLERANCE)
    what = f"places of a lattice of spacing {_formatSpacing(spacing)} m within the bounds of the region"
    requireRoom(f"body '{name}'", np.prod(last - first), region.dim * _BYTES, what)
    ranges = [np.arange(a, b) for a, b in zip(first.astype(int), last.astype(int))]
    numbers = np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1)
    return numbers.transpose(*reversed(range(region.dim)), region.dim).reshape(-1, region.dim)


def _notEmpty(cells, region, spacing, name):
    if not len(cells):
        raise ValueError(
            f"body '{name}': empty body: {shown(region)} holds no centre of a lattice of spacing "
            f"{_formatSpacing(spacing)}; enlarge the region or lower the spacing{region.toChange}"
        )
    return cells


def requireRoom(who, count, each, what):
    """Refuses arrays that do not fit into memory: of `count` places, called `what`, each of so many bytes."""
    _core.requireMemory(
        float(count) * each,
        f"{who}: the {count:.3g} {what}",
        "give fewer (a lower perCell, a larger size), or a smaller region, or end other programs",
    )


def asSpacing(spacing, dim, name):
    """Spacing as (dim,) array; raises ValueError unless it is one or dim positive numbers."""
    try:
        array = floats(spacing)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if (
        isinstance(spacing, bool)
        or array.shape not in ((), (dim,))
        or not np.all((array > 0) & np.isfinite(array))
    ):
        raise ValueError(
            f"body '{name}': spacing = {shown(spacing)} must be one positive number or {dim} of them"
        )
    return np.broadcast_to(array, (dim,)).copy()


def checkOverlap(nameA, positionsA, halfSizeA, nameB, positionsB, halfSizeB, orElse=""):
    """Refuse two bodies of which any two box-shaped particle domains overlap; touching is fine.

    name: of each body. positions: (N, dim) centres. halfSize: number, (dim,) or (N, dim). orElse: what
    else the error tells to do.
    Raises ValueError naming both bodies and one place if domains overlap by more than 1e-6 of
    the smallest half size.
    """
    a, halfA = _asBoxes(positionsA, halfSizeA)
    b, halfB = _asBoxes(positionsB, halfSizeB)
    if not len(a) or not len(b):
        return
    hits = firstNear(a, halfA, b, halfB, -1e-6 * min(halfA.min(), halfB.min()))
    overlapping = np.flatnonzero(hits >= 0)
    if len(overlapping):
        i, j = overlapping[0], hits[overlapping[0]]
        start = np.maximum(a[i] - halfA[i], b[j] - halfB[j])
        end = np.minimum(a[i] + halfA[i], b[j] + halfB[j])
        place = ((start + end) / 2).round(9)
        count = f"{len(overlapping)} {'particle' if len(overlapping) == 1 else 'particles'}"
        raise ValueError(
            f"Scene.add: bodies '{nameA}' and '{nameB}' overlap at {formatPoint(place)} "
            f"({count} of '{nameA}'); subtract one region from the other{orElse}"
        )


def firstNear(positionsA, halfSizeA, positionsB, halfSizeB, reach):
    """For each box of A the number of some box of B closer to it than reach, or -1.

    positions: (N, dim) centres. halfSize: number, (dim,) or (N, dim). reach: Euclidean distance
    between the boxes; a negative one asks for boxes that overlap by more than -reach in every direction.
    Returns (NA,) int. Boxes are binned on a lattice as wide as the largest pair; its cost grows
    with the number of boxes per bin.
    """
    a, halfA = _asBoxes(positionsA, halfSizeA)
    b, halfB = _asBoxes(positionsB, halfSizeB)
    found = np.full(len(a), -1)
    if not len(a) or not len(b):
        return found
    width = halfA.max(axis=0) + halfB.max(axis=0) + max(reach, 0.0)
    near = np.flatnonzero(np.all((a > b.min(axis=0) - width) & (a < b.max(axis=0) + width), axis=1))
    if not len(near):
        return found
    # The origin leaves a free bin on every side, so that neighbour numbers never wrap round.
    origin = b.min(axis=0) - 3 * width
    strides = _strides(np.floor((b.max(axis=0) - origin) / width).astype(int) + 4)
    binsB = np.floor((b - origin) / width).astype(int) @ strides
    order = np.argsort(binsB, kind="stable")
    binsA = np.floor((a[near] - origin) / width).astype(int) @ strides
    for offset in product((0, -1, 1), repeat=a.shape[1]):
        pending = np.flatnonzero(found[near] < 0)
        wanted = binsA[pending] + np.dot(offset, strides)
        begin = np.searchsorted(binsB, wanted, "left", sorter=order)
        end = np.searchsorted(binsB, wanted, "right", sorter=order)
        for rank in range(int(np.max(end - begin, initial=0))):
            some = begin + rank < end
            i, j = near[pending[some]], order[begin[some] + rank]
            isNear = _boxDistance(a[i] - b[j], halfA[i] + halfB[j]) < reach
            found[i[isNear]] = j[isNear]
    return found


def _boxDistance(between, halfSum):
    """Distance of two boxes; if they overlap, minus the smallest overlap over the directions."""
    gaps = np.abs(between) - halfSum
    return np.linalg.norm(np.maximum(gaps, 0), axis=1) + np.minimum(gaps.max(axis=1), 0)


def _strides(counts):
    return np.concatenate(([1], np.cumprod(counts[:-1])))


def _asBoxes(positions, halfSize):
    positions, halfSize = np.asarray(positions, float), np.asarray(halfSize, float)
    if positions.ndim != 2 or positions.shape[1] not in (2, 3):
        raise ValueError(f"positions has shape {positions.shape}; give (N, 2) or (N, 3)")
    if halfSize.shape not in ((), positions.shape[1:], positions.shape):
        raise ValueError(
            f"halfSize has shape {halfSize.shape}; give one number, {positions.shape[1:]} "
            f"or {positions.shape}"
        )
    return positions, np.broadcast_to(halfSize, positions.shape)


def _asGrid(lower, upper, region, name):
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    if lower.shape != (region.dim,) or upper.shape != (region.dim,):
        raise ValueError(
            f"body '{name}': {shown(region)} is {region.dim}D, but the grid corners have shapes "
            f"{lower.shape} and {upper.shape}; give both the same number of coordinates"
        )
    return lower, upper


def _requireInside(region, lower, upper, spacing, name):
    start, end = region.bounds()
    slack = _EDGE_TOLERANCE * spacing
    if np.any(start < lower - slack) or np.any(end > upper + slack):
        grid = f"box({formatPoint(lower)}, {formatPoint(upper)})"
        raise ValueError(
            f"body '{name}': the region reaches outside the grid: it spans {formatPoint(start)} to "
            f"{formatPoint(end)}, the grid is {grid}; shrink it or cut it with '& {grid}'{region.toChange}"
        )


def _requireMultiple(region, axis, coordinate, anchor, spacing, name):
    steps = (coordinate - anchor) / spacing
    if abs(steps - round(steps)) <= _EDGE_TOLERANCE:
        return
    below, above = (f"{anchor + k * spacing:.9g}" for k in (np.floor(steps), np.ceil(steps)))
    origin = region.originOf(axis, coordinate)
    raise ValueError(
        f"body '{name}': edge {'xyz'[axis]} = {coordinate:.9g}{origin and f', {origin},'} is not "
        f"a multiple of the spacing "
        f"{spacing:.9g} from the grid corner {anchor:.9g}; move it to {below} or {above}, "
        "or change the spacing"
    )


def _formatSpacing(spacing):
    return formatNumber(spacing[0]) if np.all(spacing == spacing[0]) else formatPoint(spacing)
