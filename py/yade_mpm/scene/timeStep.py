# SPDX-License-Identifier: GPL-2.0-or-later
"""The time step of a scene: given or chosen, checked, followed."""

import functools
import math

import numpy as np

from ..base.attributes import keep
from ..base.kinds import COUNT, FLAG, POSITIVE, takes
from ..base.warn import warnUser
from ..check import limits
from ..engine.callback import Callback

BLENDS = {
    "GridSolver": ("damping",),
    "GridToParticle": ("flip",),
}  # of engines, numbers that the longest stable step depends on


def holding(method):
    """A method that is refused where another thread is at work with the scene."""

    @functools.wraps(method)
    def held(self, *args, **named):
        with self._scene._holder.held(f"Stepper.{method.__name__}"):
            return method(self, *args, **named)

    return held


def stiffnesses(scene):
    """What the square of the fastest frequency is proportional to: by the name of a body the largest present
    bulk and shear modulus, kPa, times V/V0, over the factor on inertia, with flip and damping; where cells
    differ, times the mean square of the smallest cell of the grid over that of the particle; and the number
    of particles."""
    blend, found = _blend(scene), {}
    for body, moduli in zip(scene.bodies, scene._core.presentStiffness()):
        factor = blend / body.inertiaScale
        found[body.name] = [*(factor * modulus for modulus in moduli), float(body.count)]
    return found


def _sharesImplicit(scene):
    """Whether implicit bodies are bonded to others: there a law like that of USL holds."""
    isApart = any(type(e).__name__ == "Contact" and not e.dead for e in scene.engines)
    groups = [
        {body.group if isApart else "" for body in scene.bodies if body.implicit == flag}
        for flag in (True, False)
    ]
    return bool(groups[0] & groups[1])


def _blend(scene):
    """Factor of damping and flip."""
    blend = 1.0
    for engine in scene.engines:
        kind = type(engine).__name__
        blend *= 1 + engine.damping if kind == "GridSolver" else 1.0
        blend *= 2 / (1 + engine.flip) if kind == "GridToParticle" else 1.0
    return blend


