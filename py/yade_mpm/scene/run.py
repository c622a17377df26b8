# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a scene: the loop, its progress, and what happens when it is interrupted or fails."""

import atexit
import math
import os
import signal
import sys
import threading
import time

from ..base import limits
from ..io import checkpoint
from .pace import Pace

SLICE = 0.1  # s of wall time between looks at signals and the progress bar
SHARE = 0.01  # of the wall time of a run that checkpoints may take


class Run:
    """Takes steps until a time or a number of steps is reached, in the foreground or in a thread."""

    def __init__(self, scene, until, steps, progress, checkpointFile, checkpointPeriod=None):
        self.scene, self.until, self.checkpointFile, self.checkpointPeriod = (
            scene,
            until,
            checkpointFile,
            checkpointPeriod,
        )
        self.last = None if steps is None else scene.steps + steps
        self.progress = Progress(scene, progress, self)
        self.error, self.signal = None, None
        self._callsBefore = {e: e.calls for e in scene.engines}
        self._stop = threading.Event()
        self._thread = None

    # --- in the background ---
    def start(self):
        """Begins a background run. SIGTERM and the end of the program leave its state in a checkpoint too."""
        self._thread = threading.Thread(target=self._background, name="yade_mpm run", daemon=True)
        if threading.current_thread() is threading.main_thread():
            self._before = signal.signal(signal.SIGTERM, self._terminate)
        atexit.register(self._leave)
        self._thread.start()

    def _background(self):
        try:
            self.loop()
        except BaseException as error:  # raised again by wait()
            self.error = error
        atexit.unregister(self._leave)

    def isAlive(self):
        return self._thread is not None and self._thread.is_alive()

    def isThisThread(self):
        return threading.current_thread() is self._thread

    def stop(self):
        self._stop.set()

    def wait(self):
        """Waits for the end of a background run and raises its error; Ctrl-C ends the run and leaves a checkpoint."""
        if self._thread is None or self.isThisThread():
            return
        try:
            self._thread.join()
        except KeyboardInterrupt:
            self._cutOff()
            raise
        if (
            signal.getsignal(signal.SIGTERM) == self._terminate
            and threading.current_thread() is threading.main_thread()
        ):
            signal.signal(signal.SIGTERM, self._before or signal.SIG_DFL)
        if self.error is not None:
            error, self.error = self.error, None
            raise error

    def _terminate(self, number, frame):
        signal.signal(number, self._before or signal.SIG_DFL)
        if not self.isAlive():
            os.kill(os.getpid(), number)  # not ours any more
            return
        self._cutOff()
        raise SystemExit(128 + number)

    def _leave(self):
        if self.isAlive():
            self._cutOff()

    def _cutOff(self):
        """Ends a background run after the slice it is in, and saves."""
        self.stop()
        self._thread.join()
        if self.error is None:
            self._saveInterrupted()

    # --- the loop ---
    def stepsLeft(self):
        """Steps to the end at the present time step."""
        if self.last is not None:
            return self.last - self.scene.steps
        return max(0, math.ceil((self.until - self.scene.time) / self.scene.core.dt - 1e-6))

    def loop(self):
        """Takes the steps. KeyboardInterrupt and SystemExit(143) after signals, or what went wrong: the state is saved then."""
        handlers = self._catchSignals()
        self._saveAt = math.inf if self.checkpointPeriod is None else time.monotonic() + self.checkpointPeriod
        try:
            self._takeSteps()
            if self.signal is not None:
                self._saveInterrupted()
        except BaseException as error:
            self._failed(error)
            raise
        finally:
            self.scene._acting = None
            self.progress.close()
            for number, handler in handlers.items():
                signal.signal(number, handler or signal.SIG_DFL)
            self._flush()
        if self.signal == signal.SIGTERM:
            raise SystemExit(128 + signal.SIGTERM)
        if self.signal is not None:
            raise KeyboardInterrupt

    def _takeSteps(self):
        scene, pace = self.scene, Pace(self.scene)
        while self.stepsLeft() > 0 and self.signal is None and not self._stop.is_set():
            if scene.steps > 0 and scene.steps % limits.CHECK_PERIOD == 0:
                self._lookAtDomains(limits.INTERFACE_RUN)
            if scene.steps > 0 and scene.steps % limits.DT_PERIOD == 0 and scene._estimatedAt != scene.steps:
                self._reestimate()
            callbacks = [e.stepsToCall(scene) for e in scene.engines]
            looks = [period - scene.steps % period for period in (limits.CHECK_PERIOD, limits.DT_PERIOD)]
            pace.look()
            scene.core.advance(min([self.stepsLeft(), *looks, *callbacks]), SLICE)
            self.progress.update()
            if time.monotonic() >= self._saveAt:
                self._saveMeanwhile()
        scene.core.threads = scene.threads
        self._lookAtDomains(math.inf)

    def _lookAtDomains(self, longest):
        """Ends a run with edges beside uGIMP of more than `longest` cells; warns, once each, of long ones and of distorted domains."""
        scene = self.scene
        faults = {"interface": scene._checkInterface(longest), "distortion": scene._distortion()}
        for what, fault in faults.items():
            if fault is not None and what not in scene._warnedOf:
                scene._warnedOf.add(what)
                self.progress.say(f"warning: step {scene.steps}: {fault}")

    def _reestimate(self):
        scene = self.scene
        critical = scene._estimate()
        scene._estimatedAt = scene.steps
        if not critical > 0:
            return  # every node is held: nothing to go by
        if scene._dt is None:
            scene.core.dt = limits.DT_SAFETY[scene.scheme] * critical
        elif scene._dt > critical and not scene.allowUnstable:
            self.progress.say(
                f"warning: step {scene.steps}: dt = {scene._dt:.3g} s now exceeds the critical step "
                f"{critical:.3g} s (stiffest: '{scene.stiffest}')"
            )

    # --- signals and errors ---
    def _catchSignals(self):
        """Signals only leave a note: a callback that writes a file is never cut off."""
        if threading.current_thread() is not threading.main_thread():
            return {}

        def note(number, frame):
            self.signal = number

        return {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}

    def _flush(self):
        for engine in self.scene.engines:
            engine.flush()

    def _saveMeanwhile(self):
        """For what leaves no time to save: power that fails, a killed process."""
        began = time.monotonic()
        try:
            self._flush()
            self._save()
        except OSError as error:
            self.progress.say(f"warning: step {self.scene.steps}: {error}")
        now = time.monotonic()
        self._saveAt = now + max(self.checkpointPeriod, (now - began) / SHARE)

    def _saveInterrupted(self):
        """A checkpoint and a message; a file that cannot be written makes another message, no error."""
        self.progress.close()
        at = f"interrupted at step {self.scene.steps}, t = {self.scene.time:g} s"
        try:
            print(f"{at}; the state is in {self._save()} (continue with yade_mpm.load)", file=sys.stderr)
        except Exception as error:
            print(f"{at}; the state could not be saved: {error}", file=sys.stderr)

    def _failed(self, error):
        """The state as the error left it, beside the last checkpoint, and a message."""
        reason = f" ({error})" if self._thread is not None else ""  # else the traceback tells
        self.progress.close()
        at = f"the run failed at step {self.scene.steps}, t = {self.scene.time:g} s{reason}"
        try:
            print(f"{at}; the state is in {self._save('.failed', self._isMidStep())}", file=sys.stderr)
        except Exception as second:
            print(f"{at}, and the state could not be saved: {second}", file=sys.stderr)

    def _isMidStep(self):
        """Whether the error came between the stages of a step: from a callback there, or from a stage."""
        taken = {type(e).__name__: e.calls - self._callsBefore.get(e, 0) for e in self.scene.engines}
        return self.scene.isMidStep() or taken.get("ParticleToGrid") != taken.get("GridSolver")

    def _save(self, suffix="", midStep=False):
        file = self.checkpointFile
        if file is None:
            names = [e.file for e in self.scene.engines if getattr(e, "file", None)]
            file = (os.path.splitext(names[0])[0] if names else "yade_mpm") + ".checkpoint.h5"
        root, ending = os.path.splitext(os.fspath(file))
        checkpoint.save(self.scene, root + suffix + ending, midStep)
        return root + suffix + ending


