# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene as a checkpoint; restoring.py is the way back."""

import json
import os

import numpy as np

from ..base.attributes import keep
from ..base.kinds import FILE, takes
from ..engine.callback import Callback
from ..engine.gridSolver import GridSolver
from ..io import checkpoint
from .permissions import relativeTo

CONSTRAINT_STATE = (
    "work",
    "began",
    "active",
    "reaction",
    "moment",
    "impulse",
    "angularImpulse",
    "centre",
    "heldNodes",
    "before",
)


@takes(file=FILE)
def save(scene, file, midStep=False):
    """Writes a scene to a file, from which `load` continues with the same bits.

    Parameters
    ----------
    scene : Scene
    file : str, name of the file.
    midStep : bool, note that the state is that of an interrupted step; default False.

    Raises OSError when the file cannot be written.
    """
    refuseResults(scene, file)
    description = {**describe(scene), "midStep": bool(midStep)}
    for engine in description["engines"] or ():
        if engine["class"] in ("Recorder", "History") and engine.get("spec", {}).get("file") is not None:
            engine["spec"]["file"] = relativeTo(os.path.dirname(os.fspath(file)), engine["spec"]["file"])
    checkpoint.write(file, description, scene.bodies)
    if not midStep:
        keep(scene, _lastCheckpoint=(os.path.abspath(file), _stamp(file)))


def isLast(scene):
    """Whether the checkpoint that a scene wrote last is as it was written."""
    return scene._lastCheckpoint is not None and _stamp(scene._lastCheckpoint[0]) == scene._lastCheckpoint[1]


def _stamp(file):
    """What changes when a file does; None where it is gone."""
    try:
        found = os.stat(file)
    except FileNotFoundError:
        return None
    return found.st_mtime_ns, found.st_size


def refuseResults(scene, file):
    """Refuses a checkpoint in the place of a file of results. file : str, name of the checkpoint."""
    for engine in scene.engines if scene._hasEngines else ():
        other = getattr(engine, "file", None)
        if isinstance(other, str) and os.path.realpath(other) == os.path.realpath(file):
            raise ValueError(
                f"checkpoint '{file}' is the file of the {type(engine).__name__}, whose results it would "
                f"replace; give another file"
            )


def describe(scene):
    """Everything of a scene but the arrays of its bodies, as a dict that JSON can hold."""
    if scene._hasEngines:
        scene._changesNoted.look(scene)
    materials, types = _distinct(b.material for b in scene.bodies), _distinct(b.type for b in scene.bodies)
    return {
        "lower": list(scene.lower),
        "upper": list(scene.upper),
        "cell": None if scene.isGraded else list(scene.cell),
        "lines": [list(x) for x in scene.lines] if scene.isGraded else None,
        "axisymmetric": scene.isAxisymmetric,
        "scheme": scene.scheme,
        "threads": scene._threads,
        "allowUnstable": bool(scene.allowUnstable),
        "dt": scene._dt,
        "currentDt": scene.stepper.fullDt,
        "dtCritical": scene.dtCritical,
        "dtStable": scene.dtStable,
        "stiffest": scene.stiffest,
        "checked": scene.stepper.isChecked,
        "estimatedAt": scene.stepper.estimatedAt,
        "estimatedStiffness": scene.stepper.estimatedStiffness,
        "automaticDt": scene.stepper.automaticDt,
        "time": scene.time,
        "steps": scene.steps,
        "energies": dict(scene._core.energies),
        "startEnergy": scene._startEnergy,
        "settling": scene._dampingAfterSettling,
        "restedAt": scene._restedAt,
        "changes": scene.changes,
        "stages": scene.stages,
        "materials": [{"class": type(m).__name__, "attributes": m.attributes()} for m in materials],
        "types": [_describeType(t) for t in types],
        "bodies": [
            _describeBody(b, _indexOf(materials, b.material), _indexOf(types, b.type)) for b in scene.bodies
        ],
        "engines": None
        if not scene._hasEngines
        else [_describeEngine(e, k) for k, e in enumerate(scene.engines)],
    }


def _distinct(objects):
    return list({id(o): o for o in objects}.values())


def _indexOf(objects, one):
    return next(k for k, o in enumerate(objects) if o is one)


def _describeType(kind):
    spec = {"class": type(kind).__name__, "attributes": kind.attributes()}
    if kind._core.isMeshed:
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
        "implicit": body.implicit,
        "fbar": body.fbar,
        "group": body.group,
        "count": body.count,
        "converted": body.converted,
        "internalWork": body._core.internalWork,
        "lastInternalWork": body._core.lastInternalWork,
        "largestInertialMass": body._core.largestInertialMass,
        "hasBodyForce": body._core.hasBodyForce,
        "hasPores": body._core.hasPores,
        "hasSides": body._core.hasSides,
        "convertsTo": body.convertsTo,
    }


def _describeEngine(engine, number):
    spec = {"class": type(engine).__name__, "attributes": engine.attributes()}
    if isinstance(engine, GridSolver):
        spec.update(
            roller=engine.roller,
            fixed=engine.fixed,
            hold=[_describeHold(h) for h in engine.holds],
            drive=[_describeDrive(d) for d in engine.drives],
            faces={face: _describePrescribed(h) for face, h in engine._faceHolds.items()},
        )
    elif isinstance(engine, Callback):
        try:
            spec.update(json.loads(json.dumps({"spec": engine.spec(), "state": engine.state()})))
        except Exception:  # nothing may keep a checkpoint from being written; load() asks for it
            command = getattr(engine, "command", None)
            spec["callback"] = engine.label or getattr(command, "__name__", type(engine).__name__)
    else:
        spec["state"] = engine.state()
    return spec


def _describePrescribed(prescribed):
    core = prescribed._core
    state = {name: getattr(core, name) for name in CONSTRAINT_STATE}
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
        "byHeight": drive.byHeight,
        **_describePrescribed(drive),
    }
