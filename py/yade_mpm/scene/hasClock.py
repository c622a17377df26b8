# SPDX-License-Identifier: GPL-2.0-or-later
"""Time, time step and threads of a scene."""

from __future__ import annotations

import numpy as np

from .. import _core
from ..base.attributes import ofCore
from ..base.kinds import COUNT, FLAG, POSITIVE, takes
from ..base.wording import shown
from .running import refuseDuringStep, refuseMidStep, refuseWhileRunning

MOST_THREADS = 1024
PARTICLES_PER_THREAD = 1000  # a block of 2000 is 1.5 times as fast on two (doc/explanation/performance.md)


class HasClock:
    """The part of a Scene that knows its time, its step and how many threads take it."""

    time = ofCore("time", "Scene time, s.")
    steps = ofCore("step", "Number of steps taken.")
    dtSpeed = property(
        lambda self: self.stepper.speedDt(),
        doc="Step in which what moves fastest moves 0.2 of the smallest cell, s.",
    )

    @property
    def dt(self) -> float | None:
        """Time step, s. Left out: 0.8 (USL: 0.55) of the critical step, which is estimated again every 5000
        steps and where stiffness has grown by a quarter: particles that grow or are cut, constants that a
        callback changes (doc/explanation/time-step.md)."""
        return self._dt if self._dt is not None else (self._core.dt or None)

    @dt.setter
    def dt(self, value: float | None) -> None:
        refuseDuringStep(self, "dt")
        if value is not None:  # None: an automatic step
            POSITIVE.check("Scene", "s; None: automatic", dt=value)
        self._dt = None if value is None else float(value)
        self.stepper.noteChange()

    @property
    def allowUnstable(self) -> bool:
        """Whether dt may exceed the longest stable step."""
        return self._allowUnstable

    @allowUnstable.setter
    def allowUnstable(self, value):
        FLAG.check("Scene", allowUnstable=value)
        self._allowUnstable = bool(value)

    @property
    def threads(self) -> int:
        """Number of threads in use.

        As given, or one for every 1000 particles but at most OMP_NUM_THREADS (all cores); a run tries a
        single one now and then, and stays with the faster.
        """
        byParticles = max(1, self.particleCount // PARTICLES_PER_THREAD)
        return self._threads or min(_core.availableThreads(), byParticles)

    @threads.setter
    def threads(self, value: int | None) -> None:
        isCount = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
        if value is not None and not (isCount and 1 <= value <= MOST_THREADS):
            raise ValueError(
                f"Scene: threads = {shown(value)} is not allowed; give a whole number from 1 to "
                f"{MOST_THREADS}, or None for a choice by the number of particles"
            )
        self._threads = None if value is None else int(value)
        self.stepper.noteChange(mayBeUnstable=False)

    @takes(tolerance=POSITIVE, iterations=COUNT, asIfExplicit=FLAG)
    def criticalTimeStep(
        self, tolerance: float = 1e-4, iterations: int = 300, asIfExplicit: bool = False
    ) -> float:
        """Critical time step of the scene as it stands, s: 2/omega_max of the assembled elastic grid
        operator, or the longest stable step of the scheme if that is shorter (doc/explanation/time-step.md).

        Also sets `dtCritical`, `dtStable` and `stiffest`. Source: spectral bound of the central-difference
        scheme and of the one-step map; Lanczos iteration.

        Parameters
        ----------
        tolerance : float, relative change of the eigenvalue over ten iterations at which to stop; default
            1e-4.
        iterations : int, most iterations; default 300.
        asIfExplicit : bool, whether the stiffness of implicit bodies counts like that of others, for
            comparison: nothing is set then; default False.
        """
        refuseWhileRunning(self, "criticalTimeStep")
        refuseMidStep(self, "criticalTimeStep")
        with self._holder.held("criticalTimeStep"):
            return self.stepper.estimateCriticalStep(tolerance, iterations, asIfExplicit)
