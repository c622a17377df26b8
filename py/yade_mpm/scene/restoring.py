# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene from a checkpoint; saving.py is the way there."""

import os

import numpy as np

from ..base.attributes import keep
from ..base.warn import PACKAGE, warnUser
from ..engine.callback import Callback, PyRunner
from ..engine.engines import classes as engineClasses
from ..engine.gridSolver import GridSolver
from ..engine.prescribed import Drive, Hold
from ..geometry.mesh import Mesh
from ..geometry.numbers import isNumber
from ..geometry.regions import regionFromSpec
from ..io import checkpoint
from ..io.checkpoint import storedFields
from ..material.materials import classes as materialClasses
from ..material.materials import rebuilt
from ..particle.part import BodyPart
from ..particle.types import classes as particleClasses
from .adding import newBody
from .permissions import Permissions
from .scene import Scene
from .tableChecks import checkTables

MOST_SHOWN = 500  # characters of an error from inside
FAR = 1e300  # steps and seconds: further than any run comes


def load(file, callbacks=None, trust=False, files=None):
    """Scene from a checkpoint; `run` continues it with the same bits as if it had never stopped.

    A checkpoint is data: what it brings does not run, and writes nothing outside of its own folder, unless
    you say so.

    Parameters
    ----------
    file : name of the file.
    trust : bool, let texts of the file run (`PyRunner` with a string), and let its recorders and histories
        write anywhere; default False. Say True for files of your own only: it is like running a script.
    files : dict name -> name, for recorders and histories: where to write instead of a place that the
        checkpoint names; None instead of a name leaves the file out. Places in the folder of the checkpoint
        need none.
    callbacks : dict label -> function, for every `PyRunner` that calls a function (functions are not
        stored), or label -> engine for a callback of a class of your own without `spec()`; None instead of
        either leaves it out. Without a label the name of the function, or of the class, stands for it.

    `body.mesh` is None where domains were converted before. Materials and particle types that bodies shared
    are shared again. Raises FileNotFoundError, and ValueError for a file that is damaged, no checkpoint, or
    of a newer format, for a callback that is missing or superfluous, for a class that this installation
    does not have, and for text that would run or a place outside of the folder (the error shows them).
    Numbers of the tables that the solver goes by are checked; SECURITY.md tells what is promised. Warns
    when the state is that of an interrupted step, or of an interrupted `settle`.
    """
    file = os.fspath(file)
    spec, arrays = checkpoint.read(file)
    callbacks = dict(callbacks or {})
    if not isinstance(trust, bool):
        raise TypeError(f"load: trust = {trust!r} is not allowed; give True or False")
    permissions = Permissions(file, spec["formatVersion"], trust, callbacks, files or {})
    try:
        return _build(spec, arrays, callbacks, permissions, file)
    except (
        KeyError,
        IndexError,
        TypeError,
        AttributeError,
        OverflowError,
        RecursionError,
        ValueError,
    ) as error:
        if not _isOfFile(error) or f"'{file}'" in str(error):
            raise
        raise ValueError(
            f"checkpoint '{file}' does not describe a scene: {type(error).__name__}: "
            f"{str(error)[:MOST_SHOWN]}; it was "
            f"made by hand, or by another version"
        ) from error


def _isOfFile(error):
    """Whether an error was made here, and not by a class of the user."""
    trace = error.__traceback__
    while trace.tb_next is not None:
        trace = trace.tb_next
    return trace.tb_frame.f_code.co_filename.startswith(PACKAGE) and not str(error).startswith("load: ")


