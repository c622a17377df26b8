# SPDX-License-Identifier: GPL-2.0-or-later
"""Engines of the step, as registered in pkg/mpm/engine, prescribed motions, and callbacks."""

import sys
import weakref

import numpy as np

from .. import _core
from ..base.attributes import Attributed, Guarded, _plain, makeClasses
from ..geometry.mesh import _FACETS, boundaryFacets
from ..geometry.regions import Region
from ..particle.body import Body, BodyPart
from .rigid import shapeRow

FACES = {
    2: {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)},
    3: {"left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 1), "bottom": (2, 0), "top": (2, 1)},
}


def belongTo(scene, part):
    """Gives an engine or a prescribed motion to a scene; another scene's is refused, for it sums up work, rows or frames."""
    if part._owner is not None and part._owner() is not scene:
        raise ValueError(
            f"{type(part).__name__}: it was used by another scene; make a new one for each scene"
        )
    part._owner = weakref.ref(scene)


class Engine(Attributed):
    """Base of all engines: `label` names one, `dead` leaves it out."""

    seconds = property(lambda self: self.core.seconds, doc="Wall time spent in this engine, s.")
    calls = property(lambda self: self.core.calls, doc="How often the engine acted.")

    _owner = None  # weak reference to the scene that it works for
    _isBound = False  # checked against a scene: vectors keep their length from then on

    def __setattr__(self, name, value):
        before = None if name.startswith("_") else getattr(self, name, None)
        super().__setattr__(name, value)
        if self._isBound and isinstance(before, tuple) and len(getattr(self, name)) != len(before):
            given = len(getattr(self, name))
            self.core.set(name, before)
            raise ValueError(f"{type(self).__name__}: {name} has {given} components; give {len(before)}")

    def bind(self, scene):
        """Called before a run; engines that need the scene look things up here."""

    def flush(self):
        """Called when a run ends or is saved; engines that write files write here what is not in them yet."""

    def frictions(self):
        """All coefficients of friction that the engine was given."""
        return []

    def stepsToCall(self, scene):
        """After so many steps Python may have been called, and certainly not before: the run looks then whether to stop."""
        return 1 << 30


_generated = makeClasses(_core.engineNames(), _core.makeEngine, Engine)


class Prescribed(Guarded):
    """A prescribed velocity; base of `Drive` and `Hold`.

    Outputs of the last step: `reaction` (dim,) kN, `moment` kN m about `centre` (a number in 2D, (3,) in 3D), both
    exerted by the constraint on the material (2D: per metre). Since the start: `work` kJ, and `impulse` (dim,) kN s, the time
    integral of the reaction, whose difference between two times makes the mean.
    """

    _owner = None

    def __init__(self, velocity, ramp, name):
        object.__setattr__(self, "core", _core.Constraint())
        self._velocity = _velocity(type(self).__name__, velocity)
        self._hasBegun = False
        if not isinstance(name, str):
            raise TypeError(f"{type(self).__name__}: name = {name!r}; give a string")
        if not (isinstance(ramp, (int, float, np.number)) and 0 <= ramp < np.inf):
            raise ValueError(
                f"{type(self).__name__}: ramp = {ramp!r} is not allowed; give zero or a positive time in s"
            )
        self.core.name, self.core.velocity, self.core.ramp = name, self._velocity, float(ramp)

    def bind(self, scene):
        """Called before a run: the ramp counts from the first one."""
        if self.dim != scene.dim:
            raise ValueError(f"{type(self).__name__}: velocity has {self.dim} components; give {scene.dim}")
        if not self._hasBegun:
            self.core.began, self._hasBegun = scene.time, True

    dim = property(lambda self: len(self._velocity), doc="Number of axes, 2 or 3.")
    name = property(lambda self: self.core.name, doc="Name, used for histories.")
    ramp = property(lambda self: self.core.ramp, doc="Time over which the velocity grows from zero, s.")
    work = property(lambda self: self.core.work, doc="Work done on the material since the start, kJ.")
    heldNodes = property(
        lambda self: self.core.heldNodes, doc="Number of nodal components held in the last step."
    )
    centre = property(
        lambda self: np.array(self.core.centre)[: self.dim], doc="Point that `moment` refers to, m."
    )

    @property
    def velocity(self):
        """Prescribed velocity, m/s, one component per axis, None where free; may be changed between steps."""
        return tuple(None if np.isnan(v) else v for v in self.core.velocity)

    @velocity.setter
    def velocity(self, value):
        values = _velocity(type(self).__name__, value)
        if len(values) != self.dim:
            raise ValueError(f"{type(self).__name__}: velocity has {len(values)} components; give {self.dim}")
        self.core.velocity = self._velocity = values

    @property
    def reaction(self):
        """Force on the material in the last step, kN (2D: kN/m). RuntimeError as long as it is in no scene that was run."""
        if not self._hasBegun:
            kind = type(self).__name__
            raise RuntimeError(
                f"{kind}: '{self.name}' is in no scene that was run; give it to GridSolver({kind.lower()}=...) and run the scene"
            )
        return np.array(self.core.reaction)[: self.dim]

    impulse = property(
        lambda self: np.array(self.core.impulse)[: self.dim],
        doc="Time integral of the reaction since the start, kN s (2D: kN s/m).",
    )

    @property
    def moment(self):
        """Moment on the material about `centre` in the last step, kN m."""
        return self.core.moment[2] if self.dim == 2 else np.array(self.core.moment)


