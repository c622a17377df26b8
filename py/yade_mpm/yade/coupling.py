# SPDX-License-Identifier: GPL-2.0-or-later
"""Inside YADE: the engines of a scene become engines of O.engines, on one clock with the discrete elements.

    from yade_mpm import inYade
    soil = inYade.attach(scene)   # adds engines before the NewtonIntegrator, chooses O.dt
    O.run(1000, True)

YADE is used through its Python interface only. An engine of ours is a PyRunner whose command is `inYade.act(...)`.
"""

import builtins
import json
import math
import os
import re
import sys
import threading

from ..base import limits
from ..engine.callback import Callback
from ..engine.rigidContact import RigidContact
from ..io import checkpoint
from ..io.files import checkWritable
from ..io.history import History
from ..io.recorder import Recorder
from ..scene.restoring import load
from ..scene.run import Run
from ..scene.scene import Scene
from . import loop as yadeLoop
from .bodies import Bodies, checkExchanges  # for users: inYade.Bodies

FRESH_DT = 1e-8  # s, O.dt of a YADE that nobody has told anything
DEM_SAFETY = 0.8  # share of PWaveTimeStep taken when O.dt is left alone


def attach(scene=None, mpmSteps=None, demSteps=None, stages=None, label="mpm", plot=False, callbacks=None):
    """Makes the engines of a scene engines of O.engines, before the NewtonIntegrator (at the end if there is none).

    Parameters
    ----------
    scene : `yade_mpm.Scene`. Left out after O.load: the scene from the checkpoint beside the loaded file.
    mpmSteps : MPM steps in one DEM step; default 1 (after O.load: as saved).
    demSteps : DEM steps in one MPM step; default 1 (likewise). One of the two is 1.
    stages : True: one engine per stage, which YADE times and switches off (`dead`) one by one; False: the whole chain as
        one engine, which is faster for small scenes. Default: True unless mpmSteps > 1, which needs False.
    label : of the engine, or the start of the labels of the engines, e.g. "mpm_GridSolver"; default "mpm". Two scenes
        need two.
    plot : pass new rows of every `History` of the scene to yade.plot.addData, with `i` and `t`; default False.
    callbacks : as for `yade_mpm.load`, where the checkpoint needs functions; only without `scene`.

    Returns the `Coupling`. A scene that was attached under the same label before is replaced.

    O.dt becomes the smaller of what the scene needs and of what the discrete elements need: O.dt if it was set, else
    0.8 PWaveTimeStep. `maxDt` of a time stepper in O.engines is set likewise.

    Raises ImportError without YADE, TypeError and ValueError for arguments that are not allowed, ValueError for a
    time stepper behind the engines, what `Scene.prepare` raises, and RuntimeError while YADE runs.
    """
    O = yadeLoop.omega()
    if O.running:
        raise RuntimeError("inYade.attach: YADE is running; O.pause() and O.wait() first")
    if not (isinstance(label, str) and label.isidentifier()):
        raise ValueError(
            f"inYade.attach: label = {label!r} is not allowed; give letters, digits and underscores, e.g. 'mpm'"
        )
    saved = {}
    if scene is None:
        scene, saved = _fromTag(O, label, callbacks)
    elif callbacks is not None:
        raise ValueError(
            "inYade.attach: callbacks go with a checkpoint; leave them out where the scene is given"
        )
    if not isinstance(scene, Scene):
        raise TypeError(f"inYade.attach: scene = {scene!r}; give a yade_mpm.Scene")
    for other in yadeLoop.attached.values():
        if other.scene is scene and other.label != label:
            raise ValueError(
                f"inYade.attach: this scene is attached as '{other.label}' already; detach() it there"
            )
    mpmSteps = saved.get("mpmSteps", 1) if mpmSteps is None else _count("mpmSteps", mpmSteps)
    demSteps = saved.get("demSteps", 1) if demSteps is None else _count("demSteps", demSteps)
    if mpmSteps > 1 and demSteps > 1:
        raise ValueError(
            f"inYade.attach: mpmSteps = {mpmSteps}, demSteps = {demSteps}; one of the two has to be 1"
        )
    stages = saved.get("stages", mpmSteps == 1) if stages is None else bool(stages)
    if stages and mpmSteps > 1:
        raise ValueError(
            "inYade.attach: engines per stage cannot act several times in a DEM step; give stages=False "
            "(scene.timing() still tells the time of each stage)"
        )
    yadeLoop.waitForStep(O)
    yadeLoop.errors.clear()
    if label in yadeLoop.attached:
        yadeLoop.attached.pop(label)._letGo()
    coupling = Coupling(O, scene, mpmSteps, demSteps, stages, label, bool(plot), saved)
    yadeLoop.attached[label] = coupling
    builtins.inYade = sys.modules[
        __name__
    ]  # where the commands of the engines find it, wherever it was imported
    yadeLoop.wrapOmega(type(O))
    yadeLoop.signals.install()
    return coupling