def _build(spec, arrays, callbacks, permissions, file):
    scene = Scene(
        spec["lower"], spec["upper"], spec["cell"], spec["scheme"], spec["threads"], grading=spec.get("lines")
    )
    permissions.checkTexts(spec["engines"] or [])
    _buildBodies(scene, spec, arrays, file)
    if spec["engines"] is not None:
        engines = [_buildEngine(e, scene, callbacks, permissions, file) for e in spec["engines"]]
        scene.engines = [e for e in engines if e is not None]
    if callbacks:
        raise ValueError(
            f"load: checkpoint '{file}' has no callback {', '.join(map(repr, callbacks))}; check the labels"
        )
    permissions.finish()
    scene.allowUnstable, scene.dt = spec["allowUnstable"], spec["dt"]
    estimated = {name: spec[name] for name in ("dtCritical", "stiffest")}
    keep(scene, **estimated, dtStable=spec.get("dtStable", spec["dtCritical"]))
    _checkClock(spec)
    scene.core.dt, scene.core.time, scene.core.step = spec["currentDt"], spec["time"], spec["steps"]
    scene.core.energies = spec["energies"]
    scene.stepper.restore(
        spec["checked"], spec["estimatedAt"], spec.get("estimatedVolumes", {}), spec.get("automaticDt")
    )
    scene.changesNoted.restore(scene, spec.get("changes", []))
    _warn(scene, spec, file)
    return scene


def _checkClock(spec):
    """Refuses numbers that no scene has."""
    for name in ("currentDt", "time", "steps"):
        if not (isNumber(spec[name]) and 0 <= spec[name] < FAR):
            raise TypeError(f"{name} = {spec[name]!r}")


def _warn(scene, spec, file):
    if spec["midStep"]:
        warnUser(
            f"checkpoint '{file}' holds the state of an interrupted step {spec['steps']}: look at it, but do "
            "not "
            f"continue from it"
        )
    if spec["settling"] is not None:
        scene.gridSolver("load").damping = spec["settling"]
        warnUser(
            f"checkpoint '{file}' was written during settle(): call settle() again (damping is back at "
            f"{spec['settling']:g})"
        )


def _buildBodies(scene, spec, arrays, file):
    materials = [rebuilt(_classOf(materialClasses, m, file), m["attributes"]) for m in spec["materials"]]
    types = {}
    for entry, stored in zip(spec["bodies"], arrays):
        number = entry["type"]
        if number not in types:
            types[number] = _buildType(spec["types"][number], scene, file)
        _buildBody(scene, entry, stored, materials[entry["material"]], types[number], file)
    for body, entry in zip(scene.bodies, spec["bodies"]):
        if entry["convertsTo"] is not None:
            body.convertTo(scene[entry["convertsTo"]])


def _buildType(spec, scene, file):
    cls, attributes = _classOf(particleClasses, spec, file), dict(spec["attributes"])
    if "matched" in spec:
        attributes.update(
            size=spec["size"], matched=None if spec["matched"] is None else scene[spec["matched"]]
        )
    return cls(**attributes)


def _buildBody(scene, entry, stored, material, kind, file):
    region = None if entry["region"] is None else regionFromSpec(entry["region"])
    body = newBody(
        scene,
        entry["name"],
        material,
        kind,
        region,
        entry["inertiaScale"],
        entry["fbar"],
        entry.get("group", "main"),
        entry.get("implicit", False),
    )
    body.isDamped = entry.get("isDamped", True)
    core = body.core
    core.resize(_checked(body, entry, stored, file))
    for field in core.fields(True):
        core.resizeDomainField(field["name"], len(_stored(stored, "domains", field["name"], body, file)))
    if entry["hasBodyForce"]:
        core.view("bodyForce", False)
    _fill(body, storedFields(body), False, stored, file)
    _fill(body, [f["name"] for f in core.fields(True)], True, stored, file)
    for name in core.tables():
        core.setTable(name, np.ascontiguousarray(_stored(stored, "tables", name, body, file), np.int32))
    core.restored()
    core.converted, core.internalWork = entry["converted"], entry["internalWork"]
    core.largestInertialMass = entry["largestInertialMass"]
    if kind.core.isMeshed and body.converted == 0:
        keep(body, mesh=_meshOf(body, stored))


def _checked(body, entry, stored, file):
    """Number of particles of a body, of whose tables all numbers fit."""
    count = entry["count"]
    try:
        if len(_stored(stored, "particles", "mass", body, file)) != count:
            raise ValueError(
                f"{count} particles are described, and {len(stored['particles']['mass'])} are there"
            )
        checkTables(body, count, stored)
    except (ValueError, KeyError) as error:
        if str(error).startswith("checkpoint"):
            raise
        raise ValueError(
            f"checkpoint '{file}' is damaged: '{body.name}': {error}; use an older one"
        ) from error
    return count