class TimeStep:
    """The time step of a scene: given or chosen, checked, followed."""

    @property
    def dt(self):
        """Length of the next step, s; to be set by a loop that chooses it within `scene.dtCritical`."""
        return self._scene._core.dt

    @dt.setter
    @holding
    def dt(self, value):
        POSITIVE.check("Stepper", "s", dt=value)
        self._scene._core.dt = float(value)

    @holding
    def checkTimeStep(self):
        """Estimates the critical step; takes a share of it if dt was left out, refuses a dt above the longest
        stable step otherwise."""
        scene, given = self._scene, self._scene._dt
        scene._core.threads = scene.threads
        isAllowed = given is not None and scene.allowUnstable
        critical = None if isAllowed and scene.dtCritical is not None else self.estimateCriticalStep()
        if given is None:
            if not critical > 0:
                raise ValueError(
                    "Scene: no critical time step can be found (every node is held, every body is "
                    "implicit, or none has particles); give scene.dt"
                )
            self.takeSafeDt()
        elif not isAllowed and critical > 0 and given > scene.dtStable:
            raise ValueError(
                f"dt = {given:.3g} s exceeds the longest stable step {scene.dtStable:.3g} s of this scene "
                f"(stiffest: '{scene.stiffest}'{self._leftOut()}); lower dt, raise inertiaScale, coarsen the "
                "grid, or make a stiff body implicit"
            )
        else:
            if not isAllowed and _sharesImplicit(scene) and given > limits.DT_SHARED * scene.dtStable > 0:
                good = limits.DT_STABLE["USL"] * scene.dtStable
                warnUser(
                    f"Scene: dt = {given:.3g} s is {given / scene.dtStable:.2g} of the longest stable step; "
                    "beside an implicit body bonded to others this step falls to half where soil crosses "
                    f"a line of the grid: give {good:.3g} s, or leave dt out"
                )
            self.dt = given
            self._warnOfCells()
        self.noteEstimate()

    def _warnOfCells(self):
        fast = self.speedDt()
        if self.dt > 2 * fast:
            warnUser(
                f"Scene: with dt = {self.dt:.3g} s the fastest particle or motion crosses "
                f"{limits.DT_CELLS * self.dt / fast:.2g} of a cell in a step, and impacts gain energy; "
                f"give at most {fast:.3g} s, or leave dt out"
            )

    def _leftOut(self):
        names = [f"'{body.name}'" for body in self._scene.bodies if body.implicit]
        return f"; implicit and left out: {', '.join(names)}" if names else ""

    def noteEstimate(self):
        """The step follows the estimate just made; growth counts from here."""
        self._estimatedStiffness = stiffnesses(self._scene)
        keep(self, estimatedAt=self._scene.steps)
        self.noteChecked()

    def noteChecked(self):
        """The time step suits the scene as it stands."""
        self._isStable, self._checkedState = True, self._stabilityState()

    @holding
    @takes(tolerance=POSITIVE, iterations=COUNT, asIfExplicit=FLAG)
    def estimateCriticalStep(self, tolerance=1e-4, iterations=300, asIfExplicit=False):
        """Critical step of the scene as it stands, s; sets scene.dtCritical and scene.stiffest.

        Parameters
        ----------
        tolerance : float, relative change over ten iterations at which to stop; default 1e-4.
        iterations : int, most iterations; default 300.
        asIfExplicit : bool, count the stiffness of implicit bodies, and set nothing; default False.
        """
        self._prepareChain()
        scene = self._scene
        found = scene._core.criticalTimeStep(tolerance, iterations, asIfExplicit)
        if asIfExplicit:
            return found["dt"]
        keep(scene, dtCritical=found["dt"], dtStable=found["longestStable"])
        keep(scene, _dtIterations=found["iterations"], stiffest=found["stiffest"])
        return scene.dtCritical

    def stiffening(self):
        """Bound on what the square of the fastest frequency has grown by since the last estimate, 1 at least.

        Each particle adds V (K A + mu B) / m to that of the whole, with A and B that have no negative
        eigenvalue: none can grow by more than the largest ratio, now to then, of K V/V0 and of mu V/V0, with
        K and mu of the particle as it stands.
        """
        return max([1.0, *(growth for bulk, shear, _ in self._ratios() for growth in (bulk, shear))])

    def refining(self):
        """Largest factor, at least 1, by which a body has gained particles since the last estimate."""
        return max([1.0, *(count for _, _, count in self._ratios())])

    def growthLimits(self):
        """What bodies may become before `stiffening` or `refining` reach DT_GROWTH, a little less: for each
        body the bulk and the shear modulus of `core.presentStiffness`, and the number of particles."""
        scene, share, found = self._scene, limits.DT_GROWTH * (1 - 1e-9), []
        blend = _blend(scene)
        for body in scene.bodies:
            if not scene.dtCritical or body.name not in self._estimatedStiffness:
                found.append((math.inf, math.inf, math.inf))  # no estimate yet
                continue
            bulk, shear, count = self._estimatedStiffness[body.name]
            scale = share * body.inertiaScale / blend
            found.append((scale * bulk, scale * shear, share * count))
        return found

    def _ratios(self):
        """Of `stiffnesses`, now to then, for each body that there was."""
        then = self._estimatedStiffness
        for name, now in stiffnesses(self._scene).items():
            if name in then:
                yield [b / a if a > 0 else 1.0 if b == 0 else math.inf for b, a in zip(now, then[name])]

    @holding
    @takes(growth=POSITIVE)
    def takeSafeDt(self, growth=1.0):
        """Steps by the share of the critical step that is taken where nobody has given dt, from now on.

        Parameters
        ----------
        growth : float, of the square of the fastest frequency since the estimate, -; default 1.
        """
        law = "USL" if _sharesImplicit(self._scene) else self._scene.scheme
        safe, longest = self.safeDt(), limits.DT_STABLE[law] * self._scene.dtStable / math.sqrt(growth)
        keep(self, automaticDt=min(safe, longest))
        self.followSpeed()

    def speedDt(self):
        """The step in which what moves fastest, a particle or a prescribed motion, moves DT_CELLS of the
        smallest cell, s."""
        scene = self._scene
        speeds = [np.abs(body.velocity).max(axis=0) for body in scene.bodies if body.count]
        speeds += [np.abs(np.nan_to_num(c._core.velocity)) for c in self._constraints]
        rate = np.max(speeds / np.array(scene.cell)) if speeds else 0.0
        return limits.DT_CELLS / rate if rate > 0 else math.inf

    def pressedDt(self, longest):
        """A step up to `longest` (s) at whose end moduli that follow the pressure are not too stiff for it.

        What a modulus gains within a step, over what it is, allows for DT_GAINED of the automatic step, as
        the root of the ratio.
        """
        dt, good = longest, limits.DT_GAINED * self.automaticDt
        while any((to / now - 1) * dt**2 > good**2 for now, to in self._reached(dt)):
            dt *= 0.9
        return dt

    def _reached(self, dt):
        """Of bodies whose moduli follow the pressure the bulk modulus now and after a step, kPa."""
        return [pair for pair in self._scene._core.reachedStiffness(dt) if pair[0] > 0]

    @property
    def followsPressure(self):
        """Whether a step makes bodies stiffer in a way that is known in advance."""
        return bool(self._reached(0.0))

    def followSpeed(self):
        """Steps by the automatic step, or a shorter one that suits the speed and what is pressed in it."""
        self.dt = self.pressedDt(min(self.automaticDt, self.speedDt()))

    def safeDt(self):
        """The share of the critical step that is taken where nobody has given dt, s."""
        if self._scene.dtCritical is None:
            raise RuntimeError("Stepper: the critical time step is not known yet; call scene.prepare()")
        return limits.DT_SAFETY[self._scene.scheme] * self._scene.dtCritical

    @property
    def isBounded(self):
        """Whether `stiffening` bounds all that has changed since the time step was checked."""
        return self._isStable and self._checkedState[1:] == self._stabilityState()[1:]

    def _stabilityState(self):
        """What the critical step depends on and may be changed between steps; first what `stiffening`
        bounds."""
        scene = self._scene
        stages = [e for e in scene.engines if not isinstance(e, Callback)]
        numbers = [(tuple(b.material._core.lameConstants), b.inertiaScale) for b in scene.bodies]
        numbers += [getattr(e, name) for e in stages for name in BLENDS.get(type(e).__name__, ())]
        kinds = [(type(e).__name__, e.dead) for e in stages]
        return numbers, kinds, [b.implicit for b in scene.bodies], scene._dt, scene.allowUnstable
