# SPDX-License-Identifier: GPL-2.0-or-later
"""Free fields: level ground goes on behind a side and is shaken alike. A column of it is run beforehand; its
motion and stress act on the side."""

from __future__ import annotations

import os
import tempfile

import numpy as np

from ..base.wording import shown
from ..engine.callback import PyRunner
from ..engine.engines import classes
from ..engine.prescribed import FACES
from ..geometry.numbers import isNumber
from ..io import checkpoint
from ..material.materials import Material
from ..particle.types import Boxes, MeshedType
from .convertingToMesh import dropBoxes
from .nodes import requireSides
from .permissions import Permissions
from .removing import dropDomains
from .restoringBodies import buildBodies
from .restoringEngines import buildEngine
from .running import refuseDuringStep
from .saving import describe
from .shaking import freed, moduliBehind, refuseTaken
from .wetting import waterOf

BASE = "viscous bottom"
STEP = ("ParticleToGrid", "GridSolver", "GridToParticle", "DomainUpdater", "VelocityRemap", "SurfaceLoad")
OFTEN = 1.0  # time between rows of the table, over that of a wave of pressure through a cell, -


def freeField(scene, *sides: str, until: float | None = None, behind: Material | None = None):
    """Lets level ground go on behind sides, shaken as the ground is: waves leave through the sides.

        scene.viscous("bottom", motion=quake, behind=rock)
        scene.freeField("left", "right")

    For a slope, a pit or a wall that is shaken. At each side a column of the ground there moves alone; its
    motion and stress act on the side, with dashpots for what differs (Wolf 1988; Zienkiewicz et al. 1989).
    Call it once gravity is at rest, after `viscous`; what is fixed or on rollers is given up for it.

    Parameters
    ----------
    sides : "left", "right" or both, in plane strain.
    until : s, the last time that the scene may run to; default: the end of the motion.
    behind : Material whose stiffness is that of the dashpots; default: that of each body at the side.

    Returns the `ViscousBoundary`, or a tuple. Raises ValueError where no motion comes in through the bottom,
    where there is water or no ground at a side, and for scenes in space or with axial symmetry.
    """
    refuseDuringStep(scene, "freeField")
    if scene.dim != 2 or scene.isAxisymmetric:
        raise ValueError(
            "freeField: the scene is not in plane strain; give scene.tie('left', 'right') or scene.viscous"
        )
    requireSides(scene, "freeField", sides)
    if not set(sides) <= {"left", "right"} or len(set(sides)) < len(sides):
        raise ValueError(f"freeField: sides = {shown(sides)} is not allowed; give 'left', 'right' or both")
    refuseTaken(scene, "freeField", sides)
    base = next((e for e in scene.engines if e.label == BASE), None)
    if base is None or not len(base.motion):
        raise ValueError(
            "freeField: no motion comes in through the bottom; call scene.viscous('bottom', motion=...) first"
        )
    if waterOf(scene):
        raise ValueError("freeField: the ground has pore water, which columns do not have; leave one out")
    until = np.reshape(base.motion, (-1, 1 + scene.dim))[-1, 0] if until is None else until
    if not isNumber(until) or not scene.time < until < np.inf:
        raise ValueError(f"freeField: until = {shown(until)}; give a time after {scene.time:g} s")
    made = [_made(scene, side, until, behind) for side in sides]
    solver = freed(scene, "freeField", sides)
    for engine in made:
        scene.engines.insert(scene.engines.index(solver), engine)
    scene.stepper.noteChange()
    return made[0] if len(made) == 1 else tuple(made)


def _made(scene, side, until, behind):
    column = _Column(scene, side, behind)
    none = dict(density=1.0, normal=0.0, shear=0.0)  # dashpots of its own
    engine = classes["ViscousBoundary"](face=FACES[2][side][1], label=f"viscous {side}", **none)
    engine._core.set("dashpots", column.dashpots.ravel().tolist())
    engine._core.set("column", column.run(until).ravel().tolist())
    return engine


