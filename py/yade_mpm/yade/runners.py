# SPDX-License-Identifier: GPL-2.0-or-later
"""Engines of a scene as objects in O.engines: PyRunners whose attributes are those of the engines.

O.engines holds the very objects. YADE sees a PyRunner (MpmEngine, with the plugin) that acts in every step;
Python sees `GridSolver` with `gravity` and `damping`.
"""

import functools

from .grants import unfoldAll
from .native import baseOfEngines

OWN = "label", "dead", "ompThreads"  # attributes that YADE gives to every engine, and users may set
PACE = {
    "iterPeriod": 1,
    "virtPeriod": 0,
    "realPeriod": 0,
    "nDo": -1,
    "firstIterRun": 0,
    "initRun": True,
}  # of the PyRunner; a stage acts in every step
OURS = {"virtPeriod": "period"}  # YADE's word for scene time between calls -> that of our engines


@functools.cache
def baseOfRunners():
    """The class `MpmEngine`, a PyRunner of YADE."""
    base = baseOfEngines()

    class MpmEngine(base):
        """An engine of a scene in O.engines; `engine` is the engine itself.

        Attributes are those of the engine, besides `label`, `dead`, `ompThreads`, `execTime` and `execCount`
        of every engine of YADE. It acts in every step: `iterPeriod` and the like are those of the engine
        where it has any, as `History`, and cannot be set else.
        """

        def __init__(self, engine, label, command, stage):
            native = {} if stage is None or not hasattr(base, "stage") else {"stage": stage}
            base.__init__(self, label=label, command=command, updateGlobals=False, **native, **PACE)
            self.__dict__["engine"] = engine

        def __getattribute__(self, name):
            if name in PACE and (own := OURS.get(name, name)) in _namesOf(self.engine):
                return getattr(self.engine, own)
            return super().__getattribute__(name)

        def __getattr__(self, name):
            if name.startswith("__") or name == "engine":
                raise AttributeError(name)
            return getattr(self.engine, name)

        def __setattr__(self, name, value):
            if name in OWN:
                base.__setattr__(self, name, value)
                unfoldAll()
            elif (name := OURS.get(name, name)) in _namesOf(self.engine) or not hasattr(base, name):
                setattr(self.engine, name, value)
            else:
                raise AttributeError(
                    f"{self.label}: {name} cannot be set; the engines of a scene act in every step of YADE "
                    "(dead=True leaves one out)"
                )

        def updateAttrs(self, attributes):
            """Sets attributes by a dict of name and value."""
            for name, value in attributes.items():
                setattr(self, name, value)

        def __dir__(self):
            return sorted({*super().__dir__(), *dir(self.engine)})

        def dict(self):
            """Attributes and their values; those of the engine, and label, dead and ompThreads of YADE's."""
            own = base.dict(self)
            return {**{name: own[name] for name in OWN}, **_attributesOf(self.engine, _namesOf(self.engine))}

        def __repr__(self):
            return f"<{self.label}: {self.engine!r}>"

        __str__ = __repr__

    return MpmEngine


def runnerOf(engine, label, command, stage=None):
    """The engine of YADE that lets an engine of a scene act; its class has the same name.

    stage : number of the engine in the chain; None for the whole scene.
    """
    return _classOf(type(engine))(engine, label, command, stage)


@functools.cache
def _classOf(kind):
    return type(kind.__name__, (baseOfRunners(),), {"__doc__": kind.__doc__, "__module__": kind.__module__})


def paceOf(runner):
    """How often YADE lets an engine of ours act: a dict with the names of PACE."""
    from yade.wrapper import PyRunner

    own = PyRunner.dict(runner)
    return {name: own[name] for name in PACE}


class Chain:
    """The engines of a scene where they act as one engine of YADE.

    scene : the scene. Every engine is an attribute by its label, or else by the name of its class:
    `O.engines[5].GridSolver.gravity`.
    """

    def __init__(self, scene):
        self.__dict__["scene"] = scene

    def _attributeNames(self):
        """Names of the engines."""
        return list(self.attributes())

    def attributes(self):
        """Dict of the engines by name."""
        return {e.label or type(e).__name__: e for e in self.scene.engines}

    def __getattr__(self, name):
        engines = self.attributes() if name != "scene" else {}
        if name not in engines:
            raise AttributeError(
                f"yadeMpm: there is no engine '{name}' in the scene; it has {', '.join(engines)}"
            )
        return engines[name]

    def __setattr__(self, name, value):
        raise AttributeError(
            f"yadeMpm: the scene as one engine has no attribute {name}; set those of its engines"
        )

    def __dir__(self):
        return [*super().__dir__(), *self._attributeNames()]

    def __repr__(self):
        return f"{self.scene!r}, {' -> '.join(self.attributes())}"


def _namesOf(engine):
    return [name for name in engine._attributeNames() if name not in OWN]


def _attributesOf(engine, names):
    return {name: value for name, value in engine.attributes().items() if name in names}
