# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints: a scene in an HDF5 file, from which a run continues with the same bits.

Layout, format 1: root attributes `format`, `formatVersion`, `package`; dataset `scene`, UTF-8 text of a JSON object with
everything but arrays; groups `bodies/0`, `bodies/1` ... with `particles/FIELD` (one row per particle, in the order of
the solver), `domains/FIELD` and `tables/NAME` (how particles and vertices are grouped and connected). Datasets carry
a checksum.
"""
import json
import os
import threading
import warnings

import h5py
import numpy as np

from .files import checkWritable

FORMAT, VERSION = "yade-mpm checkpoint", 1

_CONSTRAINT_STATE = ("work", "began", "active", "reaction", "moment", "centre", "heldNodes")


def save(scene, file, midStep=False):
    """Writes a scene to a file; an older file of that name stays until the new one is complete on the disk.

    file : name of the file. midStep : note that the state is that of an interrupted step.
    Raises OSError when the file cannot be written.
    """
    file = os.fspath(file)
    checkWritable(file)
    text = json.dumps({**_describe(scene), "midStep": bool(midStep)})
    part = f"{file}.{os.getpid()}-{threading.get_ident()}.part"
    try:
        with h5py.File(part, "w") as h5:
            _writeAll(h5, scene, text)
        _syncToDisk(part)
        os.replace(part, file)
        _syncToDisk(os.path.dirname(os.path.abspath(file)))
    except (OSError, RuntimeError) as error:  # h5py raises RuntimeError when a full disk fails the closing of a file
        raise OSError(f"checkpoint '{file}' could not be written: {error}") from error
    finally:
        if os.path.exists(part):
            os.remove(part)


def load(file, callbacks=None):
    """Scene from a checkpoint; `run` continues it with the same bits as if it had never stopped.

    Parameters
    ----------
    file : name of the file.
    callbacks : dict label -> function, for every `PyRunner` that calls a function (functions are not stored), or label ->
        engine for a callback of a class of your own without `spec()`; None instead of either leaves it out. Without a
        label the name of the function, or of the class, stands for it.

    `body.mesh` is None where domains were converted before. Materials and particle types that bodies shared are
    shared again. Raises FileNotFoundError, and ValueError for a file that is damaged, no checkpoint, or of a newer
    format, for a callback that is missing or superfluous, and for a class that this installation does not have.
    Warns when the state is that of an interrupted step, or of an interrupted `settle`.
    """
    file = os.fspath(file)
    if not os.path.isfile(file):
        raise FileNotFoundError(f"checkpoint '{file}' does not exist")
    if not h5py.is_hdf5(file):
        raise ValueError(f"'{file}' is no checkpoint, or damaged: it is not an HDF5 file")
    try:
        with h5py.File(file, "r") as h5:
            spec = _readSpec(h5, file)
            arrays = [_readArrays(h5[f"bodies/{k}"]) for k in range(len(spec["bodies"]))]
    except (OSError, KeyError, RuntimeError, json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"checkpoint '{file}' is damaged: {error}; use an older one") from error
    return _build(spec, arrays, dict(callbacks or {}), file)


# --- writing ----------------------------------------------------------------------------------------------
def _writeAll(h5, scene, text):
    from . import __version__
    h5.attrs.update(format=FORMAT, formatVersion=VERSION, package=__version__)
    _write(h5, "scene", np.frombuffer(text.encode(), np.uint8))
    for k, body in enumerate(scene.bodies):
        group = h5.create_group(f"bodies/{k}")
        for name in _storedFields(body):
            _write(group, f"particles/{name}", np.asarray(body.core.view(name, False)))
        for field in body.core.fields(True):
            _write(group, f"domains/{field['name']}", np.asarray(body.core.view(field["name"], True)))
        for name, table in body.core.tables().items():
            _write(group, f"tables/{name}", np.array(table, np.int32))


def _write(group, name, array):
    group.create_dataset(name, data=array, fletcher32=array.size > 0 or None)


def _storedFields(body):
    """All but the body force that nobody has asked for: to ask is to switch it on."""
    return [f["name"] for f in body.core.fields(False) if f["name"] != "bodyForce" or body.core.hasBodyForce]


def _syncToDisk(path):
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _describe(scene):
    materials, types = _distinct(b.material for b in scene.bodies), _distinct(b.type for b in scene.bodies)
    return {
        "lower": list(scene.lower), "upper": list(scene.upper), "cell": list(scene.cell), "scheme": scene.scheme,
        "threads": scene._threads, "allowUnstable": bool(scene.allowUnstable),
        "dt": scene._dt, "currentDt": scene.core.dt, "dtCritical": scene.dtCritical, "stiffest": scene.stiffest,
        "checked": scene._checked and scene._checkedState == scene._stabilityState(), "estimatedAt": scene._estimatedAt,
        "time": scene.time, "steps": scene.steps, "energies": dict(scene.core.energies), "settling": scene._settling,
        "materials": [{"class": type(m).__name__, "attributes": m.attributes()} for m in materials],
        "types": [_describeType(t) for t in types],
        "bodies": [_describeBody(b, _place(materials, b.material), _place(types, b.type)) for b in scene.bodies],
        "engines": None if scene._engines is None else [_describeEngine(e, k) for k, e in enumerate(scene._engines)],
    }


def _distinct(objects):
    return list({id(o): o for o in objects}.values())


def _place(objects, one):
    return next(k for k, o in enumerate(objects) if o is one)


def _describeType(kind):
    spec = {"class": type(kind).__name__, "attributes": kind.attributes()}
    if kind.core.isMeshed:
        size = kind.size if kind.size is None else np.asarray(kind.size, float).tolist()
        spec.update(size=size, matched=None if kind.matched is None else kind.matched.name)
    return spec


def _describeBody(body, material, kind):
    return {
        "name": body.name, "material": material, "type": kind, "region": None if body.region is None else body.region.spec(),
        "inertiaScale": body.inertiaScale, "isDamped": body.isDamped, "fbar": body.fbar, "group": body.group, "count": body.count, "converted": body.converted,
        "internalWork": body.core.internalWork, "largestInertialMass": body.core.largestInertialMass,
        "hasBodyForce": body.core.hasBodyForce, "convertsTo": body._convertsTo,
    }


def _describeEngine(engine, number):
    from .engines import Callback, GridSolver
    spec = {"class": type(engine).__name__, "attributes": engine.attributes()}
    if isinstance(engine, GridSolver):
        spec.update(roller=engine.roller, fixed=engine.fixed, hold=[_describeHold(h) for h in engine.hold],
                    drive=[_describeDrive(d) for d in engine._drive],
                    faces={face: _describePrescribed(h) for face, h in engine._faces.items()})
    elif isinstance(engine, Callback):
        try:
            spec["spec"] = json.loads(json.dumps(engine.spec()))
        except Exception:  # nothing may keep a checkpoint from being written; load() asks for it
            command = getattr(engine, "_command", None)
            spec["callback"] = engine.label or getattr(command, "__name__", type(engine).__name__)
    return spec


def _describePrescribed(prescribed):
    core = prescribed.core
    state = {name: getattr(core, name) for name in _CONSTRAINT_STATE}
    return {"velocity": list(prescribed.velocity), "ramp": prescribed.ramp, "name": prescribed.name,
            "hasBegun": prescribed._hasBegun, "state": state}


def _describeHold(hold):
    where = hold.where if isinstance(hold.where, str) else hold.where.spec()
    return {"where": where, **_describePrescribed(hold)}


def _describeDrive(drive):
    part = drive.part
    lower, upper = (None if x is None else float(x) for x in (part.lower, part.upper))
    return {"body": part.body.name, "lower": lower, "upper": upper,
            "ids": None if part.ids is None else part.ids.tolist(), **_describePrescribed(drive)}


# --- reading ----------------------------------------------------------------------------------------------
def _readSpec(h5, file):
    if h5.attrs.get("format") != FORMAT:
        raise ValueError(f"'{file}' is an HDF5 file, but no checkpoint of yade_mpm")
    version = int(h5.attrs.get("formatVersion", 0))
    if version != VERSION:
        from . import __version__
        raise ValueError(f"checkpoint '{file}' has format {version}, written by yade_mpm {h5.attrs.get('package')}; "
                         f"yade_mpm {__version__} reads format {VERSION}; continue it with that version")
    return json.loads(bytes(h5["scene"][...]).decode())


def _readArrays(group):
    return {kind: {name: data[...] for name, data in group.get(kind, {}).items()} for kind in ("particles", "domains", "tables")}


def _build(spec, arrays, callbacks, file):
    from .scene import Scene
    scene = Scene(spec["lower"], spec["upper"], spec["cell"], scheme=spec["scheme"], threads=spec["threads"])
    _buildBodies(scene, spec, arrays, file)
    if spec["engines"] is not None:
        engines = [_buildEngine(e, scene, callbacks, file) for e in spec["engines"]]
        scene.engines = [e for e in engines if e is not None]
    if callbacks:
        raise ValueError(f"load: checkpoint '{file}' has no callback {', '.join(map(repr, callbacks))}; check the labels")
    scene.allowUnstable, scene.dtCritical, scene.stiffest = spec["allowUnstable"], spec["dtCritical"], spec["stiffest"]
    scene.dt = spec["dt"]
    scene.core.dt, scene.core.time, scene.core.step = spec["currentDt"], spec["time"], spec["steps"]
    scene.core.energies = spec["energies"]
    scene._estimatedAt, scene._checked, scene._checkedState = spec["estimatedAt"], spec["checked"], scene._stabilityState()
    _warn(scene, spec, file)
    return scene


def _warn(scene, spec, file):
    if spec["midStep"]:
        warnings.warn(f"checkpoint '{file}' holds the state of an interrupted step {spec['steps']}: look at it, but do not "
                      f"continue from it", stacklevel=4)
    if spec["settling"] is not None:
        scene._solver("load").damping = spec["settling"]
        warnings.warn(f"checkpoint '{file}' was written during settle(): call settle() again (damping is back at "
                      f"{spec['settling']:g})", stacklevel=4)


def _buildBodies(scene, spec, arrays, file):
    from .materials import classes as materialClasses, rebuilt
    materials = [rebuilt(_classOf(materialClasses, m, file), m["attributes"]) for m in spec["materials"]]
    types = {}
    for entry, stored in zip(spec["bodies"], arrays):
        number = entry["type"]
        if number not in types:
            types[number] = _buildType(spec["types"][number], scene, file)
        _buildBody(scene, entry, stored, materials[entry["material"]], types[number], file)
    for body, entry in zip(scene.bodies, spec["bodies"]):
        if entry["convertsTo"] is not None:
            scene._convertTo(body, scene[entry["convertsTo"]])


def _buildType(spec, scene, file):
    from .particles import classes
    cls, attributes = _classOf(classes, spec, file), dict(spec["attributes"])
    if "matched" in spec:
        attributes.update(size=spec["size"], matched=None if spec["matched"] is None else scene[spec["matched"]])
    return cls(**attributes)


def _buildBody(scene, entry, stored, material, kind, file):
    from .regions import regionFromSpec
    region = None if entry["region"] is None else regionFromSpec(entry["region"])
    body = scene._newBody(entry["name"], material, kind, region, entry["inertiaScale"], entry["fbar"],
                          entry.get("group", "main"))
    body.isDamped = entry.get("isDamped", True)
    core = body.core
    core.resize(entry["count"])
    for field in core.fields(True):
        core.resizeDomainField(field["name"], len(_stored(stored, "domains", field["name"], body, file)))
    if entry["hasBodyForce"]:
        core.view("bodyForce", False)
    _fill(body, _storedFields(body), False, stored, file)
    _fill(body, [f["name"] for f in core.fields(True)], True, stored, file)
    for name in core.tables():
        core.setTable(name, np.ascontiguousarray(_stored(stored, "tables", name, body, file), np.int32))
    core.restored()
    core.converted, core.internalWork = entry["converted"], entry["internalWork"]
    core.largestInertialMass = entry["largestInertialMass"]
    if kind.core.isMeshed and body.converted == 0:
        body.mesh = _meshOf(body, stored)


def _fill(body, names, ofDomains, stored, file):
    for name in names:
        view = np.asarray(body.core.view(name, ofDomains))
        values = _stored(stored, "domains" if ofDomains else "particles", name, body, file)
        if view.shape != values.shape:
            raise ValueError(f"checkpoint '{file}': {name} of '{body.name}' has the shape {values.shape} instead of {view.shape}")
        view[...] = values


def _stored(stored, kind, name, body, file):
    if name not in stored[kind]:
        raise ValueError(f"checkpoint '{file}': {name} of '{body.name}' is missing; it was written by a version of yade_mpm "
                         f"with other fields")
    return stored[kind][name]


def _meshOf(body, stored):
    """The mesh the body was made from."""
    from .mesh import Mesh
    tables, fields = stored["tables"], stored["domains"]
    return Mesh(fields["vertexReference"], tables["corners"].astype(int).reshape(body.count, -1), tables["slaves"].astype(int),
                tables["masters"].astype(int).reshape(-1, 4), fields["masterWeight"])


def _classOf(classes, spec, file):
    if spec["class"] not in classes:
        raise ValueError(f"checkpoint '{file}' needs the class {spec['class']}, which this installation does not have; "
                         f"it has {', '.join(classes)}")
    return classes[spec["class"]]


def _buildEngine(spec, scene, callbacks, file):
    from .engines import classes
    if spec["class"] == "GridSolver":
        return _buildSolver(spec, scene)
    if "spec" in spec:
        return _buildCallback(_classOf({**classes, **_callbackClasses()}, spec, file), spec)
    if "callback" in spec:
        return _givenCallback(spec, callbacks, file)
    return _classOf(classes, spec, file)(**spec["attributes"])


def _callbackClasses():
    """Dict name -> class of everything derived from Callback."""
    from .engines import Callback
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
    from .engines import Callback, PyRunner
    label, attributes = spec["callback"], spec["attributes"]
    if label not in callbacks:
        raise ValueError(f"checkpoint '{file}' has the callback '{label}', which cannot be stored; give "
                         f"load(file, callbacks={{'{label}': function}}), or None in its place to leave it out")
    given = callbacks.pop(label)
    if given is None or isinstance(given, Callback):
        return given
    if spec["class"] != "PyRunner":
        raise TypeError(f"load: callbacks['{label}'] = {given!r}; give an engine of the class {spec['class']}")
    return PyRunner(given, **attributes)


def _buildSolver(spec, scene):
    from .engines import Drive, GridSolver, Hold
    from .regions import regionFromSpec
    holds = []
    for h in spec["hold"]:
        where = h["where"] if isinstance(h["where"], str) else regionFromSpec(h["where"])
        holds.append(_restored(Hold(where, h["velocity"], h["ramp"], h["name"]), h))
    drives = [_restored(Drive(_part(d, scene), d["velocity"], d["ramp"], d["name"]), d) for d in spec["drive"]]
    solver = GridSolver(roller=spec["roller"], fixed=spec["fixed"], hold=holds, drive=drives, **spec["attributes"])
    for face, h in spec["faces"].items():
        solver._faces[face] = _restored(Hold(face, h["velocity"]), h)
    return solver


def _part(spec, scene):
    from .body import BodyPart
    return BodyPart(scene[spec["body"]], spec["lower"], spec["upper"], spec["ids"])


def _restored(prescribed, spec):
    for name, value in spec["state"].items():
        setattr(prescribed.core, name, value)
    prescribed._hasBegun = spec["hasBegun"]
    return prescribed
