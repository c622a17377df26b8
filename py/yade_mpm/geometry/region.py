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

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ..base.wording import shown
from .numbers import numbers

_TOLERANCE = 1e-9  # of the region's size
_PROBES = 16  # per interval between breaks, to see whether a plane bounds a composed region


class Region:
    """Part of 2D or 3D space; made by `box`, `sphere`, `disc`, `polygon`, `halfSpace`, `everywhere`.

    `a + b` and `a | b` unite, `a - b` subtracts, `a & b` intersects.

    A region of your own is a subclass with `contains` and `bounds`, and with `edges` where it has planes that
    have to fit the particles. Checkpoints keep the particles that it made, but not the region itself: `Hold`,
    which needs it again, refuses it, and so does a body that is to become a mesh after `mpm.load`.

    Attributes
    ----------
    dim : 2 or 3.
    """

    toChange = ""  # what else an error about its size tells to do
    origin = ""  # what its edges are, where an error names them: "a face of ..."

    def __init__(self, dim: int) -> None:
        self.dim = dim

    def __repr__(self):
        return f"{type(self).__name__}()"

    def __eq__(self, other):
        """Whether both were made alike; a region of your own equals itself alone."""
        if not isinstance(other, Region):
            return NotImplemented
        spec = self.spec()
        return self is other if spec is None else spec == other.spec()

    def __hash__(self):
        spec = self.spec()
        return object.__hash__(self) if spec is None else hash(_frozen(spec))

    def contains(self, points: ArrayLike, closed: bool = True) -> np.ndarray:
        """Tell which points are inside.

        Parameters
        ----------
        points : (N, dim), m.
        closed : True counts the boundary as inside (grid nodes); False gives each point to one of two
            complementary regions only (particles). Default True.

        Returns (N,) bool. Raises TypeError or ValueError if points is not an (N, dim) array of numbers.
        """
        points = numbers("contains", "points", points)
        if points.ndim != 2 or points.shape[1] != self.dim:
            raise ValueError(
                f"contains: points has shape {points.shape}, but {shown(self)} needs "
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
        raise self._lacking("bounds()")

    def edges(self):
        """Axis-aligned planes that bound the region, a sorted list of (axis, coordinate).

        A composed region lists those planes of its operands that still bound the result; to find
        out, both sides of each plane are probed at 16 places between any two corners of operands.
        """
        return []

    def originOf(self, axis, coordinate):
        """What an edge of it is, "" where nobody has said."""
        return self.origin if (axis, coordinate) in self.edges() else ""

    def spec(self):
        """Description of the region as a dict that JSON can hold; `regionFromSpec` reads it back. None for a
        region of your own, or with one in it."""
        return

    def __add__(self, other: Region) -> Region:
        return Composed("union", self, other)

    def __or__(self, other: Region) -> Region:
        return Composed("union", self, other)

    def __sub__(self, other: Region) -> Region:
        return Composed("difference", self, other)

    def __and__(self, other: Region) -> Region:
        return Composed("intersection", self, other)

    def _covers(self, points):
        if type(self).contains is Region.contains:
            raise self._lacking("contains(points, closed=True)")
        return self.contains(points, closed=False)

    def _lacking(self, method):
        return NotImplementedError(
            f"region: {type(self).__name__} has no {method}; a region of your own needs it, others are made "
            f"by box(), polygon() and the like"
        )

    def _size(self):
        lower, upper = self.bounds()
        return float(np.max(upper - lower))

    def _breaks(self, axis):
        """Coordinates along an axis where the region may begin, end or turn."""
        lower, upper = self.bounds()
        return [x for x in (lower[axis], upper[axis]) if np.isfinite(x)]

    def _tolerance(self):
        return _TOLERANCE * self._size()


class Composed(Region):
    """Union, difference or intersection of two regions; made by the operators."""

    SIGNS = {"union": "+", "difference": "-", "intersection": "&"}

    def __init__(self, kind, a, b):
        sign = self.SIGNS[kind]
        if not isinstance(b, Region):
            raise TypeError(
                f"region {sign} {shown(b)}: the right side is a {type(b).__name__}, not a region; "
                "make one with box(), sphere(), disc(), polygon() or halfSpace()"
            )
        if a.dim != b.dim:
            raise ValueError(
                f"{shown(a)} {sign} {shown(b)}: a {a.dim}D and a {b.dim}D region do not combine; "
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

    def originOf(self, axis, coordinate):
        return self._a.originOf(axis, coordinate) or self._b.originOf(axis, coordinate)

    def spec(self):
        a, b = self._a.spec(), self._b.spec()
        return None if a is None or b is None else {"kind": self._kind, "a": a, "b": b}

    def __repr__(self):
        left, right = self._operandText(self._a, True), self._operandText(self._b, False)
        return f"{left} {self.SIGNS[self._kind]} {right}"

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


def _frozen(spec):
    """A spec of dicts and lists as tuples, which have a hash."""
    if isinstance(spec, dict):
        return tuple((name, _frozen(value)) for name, value in sorted(spec.items()))
    return tuple(map(_frozen, spec)) if isinstance(spec, list) else spec
