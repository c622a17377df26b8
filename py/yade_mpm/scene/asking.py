# SPDX-License-Identifier: GPL-2.0-or-later
"""What users ask of a scene in the words of their problem: gravity, walls, motions, output.

Each call edits the engines that `scene.engines` shows.
"""

import os
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..base.kinds import FLAG, NOT_NEGATIVE, NUMBERS, POSITIVE, TEXT, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..diagnostics.certificate import Certificate
from ..diagnostics.certificate import quasiStatic as certificateOf
from ..diagnostics.drainage import drainage
from ..engine.boundaryLoad import BoundaryLoad
from ..engine.callback import PyRunner
from ..engine.prescribed import Drive, Hold, MotionTable, Steering, isTable, velocityRows, withFreeAxes
from ..geometry.numbers import isNumber
from ..geometry.region import Region
from ..io.history import History
from ..io.recorder import Recorder
from ..particle.body import Body
from ..particle.part import BodyPart
from .nodes import requireSides
from .running import refuseDuringStep

SUMMED = ("dampedEnergy", "energyError", "implicitEnergy", "workDone")  # columns that count since the start
ROWS = 400  # of the history that a run with a drive keeps where none was asked for


def gravityVector(scene, gravity):
    """Gravity as one component per axis: a number points down, along the last axis."""
    if isNumber(gravity) and 0 <= gravity < np.inf:
        return [*[0.0] * (scene.dim - 1), -float(gravity) if gravity else 0.0]
    isVector = isinstance(gravity, (tuple, list, np.ndarray)) and len(gravity) == scene.dim
    if isVector and all(isNumber(g) and np.isfinite(g) for g in gravity):
        return [float(g) for g in gravity]
    raise ValueError(
        f"Scene: gravity = {shown(gravity)} is not allowed; give a positive number (m/s2, downwards), or "
        f"{scene.dim} components"
    )


def fix(scene, *sides: str) -> None:
    """Holds sides of the grid: what is there does not move. Soil shears along them with its own friction, tan
    delta = sin phi without dilatancy; for a friction of their own make them a body with a contact.

    Parameters
    ----------
    sides : names, "left", "right", "bottom", "top"; in 3D also "front", "back".
    """
    _addSides(scene, "fix", sides)


def roller(scene, *sides: str) -> None:
    """Puts rollers on sides of the grid: what is there slides along them.

    Parameters
    ----------
    sides : names, "left", "right", "bottom", "top"; in 3D also "front", "back".
    """
    _addSides(scene, "roller", sides)


def _addSides(scene, call, sides):
    refuseDuringStep(scene, call)
    solver = scene._gridSolver(call)
    mine, other = (solver.fixed, solver.roller) if call == "fix" else (solver.roller, solver.fixed)
    requireSides(scene, call, sides)
    for side in sides:
        pair = {"right": "left", "back": "front"}.get(side, side)  # tied sides are named by the lower one
        for kind, label in (("viscous", f"viscous {side}"), ("tied", f"tied {pair}")):
            if any(engine.label == label for engine in scene.engines):
                raise ValueError(f"{call}: the side {shown(side)} is {kind}; leave one of the two out")
        if side in other:
            has = "rollers" if call == "fix" else "fixed"
            raise ValueError(
                f"{call}: the side {shown(side)} is {has} already; give it to one of fix and roller"
            )
    mine += [side for side in dict.fromkeys(sides) if side not in mine]
    scene._asked.add(solver)
    scene.stepper.noteChange()


