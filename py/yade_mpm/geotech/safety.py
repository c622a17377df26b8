# SPDX-License-Identifier: GPL-2.0-or-later
"""Factor of safety of ground by strength reduction: the number that divides its strength when it fails.

    found = mpm.safety(build)  # build() -> scene with gravity, before its first step
    print(found)               # factor of safety 1.40: stands at 1.39, fails at 1.41 (8 trials)
    found.plot()

Ground fails where in the last quarter of a trial its largest displacement still grows, or is a large part of
its height: it has come down then, and may rest. Velocities of single particles tell nothing: where soil
yields at rest some swing against their neighbours, and the nodes do not feel it.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass

import numpy as np

from .. import _core
from ..base.kinds import COUNT, FLAG, FUNCTION, POSITIVE, takes
from ..base.wording import shown
from ..diagnostics.drainage import consolidation
from ..engine.callback import PyRunner
from ..engine.poreWater import waterOf
from ..geometry.numbers import isNumber
from ..io.history import History
from ..io.recorder import Recorder
from ..scene.restoring import load
from ..scene.scene import Scene
from .sideBySide import callEach
from .strength import divideStrength

DAMPING = 0.3  # -, local, where the scene has less
STILL = 0.02  # growth of the largest displacement in the last quarter of a trial that is none, -
FALLEN = 0.05  # displacement over the height, beyond that of ground that stands, at which it has come down, -
FALLEN_FIRST = 0.2  # the same in the first trial: with the settlement under its own weight
DRAINED = 10.0  # c_v t/H2 of a trial, t = sqrt(height/gravity), -
LEAST = 1e-3  # part of gravity that a trial begins with, so that the heads of water have a pressure
RAISE_EVERY = 10  # steps between two increments of gravity
RAMP, HOLD = 1.0, 2.0  # times sqrt(height/gravity): gravity grows, and a trial lasts
FARTHEST = 0.05, 20.0  # factors between which the search looks, -


@dataclass(frozen=True)
class Trial:
    """Ground with its strength divided by a factor: the largest displacement, m, and whether it fails."""

    factor: float
    displacement: float
    fails: bool


class Safety:
    """What `mpm.safety` has found.

    Attributes
    ----------
    factor : factor of safety, -, the middle of `stands` and `fails`.
    stands, fails : the largest factor at which the ground stands, and the smallest at which it fails, -.
    trials : list of Trial, by factor, from the first at which the ground stands.
    height : of the ground, m.
    scene : the ground as it fails at `fails`.
    """

    def __init__(self, trials, height, scene):
        self.trials = sorted(trials, key=lambda trial: trial.factor)
        self.height, self.scene = height, scene
        self.fails = min(t.factor for t in trials if t.fails)
        self.stands = max(t.factor for t in trials if not t.fails and t.factor < self.fails)
        self.factor = 0.5 * (self.stands + self.fails)

    def plot(self, file=None, references=None):
        """Draws the ground as it fails, coloured by plastic shear strain, beside the displacements of all
        trials.

        Parameters
        ----------
        file : str, name of the picture; default: none, only the figure.
        references : dict label -> factor, or (low, high), to compare with.

        Returns the figure.
        """
        from .safetyPicture import draw

        return draw(self, references or {}, file)

    def __repr__(self):
        return (
            f"factor of safety {self.factor:.2f}: stands at {self.stands:.3g}, fails at {self.fails:.3g} "
            f"({len(self.trials)} trials)"
        )


@takes(build=FUNCTION, within=POSITIVE, progress=FLAG, jobs=COUNT)
def safety(build, between=(1.0, 2.0), within=0.02, progress=True, jobs=1):
    """Factor of safety by strength reduction: cohesion, tan(phi) and strength of all soils are divided by it.

        def build():
            scene = mpm.Scene((0, 0), (36, 12), cell=0.5, gravity=9.81)
            scene.fix("bottom")
            scene.roller("left", "right")
            scene.add("soil", mpm.polygon([(0, 0), (32, 0), (12, 10), (0, 10)]), clay)
            return scene

        found = mpm.safety(build)

    Parameters
    ----------
    build : function without arguments that returns the scene with its gravity, before its first step. Where
        its soil has no stress yet, gravity grows from zero.
    between : two factors, -, at which the ground is expected to stand and to fail; default 1 and 2. The
        search goes on beyond them if it has to, from 0.05 to 20.
    within : width of the interval at which the search ends, -; default 0.02.
    progress : bool, tells each trial in a line; default True.
    jobs : trials at once; default 1, bisection. Each has a process, its memory and its share of the cores;
        they divide the interval into jobs + 1 parts. Any build() will do.

    Returns a `Safety`. The first trial, at which the ground stands, is the state from which all others begin:
    their strength falls, and they are watched for 2 sqrt(height/g) seconds. Trials have local damping of 0.3
    at least. psi is never above phi. Water drains as in the long term, at levels that stay.
    Raises TypeError where build() returns no scene, ValueError without gravity, without a soil whose strength
    can be divided or for levels over time, RuntimeError where the ground stands or fails at all factors, or a
    trial ends with an error.

    Source: Griffiths & Lane 1999, Geotechnique 49, 387-403 (strength reduction, failure by displacements that
    do not come to rest).
    """
    low, high = _factors(between)
    search = _Search(build, progress)
    with search:
        while search.fails(low):
            low, high = low / 2, low
        fails = None
        while fails is None:
            low, fails = search.narrow(low, [*_between(low, high, jobs), high])
            high *= 2
        while fails - low > max(within, 2 * np.spacing(fails)):
            low, fails = search.narrow(low, _between(low, fails, jobs + 1), fails)
    return Safety(search.trials, search.height, search.failed)


@takes(build=FUNCTION, factor=POSITIVE)
def trial(build, factor):
    """One trial of `safety`, with the strength divided by a factor: (Trial, scene at its end).

    build, factor : as of `safety`.
    """
    with _Search(build, progress=False) as search:
        search.fails(factor)
        return search.trials[0], search.scene


def _ground(scene):
    """Bodies that yield, or all: a structure that moves alone is no failure of the ground."""
    bodies = [b for b in scene.bodies if b.count]
    return [b for b in bodies if b.material._core.yields] or bodies


def _drain(scene, height, seconds):
    """Lets water flow through the ground within a trial, at the ratios of permeability that soils have: its
    pressure is then that of steady flow, as it is in the long term."""
    wet = [body for body in scene.bodies if body._core.hasPores]
    slowest = min(consolidation(scene), default=np.inf)
    if wet and not slowest > 0:
        raise ValueError(
            f"safety: '{wet[0].name}' has water and a permeability of 0, so its weight would stay in the "
            "water; give a permeability, or leave water out and give undrained strengths"
        )
    if wet and (moving := waterOf(scene)._overTime()):
        raise ValueError(
            f"safety: levels of the water ({moving[0]}) change with time, and a factor is of one moment; "
            "let build() give the level of that moment"
        )
    for body in wet:
        body.permeability *= max(1.0, DRAINED * height**2 / (slowest * seconds))


def _factors(between):
    isPair = isinstance(between, (tuple, list)) and len(between) == 2 and all(isNumber(f) for f in between)
    if not isPair or not 0 < between[0] < between[1]:
        raise ValueError(
            f"safety: between = {shown(between)} is not allowed; give two factors, the smaller one first, "
            "e.g. (1, 2)"
        )
    return float(between[0]), float(between[1])


def _between(low, high, parts):
    """Factors that divide an interval into equal parts."""
    return [(low * (parts - i) + high * i) / parts for i in range(1, parts)]


class _Search:
    """Trials; all begin where the ground stood at the smallest factor."""

    def __init__(self, build, progress):
        self._build, self._progress = build, progress
        self.trials, self.scene, self.failed, self._stood = [], None, None, None
        self._share = None  # threads of a trial beside others

    def __enter__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="safety")
        return self

    def __exit__(self, *_):
        self._folder.cleanup()

    def fails(self, factor):
        """Whether the ground fails at a factor."""
        self._check(factor)
        trial = self._try(factor)
        if not trial.fails and self._stood is None:
            self._stood = os.path.join(self._folder.name, "stands.h5")
            self.trials = []  # those before it began with the ground without stress
            self.scene.save(self._stood)
        self._note(trial)
        if trial.fails and factor == min(t.factor for t in self.trials if t.fails):
            self.failed = self.scene
        return trial.fails

    def narrow(self, low, factors, high=None):
        """The interval within which the ground begins to fail, after trials side by side at factors between
        its ends.

        factors : rising. high : the upper end, or None where none is known yet, neither after them perhaps.
        """
        if len(factors) == 1:
            return (low, factors[0]) if self.fails(factors[0]) else (factors[0], high)
        self._check(factors[-1])
        self._share = max(1, _core.availableThreads() // len(factors))
        trials = callEach(self._tryAndSave, factors, "safety: the trial at factor")
        for trial in trials:
            self._note(trial)
        first = next((i for i, trial in enumerate(trials) if trial.fails), len(trials))
        if first < len(trials):
            self.failed, high = load(self._file(factors[first])), factors[first]
            self.failed.threads = self._given
        return [low, *factors][first], high

    def _check(self, factor):
        if not FARTHEST[0] <= factor <= FARTHEST[1]:
            raise RuntimeError(
                f"safety: the ground {'fails' if factor < 1 else 'stands'} at every factor from "
                f"{FARTHEST[0]:g} to {FARTHEST[1]:g}; look at single trials with scene.run(), and at what "
                "holds the ground"
            )

    def _try(self, factor):
        self.scene, ramp = self._loaded(factor) if self._stood else self._new(factor)
        try:
            return self._watch(self.scene, factor, ramp)
        except Exception as error:
            raise RuntimeError(
                f"safety: the trial at factor {factor:.4g} ended with {type(error).__name__}: {error}"
            ) from error

    def _tryAndSave(self, factor):
        """A trial beside others, which leaves its scene in a file where it fails."""
        trial = self._try(factor)
        if trial.fails:
            self.scene.save(self._file(factor))
        return trial

    def _file(self, factor):
        return os.path.join(self._folder.name, f"{factor!r}.h5")

    def _note(self, trial):
        self.trials.append(trial)
        if self._progress:
            print(
                f"safety: {'fails' if trial.fails else 'stands'} at {trial.factor:.4g}, moved "
                f"{trial.displacement:.3g} m"
            )

    def _new(self, factor):
        """A scene of the user's with weaker soil, and over how long its gravity grows, s."""
        built = self._build()
        if not isinstance(built, Scene):
            raise TypeError(f"safety: build() returns {type(built).__name__}; return the scene")
        self._given = built._threads
        scene = self._copy(built)  # with materials of its own: those of build() keep their strength
        self._gravity = np.array(scene._gridSolver("safety").gravity, float)
        if not self._gravity.any():
            raise ValueError("safety: the scene has no gravity; give it, e.g. mpm.Scene(..., gravity=9.81)")
        ends = [b.reference[:, -1] for b in _ground(scene)]
        self.height = float(np.ptp(np.concatenate(ends)))
        self._time = np.sqrt(self.height / np.linalg.norm(self._gravity))
        divideStrength(scene, factor)
        _drain(scene, self.height, self._time)
        hasStress = any(body.stress.any() for body in scene.bodies)
        return scene, 0.0 if hasStress else RAMP * self._time

    def _copy(self, scene):
        files = (History, Recorder)  # trials write nothing to the files of the user
        scene.engines = [engine for engine in scene.engines if not isinstance(engine, files)]
        file = os.path.join(self._folder.name, "copy.h5")
        scene.save(file)
        return load(file)

    def _loaded(self, factor):
        scene = load(self._stood)
        if self._share:
            scene.threads = min(scene.threads, self._share)
        divideStrength(scene, factor / self.trials[0].factor)
        return scene, 0.0

    def _watch(self, scene, factor, ramp):
        solver = scene._gridSolver("safety")
        solver.damping = max(solver.damping, DAMPING)
        began = scene.time
        if ramp:

            def raiseGravity():
                solver.gravity = self._gravity * np.clip((scene.time - began) / ramp, LEAST, 1.0)

            raiseGravity()
            for body in (b for b in scene.bodies if b._core.hasPores):
                body.porePressure = waterOf(scene).hydrostatic(body)

            engines = scene.engines
            scene.engines = [PyRunner(raiseGravity, iterPeriod=RAISE_EVERY), *engines]
            scene.run(until=began + ramp, progress=False)
            solver.gravity = self._gravity
            scene.engines = engines
        moved = []
        for share in (0.75, 1.0):
            scene.run(until=began + ramp + share * HOLD * self._time, progress=False)
            moved.append(max(np.linalg.norm(b.displacement, axis=1).max() for b in _ground(scene)))
        share, settled = (FALLEN, self.trials[0].displacement) if self._stood else (FALLEN_FIRST, 0.0)
        hasFallen = moved[1] > share * self.height + settled
        return Trial(factor, float(moved[1]), bool(hasFallen or moved[1] > (1 + STILL) * moved[0]))
