# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a scene: the loop, and what happens when it is interrupted or fails."""

import math
import signal
import sys
import threading

from ..base.attributes import keep
from .pace import Pace
from .policy import LoopPolicy
from .progress import Progress
from .rescue import Rescue

ENDING = (signal.SIGTERM, signal.SIGHUP)
SLICE = 0.1  # s of wall time between looks at signals and the progress bar
LAST = 10  # steps that are shortened together to end at a given time: none alone, for a reaction is m dv/dt


class Run:
    """Takes steps until a time or a number of steps is reached.

    Parameters
    ----------
    scene : Scene, prepared.
    until : float, s, scene time to reach; or None.
    steps : int, number of steps; or None.
    progress : bool, show progress; None: where the run is long.
    checkpointFile : str, name of the checkpoint; None: see `Rescue`.
    checkpointPeriod : float, s of wall time between checkpoints; None: only where the run ends before its
        time.
    """

    tellsErrors = False  # in the message about the checkpoint: the traceback shows them

    def __init__(self, scene, until, steps, progress, checkpointFile, checkpointPeriod):
        self.scene, self.until = scene, until
        self.last = None if steps is None else scene.steps + steps
        self.progress = Progress(scene, progress, self.stepsLeft)
        self.rescue = Rescue(scene, checkpointFile)
        self.checkpointPeriod = checkpointPeriod
        self.signal = None  # number of the one that ends the run
        # Plain flags: a lock, or an Event, could be held by the very code that a signal handler interrupts.
        self._isStopped = self._isSaveWanted = False

    def isAlive(self):
        """Whether it goes on in the background."""
        return False

    def isThisThread(self):
        """Whether the caller is a callback of it."""
        return False

    def stop(self):
        """Ends it behind the present slice."""
        self._isStopped = True

    def interrupt(self, number=signal.SIGTERM):
        """Ends it behind the present slice, its state saved, as a signal does."""
        self.signal = number

    def saveSoon(self, number=None, frame=None):
        """Saves the state behind the present slice, and goes on."""
        self._isSaveWanted = True

    def wait(self):
        """Waits for the end of a run in the background."""

    def stepsLeft(self):
        """Steps to the end at the present time step."""
        if self.last is not None:
            return self.last - self.scene.steps
        return max(0, math.ceil((self.until - self.scene.time) / self.scene.stepper.dt - self._roundOff()))

    def _roundOff(self):
        """What a time that was summed up may be wrong by, in steps: a digit in each, at most half of one."""
        digit = sys.float_info.epsilon * self.scene.time / self.scene.stepper.dt
        return min(0.5, max(1e-6, digit * self.scene.steps))

    def _advance(self, steps):
        """Takes some of the steps that are left; the last ones are such that the run ends on its time."""
        stepper, left = self.scene.stepper, self.stepsLeft()
        if self.until is None:
            stepper.advance(steps, SLICE)
            return
        fit = (self.until - self.scene.time) / left
        if left > LAST:
            stepper.advance(min(steps, left - LAST), SLICE)
        elif fit < stepper.dt * (1 - self._roundOff() / left):
            stepper.advanceShort(fit)
        else:
            stepper.advance(steps, SLICE)

    def loop(self):
        """Takes the steps.

        KeyboardInterrupt, SystemExit(143) and (129) after SIGINT, SIGTERM and SIGHUP, or what went wrong: the
        state is saved then. SIGUSR1 saves it and the run goes on.
        """
        handlers = self._catchSignals()
        try:
            self._takeSteps()
            if self.signal is not None:
                self.saveInterrupted()
            self.rescue.flush()
        except BaseException as error:
            self.progress.close()
            self.rescue.saveFailed(error if self.tellsErrors else None)
            self.rescue.flushAnyway()
            raise
        finally:
            keep(self.scene.stepper, acting=None)
            self.progress.close()
            for number, handler in handlers.items():
                signal.signal(number, handler or signal.SIG_DFL)
        if self.signal == signal.SIGINT:
            raise KeyboardInterrupt
        if self.signal is not None:
            raise SystemExit(128 + self.signal)

    def saveInterrupted(self):
        """Leaves the state in a checkpoint."""
        self.progress.close()
        self.rescue.saveInterrupted()

    def _takeSteps(self):
        scene, pace = self.scene, Pace(self.scene)
        if scene._notedSignals is not None:
            scene._notedSignals.handTo(self)
        policy = LoopPolicy(scene, self.progress.say, self._saveMeanwhile, self.checkpointPeriod)
        while self.stepsLeft() > 0 and self.signal is None and not self._isStopped:
            if not scene.stepper.isPrepared:  # as a callback has left it
                scene.stepper.prepare()
            policy.beforeSteps()
            pace.look()
            self._advance(min(self.stepsLeft(), policy.stepsToNext()))
            self.progress.update()
            policy.afterSteps()
            self._saveIfWanted()
        self._endOnTime()
        self._saveIfWanted()
        scene._core.threads = scene.threads
        policy.lookAtDomains(math.inf)
        policy.lookAtFields()  # also what the last step has left, which no other one looks at

    def _endOnTime(self):
        """Where the time, a sum of steps, misses the end by roundoff: so that loops over `until` end."""
        if self.until is not None and self.stepsLeft() == 0:
            self.scene.stepper.setTime(self.until)

    def _saveMeanwhile(self):
        """For what leaves no time to save: power that fails, a killed process."""
        try:
            self.rescue.flush()
        finally:  # results that cannot be written are no reason to lose the state, too
            self.rescue.save()

    def _saveIfWanted(self):
        """A checkpoint that somebody asked for, and a message; where it cannot be written, a warning."""
        if not self._isSaveWanted:
            return
        self._isSaveWanted = False
        step = self.scene.steps
        try:
            self.rescue.flush()
            self.progress.say(f"step {step}: the state is in {self.rescue.save()}; the run goes on")
        except Exception as error:
            self.progress.say(f"warning: step {step}: {error}; the run goes on")

    def _catchSignals(self):
        """Signals only leave a note: a callback that writes a file is never cut off."""
        if threading.current_thread() is not threading.main_thread():
            return {}
        return catchSignals(
            lambda number, frame: self.interrupt(number), self.saveSoon, (signal.SIGINT, *ENDING)
        )


