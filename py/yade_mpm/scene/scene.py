# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene: grid, bodies, engines, clock, and the run."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..base.attributes import Guarded
from ..base.keywords import checked
from ..base.wording import shown
from ..engine.prescribed import Drive, Hold
from ..io.particleFiles import writeParticles
from ..particle.body import Body
from . import asking, axial, display, grounding
from .adding import Bodies, add
from .asked import Asked
from .attaching import attach, detach
from .changes import Changes
from .converting import convert
from .describing import describe
from .freeField import freeField
from .geostatic import initialStress
from .grading import Grading, linesOf
from .grid import cellSize, corner, makeCore
from .groundStress import groundStress
from .groups import contact
from .hasClock import HasClock
from .hasEngines import HasEngines
from .holder import Holder
from .nodes import GHOSTS, cellSizeAt, faceNodes, nodePositions, nodesInside
from .removing import remove
from .reporting import report
from .running import (
    close,
    handOver,
    pause,
    refuseBetweenStages,
    refuseDuringStep,
    refuseMidStep,
    refuseWhileRunning,
    run,
    step,
    wait,
)
from .saving import save
from .settling import settle, unbalancedForce
from .shaking import tie, viscous
from .stages import stage
from .stepper import Stepper


class Scene(HasEngines, HasClock, Guarded):
    """A grid, the bodies on it, the engines of a step, and a clock: everything a run works on.

        scene = mpm.Scene(lower=(0, 0), upper=(4, 2), cell=0.25, gravity=9.81)
        scene.add("block", mpm.box((0, 0), (1, 1)), material)
        scene.fix("bottom")
        scene.run(until=1.0)

    `fix`, `roller`, `contact`, `drive`, `record` and `history` say what is wanted; they edit the chain of
    engines that `engines` shows.

    Parameters
    ----------
    lower, upper : corners of the grid, m; two numbers each make a plane-strain scene (per metre of
        thickness), three a 3D scene. Ghost nodes outside are added by the solver.
    axisymmetric : bool, whether a scene of two axes is symmetric about the line x = 0: x is the distance from
        that axis, and y goes along it. Masses, forces, energies are those of the whole circumference (kN, Mg,
        kJ), and so are the loads that you give. Grids that begin at x = 0 have rollers there. Default False.
        See doc/howto/axisymmetry.md.
    cell : cell size, m; one number or one per axis. upper - lower must be a multiple of it.
    grading : `Grading`, whose cells grow outside of a box; or a sequence with the positions of the lines of
        nodes across each axis, m (None: equal cells along that axis; `cell` may be left out where none is
        equal). Default: all cells are equal. See doc/explanation/graded-grids.md.
    gravity : m/s2, a number downwards, along the last axis, or one component per axis; default: none, or that
        of the GridSolver among the engines that are given.
    damping : local damping of the GridSolver, -, from 0 to below 1; default 0, or that of the GridSolver
        given.
    threads : number of threads; default: one for every 1000 particles, at most OMP_NUM_THREADS, and a single
        one while a run finds that faster, as it is beside other jobs. The results are the same bits for any
        number.

    Raises ValueError for a grid that is not made of whole cells, MemoryError for one that does not fit.

    Attributes
    ----------
    lower : (dim,), m, corner of the grid with the smallest coordinates; ghost nodes lie outside.
    upper : (dim,), m, opposite corner of the grid.
    cell : (dim,), m, cell size along each axis; with a grading the smallest.
    dim : 2 for plane strain and axial symmetry, or 3.
    isAxisymmetric : bool, whether x is the distance from an axis of symmetry.
    isGraded : bool, whether cells differ.
    bodies : tuple of Body, in the order in which they were added; `remove` empties one.
    dtCritical : s, 2/omega_max of the grid, or the longest stable step if that is shorter (USL), as estimated
        last; None before. Implicit bodies count with their mass alone: they do not limit the step;
        `criticalTimeStep(asIfExplicit=True)` tells what it would be with their stiffness.
    stiffest : body in which the mode of dtCritical moves most.
    dtStable : s, longest stable step of the scheme, with flip and damping, as estimated last; None before.
    dtSpeed : s, step in which the fastest particle or prescribed motion moves 0.2 of the smallest cell; the
        automatic step is no longer.
    stepper : `Stepper`, for loops of your own.
    """

    _elsewhere = {
        "roller": "call scene.roller('left', 'right')",
        "fix": "call scene.fix('bottom')",
        "fixed": "call scene.fix('bottom')",
        "drive": "call scene.drive(body, velocity=(0, -0.1))",
        "hold": "call scene.drive(region, velocity=(0, 0))",
        "contact": "call scene.contact(pile, soil, friction=0.3)",
        "flip": "flip is of GridToParticle: scene.engines[2] = mpm.GridToParticle(flip=1)",
    }
    _instead = "scene.save(file) keeps it, mpm.load(file) makes another one"

    lower: np.ndarray
    upper: np.ndarray
    cell: np.ndarray
    dim: int
    isGraded: bool
    isAxisymmetric: bool
    dtCritical: float | None
    dtStable: float | None
    stiffest: str | None
    stepper: Stepper

    # Methods that have a file of their own.
    add, remove = add, remove
    attach, detach, stage, report = attach, detach, stage, report
    fix, roller, contact, drive = asking.fix, asking.roller, contact, asking.drive
    load, viscous, tie, freeField = asking.load, viscous, tie, freeField
    terrain, maps = grounding.terrain, grounding.maps
    record, history, quasiStatic = asking.record, asking.history, asking.quasiStatic
    describe = describe
    nodePositions, faceNodes, nodesInside = nodePositions, faceNodes, nodesInside
    cellSizeAt = cellSizeAt
    initialStress, settle, unbalancedForce = initialStress, settle, unbalancedForce
    groundStress = groundStress
    run, step, pause, wait, close = run, step, pause, wait, close
    _convert, _writeParticles = convert, staticmethod(writeParticles)  # for Body
    _handOver, _refuseWhileRunning, _refuseDuringStep = handOver, refuseWhileRunning, refuseDuringStep
    _refuseBetweenStages = refuseBetweenStages
    _watch = asking.watch  # for run
    plot, _repr_html_ = display.plot, display.html

    @checked("Scene", research=("scheme",))
    def __init__(
        self,
        lower: ArrayLike,
        upper: ArrayLike,
        cell: ArrayLike | None = None,
        scheme: str = "MUSL",
        threads: int | None = None,
        grading: Grading | Sequence | None = None,
        gravity: ArrayLike | None = None,
        damping: float | None = None,
        axisymmetric: bool = False,
    ) -> None:
        lower, upper = corner("lower", lower), corner("upper", upper)
        dim = len(lower)
        if len(upper) != dim:
            raise ValueError(f"Scene: lower has {dim} components, upper {len(upper)}; give 2 or 3 for both")
        axial.check(axisymmetric, lower, upper)
        cell = None if cell is None and grading is not None else cellSize(cell, dim)
        lines = linesOf(grading, lower, upper, cell)
        core = makeCore(lower, upper, cell, lines)
        if axisymmetric:
            axial.begin(core, lower)
        self.__dict__.update(
            lower=lower,
            upper=upper,
            dim=dim,
            cell=cell if lines is None else np.array(core.cell),
            isGraded=lines is not None,
            isAxisymmetric=bool(axisymmetric),
            _core=core,
            dtCritical=None,  # s, as estimated last
            dtStable=None,
            _dtIterations=None,
            stiffest=None,  # body in which the fastest mode moves most
            stepper=Stepper(self),
            _holder=Holder(),
            _geostaticGravity=None,  # m/s2 that the initial stress balances
            _geostaticLayers={},  # name of a body -> Layer that initialStress made of it
            _dampingAfterSettling=None,  # while settle() is at work
            _startEnergy=0.0,  # kJ, kinetic energy before the first step
            _restedAt=None,  # s, when settle() was done: a check of the run begins there
            _notedSignals=None,  # that came between the runs of settle()
            _loadsAndDrives=[],  # that were made for its bodies, whether given to it or not
            _asked=Asked(),  # engines that calls of the scene have edited
            _contactPairs=[],  # that calls of contact have named
            _changesNoted=Changes(),
            _stages=[],  # rows of the stages that have ended
            _stage=None,  # name of the one that goes on
            _lastCheckpoint=None,  # (name, stamp) of the file
            _warnedOf=set(),  # faults of the domains that runs have told
        )
        self._bodies = []
        self._lines = tuple(np.array(x[GHOSTS:-GHOSTS]) for x in core.lines)
        for array in (self.lower, self.upper, self.cell, *self._lines):
            array.setflags(write=False)
        self._dt, self._threads, self._engines, self._loop = None, None, None, None
        self._allowUnstable = False
        self._defaultSolver = None  # the GridSolver of the default chain
        self._added = {}  # engines that the scheme asked for, by class
        self.scheme = scheme
        self.threads = threads
        if gravity is not None:
            self.gravity = gravity
        if damping is not None:
            self.damping = damping

    def __repr__(self):
        cells = " x ".join(str(n - 5) for n in self._core.nodes)
        bodies = f"{len(self.bodies)} {'body' if len(self.bodies) == 1 else 'bodies'}"
        return (
            f"<Scene {self.dim}D, {cells} cells, {bodies}, {self.particleCount} particles, "
            f"t = {self.time:g} s>"
        )

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __getitem__(self, name: str) -> Body:
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(
            f"Scene: there is no body named {shown(name)}; bodies: {', '.join(b.name for b in self.bodies)}"
        )

    @property
    def bodies(self) -> tuple[Body, ...]:
        """Tuple of all bodies, in the order in which they were added; `add` makes one more."""
        return Bodies(self._bodies)

    lines = property(
        lambda self: self._lines,
        doc="Positions of the lines of nodes across each axis, m: a tuple of arrays to read, without ghosts.",
    )
    particleCount = property(
        lambda self: sum(b.count for b in self.bodies), doc="Number of particles of all bodies."
    )
    constraints = property(
        lambda self: list(self.stepper.constraints), doc="All prescribed motions, faces included."
    )

    @property
    def drives(self) -> dict[str, Drive | Hold]:
        """What `drive` has made, by name, to be looked at, changed, and taken away (`del`); those of a
        checkpoint, too."""
        return asking.Drives(self)

    def _thicknessAt(self, x):
        """Thickness of the scene at distances x from the axis, m: 2 pi x, in plane strain 1."""
        return 2 * np.pi * x if self.isAxisymmetric else np.ones_like(x)

    _perMetre = property(
        lambda self: "/m" if self.dim == 2 and not self.isAxisymmetric else "",
        doc="What stands behind the unit of a force.",
    )
    _hasAxis = property(
        lambda self: self.isAxisymmetric and self.lower[0] == 0, doc="Whether the left side is the axis."
    )

    @property
    def changes(self) -> list[dict]:
        """Parameters that were changed between runs, and where: list of dicts with step, time (s), what,
        before and after. Engines, prescribed motions, materials and flags of bodies count, and dt; each run
        and each checkpoint looks what is other than before. Checkpoints and the files of recorders have
        it."""
        return list(self._changesNoted.all)

    stages = property(
        lambda self: [dict(row, values=dict(row["values"])) for row in self._stages],
        doc="Stages that have ended (`stage`): list of dicts with name, begin and end (s), values.",
    )

    # --- running --------------------------------------------------------------------------------------
    def prepare(self) -> None:
        """Checks the scene and makes it ready to step; `run` does it."""
        refuseDuringStep(self, "prepare")
        with self._holder.held("prepare"):
            self.stepper.prepare()

    def _checkTimeStep(self):
        """Estimates the critical step; takes 0.8 of it if dt was left out, refuses a dt above it
        otherwise."""
        refuseDuringStep(self, "checkTimeStep")
        with self._holder.held("checkTimeStep"):
            self.stepper.checkTimeStep()

    def _isMidStep(self):
        """Whether a callback is at work between two stages of a step, where the state is neither old nor
        new."""
        return self.stepper.isMidStep()

    def save(self, file: str | os.PathLike) -> None:
        """Writes a checkpoint (HDF5) from which `mpm.load` continues with the same bits.

        Parameters
        ----------
        file : str, name of the file.

        Raises OSError when the file cannot be written, RuntimeError in the middle of a step (in a callback
        between two stages) or while a run is going on in the background.
        """
        self._refuseWhileRunning("save")
        refuseMidStep(self, "save")
        with self._holder.held("save"):
            save(self, file)

    # --- loops ----------------------------------------------------------------------------------------
    running = property(
        lambda self: self._loop is not None and self._loop.isAlive(),
        doc="Whether a background run is going on.",
    )