class _Column:
    """What is in the cells at a side, all nodes of a row as one.

    dashpots : (rows, 2), kN s/m, of the nodes of the side from below.
    """

    def __init__(self, scene, side, behind):
        self._out = 1.0 if side == "right" else -1.0
        self._scene = _slice(scene, side)
        self._bodies = [b for b in self._scene.bodies if b.count]
        if not self._bodies:
            raise ValueError(f"freeField: there is no ground at the side '{side}'; leave the side out")
        if scaled := [b.name for b in self._bodies if b.inertiaScale != 1]:
            raise ValueError(
                f"freeField: '{scaled[0]}' at the side '{side}' has an inertiaScale; leave it out"
            )
        ends = np.concatenate([b.corners()[..., 1].ravel() for b in self._bodies])
        self._width = sum(b.volume.sum() for b in self._bodies) / np.ptp(ends)
        moduli = [_moduli(b, side, behind) for b in self._bodies]
        impedances = [
            np.sqrt(m * (b.mass / b.volume)[:, None]) * b.volume[:, None]
            for b, m in zip(self._bodies, moduli)
        ]
        self.dashpots = self._onRows(impedances) / self._width
        speed = max(np.sqrt(m[0] / (b.mass / b.volume).min()) for b, m in zip(self._bodies, moduli))
        self._every = OFTEN * np.diff(self._scene.lines[1]).min() / speed

    def run(self, until):
        """Rows (time, velocity and force of each row of nodes)."""
        scene = self._scene
        rows = []

        def note():
            if not rows or scene.time > rows[-1][0]:
                rows.append(np.concatenate(([scene.time], self._state())))

        note()  # forces count from these on, which act on the side already
        scene.engines = [PyRunner(note, period=self._every), *scene.engines]
        scene.run(until=until, progress=False)
        note()
        rows = np.array(rows)
        moving = rows[:, 1:].reshape(len(rows), -1, 4)
        moving[:, :, 2:] -= moving[0, :, 2:].copy()
        return rows

    def _state(self):
        mass = self._onRows([b.mass[:, None] for b in self._bodies])
        momentum = self._onRows([b.mass[:, None] * b.velocity for b in self._bodies])
        stress = self._onRows([b.volume[:, None] * b.stress[:, 0, :2] for b in self._bodies])
        force = self._out / self._width * stress
        return np.hstack((momentum / np.maximum(mass, 1e-300), force)).ravel()

    def _onRows(self, values):
        """Sums of what particles have, linear between the rows of nodes."""
        y = np.concatenate([b.position[:, 1] for b in self._bodies])
        values, lines = np.concatenate(values), self._scene.lines[1]
        row = np.clip(np.searchsorted(lines, y, "right") - 1, 0, len(lines) - 2)
        above = np.clip((y - lines[row]) / (lines[row + 1] - lines[row]), 0, 1)[:, None]
        sums = np.zeros((len(lines), values.shape[1]))
        np.add.at(sums, row, (1 - above) * values)
        np.add.at(sums, row + 1, above * values)
        return sums


def _moduli(body, side, behind):
    """Moduli of waves of pressure and of shear, kPa."""
    return np.array(
        moduliBehind(
            "freeField",
            body.material if behind is None else behind,
            f"'{body.name}' at the side '{side}' has no stiffness of its own, or one that varies; "
            "give behind=, a material with numbers",
        )
    )


def _slice(scene, side):
    """A copy of the scene with the cells at a side alone."""
    spec = describe(scene)
    spec["engines"] = [e for e in spec["engines"] if e["class"] in STEP or e["attributes"]["label"] == BASE]
    for engine in spec["engines"]:
        if engine["class"] == "GridSolver":
            engine.update(
                hold=[], drive=[], roller=[s for s in engine["roller"] if s not in ("left", "right")]
            )
        elif engine["attributes"]["label"] == BASE:
            engine["state"] = {}
    with tempfile.TemporaryDirectory(prefix="freeField") as folder:
        file = os.path.join(folder, "column.h5")
        checkpoint.write(file, spec, scene.bodies)
        spec, arrays = checkpoint.read(file)
    column = type(scene)(
        spec["lower"], spec["upper"], spec["cell"], spec["scheme"], threads=1, grading=spec["lines"]
    )
    buildBodies(column, spec, arrays, file)
    permissions = Permissions(file, False, {}, {})
    column.engines = [buildEngine(e, column, {}, permissions, file) for e in spec["engines"]]
    column.allowUnstable, column.dt = spec["allowUnstable"], spec["dt"]
    column._core.time = spec["time"]
    for body in column.bodies:
        _keepCells(column, body, side)
    engines = column.engines
    solver = next(k for k, e in enumerate(engines) if type(e).__name__ == "GridSolver")
    column.engines = [*engines[:solver], classes["UniformAlong"](axis="x"), *engines[solver:]]
    return column


def _keepCells(column, body, side):
    lines = column.lines[0]
    x = body.position[:, 0]
    away = np.flatnonzero(x > lines[1] if side == "left" else x < lines[-2])
    if not len(away):
        return
    if isinstance(body.type, MeshedType):
        dropDomains(column, body, Boxes(np.zeros((0, 2)), column.cell / 4), away)
    elif len(away) == body.count:
        column.remove(body)
    else:
        dropBoxes(body, away)
        body._core.massesChanged()
    column.stepper.noteChange()