def catchSignals(end, save, ending):
    """Handlers of the signals that concern a run; returns those before. What the user catches is left alone.

    Parameters
    ----------
    end : function (number, frame), called by signals that end a run.
    save : function (number, frame), called by SIGUSR1, which batch systems send before they kill.
    ending : numbers of the signals that end a run; SIGHUP stays ignored where it is, as under nohup.
    """
    handlers = dict.fromkeys(ending, end)
    if signal.getsignal(signal.SIGHUP) == signal.SIG_IGN:
        handlers.pop(signal.SIGHUP, None)
    present = signal.getsignal(signal.SIGUSR1)
    if present == signal.SIG_DFL or isinstance(getattr(present, "__self__", None), NotedSignals):
        handlers[signal.SIGUSR1] = save
    return {number: signal.signal(number, handler) for number, handler in handlers.items()}


class NotedSignals:
    """Signals that come between the runs of a longer job are kept for its next run.

    with NotedSignals(scene):
        while ...:
            scene.run(steps=200)
            ...
        scene.run(steps=0)  # for those behind the last run
    """

    def __init__(self, scene):
        self._scene = scene
        self.numbers, self._before = [], {}

    def __enter__(self):
        keep(self._scene, _notedSignals=self)
        if threading.current_thread() is threading.main_thread():
            self._before = catchSignals(self._note, self._note, (signal.SIGINT, *ENDING))
        return self

    def __exit__(self, *_):
        keep(self._scene, _notedSignals=None)
        for number, handler in self._before.items():
            signal.signal(number, handler or signal.SIG_DFL)

    def _note(self, number, frame):
        self.numbers.append(number)

    def handTo(self, run):
        """Lets a run do what they ask for: save, or end."""
        while self.numbers:
            number = self.numbers.pop(0)
            run.saveSoon() if number == signal.SIGUSR1 else run.interrupt(number)