class Drive(Prescribed):
    """Moves a part of a body with a prescribed velocity and measures the force that takes.

    Parameters
    ----------
    part : part of a body: `body.above(y)`, `body.below(y)` (looked up anew in every step), `body.inside(region)`,
        `body.all()`, or a body.
    velocity : m/s, one component per axis; None leaves a direction free.
    ramp : s, time over which the velocity grows from zero; default 0.
    name : for histories; default "drive".

    Nodes whose mass is to more than one half driven take the velocity.
    """

    def __init__(self, part, velocity, ramp=0.0, name="drive"):
        super().__init__(velocity, ramp, name)
        part = part.all() if isinstance(part, Body) else part
        if not isinstance(part, BodyPart):
            raise TypeError(f"Drive: part = {part!r}; give a body or a part of one, e.g. pile.above(12)")
        object.__setattr__(self, "part", part)
        far = 1e300
        self.core.body = part.body.name
        lower, upper = [-far] * self.dim, [far] * self.dim
        lower[-1] = -far if part.lower is None else float(part.lower)
        upper[-1] = far if part.upper is None else float(part.upper)
        self.core.lower, self.core.upper = lower, upper
        if part.ids is not None:
            self.core.ids = part.ids
        part.body._scene._made.append(self)

    def bind(self, scene):
        if not any(self.part.body is b for b in scene.bodies):
            raise ValueError(f"Drive: '{self.part.body.name}' is not a body of this scene")
        if not self._hasBegun and self.part.ids is None:
            heights = self.part.body.position[:, -1]
            if not (
                (heights > self.core.lower[self.dim - 1]) & (heights <= self.core.upper[self.dim - 1])
            ).any():
                raise ValueError(
                    f"Drive: no particle of '{self.part.body.name}' is in the driven part, {self.part}; its particles are at "
                    f"heights from {heights.min():g} to {heights.max():g} m"
                )
        super().bind(scene)


