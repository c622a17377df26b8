# SPDX-License-Identifier: GPL-2.0-or-later
"""A step of a scene that YADE takes engine by engine."""

from ..engine.callback import Callback


class Stages:
    """The chain of a scene as engines of YADE, which may be switched off (`dead`) one by one.

    Parameters
    ----------
    scene : Scene, prepared.
    engines : list of the engines of YADE that act for the engines of the chain.
    endStep : function without argument that is called at the end of a step.
    """

    def __init__(self, scene, engines, endStep):
        self._stepper, self._chain, self._engines, self._endStep = (
            scene.stepper,
            scene.engines,
            engines,
            endStep,
        )
        self._isStage = [not isinstance(e, Callback) for e in self._chain]
        self.isOpen = False  # whether a step is between its stages

    def act(self, number):
        """Lets one engine act. The clock stands still before the last stage that lives, and moves on behind
        it."""
        isStage = self._isStage[number]
        self.isOpen |= isStage
        isLast = isStage and self._isLast(number)
        self._stepper.acting = self._chain[number] if self.isOpen else None
        try:
            self._stepper.act(self._chain[number])
        finally:
            if isLast:  # also when it raises: what ends a step at its last stage has made all of it
                self.close()
        if self.isOpen:
            self._stepper.acting = self._chain[number + 1]

    def close(self):
        """Ends the step."""
        self.isOpen, self._stepper.acting = False, None
        self._endStep()

    def abandon(self):
        """Leaves the step as an error left it."""
        self.isOpen, self._stepper.acting = False, None

    def _isLast(self, number):
        """Whether no stage behind it lives."""
        for k in range(number + 1, len(self._chain)):
            if self._isStage[k] and not (self._engines[k].dead or self._chain[k].core.dead):
                return False
        return True
