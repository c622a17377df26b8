# SPDX-License-Identifier: GPL-2.0-or-later
"""A run in a thread of its own."""

import atexit
import os
import signal
import threading

from .run import Run


class BackgroundRun(Run):
    """A run that goes on while the program does other things; parameters as of `Run`."""

    tellsErrors = True  # the traceback comes with `wait`, which may never be called

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.error = None
        self._thread = threading.Thread(target=self._work, name="yade_mpm run", daemon=True)
        self._before = None  # handler of SIGTERM

    def start(self):
        """Begins. SIGTERM and the end of the program leave its state in a checkpoint too."""
        if threading.current_thread() is threading.main_thread():
            self._before = signal.signal(signal.SIGTERM, self._terminate)
        atexit.register(self._leave)
        self._thread.start()

    def _work(self):
        try:
            self.loop()
        except BaseException as error:  # raised again by wait()
            self.error = error
        atexit.unregister(self._leave)

    def isAlive(self):
        """Whether it goes on."""
        return self._thread.is_alive()

    def isThisThread(self):
        """Whether the caller is a callback of it."""
        return threading.current_thread() is self._thread

    def wait(self):
        """Waits for the end and raises what went wrong; Ctrl-C ends the run and leaves a checkpoint."""
        if self.isThisThread():
            return
        try:
            self._thread.join()
        except KeyboardInterrupt:
            self._cutOff()
            raise
        isMain = threading.current_thread() is threading.main_thread()
        if isMain and signal.getsignal(signal.SIGTERM) == self._terminate:
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
        """Ends it behind the slice it is in, and saves."""
        self.stop()
        self._thread.join()
        if self.error is None:
            self.saveInterrupted()