class Hold(Prescribed):
    """Prescribes the velocity of nodes: of a face of the grid or inside a region.

    Parameters
    ----------
    where : name of a face ("left", "right", "bottom", "top"; in 3D also "front", "back") or a region. Nodes on and
        behind a face are held.
    velocity : m/s, one component per axis; None leaves a direction free.
    ramp : s, time over which the velocity grows from zero; default 0.
    name : for histories; default the name of the face or "hold".
    """

    _isFound = False  # whether its nodes are known: the grid stays as it is

    def __init__(self, where, velocity, ramp=0.0, name=None):
        if not isinstance(where, (str, Region)):
            raise TypeError(f"Hold: where = {where!r}; give the name of a face or a region")
        super().__init__(velocity, ramp, name or (where if isinstance(where, str) else "hold"))
        object.__setattr__(self, "where", where)

    def bind(self, scene):
        super().bind(scene)
        if self._isFound:
            return
        nodes = scene.faceNodes(self.where) if isinstance(self.where, str) else scene.nodesInside(self.where)
        if len(nodes) == 0:
            raise ValueError(
                f"Hold: no grid node is inside {self.where!r}; make it reach a node (multiples of the cell size)"
            )
        self.core.nodes = np.ascontiguousarray(nodes, np.int32)
        self.core.centre = list(scene.nodePositions()[nodes].mean(axis=0))
        self._isFound = True


class GridSolver(_generated["GridSolver"]):
    __doc__ = (
        _generated["GridSolver"].__doc__
        + """
roller : faces of the grid where the normal velocity is zero, e.g. ("left", "right").
fixed : faces where all velocity is zero, e.g. ("bottom",).
hold : `Hold` or list of them.
drive : `Drive` or list of them.
Where several apply to a node, the later in this order wins: roller, fixed, hold, drive."""
    )

    def __init__(self, roller=(), fixed=(), hold=(), drive=(), **attributes):
        super().__init__(**attributes)
        self._roller, self._fixed = _names("roller", roller), _names("fixed", fixed)
        self._hold, self._drive = _listOf(Hold, "hold", hold), _listOf(Drive, "drive", drive)
        self._faces = {}

    roller = property(lambda self: self._roller, doc="Faces with zero normal velocity.")
    fixed = property(lambda self: self._fixed, doc="Faces with zero velocity.")
    hold = property(lambda self: self._hold, doc="List of prescribed motions of nodes.")

    @property
    def drive(self):
        """The only `Drive`, or the list of them."""
        return self._drive[0] if len(self._drive) == 1 else self._drive

    def constraints(self, scene):
        """All prescribed motions of the scene, in the order in which later ones win."""
        faces = []
        for face in self._roller + self._fixed:
            if face not in FACES[scene.dim]:
                raise ValueError(
                    f"GridSolver: there is no face '{face}'; faces are {', '.join(FACES[scene.dim])}"
                )
            velocity = [0.0] * scene.dim
            if face in self._roller and face not in self._fixed:
                velocity = [0.0 if k == FACES[scene.dim][face][0] else None for k in range(scene.dim)]
            if face not in self._faces:
                self._faces[face] = Hold(face, velocity)
            if not any(h is self._faces[face] for h in faces):
                faces.append(self._faces[face])
        everything = faces + self._hold + self._drive
        names = [c.name for c in everything]
        for c in everything:
            if names.count(c.name) > 1:
                raise ValueError(
                    f"GridSolver: two prescribed motions are named '{c.name}'; give each a name of its own"
                )
        return everything


