# SPDX-License-Identifier: GPL-2.0-or-later
"""One picture of the soil and of the bodies of YADE in it: a 2D scene, or a section through one in 3D."""

import itertools

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Circle, Polygon
from scipy.spatial import ConvexHull

from ..base.wording import shown
from ..plot import picture
from ..plot.figures import save
from .plane import Plane

BODY = dict(facecolor="0.62", edgecolor="0.25", linewidth=0.7, zorder=3)
AXES = {"x": (1, 2, 0), "y": (0, 2, 1), "z": (0, 1, 2)}  # normal of a section -> right, up, normal
NEAR = 1.001  # half sizes of a particle, from its middle to a plane that cuts it: one between two shows both
TOUCH = 1e-9  # m, from a plane at which a corner lies in it


def drawScene(coupling, field, component, limits, axes, colours, window, cut, file):
    """What `Coupling.picture` does."""
    scene = coupling.scene
    plane = next((e.plane for e in coupling.exchanges if hasattr(e, "plane")), Plane())
    if scene.dim == 2:
        frame, at, parts = plane.frame, 0.0, picture.partsOf(scene.bodies)
    else:
        frame, at = _sectionOf(scene, cut)
        parts = [p for p in (_cutBody(body, frame, at) for body in scene.bodies) if p]
        if not parts:
            raise ValueError(f"picture: there is no soil at {'xyz'[AXES[_normalOf(cut)][2]]} = {at:g} m")
    axes = picture.draw(
        parts, field, component, limits, axes=axes, colours=colours, window=window, arrows=None
    )
    axes.add_collection(PatchCollection(outlines(frame, at), match_original=True, zorder=3))
    if scene.dim == 3:
        right, up, normal = AXES[_normalOf(cut)]
        axes.set(xlabel=f"{'xyz'[right]} (m)", ylabel=f"{'xyz'[up]} (m)")
        axes.set_title(f"{'xyz'[normal]} = {at:g} m")
    if file is not None:
        save(axes.figure, file)
    return axes


def outlines(frame=None, at=0.0):
    """Patches of matplotlib where the bodies of YADE cut a plane; those that only show the soil are left out.

    Parameters
    ----------
    frame : (3, 3), axes of YADE to the right, up and along the normal, a row each; default x, y, z.
    at : m, of the plane along the normal; default 0.
    """
    from yade import O

    frame = np.eye(3) if frame is None else frame
    patches = []
    for body in O.bodies:
        if body is not None and not body.isClump and body.bounded:
            patches += _cut(body, frame, at)
    return patches


def _cut(body, frame, at):
    centre = frame @ np.array(body.state.pos)
    shape, kind = body.shape, type(body.shape).__name__
    if kind == "Sphere":
        square = shape.radius**2 - (centre[2] - at) ** 2
        return [Circle(centre[:2], np.sqrt(square), **BODY)] if square > 0 else []
    corners = _corners(shape, kind)
    if corners is None:
        return []
    turned = np.array([tuple(body.state.ori * corner) for corner in corners])
    points = _section(turned @ frame.T + centre, at)
    if len(points) < 2:
        return []
    return [Polygon(points, closed=len(points) > 2, **BODY)]


def _corners(shape, kind):
    """Corners of a convex body of YADE in its frame, as vectors of YADE; None for another one."""
    from yade import Vector3

    if kind == "Box":
        return [
            Vector3(*(s * e for s, e in zip(signs, shape.extents)))
            for signs in itertools.product((-1, 1), repeat=3)
        ]
    return {"Facet": "vertices", "Polyhedra": "v"}.get(kind) and list(
        shape.vertices if kind == "Facet" else shape.v
    )


def _section(corners, at):
    """Corners (n, 2) of the polygon in which a plane cuts the hull of some points, all round."""
    height = corners[:, 2] - at
    points = [corners[k, :2] for k in range(len(corners)) if abs(height[k]) < TOUCH]
    for a, b in itertools.combinations(range(len(corners)), 2):
        if height[a] * height[b] < 0:
            share = height[a] / (height[a] - height[b])
            points.append(corners[a, :2] + share * (corners[b, :2] - corners[a, :2]))
    points = np.array(points).reshape(-1, 2)
    if len(points) < 3 or np.linalg.matrix_rank(points - points[0], tol=TOUCH) < 2:
        return points
    return points[ConvexHull(points).vertices]


def _normalOf(cut):
    return "y" if cut is None else cut[0]


def _sectionOf(scene, cut):
    """Axes and place of a section; the middle of the scene across y by default."""
    if cut is not None and not (len(cut) == 2 and cut[0] in AXES and np.isfinite(cut[1])):
        raise ValueError(
            f"picture: cut = {shown(cut)} is not allowed; give e.g. ('y', 1.5), normal and place in m"
        )
    axes = list(AXES[_normalOf(cut)])
    at = (scene.lower[axes[2]] + scene.upper[axes[2]]) / 2 if cut is None else float(cut[1])
    return np.eye(3)[axes], at


def _cutBody(body, frame, at):
    """The particles of a body next to a plane, as squares of their size."""
    position = body.position @ frame.T
    half = np.cbrt(body.volume) / 2
    isNear = np.abs(position[:, 2] - at) <= NEAR * half
    if not isNear.any():
        return None
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    corners = position[isNear, None, :2] + half[isNear, None, None] * square
    whole = picture.partsOf([body])[0]

    def field(name):
        found = whole.field(name)
        return found and (found[0][isNear], found[1])

    field.units = whole.field.units
    return picture.Part(body.name, False, corners, field)
