# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene is made of, in words with the reason of each choice, or as the script that names
everything."""

import re

from .. import _core
from ..engine.contact import Contact
from ..engine.gridSolver import GridSolver
from ..engine.prescribed import Drive, MotionTable
from ..engine.rigidContact import RigidContact
from ..io.history import History
from ..io.recorder import Recorder
from ..particle.body import Body
from .hasClock import PARTICLES_PER_THREAD

_SHAPES = re.compile(r"\b(box|disc|polygon|sphere|halfSpace|everywhere)\(")


class Printed(str):
    """Text that has been printed: it shows as nothing, so that `print` and a prompt do not repeat it."""

    __slots__ = ()

    def __str__(self):
        return ""

    __repr__ = __str__


def describe(scene, long: bool = False) -> Printed:
    """Prints what the scene is made of, and why: grid, walls, bodies, contact, motions, step, engines.

    Parameters
    ----------
    long : print the script that does the same with every option and engine named; default False.

    Returns the text, to be searched or written to a file.

    Estimates the critical time step where none is known yet, and raises what that raises.
    """
    text = longForm(scene) if long else "\n".join(summary(scene))
    print(text)
    return Printed(text)


def summary(scene):
    """Lines about a scene: see `describe`."""
    if scene.dt is None and scene.particleCount:
        scene._checkTimeStep()
    solver = scene._gridSolver("describe")
    yield f"Grid      {_grid(scene)}"
    yield f"Solver    gravity {_vector(scene.gravity)} m/s2, local damping {solver.damping:g}"
    yield f"Sides     {_sides(scene, solver)}"
    for body in (b for b in scene.bodies if b.count):
        yield from _bodyLines(body)
    yield from _contactLines(scene)
    tables = {engine.motion: engine for engine in scene.engines if isinstance(engine, MotionTable)}
    for motion in (*solver.holds, *solver.drives):
        yield f"Motion    {_motion(motion, tables.get(motion.name))}"
    yield f"Step      {_step(scene)}"
    yield f"Threads   {_threads(scene)}"
    yield f"Engines   {', '.join(type(e).__name__ for e in scene.engines)}"


def _threads(scene):
    if scene._threads:
        return f"{scene.threads}, as given"
    return f"{scene.threads} of {_core.availableThreads()}, one for every {PARTICLES_PER_THREAD} particles"


def _grid(scene):
    size = " x ".join(f"{n:g}" for n in scene.upper - scene.lower)
    cells = " x ".join(str(len(x) - 1) for x in scene.lines)
    edge = " x ".join(f"{n:g}" for n in (scene.cell[:1] if len(set(scene.cell)) == 1 else scene.cell))
    of = f"graded, smallest {edge} m" if scene.isGraded else f"{edge} m"
    return f"{size} m, {cells} cells of {of}{_thickness(scene)}"


def _thickness(scene):
    if scene.isAxisymmetric:
        return ", axisymmetric: x is the distance from the axis, forces are of the whole circumference"
    return ", per metre of thickness" if scene.dim == 2 else ""


def _sides(scene, solver):
    told = [f"{', '.join(solver.fixed)} fixed"] if solver.fixed else []
    told += [f"{', '.join(solver.roller)} on rollers"] if solver.roller else []
    labels = [engine.label for engine in scene.engines]
    if viscous := [label.split()[1] for label in labels if label.startswith("viscous ")]:
        told.append(f"{', '.join(viscous)} viscous")
    across = {"left": "left, right", "front": "front, back"}
    if tied := [across[label.split()[1]] for label in labels if label.startswith("tied ")]:
        told.append(f"{', '.join(tied)} tied")
    return "; ".join([*told, "the others are free" if told else "all are free"])


def _bodyLines(body):
    yield f"Body      '{body.name}': {body.count} particles of {type(body.material).__name__}"
    yield f"          {_short(body.type)}{_because(body, 'particles')}"
    yield f"          F-bar {'on' if body.fbar else 'off'}{_because(body, 'fbar')}"
    yield f"          {'implicit' if body.implicit else 'explicit'}{_because(body, 'implicit')}"
    if body.scene._contactPairs or body.group != "main":
        yield f"          group '{body.group}'{_because(body, 'group')}"


def _because(body, what):
    return f": {body._chosen[what]}" if what in body._chosen else ", as given"


def _contactLines(scene):
    for engine in (e for e in scene.engines if isinstance(e, RigidContact)):
        frictions = ", ".join(f"{f:g}" for f in sorted(set(engine.friction)))
        yield f"Contact   {len(engine.friction)} rigid and all other bodies: friction {frictions}"
    for engine in (e for e in scene.engines if isinstance(e, Contact)):
        named = engine._laws()
        for (a, b), (friction, adhesion) in named.items():
            yield f"Contact   '{a}' and '{b}': friction {friction:g}, adhesion {adhesion:g} kPa"
        yield (
            f"          impactLoss {engine.impactLoss:g}, constraints {engine.constraints!r}; other groups "
            f"that meet: friction {engine.friction:g}, adhesion {engine.adhesion:g} kPa"
        )


def _motion(motion, table):
    what = motion.part if isinstance(motion, Drive) else motion.where
    if table is not None:
        return f"'{motion.name}': {what} by a table of {len(table.rows)} rows"
    ramp = f", from zero in {motion.ramp:g} s" if motion.ramp else ""
    return f"'{motion.name}': {what} with {_vector(motion.velocity)} m/s{ramp}"


def _vector(values):
    return f"({', '.join('free' if v is None else f'{v:g}' for v in values)})"


def _step(scene):
    if scene._dt is not None:
        return f"{scene._dt:g} s, as given"
    if scene.dt is None:
        return "automatic"
    return (
        f"{scene.dt:.3g} s, automatic: '{scene.stiffest}' allows {scene.dtStable:.3g} s; it follows the run"
    )


# --- the long form ------------------------------------------------------------------------------------
def longForm(scene):
    """The script that makes the scene as it is, before its first step, with every choice written out."""
    graded = (
        f"grading={[x.tolist() for x in scene.lines]}" if scene.isGraded else f"cell={_plain(scene.cell)}"
    )
    corners = f"{tuple(scene.lower.tolist())}, {tuple(scene.upper.tolist())}"
    round_ = ", axisymmetric=True" if scene.isAxisymmetric else ""
    lines = ["import yade_mpm as mpm", "", f"scene = mpm.Scene({corners}, {graded}{round_})"]
    bodies = {body.name: f"scene[{body.name!r}]" for body in scene.bodies}
    for body in (b for b in scene.bodies if b.count):
        lines.append("scene.add(\n    " + ",\n    ".join(_bodyArguments(body)) + ",\n)")
    for engine in (e for e in scene.engines if isinstance(e, Contact)):
        lines.append(f"contact = {_short(engine)}")
        for (a, b), (friction, adhesion) in engine._laws().items():
            lines.append(f"contact.pair({a!r}, {b!r}, friction={friction}, adhesion={adhesion})")
    lines.append("scene.engines = [")
    lines += [f"    {_engine(engine, bodies)}," for engine in scene.engines if not _isInserted(scene, engine)]
    lines.append("]")
    if scene._dt is not None:
        lines.append(f"scene.dt = {scene._dt}")
    return "\n".join(lines)


def _isInserted(scene, engine):
    return any(engine is one for one in scene._added.values())


def _bodyArguments(body):
    region = _SHAPES.sub(r"mpm.\1(", repr(body.region)) if body.region is not None else "MESH"
    options = {"inertiaScale": 1.0, "fbar": None, "group": "main", "implicit": False}
    given = {name: getattr(body, name) for name, default in options.items() if getattr(body, name) != default}
    rest = [f"{name}={value!r}" for name, value in given.items()]
    return [repr(body.name), region, _short(body.material), _short(body.type), *rest]


def _engine(engine, bodies):
    if isinstance(engine, Contact):
        return "contact"
    if isinstance(engine, (History, Recorder)):
        return f"mpm.{engine!r}"
    if isinstance(engine, MotionTable):
        return f"mpm.engine.MotionTable({engine.motion!r}, {engine.spec()['table']})"
    if not isinstance(engine, GridSolver):
        return _short(engine)
    parts = [f"{name}={value!r}" for name, value in _unlikeDefault(engine).items()]
    parts += [
        f"{name}={tuple(getattr(engine, name))}" for name in ("roller", "fixed") if getattr(engine, name)
    ]
    for name, motions in (("hold", engine.holds), ("drive", engine.drives)):
        if motions:
            parts.append(f"{name}=[{', '.join(_motionCode(m, bodies) for m in motions)}]")
    return f"mpm.GridSolver({', '.join(parts)})"


def _motionCode(motion, bodies):
    if isinstance(motion, Drive):
        what = f"{bodies[motion.part.body.name]}{motion.part._call()}"
    else:
        what = _SHAPES.sub(r"mpm.\1(", repr(motion.where))
    ramp = f", ramp={motion.ramp}" if motion.ramp else ""
    how = ", byHeight=True" if isinstance(motion, Drive) and motion.byHeight else ""
    return f"mpm.{type(motion).__name__}({what}, {motion.velocity}{ramp}, name={motion.name!r}{how})"


def _short(thing):
    """As it would be written in a script: what is not the default."""
    parts = [f"{name}={value!r}" for name, value in _unlikeDefault(thing).items()]
    matched = getattr(thing, "matched", None)
    parts += [f"size={_plain(thing.size)}"] if getattr(thing, "size", None) is not None else []
    parts += [f"matched=scene[{matched.name!r}]"] if isinstance(matched, Body) else []
    return f"mpm.{type(thing).__name__}({', '.join(parts)})"


def _unlikeDefault(thing):
    defaults = {p["name"]: p["default"] for p in type(thing)._make(thing._coreName).parameters()}
    values = thing.attributes()
    # Elastic constants have two forms, and pairs of groups a call of their own.
    left = {"lame" if "young" in values else "", "pairs" if isinstance(thing, Contact) else ""}
    return {name: v for name, v in values.items() if name not in left and v != defaults.get(name)}


def _plain(values):
    """A number where all axes have the same one, else a tuple."""
    numbers = [float(v) for v in values] if hasattr(values, "__len__") else [float(values)]
    return numbers[0] if len(set(numbers)) == 1 else tuple(numbers)
