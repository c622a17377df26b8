# SPDX-License-Identifier: GPL-2.0-or-later
"""Shapes of bodies of YADE as shapes of rigid bodies of a scene."""

import numpy as np

from .. import rigid
from .grids import isElement, massOf, shapeOf

INSTEAD = {
    "GridNode": "; give the GridConnections or PFacets that it carries, nodes touch nothing in YADE, either",
    "Cylinder": "; make it of yade.gridpfacet.cylinder",
    "ChainedCylinder": "; make it of yade.gridpfacet.cylinderConnection",
    "PotentialBlock": "; make it one of yade.polyhedra_utils.polyhedra",
    "PotentialParticle": "; make it a clump of spheres or one of yade.polyhedra_utils.polyhedra",
    "LevelSet": "; make it a clump of spheres or facets of its surface",
}  # what to do with shapes that cannot touch


def shapesOf(omega, body, facetThickness, plane, mayBeMember=False):
    """Shapes of a body of YADE in the frame of `frameOf`, in the axes of the scene."""
    if body.isClumpMember and not mayBeMember:
        raise ValueError(
            f"yade.Bodies: body {body.id} stands in clump {body.clumpId}; give the number of the clump"
        )
    if isElement(body):
        return [shapeOf(body, plane)]
    members = body.shape.members.items() if body.isClump else [(body.id, ((0, 0, 0), (0, 0, 0, 1)))]
    back = plane.turnToScene(frameOf(body)) * (1, -1, -1, -1)
    return [
        shape
        for member, (centre, turn) in members
        for shape in _shapesAt(
            omega.bodies[member],
            _turned(back, plane.toScene(centre)),
            tuple(_product(back, plane.turnToScene(turn))),
            facetThickness,
            plane,
        )
    ]


def frameOf(body):
    """Orientation (x, y, z, w) of the frame of the shapes against that of the body. A clump has its principal
    axes, which may be turned out of the plane of a 2D scene; the axes of its first member are not."""
    if not body.isClump:
        return 0.0, 0.0, 0.0, 1.0
    return tuple(body.shape.members[min(body.shape.members.keys())][1])


def _shapesAt(body, centre, turn, facetThickness, plane):
    """Shapes of a body that is no clump, with its place in the frame of `frameOf`."""
    shape, kind = body.shape, type(body.shape).__name__
    if kind == "Sphere":
        return [rigid.Sphere(shape.radius, tuple(centre))]
    if kind == "Box":
        return [rigid.Box(tuple(plane.lengthsToScene(shape.extents)), tuple(centre), turn)]
    if kind in ("Facet", "Polyhedra"):
        vertices = (
            shape.vertices if kind == "Facet" else [shape.v[k] for k in shape.GetSurfaceTriangulation()]
        )
        corners = [tuple(centre + _turned(turn, plane.toScene(v))) for v in vertices]
        return [rigid.Facet(tuple(corners[k : k + 3]), facetThickness) for k in range(0, len(corners), 3)]
    if kind == "Wall":
        if shape.sense == 0:
            raise ValueError(
                f"yade.Bodies: wall {body.id} has sense 0; give 1 or -1, the side on which the soil is"
            )
        return [rigid.Wall(tuple(plane.toScene(shape.sense * np.eye(3)[shape.axis])), tuple(centre))]
    raise ValueError(
        f"yade.Bodies: body {body.id} is a {kind}; Sphere, Box, Facet, Polyhedra, Wall, clumps of them, "
        f"GridConnection and PFacet can touch the soil{INSTEAD.get(kind, '')}"
    )


def yieldingMass(body):
    """Mass of what moves by its forces, as YADE has it; zero for what is moved by its velocity alone."""
    if isElement(body):
        return massOf(body)
    return 0.0 if body.state.blockedDOFs == "xyzXYZ" else body.state.mass


def density(omega, body, thickness):
    """Mass over volume, Mg/m3; zero for what is moved by its velocity alone, and for facets. thickness : of a
    2D scene; None in 3D."""
    shapes = (
        [omega.bodies[member].shape for member, _ in body.shape.members.items()]
        if body.isClump
        else [body.shape]
    )
    if body.state.blockedDOFs == "xyzXYZ" or not all(
        type(shape).__name__ in ("Sphere", "Box") for shape in shapes
    ):
        return 0.0
    return body.state.mass / sum(_volume(shape, thickness) for shape in shapes)


def _volume(shape, thickness):
    if type(shape).__name__ == "Box":
        return 8 * shape.extents.prod()
    return np.pi * shape.radius**2 * (4 / 3 * shape.radius if thickness is None else thickness)


def _turned(quaternion, v):
    w, axis = quaternion[0], np.array(quaternion[1:])
    return v + 2 * np.cross(axis, np.cross(axis, v) + w * v)


def _product(p, q):
    """Product of quaternions (..., 4), (w, x, y, z): first q, then p."""
    vector = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate(
        [p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True), vector], axis=-1
    )
