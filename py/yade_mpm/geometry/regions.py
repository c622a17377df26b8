# SPDX-License-Identifier: GPL-2.0-or-later
"""The functions that make regions, and regions from their descriptions."""

from .polygon import Polygon
from .primitives import Ball, Box, Everywhere, HalfSpace
from .region import Composed


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
        if kind in Composed.SIGNS:
            return Composed(kind, *(regionFromSpec(arguments[side]) for side in "ab"))
        if kind in _CONSTRUCTORS:
            return _CONSTRUCTORS[kind](**arguments)
    except (KeyError, TypeError) as error:
        raise ValueError(f"regionFromSpec: {spec} does not describe a {kind}: {error}") from error
    raise ValueError(
        f"regionFromSpec: kind = {kind!r} is unknown; allowed are "
        f"{', '.join([*_CONSTRUCTORS, *Composed.SIGNS])}"
    )
