# SPDX-License-Identifier: GPL-2.0-or-later
"""Methods of a scene about the nodes of its grid: where they are, and which lie on a face or in a region."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..base.kinds import NUMBERS, TEXT, takes
from ..base.wording import didYouMean, shown
from ..engine.prescribed import FACES
from ..geometry.region import Region

ROUND_OFF = 1e-6  # of lengths
GHOSTS = 2  # layers of nodes outside of the grid, on the lower side of each axis


def nodePositions(scene) -> np.ndarray:
    """Positions of all grid nodes, ghosts included, m (Nn, dim); first axis fastest."""
    axes = [
        scene.lower[k] + (np.arange(scene._core.nodes[k]) - GHOSTS) * scene.cell[k] for k in range(scene.dim)
    ]
    if scene.isGraded:
        axes = [np.array(x) for x in scene._core.lines]
    return np.stack([a.ravel(order="F") for a in np.meshgrid(*axes, indexing="ij")], axis=1)


@takes(points=NUMBERS)
def cellSizeAt(scene, points: ArrayLike) -> np.ndarray:
    """Edges of the grid's cells in which points lie, m (N, dim).

    Parameters
    ----------
    points : (N, dim) m; where they are outside of the grid, the cell beside them counts.

    Raises ValueError for points of another shape.
    """
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] != scene.dim:
        raise ValueError(f"cellSizeAt: points has shape {points.shape}; give (N, {scene.dim})")
    if not scene.isGraded:
        return np.tile(scene.cell, (len(points), 1))
    sizes = np.empty(points.shape)
    for k, x in enumerate(scene.lines):
        above = np.searchsorted(x[1:-1], points[:, k], "right")  # the line above it, but for the last cell
        sizes[:, k] = x[above + 1] - x[above]
    return sizes


def onLinesBetween(scene, start, end):
    """Points (N, dim), m, where a line along an axis, with an end between lines of the grid, crosses these,
    a cell or more from both ends; None where there are none, and for other lines and cells that differ.

    Nodes half-way between two of a body's cross-sections would move as it does not feel.
    """
    along = np.abs(end - start)
    k = int(np.argmax(along))
    if np.delete(along, k).max() > ROUND_OFF * along[k]:
        return None
    x, (low, high) = scene.lines[k], np.sort([start[k], end[k]])
    ends = np.array([np.abs(x - place).min() for place in (low, high)])
    between = x[(x > low) & (x < high)]
    points = np.repeat(start[None], len(between), axis=0)
    points[:, k] = between if end[k] > start[k] else between[::-1]
    sizes = cellSizeAt(scene, np.concatenate((start[None], points, end[None])))
    if ends.max() <= ROUND_OFF * along[k] or sizes.max(axis=1).max() > (1 + ROUND_OFF) * sizes[:, k].min():
        return None
    away = np.minimum(points[:, k] - low, high - points[:, k])
    isFar = away >= (1 - ROUND_OFF) * sizes[1:-1, k]
    return points[isFar] if isFar.any() else None


@takes(face=TEXT)
def faceNodes(scene, face: str) -> np.ndarray:
    """Numbers of the nodes on and behind a face of the grid.

    Parameters
    ----------
    face : str, name of the face, such as "left".

    Raises ValueError for a face that the grid does not have.
    """
    if face not in FACES[scene.dim]:
        raise ValueError(f"Scene: there is no face {shown(face)}; faces are {', '.join(FACES[scene.dim])}")
    axis, side = FACES[scene.dim][face]
    x = scene.nodePositions()[:, axis]
    tolerance = 1e-6 * scene.cell[axis]
    if side == 0:
        return np.flatnonzero(x <= scene.lower[axis] + tolerance)
    return np.flatnonzero(x >= scene.upper[axis] - tolerance)


def requireSides(scene, call, sides, hint=""):
    """TypeError unless sides are names, ValueError for one that the grid does not have; hint : what to do."""
    known = FACES[scene.dim]
    if not sides or not all(isinstance(side, str) for side in sides):
        raise TypeError(f"{call}: sides = {shown(sides)}; give names, of {', '.join(known)}")
    for side in (side for side in sides if side not in known):
        raise ValueError(
            f"{call}: there is no side {shown(side)}; sides are {', '.join(known)}"
            f"{hint or didYouMean(side, known)}"
        )


def nodesInside(scene, region: Region) -> np.ndarray:
    """Numbers of the nodes inside a region.

    Parameters
    ----------
    region : Region, its boundary included.

    Raises TypeError for anything but a region, ValueError for one of the other dimension.
    """
    if not isinstance(region, Region):
        raise TypeError(f"nodesInside: {shown(region)} is not a region, e.g. box((0, 0), (1, 1))")
    if region.dim != scene.dim:
        raise ValueError(
            f"nodesInside: {shown(region)} is {region.dim}D and the scene {scene.dim}D; give one of the "
            "scene's"
        )
    return np.flatnonzero(region.contains(scene.nodePositions()))