def act(label, number=None):
    """What an engine of ours does: the whole step, or stage `number`. Never raises; an error pauses YADE and is raised
    after the step."""
    coupling = yadeLoop.attached.get(label)
    if coupling is not None:
        coupling._act(number)
    elif not yadeLoop.errors:
        message = f"inYade: no scene is attached as '{label}'; after O.load call inYade.attach()"
        print(message, file=sys.stderr)
        yadeLoop.errors.append(RuntimeError(message))
    if yadeLoop.errors:
        yadeLoop.pauseAfterStep(yadeLoop.omega())


def checkpointOf(file, label="mpm"):
    """Name of our checkpoint that goes with a file of O.save."""
    return f"{os.fspath(file)}.{label}.h5"


class Coupling:
    """A scene on YADE's clock, as `attach` returns it.

    Attributes
    ----------
    scene : the scene (read only, as are the others but for plot and exchanges).
    label, mpmSteps, demSteps, stages : as given to `attach`.
    engines : its engines in O.engines, in order.
    plot : whether new rows of histories go to yade.plot.
    timeOffset : s, scene.time - O.time; 0 unless one of the two clocks was ahead when the scene was attached.
    maxDt : s, largest O.dt that the scene wants: its own step (scene.dt, or a share of the critical step: 0.8, USL 0.5)
        times mpmSteps / demSteps.
    criticalDt : s, O.dt above which a step is refused; infinite with scene.allowUnstable.
    runs : number of runs of YADE so far in which it acted.
    error : what ended the run, or None. The scene has to be attached anew then.
    exchanges : list of objects with read(coupling) and apply(coupling), for coupling with bodies of YADE. `read` is called
        before the MPM takes its step or steps, when both sides are at the same time; `apply` in every DEM step after that
        and before the NewtonIntegrator (YADE forgets forces after every step).
    """

    def __init__(self, O, scene, mpmSteps, demSteps, stages, label, plot, saved):
        self._O, self.scene, self.label, self.plot = O, scene, label, plot
        self.mpmSteps, self.demSteps, self.stages = mpmSteps, demSteps, stages
        self.error, self.exchanges = None, []
        self._thread = None  # at work on this scene
        self._loopThread = None  # in which the present run calls us
        self._fresh = False  # a run has begun
        self.runs = 0
        kept, place = self._places()
        self._steppers, self._stepperMaxDt = _steppersIn(kept), []
        if any(s in kept[place:] for s in self._steppers):
            raise ValueError(
                "inYade.attach: a time stepper stands behind the place of the MPM engines and would change O.dt "
                "in the middle of a step; put it before the NewtonIntegrator"
            )
        scene._refuseWhileRunning("attach")
        if any(isinstance(e, RigidContact) and not e.frictions() for e in scene.engines):
            raise ValueError(
                "inYade.attach: a RigidContact of the scene has no rigid bodies; make inYade.Bodies(contact, ids) before"
            )
        scene.prepare()
        scene._run = self._run = _YadeRun(self)
        self._chain = scene.engines
        self._cores = [e.core for e in self._chain]
        self._isStage = [not isinstance(e, Callback) for e in self._chain]
        # Rows that yade.plot has already: none of a loaded run.
        self._inPlot = {} if saved else {e: len(e) for e in self._chain if isinstance(e, History)}
        self._tagRecorders()
        self._estimateAt, self._checkAt = (
            _nextAt(scene.steps, limits.DT_PERIOD),
            _nextAt(scene.steps, limits.CHECK_PERIOD),
        )
        self._iter = None  # of the DEM step that has begun last
        self._cycleEnd = saved.get("cycleEnd", O.iter)  # iteration at which the MPM acts next
        self._isMpmStep, self._isOpen = (
            False,
            False,
        )  # whether it acts in this DEM step, and is between its stages
        self._end = saved.get("end", scene.time)  # scene time at the end of the cycle
        self.timeOffset = saved.get("timeOffset", scene.time - O.time)
        self._at = scene.steps, scene.time
        isFresh = O.iter == 0 and O.dt == FRESH_DT
        self._demDt = saved.get("demDt", _demStep(O) if isFresh else O.dt)  # O.dt if there were no MPM
        self._dt, self._asked = (
            saved.get("dt"),
            None,
        )  # O.dt in this cycle, and what the user has set meanwhile
        self._setLimits()
        if self._cycleEnd <= O.iter:
            self._governDt()
        self._makeEngines(kept, place)
        self._stepsSaved = scene.steps
        self.exchanges += [Bodies(self._chain[place], **spec) for place, spec in saved.get("bodies", ())]

    def __repr__(self):
        ratio = (
            f"{self.mpmSteps} MPM steps per DEM step"
            if self.demSteps == 1
            else f"{self.demSteps} DEM steps per MPM step"
        )
        return f"<{self.label}: {self.scene!r} in YADE, {ratio}>"

    engines = property(lambda self: list(self._engines), doc="Its engines in O.engines.")

    # --- engines ----------------------------------------------------------------------------------------
    def _command(self, number=None):
        return f"inYade.act('{self.label}')" if number is None else f"inYade.act('{self.label}', {number})"

    def _isOurs(self, engine):
        return getattr(engine, "command", "").startswith(self._command()[:-1])

    def _places(self):
        """The engines that are not ours, and where ours go: where they were, before the NewtonIntegrator, or at the end."""
        engines = self._O.engines
        ours = [k for k, e in enumerate(engines) if self._isOurs(e)]
        kept = [e for e in engines if not self._isOurs(e)]
        newtons = [k for k, e in enumerate(kept) if type(e).__name__ == "NewtonIntegrator"]
        return kept, ours[0] if ours else newtons[0] if newtons else len(kept)

    def _checkEngines(self):
        """RuntimeError when someone has taken our engines out of O.engines."""
        missing = len(self._engines) - sum(map(self._isOurs, self._O.engines))
        if missing > 0 and self.error is None:
            raise RuntimeError(
                f"O.engines has lost {missing} of the {len(self._engines)} engines of '{self.label}': it was assigned after inYade.attach(); "
                f"attach the scene again, behind that, or detach() it to go on without it"
            )

    def _makeEngines(self, kept, place):
        from yade.wrapper import PyRunner

        def runner(label, command):
            return PyRunner(label=label, command=command, iterPeriod=1, initRun=True, updateGlobals=False)

        if self.stages:
            names = []
            for engine in self._chain:
                name = re.sub(r"\W", "_", f"{self.label}_{engine.label or type(engine).__name__}")
                names.append(name if name not in names else f"{name}_{len(names)}")
            self._engines = [runner(name, self._command(k)) for k, name in enumerate(names)]
        else:
            self._engines = [runner(self.label, self._command())]
        self._O.engines = kept[:place] + self._engines + kept[place:]

    def detach(self):
        """Takes the engines out of O.engines; the scene goes on by its own loop, and may be attached again.

        O.dt and maxDt become what they would be without the scene. Raises RuntimeError while YADE runs.
        """
        if self._O.running:
            raise RuntimeError("detach: YADE is running; O.pause() and O.wait() first")
        yadeLoop.waitForStep(self._O)
        self.flush()
        self._O.engines = [e for e in self._O.engines if not self._isOurs(e)]
        if yadeLoop.attached.get(self.label) is self:
            del yadeLoop.attached[self.label]
        self._letGo()

    def _letGo(self):
        for stepper, own, _ in self._stepperMaxDt:
            stepper.maxDt = own
        if self._O.dt == self._dt and math.isfinite(self._demDt) and self._stepper() is None:
            self._O.dt = self._demDt
        if self.scene._run is self._run:
            self.scene._run = None

    # --- time step --------------------------------------------------------------------------------------
    def _setLimits(self):
        scene, critical = self.scene, self.scene.dtCritical or 0.0
        own = scene._dt
        if own is None:
            own = limits.DT_SAFETY[scene.scheme] * critical if critical > 0 else scene.core.dt
        self.maxDt = own * self.mpmSteps / self.demSteps
        isBounded = critical > 0 and not scene.allowUnstable
        self.criticalDt = critical * self.mpmSteps / self.demSteps if isBounded else math.inf

    def _governDt(self):
        """O.dt, and maxDt of time steppers, from the limits of both sides."""
        O, given = self._O, []
        for stepper in self._steppers:
            own = stepper.maxDt
            for known, before, after in self._stepperMaxDt:
                if known is stepper and own == after:
                    own = before  # not changed by the user since
            stepper.maxDt = min(own, self.maxDt) if own > 0 else self.maxDt
            given.append((stepper, own, stepper.maxDt))
        self._stepperMaxDt = given
        wanted = O.dt if self._stepper() is not None and O.dt != FRESH_DT else self._demDt
        O.dt = min(wanted, self.maxDt) if wanted > 0 else self.maxDt
        self._dt = O.dt

    def _stepper(self):
        """The time stepper that chooses O.dt, or None."""
        return next((s for s in self._steppers if s.active and not s.dead), None)

    def _checkDt(self):
        """O.dt as the user or a time stepper has left it; ValueError if it is too large."""
        O, dt = self._O, self._O.dt
        if dt != self._dt:
            if self._stepper() is None:
                self._demDt = dt
            elif dt > self.maxDt:
                dt = O.dt = self.maxDt
            self._dt = dt
        if not 0 < dt <= self.criticalDt * (1 + 1e-9):
            raise ValueError(
                f"O.dt = {dt:.3g} s is not allowed: the critical step of '{self.label}' is {self.criticalDt:.3g} s "
                f"(stiffest: '{self.scene.stiffest}'; {self.mpmSteps} MPM steps in {self.demSteps} DEM steps); "
                f"lower O.dt, or attach with more mpmSteps"
            )
        return dt

    # --- the step ---------------------------------------------------------------------------------------
    def _act(self, number):
        if self.error is not None:
            if not yadeLoop.errors:
                yadeLoop.errors.append(
                    RuntimeError(f"'{self.label}' was stopped by an error ({self.error}); attach it again")
                )
            return
        self._thread = self._loopThread = threading.get_ident()
        try:
            if self._O.iter != self._iter:
                self._beginStep()
            if self._isMpmStep:
                if number is None:
                    self._takeSteps()
                else:
                    self._takeStage(number)
        except BaseException as error:
            self._fail(error)
        self._thread = None

    def _beginStep(self):
        """Once in every DEM step, before anything else of ours."""
        O, core = self._O, self.scene.core
        before, self._iter = self._iter, O.iter
        if self._isOpen:  # the last stage was switched off during the step
            self._close()
        self._forward()
        if yadeLoop.signals.isPending():
            yadeLoop.pauseAfterStep(O)
        if self._iter < self._cycleEnd - self.demSteps:
            self._refuseClock()
        self._isMpmStep = self._iter >= self._cycleEnd
        if not self._isMpmStep:  # the MPM is ahead; within a cycle O.dt stays
            if O.dt != self._dt:
                if self._stepper() is None:
                    self._asked = O.dt
                O.dt = self._dt
            self._apply()
            return
        self._checkScene()
        self._checkClock(before)
        if self.scene.steps >= self._checkAt:
            self._checkAt = _nextAt(self.scene.steps, limits.CHECK_PERIOD)
            self._run._lookAtDomains(limits.INTERFACE_RUN)
        if self.scene.steps >= self._estimateAt:
            self._reestimate()
        if self._asked is not None:
            O.dt, self._asked = self._asked, None
        dt = self._checkDt()
        core.dt = dt * self.demSteps / self.mpmSteps
        end = O.time
        for _ in range(self.demSteps):  # as YADE adds up
            end += dt
        self._end = end + self.timeOffset
        self._cycleEnd = self._iter + self.demSteps
        for exchange in self.exchanges:
            exchange.read(self)

    def _checkScene(self):
        scene = self.scene
        if scene._engines is not self._chain:
            raise RuntimeError(
                f"scene.engines of '{self.label}' was changed; call inYade.attach(scene) again"
            )
        if (scene.steps, scene.time) != self._at:
            raise RuntimeError(
                f"the scene '{self.label}' has taken steps outside of YADE (it is at step {scene.steps}, YADE left "
                f"it at {self._at[0]}); call inYade.attach(scene) again"
            )
        scene._run = self._run
        if self._fresh or not scene._prepared:
            self._fresh = False
            self.runs += 1
            self._steppers = _steppersIn(self._O.engines)
            checkExchanges(self)
            if not scene._prepared or scene._checkedState != scene._stabilityState():
                scene.prepare()
                self._tagRecorders()
                self._setLimits()
                self._governDt()

    def _checkClock(self, before):
        now, core = self._O.time + self.timeOffset, self.scene.core
        if now != core.time and before is not None and self._iter == before + 1:
            self._refuseClock()
        core.time = now  # later than it was only when all engines were dead for some steps

    def _refuseClock(self):
        raise RuntimeError(
            f"the clocks differ: scene.time = {self.scene.time!r} s, O.time + timeOffset = "
            f"{self._O.time + self.timeOffset!r} s. O.time was set back, or O.dt was changed in a step after the "
            f"MPM engines; mend that, and call inYade.attach(scene) again"
        )

    def _reestimate(self):
        self._estimateAt = _nextAt(self.scene.steps, limits.DT_PERIOD)
        if self.scene._estimatedAt != self.scene.steps:
            self._run._reestimate()
        self._setLimits()
        if self.scene._dt is None:
            self._governDt()

    def _takeSteps(self):
        core = self.scene.core
        for _ in range(self.mpmSteps):
            core.advance(1, 1e9)
        core.time = self._end  # the sum of MPM steps may differ by rounding
        self._at = core.step, core.time
        self._apply()

    def _takeStage(self, number):
        """One engine of the chain. The clock stands still before the last stage that lives, and moves on behind it."""
        scene, isStage = self.scene, self._isStage[number]
        self._isOpen |= isStage
        isLast = isStage and self._isLastStage(number)
        scene._acting = self._chain[number] if self._isOpen else None
        try:
            scene.core.actAlone(self._cores[number])
        finally:
            if isLast:  # also when it raises: what ends a step at its last stage has made all of it
                self._close()
        if self._isOpen:
            scene._acting = self._chain[number + 1]

    def _isLastStage(self, number):
        """Whether no stage behind it lives."""
        for k in range(number + 1, len(self._chain)):
            if self._isStage[k] and not (self._engines[k].dead or self._cores[k].dead):
                return False
        return True

    def _close(self):
        """The end of a step that was taken stage by stage."""
        core = self.scene.core
        core.endStep(self._end)
        self._isOpen, self.scene._acting = False, None
        self._at = core.step, core.time
        self._apply()

    def _apply(self):
        for exchange in self.exchanges:
            exchange.apply(self)

    def _fail(self, error):
        self.error = error
        yadeLoop.errors.append(error)
        yadeLoop.pauseAfterStep(self._O)
        self._run._failed(error)
        self._isOpen, self.scene._acting = False, None

    # --- results ----------------------------------------------------------------------------------------
    def _forward(self):
        """New rows of histories to yade.plot."""
        if not self.plot:
            return
        from yade import plot

        for history in (e for e in self._chain if isinstance(e, History)):
            first, last = self._inPlot.get(history, 0), len(history)
            self._inPlot[history] = last
            prefix = f"{history.label}." if history.label else ""
            for row in range(first, last):
                columns = {name: column[row] for name, column in history._data.items()}
                behind = (self._at[0] - columns["step"]) * self.demSteps // self.mpmSteps
                plot.addData(
                    {
                        "i": self._cycleEnd - behind,
                        "t": columns["time"] - self.timeOffset,
                        **{prefix + name: value for name, value in columns.items()},
                    }
                )

    def flush(self):
        """Writes rows and frames that are not in the files yet; O.run, O.step, O.wait and O.save do it."""
        self._forward()
        for engine in self._chain:
            if isinstance(engine, Callback) and engine._scene is not None:
                engine.flush()

    def _tagRecorders(self):
        """O.tags as attribute `O.tags` of the files of our recorders (JSON)."""
        tags = json.dumps({key: self._O.tags[key] for key in self._O.tags.keys()})
        for recorder in self._chain:
            if isinstance(recorder, Recorder) and recorder._path is not None:
                with recorder.appending() as h5:
                    h5.attrs["O.tags"] = tags

    def _saveBeside(self, file):
        """Writes our checkpoint that goes with a file of O.save, and notes in O.tags what attach() needs."""
        if self.error is not None:
            raise RuntimeError(
                f"O.save: '{self.label}' was stopped by an error ({self.error}); detach() it to save YADE alone"
            )
        name = checkpointOf(file, self.label)
        checkWritable(name)
        self.flush()
        self._O.tags[_tagOf(self.label)] = json.dumps(
            dict(
                file=os.path.basename(name),
                mpmSteps=self.mpmSteps,
                demSteps=self.demSteps,
                stages=self.stages,
                cycleEnd=self._cycleEnd,
                end=self._end,
                timeOffset=self.timeOffset,
                demDt=self._demDt,
                dt=self._dt,
                iter=self._O.iter,
                bodies=[
                    (self._chain.index(e.contact), e.spec()) for e in self.exchanges if isinstance(e, Bodies)
                ],
            )
        )
        checkpoint.save(self.scene, name)
        self._stepsSaved = self.scene.steps


