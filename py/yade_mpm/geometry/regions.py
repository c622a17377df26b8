# SPDX-License-Identifier: GPL-2.0-or-later
"""Regions of space from which bodies are made and grid nodes are selected.

A region answers two questions, and the difference matters on its boundary only:

* `contains(points)` is the closed region: a point within 1e-9 of the region's size from its
  interior is inside. This is the rule for selecting grid nodes, which do sit on boundaries.
  It holds for composed regions as well: nodes on the common face of `a` and `b` belong to `a`,
  to `b`, to `a + b` and to `a - b`, but not to `c - (a + b)`, of which they bound nothing, and
  not to `a & b`, which has no interior.
* `contains(points, closed=False)` gives every point to exactly one of `c & a` and `c - a`.
  This is the rule for filling bodies, so that neighbouring bodies never share a particle.

Lengths are in the unit of the scene (m, if the scene is in SI).
"""

from itertools import product

import numpy as np

_TOLERANCE = 1e-9  # of the region's size
_PROBES = 16  # per interval between breaks, to see whether a plane bounds a composed region


def formatNumber(x):
    """Shortest text that reads back as the same number (30, not 30.0)."""
    text = repr(float(x))
    return text[:-2] if text.endswith(".0") else text


def formatPoint(point):
    """Text of a point as a tuple."""
    return "(" + ", ".join(formatNumber(x) for x in point) + ")"


class Region:
    """Part of 2D or 3D space; made by `box`, `sphere`, `disc`, `polygon`, `halfSpace`, `everywhere`.

    `a + b` and `a | b` unite, `a - b` subtracts, `a & b` intersects.

    Attributes: `dim`, 2 or 3.
    """

    def __init__(self, dim):
        self.dim = dim

    def contains(self, points, closed=True):
        """Tell which points are inside.

        points: (N, dim). closed: True counts the boundary as inside (grid nodes); False gives
        each point to one of two complementary regions only (particles). See the module's text.
        Returns (N,) bool. Raises TypeError or ValueError if points is not an (N, dim) array of numbers.
        """
        points = _numbers("contains", "points", points)
        if points.ndim != 2 or points.shape[1] != self.dim:
            raise ValueError(
                f"contains: points has shape {points.shape}, but {self!r} needs "
                f"(N, {self.dim}); write a single point as [point]"
            )
        if not closed:
            return self._covers(points)
        # Only the 2^dim corners round each point are asked, never the point itself, which may lie
        # exactly on a face inside a union. A polygon vertex sharper than a right angle can be missed.
        inside = np.zeros(len(points), bool)
        for corner in product((-1.0, 1.0), repeat=self.dim):
            inside |= self._covers(points + self._tolerance() * np.array(corner))
        return inside

    def bounds(self):
        """Corners (lower, upper), each (dim,), of a box that holds the region; +-inf where it has no end.

        Subtraction does not tighten the bounds: those of `a - b` are those of `a`.
        """
        raise NotImplementedError

    def edges(self):
        """Axis-aligned planes that bound the region, a sorted list of (axis, coordinate).

        A composed region lists those planes of its operands that still bound the result; to find
        out, both sides of each plane are probed at 16 places between any two corners of operands.
        """
        raise NotImplementedError

    def spec(self):
        """Description of the region as a dict that JSON can hold; `regionFromSpec` reads it back."""
        raise NotImplementedError

    def __add__(self, other):
        return Composed("union", self, other)

    def __or__(self, other):
        return Composed("union", self, other)

    def __sub__(self, other):
        return Composed("difference", self, other)

    def __and__(self, other):
        return Composed("intersection", self, other)

    def _covers(self, points):
        raise NotImplementedError

    def _size(self):
        lower, upper = self.bounds()
        return float(np.max(upper - lower))

    def _breaks(self, axis):
        """Coordinates along an axis where the region may begin, end or turn."""
        lower, upper = self.bounds()
        return [x for x in (lower[axis], upper[axis]) if np.isfinite(x)]

    def _tolerance(self):
        return _TOLERANCE * self._size()


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
        return f"{self._kind}({', '.join(_formatArgument(value) for value in self._arguments.values())})"