@takes(ramp=NOT_NEGATIVE, name=TEXT, byHeight=FLAG, times=NUMBERS)
def drive(
    scene,
    what: Body | BodyPart | Region | str,
    velocity: Sequence | Callable,
    ramp: float = 0.0,
    name: str | None = None,
    byHeight: bool = False,
    times: Sequence[float] | None = None,
) -> Drive | Hold:
    """Moves a body, a part of one, or nodes with a prescribed velocity, and measures the force that takes.

        press = scene.drive(pile.above(12), velocity=(0, -0.1))
        scene.run(until=10)
        print(press.reaction)  # kN (2D: kN/m), on the pile

    A `history` has the reaction over time: `history["pile.fy"]` over `history["time"]`.

    Parameters
    ----------
    what : Body, or a part of one, as of `body.above(12)`, `body.inside(region)`: a `Drive`. Or a region, or
        the name of a side of the grid: a `Hold` of the nodes there, which stay where they are.
    velocity : m/s, one component per axis; None leaves a direction free, zeros hold it. Or a table, rows of
        the scene's time (s) and these, linear between them, the first and last one outside: the path is its
        integral, and a checkpoint keeps it. Or a function of the time that returns them: each step ends with
        the value at its end. After `mpm.load` give it again,
        `callbacks={"NAME.velocity": mpm.engine.Steering("NAME", function)}`.
    ramp : s, time over which the velocity grows from zero; default 0.
    name : of its columns in a history; default the name of the body or of the side, "hold" for a region.

    byHeight : bool. False: the part keeps the particles that are in it at this call, wherever they go. True:
        the part is found again in each step, and particles that sink below 12 move freely; default False.
    times : s, of the rows of a table that is made of a function; default None: no table.

    Returns the `Drive` or `Hold`, which `scene.drives` has by its name, also after `mpm.load`. `Drive` tells
    which nodes move.

    Raises TypeError and ValueError for anything else.
    """
    refuseDuringStep(scene, "drive")
    solver = scene._gridSolver("drive")
    if not isinstance(what, (Body, BodyPart, str, Region)):
        raise TypeError(
            f"drive: what = {shown(what)}; give a body, a part of one, e.g. pile.above(12), a region, or a "
            "side"
        )
    if isinstance(what, str):
        isBody = any(what == body.name for body in scene.bodies)
        requireSides(scene, "drive", [what], f"; give scene[{what!r}] for the body" if isBody else "")
    rows = _velocityRows(scene, velocity, times, ramp)
    function = velocity if callable(velocity) and rows is None else None
    velocity = velocity if function is None else function(scene.time)
    if rows is not None:  # of the start
        velocity = withFreeAxes([[np.interp(scene.time, rows[:, 0], v) for v in rows.T[1:]]])[0]
    if not (isinstance(velocity, (tuple, list, np.ndarray)) and len(velocity) == scene.dim):
        raise ValueError(
            f"drive: velocity = {shown(velocity)} is not allowed; give {scene.dim} components, m/s (None "
            "leaves one free)"
        )
    if all(v is None for v in velocity):
        raise ValueError(f"drive: velocity = {shown(velocity)} leaves all axes free; give one a number, m/s")
    if isinstance(what, (str, Region)):
        motion = Hold(what, velocity, ramp, name)
        solver.holds.append(motion)
    else:
        body = what if isinstance(what, Body) else what.body
        if body.scene is not scene:
            raise ValueError(f"drive: '{body.name}' is in another scene; give a body of this one")
        taken = [m.name for m in (*solver.holds, *solver.drives)]
        part = what.all() if isinstance(what, Body) else what
        part, name = part if byHeight else part.now(), name or freeName(body.name, taken)
        motion = Drive(part, velocity, ramp, name, byHeight)
        solver.drives.append(motion)
    if function is not None:
        steering = PyRunner(Steering(motion.name, function), iterPeriod=1, label=f"{motion.name}.velocity")
        scene.engines.insert(0, steering)
    if rows is not None:
        table = MotionTable(motion.name, withFreeAxes(rows), label=f"{motion.name}.velocity")
        table.take(motion)
        if len(rows) > 1 and rows[-1, 0] <= scene.time:
            warnUser(
                f"drive: the table of '{motion.name}' ends at {rows[-1, 0]:g} s, and the scene's time is "
                f"{scene.time:.4g} s: its last row holds; give times from scene.time on"
            )
        scene.engines.insert(0, table)
    scene._asked.add(solver)
    scene.stepper.noteChange()
    return motion


class Drives(dict):
    """The prescribed motions of a scene by name; `del` takes one away, and what steers it."""

    def __init__(self, scene):
        solver = scene._gridSolver("drives")
        super().__init__((motion.name, motion) for motion in (*solver.holds, *solver.drives))
        self._scene, self._lists = scene, (solver.holds, solver.drives)

    def __delitem__(self, name):
        refuseDuringStep(self._scene, "drives")
        if name not in self:
            raise KeyError(
                f"drives: {shown(name)} is none; there are {', '.join(map(shown, self)) or 'none'}"
            )
        for motions in self._lists:
            motions[:] = [motion for motion in motions if motion is not self[name]]
        for engine in [e for e in self._scene.engines if e.label == f"{name}.velocity"]:
            self._scene.engines.remove(engine)
        super().__delitem__(name)
        self._scene.stepper.noteChange()

    def _refuse(self, *args, **kwargs):
        raise TypeError(
            "drives: scene.drive(...) makes a motion, `del scene.drives['press']` takes one away, and its "
            "attributes change it"
        )

    __setitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse


