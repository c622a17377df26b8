# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of YADE that touch the soil: their states go to a `RigidContact`, its forces come back."""
import numpy as np

from . import rigid


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

    O.engines needs a ForceResetter. YADE knows no units: give it Mg, m, s, kPa (kN), as the solver. Raises ValueError for a body that is not there, is of
    another shape or stands in a clump, and for a wall with sense 0.

        contact = mpm.RigidContact()
        scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(...), mpm.GridToParticle(), mpm.DomainUpdater()]
        bodies = inYade.Bodies(contact, O.bodies.append([sphere((0, 1, 0), 0.2)]), friction=0.5)
        coupling = inYade.attach(scene)
        coupling.exchanges.append(bodies)
    """

    def __init__(self, contact, ids, friction=0.0, thickness=1.0, facetThickness=0.0):
        from yade import O
        self._O, self.contact, self.ids, self.thickness = O, contact, list(ids), float(thickness)
        if not 0 < self.thickness < np.inf:
            raise ValueError(f"inYade.Bodies: thickness = {thickness!r} m is not allowed; give a positive number")
        for number in self.ids:
            if not 0 <= number < len(O.bodies) or O.bodies[number] is None:
                raise ValueError(f"inYade.Bodies: there is no body {number} in O.bodies")
            contact.addBody(_shapesOf(O, O.bodies[number], facetThickness), friction=friction)
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
            self._forces, self._torques, self._fresh = impulses / time, moments / time, False
        for number, force, torque in zip(self.ids, self._forces.tolist(), self._torques.tolist()):
            if any(force) or any(torque):
                self._O.forces.addF(number, force)
                self._O.forces.addT(number, torque)

    def _sendStates(self):
        states = [(*s.pos, s.ori[3], s.ori[0], s.ori[1], s.ori[2], *s.vel, *s.angVel) for s in self._states]
        table = np.reshape(np.array(states, float), (-1, 13))
        self.contact.setStates(table[:, :3], table[:, 3:7], table[:, 7:10], table[:, 10:])


def _shapesOf(O, body, facetThickness):
    """Shapes of a body of YADE in its own frame."""
    if body.isClumpMember:
        raise ValueError(f"inYade.Bodies: body {body.id} stands in clump {body.clumpId}; give the number of the clump")
    if not body.isClump:
        return [_shapeOf(body, np.zeros(3), (1.0, 0.0, 0.0, 0.0), facetThickness)]
    return [_shapeOf(O.bodies[member], np.array(pose[0]), (pose[1][3], pose[1][0], pose[1][1], pose[1][2]), facetThickness)
            for member, pose in body.shape.members.items()]


def _shapeOf(body, centre, turn, facetThickness):
    shape, kind = body.shape, type(body.shape).__name__
    if kind == "Sphere":
        return rigid.Sphere(shape.radius, tuple(centre))
    if kind == "Box":
        return rigid.Box(tuple(shape.extents), tuple(centre), turn)
    if kind == "Facet":
        return rigid.Facet(tuple(tuple(centre + _turned(turn, np.array(v))) for v in shape.vertices), facetThickness)
    if kind == "Wall":
        if shape.sense == 0:
            raise ValueError(f"inYade.Bodies: wall {body.id} has sense 0; give 1 or -1, the side on which the soil is")
        return rigid.Wall(tuple(shape.sense * np.eye(3)[shape.axis]), tuple(centre))
    raise ValueError(f"inYade.Bodies: body {body.id} is a {kind}; Sphere, Box, Facet, Wall and clumps of them can touch the soil")


def _turned(quaternion, v):
    w, axis = quaternion[0], np.array(quaternion[1:])
    return v + 2 * np.cross(axis, np.cross(axis, v) + w * v)
