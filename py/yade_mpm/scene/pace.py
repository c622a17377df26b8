# SPDX-License-Identifier: GPL-2.0-or-later
"""How many threads a run takes, where nobody has said: as many as the scene's size asks for, or one while
other jobs have the processors.

Threads that share their processors with another job wait for each other most of the time: two then take two
to four times as long as one. The results are the same bits for any number, so a run may change it: it tries
the other number for a moment, now and then, and stays with the faster.
"""

import time

from ..engine.engine import Engine

FIRST, LATER = (
    0.3,
    10.0,
)  # s of wall time to the first trial; at most between later ones, each time twice as long
TRIAL = 0.1  # s that one lasts
GAIN = 0.9  # a number is changed for one that takes less than this part of the time


class Pace:
    """Chooses the number of threads of a run, slice by slice."""

    def __init__(self, scene, clock=time.monotonic):
        self._scene, self._clock, self._isSingle, self._wait = scene, clock, False, FIRST
        self._begin(isTrial=False)

    def look(self):
        """To be called between slices; gives the scene the number of threads for the next one."""
        scene, most = self._scene, self._scene.threads
        if scene._threads is not None or most == 1:
            scene._core.threads = most
            return
        self._decide()
        scene._core.threads = 1 if self._isSingle != self._isTrial else most

    def _decide(self):
        wall = self._clock() - self._began
        if wall < (TRIAL if self._isTrial else self._wait) or self._scene.steps == self._firstStep:
            return
        if not self._isTrial:
            self._stepTimeBefore, self._wait = self._stepTime(), min(2 * self._wait, LATER)
        elif self._stepTime() < GAIN * self._stepTimeBefore:
            self._isSingle, self._wait = not self._isSingle, FIRST
        self._begin(isTrial=not self._isTrial)

    def _begin(self, isTrial):
        self._isTrial = isTrial
        self._began, self._firstStep, self._before = self._clock(), self._scene.steps, self._seconds()

    def _stepTime(self):
        return (self._seconds() - self._before) / (self._scene.steps - self._firstStep)

    def _seconds(self):
        """Of the engines of every step: what is called now and then does not depend on the number."""
        return sum(e.seconds for e in self._scene.engines if type(e).stepsToCall is Engine.stepsToCall)
