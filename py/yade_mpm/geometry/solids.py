# SPDX-License-Identifier: GPL-2.0-or-later
"""Regions in space that are not boxes: cylinders, and prisms of polygons (wedges, slopes of one profile)."""

import numpy as np

from ..base.wording import shown
from .numbers import formatNumber, formatPoint, numbers, vector
from .polygon import Polygon
from .primitives import Primitive

AXES = "xyz"


class Cylinder(Primitive):
    """Cylinder between two points of its axis; see `cylinder`."""

    def __init__(self, bottom, top, radius):
        self._bottom = vector("cylinder", "bottom", bottom, 3)
        self._top = vector("cylinder", "top", top, 3)
        self._radius = float(numbers("cylinder", "radius", radius, shape=()))
        if not 0 < self._radius < np.inf:
            raise ValueError(f"cylinder: radius = {formatNumber(self._radius)} must be positive and finite")
        self._length = float(np.linalg.norm(self._top - self._bottom))
        if not self._length > 0:
            raise ValueError(
                f"cylinder: bottom and top are both {formatPoint(self._top)}; give the two ends of its axis"
            )
        self._along = (self._top - self._bottom) / self._length
        super().__init__("cylinder", 3, bottom=self._bottom, top=self._top, radius=self._radius)

    def bounds(self):
        reach = self._radius * np.sqrt(np.maximum(0, 1 - self._along**2))
        ends = np.array([self._bottom, self._top])
        return ends.min(axis=0) - reach, ends.max(axis=0) + reach

    def edges(self):
        axes = np.flatnonzero(self._along)
        if len(axes) > 1:
            return []
        return sorted((int(axes[0]), float(end[axes[0]])) for end in (self._bottom, self._top))

    def _covers(self, points):
        away = points - self._bottom
        along = away @ self._along
        across = np.sum(away**2, axis=1) - along**2
        return (along >= 0) & (along < self._length) & (across < self._radius**2)


class Prism(Primitive):
    """Polygon that is drawn along an axis; see `prism`."""

    def __init__(self, points, start, end, axis="z"):
        if axis not in tuple(AXES):
            raise ValueError(f"prism: axis = {shown(axis)} is not allowed; give 'x', 'y' or 'z'")
        self._base = Polygon(points)
        given = ("start", start), ("end", end)
        self._ends = [float(numbers("prism", name, x, shape=())) for name, x in given]
        if not (np.isfinite(self._ends).all() and self._ends[0] < self._ends[1]):
            raise ValueError(
                f"prism: start = {formatNumber(self._ends[0])} must be below end = "
                f"{formatNumber(self._ends[1])}; swap or correct them"
            )
        self._axis = AXES.index(axis)
        self._plane = [k for k in range(3) if k != self._axis]
        start, end = self._ends
        super().__init__("prism", 3, points=self._base._points, start=start, end=end, axis=axis)

    def bounds(self):
        corners = np.zeros((2, 3))
        corners[:, self._plane] = self._base.bounds()
        corners[:, self._axis] = self._ends
        return corners[0], corners[1]

    def edges(self):
        sides = [(self._plane[axis], x) for axis, x in self._base.edges()]
        return sorted([*sides, *((self._axis, end) for end in self._ends)])

    def _covers(self, points):
        along = points[:, self._axis]
        isBetween = (along >= self._ends[0]) & (along < self._ends[1])
        return isBetween & self._base._covers(points[:, self._plane])

    def __repr__(self):
        corners = len(self._base._points)
        return f"prism({corners} corners, {formatNumber(self._ends[0])}, {formatNumber(self._ends[1])})"

    def _breaks(self, axis):
        return self._ends if axis == self._axis else self._base._breaks(self._plane.index(axis))