def _velocityRows(scene, velocity, times, ramp):
    """The table of a motion; None: its velocity is none."""
    if times is not None and not callable(velocity):
        raise ValueError("drive: times are given, and velocity is no function; leave times out")
    if not isTable(velocity) and times is None:
        return None
    if ramp:
        raise ValueError(
            f"drive: ramp = {ramp:g} beside a table of the velocity; let the table grow from zero"
        )
    return velocityRows("drive", velocity, times, scene.dim)


def load(scene, body: Body, where: Region, **options) -> BoundaryLoad:
    """Loads the surface of a meshed body: pressure that follows it, or traction of a fixed direction.

        scene.load(ground, mpm.box((4, 4.9), (6, 5.1)), pressure=50, ramp=0.1)

    Parameters
    ----------
    body : Body of APDI domains; for boxes see `SurfaceLoad`.
    where : Region with the middles of the facets that are loaded.
    options : as of `BoundaryLoad`: pressure (kPa), traction (kPa, one component per axis), ramp (s) ...

    Returns the `BoundaryLoad`.
    """
    refuseDuringStep(scene, "load")
    engine = BoundaryLoad(body, where, **options)
    scene.engines.insert(scene.engines.index(scene._gridSolver("load")), engine)
    scene.stepper.noteChange()
    return engine


def freeName(name, taken):
    """A name that is not taken: with a number where it is."""
    names = [name, *(f"{name} {k}" for k in range(2, len(taken) + 2))]
    return next(n for n in names if n not in taken)


def record(
    scene,
    file: str | os.PathLike,
    every: float,
    fields: Sequence[str] | None = None,
    bodies: Sequence | None = None,
) -> Recorder:
    """Writes the particles into a file for ParaView and `mpm.read`, at the start and every so often.

    Parameters
    ----------
    file : name of the file, ending in .vtkhdf.
    every : s, scene time between frames.
    fields, bodies : as of `Recorder`; default: those that one usually wants, all bodies.

    Returns the `Recorder`.
    """
    refuseDuringStep(scene, "record")
    POSITIVE.check("record", "s", every=every)
    return _append(scene, Recorder(file, period=every, fields=fields, bodies=bodies))


def history(
    scene, every: float, file: str | os.PathLike | None = None, columns: dict | None = None
) -> History:
    """Keeps forces, energies and checks over time; `scene.history(0.1)["time"]` is a NumPy array.

    What is driven or held has columns of its name, the reaction on it: `history["pile.fy"]`. Its `names` are
    those of all columns.

    Parameters
    ----------
    every : s, scene time between rows.
    file : name of a CSV file; default: none.
    columns : dict name -> function of the scene, or text; more columns, as of `History`.

    Returns the `History`.
    """
    refuseDuringStep(scene, "history")
    POSITIVE.check("history", "s", every=every)
    return _append(scene, History(period=every, file=file, columns=columns))


def _append(scene, engine):
    scene.engines.append(engine)
    scene.stepper.noteChange()
    return engine


def watch(scene, until, steps):
    """Gives a run with a prescribed motion a history, if calls of the scene made it and it has none."""
    if not scene._asked or any(isinstance(engine, History) for engine in scene.engines):
        return
    solver = scene._gridSolver("run")
    if solver.drives or solver.holds:
        isByTime = until is not None
        rows = {"period": (until - scene.time) / ROWS} if isByTime else {"iterPeriod": max(1, steps // ROWS)}
        _append(scene, History(**rows))


def quasiStatic(
    scene, after: float | None = None, rateSensitivity: float | None = None, limits: dict | None = None
) -> Certificate:
    """Tells whether the run was slow enough to be called quasi-static: `mpm.quasiStatic` of its history.

    A run with a drive keeps a history by itself; for others call `scene.history` before the run. Arguments
    are those of `mpm.quasiStatic`. Behind `settle` all counts from its end: its damping is meant. Whether
    soil has failed is another question, of `mpm.safety` and `mpm.limitLoad`. With pore water a line says
    whether the rate was drained or undrained.
    """
    found = next((engine for engine in scene.engines if isinstance(engine, History)), None)
    if found is None:
        raise ValueError(
            "quasiStatic: the scene keeps no history; call scene.history(every=...) before the run"
        )
    certificate = certificateOf(_sinceRest(scene, found), after, rateSensitivity, limits)
    water = drainage(scene)
    return certificate if water is None else replace(certificate, drainage=water[1])


def _sinceRest(scene, history):
    """Rows of a history since `settle`, with energies that count from there; all of them without it."""
    began = 0 if scene._restedAt is None or not len(history) else history["time"] >= scene._restedAt
    if np.sum(began) < 2:
        return history
    rows = {name: column[began] for name, column in dict(history).items()}
    return {name: c - c[0] if name in SUMMED else c for name, c in rows.items()}
