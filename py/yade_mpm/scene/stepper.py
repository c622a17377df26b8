# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps of a scene, for the loop that owns the clock: `Scene.run`, `Scene.step`, or another program."""

import copy
import functools
import math
import time
from contextlib import contextmanager

import numpy as np

from ..base.attributes import Guarded, keep
from ..base.kinds import COUNT, ENGINE, FLAG, POSITIVE, takes
from ..base.warn import warnUser
from ..check import limits
from ..check.bending import actions, thinBeams
from ..check.domains import checkFields, checkInterface
from ..check.mistakes import likelyMistakes
from ..engine import chain
from ..engine.callback import Callback
from ..engine.engine import belongTo
from ..engine.gridSolver import GridSolver
from ..geometry.numbers import isNumber
from . import choices

UNLIMITED = 1e9  # s of wall time: no limit
SLICE = 0.1  # s of wall time between looks at signals

BLENDS = {
    "GridSolver": ("damping",),
    "GridToParticle": ("flip",),
}  # of engines, numbers that the longest stable step depends on


def _holding(method):
    """A method that is refused where another thread is at work with the scene."""

    @functools.wraps(method)
    def held(self, *args, **named):
        with self._scene._holder.held(f"Stepper.{method.__name__}"):
            return method(self, *args, **named)

    return held


