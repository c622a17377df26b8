# SPDX-License-Identifier: GPL-2.0-or-later
"""Engines of a checkpoint, with prescribed motions; callbacks come from the caller, or from a spec."""

from ..base.attributes import keep
from ..base.warn import warnUser
from ..base.wording import shown
from ..engine.callback import Callback, PyRunner
from ..engine.engines import classes as engineClasses
from ..engine.gridSolver import GridSolver, wall
from ..engine.prescribed import Drive, Hold
from ..geometry.regions import regionFromSpec
from ..io.columns import Columns
from ..particle.part import BodyPart
from .restoringBodies import classOf
from .saving import CONSTRAINT_STATE


def buildEngine(spec, scene, callbacks, permissions, file):
    """The engine of an entry of a checkpoint; None: it is left out.

    spec : the entry. callbacks : dict label -> function, those used are taken out. permissions :
    `Permissions` of the file.
    """
    if spec["class"] == "GridSolver":
        return _buildSolver(spec, scene)
    if permissions.isText(spec) and (label := permissions.instead(spec)) is not None:
        return _givenCallback({**spec, "callback": label}, callbacks, file)
    if "spec" in spec:
        if spec["class"] in ("Recorder", "History") and spec["spec"]["file"] is not None:
            place = permissions.place(spec["spec"]["file"], spec["class"])
            if place is None and spec["class"] == "Recorder":
                return None
            spec = {**spec, "spec": {**spec["spec"], "file": place}}
        return _buildCallback(classOf({**engineClasses, **_callbackClasses()}, spec, file), spec)
    if "callback" in spec:
        return _givenCallback(spec, callbacks, file)
    cls = classOf(engineClasses, spec, file)
    if issubclass(cls, Callback):  # whose arguments nobody has looked at, a text that runs among them
        raise ValueError(
            f"checkpoint '{file}' has a {spec['class']} without what it was made from; use another"
        )
    if not cls._found:
        return cls(**spec["attributes"])
    engine = cls()
    engine.restoreState(spec.get("state", {}), spec["attributes"])
    return engine


def _callbackClasses():
    """Dict name -> class of everything derived from Callback."""
    found, rest = {}, Callback.__subclasses__()
    while rest:
        cls = rest.pop()
        found.setdefault(cls.__name__, cls)
        rest.extend(cls.__subclasses__())
    return found


def _buildCallback(cls, spec):
    arguments = dict(spec["spec"])
    if spec["class"] == "History":
        arguments["columns"] = {name: _columnOf(name, text) for name, text in arguments["columns"].items()}
    engine = cls(**arguments)
    engine.restoreState(spec.get("state", {}))
    for name, value in spec["attributes"].items():
        engine._core.set(name, value)
    return engine


def _columnOf(name, text):
    """Text of a column; None, with a warning, for one that only an earlier version understood."""
    try:
        Columns({name: text})
    except (ValueError, SyntaxError) as error:
        warnUser(f"load: {error}; the column is nan until then")
        return None
    return text


def _givenCallback(spec, callbacks, file):
    label, attributes = spec["callback"], spec["attributes"]
    if label not in callbacks:
        raise ValueError(
            f"checkpoint '{file}' has the callback '{label}', which cannot be stored; give "
            f"load(file, callbacks={{'{label}': function}}), or None in its place to leave it out"
        )
    given = callbacks.pop(label)
    if given is None or isinstance(given, Callback):
        return given
    if spec["class"] != "PyRunner":
        raise TypeError(
            f"load: callbacks['{label}'] = {shown(given)}; give an engine of the class {spec['class']}"
        )
    return PyRunner(given, **attributes)


def _buildSolver(spec, scene):
    holds = []
    for h in spec["hold"]:
        where = h["where"] if isinstance(h["where"], str) else regionFromSpec(h["where"])
        holds.append(_restored(Hold(where, h["velocity"], h["ramp"], h["name"]), h))
    drives = [
        _restored(Drive(_part(d, scene), d["velocity"], d["ramp"], d["name"], d.get("byHeight", True)), d)
        for d in spec["drive"]
    ]
    solver = GridSolver(
        roller=spec["roller"], fixed=spec["fixed"], hold=holds, drive=drives, **spec["attributes"]
    )
    for face, h in spec["faces"].items():
        solver._faceHolds[face] = _restored(wall(face, h["velocity"]), h)
    return solver


def _part(spec, scene):
    return BodyPart(scene[spec["body"]], spec["lower"], spec["upper"], spec["ids"])


def _restored(prescribed, spec):
    for name, value in spec["state"].items():
        if name not in CONSTRAINT_STATE:  # nodes, say, which the solver would go by
            raise ValueError(f"the state of '{prescribed.name}' has '{name}', which is none of it")
        setattr(prescribed._core, name, value)
    keep(prescribed, _hasBegun=spec["hasBegun"])
    return prescribed
