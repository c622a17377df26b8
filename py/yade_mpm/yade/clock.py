# SPDX-License-Identifier: GPL-2.0-or-later
"""The clocks of YADE and of a scene: cycles at whose ends both are at the same time."""


class Clock:
    """Cycles of `demSteps` DEM steps, in whose first one a scene takes `mpmSteps` steps.

    Parameters
    ----------
    omega : O of YADE.
    scene : Scene
    mpmSteps, demSteps : int, one of the two is 1.
    saved : dict with what was noted at O.save under "cycleEnd", "end" and "timeOffset"; empty otherwise.
    grants : Grants, steps that are taken without asking; as if they had been noted here.

    Attributes
    ----------
    iteration : int, of the DEM step that has begun last; None before.
    cycleEnd : int, iteration at which the scene steps next.
    end : s, scene time at the end of the cycle.
    timeOffset : s, scene.time - O.time.
    """

    def __init__(self, omega, scene, mpmSteps, demSteps, saved, grants):
        self._omega, self._scene, self._mpmSteps, self._demSteps = omega, scene, mpmSteps, demSteps
        self._grants = grants
        self._iteration, self._before, self._granted = None, None, grants.lastStep
        self._cycleEnd = saved.get("cycleEnd", omega.iter)
        self._end = saved.get("end", scene.time)
        self.timeOffset = saved.get("timeOffset", scene.time - omega.time)
        self._stepsSeen, self._timeSeen = None, None
        self.noteSteps()

    iteration = property(lambda self: self._caughtUp()._iteration)
    cycleEnd = property(lambda self: self._caughtUp()._cycleEnd)
    end = property(lambda self: self._caughtUp()._end)

    def _caughtUp(self):
        """Itself, with the steps that were granted since."""
        last = self._grants.lastStep
        if last != self._granted:
            self._stepsSeen += (last - self._iteration) * self._mpmSteps
            self._timeSeen = self._end = self._grants.end
            self._granted, self._iteration, self._cycleEnd = last, last, last + 1
        return self

    isAtCycleEnd = property(
        lambda self: self.iteration >= self.cycleEnd, doc="Whether the scene steps in this DEM step."
    )

    def isInStep(self):
        """Whether YADE is still in the DEM step that was noted last."""
        return self._omega.iter == self.iteration

    def noteStep(self):
        """Notes the DEM step that begins."""
        self._before, self._iteration = self.iteration, self._omega.iter

    def refuseStepBack(self):
        """Raises RuntimeError where YADE was set back behind the present cycle."""
        if self.iteration < self.cycleEnd - self._demSteps:
            self._refuse()

    def noteSteps(self):
        """Notes that the scene has taken its steps."""
        self._stepsSeen, self._timeSeen = self._scene.steps, self._scene.time

    def refuseForeignSteps(self, label):
        """Raises RuntimeError where the scene has taken steps outside of YADE."""
        scene = self._scene
        if (scene.steps, scene.time) != (self._stepsSeen, self._timeSeen):
            raise RuntimeError(
                f"the scene '{label}' has taken steps outside of YADE (it is at step {scene.steps}, YADE "
                f"left it at {self._stepsSeen}); call mpm.inYade(scene) again"
            )

    def meet(self):
        """At the end of a cycle both clocks agree: RuntimeError if not."""
        now, isNext = self._omega.time + self.timeOffset, self._before is not None
        if now != self._scene.time and isNext and self.iteration == self._before + 1:
            self._refuse()
        self._scene.stepper.setTime(now)  # later than it was only when all engines were dead for some steps

    def beginCycle(self, dt):
        """A cycle of DEM steps of dt, s; sets the scene's time step."""
        self._scene.stepper.dt = dt * self._demSteps / self._mpmSteps
        end = self._omega.time
        for _ in range(self._demSteps):  # as YADE adds up
            end += dt
        self._end = end + self.timeOffset
        self._cycleEnd = self.iteration + self._demSteps

    def iterationOf(self, step):
        """Iteration of YADE that belongs to an MPM step that was taken."""
        return self.cycleEnd - (self._stepsSeen - step) * self._demSteps // self._mpmSteps

    def noted(self):
        """Dict of what goes with a file of O.save, of plain types."""
        return dict(iter=self._omega.iter, cycleEnd=self.cycleEnd, end=self.end, timeOffset=self.timeOffset)

    def _refuse(self):
        raise RuntimeError(
            f"the clocks differ: scene.time = {self._scene.time!r} s, O.time + timeOffset = "
            f"{self._omega.time + self.timeOffset!r} s. O.time was set back, or O.dt was changed in a step "
            "after the MPM engines; correct that, and call mpm.inYade(scene) again"
        )
