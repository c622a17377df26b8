# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene on YADE's clock: what it does in every DEM step."""

import json
import os

from ..engine.callback import Callback
from ..engine.rigidContact import RigidContact
from ..io.files import checkWritable
from ..scene.policy import LoopPolicy
from ..scene.rescue import Rescue
from ..scene.saving import save
from . import checkpoints, loop
from .bodies import Bodies
from .clock import Clock
from .drawing import Drawing, drawersIn, drawSoil
from .engineList import EngineList
from .exchanges import checkExchanges, checkRead
from .grants import Grants
from .gravity import difference
from .output import PlotRows, checkpointOf, tagOf, tagRecorders
from .results import Energies, Materials, interactionsOf, unbalancedForce
from .stages import Stages
from .timeStep import TimeStep, steppersIn
from .views import Views


class Coupling(Views):
    """A scene on YADE's clock, as `attach` returns it.

    Attributes
    ----------
    scene : the scene (read only, as are the others but for plot and exchanges).
    label, mpmSteps, demSteps, stages : as given to `attach`.
    engines : its engines in O.engines, in order.
    plot : whether new rows of histories go to yade.plot; or names of the columns that do.
    timeOffset : s, scene.time - O.time; 0 unless one of the two clocks was ahead when the scene was attached.
    cycle : s, duration of the MPM steps of a cycle as they are taken.
    maxDt : s, largest O.dt that the scene wants: its own step (scene.dt, or a share of the critical step:
        0.8, USL 0.55) times mpmSteps / demSteps.
    criticalDt : s, O.dt above which a step is refused; infinite with scene.allowUnstable.
    runs : number of runs of YADE so far in which it acted.
    error : what ended the run, or None. Attach the scene again then.
    checkpointPeriod : s of wall time between checkpoints, as given to `attach`; None: there are none.
    stepsSaved : number of MPM steps that the last checkpoint holds.
    exchanges : list of objects with read(coupling) and apply(coupling), for coupling with bodies of YADE.
        `read` is called before the MPM takes its step or steps, when both sides are at the same time; `apply`
        in every DEM step after that and before the NewtonIntegrator (YADE forgets forces after every step).
    """

    def __init__(self, omega, scene, mpmSteps, demSteps, stages, label, plot, saved, bodies):
        self._omega, self.scene, self.label, self.plot = omega, scene, label, plot
        self.mpmSteps, self.demSteps, self.stages = mpmSteps, demSteps, stages
        self.error, self.runs, self.checkpointPeriod = None, 0, None
        isKept = bodies is None
        self.exchanges = _exchangesOf(scene) if isKept else bodies
        self._isAtWork = False  # on this scene
        self._isAtRisk = False  # whether an error may have left the scene in another state than it was
        self._isFresh = False  # whether a run has begun in which we have not acted yet
        self._isFirstCycle = False  # of a run
        self._toldOfGravity = None  # how that of YADE differed, when it was compared last
        self.kept = self.exchanges[:] if isKept else []  # from the last time that the scene was attached
        self._list = EngineList(omega, label)
        self._refuseUnfit()
        scene.prepare()
        self._loop = loop.LoopOfYade(self, omega)
        scene._handOver(self._loop)
        self._rescue = Rescue(scene, f"{omega.tags['id']}.{label}.h5")
        self._policy = LoopPolicy(scene, loop.warn, stride=mpmSteps, followsSpeed=False)
        self._chain = scene.engines
        self._energies = Energies(omega, scene, label)
        self._rows = PlotRows(self._chain, areAllNew=bool(saved))
        tagRecorders(self._chain, omega.tags)
        self._grants = Grants(scene, mpmSteps, demSteps)
        self._clock = Clock(omega, scene, mpmSteps, demSteps, saved, self._grants)
        self._isMpmStep = False  # whether it acts in this DEM step
        self._timeStep = TimeStep(omega, scene, mpmSteps, demSteps, label, saved)
        if self._clock.cycleEnd <= omega.iter:
            self._timeStep.govern()
        self._list.make(scene, stages)
        self._stages = Stages(scene, self._list.engines, self._endStep)
        self._grants.serve(self._list.engines)
        scene.stepper.onChange = self._grants.revoke
        self.stepsSaved = scene.steps
        if isKept:
            self.exchanges += [Bodies(self._chain[place], **spec) for place, spec in saved.get("bodies", ())]
        for drawer in drawersIn(omega, label):
            drawSoil(self, drawer)

    def __repr__(self):
        ratio = (
            f"{self.mpmSteps} MPM steps per DEM step"
            if self.demSteps == 1
            else f"{self.demSteps} DEM steps per MPM step"
        )
        return f"<{self.label}: {self.scene!r} in YADE, {ratio}>"

    engines = property(lambda self: list(self._list.engines), doc="Its engines in O.engines.")
    cycle = property(
        lambda self: self.scene.stepper.dt * self.mpmSteps,
        doc="Duration of the MPM steps of a cycle as they are taken, s; scene.dt is the largest one allowed.",
    )
    timeOffset = property(lambda self: self._clock.timeOffset, doc="scene.time - O.time, s.")
    maxDt = property(lambda self: self._timeStep.maxDt, doc="Largest O.dt that the scene wants, s.")
    criticalDt = property(
        lambda self: self._timeStep.criticalDt, doc="O.dt above which a step is refused, s."
    )
    materials = property(
        lambda self: Materials(self.scene), doc="Materials of the scene, by number or name of a body."
    )
    interactions = property(
        lambda self: [
            i for e in self.exchanges if isinstance(e, Bodies) for i in interactionsOf(e, self.scene)
        ],
        doc="Contacts of bodies of YADE with the soil, as of O.interactions; see `results`.",
    )
    unbalancedForce = unbalancedForce
    isActing = property(
        lambda self: self._isAtWork and loop.thread.isMine(),
        doc="Whether the caller is a callback of the scene.",
    )

    def _refuseUnfit(self):
        self._refusePeriodic()
        if steppersIn(self._list.others[self._list.place :]):
            raise ValueError(
                "inYade: a time stepper stands behind the place of the MPM engines and would change O.dt in "
                "the middle of a step; put it before the NewtonIntegrator"
            )
        self.scene._refuseWhileRunning("attach")
        if any(isinstance(e, RigidContact) and not e._frictions() for e in self.scene.engines):
            raise ValueError(
                "inYade: a RigidContact of the scene has no rigid bodies; make "
                "mpm.yade.Bodies(contact, ids) before"
            )

    # --- runs of YADE -----------------------------------------------------------------------------------
    def beginRun(self):
        """Called before a run of YADE: refuses what can be seen before the first step."""
        if self.error is None:
            self._refuseUnfitRun()
            if self.scene.stepper.isReady and self._clock.cycleEnd <= self._omega.iter:
                self._timeStep.lookForSteppers()
                self._timeStep.checkBefore()

    def refuseLost(self):
        """Behind a run: RuntimeError where O.engines has lost engines of ours."""
        if self.error is None:
            self._list.refuseLost()

    def noteRun(self):
        """Called in the first step of a run of YADE."""
        self._isFresh = True

    def _refusePeriodic(self):
        if self._omega.periodic:
            raise ValueError(
                f"yade: YADE's cell is periodic, and the scene '{self.label}' is not; O.periodic = False"
            )

    def _refuseUnfitRun(self):
        self._refusePeriodic()
        checkExchanges(self)
        bodies = [e for e in self.exchanges if isinstance(e, Bodies)]
        self._list.check(haveBodies=bool(bodies))
        text = difference(self._omega.engines, self.scene, bodies[0].plane if bodies else None)
        if text is not None and text != self._toldOfGravity:
            loop.warn(f"warning: '{self.label}': {text}")
        self._toldOfGravity = text

    def isInStep(self):
        """Whether YADE is in a step that the scene has begun; from YADE's thread."""
        return self._clock.isInStep()

    def checkDt(self, dt):
        """Raises ValueError for a DEM step that the scene cannot take, s."""
        if self.error is None:
            self._timeStep.check(dt)

    def detach(self):
        """Takes the engines out of O.engines; the scene goes on by its own loop, and may be attached again.

        O.dt and maxDt become what they would be without the scene. Raises RuntimeError while YADE runs.
        """
        if self._omega.running:
            raise RuntimeError("detach: YADE is running; O.pause() first")
        loop.thread.waitForEnd()
        self.flush()
        self._list.remove()
        checkpoints.insert(self._omega, self.label, None)
        if loop.attached.get(self.label) is self:
            del loop.attached[self.label]
        self.letGo()

    def letGo(self):
        """Gives O.dt and the scene back, and notes the exchanges for `attach`."""
        loop.kept[self.scene] = [e for e in self.exchanges if not isinstance(e, Drawing)]
        for drawing in self._drawings():
            drawing.clear()
        self._grants.release()
        self.scene.stepper.onChange = None
        self._timeStep.release()
        if self.scene._loop is self._loop:
            self.scene._handOver(None)

    # --- the step ---------------------------------------------------------------------------------------
    def actOf(self, number, act):
        """A function that acts as `act` does, both without argument; quicker where nothing is due."""
        return self._grants.actOf(number, self._omega, loop.dt.now, act)

    def act(self, number):
        """Takes the steps of the scene in this DEM step, or its stage `number`; an error is noted, and raised
        behind the step."""
        if self.error is not None:
            loop.beginStep(self._omega)
            if not loop.errors:
                loop.errors.append(
                    RuntimeError(f"'{self.label}' was stopped by an error ({self.error}); attach it again")
                )
            return
        isNewStep = self._omega.iter != self._clock.iteration
        if isNewStep and self._omega.subStep < 0:
            raise RuntimeError(f"an engine of '{self.label}' acts in the loop of YADE only; call O.step()")
        self._isAtWork = True
        try:
            self._throwOfGranted()
            if isNewStep:
                self._beginStep()
            if self._isMpmStep:
                self._isAtRisk = True
                if number is None:
                    self._takeSteps()
                else:
                    self._stages.act(number)
        except BaseException as error:
            self._fail(error)
        self._isAtWork = False

    def _throwOfGranted(self):
        """Raises what has gone wrong in a step that was granted."""
        self._isAtRisk = True
        self._grants.throwError()

    def _beginStep(self):
        """Once in every DEM step, before anything else of ours."""
        self._isAtRisk = False
        self._grants.noteStep()
        self._clock.noteStep()
        if self._stages.isOpen:  # the last stage was switched off during the step
            self._stages.close()
        self._forward()
        loop.beginStep(self._omega)
        self._energies.note()
        self._clock.refuseStepBack()
        self._isMpmStep = self._clock.isAtCycleEnd
        if self._isMpmStep:
            self._beginCycle()
        else:  # the MPM is ahead
            self._timeStep.keep()
            self._apply()

    def _beginCycle(self):
        """Both sides are at the same time: checks, time step, and the states of bodies."""
        self._checkScene()
        self._clock.meet()
        if self._dueChecks():
            self._timeStep.setLimits()
            if self.scene._dt is None:
                self._timeStep.govern()
        self._clock.beginCycle(self._timeStep.choose())
        isFirst, self._isFirstCycle = self._isFirstCycle, False
        for exchange in self.exchanges:
            exchange.read(self)
        if isFirst:
            checkRead(self)

    def _dueChecks(self):
        """What is due between steps; an error there is the scene's, not a mistake of the user."""
        self._isAtRisk = True
        self._policy.noteLooks(self._grants.nextLook)
        isChanged = self._policy.followChanges()
        isEstimated = self._policy.beforeSteps()
        self._isAtRisk = False
        return isChanged or isEstimated

    def _checkScene(self):
        scene = self.scene
        if scene.engines is not self._chain:
            raise RuntimeError(f"scene.engines of '{self.label}' was changed; call mpm.inYade(scene) again")
        self._clock.refuseForeignSteps(self.label)
        scene._handOver(self._loop)
        if self._isFresh or not scene.stepper.isPrepared:
            self._beginOfRun()

    def _beginOfRun(self):
        """Once in every run of YADE, and where something of the scene has changed."""
        self._isFresh, self._isFirstCycle = False, True
        self.runs += 1
        self._timeStep.lookForSteppers()
        self._refuseUnfitRun()
        if not self.scene.stepper.isReady:
            self.scene.prepare()
            tagRecorders(self._chain, self._omega.tags)
            self._timeStep.setLimits()
            self._timeStep.govern()

    def _takeSteps(self):
        stepper = self.scene.stepper
        for _ in range(self.mpmSteps):
            stepper.advance(1)
        stepper.setTime(self._clock.end)  # the sum of MPM steps may differ by rounding
        self._clock.noteSteps()
        self._apply()
        self._grant(lastStage=-1)

    def _endStep(self):
        """The end of a step that was taken stage by stage."""
        self.scene.stepper.endStep(self._clock.end)
        self._clock.noteSteps()
        self._apply()
        self._grant(lastStage=self._stages.last)

    def _grant(self, lastStage):
        """The steps in which nothing is due may be taken without us."""
        looks = [e.cyclesToLook(self) for e in self.exchanges if hasattr(e, "cyclesToLook")]
        steps = self._policy.cyclesToNext(self.mpmSteps)
        steps = min(steps, self._energies.stepsToNext(), *looks) if self.error is None else 0
        look = self._policy.nextLook, self._policy.lookPeriod, self.scene.stepper.growthLimits
        self._grants.grant(
            self._omega, steps, self._clock, self._timeStep.dt, lastStage, self.exchanges, look
        )

    def _apply(self):
        for exchange in self.exchanges:
            exchange.apply(self)

    def _fail(self, error):
        self.error = error
        loop.errors.append(error)
        loop.pauseAfterStep(self._omega)
        if self._isAtRisk:  # not for a mistake that was noticed before the step
            self._rescue.saveFailed(error)
        self._stages.abandon()

    # --- results ----------------------------------------------------------------------------------------
    def _forward(self):
        """New rows of histories to yade.plot."""
        if self.plot:
            chosen, self.plot = self.plot, False  # in case of an error
            self._rows.forward(self._clock.iterationOf, self.timeOffset, None if chosen is True else chosen)
            self.plot = chosen

    def flush(self):
        """Writes rows and frames that are not in the files yet; O.run, O.step, O.wait and O.save do it."""
        self._forward()
        self._energies.note(isDue=True)
        for engine in self._chain:
            if isinstance(engine, Callback) and engine._isBound:
                engine.flush()
        for drawing in self._drawings():
            drawing.catchUp()

    def saveBeside(self, file, isBeside=True):
        """Writes our checkpoint that goes with a file of O.save, and notes in O.tags what attach() needs.

        isBeside : bool, whether YADE's own file stands in the same folder, wherever that goes.
        """
        if self.error is not None:
            raise RuntimeError(
                f"O.save: '{self.label}' was stopped by an error ({self.error}); detach() it to save YADE "
                "alone"
            )
        name = checkpointOf(file, self.label)
        checkWritable(name)
        self.flush()
        self._grants.unfold()  # YADE's file has every engine as it is
        bodies = [(self._chain.index(e.contact), e.spec()) for e in self.exchanges if isinstance(e, Bodies)]
        how = dict(mpmSteps=self.mpmSteps, demSteps=self.demSteps, stages=self.stages, bodies=bodies)
        how["checkpointPeriod"] = self.checkpointPeriod
        how["file"] = os.path.basename(name) if isBeside else name
        noted = {**how, **self._clock.noted(), **self._timeStep.noted()}
        self._omega.tags[tagOf(self.label)] = json.dumps(noted)
        save(self.scene, name)
        self.stepsSaved = self.scene.steps


def _exchangesOf(scene):
    """Exchanges that a scene had when it was attached last, but for bodies of a contact that it lost."""
    kept = loop.kept.get(scene, ())
    return [e for e in kept if not isinstance(e, Bodies) or any(e.contact is c for c in scene.engines)]