class Box(Primitive):
    """Axis-aligned rectangle or cuboid; see `box`."""

    def __init__(self, lower, upper):
        self._lower = _vector("box", "lower", lower)
        self._upper = _vector("box", "upper", upper, len(self._lower))
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
                f"{kind}: centre = {centre!r} must have {dim} coordinates; {'in 2D give a disc()' if dim == 3 else 'in 3D give a sphere()'}"
            )
        self._centre = _vector(kind, "centre", centre, dim)
        self._radius = float(_numbers(kind, "radius", radius, shape=()))
        if not 0 < self._radius < np.inf:
            raise ValueError(f"{kind}: radius = {formatNumber(self._radius)} must be positive and finite")
        super().__init__(kind, dim, centre=self._centre, radius=self._radius)

    def bounds(self):
        return self._centre - self._radius, self._centre + self._radius

    def _covers(self, points):
        return np.sum((points - self._centre) ** 2, axis=1) < self._radius**2


class Polygon(Primitive):
    """Simple polygon in 2D; see `polygon`."""

    def __init__(self, points):
        self._points = _numbers("polygon", "points", points)
        if self._points.ndim != 2 or self._points.shape[1] != 2 or len(self._points) < 3:
            raise ValueError(
                f"polygon: points has shape {self._points.shape}; at least three points (x, y) are needed"
            )
        _requireFinite("polygon", "points", self._points)
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


class HalfSpace(Primitive):
    """All points on one side of a plane (3D) or line (2D); see `halfSpace`."""

    def __init__(self, point, normal):
        self._point = _vector("halfSpace", "point", point)
        self._normal = _vector("halfSpace", "normal", normal, len(self._point))
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
            raise ValueError(f"everywhere: dim = {dim!r} must be 2 or 3")
        super().__init__("everywhere", int(dim), dim=int(dim))

    def bounds(self):
        return np.full(self.dim, -np.inf), np.full(self.dim, np.inf)

    def _covers(self, points):
        return np.ones(len(points), bool)

    def _size(self):
        return 0.0


class Composed(Region):
    """Union, difference or intersection of two regions; made by the operators."""

    _SIGNS = {"union": "+", "difference": "-", "intersection": "&"}

    def __init__(self, kind, a, b):
        sign = self._SIGNS[kind]
        if not isinstance(b, Region):
            raise TypeError(
                f"region {sign} {b!r}: the right side is a {type(b).__name__}, not a region; "
                "make one with box(), sphere(), disc(), polygon() or halfSpace()"
            )
        if a.dim != b.dim:
            raise ValueError(
                f"{a!r} {sign} {b!r}: a {a.dim}D and a {b.dim}D region do not combine; "
                "give both the same number of coordinates"
            )
        super().__init__(a.dim)
        self._kind, self._a, self._b = kind, a, b

    def bounds(self):
        (lowerA, upperA), (lowerB, upperB) = self._a.bounds(), self._b.bounds()
        if self._kind == "union":
            return np.minimum(lowerA, lowerB), np.maximum(upperA, upperB)
        if self._kind == "intersection":
            lower = np.maximum(lowerA, lowerB)
            return lower, np.maximum(lower, np.minimum(upperA, upperB))
        return lowerA, upperA

    def edges(self):
        candidates = sorted(self._a.edges() + self._b.edges())
        return [
            edge
            for k, edge in enumerate(candidates)
            if not self._repeats(edge, candidates[:k]) and self._isBoundary(*edge)
        ]

    def spec(self):
        return {"kind": self._kind, "a": self._a.spec(), "b": self._b.spec()}

    def __repr__(self):
        left, right = self._operandText(self._a, True), self._operandText(self._b, False)
        return f"{left} {self._SIGNS[self._kind]} {right}"

    def _covers(self, points):
        a, b = self._a._covers(points), self._b._covers(points)
        if self._kind == "union":
            return a | b
        return a & ~b if self._kind == "difference" else a & b

    def _size(self):
        return max(self._a._size(), self._b._size())

    def _breaks(self, axis):
        return self._a._breaks(axis) + self._b._breaks(axis)

    def _repeats(self, edge, earlier):
        return bool(earlier) and earlier[-1][0] == edge[0] and edge[1] - earlier[-1][1] <= self._tolerance()

    def _isBoundary(self, axis, coordinate):
        """Whether the region lies on one side only of some part of a plane."""
        along = [self._probes(other) for other in range(self.dim) if other != axis]
        along.insert(axis, np.array([coordinate]))
        points = np.stack(np.meshgrid(*along, indexing="ij"), axis=-1).reshape(-1, self.dim)
        step = np.zeros(self.dim)
        step[axis] = 10 * self._tolerance()
        return bool(np.any(self._covers(points - step) != self._covers(points + step)))

    def _probes(self, axis):
        breaks = np.unique(self._breaks(axis))
        if not len(breaks):
            return np.array([0.0])
        ends = np.concatenate(([breaks[0] - self._size()], breaks, [breaks[-1] + self._size()]))
        fractions = (np.arange(_PROBES) + 0.5) / _PROBES
        return (ends[:-1, None] + np.diff(ends)[:, None] * fractions).ravel()

    def _operandText(self, operand, isLeft):
        sums = ("union", "difference")
        joins = (
            isinstance(operand, Composed)
            and isLeft
            and (operand._kind == self._kind or (operand._kind in sums and self._kind in sums))
        )
        return f"({operand!r})" if isinstance(operand, Composed) and not joins else repr(operand)


