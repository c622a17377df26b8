# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of a checkpoint, with their materials and types: every table is checked before it is used."""

import numpy as np

from ..base.attributes import keep
from ..geometry.mesh import Mesh
from ..geometry.regions import regionFromSpec
from ..io.checkpoint import storedFields
from ..material.materials import classes as materialClasses
from ..material.materials import rebuilt
from ..particle.types import classes as particleClasses
from .adding import newBody
from .tables import checkTables
from .wetting import addPores


def buildBodies(scene, spec, arrays, file):
    """Adds the bodies of a checkpoint to a scene. spec, arrays : as `io.checkpoint.read` gives them."""
    materials = [rebuilt(classOf(materialClasses, m, file), m["attributes"]) for m in spec["materials"]]
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
    cls, attributes = classOf(particleClasses, spec, file), dict(spec["attributes"])
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
    core = body._core
    core.resize(_checked(body, entry, stored, file))
    for field in core.fields(True):
        core.resizeDomainField(field["name"], len(_stored(stored, "domains", field["name"], body, file)))
    if entry["hasBodyForce"]:
        core.view("bodyForce", False)
    if entry.get("hasSides"):
        core.addSides()
    if entry.get("hasPores"):
        addPores(body)
    _fill(body, storedFields(body), False, stored, file)
    _fill(body, [f["name"] for f in core.fields(True)], True, stored, file)
    for name in core.tables():
        core.setTable(name, np.ascontiguousarray(_stored(stored, "tables", name, body, file), np.int32))
    try:
        core.restored()
    except RuntimeError as error:  # particles where the grid is not
        raise ValueError(f"'{file}' is damaged: {error}") from error
    core.converted, core.internalWork = entry["converted"], entry["internalWork"]
    core.lastInternalWork = entry.get("lastInternalWork", 0.0)
    core.largestInertialMass = entry["largestInertialMass"]
    if kind._core.isMeshed and body.converted == 0:
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
        view = np.asarray(body._core.view(name, ofDomains))
        values = _stored(stored, "domains" if ofDomains else "particles", name, body, file)
        if view.dtype != values.dtype:
            raise ValueError(
                f"checkpoint '{file}': {name} of '{body.name}' holds {values.dtype} instead of {view.dtype}; "
                "use an older one"
            )
        if view.shape != values.shape:
            raise ValueError(
                f"checkpoint '{file}': {name} of '{body.name}' has the shape {values.shape} instead of "
                f"{view.shape}; use an older one"
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


def classOf(classes, spec, file):
    """The class that an entry of a checkpoint names; ValueError where this installation has none of it."""
    if spec["class"] not in classes:
        raise ValueError(
            f"checkpoint '{file}' needs the class {spec['class']}, which this installation does not have; "
            f"it has {', '.join(classes)}"
        )
    return classes[spec["class"]]
