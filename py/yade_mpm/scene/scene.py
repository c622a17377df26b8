# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene: grid, bodies, engines, clock, and the run."""

import warnings

import numpy as np

from .. import _core
from ..base import limits
from ..base.attributes import Guarded
from ..check.mistakes import likelyMistakes
from ..engine.callback import Callback
from ..engine.engine import Engine, belongTo
from ..engine.engines import classes
from ..engine.gridSolver import GridSolver
from ..engine.prescribed import FACES
from ..geometry.lattice import checkOverlap
from ..geometry.region import Region
from ..io import checkpoint
from ..io.files import checkWritable
from ..material.materials import Material
from ..particle.body import Body
from ..particle.types import Boxes, ParticleType
from ..particle.types import classes as particleClasses
from .run import Run

MOST_THREADS = 1024
PARTICLES_PER_THREAD = 1000  # a block of 2000 is 1.5 times as fast on two (doc/performance.md)


class Scene(Guarded):
    """Everything a run works on.

    Parameters
    ----------
    lower, upper : corners of the grid, m; two numbers each make a plane-strain scene (per metre of thickness), three a
        3D scene. Ghost nodes outside are added by the solver.
    cell : cell size, m; one number or one per axis. upper - lower must be a multiple of it.
    scheme : "MUSL" (default), "USF" or "USL": when the stress is updated in a step (Sulsky et al. 1995; Bardenhagen 2002).
    threads : number of threads; default: one for every 1000 particles, at most OMP_NUM_THREADS, and a single one while a run
        finds that faster, as it is beside other jobs. The results are the same bits for any number.

    Raises ValueError for a grid that is not made of whole cells.
    """

    def __init__(self, lower, upper, cell, scheme="MUSL", threads=None):
        lower, upper = _corner("lower", lower), _corner("upper", upper)
        dim = len(lower)
        if len(upper) != dim:
            raise ValueError(f"Scene: lower has {dim} components, upper {len(upper)}; give 2 or 3 for both")
        cell = _cell(cell, dim)
        try:
            core = (_core.Scene2 if dim == 2 else _core.Scene3)(list(lower), list(upper), list(cell))
        except MemoryError:
            raise MemoryError(
                f"Scene: the {np.prod((upper - lower) / cell):.3g} cells of the grid do not fit into memory; give a larger "
                f"cell or a smaller grid"
            ) from None
        self.__dict__.update(
            lower=lower,
            upper=upper,
            dim=dim,
            cell=cell,
            core=core,
            bodies=[],
            allowUnstable=False,
            dtCritical=None,  # s, as estimated last
            dtIterations=None,
            stiffest=None,  # body in which the fastest mode moves most
        )
        self._dt, self._threads, self._engines, self._run = None, None, None, None
        self._constraints, self._chain = [], None  # engines that the core has
        self._prepared, self._checked, self._checkedState = False, False, None
        self._estimatedAt = -1  # step at which the critical step was estimated last
        self._acting = None  # callback that is at work
        self._settling = None  # damping to go back to after settle()
        self._geostatic = None  # m/s2 that the initial stress balances
        self._made = []  # loads and drives that were made for its bodies
        self._warnedOf = set()  # faults of the domains that runs have told
        self.scheme = scheme
        self.threads = threads

    def __repr__(self):
        return (
            f"<Scene {self.dim}D, {' x '.join(str(n - 5) for n in self.core.nodes)} cells, {len(self.bodies)} bodies, "
            f"{self.particleCount} particles, t = {self.time:g} s>"
        )

    # --- bodies ---------------------------------------------------------------------------------------
    def add(self, name, region, material, type, inertiaScale=1.0, fbar=False, group="main"):
        """Adds a body and returns it.

        name : used in messages, results and checkpoints.
        region : Region; for APDI also (points (Nv, dim), cells (Nc, 4 or 8)), a Mesh, or the name of a mesh file. Domains are in the order
            of the cells; those of a file are numbered anew in rows, for speed: `body.mesh.cellNumbers` tells which cell each is.
        material : e.g. mpm.LinearElastic(...). type : e.g. mpm.UGIMP(perCell=2) or mpm.APDI(size=0.25).
        inertiaScale : factor on the inertial mass, not on the weight; default 1.
        fbar : one increment of volumetric strain and one linear mean stress per cell (against volumetric locking; de Souza Neto et al.
            1996, doc/decisions/0008); default False.
        group : name; bodies of one group stick together, between groups a `Contact` engine lets them slip; default "main".

        Raises ValueError for an empty body, edges off the particle spacing, particles outside the grid, bodies that
        overlap, or a mesh that is inverted; TypeError for a wrong kind of argument.
        """
        self._refuseWhileRunning("add")
        if not (isinstance(name, str) and name):
            raise TypeError(f"Scene: name = {name!r} of a body; give a string")
        if not isinstance(material, Material):
            raise TypeError(f"body '{name}': material = {material!r}; give e.g. mpm.LinearElastic(...)")
        if not isinstance(type, ParticleType):
            raise TypeError(
                f"body '{name}': type = {type!r}; give e.g. mpm.UGIMP(perCell=2) or mpm.APDI(size=...)"
            )
        if isinstance(region, Region) and region.dim != self.dim:
            raise ValueError(f"body '{name}': the region is {region.dim}D, the scene {self.dim}D")
        geometry = type.geometry(region, self, name)
        if not isinstance(geometry, tuple) and geometry.dim != self.dim:
            raise ValueError(f"body '{name}': the mesh is {geometry.dim}D, the scene {self.dim}D")
        self._checkInside(name, geometry)
        body = self._newBody(
            name, material, type, region if isinstance(region, Region) else None, inertiaScale, fbar, group
        )
        try:
            self._build(body, geometry)
            for other in self.bodies[:-1]:
                checkOverlap(other.name, *_boxes(other), name, *_boxes(body))
        except Exception:
            self._drop(body)
            raise
        if type.core.converts:
            self._addConverted(body)
        return body

    def _newBody(self, name, material, type, region, inertiaScale, fbar, group):
        core = self.core.addBody(name, material.core, type.core)
        body = Body(self, core, type, material, region)
        self.bodies.append(body)
        self._dirty()
        try:
            body.inertiaScale, body.fbar, body.group = inertiaScale, fbar, group
        except Exception:
            self._drop(body)
            raise
        material._usedBy = type._usedBy = name
        return body

    def _drop(self, body):
        """Takes back the body added last; whoever still has it finds it empty, not dangling."""
        self.bodies.pop()
        self.core.dropBody()
        body.__dict__.update(core=None, _fields=())

    def _build(self, body, geometry):
        if isinstance(geometry, tuple):
            outline = (_array(geometry.carriers, np.int32), _array(geometry.offsets), _array(geometry.areas))
            body.core.buildLattice(_array(geometry.positions), _array(geometry.halfSize), *outline)
            if geometry.shares is not None:
                for field in ("mass", "volume", "initialVolume"):
                    setattr(body, field, getattr(body, field) * geometry.shares[body.id])
        else:
            body.mesh = geometry
            body.core.buildMesh(
                _array(geometry.points),
                _array(geometry.cells, np.int32),
                _array(geometry.slaves, np.int32),
                _array(geometry.masters, np.int32),
                _array(geometry.masterWeights),
            )

    def _addConverted(self, body):
        """The body that takes over domains of `body` that become too distorted; empty at first."""
        spacing = self.cell / 2 if body.type.matched is None else 2 * body.type.matched.halfSize
        other = self._newBody(
            body.name + " (converted)",
            body.material,
            particleClasses["UGIMP"](),
            None,
            body.inertiaScale,
            body.fbar,
            body.group,
        )
        self._build(other, Boxes(np.zeros((0, self.dim)), spacing / 2))
        self._convertTo(body, other)

    def _convertTo(self, body, other):
        self.core.convertTo(body.name, other.name)
        body._convertsTo = other.name

    def _checkInside(self, name, geometry):
        positions = geometry[0] if isinstance(geometry, tuple) else geometry.points
        tolerance = 1e-9 * self.cell
        outside = ((positions < self.lower - tolerance) | (positions > self.upper + tolerance)).any(axis=1)
        if outside.any():
            at = positions[np.argmax(outside)]
            raise ValueError(
                f"body '{name}': {'particle' if isinstance(geometry, tuple) else 'vertex'} at {_place(at)} is outside "
                f"the grid {_place(self.lower)} to {_place(self.upper)}; enlarge the grid or move the body"
            )

    def __getitem__(self, name):
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(f"there is no body named '{name}'; bodies: {', '.join(b.name for b in self.bodies)}")

    particleCount = property(
        lambda self: sum(b.count for b in self.bodies), doc="Number of particles of all bodies."
    )

    # --- nodes ----------------------------------------------------------------------------------------
    def nodePositions(self):
        """Positions of all grid nodes, ghosts included, m (Nn, dim); first axis fastest."""
        axes = [self.lower[k] + (np.arange(self.core.nodes[k]) - 2) * self.cell[k] for k in range(self.dim)]
        return np.stack([a.ravel(order="F") for a in np.meshgrid(*axes, indexing="ij")], axis=1)

    def faceNodes(self, face):
        """Numbers of the nodes on and behind a face of the grid."""
        if face not in FACES[self.dim]:
            raise ValueError(f"there is no face '{face}'; faces are {', '.join(FACES[self.dim])}")
        axis, side = FACES[self.dim][face]
        x = self.nodePositions()[:, axis]
        tolerance = 1e-6 * self.cell[axis]
        return np.flatnonzero(
            x <= self.lower[axis] + tolerance if side == 0 else x >= self.upper[axis] - tolerance
        )

    def nodesInside(self, region):
        """Numbers of the nodes inside a region."""
        if not isinstance(region, Region):
            raise TypeError(f"nodesInside: {region!r} is not a region, e.g. box((0, 0), (1, 1))")
        return np.flatnonzero(region.contains(self.nodePositions()))

    # --- engines and clock ----------------------------------------------------------------------------
    @property
    def engines(self):
        """The chain of engines; assign a list to change it. Default: ParticleToGrid, GridSolver, GridToParticle,
        DomainUpdater (USF: DomainUpdater before GridSolver). They serve this scene alone; `dead=True` leaves one out."""
        if self._engines is None:
            self.engines = [
                classes[n]() for n in ("ParticleToGrid", "GridSolver", "GridToParticle", "DomainUpdater")
            ]
        return self._engines

    @engines.setter
    def engines(self, engines):
        self._refuseDuringStep("engines")
        engines = list(engines) if isinstance(engines, (list, tuple)) else [engines]
        for engine in engines:
            if not isinstance(engine, Engine):
                raise TypeError(f"Scene: {engine!r} is not an engine; give a list of engines")
        if self.scheme == "USF":
            engines = _inUSFOrder(engines)
        _checkOrder(engines, self.scheme)
        self._engines = engines
        self._dirty()

    @property
    def scheme(self):
        """ "MUSL", "USF" or "USL"."""
        return self.core.scheme

    @scheme.setter
    def scheme(self, name):
        if self._engines is not None:
            raise ValueError("Scene: set the scheme before the engines")
        if not isinstance(name, str):
            raise ValueError(f"Scene: scheme = {name!r} is not allowed; give one of 'MUSL', 'USF', 'USL'")
        self.core.scheme = name

    time = property(lambda self: self.core.time, doc="Scene time, s.")
    steps = property(lambda self: self.core.step, doc="Number of steps taken.")

    @property
    def dt(self):
        """Time step, s. Left out: 0.8 of the critical step, estimated anew every 5000 steps."""
        return self._dt if self._dt is not None else (self.core.dt or None)

    @dt.setter
    def dt(self, value):
        self._refuseDuringStep("dt")
        if value is not None and not (_isNumber(value) and 0 < value < np.inf):
            raise ValueError(
                f"Scene: dt = {value!r} s is not allowed; give a positive number, or None for an automatic step"
            )
        self._dt = None if value is None else float(value)
        self._dirty()

    @property
    def threads(self):
        """Number of threads in use: as given, or one for every 1000 particles but at most OMP_NUM_THREADS (all cores); a
        run tries a single one now and then, and stays with the faster."""
        return self._threads or min(
            _core.availableThreads(), max(1, self.particleCount // PARTICLES_PER_THREAD)
        )

    @threads.setter
    def threads(self, value):
        isCount = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
        if value is not None and not (isCount and 1 <= value <= MOST_THREADS):
            raise ValueError(
                f"Scene: threads = {value!r} is not allowed; give a whole number from 1 to {MOST_THREADS}, "
                f"or None for a choice by the number of particles"
            )
        self._threads = None if value is None else int(value)
        self._prepared = False

    def criticalTimeStep(self, tolerance=1e-4, iterations=300):
        """Largest stable time step of the scene as it stands, s: 2/omega_max of the assembled elastic grid operator.

        tolerance : relative change of the eigenvalue over ten iterations at which to stop. Also sets `dtCritical`
        and `stiffest`. Source: spectral bound of the central-difference scheme; Lanczos iteration.
        """
        self._refuseWhileRunning("criticalTimeStep")
        if not (isinstance(iterations, (int, np.integer)) and iterations >= 1 and tolerance > 0):
            raise ValueError(
                f"criticalTimeStep: tolerance = {tolerance!r}, iterations = {iterations!r} is not allowed; give a "
                f"positive number, and a whole number from 1 on"
            )
        if self.isMidStep():
            raise RuntimeError(
                "criticalTimeStep: the scene is in the middle of a step; put the callback at the end of the engines"
            )
        return self._estimate(tolerance, iterations)

    def _estimate(self, tolerance=1e-4, iterations=300):
        self._prepareChain()
        self.dtCritical, self.dtIterations, self.stiffest = self.core.criticalTimeStep(tolerance, iterations)
        return self.dtCritical

    # --- initial state --------------------------------------------------------------------------------
    def initialStress(self, surface, K0, gravity=9.81, bodies=None, unitWeight=None):
        """Geostatic stress below a level surface: sigma_v = -gamma z, sigma_h = -K0 gamma z, z the depth.

        surface : height of the ground surface (last axis), m. K0 : earth pressure coefficient at rest, -.
        gravity : m/s2. unitWeight : gamma, kN/m3; default: density of each body times gravity.
        bodies : which; default: all that do not rise above the surface.
        Raises ValueError when nothing lies below the surface or layers of different weight need `unitWeight`.
        """
        for name, value, least in (
            ("surface", surface, -np.inf),
            ("K0", K0, 0),
            ("gravity", gravity, 0),
            ("unitWeight", 0 if unitWeight is None else unitWeight, 0),
        ):
            if not (isinstance(value, (int, float, np.number)) and np.isfinite(value) and value >= least):
                raise ValueError(
                    f"initialStress: {name} = {value!r} is not allowed; give "
                    f"{'zero or a positive number' if least == 0 else 'a number'}"
                )
        for body in bodies or ():
            if not isinstance(body, Body):
                raise TypeError(
                    f"initialStress: {body!r} among the bodies is not a body, as scene.add returns it"
                )
        ground = bodies or [b for b in self.bodies if b.count and b.position[:, -1].max() < surface]
        if not ground:
            raise ValueError(f"initialStress: no body lies below the surface {surface:g} m; check the level")
        self._geostatic = float(gravity) if unitWeight is None else None
        weights = {b.material.density * gravity for b in ground} if unitWeight is None else {unitWeight}
        if len(weights) > 1:
            raise ValueError(
                f"initialStress: the bodies weigh {sorted(weights)} kN/m3; give unitWeight, or set body.stress"
            )
        for body in ground:
            vertical = -weights.copy().pop() * (surface - body.position[:, -1])
            stress = np.zeros((body.count, 3, 3))
            up = self.dim - 1
            for k in range(3):
                stress[:, k, k] = vertical * (1.0 if k == up else K0)
            body.setStress(stress)

    def settle(self, damping=0.7, tolerance=1e-3, maxSteps=200000, checkEvery=200, progress=None):
        """Lets gravity settle with heavy damping, then stops all motion and counts displacement from there.

        Ends when the largest out-of-balance force that particles feel (`unbalancedForce`) falls below `tolerance` times the mean
        internal force. Ramps of prescribed motions count from there. Returns the number of steps. Raises ValueError for a
        prescribed motion that is not at rest, RuntimeError if it takes more than maxSteps.
        """
        solver = self._solver("settle")
        motions = solver.constraints(self)
        for motion in motions:
            if any(motion.velocity):
                raise ValueError(
                    f"settle: '{motion.name}' would move on with {motion.velocity} m/s; set its velocity to zero, settle, and "
                    f"set it again"
                )
        self._settling, solver.damping = solver.damping, damping
        taken, ratio = 0, np.inf
        try:
            while ratio > tolerance:
                if taken >= maxSteps:
                    raise RuntimeError(
                        f"settle: still out of balance by {ratio:.2g} of the mean force after {taken} steps; "
                        f"raise tolerance, or maxSteps, or check that the bodies are supported"
                    )
                self.run(steps=checkEvery, progress=False if progress is None else progress)
                taken += checkEvery
                ratio = self.unbalancedForce()
        finally:
            solver.damping, self._settling = self._settling, None
        for body in self.bodies:
            body.velocity[...] = 0
            body.zeroDisplacement()
        for motion in motions:
            motion.core.began = self.time
        return taken

    def unbalancedForce(self):
        """Largest out-of-balance force that particles feel over the mean internal force of a node, -; takes one step to see it.

        It is that of a cell full of the particle's material, rho h^dim |a|, with the change a of its velocity in the step (local
        damping takes part in it). What nodes have left that cancels over every particle does not count: hourglass control keeps a
        distorted mesh from ever losing it under MUSL. Infinite where nothing but inertia acts against a force.
        """
        before = [(body.id.copy(), body.velocity.copy()) for body in self.bodies]
        self.step()
        largest = 0.0
        for body, (ids, velocity) in zip(self.bodies, before):
            _, old, now = np.intersect1d(
                ids, body.id, assume_unique=True, return_indices=True
            )  # they may have been sorted, or cut
            change = np.linalg.norm(body.velocity[now] - velocity[old], axis=1) / self.dt
            felt = body.inertiaScale * (body.mass / body.volume)[now] * change
            largest = max(largest, felt.max(initial=0.0) * np.prod(self.cell))
        d = self.dim
        internal = np.linalg.norm(np.array(self.core.nodalValues())[:, 2 + d : 2 + 2 * d], axis=1)
        if not internal.any():
            return np.inf if largest > 0 else 0.0
        return float(largest / internal[internal > 0].mean())

    # --- running --------------------------------------------------------------------------------------
    def run(
        self,
        until=None,
        steps=None,
        background=False,
        progress=None,
        checkpointFile=None,
        checkpointPeriod=600.0,
    ):
        """Runs to a time or for a number of steps.

        until : scene time to reach, s; or steps : number of steps. One of the two.
        background : return at once; `pause()` stops, `wait()` waits and raises what went wrong.
        progress : show progress; default: yes for a run of more than 2 s.
        checkpointFile : where Ctrl-C, SIGTERM and errors leave the state; default: beside the recorder's file, or
            yade_mpm.checkpoint.h5.
        checkpointPeriod : wall time after which the state is saved there anyway, for power that fails or a killed process, s;
            default 600; None: not. Saving takes at most a hundredth of the run.

        Before the first step the scene is checked: ValueError for a time step above the critical one (unless
        `allowUnstable`), an interface that is too coarse, or constraints that hold nothing. During the run RuntimeError
        for particles outside the grid, distorted domains and an interface that has become too coarse, after the state was
        saved. KeyboardInterrupt and SystemExit(143) after Ctrl-C and SIGTERM, likewise.
        """
        self._refuseWhileRunning("run")
        if self._acting is not None:
            raise RuntimeError("run: a step is going on; a callback cannot run the scene")
        if (until is None) == (steps is None):
            raise ValueError("run: give either until (s) or steps")
        if steps is not None and not (isinstance(steps, (int, np.integer)) and steps >= 0):
            raise ValueError(f"run: steps = {steps!r} is not allowed; give a whole number")
        if until is not None and not (isinstance(until, (int, float, np.number)) and until < np.inf):
            raise ValueError(f"run: until = {until!r} is not allowed; give a time in s")
        if until is not None and not until > self.time:
            raise ValueError(f"run: until = {until:g} s is not after the scene's time {self.time:g} s")
        if checkpointFile is not None:
            checkWritable(checkpointFile)
        if checkpointPeriod is not None and not (_isNumber(checkpointPeriod) and checkpointPeriod >= 0):
            raise ValueError(
                f"run: checkpointPeriod = {checkpointPeriod!r} is not allowed; give a wall time in s, or None"
            )
        self.prepare()
        self._run = Run(self, until, steps, progress, checkpointFile, checkpointPeriod)
        if background:
            self._run.start()
        else:
            self._run.loop()

    def step(self):
        """Takes one step. The critical step is estimated before the first one only."""
        self._refuseWhileRunning("step")
        if self._acting is not None:
            raise RuntimeError("step: a step is going on; a callback cannot step the scene")
        if not self._prepared or self._chain != self._engines or self._checkedState != self._stabilityState():
            self.prepare()
        try:
            self.core.advance(1, 1e9)
        finally:
            self._acting = None

    running = property(
        lambda self: self._run is not None and self._run.isAlive(),
        doc="Whether a background run is going on.",
    )

    def pause(self):
        """Ends a run: of a background run waits for the end of a slice of 0.1 s; in a callback, after this step."""
        if self._run is not None:
            self._run.stop()
            self._run.wait()

    def isMidStep(self):
        """Whether a callback is at work between two stages of a step, where the state is neither old nor new."""
        if self._acting is None:
            return False
        stages = [e for e in self.engines if not isinstance(e, Callback) and not e.dead]
        before = self.engines[: self.engines.index(self._acting)] if self._acting in self.engines else []
        done = [e for e in stages if e in before]
        changes = [e for e in done if type(e).__name__ != "ParticleToGrid"]
        return bool(changes) and len(done) < len(stages)

    def _refuseWhileRunning(self, what):
        if self.running and not self._run.isThisThread():
            raise RuntimeError(f"{what}: a run is going on in the background; pause() it first")

    def _refuseDuringStep(self, what):
        self._refuseWhileRunning(what)
        if self._acting is not None:
            raise RuntimeError(
                f"{what}: a step is going on, and the change would come too late; pause() in the callback, and "
                f"set it between two runs"
            )

    def _solver(self, who):
        for engine in self.engines:
            if isinstance(engine, GridSolver):
                return engine
        raise ValueError(f"{who}: there is no GridSolver among the engines")

    def wait(self):
        """Waits for a background run and raises what went wrong in it."""
        if self._run is not None:
            self._run.wait()

    def prepare(self):
        """Checks the scene and makes it ready to step; `run` does it."""
        if not isinstance(self.allowUnstable, (bool, np.bool_)):
            raise ValueError(
                f"Scene: allowUnstable = {self.allowUnstable!r} is not allowed; give True or False"
            )
        self._prepareChain()
        for body in self.bodies:
            _checkFields(body)
        if self.steps == 0:
            for mistake in likelyMistakes(self, self._solver("prepare").gravity):
                warnings.warn(mistake, stacklevel=3)
        self._checkInterface(limits.INTERFACE_BUILD if self.steps == 0 else limits.INTERFACE_RUN)
        if not (self._checked and self._checkedState == self._stabilityState()):
            self.checkTimeStep()
        self.core.threads = self.threads
        self._prepared = True

    def checkTimeStep(self):
        """Estimates the critical step; takes 0.8 of it if dt was left out, refuses a dt above it otherwise."""
        self.core.threads = self.threads
        if self._dt is not None and self.allowUnstable and self.dtCritical is not None:
            self.core.dt = self._dt
            self._isChecked()
            return
        critical = self._estimate()
        if self._dt is None:
            if not critical > 0:
                raise ValueError(
                    "Scene: no critical time step can be found (every node is held); give scene.dt"
                )
            self.core.dt = limits.DT_SAFETY[self.scheme] * critical
        elif self._dt > critical > 0 and not self.allowUnstable:
            raise ValueError(
                f"dt = {self._dt:.3g} s exceeds the critical step {critical:.3g} s of this scene (stiffest: "
                f"'{self.stiffest}'); lower dt, raise inertiaScale, or coarsen the grid"
            )
        else:
            self.core.dt = self._dt
        self._isChecked()

    def _isChecked(self):
        self._checked, self._checkedState, self._estimatedAt = True, self._stabilityState(), self.steps

    def _stabilityState(self):
        """What the critical step depends on and may be changed between runs."""
        return (
            self._dt,
            self.allowUnstable,
            [(tuple(b.material.lameConstants), b.inertiaScale) for b in self.bodies],
        )

    def _dirty(self):
        self._prepared = self._checked = False

    def _prepareChain(self):
        engines = self.engines
        _checkOrder(engines, self.scheme)  # the list itself may have been changed since it was given
        _checkComplete(engines, self.scheme)
        constraints = [c for e in engines if isinstance(e, GridSolver) for c in e.constraints(self)]
        for part in [*engines, *constraints]:
            belongTo(self, part)
        for constraint in constraints:
            constraint.bind(self)
        self._constraints = constraints
        for engine in sorted(engines, key=lambda e: isinstance(e, Callback)):  # which look at the others
            engine.bind(self)
        self.core.setConstraints([c.core for c in constraints])
        self.core.setEngines([e.core for e in engines])
        self.core.prepare()
        self._chain = list(engines)
        for engine in engines:
            engine._isBound = True

    def _checkInterface(self, limit):
        """Refuses APDI edges within one cell of uGIMP that are longer than `limit` cells. Returns what is wrong with the longest
        of those above INTERFACE_WARN; or None."""
        fault = self.core.interfaceFault(min(limit, limits.INTERFACE_WARN))
        if fault is None:
            return None
        told = self._interfaceFault(*fault)
        if fault[3] > limit * min(self.cell):
            raise (ValueError(told) if self.steps == 0 else RuntimeError(f"step {self.steps}: {told}"))
        return told

    def _interfaceFault(self, meshed, boxes, where, edge, initial):
        cell = min(self.cell)
        place = f"interface of '{meshed}' and '{boxes}' near {where}: an edge"
        if initial > limits.INTERFACE_BUILD * cell:
            return (
                f"{place} of {edge:.6g} m is longer than the cell {cell:.6g} m within one cell of uGIMP particles; refine '{meshed}' there, "
                f"e.g. APDI(size=..., matched=...)"
            )
        return (
            f"{place} has stretched from {initial:.3g} to {edge:.3g} m, {edge / cell:.3g} cells, within one cell of uGIMP particles, where the "
            f'stress becomes wrong beyond one cell (a run ends at {limits.INTERFACE_RUN:g}); use UGIMP there, or APDI(onDistortion="convert")'
        )

    def _distortion(self):
        """Which APDI domain is distorted most, if any is much; or None."""
        poor = [
            (quality, body, particle, count)
            for body in self.bodies
            for count, particle, quality in [body.core.poorDomains(limits.POOR_QUALITY)]
            if count
        ]
        if not poor:
            return None
        quality, body, particle, count = min(poor, key=lambda p: p[0])
        number = f"{count} domains" if count > 1 else "a domain"
        return (
            f"{number} of '{body.name}' distorted, most that of particle {body.id[particle]} at {_place(body.position[particle])}: smallest corner "
            f"{100 * quality:.3g} % of its area, and at 5 % {'it becomes uGIMP' if body.type.core.converts else 'the run stops'}; use UGIMP there"
            + ("" if body.type.core.converts else ', or APDI(onDistortion="convert")')
        )

    # --- results --------------------------------------------------------------------------------------
    constraints = property(
        lambda self: list(self._constraints), doc="All prescribed motions, faces included."
    )

    def timing(self):
        """Dict engine -> (seconds, calls) since the scene was made."""
        return {(e.label or type(e).__name__): (e.seconds, e.calls) for e in self.engines}

    def save(self, file):
        """Writes a checkpoint (HDF5) from which `mpm.load` continues with the same bits.

        Raises OSError when the file cannot be written, RuntimeError in the middle of a step (in a callback between
        two stages) or while a run is going on in the background.
        """
        self._refuseWhileRunning("save")
        if self.isMidStep():
            raise RuntimeError(
                "save: the scene is in the middle of a step; put the callback at the end of the engines"
            )
        checkpoint.save(self, file)


_ORDER = {
    "MUSL": ("ParticleToGrid", "BoundaryLoad", "GridSolver", "Contact", "GridToParticle", "DomainUpdater"),
    "USF": ("ParticleToGrid", "DomainUpdater", "BoundaryLoad", "GridSolver", "Contact", "GridToParticle"),
}
_ORDER["USL"] = _ORDER["MUSL"]
_OPTIONAL = ("BoundaryLoad", "Contact")
_LIKE_LOADS = ("RigidContact",)  # add forces to the nodes where loads do


def _inUSFOrder(engines):
    """DomainUpdater straight after ParticleToGrid: the stress is updated first, and its forces summed before loads are added."""
    kinds = [type(e).__name__ for e in engines]
    if {"DomainUpdater", "ParticleToGrid"} <= set(kinds) and kinds.index("DomainUpdater") > kinds.index(
        "ParticleToGrid"
    ):
        updater = engines.pop(kinds.index("DomainUpdater"))
        engines.insert(kinds.index("ParticleToGrid") + 1, updater)
    return engines


def _checkOrder(engines, scheme):
    """Refuses stages in an order that has no meaning, or twice; others may stand anywhere."""
    stages = [type(e).__name__ for e in engines if type(e).__name__ in (*_ORDER[scheme], *_LIKE_LOADS)]
    kinds = ["BoundaryLoad" if s in _LIKE_LOADS else s for s in stages]
    places = [_ORDER[scheme].index(k) for k in kinds]
    isTwice = any(kinds.count(k) > 1 for k in kinds if k != "BoundaryLoad") or len(
        {id(e) for e in engines}
    ) < len(engines)
    if isTwice or places != sorted(places):
        raise ValueError(
            f"Scene: engines {', '.join(stages)} do not make a step; under {scheme} the order is "
            f"{', '.join(_ORDER[scheme])}, each once, loads (and RigidContact, in their place) as many as you like"
        )


def _checkComplete(engines, scheme):
    """Refuses a chain without a stage that every step needs; `dead` leaves one out on purpose."""
    needed = [kind for kind in _ORDER[scheme] if kind not in _OPTIONAL]
    missing = [kind for kind in needed if kind not in [type(e).__name__ for e in engines]]
    if missing:
        raise ValueError(
            f"Scene: {', '.join(missing)} missing among the engines; a step under {scheme} needs "
            f"{', '.join(needed)}; add what is missing, with dead=True to leave it out on purpose"
        )


def _boxes(body):
    """Centres and half sizes of boxes that lie inside the domains of a body, for the check of overlaps."""
    if body.cells is None:
        share = body.initialVolume / np.prod(2 * body.halfSize)
        return body.position, np.where(share > 1 - 1e-9, 1, share / 2)[
            :, None
        ] * body.halfSize  # of cut boxes half of what they hold
    corners = body.corners()
    return body.position, 0.5 * np.abs(corners - body.position[:, None]).min(axis=1)


def _array(values, dtype=np.float64):
    return np.ascontiguousarray(values, dtype=dtype)


def _checkFields(body):
    """Refuses values that are not finite, and mass or volume that is not positive."""
    names = [(f["name"], False) for f in body.core.fields(False)] + [
        (f["name"], True) for f in body.core.fields(True)
    ]
    for name, ofDomains in names:
        if name == "bodyForce" and not body.core.hasBodyForce:
            continue
        values = np.asarray(body.core.view(name, ofDomains))
        if not np.isfinite(values).all():
            number = np.argwhere(~np.isfinite(values))[0][0]
            raise ValueError(
                f"body '{body.name}': {name} holds a value that is not finite (entry {number}); mend it"
            )
        if name in ("mass", "volume", "initialVolume") and not (values > 0).all():
            raise ValueError(
                f"body '{body.name}': {name} = {values.min():g} of entry {values.argmin()} is not positive; mend it"
            )


def _isNumber(value):
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)


def _cell(cell, dim):
    try:
        return np.broadcast_to(np.asarray(cell, float), (dim,)).copy()
    except (TypeError, ValueError):
        raise ValueError(f"Scene: cell = {cell!r} is not allowed; give one number, or {dim}, m") from None


def _corner(what, values):
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if array.shape not in ((2,), (3,)) or not np.isfinite(array).all():
        raise ValueError(
            f"Scene: {what} = {values!r} is not allowed; give two (plane strain) or three numbers, m"
        )
    return array


def _place(x):
    return "(" + ", ".join(f"{v:.6g}" for v in x) + ")"
