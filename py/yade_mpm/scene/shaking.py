# SPDX-License-Identifier: GPL-2.0-or-later
"""Sides of the grid behind which the ground goes on: earthquakes come in and waves go out, or both sides move
as one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..base.warn import warnUser
from ..base.wording import shown
from ..engine.engines import classes
from ..engine.prescribed import FACES
from ..engine.supports import timeRows
from ..material.materials import Material
from .nodes import requireSides
from .running import refuseDuringStep
from .wetting import waterOf


def tie(scene, *sides: str):
    """Ties two sides of the grid that face each other: they move as one.

        scene.tie("left", "right")

    For ground that is shaken, with the same profile at both sides. It goes on behind each side as at the
    other one, so a level layer has no end, and waves that leave at one side come back at the other. Sides
    may move along their normal by half a cell; what is fixed or on rollers is given up for it.

    Parameters
    ----------
    sides : "left" and "right"; in 3D also "front" and "back".

    Returns the `UniformAlong`. Raises ValueError for sides that do not face each other, or have cells of
    different size, or are viscous or tied; or where the ground has water.
    """
    refuseDuringStep(scene, "tie")
    requireSides(scene, "tie", sides)
    faces = FACES[scene.dim]
    pairs = {tuple(s for s in faces if faces[s][0] == axis): axis for axis in range(scene.dim - 1)}
    axis = next((pairs[pair] for pair in pairs if set(sides) == set(pair) and len(sides) == 2), None)
    allowed = " or ".join(" and ".join(f"'{side}'" for side in pair) for pair in pairs)
    if axis is None or scene.isAxisymmetric:
        raise ValueError(
            f"tie: sides = {shown(sides)} is not allowed; give {allowed}, in a scene without axial symmetry"
        )
    refuseTaken(scene, "tie", sides)
    if waterOf(scene):
        raise ValueError(
            "tie: the ground has pore water, whose flow tied sides do not pass on; leave out one of the two"
        )
    ends = np.tile(0.5 * (scene.lower + scene.upper), (2, 1))
    ends[:, axis] = scene.lower[axis], scene.upper[axis]
    sizes = scene.cellSizeAt(ends)[:, axis]
    if not np.isclose(*sizes):
        raise ValueError(
            f"tie: cells at the sides are {sizes[0]:g} and {sizes[1]:g} m wide; give a grid with equal ones"
        )
    solver = freed(scene, "tie", sides)
    cells = len(scene.lines[axis]) - 1
    lower = min(sides, key=lambda side: faces[side][1])
    engine = classes["UniformAlong"](axis="xyz"[axis], period=cells, label=f"tied {lower}")
    scene.engines.insert(scene.engines.index(solver), engine)
    scene.stepper.noteChange()
    return engine


def refuseTaken(scene, call, sides):
    """Refuses sides that are tied, or viscous, already."""
    lower = {"right": "left", "back": "front"}
    labels = [f"viscous {side}" for side in sides] + [f"tied {lower.get(side, side)}" for side in sides]
    if taken := [engine.label for engine in scene.engines if engine.label in labels]:
        raise ValueError(f"{call}: there is '{taken[0]}' already; leave one of the two out")


def freed(scene, call, sides):
    """The solver of the grid, with nothing that is fixed or on rollers at some sides."""
    solver = scene._gridSolver(call)
    for side in sides:
        for held in (solver.fixed, solver.roller):
            if side in held:
                held.remove(side)
    return solver


def viscous(
    scene,
    *sides: str,
    motion: ArrayLike | Callable | None = None,
    times: ArrayLike | None = None,
    behind: Material | None = None,
):
    """Lets waves leave through sides of the grid, and an earthquake come in through them.

        scene.viscous("bottom", motion=mpm.geotech.readRecord("quake.csv"), behind=rock)
        scene.viscous("left", "right")

    Dashpots take the place of the ground behind (Lysmer & Kuhlemeyer 1969). The force on a side when the run
    goes on stays on it, so call this once gravity is at rest, on sides that are free; what is fixed or
    on rollers is given up for it.

    Parameters
    ----------
    sides : names, as of `fix`.
    motion : velocity of the ground at an outcrop of the rock, m/s: a record (along x), rows (time, one
        component per axis) or (time, along x), or a function of the time that gives either, at `times`. Half
        of it comes in as a wave. Times are those of the scene, which `settle` moves on.
    times : s, for a function.
    behind : Material of the ground there; default: that of the body at the side.

    Returns the `ViscousBoundary`, or a tuple. Raises ValueError for another side, or where the ground at a
    side is of several materials and `behind` is left out.
    """
    refuseDuringStep(scene, "viscous")
    requireSides(scene, "viscous", sides)
    there = {engine.label for engine in scene.engines}
    for lower, upper in (("left", "right"), ("front", "back")):
        if f"tied {lower}" in there and {lower, upper} & set(sides):
            raise ValueError(f"viscous: the sides '{lower}' and '{upper}' are tied; leave one of the two out")
    if twice := [side for side in sides if f"viscous {side}" in there or sides.count(side) > 1]:
        raise ValueError(f"viscous: the side '{twice[0]}' is viscous already; give each side once")
    made = [_made(scene, side, motion, times, behind) for side in sides]
    solver = freed(scene, "viscous", sides)
    for engine in made:
        scene.engines.insert(scene.engines.index(solver), engine)
    scene.stepper.noteChange()
    return made[0] if len(made) == 1 else tuple(made)


def _made(scene, side, motion, times, behind):
    near = _bodiesAt(scene, side)
    soil = _stiffness(near)
    if len({body.material.density for body in near}) != 1 or any(body.inertiaScale != 1 for body in near):
        raise ValueError(
            f"viscous: the bodies at the side '{side}' ({', '.join(body.name for body in near) or 'none'}) "
            "differ in density or have an inertiaScale; give the side one soil"
        )
    rock = soil if behind is None else behind
    if rock is None:
        raise ValueError(
            f"viscous: the ground at the side '{side}' is of several materials, or of one without a "
            "stiffness of its own; give behind=, the material of the ground behind it"
        )
    first, second = moduliBehind(
        "viscous",
        rock,
        f"behind = {type(rock).__name__} has no stiffness of its own, or one that varies; give "
        "a material with numbers, e.g. mpm.LinearElastic(...)",
    )
    axis, isUpper = FACES[scene.dim][side]
    if behind is None and (water := waterOf(scene)) and any(body._core.hasPores for body in near):
        first += water.bulkModulus / water.porosity  # waves of pressure run through the water
    engine = classes["ViscousBoundary"](
        face=2 * axis + isUpper,
        density=near[0].material.density,
        normal=float(np.sqrt(first * rock.density)),
        shear=float(np.sqrt(second * rock.density)),
        label=f"viscous {side}",
    )
    if motion is not None:
        rows = _rows(motion, times, scene.dim)
        _warnOfStart(scene, rows)
        engine.motion = (rows * [1.0, *[0.5] * scene.dim]).ravel().tolist()
    return engine


def moduliBehind(call, material, missing):
    """Moduli of waves of pressure and of shear, kPa. missing : what to say where they are no numbers."""
    if not isinstance(material, Material):
        raise TypeError(f"{call}: behind = {shown(material)}; give a material, e.g. mpm.LinearElastic(...)")
    if not getattr(material, "lame", None) or material.attributes().get("pressureExponent"):
        raise ValueError(f"{call}: {missing}")
    first, second = material.lame
    return first + 2 * second, second


def _warnOfStart(scene, rows):
    """Warns of a motion that has begun before the time of the scene, such as that of its rest."""
    if len(rows) > 1 and rows[rows[:, 0] < scene.time, 1:].any():
        warnUser(
            f"viscous: the motion begins at {rows[0, 0]:g} s, but the scene is at {scene.time:g} s already: "
            "what comes before is lost; add scene.time to its times (of a record: quake.time += scene.time)"
        )


def _rows(motion, times, dim):
    if hasattr(motion, "acceleration"):  # of geotech.readRecord
        motion = np.column_stack((motion.time, motion.velocity))
    if callable(motion) and times is not None and len(times) and np.ndim(motion(times[0])) == 0:
        motion = np.column_stack((times, [motion(t) for t in times]))
    along = not callable(motion) and np.ndim(motion) == 2 and np.shape(motion)[1] == 2 and dim > 1
    rows = timeRows("viscous", "motion", motion, 1 if along else dim, times)
    return np.column_stack((rows, np.zeros((len(rows), dim - 1)))) if along else rows


def _bodiesAt(scene, side):
    """Bodies that reach within half a cell of a side."""
    axis, isUpper = FACES[scene.dim][side]
    face = (scene.upper if isUpper else scene.lower)[axis]
    reach = 0.5 * scene.cell[axis]
    return [b for b in scene.bodies if b.count and (np.abs(b.corners()[..., axis] - face) < reach).any()]


def _stiffness(bodies):
    """The elastic material of some bodies, None where they are of several."""
    materials = [body.material for body in bodies]
    isOne = materials and all(m == materials[0] for m in materials)
    return materials[0] if isOne and getattr(materials[0], "lame", None) else None
