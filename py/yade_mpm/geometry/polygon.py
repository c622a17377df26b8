# SPDX-License-Identifier: GPL-2.0-or-later
"""Simple polygons."""

import numpy as np

from .numbers import formatPoint, numbers, requireFinite
from .primitives import Primitive


class Polygon(Primitive):
    """Simple polygon in 2D; see `polygon`."""

    def __init__(self, points):
        self._points = numbers("polygon", "points", points)
        if self._points.ndim != 2 or self._points.shape[1] != 2 or len(self._points) < 3:
            raise ValueError(
                f"polygon: points has shape {self._points.shape}; give at least three points (x, y)"
            )
        requireFinite("polygon", "points", self._points)
        if len(self._points) > 3 and np.array_equal(self._points[0], self._points[-1]):
            self._points = self._points[:-1]
        _requireSimple(self._points)
        super().__init__("polygon", 2, points=self._points)

    def bounds(self):
        return self._points.min(axis=0), self._points.max(axis=0)

    def edges(self):
        sides = zip(self._points, np.roll(self._points, -1, axis=0))
        return sorted({(axis, float(p[axis])) for p, q in sides for axis in (0, 1) if p[axis] == q[axis]})

    def _covers(self, points):
        x, y = points.T
        inside = np.zeros(len(points), bool)
        for (x1, y1), (x2, y2) in zip(self._points, np.roll(self._points, -1, axis=0)):
            if y1 != y2:  # a ray to the right crosses no horizontal side
                inside ^= ((y1 > y) != (y2 > y)) & (x < x1 + (y - y1) * (x2 - x1) / (y2 - y1))
        return inside

    def _breaks(self, axis):
        return list(self._points[:, axis])


def _requireSimple(points):
    """Refuse a polygon with a repeated corner, a spike, or sides that cross or touch."""
    ends = np.roll(points, -1, axis=0)
    eps = 1e-12 * np.max(np.ptp(points, axis=0)) ** 2
    count = len(points)
    repeated = np.flatnonzero(np.sum((ends - points) ** 2, axis=1) <= eps)
    if len(repeated):
        raise ValueError(
            f"polygon: point {repeated[0]} at {formatPoint(points[repeated[0]])} is repeated; "
            "give every corner once"
        )
    for i in range(count):
        follower = ends[(i + 1) % count] - ends[i]
        side = ends[i] - points[i]
        if abs(_cross(side, follower)) <= eps and side @ follower < 0:
            raise ValueError(
                f"polygon: the sides folded at {formatPoint(ends[i])} intersect; remove that corner"
            )
        others = np.array([j for j in range(i + 2, count) if (j + 1) % count != i], int)
        hits = others[_segmentsMeet(points[i], ends[i], points[others], ends[others], eps)]
        if len(hits):
            raise ValueError(
                f"polygon: the sides from {formatPoint(points[i])} and from {formatPoint(points[hits[0]])} "
                "intersect; reorder the corners, or split the polygon and unite the parts"
            )


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _segmentsMeet(p, q, starts, ends, eps):
    """Whether segment p-q meets each segment starts-ends, touching included."""

    def side(value):
        return np.where(np.abs(value) <= eps, 0, np.sign(value))

    overStarts, overEnds = side(_cross(q - p, starts - p)), side(_cross(q - p, ends - p))
    overP, overQ = side(_cross(ends - starts, p - starts)), side(_cross(ends - starts, q - starts))
    isBelow = np.any(np.maximum(starts, ends) < np.minimum(p, q), axis=1)
    isAbove = np.any(np.minimum(starts, ends) > np.maximum(p, q), axis=1)
    return (overStarts * overEnds <= 0) & (overP * overQ <= 0) & ~isBelow & ~isAbove
