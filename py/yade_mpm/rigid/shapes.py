# SPDX-License-Identifier: GPL-2.0-or-later
"""Shapes of rigid bodies for `RigidContact`, in the frame of their body: coordinates with two (z = 0) or
three numbers, m.

In a 2D scene a sphere is a disc, a box a rectangle, a facet a segment, all per metre of thickness.
"""

from dataclasses import dataclass, field

import numpy as np

from ..base.kinds import FILE, NOT_NEGATIVE, NUMBER, POSITIVE, takes
from ..base.wording import shown
from ..geometry.numbers import floats
from ..geometry.terrain import Terrain
from ..geometry.triangleFiles import readTriangles


class Shape:
    """Base of the shapes of rigid bodies."""


@dataclass
class Sphere(Shape):
    """Sphere (2D: disc).

    Parameters
    ----------
    radius : m.
    centre : m; default the origin of the body.
    """

    radius: float
    centre: tuple = (0.0, 0.0, 0.0)

    def row(self):
        """Kind and members of the shape, by the names of the solver's ShapeRecord."""
        return {"kind": "Sphere", "centre": _vector(self, "centre"), "radius": _positive(self, "radius")}


@dataclass
class Box(Shape):
    """Box (2D: rectangle).

    Parameters
    ----------
    halfSize : half edges, m, two or three numbers.
    centre : m; default the origin of the body.
    orientation : unit quaternion (w, x, y, z) against the body; default not turned.
    """

    halfSize: tuple
    centre: tuple = (0.0, 0.0, 0.0)
    orientation: tuple = (1.0, 0.0, 0.0, 0.0)

    def row(self):
        """Kind and members of the shape, by the names of the solver's ShapeRecord."""
        half = _vector(self, "halfSize", missing=1.0)
        if not (half > 0).all():
            raise ValueError(
                f"Box: halfSize = {shown(self.halfSize)} is not allowed; give positive half edges in m"
            )
        turn = np.asarray(self.orientation, float)
        if turn.shape != (4,) or not abs(np.linalg.norm(turn) - 1) < 1e-6:
            raise ValueError(
                f"Box: orientation = {shown(self.orientation)} is not allowed; give a unit quaternion (w, "
                "x, y, z)"
            )
        return {"kind": "Box", "centre": _vector(self, "centre"), "halfSize": half, "orientation": turn}


@dataclass
class Wall(Shape):
    """Half-space.

    Parameters
    ----------
    normal : out of the wall, to the side where the soil is.
    point : one on its surface, m; default the origin of the body.
    """

    normal: tuple
    point: tuple = (0.0, 0.0, 0.0)

    def row(self):
        """Kind and members of the shape, by the names of the solver's ShapeRecord."""
        normal = _vector(self, "normal")
        if not np.linalg.norm(normal) > 0:
            raise ValueError(
                f"Wall: normal = {shown(self.normal)} has no direction; give a vector that is not zero"
            )
        return {"kind": "Wall", "centre": _vector(self, "point"), "normal": normal / np.linalg.norm(normal)}


@dataclass
class Facet(Shape):
    """Segment between two vertices, or triangle with three, with rounded edges; touched from either side.

    Parameters
    ----------
    vertices : m, (2, 2), (2, 3) or (3, 3).
    thickness : m; default 0; APDI bodies need one.
    """

    vertices: tuple = field(default_factory=tuple)
    thickness: float = 0.0

    def row(self):
        """Kind and members of the shape, by the names of the solver's ShapeRecord."""
        points = [_point(self, "vertices", v) for v in self.vertices]
        if len(points) not in (2, 3):
            raise ValueError(f"Facet: {len(points)} vertices; give two (segment) or three (triangle)")
        size = (
            np.linalg.norm(points[1] - points[0])
            if len(points) == 2
            else np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0]))
        )
        if not size > 0:
            raise ValueError(f"Facet: vertices = {shown(self.vertices)} coincide or lie on a line; move one")
        NOT_NEGATIVE.check("Facet", "m", thickness=self.thickness)
        return {
            "kind": "Capsule" if len(points) == 2 else "Triangle",
            "vertices": np.concatenate([*points, *[np.zeros(3)] * (3 - len(points))]),
            "radius": 0.5 * float(self.thickness),
        }


@takes(file=FILE, unit=POSITIVE, thickness=NUMBER)
def facetsFromFile(file, unit=1.0, thickness=0.0):
    """The triangles of an STL or OBJ file as a list of `Facet`, for one rigid body: a chute, a rock, a wheel.

        contact.addBody(mpm.rigid.facetsFromFile("chute.stl", unit=0.001), friction=0.4)  # drawn in mm

    Parameters
    ----------
    file : in any format that meshio reads; the surface may be open.
    unit : m, length of one unit of the file; default 1.
    thickness : m, of each facet; default 0.
    """
    points, triangles = readTriangles("facetsFromFile", file, unit)
    return [Facet(points[corners], thickness) for corners in triangles]


@dataclass
class HeightField(Shape):
    """Ground by heights on a raster, solid below: the bilinear surface, averaged over a cell of the raster,
    so that it has no edges. Beyond the raster it goes on straight.

    Parameters
    ----------
    heights : m, (columns, rows) along x and y, height along z; in a 2D scene (columns,), height along y.
    spacing : m, between two heights; one number, or two.
    origin : m, x (and y) of the first height; default the origin of the body.
    """

    heights: np.ndarray
    spacing: float
    origin: tuple | None = None

    def __post_init__(self):
        ground = Terrain(self.heights, self.spacing, self.origin)
        self.heights, self.spacing, self.origin = ground.heights, ground.spacing, ground.origin

    def record(self, body):
        """Row of the table of height fields that the solver reads; its heights stand in a table of their
        own."""
        columns, rows = (*self.heights.shape, 1)[:2]
        pad = [1.0] * (3 - len(self.spacing))
        return {
            "body": int(body),
            "columns": columns,
            "rows": rows,
            "origin": [*self.origin.tolist(), *([0.0] * len(pad))],
            "spacing": [*self.spacing.tolist(), *pad],
        }


_NONE = {  # of members that a kind of shape does not have
    "centre": (0.0, 0.0, 0.0),
    "halfSize": (0.0, 0.0, 0.0),
    "normal": (0.0, 0.0, 0.0),
    "vertices": (0.0,) * 9,
    "orientation": (1.0, 0.0, 0.0, 0.0),
    "radius": 0.0,
}


def shapeRow(body, shape):
    """The members of a shape of rigid body number `body`: a row of the table that the solver reads."""
    if not isinstance(shape, Shape):
        raise TypeError(
            f"RigidContact: shape = {shown(shape)}; give mpm.rigid.Sphere, Box, Wall, Facet or HeightField"
        )
    row = {"body": int(body), **_NONE, **shape.row()}
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in row.items()}


def _vector(shape, name, missing=0.0):
    return _point(shape, name, getattr(shape, name), missing)


def _point(shape, name, value, missing=0.0):
    try:
        given = floats(value)
    except (TypeError, ValueError):
        given = np.zeros(0)
    if given.shape not in ((2,), (3,)) or not np.isfinite(given).all():
        raise ValueError(
            f"{type(shape).__name__}: {name} = {shown(value)} is not allowed; give two or three numbers in m"
        )
    return given if len(given) == 3 else np.append(given, missing)


def _positive(shape, name):
    value = getattr(shape, name)
    POSITIVE.check(type(shape).__name__, "m", **{name: value})
    return float(value)
