# SPDX-License-Identifier: GPL-2.0-or-later
"""What every mesh must be before the solver takes it: the one place where that is checked."""

import numpy as np

from .mesh import FACETS, MAX_MASTERS, Mesh
from .numbers import formatPoint
from .overlap import overlappingCell

MOST_VERTICES = 2**31 - 1  # the solver numbers them by 32 bits
OFF_ITS_MASTERS = 1e-6  # of the size of the mesh, hence cells may overlap by as much; round-off is 1e-15


def checkMesh(name, mesh):
    """The mesh with arrays of the right kinds; ValueError, in the name of a body, for what the solver cannot.

    Refused are wrong shapes, numbers that are not finite, vertices and masters out of range or twice in a
    cell, cells that are twice there or lie on each other, and hanging vertices without masters or away from
    them.
    """
    points, cells = _points(name, mesh.points), _integers(name, "cells", mesh.cells)
    corners = 2 ** points.shape[1]
    _require(
        cells.ndim == 2 and cells.shape[1] == corners and len(cells),
        f"mesh '{name}': cells has the shape {cells.shape}; give ({corners} vertices each), and one or more",
    )
    checkIndices(name, points, cells)
    slaves, masters = (_integers(name, what, getattr(mesh, what)) for what in ("slaves", "masters"))
    weights = np.asarray(mesh.masterWeights, float)
    try:
        checkHanging(len(points), slaves, masters, weights)
    except ValueError as error:
        raise ValueError(f"mesh '{name}': {error}; see mpm.Mesh for what hanging vertices need") from None
    _checkPlaces(name, points, slaves, masters, weights)
    _refuseOverlap(name, points, cells)
    return Mesh(points, cells, slaves, masters, weights, mesh.cellNumbers)


def checkIndices(name, points, cells):
    """Refuses cells that name a vertex that is not there."""
    outside = np.any((cells < 0) | (cells >= len(points)), axis=1)
    if np.any(outside):
        k = np.flatnonzero(outside)[0]
        raise ValueError(
            f"mesh '{name}': cell {k} names vertices {cells[k].tolist()}, but the points are "
            f"numbered 0 to {len(points) - 1}; count from zero"
        )


def checkHanging(points, slaves, masters, weights):
    """Refuses hanging vertices that are not in order, or whose masters do not stand by themselves.

    Parameters
    ----------
    points : int, number of vertices.
    slaves, masters, weights : arrays as of `Mesh`; masters may be flat.

    Raises ValueError, which names the table.
    """
    isWhole = np.size(masters) == MAX_MASTERS * len(slaves)
    _require(
        isWhole,
        f"masters has {np.size(masters)} numbers, {MAX_MASTERS} for each of {len(slaves)} slaves are needed",
    )
    masters = np.reshape(masters, (-1, MAX_MASTERS))
    _require(np.shape(weights) == masters.shape, f"masterWeights has the shape {np.shape(weights)}")
    checkRange("slaves", slaves, 0, points)
    checkRange("masters", masters, -1, points)
    _require((np.diff(slaves) > 0).all(), "slaves are not in rising order, or twice there")
    _require((masters[:, 0] >= 0).all(), "a slave has no master")
    _require(not np.isin(masters, slaves).any(), "a master is a slave itself")
    isUsed = masters >= 0
    _require(
        np.isfinite(weights).all() and not np.any(weights[~isUsed]),
        "masterWeights is not zero where no master is",
    )
    _require(
        np.allclose(np.sum(weights, axis=1), 1, atol=1e-9), "the masterWeights of a slave do not sum up to 1"
    )


def checkRange(what, values, first, end):
    """Refuses numbers below `first`, or from `end` on."""
    values = np.asarray(values)
    wrong = values[(values < first) | (values >= end)]
    _require(wrong.size == 0, f"{what} has {wrong[:1].tolist()}, and from {first} to {end - 1} is allowed")


def _points(name, points):
    try:
        points = np.array(points, float)
    except (TypeError, ValueError):
        raise ValueError(
            f"mesh '{name}': points is no array of numbers; give (Nv, 2) or (Nv, 3), m"
        ) from None
    isRight = points.ndim == 2 and points.shape[1] in (2, 3) and 0 < len(points) <= MOST_VERTICES
    _require(isRight, f"mesh '{name}': points has the shape {points.shape}; give (Nv, 2) or (Nv, 3), m")
    bad = np.flatnonzero(~np.all(np.isfinite(points), axis=1))
    _require(not len(bad), f"mesh '{name}': point {bad[:1].tolist()} is not finite; correct it")
    return points


def _integers(name, what, values):
    values = np.array(values)
    isRight = values.dtype.kind in "iu" or values.size == 0
    _require(isRight, f"mesh '{name}': {what} has the type {values.dtype}; give vertex numbers (int)")
    return values.astype(int)


def _checkPlaces(name, points, slaves, masters, weights):
    """Refuses hanging vertices that are not where their masters put them."""
    if not len(slaves):
        return
    masters = np.reshape(masters, (-1, MAX_MASTERS))
    expected = np.einsum("sm,smk->sk", weights, points[np.maximum(masters, 0)])
    away = np.linalg.norm(points[slaves] - expected, axis=1)
    worst = int(np.argmax(away))
    _require(
        away[worst] <= OFF_ITS_MASTERS * np.ptp(points, axis=0).max(),
        f"mesh '{name}': slave {slaves[worst]} at {formatPoint(points[slaves[worst]])} is {away[worst]:.3g} "
        f"m away from the weighted mean of its masters; correct the weights or the point",
    )


def _refuseOverlap(name, points, cells):
    """Refuses cells that lie on each other: as facets that they share tell, and planes between them."""
    table = FACETS[points.shape[1]]
    facets = cells[:, table].reshape(-1, len(table[0]))
    owners = np.repeat(np.arange(len(cells)), len(table))
    order = np.sort(facets, axis=1)
    _, index, counts = np.unique(order, axis=0, return_inverse=True, return_counts=True)
    crowded = np.flatnonzero(counts[index.ravel()] > 2)
    twice = owners[crowded]
    if not len(twice):
        twice = _sameSide(facets, owners, index.ravel(), counts)
    if not len(twice):
        one = overlappingCell(points, cells, OFF_ITS_MASTERS * np.ptp(points, axis=0).max())
        twice = [] if one is None else [one]
    if len(twice):
        place = formatPoint(points[cells[twice[0]]].mean(axis=0).round(9))
        raise ValueError(
            f"mesh '{name}': cell {twice[0]} at {place} lies on another one; each place may be covered once: "
            "remove cells that are twice there"
        )


def _sameSide(facets, owners, index, counts):
    """Cells that share a facet with another one on the same side of it: both go round it alike."""
    shared = np.flatnonzero(counts[index] == 2)
    pairs = shared[np.argsort(index[shared], kind="stable")].reshape(-1, 2)
    first, second = facets[pairs[:, 0]], facets[pairs[:, 1]]
    start = np.argmax(second == first[:, :1], axis=1)
    following = np.take_along_axis(second, ((start + 1) % facets.shape[1])[:, None], axis=1)[:, 0]
    isSame = following == first[:, 1] if facets.shape[1] > 2 else (first == second).all(axis=1)
    return owners[pairs[isSame, 1]]


def _require(isRight, complaint):
    if not isRight:
        raise ValueError(complaint)
