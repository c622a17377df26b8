# SPDX-License-Identifier: GPL-2.0-or-later
"""Prescribed motions, of parts of bodies and of nodes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .. import _core
from ..base.attributes import Guarded, keep, ofCore
from ..base.html import card, table
from ..base.keywords import checked
from ..base.kinds import LIST, NOT_NEGATIVE, NUMBER, takes
from ..base.wording import shown
from ..geometry.numbers import floats, isNumber
from ..geometry.region import Region
from ..particle.body import Body
from ..particle.part import BodyPart
from .callback import Callback
from .supports import timeRows

FACES = {
    2: {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)},
    3: {"left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 1), "bottom": (2, 0), "top": (2, 1)},
}


class Prescribed(Guarded):
    """A prescribed velocity; base of `Drive` and `Hold`.

    Outputs of the last step: `reaction` (dim,) kN, `moment` kN m about `centre` (a number in 2D, (3,) in 3D),
    both exerted by the constraint on the material (plane strain: per metre; axisymmetric: of the whole
    circumference, and along x the sum of the radial forces). Since the start: `work` kJ, and
    `impulse` (dim,) kN s, the time integral of the reaction: its difference between two times makes the mean.
    The impulse is the change of momentum of what is held, less that by other forces. Work is done with the
    mean of the velocities prescribed at the start and the end of a step; one that begins takes over the
    velocity that it finds.
    """

    part: BodyPart  # of a Drive
    byHeight: bool  # of a Drive
    where: str | Region  # of a Hold
    _owner = None
    _hasBegun = False  # whether its ramp counts
    _per = ""  # what stands behind the unit of its force, known once it has begun

    def __init__(self, velocity, ramp, name):
        object.__setattr__(self, "_core", _core.Constraint())
        self._velocity = _velocity(type(self).__name__, velocity)
        if not isinstance(name, str):
            raise TypeError(f"{type(self).__name__}: name = {shown(name)}; give a string")
        NOT_NEGATIVE.check(type(self).__name__, "s", ramp=ramp)
        self._core.name, self._core.velocity, self._core.ramp = name, self._velocity, float(ramp)

    def _bind(self, scene):
        """Called before a run: the ramp counts from the first one."""
        if self.dim != scene.dim:
            raise ValueError(f"{type(self).__name__}: velocity has {self.dim} components; give {scene.dim}")
        if not self._hasBegun:
            self._core.began = scene.time
            keep(self, _hasBegun=True, _per=scene._perMetre)

    @takes(time=NUMBER)
    def velocityAt(self, time: float) -> np.ndarray:
        """Prescribed velocity at a time (s) with its ramp, m/s (dim,); nan where free."""
        since = max(0.0, time - self._core.began)
        return np.array(self._core.velocity) * (min(1.0, since / self.ramp) if self.ramp else 1.0)

    def __repr__(self):
        return f"<{type(self).__name__} '{self.name}': velocity {self.velocity} m/s>"

    def _repr_html_(self):
        """Card for a notebook: what is prescribed, and what it takes."""
        rows = [("velocity", self.velocity, "m/s"), ("ramp", self.ramp, "s")]
        if self._hasBegun:
            rows += [
                ("reaction", self.reaction.round(6).tolist(), f"kN{self._per}"),
                ("work", self.work, f"kJ{self._per}"),
            ]
        return card(f"{type(self).__name__} '{self.name}'", table(("", "value", "unit"), rows))

    dim = property(lambda self: len(self._velocity), doc="Number of axes, 2 or 3.")
    name = ofCore("name", "Name, used for histories.")
    ramp = ofCore("ramp", "Time over which the velocity grows from zero, s.")
    work = ofCore("work", "Work done on the material since the start, kJ.")
    heldNodes = ofCore("heldNodes", "Number of nodal components held in the last step.")
    centre = property(
        lambda self: np.array(self._core.centre)[: self.dim], doc="Point that `moment` refers to, m."
    )

    @property
    def velocity(self):
        """Prescribed velocity, m/s, one component per axis, None where free; may be changed between steps."""
        return tuple(None if np.isnan(v) else v for v in self._core.velocity)

    @velocity.setter
    def velocity(self, value):
        values = _velocity(type(self).__name__, value)
        if len(values) != self.dim:
            raise ValueError(f"{type(self).__name__}: velocity has {len(values)} components; give {self.dim}")
        self._core.velocity = self._velocity = values

    @property
    def reaction(self) -> np.ndarray:
        """Force on the material in the last step, kN (plane strain: kN/m): what the drive adds to the weight.
        The ground below a pile that is pressed down resists with -reaction and the weight of the pile.
        RuntimeError as long as it is in no scene that was run."""
        if not self._hasBegun:
            kind = type(self).__name__
            raise RuntimeError(
                f"{kind}: '{self.name}' is in no scene that was run; give it to "
                f"GridSolver({kind.lower()}=...) and run the scene"
            )
        return np.array(self._core.reaction)[: self.dim]

    impulse = property(
        lambda self: np.array(self._core.impulse)[: self.dim],
        doc="Time integral of the reaction since the start, kN s (2D: kN s/m).",
    )

    @property
    def moment(self) -> float | np.ndarray:
        """Moment on the material about `centre` in the last step, kN m."""
        return self._core.moment[2] if self.dim == 2 else np.array(self._core.moment)


class Drive(Prescribed):
    """Moves a part of a body with a prescribed velocity and measures the force that takes.

    Parameters
    ----------
    part : part of a body: `body.above(y)`, `body.below(y)`, `body.inside(region)`, `body.all()`, or a body.
    velocity : m/s, one component per axis; None leaves a direction free.
    ramp : s, time over which the velocity grows from zero; default 0.
    name : for histories; default "drive".
    byHeight : bool. False: the part keeps the particles that are in it at the first run, wherever they go.
        True: a part above or below a height is found again in each step; default False.

    Nodes of which half of the mass or more is driven take the velocity: where the part ends on a line of the
    grid, all nodes of that line do. While the body moves across the line, that holds as long as half of the
    mass there is driven: end a part between two lines where that counts. Of two drives that meet on a line,
    the later one in `GridSolver(drive=[...])` moves it.
    """

    @checked("Drive")
    def __init__(
        self,
        part: Body | BodyPart,
        velocity: Sequence[float | None],
        ramp: float = 0.0,
        name: str = "drive",
        byHeight: bool = False,
    ) -> None:
        super().__init__(velocity, ramp, name)
        part = part.all() if isinstance(part, Body) else part
        if not isinstance(part, BodyPart):
            raise TypeError(f"Drive: part = {shown(part)}; give a body or a part of one, e.g. pile.above(12)")
        keep(self, byHeight=bool(byHeight))
        self._choose(part)
        part.body.scene._loadsAndDrives.append(self)

    def _choose(self, part):
        keep(self, part=part)
        far = 1e300
        self._core.body = part.body.name
        lower, upper = [-far] * self.dim, [far] * self.dim
        lower[-1] = -far if part.lower is None else float(part.lower)
        upper[-1] = far if part.upper is None else float(part.upper)
        self._core.lower, self._core.upper = lower, upper
        if part.ids is not None:
            self._core.ids = part.ids

    @property
    def displacement(self) -> np.ndarray:
        """Mean displacement of the driven particles, weighted by mass, m (dim,); nan without any."""
        body, driven = self.part.body, self.part.has()
        mass = body.mass[driven]
        return mass @ body.displacement[driven] / mass.sum() if driven.any() else np.full(self.dim, np.nan)

    @property
    def rowsCrossed(self) -> float:
        """Rows of nodes behind the front of the driven body, from the edge of the grid on, with the part of
        the cell that it is in: it grows by one for each cell of the path. nan while the drive stands."""
        velocity = [0.0 if math.isnan(v) else v for v in self._core.velocity[: self.dim]]
        axis = max(range(self.dim), key=lambda k: abs(velocity[k]))
        body = self.part.body
        if not velocity[axis] or not body.count:
            return np.nan
        along, lines = body.corners()[..., axis], body.scene.lines[axis]
        if velocity[axis] > 0:
            return float(np.interp(along.max(), lines, np.arange(len(lines))))
        return float(np.interp(along.min(), lines, np.arange(len(lines))[::-1]))

    def _bind(self, scene):
        if not any(self.part.body is b for b in scene.bodies):
            raise ValueError(f"Drive: '{self.part.body.name}' is not a body of this scene")
        if not self._hasBegun and self.part.ids is None and not np.any(self.part.has()):
            heights = self.part.body.position[:, -1]
            at = (
                f"at heights from {heights.min():g} to {heights.max():g} m" if len(heights) else "it is empty"
            )
            raise ValueError(
                f"Drive: no particle of '{self.part.body.name}' is in the driven part, {self.part}, but "
                f"{at}; give a part there"
            )
        if not (self._hasBegun or self.byHeight):
            self._choose(self.part.now())
        super()._bind(scene)


class Hold(Prescribed):
    """Prescribes the velocity of nodes: of a face of the grid or inside a region.

    Parameters
    ----------
    where : name of a face ("left", "right", "bottom", "top"; in 3D also "front", "back") or a region, which a
        checkpoint has to describe: none of your own. Nodes on and behind a face are held.
    velocity : m/s, one component per axis; None leaves a direction free.
    ramp : s, time over which the velocity grows from zero; default 0.
    name : for histories; default the name of the face or "hold".

    Nodes stay where they are. Once the material has moved by more than a third of a cell it leaves them, and
    the reaction falls: press a body by `Drive` for more. A run tells when a hold has gone 0.4 of a cell.
    """

    _isFound = False  # whether its nodes are known: the grid stays as it is
    _way, _seenAt = 0.0, None  # see follow()

    @checked("Hold")
    def __init__(
        self,
        where: str | Region,
        velocity: Sequence[float | None],
        ramp: float = 0.0,
        name: str | None = None,
    ) -> None:
        if not isinstance(where, (str, Region)):
            raise TypeError(f"Hold: where = {shown(where)}; give the name of a face or a region")
        if isinstance(where, Region) and where.spec() is None:
            raise ValueError(
                f"Hold: where = {shown(where)} is a region of your own; its nodes no checkpoint could find; "
                f"give a region made by box(), polygon() and the like"
            )
        super().__init__(velocity, ramp, name or (where if isinstance(where, str) else "hold"))
        object.__setattr__(self, "where", where)

    def follow(self, time):
        """How far it has moved along each axis since its first run, m (dim,): with the mean of its velocities
        of now and when it was last asked (s)."""
        mean = (self.velocityAt(time) + self.velocityAt(self._seenAt)) / 2
        self._way = self._way + np.nan_to_num(mean) * (time - self._seenAt)
        self._seenAt = time
        return self._way

    def _bind(self, scene):
        super()._bind(scene)
        self._seenAt = scene.time if self._seenAt is None else self._seenAt
        if self._isFound:
            return
        nodes = scene.faceNodes(self.where) if isinstance(self.where, str) else scene.nodesInside(self.where)
        if len(nodes) == 0:
            raise ValueError(
                f"Hold: no grid node is inside {shown(self.where)}; make it reach a node (multiples of the "
                "cell size)"
            )
        self._core.nodes = np.ascontiguousarray(nodes, np.int32)
        self._core.centre = list(scene.nodePositions()[nodes].mean(axis=0))
        self._isFound = True


class Steering:
    """Command of a PyRunner at the head of the engines: gives a motion the velocity of a function.

    Parameters
    ----------
    name : of the `Drive` or `Hold`.
    function : of the scene's time, s, that returns the velocity, m/s, one component per axis.
    """

    def __init__(self, name, function):
        self.name, self.function = name, function

    def __call__(self, scene):
        motion = next(m for m in scene.constraints if m.name == self.name)
        motion.velocity = self.function(scene.time + scene.stepper.dt)


class MotionTable(Callback):
    """Gives a motion the velocity of a table, at the head of the engines. A checkpoint keeps it.

    In each step the velocity is the mean of the table over it, so that the path is its integral, whatever the
    steps.

    Parameters
    ----------
    motion : name of the `Drive` or `Hold`.
    table : rows (time, velocity along each axis), s and m/s, linear between them; None along a free axis.
    """

    @checked("MotionTable")
    def __init__(self, motion: str, table: list, label: str = "") -> None:
        super().__init__(iterPeriod=1, label=label)
        LIST.require("MotionTable", "table", table)
        table = list(table)
        self._motion = motion
        inSpace = all(np.shape(np.array(row, object)) == (4,) for row in table)
        self._rows = velocityRows("MotionTable", table, None, 3 if inSpace else 2)
        self._given = None  # the velocity that the motion has of it

    motion = property(lambda self: self._motion, doc="Name of what it moves.")
    rows = property(lambda self: self._rows, doc="Of the table; nan along free axes.")

    def __repr__(self):
        return f"MotionTable({self.motion!r}, {len(self.rows)} rows, label={self.label!r})"

    def spec(self):
        return {"motion": self.motion, "table": withFreeAxes(self.rows)}

    def mean(self, start, end):
        """Velocity along each axis, m/s: the mean from a time to another one, s."""
        first, last = np.searchsorted(self.rows[:, 0], (start, end), "right")
        times = np.concatenate(([start], self.rows[first:last, 0], [end]))
        return [
            np.trapz(np.interp(times, self.rows[:, 0], v), times) / (end - start) for v in self.rows.T[1:]
        ]

    def state(self):
        return {"given": self._given}

    def restoreState(self, state):
        self._given = state.get("given")

    def bind(self, scene):
        super().bind(scene)
        if not self.dead:
            self._moved(scene.drives)

    def _moved(self, motions):
        """What it moves. ValueError where that is gone, or has a velocity that is not of the table."""
        out = f"take the engine '{self.label}' out of scene.engines"
        if self.motion not in motions:
            raise ValueError(
                f"MotionTable: '{self.motion}' is no drive or hold of the scene any more; {out}, too"
            )
        motion = motions[self.motion]
        if self._given is not None and list(motion.velocity) != self._given:
            raise ValueError(
                f"MotionTable: '{self.motion}' was given {motion.velocity} m/s, and moves by a table; {out} "
                "and give the velocity then"
            )
        return motion

    def take(self, motion):
        """Begins with the velocity that a motion has."""
        self._given = list(motion.velocity)

    def act(self, scene):
        motion = self._moved(scene.drives)
        means = self.mean(scene.time, scene.time + scene.stepper.dt)
        motion.velocity = withFreeAxes([means])[0]
        self.take(motion)


def withFreeAxes(rows):
    """Rows as they are given: None where a number is nan."""
    return [[None if np.isnan(v) else float(v) for v in row] for row in rows]


def isTable(velocity):
    """Whether a velocity is given as rows."""
    return isinstance(velocity, (list, tuple, np.ndarray)) and any(np.ndim(row) for row in velocity)


def velocityRows(who, velocity, times, dim):
    """Rows (time, velocity along each axis) of a table, or of a function at some times; nan on free axes."""
    rows = [(t, *velocity(t)) for t in floats(times)] if callable(velocity) else velocity
    if not len(rows) or any(np.shape(np.array(row, object)) != (1 + dim,) for row in rows):
        return timeRows(who, "velocity", rows, dim, None)  # which says what is wrong
    isFree = np.array([[v is None for v in row] for row in rows]).all(axis=0)
    rows = timeRows(
        who,
        "velocity",
        np.where(isFree, 0.0, [[np.nan if v is None else v for v in row] for row in rows]),
        dim,
        None,
    )
    rows[:, isFree] = np.nan
    return rows


def _velocity(who, velocity):
    given = list(velocity) if isinstance(velocity, (list, tuple, np.ndarray)) else []
    numbers = [v for v in given if v is not None]
    if len(given) not in (2, 3) or not all(isNumber(v) and np.isfinite(v) for v in numbers):
        raise ValueError(
            f"{who}: velocity = {shown(velocity)} is not allowed; give one number (m/s) or None per axis"
        )
    return [np.nan if v is None else float(v) for v in given]