class BoundaryLoad(_generated["BoundaryLoad"]):
    __doc__ = (
        _generated["BoundaryLoad"].__doc__
        + """
body : the loaded APDI body.
where : region; facets whose centre is inside are loaded (default: all boundary facets)."""
    )

    _fixed = ("body", "facets")

    def bind(self, scene):
        body = scene[self.body]
        most = body.id.max(initial=-1), 2 * scene.dim
        pairs = np.reshape(self.facets, (-1, 2)) if len(self.facets) % 2 == 0 else np.full((1, 2), -1)
        if ((pairs < 0) | (body.converted == 0) & (pairs > np.array(most) - (0, 1))).any() or (
            pairs % 1
        ).any():
            raise ValueError(
                f"BoundaryLoad: facets name domains that '{self.body}' does not have; make the load from the body"
            )

    def __init__(self, body, where=None, **attributes):
        self._usedBy = body if isinstance(body, str) else getattr(body, "name", None)
        if isinstance(body, str):  # from a checkpoint: the facets are given
            super().__init__(body=body, **attributes)
            return
        if not isinstance(body, Body):
            raise TypeError(f"BoundaryLoad: body = {body!r}; give a body, as scene.add returns it")
        if not (where is None or isinstance(where, Region)):
            raise TypeError(f"BoundaryLoad: where = {where!r}; give a region, e.g. box((0, 2), (1, 3))")
        if body.mesh is None:
            raise ValueError(
                f"BoundaryLoad: '{body.name}' "
                + (
                    "lost its first mesh when domains were converted; make loads before that"
                    if body.type.core.isMeshed
                    else "has no boundary facets; loads need an APDI body"
                )
            )
        facets, owners = boundaryFacets(body.mesh)
        if where is not None:
            inside = where.contains(body.mesh.points[facets].mean(axis=1))
            facets, owners = facets[inside], owners[inside]
        if len(facets) == 0:
            raise ValueError(
                f"BoundaryLoad: no boundary facet of '{body.name}' is inside {where!r}; widen the region"
            )
        pairs = [(owner, _facetNumber(body.mesh.cells[owner], facet)) for facet, owner in zip(facets, owners)]
        super().__init__(body=body.name, facets=np.array(pairs, float).ravel(), **attributes)
        body._scene._made.append(self)


def _facetNumber(cell, facet):
    """Which facet of a cell has these vertices."""
    dim = 2 if len(cell) == 4 else 3
    for number, corners in enumerate(_FACETS[dim]):
        if set(cell[list(corners)]) == set(facet):
            return number
    raise AssertionError("a boundary facet belongs to its owner")