def box(lower, upper):
    """Axis-aligned rectangle (2D) or cuboid (3D).

    lower, upper: (dim,) opposite corners. Raises ValueError unless lower < upper in every direction.
    """
    return Box(lower, upper)


def sphere(centre, radius):
    """Ball in 3D. centre: (3,). radius: positive. Raises ValueError on anything else."""
    return Ball("sphere", 3, centre, radius)


def disc(centre, radius):
    """Disc in 2D. centre: (2,). radius: positive. Raises ValueError on anything else."""
    return Ball("disc", 2, centre, radius)


def polygon(points):
    """Polygon in 2D that does not cross or touch itself.

    points: (N, 2), N >= 3, corners in order, clockwise or counter-clockwise, the first not repeated.
    Raises ValueError if it crosses or touches itself.
    """
    return Polygon(points)


def halfSpace(point, normal):
    """The side of a plane (line in 2D) that its normal points away from: (x - point) . normal <= 0.

    point: (dim,), any point of the plane. normal: (dim,), any length but zero, else ValueError.
    """
    return HalfSpace(point, normal)


def everywhere(dim):
    """All of space. dim: 2 or 3, else ValueError."""
    return Everywhere(dim)


_CONSTRUCTORS = {
    "box": box,
    "sphere": sphere,
    "disc": disc,
    "polygon": polygon,
    "halfSpace": halfSpace,
    "everywhere": everywhere,
}


def regionFromSpec(spec):
    """Region described by a dict from `Region.spec()`.

    spec: {"kind": constructor's name, argument: value, ...}, or {"kind": "union" | "difference" |
    "intersection", "a": spec, "b": spec}. Raises TypeError or ValueError if it describes no region.
    """
    if not isinstance(spec, dict):
        raise TypeError(
            f"regionFromSpec: spec is a {type(spec).__name__}; give a dict as made by Region.spec()"
        )
    arguments = dict(spec)
    kind = arguments.pop("kind", None)
    try:
        if kind in Composed._SIGNS:
            return Composed(kind, *(regionFromSpec(arguments[side]) for side in "ab"))
        if kind in _CONSTRUCTORS:
            return _CONSTRUCTORS[kind](**arguments)
    except (KeyError, TypeError) as error:
        raise ValueError(f"regionFromSpec: {spec} does not describe a {kind}: {error}") from error
    raise ValueError(
        f"regionFromSpec: kind = {kind!r} is unknown; allowed are "
        f"{', '.join([*_CONSTRUCTORS, *Composed._SIGNS])}"
    )


def _numbers(who, what, value, shape=None):
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{who}: {what} = {value!r} is not made of numbers") from None
    if shape is not None and array.shape != shape:
        raise ValueError(f"{who}: {what} = {value!r} must be {'one number' if shape == () else shape}")
    return array


def _requireFinite(who, what, array):
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{who}: {what} = {array.tolist()} must be finite; remove NaN and infinity")


def _vector(who, what, value, dim=None):
    array = _numbers(who, what, value)
    allowed = (2, 3) if dim is None else (dim,)
    if array.ndim != 1 or len(array) not in allowed:
        raise ValueError(f"{who}: {what} = {value!r} must have {' or '.join(map(str, allowed))} coordinates")
    _requireFinite(who, what, array)
    return array


def _formatArgument(value):
    if value.ndim == 2:
        return "[" + ", ".join(formatPoint(point) for point in value) + "]"
    return formatPoint(value) if value.ndim else formatNumber(value)


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
                f"polygon: the sides from {formatPoint(points[i])} and from "
                f"{formatPoint(points[hits[0]])} intersect; reorder the corners, or split the "
                "polygon and unite the parts"
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
