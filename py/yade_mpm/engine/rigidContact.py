# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact of the scene's bodies with rigid ones."""

import numpy as np

from ..base.attributes import ofCore
from ..base.kinds import NUMBER, Kind, listOf, takes
from ..base.wording import shown
from ..geometry.numbers import floats, isNumber
from ..rigid.shapes import HeightField, shapeRow
from .engine import generated
from .records import column, withRows

PAIR = Kind("four numbers", lambda pair: np.shape(pair) == (4,))


class RigidContact(generated["RigidContact"]):
    __doc__ = (
        generated["RigidContact"].__doc__
        + """

Rigid bodies are added by `addBody` and moved by `setStates`, by YADE or a callback; until they are set again
they move on with their velocities. All arrays have a row per rigid body and three columns, in 2D scenes,
too."""
    )

    frictionWork = property(
        lambda self: self._core.value("frictionWork"), doc="Work lost to friction since the start, kJ."
    )

    @takes(friction=NUMBER, mass=NUMBER, adhesion=NUMBER)
    def addBody(
        self,
        shapes,
        friction=0.0,
        position=(0, 0, 0),
        orientation=(1, 0, 0, 0),
        velocity=(0, 0, 0),
        angularVelocity=(0, 0, 0),
        mass=0.0,
        adhesion=0.0,
    ):
        """Adds a rigid body and returns its number.

        Parameters
        ----------
        shapes : `rigid.Sphere`, `Box`, `Wall`, `Facet` or `HeightField`, or a list of them (a clump), in the
            frame of the body.
        friction : float, coefficient, -; default 0.
        position : (2,) or (3,), m; default the origin.
        orientation : (4,), unit quaternion (w, x, y, z); default not turned.
        velocity : (2,) or (3,), m/s; default zero.
        angularVelocity : (3,), rad/s; default zero.
        mass : float, Mg (2D: Mg/m), of a body that yields to its forces; give it where whoever moves the body
            does so by forces. Contact with a body that is lighter than the soil's particles is then made so
            soft that the step resolves it; else it would leave faster than it came. Default 0: it does not
            yield, or is heavy.
        adhesion : float, kPa, shear strength of its contact at no pressure; default 0.

        Raises RuntimeError after the first run, ValueError for a value that is not allowed.
        """
        if self._isBound:
            raise RuntimeError("RigidContact: addBody after the first run; add all rigid bodies before it")
        return self._insert(
            shapes, friction, position, orientation, velocity, angularVelocity, mass, adhesion
        )

    def _insertBody(self, shapes, friction=0.0, mass=0.0, adhesion=0.0):
        """As `addBody`, between two steps of a host that gives the states and prepares the scene again."""
        return self._insert(shapes, friction, (0, 0, 0), (1, 0, 0, 0), (0, 0, 0), (0, 0, 0), mass, adhesion)

    @takes(pairs=listOf(PAIR, "a list of (rigid body, body, friction, adhesion)"))
    def setPairs(self, pairs):
        """Friction and adhesion of pairs of materials, between two runs.

        Parameters
        ----------
        pairs : list of (number of the rigid body, number of the body in scene.bodies, friction -, adhesion
            kPa); they hold in place of what the two bodies have by themselves.
        """
        names = "body", "soil", "friction", "adhesion"
        rows = [dict(zip(names, (int(body), int(soil), float(f), float(a)))) for body, soil, f, a in pairs]
        self._core.set("pairs", withRows((), rows) if rows else ())
        self._core.finish()

    def _insert(self, shapes, friction, position, orientation, velocity, angularVelocity, mass, adhesion):
        shapes = list(shapes) if isinstance(shapes, (list, tuple)) else [shapes]
        if not shapes:
            raise ValueError("RigidContact: addBody without a shape; give e.g. [mpm.rigid.Sphere(0.1)]")
        number = len(self.friction)
        state = {
            "position": _numbers("position", position, 3),
            "orientation": _numbers("orientation", orientation, 4),
            "velocity": _numbers("velocity", velocity, 3),
            "angularVelocity": _numbers("angularVelocity", angularVelocity, 3),
        }
        if not abs(np.linalg.norm(state["orientation"]) - 1) < 1e-6:
            raise ValueError(
                f"RigidContact: orientation = {shown(orientation)} is not allowed; give a unit quaternion "
                "(w, x, y, z)"
            )
        impulse = {"force": [0.0] * 3, "torque": [0.0] * 3}
        fields = [shape for shape in shapes if isinstance(shape, HeightField)]
        rows = [shapeRow(number, shape) for shape in shapes if not isinstance(shape, HeightField)]
        if not (isNumber(mass) and 0 <= mass < np.inf):
            raise ValueError(
                f"RigidContact: mass = {shown(mass)} is not allowed; give Mg, or zero for a body that does "
                "not yield"
            )
        self._core.set("friction", [*self.friction, friction])
        self._core.set("masses", [*self.masses, float(mass)])
        self._core.set("adhesion", [*self.adhesion, float(adhesion)])
        heights = [self._core.value("heights"), *(field.heights.ravel() for field in fields)]
        self._core.set("heights", np.concatenate(heights).tolist())
        tables = (
            ("shapes", rows),
            ("heightFields", [field.record(number) for field in fields]),
            ("states", [state]),
            ("impulses", [impulse]),
        )
        for name, more in tables:
            if more:
                self._core.set(name, withRows(self._core.value(name), more))
        self._core.finish()
        return number

    def _replaceShapes(self, shapes):
        """Gives the rigid bodies other shapes, between two steps of a host that prepares the scene again
        behind it. A body without a shape touches nothing.

        Parameters
        ----------
        shapes : list of (number of the rigid body, `rigid.Sphere`, `Box`, `Wall` or `Facet`).
        """
        rows = [shapeRow(number, shape) for number, shape in shapes]
        self._core.set("shapes", withRows((), rows) if rows else ())
        self._core.finish()

    def _frictions(self):
        """The coefficients of friction of all rigid bodies."""
        return list(self.friction)

    def setStates(self, positions, orientations, velocities, angularVelocities):
        """Puts the rigid bodies where they are now.

        Parameters
        ----------
        positions : (N, 3), m.
        orientations : (N, 4), unit quaternions (w, x, y, z).
        velocities : (N, 3), m/s.
        angularVelocities : (N, 3), rad/s.
        """
        try:
            states = positions, orientations, velocities, angularVelocities
            arrays = [np.ascontiguousarray(a, np.float64) for a in states]
        except (TypeError, ValueError) as error:
            raise ValueError(f"RigidContact: setStates: {error}; give arrays of numbers") from None
        self._core.setStates(*arrays)

    forces = property(
        lambda self: np.array(self._core.forces),
        doc="Forces on the rigid bodies in the last step, kN (2D: kN/m).",
    )
    torques = property(
        lambda self: np.array(self._core.torques),
        doc="Moments on the rigid bodies about their positions, kN m.",
    )
    positions = property(
        lambda self: self._state("position"), doc="Positions, m; where the bodies are after the last step."
    )
    orientations = property(lambda self: self._state("orientation", 4), doc="Orientations (w, x, y, z).")
    velocities = property(lambda self: self._state("velocity"), doc="Velocities, m/s.")
    angularVelocities = property(
        lambda self: self._state("angularVelocity"), doc="Angular velocities, rad/s."
    )
    contacts = ofCore("contacts", "Number of contacts in the last step.")
    sliding = ofCore("sliding", "Number of contacts that slid in the last step.")
    largestPenetration = ofCore("largestPenetration", "Largest overlap in the last step, m.")
    springEnergy = ofCore("springEnergy", "Energy in the springs of all contacts in the last step, kJ.")
    stiffnessUsed = ofCore("stiffnessUsed", "Normal stiffness per area in the last step, kPa/m.")

    def takeImpulses(self):
        """Integrals of forces and torques over the time since the last call, kN s and kN m s: (N, 3), (N, 3);
        for sub-cycling."""
        taken = self._core.value("impulses")
        self._core.clearImpulses()
        return column(taken, "force", 3), column(taken, "torque", 3)

    def contactTable(self):
        """Dict of arrays over the contacts of the last step.

        soil : number of the body in scene.bodies; body : rigid body; id : particle (uGIMP) or vertex (APDI);
        normal (n, 3), out of the rigid body; slip (n, 3), m, held by the tangential spring; point (n, 3), m,
        the vertex, or where the particle would be had it moved as it is strained; gap, m; stretch of a box
        along the normal since it was touched; force (n, 3), kN, on the soil.
        """
        history = self._core.value("history")
        table = {
            **{name: column(history, name, type=int) for name in ("soil", "body", "id")},
            **{name: column(history, name, 3) for name in ("normal", "slip", "point")},
            "gap": column(history, "gap"),
            "stretch": column(history, "stretch"),
            "force": column(history, "force", 3),
        }
        pushes = (table["gap"] < 0) | table["force"].any(axis=1)
        return {name: values[pushes] for name, values in table.items()}

    def _state(self, name, width=3):
        return column(self._core.value("states"), name, width)

    def __repr__(self):
        return f"<RigidContact of {len(self.friction)} rigid bodies, {self.contacts} contacts>"


def _numbers(what, value, width):
    try:
        array = floats(value)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if width == 3 and array.shape == (2,):
        array = np.append(array, 0.0)
    if array.shape != (width,) or not np.isfinite(array).all():
        raise ValueError(f"RigidContact: {what} = {shown(value)} is not allowed; give {width} numbers")
    return array.tolist()