class Progress:
    """A bar on a terminal, a line now and then elsewhere."""

    WAIT = 2.0  # s before anything is shown
    LINES = 30.0  # s between lines that are no terminal

    def __init__(self, scene, wanted, run):
        self.scene, self.wanted, self.run = scene, wanted, run
        self.began, self.firstStep, self.bar, self.lastLine = time.monotonic(), scene.steps, None, 0.0
        self.terminal = sys.stderr.isatty()

    def text(self):
        """Time, rate and number of threads."""
        steps = self.scene.steps - self.firstStep
        wall = time.monotonic() - self.began
        rate = wall / max(1, steps) / max(1, self.scene.particleCount) * 1e9
        threads = f"{self.scene.core.threads} thread{'s' if self.scene.core.threads > 1 else ''}"
        return f"t = {self.scene.time:.4g} s, {rate:.3g} ns per particle-step on {threads}"

    def update(self):
        wall = time.monotonic() - self.began
        if self.wanted is False or (wall < self.WAIT and not self.wanted):
            return
        done, left = self.scene.steps - self.firstStep, self.run.stepsLeft()
        if self.terminal:
            if self.bar is None:
                from tqdm import tqdm

                self.bar = tqdm(
                    total=done + left, unit="step", file=sys.stderr, dynamic_ncols=True, leave=True
                )
            self.bar.total = done + left
            self.bar.set_postfix_str(self.text(), refresh=False)
            self.bar.update(done - self.bar.n)
        elif wall - self.lastLine >= self.LINES or (left == 0 and self.lastLine > 0):
            self.lastLine = wall
            remaining = wall / max(1, done) * left
            print(
                f"step {self.scene.steps} of {self.scene.steps + left}, {self.text()}, {remaining:.0f} s left",
                file=sys.stderr,
            )

    def say(self, message):
        if self.bar is not None:
            self.bar.write(message, file=sys.stderr)
        else:
            print(message, file=sys.stderr)

    def close(self):
        if self.bar is not None:
            self.bar.close()
            self.bar = None
