# SPDX-License-Identifier: GPL-2.0-or-later
"""The chain of engines of a scene, and what a scene sets at its GridSolver."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..base.wording import shown
from ..engine import chain
from ..engine.engine import Engine
from ..engine.gridSolver import GridSolver
from ..engine.prescribed import Prescribed
from . import asking
from .running import refuseDuringStep
from .timing import Timing


class HasEngines:
    """The part of a Scene that keeps its chain of engines whole and in order."""

    @property
    def gravity(self) -> np.ndarray:
        """Gravity of the GridSolver, m/s2 (dim,); set it by a number (downwards) or a vector."""
        return np.array(self._gridSolver("Scene").gravity or [0.0] * self.dim)

    @gravity.setter
    def gravity(self, value: ArrayLike) -> None:
        self._ask("gravity", asking.gravityVector(self, value))

    @property
    def damping(self) -> float:
        """Local damping of the GridSolver, -."""
        return self._gridSolver("Scene").damping

    @damping.setter
    def damping(self, value: float) -> None:
        self._ask("damping", value)

    def _ask(self, name, value):
        """Sets an attribute of the GridSolver, which has to stay from then on."""
        refuseDuringStep(self, name)
        solver = self._gridSolver("Scene")
        setattr(solver, name, value)
        self._asked.add(solver)

    @property
    def engines(self) -> list[Engine]:
        """The chain of engines; assign a list to change it.

        Default: ParticleToGrid, GridSolver, GridToParticle, DomainUpdater (USF: DomainUpdater before
        GridSolver). The scene adds VelocityRemap behind GridToParticle (USF: before DomainUpdater; USL: not).
        They serve this scene alone; `dead=True` leaves one out.
        """
        if self._engines is None:
            self.engines = chain.defaultChain()
            self._defaultSolver = self._gridSolver("Scene")
        return self._engines

    @engines.setter
    def engines(self, engines: Sequence[Engine]) -> None:
        refuseDuringStep(self, "engines")
        engines = list(engines) if isinstance(engines, (list, tuple)) else [engines]
        self._putInOrder(engines)
        self._engines = engines
        self.stepper.noteChange()

    _hasEngines = property(
        lambda self: self._engines is not None, doc="Whether engines were given, or made as a default."
    )

    def _putInOrder(self, engines):
        """Adds what the scheme asks for to a chain, in the list itself.

        TypeError for what is no engine, ValueError for stages in no order.
        """
        for engine in engines:
            if not isinstance(engine, Engine):
                kind = type(engine).__name__
                where = f"give it to GridSolver({kind.lower()}=...)" if isinstance(engine, Prescribed) else ""
                raise TypeError(
                    f"Scene: {shown(engine)} is not an engine; {where or 'give a list of engines'}"
                )
        order = self._core.stageOrder
        chain.complete(engines, order, self._added)
        chain.checkOrder(engines, order, self.scheme)
        self._asked.refuseLost(engines)

    def _isLeftAsMade(self):
        """Whether the GridSolver is that of the default chain, as it was: without gravity and walls."""
        solver = self._defaultSolver
        isThere = any(engine is solver for engine in self.engines)
        return isThere and not (any(solver.gravity) or solver._constraints(self))

    def _gridSolver(self, who):
        """The GridSolver among the engines; ValueError, in the name of `who`, if there is none."""
        for engine in self.engines:
            if isinstance(engine, GridSolver):
                return engine
        raise ValueError(f"{who}: there is no GridSolver among the engines; add one to scene.engines")

    @property
    def scheme(self) -> str:
        """ "MUSL", "USF" or "USL"."""
        return self._core.scheme

    @scheme.setter
    def scheme(self, name):
        if self._engines is not None:
            raise ValueError("Scene: set the scheme before the engines")
        if not isinstance(name, str):
            raise ValueError(
                f"Scene: scheme = {shown(name)} is not allowed; give one of 'MUSL', 'USF', 'USL'"
            )
        self._core.scheme = name

    def timing(self) -> Timing:
        """Dict engine -> (seconds, calls) since the scene was made; print it to see where threads wait.
        Engines of one kind without labels have numbers."""
        engines = {}
        for engine in self.engines:
            engines[asking.freeName(engine.label or type(engine).__name__, engines)] = engine
        return Timing(
            {name: (e.seconds, e.calls) for name, e in engines.items()},
            {name: e._core.threadUse for name, e in engines.items()},
            sum(body._core.bytes for body in self.bodies),
        )