class RigidContact(_generated["RigidContact"]):
    __doc__ = (
        _generated["RigidContact"].__doc__
        + """

Rigid bodies are added by `addBody` and moved by `setStates`, by YADE or a callback; until they are set anew they move on with
their velocities. All arrays have a row per rigid body and three columns, in 2D scenes, too."""
    )

    _isFelt = True  # False: there are inYade.Bodies that no coupling has

    def addBody(
        self,
        shapes,
        friction=0.0,
        position=(0, 0, 0),
        orientation=(1, 0, 0, 0),
        velocity=(0, 0, 0),
        angularVelocity=(0, 0, 0),
    ):
        """Adds a rigid body and returns its number.

        shapes : `rigid.Sphere`, `Box`, `Wall` or `Facet`, or a list of them (a clump), in the frame of the body.
        friction : coefficient, -. position : m; orientation : unit quaternion (w, x, y, z); velocity : m/s;
        angularVelocity : rad/s.
        """
        if self._isBound:
            raise RuntimeError("RigidContact: addBody after the first run; add all rigid bodies before it")
        shapes = list(shapes) if isinstance(shapes, (list, tuple)) else [shapes]
        if not shapes:
            raise ValueError("RigidContact: addBody without a shape; give e.g. [mpm.rigid.Sphere(0.1)]")
        number = len(self.friction)
        state = (
            _rows("position", [position], 3)
            + _rows("orientation", [orientation], 4)
            + _rows("velocity", [velocity], 3)
            + _rows("angularVelocity", [angularVelocity], 3)
        )
        if not abs(np.linalg.norm(state[3:7]) - 1) < 1e-6:
            raise ValueError(
                f"RigidContact: orientation = {orientation!r} is not allowed; give a unit quaternion (w, x, y, z)"
            )
        rows = [x for shape in shapes for x in shapeRow(number, shape)]
        self.core.set("friction", [*self.friction, friction])
        for name, more in (("shapes", rows), ("states", state), ("impulses", [0.0] * 6)):
            self.core.set(name, [*self.core.value(name), *more])
        self.core.finish()
        return number

    def frictions(self):
        """The coefficients of friction of all rigid bodies."""
        return list(self.friction)

    def setStates(self, positions, orientations, velocities, angularVelocities):
        """Positions (N, 3) m, orientations (N, 4) as (w, x, y, z), velocities (N, 3) m/s, angular velocities (N, 3) rad/s."""
        self.core.setStates(
            *(
                np.ascontiguousarray(a, np.float64)
                for a in (positions, orientations, velocities, angularVelocities)
            )
        )

    forces = property(
        lambda self: np.array(self.core.forces),
        doc="Forces on the rigid bodies in the last step, kN (2D: kN/m).",
    )
    torques = property(
        lambda self: np.array(self.core.torques),
        doc="Moments on the rigid bodies about their positions, kN m.",
    )
    positions = property(
        lambda self: self._states()[:, :3], doc="Positions, m; where the bodies are after the last step."
    )
    orientations = property(lambda self: self._states()[:, 3:7], doc="Orientations (w, x, y, z).")
    velocities = property(lambda self: self._states()[:, 7:10], doc="Velocities, m/s.")
    angularVelocities = property(lambda self: self._states()[:, 10:], doc="Angular velocities, rad/s.")
    contacts = property(lambda self: self.core.contacts, doc="Number of contacts in the last step.")
    sliding = property(lambda self: self.core.sliding, doc="Number of contacts that slid in the last step.")
    largestPenetration = property(
        lambda self: self.core.largestPenetration, doc="Largest overlap in the last step, m."
    )
    stiffnessUsed = property(
        lambda self: self.core.stiffnessUsed, doc="Normal stiffness per area in the last step, kPa/m."
    )

    def takeImpulses(self):
        """Integrals of forces and torques over the time since the last call, kN s and kN m s: (N, 3), (N, 3); for sub-cycling."""
        taken = np.reshape(self.core.value("impulses"), (-1, 6))
        self.core.clearImpulses()
        return taken[:, :3], taken[:, 3:]

    def contactTable(self):
        """Dict of arrays over the contacts of the last step.

        soil : number of the body in scene.bodies; body : rigid body; id : particle (uGIMP) or vertex (APDI); normal (n, 3), out
        of the rigid body; slip (n, 3), m, held by the tangential spring; point (n, 3), m, the vertex, or where the
        particle would be had it moved as it is strained; gap, m; force (n, 3), kN, on the soil.
        """
        rows = np.reshape(self.core.value("history"), (-1, 16))
        table = {name: rows[:, k].astype(int) for k, name in enumerate(("soil", "body", "id"))}
        return {
            **table,
            "normal": rows[:, 3:6],
            "slip": rows[:, 6:9],
            "point": rows[:, 9:12],
            "gap": rows[:, 12],
            "force": rows[:, 13:],
        }

    def _states(self):
        return np.reshape(self.core.value("states"), (-1, 13))

    def __repr__(self):
        return f"<RigidContact of {len(self.friction)} rigid bodies, {self.contacts} contacts>"


def _rows(what, values, width):
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if width == 3 and array.shape[-1:] == (2,):
        array = np.pad(array, ((0, 0), (0, 1)))
    if array.shape != (len(values), width) or not np.isfinite(array).all():
        raise ValueError(f"RigidContact: {what} = {values[0]!r} is not allowed; give {width} numbers")
    return array.ravel().tolist()


