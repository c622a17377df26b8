# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of YADE that touch the soil: their states go to a `RigidContact`, its forces come back."""
import numpy as np

from . import rigid
from .yadePlane import Plane


class Bodies:
    """Bodies of YADE as rigid bodies of a `RigidContact`; goes into `Coupling.exchanges`.

    Parameters
    ----------
    contact : the `RigidContact` in the engines of the scene, before its first run.
    ids : numbers of bodies in O.bodies: Sphere, Box, Facet, Wall (with sense 1 or -1), or clumps of these (the clump's own
        number).
    friction : coefficient against the soil, -; default 0.
    thickness : m, of a 2D scene in YADE's third direction; forces per metre are multiplied by it. Default 1, and 1 in 3D.
    facetThickness : m, of facets against the soil; APDI bodies need one. Default 0.
    plane : "xy" (default), "xz" or "yz": axes of YADE along x and y of a 2D scene; a positive moment turns x to y. "xy" in 3D.

    O.engines needs a ForceResetter. YADE knows no units: give it Mg, m, s, kPa (kN), as the solver. Raises ValueError for a body that is not there, is of
    another shape or stands in a clump, and for a wall with sense 0.

        contact = mpm.RigidContact()
        scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(...), mpm.GridToParticle(), mpm.DomainUpdater()]
        bodies = inYade.Bodies(contact, O.bodies.append([sphere((0, 1, 0), 0.2)]), friction=0.5)
        coupling = inYade.attach(scene)
        coupling.exchanges.append(bodies)
    """

    def __init__(self, contact, ids, friction=0.0, thickness=1.0, facetThickness=0.0, plane="xy"):
        from yade import O
        self._O, self.contact, self.ids, self.thickness = O, contact, list(ids), float(thickness)
        if not 0 < self.thickness < np.inf:
            raise ValueError(f"inYade.Bodies: thickness = {thickness!r} m is not allowed; give a positive number")
        self._plane = Plane(plane)
        for number in self.ids:
            if not 0 <= number < len(O.bodies) or O.bodies[number] is None:
                raise ValueError(f"inYade.Bodies: there is no body {number} in O.bodies")
            contact.addBody(_shapesOf(O, O.bodies[number], facetThickness, self._plane), friction=friction)
        self._frames = np.array([self._plane.turnToScene(_frameOf(O.bodies[number])) for number in self.ids])
        self._states = [O.bodies[number].state for number in self.ids]  # YADE hands out references
        self._forces = self._torques = np.zeros((len(self.ids), 3))
        self._sendStates()
        self._fresh = False

    def read(self, coupling):
        """At the beginning of a cycle, when both clocks agree: states of the bodies to the contact."""
        self.contact.takeImpulses()
        self._sendStates()
        self._fresh = True

    def apply(self, coupling):
        """In every DEM step: mean force and moment of the cycle's MPM steps to the bodies."""
        if self._fresh:
            time = coupling.scene.dt * coupling.mpmSteps / self.thickness
            impulses, moments = self.contact.takeImpulses()
            self._forces, self._torques, self._fresh = self._plane.toYade(impulses / time), self._plane.toYade(moments / time), False
        for number, force, torque in zip(self.ids, self._forces.tolist(), self._torques.tolist()):
            if any(force) or any(torque):
                self._O.forces.addF(number, force)
                self._O.forces.addT(number, torque)

    def _sendStates(self):
        states = [(*s.pos, s.ori[3], s.ori[0], s.ori[1], s.ori[2], *s.vel, *s.angVel) for s in self._states]
        table = np.reshape(np.array(states, float), (-1, 13))
        for first in (0, 4, 7, 10):
            table[:, first:first + 3] = self._plane.toScene(table[:, first:first + 3])
        table[:, 3:7] = _product(table[:, 3:7], self._frames)
        self.contact.setStates(table[:, :3], table[:, 3:7], table[:, 7:10], table[:, 10:])


def _frameOf(body):
    """Orientation (x, y, z, w) of the frame of the shapes against that of the body. A clump has its principal axes, which may be turned
    out of the plane of a 2D scene; the axes of its first member are not."""
    if not body.isClump:
        return 0.0, 0.0, 0.0, 1.0
    return tuple(body.shape.members[min(body.shape.members.keys())][1])


def _shapesOf(O, body, facetThickness, plane):
    """Shapes of a body of YADE in the frame of `_frameOf`, in the axes of the scene."""
    if body.isClumpMember:
        raise ValueError(f"inYade.Bodies: body {body.id} stands in clump {body.clumpId}; give the number of the clump")
    members = body.shape.members.items() if body.isClump else [(body.id, ((0, 0, 0), (0, 0, 0, 1)))]
    back = plane.turnToScene(_frameOf(body)) * (1, -1, -1, -1)
    return [_shapeOf(O.bodies[member], _turned(back, plane.toScene(centre)), tuple(_product(back, plane.turnToScene(turn))), facetThickness,
                     plane)
            for member, (centre, turn) in members]


def _shapeOf(body, centre, turn, facetThickness, plane):
    shape, kind = body.shape, type(body.shape).__name__
    if kind == "Sphere":
        return rigid.Sphere(shape.radius, tuple(centre))
    if kind == "Box":
        return rigid.Box(tuple(plane.lengthsToScene(shape.extents)), tuple(centre), turn)
    if kind == "Facet":
        return rigid.Facet(tuple(tuple(centre + _turned(turn, plane.toScene(v))) for v in shape.vertices), facetThickness)
    if kind == "Wall":
        if shape.sense == 0:
            raise ValueError(f"inYade.Bodies: wall {body.id} has sense 0; give 1 or -1, the side on which the soil is")
        return rigid.Wall(tuple(plane.toScene(shape.sense * np.eye(3)[shape.axis])), tuple(centre))
    raise ValueError(f"inYade.Bodies: body {body.id} is a {kind}; Sphere, Box, Facet, Wall and clumps of them can touch the soil")


def _turned(quaternion, v):
    w, axis = quaternion[0], np.array(quaternion[1:])
    return v + 2 * np.cross(axis, np.cross(axis, v) + w * v)


def _product(p, q):
    """Product of quaternions (..., 4), (w, x, y, z): first q, then p."""
    vector = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True), vector], axis=-1)
