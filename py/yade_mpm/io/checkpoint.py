# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints: a scene in an HDF5 file, from which a run continues with the same bits; restoring.py reads them.

Layout, format 2: root attributes `format`, `formatVersion`, `package`; dataset `scene`, UTF-8 text of a JSON object with
everything but arrays; groups `bodies/0`, `bodies/1` ... with `particles/FIELD` (one row per particle, in the order of
the solver), `domains/FIELD` and `tables/NAME` (how particles and vertices are grouped and connected). Datasets carry
a checksum.
"""

import json
import os

import h5py
import numpy as np

from .. import __version__
from ..engine.callback import Callback
from ..engine.gridSolver import GridSolver
from .files import checkWritable, replacing

FORMAT, VERSION = "yade-mpm checkpoint", 2

_CONSTRAINT_STATE = (
    "work",
    "began",
    "active",
    "reaction",
    "moment",
    "impulse",
    "angularImpulse",
    "centre",
    "heldNodes",
)


def save(scene, file, midStep=False):
    """Writes a scene to a file; an older file of that name stays until the new one is complete on the disk.

    file : name of the file. midStep : note that the state is that of an interrupted step.
    Raises OSError when the file cannot be written.
    """
    file = os.fspath(file)
    checkWritable(file)
    text = json.dumps({**_describe(scene), "midStep": bool(midStep)})
    try:
        with replacing(file) as part:
            with h5py.File(part, "w") as h5:
                _writeAll(h5, scene, text)
            _syncToDisk(part)
        _syncToDisk(os.path.dirname(os.path.abspath(file)))
    except (
        OSError,
        RuntimeError,
    ) as error:  # h5py raises RuntimeError when a full disk fails the closing of a file
        raise OSError(f"checkpoint '{file}' could not be written: {error}") from error


def _writeAll(h5, scene, text):
    h5.attrs.update(format=FORMAT, formatVersion=VERSION, package=__version__)
    _write(h5, "scene", np.frombuffer(text.encode(), np.uint8))
    for k, body in enumerate(scene.bodies):
        group = h5.create_group(f"bodies/{k}")
        for name in storedFields(body):
            _write(group, f"particles/{name}", np.asarray(body.core.view(name, False)))
        for field in body.core.fields(True):
            _write(group, f"domains/{field['name']}", np.asarray(body.core.view(field["name"], True)))
        for name, table in body.core.tables().items():
            _write(group, f"tables/{name}", np.array(table, np.int32))


def _write(group, name, array):
    group.create_dataset(name, data=array, fletcher32=array.size > 0 or None)


def storedFields(body):
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
        "lower": list(scene.lower),
        "upper": list(scene.upper),
        "cell": list(scene.cell),
        "scheme": scene.scheme,
        "threads": scene._threads,
        "allowUnstable": bool(scene.allowUnstable),
        "dt": scene._dt,
        "currentDt": scene.core.dt,
        "dtCritical": scene.dtCritical,
        "stiffest": scene.stiffest,
        "checked": scene._checked and scene._checkedState == scene._stabilityState(),
        "estimatedAt": scene._estimatedAt,
        "time": scene.time,
        "steps": scene.steps,
        "energies": dict(scene.core.energies),
        "settling": scene._settling,
        "materials": [{"class": type(m).__name__, "attributes": m.attributes()} for m in materials],
        "types": [_describeType(t) for t in types],
        "bodies": [
            _describeBody(b, _place(materials, b.material), _place(types, b.type)) for b in scene.bodies
        ],
        "engines": None
        if scene._engines is None
        else [_describeEngine(e, k) for k, e in enumerate(scene._engines)],
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
        "name": body.name,
        "material": material,
        "type": kind,
        "region": None if body.region is None else body.region.spec(),
        "inertiaScale": body.inertiaScale,
        "isDamped": body.isDamped,
        "fbar": body.fbar,
        "group": body.group,
        "count": body.count,
        "converted": body.converted,
        "internalWork": body.core.internalWork,
        "largestInertialMass": body.core.largestInertialMass,
        "hasBodyForce": body.core.hasBodyForce,
        "convertsTo": body._convertsTo,
    }


def _describeEngine(engine, number):
    spec = {"class": type(engine).__name__, "attributes": engine.attributes()}
    if isinstance(engine, GridSolver):
        spec.update(
            roller=engine.roller,
            fixed=engine.fixed,
            hold=[_describeHold(h) for h in engine.hold],
            drive=[_describeDrive(d) for d in engine._drive],
            faces={face: _describePrescribed(h) for face, h in engine._faces.items()},
        )
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
    return {
        "velocity": list(prescribed.velocity),
        "ramp": prescribed.ramp,
        "name": prescribed.name,
        "hasBegun": prescribed._hasBegun,
        "state": state,
    }


def _describeHold(hold):
    where = hold.where if isinstance(hold.where, str) else hold.where.spec()
    return {"where": where, **_describePrescribed(hold)}


def _describeDrive(drive):
    part = drive.part
    lower, upper = (None if x is None else float(x) for x in (part.lower, part.upper))
    return {
        "body": part.body.name,
        "lower": lower,
        "upper": upper,
        "ids": None if part.ids is None else part.ids.tolist(),
        **_describePrescribed(drive),
    }