class _YadeRun(Run):
    """What the scene takes YADE's loop for: `scene.pause()` pauses YADE, and changes are refused while it runs."""

    def __init__(self, coupling):
        super().__init__(coupling.scene, None, None, False, f"{coupling._O.tags['id']}.{coupling.label}.h5")
        self._coupling = coupling

    def isAlive(self):
        return self._coupling._O.running

    def isThisThread(self):
        return threading.get_ident() == self._coupling._thread

    def stop(self):
        yadeLoop.pauseAfterStep(self._coupling._O)

    def wait(self):
        if not self.isThisThread():
            self._coupling._O.wait()

    def _failed(self, error):
        self._thread = True  # for a message with the reason
        super()._failed(error)


# --- helpers ------------------------------------------------------------------------------------------------
def _count(name, value):
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise ValueError(f"inYade.attach: {name} = {value!r} is not allowed; give a whole number from 1 on")
    return value


def _steppersIn(engines):
    from yade.wrapper import TimeStepper

    return [e for e in engines if isinstance(e, TimeStepper)]


def _demStep(O):
    """What the discrete elements need where nobody has set O.dt, s."""
    if not any(type(b.shape).__name__ == "Sphere" for b in O.bodies):
        return math.inf
    from yade.utils import PWaveTimeStep

    return DEM_SAFETY * PWaveTimeStep()


def _nextAt(steps, period):
    return (steps // period + 1) * period


def _tagOf(label):
    return f"yade_mpm.{label}"


def _fromTag(O, label, callbacks):
    """Scene from the checkpoint that O.tags name, and what was noted there."""
    tag = _tagOf(label)
    if tag not in list(O.tags.keys()):
        raise ValueError(
            f"inYade.attach: no scene was given, and YADE's state names none for the label '{label}' "
            f"(O.tags['{tag}'])"
        )
    saved = json.loads(O.tags[tag])
    if saved["iter"] != O.iter:
        raise ValueError(
            f"inYade.attach: the checkpoint that O.tags name was written at O.iter = {saved['iter']}, YADE is at "
            f"{O.iter}; load a file that O.save wrote with the scene attached, or give the scene"
        )
    file = os.path.join(os.path.dirname(O.filename or ""), saved["file"])
    return load(file, callbacks), saved
