# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps of a scene, for the loop that owns the clock: `Scene.run`, `Scene.step`, or another program."""

import copy
import math
import time
from contextlib import contextmanager

from ..base.attributes import Guarded, keep
from ..base.kinds import ENGINE, NOT_NEGATIVE, WHOLE, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..check import limits
from ..check.bending import actions, thinBeams
from ..check.domains import checkFields, checkInterface
from ..check.mistakes import likelyMistakes, stiffContacts
from ..diagnostics.balance import kineticEnergy
from ..engine import chain
from ..engine.callback import Callback
from ..engine.engine import belongTo
from ..engine.gridSolver import GridSolver
from ..geometry.numbers import isNumber
from . import axial, choices
from .timeStep import TimeStep, holding

UNLIMITED = 1e9  # s of wall time: no limit
SLICE = 0.1  # s of wall time between looks at signals


class Stepper(TimeStep, Guarded):
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
            raise TypeError(f"Stepper: onChange = {shown(function)} is not allowed; give a function, or None")
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

    @holding
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

    @holding
    def prepare(self):
        """Checks the scene and gives the chain to the solver; see `Scene.run` for what is refused."""
        scene = self._scene
        self._prepareChain()
        for body in scene.bodies:
            checkFields(body)
        if scene.steps == 0:
            keep(scene, _startEnergy=kineticEnergy(scene))
            for mistake in likelyMistakes(scene, scene._gridSolver("prepare").gravity):
                warnUser(mistake)
        self._warnOfThinBeams()
        checkInterface(scene, limits.INTERFACE_BUILD if scene.steps == 0 else limits.INTERFACE_RUN)
        if not self.isChecked:
            self.checkTimeStep()
            for text in stiffContacts(scene) if scene.steps == 0 else ():
                warnUser(text)
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
        axial.refuseUndone(scene)
        choices.update(scene, isFinal=True)
        if self._isStepping and engines != self._chain:
            raise RuntimeError(
                "Scene: a step is going on; a callback cannot change the engines: pause() first"
            )
        chain.dropFaded(engines)
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

    fullDt = property(
        lambda self: self._fullDt or self.dt, doc="Length of the steps, s; of those at the end of a run, too."
    )

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
        if not (WHOLE.isOne(steps) and steps >= 0 and isNumber(seconds)):
            raise ValueError(
                f"Stepper.advance: steps = {shown(steps)}, seconds = {shown(seconds)} is not allowed; give a "
                "whole number from 0 on, and a wall time in s"
            )
        with self._alone("advance"):
            began, advance = time.monotonic(), self._scene._core.advance
            taken = advance(steps, min(seconds, SLICE))
            while taken < steps and (left := seconds - (time.monotonic() - began)) > 0:
                taken += advance(steps - taken, min(left, SLICE))

    def advanceShort(self, dt):
        """Takes one step that is shorter than the others, s."""
        self._fullDt, self.dt = self.dt, dt
        for contact in (e for e in self._scene.engines if type(e).__name__ == "RigidContact"):
            contact._core.set("longestStep", max(contact.longestStep, self._fullDt))
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
                f"Stepper.act: {shown(engine)} is not in the chain as it was prepared; call scene.prepare() "
                "and give one of scene.engines"
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
        raise ValueError(f"Stepper.restore: {name} = {shown(value)} is not allowed; give {allowed}")


def _asTime(what, time):
    NOT_NEGATIVE.check(f"Stepper.{what}", "s", time=time)
    return float(time)