def _fill(body, names, ofDomains, stored, file):
    for name in names:
        view = np.asarray(body.core.view(name, ofDomains))
        values = _stored(stored, "domains" if ofDomains else "particles", name, body, file)
        if view.dtype != values.dtype:
            raise ValueError(
                f"checkpoint '{file}': {name} of '{body.name}' holds {values.dtype} instead of {view.dtype}"
            )
        if view.shape != values.shape:
            raise ValueError(
                f"checkpoint '{file}': {name} of '{body.name}' has the shape {values.shape} instead of "
                f"{view.shape}"
            )
        view[...] = values


def _stored(stored, kind, name, body, file):
    if name not in stored[kind]:
        raise ValueError(
            f"checkpoint '{file}': {name} of '{body.name}' is missing; it was written by a version of "
            f"yade_mpm with other fields; continue it with that version"
        )
    return stored[kind][name]


def _meshOf(body, stored):
    """The mesh the body was made from."""
    tables, fields = stored["tables"], stored["domains"]
    return Mesh(
        fields["vertexReference"],
        tables["corners"].astype(int).reshape(body.count, -1),
        tables["slaves"].astype(int),
        tables["masters"].astype(int).reshape(-1, 4),
        fields["masterWeight"],
    )


def _classOf(classes, spec, file):
    if spec["class"] not in classes:
        raise ValueError(
            f"checkpoint '{file}' needs the class {spec['class']}, which this installation does not have; "
            f"it has {', '.join(classes)}"
        )
    return classes[spec["class"]]


def _buildEngine(spec, scene, callbacks, permissions, file):
    if spec["class"] == "GridSolver":
        return _buildSolver(spec, scene)
    if permissions.isText(spec) and (label := permissions.instead(spec)) is not None:
        return _givenCallback({**spec, "callback": label}, callbacks, file)
    if "spec" in spec:
        if spec["class"] in ("Recorder", "History") and spec["spec"]["file"] is not None:
            place = permissions.place(spec["spec"]["file"])
            if place is None and spec["class"] == "Recorder":
                return None
            spec = {**spec, "spec": {**spec["spec"], "file": place}}
        return _buildCallback(_classOf({**engineClasses, **_callbackClasses()}, spec, file), spec)
    if "callback" in spec:
        return _givenCallback(spec, callbacks, file)
    return _classOf(engineClasses, spec, file)(**spec["attributes"])


def _callbackClasses():
    """Dict name -> class of everything derived from Callback."""
    found, rest = {}, [Callback]
    while rest:
        cls = rest.pop()
        found.setdefault(cls.__name__, cls)
        rest.extend(cls.__subclasses__())
    return found


def _buildCallback(cls, spec):
    engine = cls(**spec["spec"])
    for name, value in spec["attributes"].items():
        engine.core.set(name, value)
    return engine


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
            f"load: callbacks['{label}'] = {given!r}; give an engine of the class {spec['class']}"
        )
    return PyRunner(given, **attributes)


def _buildSolver(spec, scene):
    holds = []
    for h in spec["hold"]:
        where = h["where"] if isinstance(h["where"], str) else regionFromSpec(h["where"])
        holds.append(_restored(Hold(where, h["velocity"], h["ramp"], h["name"]), h))
    drives = [
        _restored(Drive(_part(d, scene), d["velocity"], d["ramp"], d["name"]), d) for d in spec["drive"]
    ]
    solver = GridSolver(
        roller=spec["roller"], fixed=spec["fixed"], hold=holds, drive=drives, **spec["attributes"]
    )
    for face, h in spec["faces"].items():
        solver.faceHolds[face] = _restored(Hold(face, h["velocity"]), h)
    return solver


def _part(spec, scene):
    return BodyPart(scene[spec["body"]], spec["lower"], spec["upper"], spec["ids"])


def _restored(prescribed, spec):
    for name, value in spec["state"].items():
        setattr(prescribed.core, name, value)
    keep(prescribed, hasBegun=spec["hasBegun"])
    return prescribed
