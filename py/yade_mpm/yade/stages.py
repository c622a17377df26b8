# SPDX-License-Identifier: GPL-2.0-or-later
"""A step of a scene that YADE takes engine by engine."""

from ..base.attributes import keep
from ..engine.callback import Callback
from .native import isDead


class Stages:
    """The chain of a scene as engines of YADE, which may be switched off (`dead`) one by one.

    Parameters
    ----------
    scene : Scene, prepared.
    engines : list of the engines of YADE that act for the engines of the chain.
    endStep : function without argument that is called at the end of a step.
    """

    def __init__(self, scene, engines, endStep):
        self._stepper, self._chain, self._engines = scene.stepper, scene.engines, engines
        self._endStep = endStep
        self._acts = [scene.stepper.actOf(e) for e in self._chain]
        self._isStage = [not isinstance(e, Callback) for e in self._chain]
        self.last = -1  # number of the last stage of this step
        self.isOpen = False  # whether a step is between its stages

    def act(self, number):
        """Lets one engine act. The clock stands still before the last stage that lives, and moves on behind
        it."""
        if self._isStage[number]:
            if not self.isOpen:
                self.isOpen, self.last = True, self._lastLiving(number)
            isLast = number >= self.last
        else:
            isLast = False
        stepper = self._stepper
        keep(stepper, acting=self._chain[number] if self.isOpen else None)
        try:
            self._acts[number]()
        finally:
            if isLast:  # also when it raises: what ends a step at its last stage has made all of it
                self.close()
        if self.isOpen:
            keep(stepper, acting=self._chain[number + 1])

    def close(self):
        """Ends the step."""
        self.isOpen = False
        keep(self._stepper, acting=None)
        self._endStep()

    def abandon(self):
        """Leaves the step as an error left it."""
        self.isOpen = False
        keep(self._stepper, acting=None)

    def _lastLiving(self, first):
        """Number of the last stage that lives, from one of them on."""
        for k in range(len(self._chain) - 1, first, -1):
            if self._isStage[k] and not (isDead(self._engines[k]) or self._chain[k]._core.dead):
                return k
        return first