class Stepper(Guarded):
    """Makes a scene ready to step, and takes its steps; `scene.stepper`.

    A loop of your own prepares once, then steps as long as the scene stays ready:

        scene.prepare()
        while ...:
            if not scene.stepper.isReady:
                scene.prepare()
            scene.stepper.advance(10)

    or engine by engine, with `act` for each of `scene.engines` and `endStep` behind the last stage.
    `LoopPolicy` tells such a loop when to look at the domains and to estimate the critical step again.

    Attributes
    ----------
    constraints : list of prescribed motions that are in force, those of faces included.
    estimatedAt : int, step at which the critical step was estimated last; -1: never.
    estimatedStiffness : dict, what `stiffnesses` gave at that time.
    automaticDt : float, s, step that was chosen last where nobody has given dt; None before.
    acting : Engine, callback that is at work or has failed at it; None between them.
        These five can be read, not set.
    onChange : function without argument that is called when something of the scene has changed; default None;
        TypeError for what cannot be called.
    """

    _instead = "use that of another scene"

    def __repr__(self):
        return f"<Stepper of {self._scene!r}>"

    def __init__(self, scene):
        self._scene = scene
        self._chain = None  # engines that the core has
        self._isPrepared, self._isStable = False, False
        self._isStepping = False  # whether the solver is at work, or calls back
        self._fullDt = None  # in a step that is shorter
        self._checkedState = None  # what the critical step was checked for
        self._onChange, self._constraints, self._estimatedStiffness = None, [], {}
        self._actions = None  # what may bend bodies, as it was when this was looked at
        keep(self, acting=None, estimatedAt=-1, automaticDt=None)

    constraints = property(lambda self: list(self._constraints))
    estimatedStiffness = property(lambda self: copy.deepcopy(self._estimatedStiffness))

    @property
    def onChange(self):
        return self._onChange

    @onChange.setter
    def onChange(self, function):
        if not (function is None or callable(function)):
            raise TypeError(f"Stepper: onChange = {function!r} is not allowed; give a function, or None")
        self._onChange = function

    # --- readiness ------------------------------------------------------------------------------------
    @property
    def isReady(self):
        """Whether the scene can step as it stands; if not, `prepare` it."""
        return self.isPrepared and self.isChecked

    @property
    def isPrepared(self):
        """Whether nothing was noted since `prepare` that calls for it again, and the engines are the same.

        Quicker than isReady, which also looks at what materials and bodies are like now.
        """
        return self._isPrepared and self._chain == self._scene.engines

    def _refuseUnprepared(self, what):
        if not self.isPrepared:
            raise RuntimeError(
                f"Stepper.{what}: the scene is not prepared, or has changed since; call scene.prepare() first"
            )

    @property
    def isChecked(self):
        """Whether the time step was checked for the scene as it stands."""
        return self._isStable and self._checkedState == self._stabilityState()

    def noteChange(self, mayBeUnstable=True):
        """Something of the scene has changed: it has to be prepared before the next step.

        Parameters
        ----------
        mayBeUnstable : bool, whether the time step has to be checked, too; default True.
        """
        self._isPrepared = False
        if mayBeUnstable:
            self._isStable = False
        if self.onChange is not None:
            self.onChange()

    @_holding
    def restore(self, isChecked, estimatedAt, estimatedStiffness, automaticDt):
        """State of a scene from a checkpoint: whether its time step was checked, and the last estimate.

        Raises ValueError for what no scene has: isChecked is True or False, estimatedAt a step up to the
        present one or -1, the others as the attributes of these names.
        """
        self._refuseUnlike(isChecked, estimatedAt, estimatedStiffness, automaticDt)
        self._constraints = self._motions()  # whose work diagnostics count, also before the next run
        self._isStable, self._checkedState = isChecked, self._stabilityState()
        self._estimatedStiffness = copy.deepcopy(estimatedStiffness)
        keep(self, estimatedAt=estimatedAt, automaticDt=automaticDt)

    def _refuseUnlike(self, isChecked, estimatedAt, estimatedStiffness, automaticDt):
        """Refuses an estimate that the scene cannot have had."""
        steps, isWhole = self._scene.steps, isinstance(estimatedAt, int) and not isinstance(estimatedAt, bool)
        areStiffnesses = isinstance(estimatedStiffness, dict) and all(
            isinstance(three, list)
            and len(three) == 3
            and all(isNumber(x) and 0 <= x < math.inf for x in three)
            for three in estimatedStiffness.values()
        )
        isLength = automaticDt is None or isNumber(automaticDt) and 0 < automaticDt < math.inf
        _require(isinstance(isChecked, bool), "isChecked", isChecked, "True or False")
        _require(
            isWhole and -1 <= estimatedAt <= steps, "estimatedAt", estimatedAt, f"-1, or a step to {steps}"
        )
        threes = "lists of three numbers from 0 on by the name of a body"
        _require(areStiffnesses, "estimatedStiffness", estimatedStiffness, threes)
        _require(isLength, "automaticDt", automaticDt, "a positive time in s, or None")

    @_holding
    def prepare(self):
        """Checks the scene and gives the chain to the solver; see `Scene.run` for what is refused."""
        scene = self._scene
        self._prepareChain()
        for body in scene.bodies:
            checkFields(body)
        if scene.steps == 0:
            for mistake in likelyMistakes(scene, scene._gridSolver("prepare").gravity):
                warnUser(mistake)
        self._warnOfThinBeams()
        checkInterface(scene, limits.INTERFACE_BUILD if scene.steps == 0 else limits.INTERFACE_RUN)
        if not self.isChecked:
            self.checkTimeStep()
        scene._core.threads = scene.threads
        self._isPrepared = True
        scene._changesNoted.look(scene)

    def _warnOfThinBeams(self):
        """Once each, when what acts has changed; a scene from a checkpoint was looked at before."""
        scene, before = self._scene, self._actions
        self._actions = actions(scene)
        if self._actions == before or (before is None and scene.steps > 0):
            return
        for name, text in thinBeams(scene):
            if f"bending of {name}" not in scene._warnedOf:
                scene._warnedOf.add(f"bending of {name}")
                warnUser(text)

    def _motions(self):
        """Prescribed motions of the engines, those of faces included."""
        scene = self._scene
        return [c for e in scene.engines if isinstance(e, GridSolver) for c in e._constraints(scene)]

    def _prepareChain(self):
        scene, engines = self._scene, self._scene.engines
        choices.update(scene, isFinal=True)
        if self._isStepping and engines != self._chain:
            raise RuntimeError(
                "Scene: a step is going on; a callback cannot change the engines: pause() first"
            )
        scene._putInOrder(engines)  # the list itself may have been changed since it was given
        chain.checkComplete(engines, scene._core.stageOrder, scene.scheme)
        self._constraints = self._motions()
        for part in [*engines, *self._constraints]:
            belongTo(scene, part)
        for constraint in self._constraints:
            constraint._bind(scene)
        for engine in sorted(engines, key=lambda e: isinstance(e, Callback)):  # which look at the others
            engine.bind(scene)
        scene._core.setConstraints([c._core for c in self._constraints])
        scene._core.setEngines([e._core for e in engines])
        scene._core.prepare()
        self._chain = list(engines)
        for engine in engines:
            engine._markBound()

    # --- time step ------------------------------------------------------------------------------------
    @property
    def dt(self):
        """Length of the next step, s; to be set by a loop that chooses it within `scene.dtCritical`."""
        return self._scene._core.dt

    @dt.setter
    @_holding
    def dt(self, value):
        if not (isNumber(value) and 0 < value < math.inf):
            raise ValueError(f"Stepper: dt = {value!r} s is not allowed; give a positive number")
        self._scene._core.dt = float(value)

    fullDt = property(
        lambda self: self._fullDt or self.dt, doc="Length of the steps, s; of those at the end of a run, too."
    )

    @_holding
    def checkTimeStep(self):
        """Estimates the critical step; takes a share of it if dt was left out, refuses a dt above the longest
        stable step otherwise."""
        scene, given = self._scene, self._scene._dt
        scene._core.threads = scene.threads
        isAllowed = given is not None and scene.allowUnstable
        critical = None if isAllowed and scene.dtCritical is not None else self.estimateCriticalStep()
        if given is None:
            if not critical > 0:
                raise ValueError(
                    "Scene: no critical time step can be found (every node is held, every body is "
                    "implicit, or none has particles); give scene.dt"
                )
            self.takeSafeDt()
        elif not isAllowed and critical > 0 and given > scene.dtStable:
            raise ValueError(
                f"dt = {given:.3g} s exceeds the longest stable step {scene.dtStable:.3g} s of this scene "
                f"(stiffest: '{scene.stiffest}'{self._leftOut()}); lower dt, raise inertiaScale, coarsen the "
                "grid, or make a stiff body implicit"
            )
        else:
            if not isAllowed and _sharesImplicit(scene) and given > limits.DT_SHARED * scene.dtStable > 0:
                good = limits.DT_STABLE["USL"] * scene.dtStable
                warnUser(
                    f"Scene: dt = {given:.3g} s is {given / scene.dtStable:.2g} of the longest stable step; "
                    "beside an implicit body bonded to others that falls to half where soil pokes over "
                    f"a line of the grid: give {good:.3g} s, or leave dt out"
                )
            self.dt = given
            self._warnOfCells()
        self.noteEstimate()

    def _warnOfCells(self):
        fast = self.speedDt()
        if self.dt > 2 * fast:
            warnUser(
                f"Scene: with dt = {self.dt:.3g} s something moves {limits.DT_CELLS * self.dt / fast:.2g} "
                f"of a cell in a step, and impacts make energy; give at most {fast:.3g} s, or leave dt out"
            )

    def _leftOut(self):
        names = [f"'{body.name}'" for body in self._scene.bodies if body.implicit]
        return f"; implicit and left out: {', '.join(names)}" if names else ""

    def noteEstimate(self):
        """The step follows the estimate just made; growth counts from here."""
        self._estimatedStiffness = stiffnesses(self._scene)
        keep(self, estimatedAt=self._scene.steps)
        self.noteChecked()

    def noteChecked(self):
        """The time step suits the scene as it stands."""
        self._isStable, self._checkedState = True, self._stabilityState()

    @_holding
    @takes(tolerance=POSITIVE, iterations=COUNT, asIfExplicit=FLAG)
    def estimateCriticalStep(self, tolerance=1e-4, iterations=300, asIfExplicit=False):
        """Critical step of the scene as it stands, s; sets scene.dtCritical and scene.stiffest.

        Parameters
        ----------
        tolerance : float, relative change over ten iterations at which to stop; default 1e-4.
        iterations : int, most iterations; default 300.
        asIfExplicit : bool, count the stiffness of implicit bodies, and set nothing; default False.
        """
        self._prepareChain()
        scene = self._scene
        found = scene._core.criticalTimeStep(tolerance, iterations, asIfExplicit)
        if asIfExplicit:
            return found["dt"]
        keep(scene, dtCritical=found["dt"], dtStable=found["longestStable"])
        keep(scene, _dtIterations=found["iterations"], stiffest=found["stiffest"])
        return scene.dtCritical

    def stiffening(self):
        """Bound on what the square of the fastest frequency has grown by since the last estimate, 1 at least.

        Each particle adds V (K A + mu B) / m to that of the whole, with A and B that have no negative
        eigenvalue: none can grow by more than the largest ratio, now to then, of K V/V0 and of mu V/V0, with
        K and mu of the particle as it stands.
        """
        return max([1.0, *(growth for bulk, shear, _ in self._ratios() for growth in (bulk, shear))])

    def refining(self):
        """What the number of particles has grown by since the last estimate, where most; 1 at least."""
        return max([1.0, *(count for _, _, count in self._ratios())])

    def growthLimits(self):
        """What bodies may become before `stiffening` or `refining` reach DT_GROWTH, a little less: for each
        body the bulk and the shear modulus of `core.presentStiffness`, and the number of particles."""
        scene, share, found = self._scene, limits.DT_GROWTH * (1 - 1e-9), []
        blend = _blend(scene)
        for body in scene.bodies:
            if not scene.dtCritical or body.name not in self._estimatedStiffness:
                found.append((math.inf, math.inf, math.inf))  # nothing to go by
                continue
            bulk, shear, count = self._estimatedStiffness[body.name]
            scale = share * body.inertiaScale / blend
            found.append((scale * bulk, scale * shear, share * count))
        return found

    def _ratios(self):
        """Of `stiffnesses`, now to then, for each body that there was."""
        then = self._estimatedStiffness
        for name, now in stiffnesses(self._scene).items():
            if name in then:
                yield [b / a if a > 0 else 1.0 if b == 0 else math.inf for b, a in zip(now, then[name])]

    @_holding
    @takes(growth=POSITIVE)
    def takeSafeDt(self, growth=1.0):
        """Steps by the share of the critical step that is taken where nobody has given dt, from now on.

        Parameters
        ----------
        growth : float, of the square of the fastest frequency since the estimate, -; default 1.
        """
        law = "USL" if _sharesImplicit(self._scene) else self._scene.scheme
        safe, longest = self.safeDt(), limits.DT_STABLE[law] * self._scene.dtStable / math.sqrt(growth)
        keep(self, automaticDt=min(safe, longest))
        self.followSpeed()

    def speedDt(self):
        """The step in which what moves fastest, a particle or a prescribed motion, moves DT_CELLS of the
        smallest cell, s."""
        scene = self._scene
        speeds = [np.abs(body.velocity).max(axis=0) for body in scene.bodies if body.count]
        speeds += [np.abs(np.nan_to_num(c._core.velocity)) for c in self._constraints]
        rate = np.max(speeds / np.array(scene.cell)) if speeds else 0.0
        return limits.DT_CELLS / rate if rate > 0 else math.inf

    def followSpeed(self):
        """Steps by the automatic step, or a shorter one that suits the speed."""
        self.dt = min(self.automaticDt, self.speedDt())

    def safeDt(self):
        """The share of the critical step that is taken where nobody has given dt, s."""
        if self._scene.dtCritical is None:
            raise RuntimeError("Stepper: the critical time step is not known yet; call scene.prepare()")
        return limits.DT_SAFETY[self._scene.scheme] * self._scene.dtCritical

    @property
    def isBounded(self):
        """Whether `stiffening` bounds all that has changed since the time step was checked."""
        return self._isStable and self._checkedState[1:] == self._stabilityState()[1:]

    def _stabilityState(self):
        """What the critical step depends on and may be changed between steps; first what `stiffening`
        bounds."""
        scene = self._scene
        stages = [e for e in scene.engines if not isinstance(e, Callback)]
        numbers = [(tuple(b.material.lameConstants), b.inertiaScale) for b in scene.bodies]
        numbers += [getattr(e, name) for e in stages for name in BLENDS.get(type(e).__name__, ())]
        kinds = [(type(e).__name__, e.dead) for e in stages]
        return numbers, kinds, [b.implicit for b in scene.bodies], scene._dt, scene.allowUnstable

    # --- steps ----------------------------------------------------------------------------------------
    def advance(self, steps, seconds=UNLIMITED):
        """Takes steps; Ctrl-C and other signals come through between two of them.

        Parameters
        ----------
        steps : int, how many at most.
        seconds : float, s of wall time after which to return behind a step; default: no limit.

        Raises RuntimeError for a scene that is not prepared as it stands, in a callback, and where another
        thread is at work with the scene; and what a step raises.
        """
        self._refuseUnprepared("advance")
        isWhole = isinstance(steps, (int, np.integer)) and not isinstance(steps, bool)
        if not (isWhole and steps >= 0 and isNumber(seconds)):
            raise ValueError(
                f"Stepper.advance: steps = {steps!r}, seconds = {seconds!r} is not allowed; give a whole "
                "number from 0 on, and a wall time in s"
            )
        with self._alone("advance"):
            began, advance = time.monotonic(), self._scene._core.advance
            taken = advance(steps, min(seconds, SLICE))
            while taken < steps and (left := seconds - (time.monotonic() - began)) > 0:
                taken += advance(steps - taken, min(left, SLICE))

    def advanceShort(self, dt):
        """Takes one step that is shorter than the others, s."""
        self._fullDt, self.dt = self.dt, dt
        try:
            self.advance(1)
        finally:
            self.dt, self._fullDt = self._fullDt, None

    def act(self, engine):
        """Lets one engine of the chain act; the clock stands still until `endStep`.

        Raises ValueError for an engine that is not in the chain as it was prepared, or not yet on turn, and
        RuntimeError as `advance`.
        """
        if not any(engine is other for other in self._chain or ()):
            raise ValueError(
                f"Stepper.act: {engine!r} is not in the chain as it was prepared; call scene.prepare() and "
                "give one of scene.engines"
            )
        self._refuseUnprepared("act")
        with self._alone("act"):
            self._scene._core.actAlone(engine._core)

    @contextmanager
    def _alone(self, what):
        """One thread at a time steps the scene, and never from within a step."""
        with self._scene._holder.held(what):
            if self._isStepping:
                raise RuntimeError(
                    f"Stepper.{what}: a step is going on; a callback cannot step the scene, nor set its clock"
                )
            self._isStepping = True
            try:
                yield
            finally:
                self._isStepping = False

    @takes(engine=ENGINE)
    def actOf(self, engine):
        """A function that lets one engine of the chain act, for those who call it in every step."""
        actAlone, core = self._scene._core.actAlone, engine._core
        refuseOthers = self._scene._holder.refuseOthers

        def act():
            refuseOthers("Stepper.act")
            actAlone(core)

        return act

    def endStep(self, time):
        """The end of a step that was taken engine by engine; sets the clock, s."""
        time = _asTime("endStep", time)
        with self._alone("endStep"):
            self._scene._core.endStep(time)

    def setTime(self, time):
        """Sets the clock between two steps, s: to that of the program that owns it."""
        time = _asTime("setTime", time)
        with self._alone("setTime"):
            self._scene._core.time = time

    def isMidStep(self):
        """Whether a callback is at work between two stages of a step, where the state is neither old nor
        new."""
        done, left = self._stagesDone()
        return bool(left) and any(type(e).__name__ != "ParticleToGrid" for e in done)

    def isBetweenStages(self):
        """Whether a callback is at work behind a stage of a step, the first included, and before another:
        the nodes hold sums of the particles as they are."""
        done, left = self._stagesDone()
        return bool(done and left)

    def _stagesDone(self):
        """Stages of the step behind and before the callback that is at work; none where there is no one."""
        engines = self._scene.engines if self.acting is not None else []
        stages = [e for e in engines if not isinstance(e, Callback) and not e.dead]
        before = engines[: engines.index(self.acting)] if self.acting in engines else []
        done = [e for e in stages if e in before]
        return done, [e for e in stages if e not in done]