class Contact(_generated["Contact"]):
    __doc__ = (
        _generated["Contact"].__doc__
        + """

        scene.add("pile", shaft, steel, mpm.APDI(size=0.125), group="pile")
        contact = mpm.Contact(friction=0.4)
        scene.engines = [mpm.ParticleToGrid(), mpm.GridSolver(...), contact, mpm.GridToParticle(), mpm.DomainUpdater()]
"""
    )

    def __init__(self, **attributes):
        super().__init__(**attributes)
        object.__setattr__(self, "_pairs", {})
        object.__setattr__(self, "_groups", [])

    def pair(self, first, second, friction, adhesion=0.0):
        """Friction (-) and adhesion (kPa) between two groups, by their names; else those of the engine."""
        for name, value in (("friction", friction), ("adhesion", adhesion)):
            if not (isinstance(value, (int, float, np.number)) and value >= 0):
                raise ValueError(
                    f"Contact: {name} = {value!r} between '{first}' and '{second}'; give zero or a positive number"
                )
        self._pairs[first, second] = float(friction), float(adhesion)
        if self._groups:
            self._setPairs()

    def frictions(self):
        """All coefficients of friction: that of the engine, and those of pairs of groups."""
        return [self.friction, *(friction for friction, _ in self._pairs.values())]

    def bind(self, scene):
        object.__setattr__(self, "_groups", list(dict.fromkeys(b.group for b in scene.bodies)))
        if self._pairs:
            self._setPairs()

    def _setPairs(self):
        for name in (n for names in self._pairs for n in names):
            if name not in self._groups:
                raise ValueError(f"Contact: there is no group '{name}'; groups: {', '.join(self._groups)}")
        self.core.set(
            "pairs",
            [
                float(x)
                for (a, b), law in self._pairs.items()
                for x in (self._groups.index(a), self._groups.index(b), *law)
            ],
        )

    sliding = property(
        lambda self: self.core.sliding, doc="Number of nodes in contact that slid in the last step."
    )
    largestPenetration = property(
        lambda self: self.core.largestPenetration,
        doc="Largest overlap of surfaces at nodes in contact in the last step, m.",
    )
    gridLoss = property(
        lambda self: self.core.gridLoss,
        doc="Energy that contact took from the motion of the nodes in the last step, kJ; never negative (doc/contact.md).",
    )
    reduced = property(
        lambda self: self.core.reduced,
        doc="Number of pairs of groups whose impulses would have given energy in the last step, and were cut (doc/contact.md).",
    )

    def contactTable(self):
        """Dict of arrays over the nodes in contact in the last step.

        first, second : names of the groups; node (n, 3), m; normal (n, 3), from the first to the second; gap, m (negative:
        overlap); area, m2 (2D: m); force (n, 3), kN, on the second; slip (n, 3), m/s, the rate of the first
        against the second (RigidContact: a length).
        """
        rows = np.reshape(self.core.table, (-1, 16))
        names = np.array(self._groups or [""], object)
        return {
            "first": names[rows[:, 0].astype(int)],
            "second": names[rows[:, 1].astype(int)],
            "node": rows[:, 2:5],
            "normal": rows[:, 5:8],
            "gap": rows[:, 8],
            "area": rows[:, 9],
            "force": rows[:, 10:13],
            "slip": rows[:, 13:],
        }

    def forces(self):
        """Dict (A, B) -> force on group B by group A in the last step, kN (3,), for all pairs of groups; zero where they do not meet."""
        return self._byPair(self.core.forces)

    def forceImpulses(self):
        """Dict (A, B) -> time integral of the force on group B by group A since the start, kN s (3,), for all pairs of groups."""
        return self._byPair(self.impulses)

    def _byPair(self, values):
        rows, pairs = (
            np.reshape(values, (-1, 3)),
            [(a, b) for b in range(len(self._groups)) for a in range(b)],
        )
        return {
            (self._groups[a], self._groups[b]): rows[k] if k < len(rows) else np.zeros(3)
            for k, (a, b) in enumerate(pairs)
        }

    def forceOn(self, group):
        """Force on a group in the last step, kN (3,)."""
        return sum(
            (
                (second == group) * force - (first == group) * force
                for (first, second), force in self.forces().items()
            ),
            np.zeros(3),
        )


