# SPDX-License-Identifier: GPL-2.0-or-later
"""Ctrl-C and SIGTERM in YADE's loop."""

import os
import signal
import sys
import threading
import time

SIGNAL_PERIOD = 0.1  # s of wall time between looks for signals
SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Signals:
    """Ctrl-C and SIGTERM. O.run(n, True) keeps Python's handlers waiting until it ends, so a pipe tells the
    engines to pause it; the handler, in the main thread, saves when YADE has stopped.

    Parameters
    ----------
    omega : function without argument that returns O of YADE.
    isInStep : function without argument, whether the caller is a callback of YADE's loop.
    couplings : function without argument that returns what is attached.
    """

    def __init__(self, omega, isInStep, couplings):
        self._omega, self._isInStep, self._couplings = omega, isInStep, couplings
        self._before, self._pipe, self._looked, self._noted = {}, None, 0.0, None

    def install(self):
        """Handles both from now on; does nothing outside of the main thread."""
        if threading.current_thread() is not threading.main_thread() or self._pipe is not None:
            return
        self._pipe = os.pipe()
        for end in self._pipe:
            os.set_blocking(end, False)
        signal.set_wakeup_fd(self._pipe[1], warn_on_full_buffer=False)
        for number in SIGNALS:
            self._before[number] = signal.signal(number, self._handle)

    def isPending(self):
        """Whether a signal has come; looks every 0.1 s."""
        now = time.monotonic()
        if self._pipe is None or now - self._looked < SIGNAL_PERIOD:
            return False
        self._looked = now
        try:
            return any(number in SIGNALS for number in os.read(self._pipe[0], 64))
        except BlockingIOError:
            return False

    def _handle(self, number, frame):
        self._noted = number
        if not self._isInStep():  # else afterRun() sees to it
            if self._omega().running:
                self._omega().pause()
            self.afterRun()

    def afterRun(self):
        """Saves what was interrupted, and does what the signal did before."""
        number = self._noted
        if number is None or threading.current_thread() is not threading.main_thread():
            return
        self._noted = None
        if any(c.error is None and c.scene.steps > c.stepsSaved for c in self._couplings()):
            self._save(self._omega())
        before = self._before.get(number)
        if callable(before):
            before(number, None)
        elif before != signal.SIG_IGN:
            raise SystemExit(128 + number)

    def _save(self, yade):
        file = f"{yade.tags['id']}.interrupted.yade.gz"
        at = f"interrupted at O.iter = {yade.iter}, O.time = {yade.time:g} s"
        try:
            yade.save(file)
            print(
                f"{at}; the state is in {file} and beside it (continue with O.load and mpm.inYade())",
                file=sys.stderr,
            )
        except Exception as error:
            print(f"{at}; the state could not be saved: {error}", file=sys.stderr)
