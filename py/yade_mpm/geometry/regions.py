# SPDX-License-Identifier: GPL-2.0-or-later
"""The functions that make regions, and regions from their descriptions."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..base.wording import shown
from .polygon import Polygon
from .primitives import Ball, Box, Everywhere, HalfSpace
from .region import Composed, Region
from .solids import Cylinder, Prism
from .terrain import Below, Layer
from .triangulated import Triangulated


def box(lower: ArrayLike, upper: ArrayLike) -> Region:
    """Axis-aligned rectangle (2D) or cuboid (3D).

    Parameters
    ----------
    lower, upper : (dim,), m, opposite corners.

    Raises ValueError unless lower < upper in every direction.
    """
    return Box(lower, upper)


def sphere(centre: ArrayLike, radius: float) -> Region:
    """Ball in 3D.

    Parameters
    ----------
    centre : (3,), m.
    radius : m, positive.

    Raises ValueError on anything else.
    """
    return Ball("sphere", 3, centre, radius)


def disc(centre: ArrayLike, radius: float) -> Region:
    """Disc in 2D.

    Parameters
    ----------
    centre : (2,), m.
    radius : m, positive.

    Raises ValueError on anything else.
    """
    return Ball("disc", 2, centre, radius)


def polygon(points: ArrayLike) -> Region:
    """Polygon in 2D that does not cross or touch itself.

    Parameters
    ----------
    points : (N, 2), N >= 3, m: corners in order, clockwise or counter-clockwise. The last may repeat the
        first, as in the rings of GeoJSON.

    Raises ValueError if it crosses or touches itself.
    """
    return Polygon(points)


def cylinder(bottom: ArrayLike, top: ArrayLike, radius: float) -> Region:
    """Cylinder in 3D, in any direction.

    Parameters
    ----------
    bottom, top : (3,), m, the ends of its axis.
    radius : m, positive.

    Raises ValueError on anything else.
    """
    return Cylinder(bottom, top, radius)


def prism(points: ArrayLike, start: float, end: float, axis: str = "z") -> Region:
    """Polygon in 3D that is drawn along an axis: a wedge, a slope of one profile, a pile of any section.

    Parameters
    ----------
    points : (N, 2), m, corners of the polygon in the two other axes, in their order: (x, y), along y (x, z).
    start, end : m, ends along the axis.
    axis : "x", "y" or "z"; default "z".

    Raises ValueError as `polygon` does, and unless start < end.
    """
    return Prism(points, start, end, axis)


def halfSpace(point: ArrayLike, normal: ArrayLike) -> Region:
    """The side of a plane (line in 2D) that its normal points away from: (x - point) . normal <= 0.

    Parameters
    ----------
    point : (dim,), m, any point of the plane.
    normal : (dim,), of any length but zero.

    Raises ValueError for a normal of zero.
    """
    return HalfSpace(point, normal)


def everywhere(dim: int) -> Region:
    """All of space.

    Parameters
    ----------
    dim : 2 or 3, else ValueError.
    """
    return Everywhere(dim)


_CONSTRUCTORS = {
    "box": box,
    "sphere": sphere,
    "disc": disc,
    "polygon": polygon,
    "cylinder": cylinder,
    "prism": prism,
    "halfSpace": halfSpace,
    "everywhere": everywhere,
    "below": Below,
    "layer": Layer,
    "solid": Triangulated,
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
        f"regionFromSpec: kind = {shown(kind)} is unknown; allowed are "
        f"{', '.join([*_CONSTRUCTORS, *Composed.SIGNS])}"
    )
