# SPDX-License-Identifier: GPL-2.0-or-later
"""The thread of YADE's loop, and how to wait until it stands still.

YADE's own O.pause() returns while the step under way goes on, and the loop may even begin one more. Here the
loop is paused from inside a step, by an engine of ours, and stands still when its thread has ended: every run
of YADE has a thread of its own.
"""

import os
import threading
import time

from .. import _core
from .grants import revokeAll, unfoldAll

LOOK_PERIOD = 2e-4  # s between looks at a thread that is about to end


class LoopThread:
    """The thread in which YADE calls our engines: that of O.run, or the caller's in O.step."""

    def __init__(self):
        self._number = None  # of the operating system; it is not given again soon, as Python's are
        self._isPauseAsked = False

    def note(self):
        """From inside a step: this is the thread. Returns whether it is a new one, that of another run."""
        number = threading.get_native_id()
        if number == self._number:
            return False
        self._number = number
        _core.keepThreadState()
        return True

    def isMine(self):
        """Whether the caller is this thread: in the first step of a run, before an engine of ours, it is the
        only one that Python has not made."""
        if self._number == threading.get_native_id():
            return True
        return isinstance(threading.current_thread(), threading._DummyThread)

    def waitForEnd(self):
        """Waits until the thread has ended; at once where that is the caller's own, or none is known."""
        if self._number is not None and not self.isMine():
            while os.path.exists(f"/proc/self/task/{self._number}"):
                time.sleep(LOOK_PERIOD)
        self._number = None
        unfoldAll()  # the next run has another thread, or is the caller's next step

    def pause(self, yade, pause):
        """Pauses YADE from inside a step, and waits until it has taken notice; another thread calls it.

        Parameters
        ----------
        yade : O of YADE.
        pause : function of O, YADE's own.
        """
        self._isPauseAsked = True
        revokeAll()
        first = yade.iter
        try:
            while yade.running:
                time.sleep(LOOK_PERIOD)
                if yade.iter > first + 1 and self._isPauseAsked:  # no engine of ours lives
                    pause(yade)
        finally:
            self._isPauseAsked = False

    def takePause(self):
        """Whether a pause was asked for since the last call; from inside a step."""
        isAsked, self._isPauseAsked = self._isPauseAsked, False
        return isAsked
