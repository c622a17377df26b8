# SPDX-License-Identifier: GPL-2.0-or-later
"""Regions that are not composed: boxes, balls, half-spaces, all of space."""

import numpy as np

from ..base.wording import shown
from .numbers import formatArgument, formatNumber, formatPoint, numbers, vector
from .region import Region


class Primitive(Region):
    """Region given by the arguments of its constructor; base of all that are not composed."""

    def __init__(self, kind, dim, /, **arguments):
        super().__init__(dim)
        self._kind = kind
        self._arguments = {name: np.asarray(value) for name, value in arguments.items()}

    def edges(self):
        return []

    def spec(self):
        return {"kind": self._kind, **{name: value.tolist() for name, value in self._arguments.items()}}

    def __repr__(self):
        return f"{self._kind}({', '.join(formatArgument(value) for value in self._arguments.values())})"


class Box(Primitive):
    """Axis-aligned rectangle or cuboid; see `box`."""

    def __init__(self, lower, upper):
        self._lower = vector("box", "lower", lower)
        self._upper = vector("box", "upper", upper, len(self._lower))
        if np.any(self._lower >= self._upper):
            raise ValueError(
                f"box: lower = {formatPoint(self._lower)} must be below upper = "
                f"{formatPoint(self._upper)} in every direction; swap or correct the corners"
            )
        super().__init__("box", len(self._lower), lower=self._lower, upper=self._upper)

    def bounds(self):
        return self._lower.copy(), self._upper.copy()

    def edges(self):
        return sorted((axis, float(c)) for corner in self.bounds() for axis, c in enumerate(corner))

    def _covers(self, points):
        return np.all((points >= self._lower) & (points < self._upper), axis=1)


class Ball(Primitive):
    """Sphere in 3D, disc in 2D; see `sphere` and `disc`."""

    def __init__(self, kind, dim, centre, radius):
        if hasattr(centre, "__len__") and len(centre) == 5 - dim:
            raise ValueError(
                f"{kind}: centre = {shown(centre)} must have {dim} coordinates; "
                f"{'in 2D give a disc()' if dim == 3 else 'in 3D give a sphere()'}"
            )
        self._centre = vector(kind, "centre", centre, dim)
        self._radius = float(numbers(kind, "radius", radius, shape=()))
        if not 0 < self._radius < np.inf:
            raise ValueError(f"{kind}: radius = {formatNumber(self._radius)} must be positive and finite")
        super().__init__(kind, dim, centre=self._centre, radius=self._radius)

    def bounds(self):
        return self._centre - self._radius, self._centre + self._radius

    def _covers(self, points):
        return np.sum((points - self._centre) ** 2, axis=1) < self._radius**2


class HalfSpace(Primitive):
    """All points on one side of a plane (3D) or line (2D); see `halfSpace`."""

    def __init__(self, point, normal):
        self._point = vector("halfSpace", "point", point)
        self._normal = vector("halfSpace", "normal", normal, len(self._point))
        if not np.any(self._normal):
            raise ValueError(
                f"halfSpace: normal = {formatPoint(self._normal)} has no direction; "
                "give the outward normal, of any length but zero"
            )
        super().__init__("halfSpace", len(self._point), point=self._point, normal=self._normal)

    def bounds(self):
        lower, upper = np.full(self.dim, -np.inf), np.full(self.dim, np.inf)
        for axis, coordinate in self.edges():
            (upper if self._normal[axis] > 0 else lower)[axis] = coordinate
        return lower, upper

    def edges(self):
        axes = np.flatnonzero(self._normal)
        return [(int(axes[0]), float(self._point[axes[0]]))] if len(axes) == 1 else []

    def _covers(self, points):
        return (points - self._point) @ self._normal < 0

    def _size(self):
        return float(np.max(np.abs(self._point))) or 1.0

    def _breaks(self, axis):
        return [self._point[axis]]


class Everywhere(Primitive):
    """All of space; see `everywhere`."""

    def __init__(self, dim):
        if dim not in (2, 3):
            raise ValueError(f"everywhere: dim = {shown(dim)} must be 2 or 3")
        super().__init__("everywhere", int(dim), dim=int(dim))

    def bounds(self):
        return np.full(self.dim, -np.inf), np.full(self.dim, np.inf)

    def _covers(self, points):
        return np.ones(len(points), bool)

    def _size(self):
        return 0.0