class Callback(Engine):
    """Base of engines that call back into Python: every `iterPeriod` steps or every `virtPeriod` s of scene time.

    A class that adds `spec()`, a dict of constructor arguments that JSON can hold, is restored from checkpoints.
    """

    def __init__(self, iterPeriod=0, virtPeriod=0.0, **attributes):
        # The solver refers to the object weakly: a cycle through it would never be collected.
        method = weakref.WeakMethod(self._call)
        object.__setattr__(self, "core", _core.makePythonEngine(lambda: method()()))
        for name, value in dict(attributes, iterPeriod=iterPeriod, virtPeriod=virtPeriod).items():
            self.core.set(name, _plain(value))
        self._scene = None

    def bind(self, scene):
        self._scene = scene

    def _call(self):
        self._scene._acting = self
        self.act(self._scene)
        self._scene._acting = None

    def stepsToCall(self, scene):
        dt, steps = scene.core.dt, 1 << 30
        if self.iterPeriod > 0:
            past = scene.steps % self.iterPeriod
            steps = self.iterPeriod - past if past else 1
        if self.virtPeriod > 0:
            past = scene.time % self.virtPeriod
            steps = min(steps, max(1, int((self.virtPeriod - past) / dt) - 1) if past > dt else 1)
        return steps

    def act(self, scene):
        """What to do; the scene is at rest between two engines meanwhile."""
        raise NotImplementedError


class PyRunner(Callback):
    """Calls a Python function every `iterPeriod` steps or every `virtPeriod` seconds of scene time.

    Parameters
    ----------
    command : function of no argument, or of the scene; or a string that is executed in __main__, with `scene` defined.
    iterPeriod : steps between calls. virtPeriod : scene time between calls, s. One of the two is needed.
    """

    def __init__(self, command, iterPeriod=0, virtPeriod=0.0, **attributes):
        if not (callable(command) or isinstance(command, str)):
            raise TypeError(f"PyRunner: command = {command!r}; give a function or a string")
        if not iterPeriod and not virtPeriod:
            raise ValueError("PyRunner: give iterPeriod (steps) or virtPeriod (s)")
        super().__init__(iterPeriod, virtPeriod, **attributes)
        self._command = command
        self._code = compile(command, "<PyRunner>", "exec") if isinstance(command, str) else None
        self._wantsScene = callable(command) and _takesArgument(command)

    command = property(lambda self: self._command, doc="What is called.")

    def spec(self):
        """Constructor arguments for a checkpoint; a function cannot be stored: TypeError."""
        if not isinstance(self._command, str):
            raise TypeError("a function cannot be stored")
        return {"command": self._command, "iterPeriod": self.iterPeriod, "virtPeriod": self.virtPeriod}

    def act(self, scene):
        if isinstance(self._command, str):
            exec(self._code, dict(vars(sys.modules["__main__"]), scene=scene))
        elif self._wantsScene:
            self._command(scene)
        else:
            self._command()


def _takesArgument(function):
    import inspect

    try:
        parameters = inspect.signature(function).parameters.values()
    except ValueError:
        return False
    return any(
        p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters
    )


def _velocity(who, velocity):
    given = list(velocity) if isinstance(velocity, (list, tuple, np.ndarray)) else []
    numbers = [v for v in given if v is not None]
    if len(given) not in (2, 3) or not all(
        isinstance(v, (int, float, np.number)) and np.isfinite(v) for v in numbers
    ):
        raise ValueError(
            f"{who}: velocity = {velocity!r} is not allowed; give one number (m/s) or None per axis"
        )
    return [np.nan if v is None else float(v) for v in given]


def _names(what, names):
    if isinstance(names, str):
        names = (names,)
    if not (isinstance(names, (list, tuple)) and all(isinstance(n, str) for n in names)):
        raise TypeError(f"GridSolver: {what} = {names!r}; give names of faces, e.g. ('left', 'right')")
    return list(names)


def _listOf(kind, what, given):
    given = list(given) if isinstance(given, (list, tuple)) else [given]
    for one in given:
        if not isinstance(one, kind):
            raise TypeError(f"GridSolver: {what} = {one!r}; give mpm.{kind.__name__}(...)")
    return given


_own = {
    "GridSolver": GridSolver,
    "BoundaryLoad": BoundaryLoad,
    "RigidContact": RigidContact,
    "Contact": Contact,
    "PyRunner": PyRunner,
}
classes = {**_generated, **_own}
globals().update({name: c for name, c in classes.items() if name not in _own})
