# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a scene: the loop, and what happens when it is interrupted or fails."""

import math
import signal
import threading

from .pace import Pace
from .policy import LoopPolicy
from .progress import Progress
from .rescue import Rescue

SLICE = 0.1  # s of wall time between looks at signals and the progress bar


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

    tellsErrors = False  # in the message about the checkpoint: a traceback tells them

    def __init__(self, scene, until, steps, progress, checkpointFile, checkpointPeriod):
        self.scene, self.until = scene, until
        self.last = None if steps is None else scene.steps + steps
        self.progress = Progress(scene, progress, self.stepsLeft)
        self.rescue = Rescue(scene, checkpointFile)
        self.checkpointPeriod = checkpointPeriod
        self.signal = None
        self._stop = threading.Event()

    def isAlive(self):
        """Whether it goes on in the background."""
        return False

    def isThisThread(self):
        """Whether the caller is a callback of it."""
        return False

    def stop(self):
        """Ends it behind the present slice."""
        self._stop.set()

    def wait(self):
        """Waits for the end of a run in the background."""

    def stepsLeft(self):
        """Steps to the end at the present time step."""
        if self.last is not None:
            return self.last - self.scene.steps
        return max(0, math.ceil((self.until - self.scene.time) / self.scene.stepper.dt - 1e-6))

    def loop(self):
        """Takes the steps.

        KeyboardInterrupt and SystemExit(143) after signals, or what went wrong: the state is saved then.
        """
        handlers = self._catchSignals()
        try:
            self._takeSteps()
            if self.signal is not None:
                self.saveInterrupted()
        except BaseException as error:
            self.progress.close()
            self.rescue.saveFailed(error if self.tellsErrors else None)
            raise
        finally:
            self.scene.stepper.acting = None
            self.progress.close()
            for number, handler in handlers.items():
                signal.signal(number, handler or signal.SIG_DFL)
            self.rescue.flush()
        if self.signal == signal.SIGTERM:
            raise SystemExit(128 + signal.SIGTERM)
        if self.signal is not None:
            raise KeyboardInterrupt

    def saveInterrupted(self):
        """Leaves the state in a checkpoint."""
        self.progress.close()
        self.rescue.saveInterrupted()

    def _takeSteps(self):
        scene, pace = self.scene, Pace(self.scene)
        policy = LoopPolicy(scene, self.progress.say, self._saveMeanwhile, self.checkpointPeriod)
        while self.stepsLeft() > 0 and self.signal is None and not self._stop.is_set():
            policy.beforeSteps()
            pace.look()
            scene.stepper.advance(min(self.stepsLeft(), policy.stepsToNext()), SLICE)
            self.progress.update()
            policy.afterSteps()
        scene.core.threads = scene.threads
        policy.lookAtDomains(math.inf)

    def _saveMeanwhile(self):
        """For what leaves no time to save: power that fails, a killed process."""
        self.rescue.flush()
        self.rescue.save()

    def _catchSignals(self):
        """Signals only leave a note: a callback that writes a file is never cut off."""
        if threading.current_thread() is not threading.main_thread():
            return {}

        def note(number, frame):
            self.signal = number

        return {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