def _require(isRight, name, value, allowed):
    if not isRight:
        raise ValueError(f"Stepper.restore: {name} = {value!r} is not allowed; give {allowed}")


def _asTime(what, time):
    if not (isNumber(time) and 0 <= time < math.inf):
        raise ValueError(f"Stepper.{what}: time = {time!r} is not allowed; give zero or a positive time, s")
    return float(time)


def stiffnesses(scene):
    """What the square of the fastest frequency is proportional to: by the name of a body the largest present
    bulk and shear modulus, kPa, times V/V0, over the factor on inertia, with flip and damping; where cells
    differ, times the mean square of the smallest cell of the grid over that of the particle; and the number
    of particles."""
    blend, found = _blend(scene), {}
    for body, moduli in zip(scene.bodies, scene._core.presentStiffness()):
        factor = blend / body.inertiaScale
        found[body.name] = [*(factor * modulus for modulus in moduli), float(body.count)]
    return found


def _sharesImplicit(scene):
    """Whether implicit bodies are bonded to others: there a law like that of USL holds."""
    isApart = any(type(e).__name__ == "Contact" and not e.dead for e in scene.engines)
    groups = [
        {body.group if isApart else "" for body in scene.bodies if body.implicit == flag}
        for flag in (True, False)
    ]
    return bool(groups[0] & groups[1])


def _blend(scene):
    """Factor of damping and flip."""
    blend = 1.0
    for engine in scene.engines:
        kind = type(engine).__name__
        blend *= 1 + engine.damping if kind == "GridSolver" else 1.0
        blend *= 2 / (1 + engine.flip) if kind == "GridToParticle" else 1.0
    return blend
