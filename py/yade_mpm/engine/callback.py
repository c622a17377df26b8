# SPDX-License-Identifier: GPL-2.0-or-later
"""Engines that call back into Python."""

from __future__ import annotations

import inspect
import sys
import weakref
from collections.abc import Callable

from .. import _core
from ..base.attributes import keep, plain
from ..base.keywords import checked
from ..base.kinds import NUMBER
from ..base.wording import shown
from .engine import NO_CALL, Engine


class Callback(Engine):
    """Base of engines that call back into Python: every `iterPeriod` steps or every `period` s of scene time.

    A class that adds `spec()`, a dict of constructor arguments that JSON can hold, is restored from
    checkpoints.
    """

    _hooks = ("act", "bind", "flush", "restoreState", "spec", "state", "stepsToCall")

    @checked("Callback")
    def __init__(self, iterPeriod: int = 0, period: float = 0.0, label: str = "", dead: bool = False) -> None:
        # The solver refers to the object weakly: a cycle through it would never be collected.
        method = weakref.WeakMethod(self._call)
        object.__setattr__(self, "_core", _core.makePythonEngine(lambda: method()()))
        for name, value in dict(iterPeriod=iterPeriod, period=period, label=label, dead=dead).items():
            self._core.set(name, plain(value))
        self._scene = None

    def bind(self, scene):
        self._scene = scene

    def _call(self):
        keep(self._scene.stepper, acting=self)
        self.act(self._scene)
        keep(self._scene.stepper, acting=None)

    def stepsToCall(self, scene):
        dt, steps = scene._core.dt, NO_CALL
        if self.iterPeriod > 0:
            past = scene.steps % self.iterPeriod
            steps = self.iterPeriod - past if past else 1
        if self.period > 0:
            past = scene.time % self.period
            steps = min(steps, max(1, int((self.period - past) / dt) - 1) if past > dt else 1)
        return steps

    def state(self):
        """Dict of plain types that a run has found, which a checkpoint keeps for `restoreState`."""
        return {}

    def restoreState(self, state):
        """Goes on from what `state` has given."""

    def act(self, scene):
        """What to do; the scene is at rest between two engines meanwhile."""
        raise NotImplementedError


class PyRunner(Callback):
    """Calls a Python function every `iterPeriod` steps or every `period` seconds of scene time.

    Parameters
    ----------
    command : function of no argument, or of the scene; or a string that is executed in __main__, with `scene`
        defined.
    iterPeriod : steps between calls; or
    period : scene time between calls, s. One of the two is needed.
    label : name of the engine; default "".
    dead : leave the engine out; default False.
    """

    @checked("PyRunner")
    def __init__(
        self,
        command: Callable | str,
        iterPeriod: int = 0,
        period: float = 0.0,
        label: str = "",
        dead: bool = False,
    ) -> None:
        if not (callable(command) or isinstance(command, str)):
            raise TypeError(f"PyRunner: command = {shown(command)}; give a function or a string")
        if all(p is None or NUMBER.isOne(p) and p == 0 for p in (iterPeriod, period)):
            raise ValueError("PyRunner: give iterPeriod (steps) or period (s)")
        super().__init__(iterPeriod, period, label, dead)
        self._command = command
        self._code = _compiled(command) if isinstance(command, str) else None
        self._wantsScene = callable(command) and _takesArgument(command)

    command = property(lambda self: self._command, doc="What is called.")

    def __repr__(self):
        period = f"period={self.period!r}" if self.period else f"iterPeriod={self.iterPeriod!r}"
        label = f", label={self.label!r}" if self.label else ""
        return f"PyRunner({shown(self._command)}, {period}{label})"

    def spec(self):
        """Constructor arguments for a checkpoint; a function cannot be stored: TypeError."""
        if not isinstance(self._command, str):
            raise TypeError("PyRunner: a function cannot be stored; give a string that is executed")
        return {"command": self._command, "iterPeriod": self.iterPeriod, "period": self.period}

    def act(self, scene):
        if isinstance(self._command, str):
            exec(self._code, dict(vars(sys.modules["__main__"]), scene=scene))
        elif self._wantsScene:
            self._command(scene)
        else:
            self._command()


def _compiled(text):
    try:
        return compile(text, "<PyRunner>", "exec")
    except SyntaxError as error:
        said = f"PyRunner: command = {shown(text)} is not allowed: {error.msg}; give Python, or a function"
        raise SyntaxError(said, error.args[1]) from None


def _takesArgument(function):
    try:
        parameters = inspect.signature(function).parameters.values()
    except ValueError:
        return False
    return any(
        p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters
    )


def checkPeriod(who, period, iterPeriod):
    """Raises ValueError unless exactly one period is given and positive."""
    if not (
        NUMBER.isOne(period)
        and NUMBER.isOne(iterPeriod)
        and (period > 0) != (iterPeriod > 0)
        and period >= 0
        and iterPeriod >= 0
        and iterPeriod == int(iterPeriod)
    ):
        raise ValueError(
            f"{who}: period = {shown(period)} s, iterPeriod = {shown(iterPeriod)} is not allowed; give one "
            "of the two, positive: scene time or number of steps between records"
        )
