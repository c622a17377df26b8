# SPDX-License-Identifier: GPL-2.0-or-later
"""One run of a scene: the loop, its progress, and what happens when it is interrupted or fails."""
import math
import os
import signal
import sys
import threading
import time

SLICE = 0.1  # s of wall time between looks at signals and the progress bar


class Run:
    """Takes steps until a time or a number of steps is reached, in the foreground or in a thread."""

    def __init__(self, scene, until, steps, progress, checkpointFile):
        self.scene, self.until, self.checkpointFile = scene, until, checkpointFile
        self.last = None if steps is None else scene.steps + steps
        self.progress = Progress(scene, progress, self)
        self.error, self.signal = None, None
        self._stop = threading.Event()
        self._thread = None

    # --- in the background ---
    def start(self):
        self._thread = threading.Thread(target=self._background, name="yade_mpm run", daemon=True)
        self._thread.start()

    def _background(self):
        try:
            self.loop()
        except BaseException as error:  # raised again by wait()
            self.error = error

    def isAlive(self):
        return self._thread is not None and self._thread.is_alive()

    def stop(self):
        self._stop.set()

    def wait(self):
        if self._thread is not None:
            self._thread.join()
        if self.error is not None:
            error, self.error = self.error, None
            raise error

    # --- the loop ---
    def stepsLeft(self):
        """Steps to the end at the present time step."""
        if self.last is not None:
            return self.last - self.scene.steps
        return max(0, math.ceil((self.until - self.scene.time) / self.scene.core.dt - 1e-6))

    def loop(self):
        from .scene import DT_PERIOD
        scene = self.scene
        handlers = self._catchSignals()
        try:
            while self.stepsLeft() > 0 and not self._stop.is_set():
                scene.core.advance(min(self.stepsLeft(), DT_PERIOD - scene.steps % DT_PERIOD), SLICE)
                if scene.steps % DT_PERIOD == 0:
                    self._reestimate()
                self.progress.update()
                if self.signal is not None:
                    self._interrupted()
        except Exception as error:
            self._failed(error)
            raise
        finally:
            self.progress.close()
            for number, handler in handlers.items():
                signal.signal(number, handler)
            for engine in scene.engines:
                if hasattr(engine, "flush"):
                    engine.flush()

    def _reestimate(self):
        from .scene import DT_SAFETY, INTERFACE_RUN
        scene = self.scene
        scene._checkInterface(INTERFACE_RUN)
        critical = scene.criticalTimeStep()
        if scene._dt is None:
            scene.core.dt = DT_SAFETY * critical
        elif scene._dt > critical and not scene.allowUnstable:
            self.progress.say(f"warning: step {scene.steps}: dt = {scene._dt:.3g} s now exceeds the critical step "
                              f"{critical:.3g} s (stiffest: '{scene.stiffest}')")

    # --- signals and errors ---
    def _catchSignals(self):
        """Signals only leave a note: a callback that writes a file is never cut off."""
        if threading.current_thread() is not threading.main_thread():
            return {}
        def note(number, frame):
            self.signal = number
        return {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}

    def _interrupted(self):
        file = self._save()
        self.progress.close()
        print(f"interrupted at step {self.scene.steps}, t = {self.scene.time:g} s; the state is in {file} "
              f"(continue with yade_mpm.load)", file=sys.stderr)
        if self.signal == signal.SIGTERM:
            raise SystemExit(143)
        raise KeyboardInterrupt

    def _failed(self, error):
        try:
            file = self._save(".failed")
            print(f"the run failed at step {self.scene.steps}, t = {self.scene.time:g} s; the state is in {file}", file=sys.stderr)
        except Exception as second:
            print(f"the run failed, and the state could not be saved: {second}", file=sys.stderr)

    def _save(self, suffix=""):
        file = self.checkpointFile
        if file is None:
            names = [e.file for e in self.scene.engines if getattr(e, "file", None)]
            file = (os.path.splitext(names[0])[0] if names else "yade_mpm") + ".checkpoint.h5"
        root, ending = os.path.splitext(file)
        self.scene.save(root + suffix + ending)
        return root + suffix + ending


class Progress:
    """A bar on a terminal, a line now and then elsewhere."""

    WAIT = 2.0    # s before anything is shown
    LINES = 30.0  # s between lines that are no terminal

    def __init__(self, scene, wanted, run):
        self.scene, self.wanted, self.run = scene, wanted, run
        self.began, self.firstStep, self.bar, self.lastLine = time.monotonic(), scene.steps, None, 0.0
        self.terminal = sys.stderr.isatty()

    def text(self):
        """Step, time, rate and time left."""
        steps = self.scene.steps - self.firstStep
        wall = time.monotonic() - self.began
        rate = wall / max(1, steps) / max(1, self.scene.particleCount) * 1e9
        return f"t = {self.scene.time:.4g} s, {rate:.3g} ns per particle-step"

    def update(self):
        wall = time.monotonic() - self.began
        if self.wanted is False or (wall < self.WAIT and not self.wanted):
            return
        done, left = self.scene.steps - self.firstStep, self.run.stepsLeft()
        if self.terminal:
            if self.bar is None:
                from tqdm import tqdm
                self.bar = tqdm(total=done + left, unit="step", file=sys.stderr, dynamic_ncols=True, leave=True)
            self.bar.total = done + left
            self.bar.set_postfix_str(self.text(), refresh=False)
            self.bar.update(done - self.bar.n)
        elif wall - self.lastLine >= self.LINES or (left == 0 and self.lastLine > 0):
            self.lastLine = wall
            remaining = wall / max(1, done) * left
            print(f"step {self.scene.steps} of {self.scene.steps + left}, {self.text()}, {remaining:.0f} s left", file=sys.stderr)

    def say(self, message):
        if self.bar is not None:
            self.bar.write(message, file=sys.stderr)
        else:
            print(message, file=sys.stderr)

    def close(self):
        if self.bar is not None:
            self.bar.close()
            self.bar = None
