# SPDX-License-Identifier: GPL-2.0-or-later
"""A run in a thread of its own."""

import atexit
import os
import signal
import threading
import time

from .loop import ENDING, Run, catchSignals

LOOK = 1.0  # s between looks whether a run in the background is over, besides being told
PATIENCE = 2  # times that Ctrl-C is pressed before a run that does not end is given up


class BackgroundRun(Run):
    """A run that goes on while the program does other things; parameters as of `Run`."""

    tellsErrors = True  # the traceback comes with `wait`, which may never be called

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.error = None
        self._thread = threading.Thread(target=self._work, name="yade_mpm run", daemon=True)
        self._process = os.getpid()  # a child made by fork has no such thread
        # A bare lock, held while it goes on. Not Thread.join: interrupted by Ctrl-C it takes a thread that
        # steps on for finished (bpo-45274). Nor an Event: interrupted twice it releases a lock that it lacks.
        self._isOver, self._over = False, threading.Lock()
        self._before = {}  # signal -> handler

    def start(self):
        """Begins. Signals and the end of the program leave its state in a checkpoint too."""
        if threading.current_thread() is threading.main_thread():
            self._before = catchSignals(self._terminate, self.saveSoon, ENDING)
        atexit.register(self._leave)
        self._over.acquire()
        self._thread.start()

    def _work(self):
        try:
            with self.scene._holder.held("run"):
                self.loop()
        except BaseException as error:  # raised again by wait()
            self.error = error
        atexit.unregister(self._leave)
        self._isOver = True  # first: the handler of a signal looks at nothing else
        self._over.release()

    def isAlive(self):
        """Whether it goes on."""
        return not self._isOver and self._process == os.getpid()

    def isThisThread(self):
        """Whether the caller is a callback of it."""
        return threading.current_thread() is self._thread

    def wait(self):
        """Waits for the end and raises what went wrong; Ctrl-C ends the run and leaves a checkpoint.

        Ctrl-C again and again raises KeyboardInterrupt at once: for a callback that hangs.
        """
        if self.isThisThread():
            return
        presses = 0
        while self.isAlive():
            try:
                if self._over.acquire(timeout=LOOK):
                    self._over.release()
            except KeyboardInterrupt:
                presses += 1
                self.interrupt(signal.SIGINT)
                if presses > PATIENCE:
                    raise
        self._releaseSignals()
        if self.error is not None:
            error, self.error = self.error, None
            raise error
        if presses:
            raise KeyboardInterrupt

    def _releaseSignals(self):
        if threading.current_thread() is not threading.main_thread():
            return
        for number, handler in self._before.items():
            if signal.getsignal(number) in (self._terminate, self.saveSoon):
                signal.signal(number, handler or signal.SIG_DFL)
        self._before = {}

    def _terminate(self, number, frame):
        if not self.isAlive():
            signal.signal(number, self._before.get(number) or signal.SIG_DFL)
            os.kill(os.getpid(), number)  # not ours any more
            return
        self._cutOff(number)
        raise SystemExit(128 + number)

    def _leave(self):
        if self.isAlive():
            self._cutOff(signal.SIGTERM)

    def _cutOff(self, number):
        """Ends it behind the slice it is in, which saves. Takes no lock: signal handlers call it."""
        self.interrupt(number)
        while self.isAlive():
            time.sleep(0.005)
