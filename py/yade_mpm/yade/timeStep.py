# SPDX-License-Identifier: GPL-2.0-or-later
"""O.dt that suits both sides, and the limits of time steppers of YADE."""

import math

from . import loop

FRESH_DT = 1e-8  # s, O.dt of a YADE that nobody has told anything
DEM_SAFETY = 0.8  # share of PWaveTimeStep taken when O.dt is left alone


class TimeStep:
    """Governs O.dt for a scene.

    Parameters
    ----------
    omega : O of YADE.
    scene : Scene, prepared.
    mpmSteps, demSteps : int, MPM steps in so many DEM steps.
    label : str, of the coupling, for errors.
    saved : dict with what was noted at O.save under "demDt" and "dt"; empty otherwise.

    Attributes
    ----------
    maxDt : s, largest O.dt that the scene wants.
    criticalDt : s, O.dt above which a step is refused; infinite with scene.allowUnstable.
    demDt : s, O.dt if there were no MPM.
    dt : s, O.dt in the present cycle.
    """

    def __init__(self, omega, scene, mpmSteps, demSteps, label, saved):
        self._omega, self._scene, self._label = omega, scene, label
        self._mpmSteps, self._demSteps = mpmSteps, demSteps
        isFresh = omega.iter == 0 and loop.dt.now(omega) == FRESH_DT
        self.demDt = saved.get("demDt", _demStep(omega) if isFresh else loop.dt.now(omega))
        self.dt = saved.get("dt")
        self._asked = None  # O.dt that the user has set within a cycle
        self._given = []  # (time stepper, its own maxDt, maxDt that it was given)
        self._steppers = steppersIn(omega.engines)
        self.setLimits()

    def lookForSteppers(self):
        """Finds the time steppers again: the user may have changed O.engines."""
        self._steppers = steppersIn(self._omega.engines)

    def setLimits(self):
        """Limits from the scene as it stands."""
        scene, critical = self._scene, self._scene.dtCritical or 0.0
        own = scene._dt
        if own is None:
            own = scene.stepper.automaticDt or (scene.stepper.safeDt() if critical > 0 else scene.stepper.dt)
            own = min(own, scene.stepper.speedDt())
        self.maxDt = own * self._mpmSteps / self._demSteps
        isBounded = critical > 0 and not scene.allowUnstable
        self.criticalDt = scene.dtStable * self._mpmSteps / self._demSteps if isBounded else math.inf

    def govern(self):
        """Sets O.dt, and maxDt of time steppers, from the limits of both sides."""
        omega, given = self._omega, []
        for stepper in self._steppers:
            own = stepper.maxDt
            for known, before, after in self._given:
                if known is stepper and own == after:
                    own = before  # not changed by the user since
            stepper.maxDt = min(own, self.maxDt) if own > 0 else self.maxDt
            given.append((stepper, own, stepper.maxDt))
        self._given = given
        now = loop.dt.now(omega)
        wanted = now if self._chooser() is not None and now != FRESH_DT else self.demDt
        self.dt = min(wanted, self.maxDt) if wanted > 0 else self.maxDt
        loop.dt.set(omega, self.dt)

    def keep(self):
        """Within a cycle O.dt stays; what the user sets counts from the next one on."""
        now = loop.dt.now(self._omega)
        if now != self.dt:
            if self._chooser() is None:
                self._asked = now
            loop.dt.set(self._omega, self.dt)

    def choose(self):
        """O.dt of the cycle that begins, as the user or a time stepper has left it; ValueError if it is too
        large."""
        omega = self._omega
        if self._asked is not None:
            loop.dt.set(omega, self._asked)
            self._asked = None
        dt = loop.dt.now(omega)
        if dt != self.dt:
            if self._chooser() is None:
                self.demDt = dt
            elif dt > self.maxDt:
                dt = self.maxDt
                loop.dt.set(omega, dt)
            self.dt = dt
        self.check(dt)
        return dt

    def check(self, dt):
        """Raises ValueError for a DEM step that the scene cannot take, s."""
        if not 0 < dt <= self.criticalDt * (1 + 1e-9):
            raise ValueError(
                f"O.dt = {dt:.3g} s is not allowed: the critical step of '{self._label}' is "
                f"{self.criticalDt:.3g} s (stiffest: '{self._scene.stiffest}'; {self._mpmSteps} MPM steps in "
                f"{self._demSteps} DEM steps); lower O.dt, or attach with more mpmSteps"
            )

    def checkBefore(self):
        """Before a run: the same of O.dt as it stands, unless a time stepper is to choose another."""
        if self._chooser() is None and self._asked is None:
            self.check(loop.dt.now(self._omega))

    def release(self):
        """O.dt and maxDt become what they would be without the scene."""
        for stepper, own, _ in self._given:
            stepper.maxDt = own
        if loop.dt.now(self._omega) == self.dt and math.isfinite(self.demDt) and self._chooser() is None:
            loop.dt.set(self._omega, self.demDt)

    def noted(self):
        """Dict of what goes with a file of O.save, of plain types."""
        return dict(demDt=self.demDt, dt=self.dt)

    def _chooser(self):
        """The time stepper that chooses O.dt, or None."""
        return next((s for s in self._steppers if s.active and not s.dead), None)


def steppersIn(engines):
    """The time steppers among engines of YADE."""
    from yade.wrapper import TimeStepper

    return [e for e in engines if isinstance(e, TimeStepper)]


def _demStep(omega):
    """What the discrete elements need where nobody has set O.dt, s."""
    if not any(type(b.shape).__name__ == "Sphere" for b in omega.bodies):
        return math.inf
    from yade.utils import PWaveTimeStep

    return DEM_SAFETY * PWaveTimeStep()
