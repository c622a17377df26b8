# SPDX-License-Identifier: GPL-2.0-or-later
"""What a loop over steps does between them, and when: one policy for `Scene.run` and for the loop of YADE."""

import math
import time

import numpy as np

from ..check import domains, limits
from ..check.domains import OF_THE_RUN, checkFields, checkInterface, distortion, leftBehind
from ..check.touching import squeezed
from ..engine.callback import Callback
from ..engine.engine import NO_CALL
from ..engine.gridSolver import GridSolver
from ..material.materials import MaterialPoint
from ..material.spatial import isSpatial

SHARE = 0.01  # of the wall time of a run that checkpoints may take


class LoopPolicy:
    """Looks at the domains, estimates the critical step again, saves, and lets callbacks stop the loop.

    A loop calls `beforeSteps`, takes at most `stepsToNext` steps, and calls `afterSteps`. What is due follows
    from the number of steps: a loop that is cut in pieces, each with a policy of its own, does the same.

    Parameters
    ----------
    scene : Scene
    say : function of a text, for warnings.
    save : function without argument that writes a checkpoint; default: none is written.
    savePeriod : float, s of wall time between checkpoints; None (default): none is written.
    stride : int, steps that the loop takes at a time; default 1.
    followsSpeed : bool, whether an automatic step follows the speed between estimates; default True.
    """

    def __init__(self, scene, say, save=None, savePeriod=None, stride=1, followsSpeed=True):
        self._scene, self._say, self._save, self._savePeriod = scene, say, save, savePeriod
        self._followsSpeed = followsSpeed
        self._checkAt = _firstAt(scene.steps, limits.CHECK_PERIOD, stride)
        self._estimateAt = _firstAt(scene.steps, limits.DT_PERIOD, stride)
        self._isPressed = any(followsStress(body.material) for body in scene.bodies)
        self._isPressedInSteps = self._isPressed and followsSpeed and scene.stepper.followsPressure
        self.lookPeriod = limits.DT_LOOK_PRESSED if self._isPressed else limits.DT_LOOK
        self._lookAt = _firstAt(scene.steps, self._lookPeriodAt(scene.steps), stride)
        self._saveAt = math.inf if savePeriod is None else time.monotonic() + savePeriod

    def beforeSteps(self):
        """Looks at the domains and estimates the critical step where that is due.

        Returns whether the critical step was estimated. Raises RuntimeError where an interface has become too
        coarse.
        """
        steps = self._scene.steps
        scene = self._scene
        self._warnOnce({"overlap": domains.deepOverlap(scene), "cost": domains.costlyBodies(scene)})
        if steps >= self._checkAt:
            self._checkAt = _nextAt(steps, limits.CHECK_PERIOD)
            self.lookAtDomains(limits.INTERFACE_RUN)
            self.lookAtFields()
        isChanged = False
        if steps >= self._lookAt:
            self._lookAt = _nextAt(steps, self._lookPeriodAt(steps))
            isChanged = self._followGrowth() or self._followSpeed()
        if steps < self._estimateAt:
            return isChanged
        self._estimateAt = _nextAt(steps, limits.DT_PERIOD)
        if self._scene.stepper.estimatedAt != steps:
            self._estimate()
        return True

    def stepsToNext(self):
        """Steps until something is due, or a callback may have been called, which may want to stop the
        loop."""
        scene = self._scene
        calls = [engine.stepsToCall(scene) for engine in scene.engines]
        due = min(self._checkAt, self._estimateAt, self._lookAt)
        return min([due - scene.steps, *calls])

    def cyclesToNext(self, stride):
        """Cycles of `stride` steps that need nothing but looks at growth, see `nextLook`: a check is due
        before a cycle, and a callback may be called in one."""
        scene = self._scene
        calls = min((engine.stepsToCall(scene) for engine in scene.engines), default=NO_CALL)
        due = min(self._checkAt, self._estimateAt) - scene.steps
        return min((due - 1) // stride + 1, (calls - 1) // stride)

    nextLook = property(lambda self: self._lookAt, doc="Step of the next look at growth.")

    def noteLooks(self, nextLook):
        """Someone else has looked, and found that no body had passed its limit (`Stepper.growthLimits`)."""
        self._lookAt = max(self._lookAt, nextLook)

    def afterSteps(self):
        """Follows what callbacks have changed, and writes a checkpoint where that is due; a file that cannot
        be written makes a warning."""
        if any(isinstance(engine, Callback) for engine in self._scene.engines):
            self.followChanges()
        began = time.monotonic()
        if began < self._saveAt:
            return
        try:
            self._save()
        except (OSError, MemoryError) as error:
            self._say(f"warning: step {self._scene.steps}: {error}; the run goes on")
        now = time.monotonic()
        self._saveAt = now + max(self._savePeriod, (now - began) / SHARE)

    def followChanges(self):
        """Finds the step that suits what callbacks have changed: stiffness, inertia, damping, flip.

        The critical step is estimated where the scene may have become much stiffer, or nothing bounds the
        change. A small one shortens an automatic step by its bound, and counts for a given one only where it
        passes that: changes in every step are cheap. Returns whether the step may be another one.
        """
        stepper, given = self._scene.stepper, self._scene._dt
        if not stepper.isPrepared or stepper.isChecked:
            return False  # what is not prepared is checked when it is
        growth = stepper.stiffening()
        longest = (self._scene.dtStable or 0.0) / math.sqrt(growth)
        if not stepper.isBounded or growth >= limits.DT_GROWTH or (given is not None and given > longest):
            self._estimate()
        elif given is None:
            stepper.takeSafeDt(growth)
        stepper.noteChecked()
        return True

    def lookAtFields(self):
        """Ends the run by RuntimeError where a field holds what no matter has, as a callback may leave it."""
        for body in self._scene.bodies:
            try:
                checkFields(body, OF_THE_RUN)
            except ValueError as error:
                raise RuntimeError(f"step {self._scene.steps}: {error}") from error

    def lookAtDomains(self, longest):
        """Warns, once each, of long edges beside uGIMP, of distorted domains, of soil between two bodies, of
        bodies that lock or opened, of meshes that flow.

        Parameters
        ----------
        longest : float, cells; edges beside uGIMP that are longer end the run by RuntimeError.
        """
        scene = self._scene
        faults = {"interface": checkInterface(scene, longest), "distortion": distortion(scene)}
        faults["narrow"] = squeezed(scene)
        for body in scene.bodies:
            looks = {"locking": domains.locking, "opening": domains.opened, "flow": domains.flowing}
            faults |= {f"{what} of {body.name}": look(body) for what, look in looks.items()}
        for solver in (e for e in scene.engines if isinstance(e, GridSolver)):
            faults |= {f"way of {hold.name}": leftBehind(scene, hold) for hold in solver.holds}
        self._warnOnce(faults)

    def _lookPeriodAt(self, steps):
        """Steps between looks at growth: a scene without stress is stiffer by far after each of its first,
        and a step that follows the pressure is found for each."""
        isEarly = self._isPressed and steps < limits.DT_EARLY
        return 1 if isEarly or self._isPressedInSteps else self.lookPeriod

    def _warnOnce(self, faults):
        """Says each fault that is one, as a dict of texts or None, once in the life of the scene."""
        scene = self._scene
        for what, fault in faults.items():
            if fault is not None and what not in scene._warnedOf:
                scene._warnedOf.add(what)
                self._say(f"warning: step {scene.steps}: {fault}")

    def _followGrowth(self):
        """Estimates where particles have grown, or were cut, since the last time; before that is due, a step
        that was left out becomes shorter. Returns whether either was done."""
        stepper = self._scene.stepper
        growth = stepper.stiffening()
        if max(growth, stepper.refining()) < limits.DT_GROWTH or not self._scene.dtCritical:
            return False
        isKnown = growth < math.inf  # not where what had no stiffness has some
        if self._scene.steps >= stepper.estimatedAt + limits.DT_LEAST_PERIOD or not isKnown:
            self._estimate()
        elif self._scene._dt is None:
            stepper.takeSafeDt(growth)
        return True

    def _followSpeed(self):
        """Whether a step that was left out has become another one, for the speed has."""
        stepper = self._scene.stepper
        if not self._followsSpeed or self._scene._dt is not None or stepper.automaticDt is None:
            return False
        before = stepper.dt
        stepper.followSpeed()
        return stepper.dt != before

    def _estimate(self):
        scene, stepper = self._scene, self._scene.stepper
        critical = stepper.estimateCriticalStep()
        stepper.noteEstimate()
        if not critical > 0:
            return  # every node is held: nothing to go by
        if scene._dt is None:
            stepper.takeSafeDt()
        elif scene._dt > scene.dtStable and not scene.allowUnstable:
            self._say(
                f"warning: step {scene.steps}: dt = {scene._dt:.3g} s now exceeds the longest stable "
                f"step {scene.dtStable:.3g} s (stiffest: '{scene.stiffest}')"
            )


def followsStress(material):
    """Whether the stiffness of a law is another one under pressure; True where the law cannot tell."""
    power = material.attributes().get("pressureExponent", 0)
    if isSpatial(power) or power != 0:
        return True  # whatever moduli vary in space, which have no number to go by
    core = material._core
    pressure, state = core.lameConstants[1], {name: core.value(name) or 1.0 for name in material._spatial}
    try:
        free, pressed = (MaterialPoint(material, -p * np.eye(3), state).stiffness for p in (0.0, pressure))
    except ValueError:  # its stress follows from F alone, and so does its stiffness
        return False
    except RuntimeError:  # a routine from elsewhere that fails at these stresses
        return True
    return free != pressed


def _firstAt(steps, period, stride):
    """Step at which a loop that begins has something to do: now, if it was due behind the steps taken
    last."""
    latest = steps // period * period
    return latest if latest > max(0, steps - stride) else latest + period


def _nextAt(steps, period):
    return (steps // period + 1) * period
