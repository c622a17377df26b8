# SPDX-License-Identifier: GPL-2.0-or-later
"""Another particle type for a part of a body, between two runs: domains become boxes."""

import numpy as np

from ..base.attributes import keep
from ..base.warn import warnUser
from ..base.wording import shown
from ..engine.boundaryLoad import BoundaryLoad
from ..engine.gridSolver import GridSolver
from ..geometry.region import Region
from ..geometry.regions import box
from ..particle.types import Boxes, MeshedType, ParticleType, classes
from .adding import build, newBody
from .convertingToMesh import toMesh
from .running import refuseDuringStep, refuseMidStep


def convert(scene, body, region, type, tolerance):
    """Makes particles of another type of those of a body in a region; returns the new body, see
    `Body.convert`."""
    refuseDuringStep(scene, "convert")
    refuseMidStep(scene, "convert")
    numbers = _checked(scene, body, region, type)
    _warnOfLost(scene, body, numbers)
    name = _freeName(scene, f"{body.name} ({type.__class__.__name__})")
    way = toBoxes if isinstance(body.type, MeshedType) else toMesh
    with scene._holder.held("convert"):
        other = way(scene, body, numbers, type, name, tolerance)
        scene.stepper.noteChange()
    return other


def toBoxes(scene, body, numbers, type, name, _):
    """The domains `numbers` of a body as boxes."""
    options = body.inertiaScale, body.fbar, body.group, body.implicit
    other = newBody(scene, name, body.material, type, None, *options)
    other.isDamped = body.isDamped
    half = type._geometry(_aCell(scene), scene, name).halfSize
    build(other, Boxes(np.zeros((0, scene.dim)), half))
    scene._core.convertDomains(body.name, name, np.ascontiguousarray(numbers, np.int32))
    _shapeForSplitting(other)
    keep(body, mesh=None)
    return other


def _checked(scene, body, region, type):
    """Numbers of the particles that are to be converted."""
    who = f"body '{body.name}': convert"
    if not isinstance(region, Region):
        raise TypeError(f"{who}: region = {shown(region)}; give a region, e.g. mpm.box((0, 0), (1, 1))")
    if not isinstance(type, ParticleType):
        raise TypeError(f"{who}: type = {shown(type)}; give mpm.UGIMP(...) or mpm.APDI(...)")
    if not isinstance(body.type, (classes["UGIMP"], classes["APDI"])):
        own = body.type.__class__.__name__
        raise ValueError(f"{who}: its particles are {own}; only those of APDI and UGIMP convert")
    if isinstance(body.type, MeshedType):
        if not isinstance(type, classes["UGIMP"]) or type.cut:
            raise ValueError(f"{who}: {shown(type)} is not allowed; give mpm.UGIMP(...), not cut by a region")
    elif not isinstance(type, classes["APDI"]) or type.size is not None or type.matched is not None:
        edge = "without size and matched: the domains are as large as the boxes"
        raise ValueError(f"{who}: {shown(type)} is not allowed; give mpm.APDI(), {edge}")
    if region.dim != scene.dim:
        raise ValueError(
            f"{who}: the region is {region.dim}D, the scene {scene.dim}D; give one in {scene.dim}D"
        )
    numbers = np.flatnonzero(region.contains(body.position))
    if len(numbers) == 0:
        what = "domain" if isinstance(body.type, MeshedType) else "particle"
        raise ValueError(f"{who}: no {what} has its centre in the region; give a larger one")
    return numbers


def _warnOfLost(scene, body, numbers):
    """Tells which loads and drives will not act on the particles `numbers` of a body any more."""
    lost = []
    for engine in scene.engines:
        if isinstance(engine, BoundaryLoad) and engine.body == body.name and not engine.dead:
            count = np.isin(engine.facets[:, 0], body.id[numbers]).sum()
            lost += [f"{count} of {len(engine.facets)} facets of a BoundaryLoad"] if count else []
        for drive in engine.drives if isinstance(engine, GridSolver) else ():
            has = drive.part.has() if drive.part.body is body else np.zeros(body.count, bool)
            count = has[numbers].sum()
            lost += [f"{count} of {has.sum()} particles of the Drive '{drive.name}'"] if count else []
    if lost:
        warnUser(
            f"body '{body.name}': convert: {' and '.join(lost)} are converted, and it acts on them no more; "
            "drive or load the new body, or leave these particles out of the region"
        )


def _aCell(scene):
    """A region of one cell, for the size of a type's boxes."""
    return box(scene.lower, scene.lower + scene.cell)


def _freeName(scene, name):
    known = {body.name for body in scene.bodies}
    number = 2
    free = name
    while free in known:
        free, number = f"{name} {number}", number + 1
    return free


def _shapeForSplitting(body):
    """Where stretched particles are cut: the parts of a domain are as large as boxes, whatever its stretch
    was."""
    if "splitShare" in [field["name"] for field in body._core.fields(True)]:
        body._core.resizeDomainField("splitShare", body.count)
        dim = body.position.shape[1]
        share = np.asarray(body._core.view("splitShare", True))
        share[...] = np.linalg.inv(body.deformationGradient[:, :dim, :dim])
