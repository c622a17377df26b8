# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of a scene: how they are added, and what they are made of."""

from __future__ import annotations

import os

import numpy as np

from ..base.attributes import keep
from ..base.keywords import checked
from ..base.kinds import FLAG
from ..base.wording import shown
from ..check import limits
from ..engine.poreWater import PoreWater
from ..engine.rigidContact import RigidContact
from ..geometry.lattice import checkOverlap
from ..geometry.mesh import Mesh
from ..geometry.numbers import placeText
from ..geometry.particleSet import ParticleSet
from ..geometry.region import Region
from ..material.materials import Material, isBeam
from ..particle.body import Body
from ..particle.types import Boxes, ParticleType, classes
from . import choices
from .beam import Beam
from .filling import above, bodiesBelow
from .hybrid import addHybrid
from .running import refuseDuringStep
from .wetting import checkWater, giveWater, waterOf

CUT_BOXES = "; where it is, a slanted edge cuts boxes: particles=mpm.UGIMP(perCell=2, cut=True)"


class Bodies(tuple):
    """The bodies of a scene, which stay: checkpoints and contact know them by number."""

    __slots__ = ()

    def __getattr__(self, name):
        if name in ("append", "clear", "extend", "insert", "pop", "remove"):
            raise AttributeError(
                f"Scene: bodies has no {name}(); bodies come by scene.add(...), and scene.remove(body) takes "
                f"the particles of one out"
            )
        raise AttributeError(f"Scene: bodies has no attribute '{name}'; it is a tuple of Body")


@checked("Scene.add", research=("inertiaScale",))
def add(
    scene,
    name: str,
    region: Region | ParticleSet | Mesh | Beam | tuple | str | os.PathLike,
    material: Material | None = None,
    particles: ParticleType | None = None,
    inertiaScale: float = 1.0,
    fbar: bool | None = None,
    group: str | None = None,
    implicit: bool | None = None,
    exclude: RigidContact | None = None,
    flow: Region | tuple | None = None,
    on: Body | tuple | None = None,
    water: PoreWater | None = None,
    undrained: bool = False,
) -> Body:
    """Adds a body and returns it. What is left out the scene chooses, and `describe` tells why.

    Parameters
    ----------
    name : str, used in messages, results and checkpoints.
    region : Region; for APDI also (points (Nv, dim), cells (Nc, 4 or 8)), a Mesh, or the name of a mesh file.
        Domains are in the order of the cells; those of a file are renumbered in rows, for speed:
        `body.mesh.cellNumbers` tells which cell each is. For boxes also `mpm.particles` at
        positions. Or a Beam, which has all but the name and the group.
    material : Material, e.g. mpm.LinearElastic(...).
    particles : ParticleType, e.g. mpm.UGIMP(perCell=2) or mpm.APDI(size=0.25). Default None: boxes that are
        cut as they grow long, mpm.UGIMP(perCell=2, splitAt=1.3), for a material that yields; a mesh with
        edges of half a cell, mpm.APDI(size=cell/2), for an elastic one.
    fbar : bool, one increment of volumetric strain and one linear mean stress per cell: against volumetric
        locking, which makes soil that yields too strong, and for volumes that stay (de Souza Neto et al.
        1996, doc/explanation/volumes.md). Default None: for materials that yield. False: the bare form.
    group : str; bodies of one group stick together, between groups a `Contact` engine lets them slip. Default
        None: by the calls of `contact`; "main" where there are none.
    implicit : bool, solve for the elastic forces of the body at the end of each step: its stiffness does not
        limit the time step, and GridSolver's damping leaves it alone. For structures much stiffer than what
        is around them (doc/explanation/implicit-bodies.md). Default None: where `particles` is left out an
        elastic body is implicit if its waves are four times as fast as those of the other bodies, until the
        first step; where it is given it is not.
    exclude : RigidContact, or what `contact` has returned for bodies of YADE: rigid bodies that keep their
        place. Boxes that would overlap with one are left out, also beside thin and inclined shapes. Of boxes
        only. Default None: the region is filled.
    flow : where the soil flows: a region, or (pile, 2.0), a box up to 2 m round a body or a region
        (`mpm.geotech.flowRegion` finds one by a coarse run). Boxes are made there, and elsewhere a mesh with
        edges of a cell, in a body of its own, "NAME (mesh)", whose edges beside the boxes match them. In
        place of `particles`. Default None: all of the body is of one type.
    on : Body, or several, whose surface a lift of fill is put on: the region may reach into them, and boxes
        are cut where the surface is now, heaved or settled. Of boxes only. Default None: bodies that overlap
        are refused.
    water : PoreWater, fills the pores below its table. Default None: dry, or one phase.
    undrained : True: the body has water that does not flow, for strength by effective stress under fast
        loads: that of `water`, else of the scene, with the permeability 0. Where there is none it has no
        table: all is full, and stress starts as that without water.

    Raises ValueError for an empty body, edges off the particle spacing, particles outside the grid, bodies
    that overlap, or a mesh that is inverted; TypeError for a wrong kind of argument.
    """
    refuseDuringStep(scene, "add")
    if isinstance(region, Beam):
        _refuseBesideBeam(
            name,
            material=material,
            particles=particles,
            fbar=fbar,
            exclude=exclude,
            flow=flow,
            on=on,
            water=water,
            undrained=undrained or None,
            implicit=implicit,
        )
        region, material, particles = region._parts(scene, name)
        implicit = True
    elif isBeam(material):
        raise ValueError(f"body '{name}': BeamSection is no material of a region; give mpm.Beam(line, ...)")
    if flow is not None:
        if particles is not None:
            raise ValueError(f"body '{name}': particles and flow are given together; flow chooses them")

        def part(its, where, kind):
            return add(
                scene,
                its,
                where,
                material,
                kind,
                inertiaScale,
                fbar,
                group,
                implicit,
                exclude,
                on=on,
                water=water,
                undrained=undrained,
            )

        return addHybrid(scene, name, region, flow, part)
    FLAG.require(f"body {shown(name)}", "undrained", undrained)
    chosen = {}
    if particles is None and isinstance(material, Material):
        particles, chosen["particles"] = choices.particlesFor(scene, region, material)
        if implicit is None:
            chosen["implicit"] = "its material yields"
    _checkArguments(scene, name, region, material, particles)
    if undrained and water is None:
        water = waterOf(scene) or PoreWater()
    if water is not None:
        checkWater(scene, name, material, water, implicit)
    if fbar is None:
        fbar = material._core.yields and not implicit
        chosen["fbar"] = "yields, and would lock" if fbar else "keeps its volume by itself"
    if group is None:
        group, chosen["group"] = "main", "in no contact"
    with scene._holder.held("add"):
        options = inertiaScale, fbar, group, bool(implicit) if implicit is None else implicit
        body = _added(scene, name, region, material, particles, options, exclude, on)
        for one in [body] if body.convertsTo is None else [body, scene[body.convertsTo]]:
            keep(one, _chosen=dict(chosen))
            if water is not None:
                giveWater(scene, one, water)
            if undrained:
                one.permeability = 0.0
        choices.update(scene)
    return body


def _refuseBesideBeam(name, implicit, **options):
    for option, value in options.items():
        if value is not None:
            raise ValueError(f"body '{name}': {option} is given, and a Beam has it; leave it out")
    if implicit is False:
        raise ValueError(f"body '{name}': a Beam is implicit; leave implicit out")


def _added(scene, name, region, material, type, options, exclude=None, on=None):
    below = [] if on is None else bodiesBelow(scene, name, on)
    geometry = type._geometry(region, scene, name)
    if below:
        geometry = above(geometry, below, name)
    if not isinstance(geometry, tuple) and geometry.dim != scene.dim:
        raise ValueError(
            f"body '{name}': the mesh is {geometry.dim}D, the scene {scene.dim}D; give one in {scene.dim}D"
        )
    _checkInside(scene, name, geometry)
    region = region if isinstance(region, Region) else None
    if exclude is not None:
        geometry = _without(exclude, geometry, scene, (name, material, type, region, *options))
    body = newBody(scene, name, material, type, region, *options)
    try:
        build(body, geometry)
        material._giveTo(body)
        for other in (one for one in scene.bodies[:-1] if one not in below):
            advice = CUT_BOXES if any(map(_areWholeBoxes, (other, body))) else ""
            checkOverlap(other.name, *_innerBoxes(other), name, *_innerBoxes(body), advice)
    except Exception:
        drop(scene, body)
        raise
    if type._core.converts:
        addConverted(scene, body)
    return body


def _without(contact, boxes, scene, how):
    """Boxes that overlap with none of the rigid bodies of a contact, by the rule of the contact itself.

    how : arguments of newBody behind the scene.
    """
    contact = getattr(contact, "contact", contact)  # of bodies of YADE
    if not isinstance(contact, RigidContact):
        raise TypeError(
            f"body '{how[0]}': exclude = {shown(contact)}; give the mpm.RigidContact of the bodies"
        )
    if not isinstance(boxes, Boxes):
        raise ValueError(
            f"body '{how[0]}': exclude leaves boxes out, and the type is {shown(how[2])}; give UGIMP, or a "
            "region without the place of the bodies"
        )
    body = newBody(scene, *how)
    try:
        build(body, boxes)
        number = len(scene.bodies) - 1
        left = np.delete(
            np.arange(len(boxes.positions)), body.id[contact._core.overlapping(scene._core, number)]
        )
    finally:
        drop(scene, body)
    return boxes.only(left)


def newBody(scene, name, material, type, region, inertiaScale, fbar, group, implicit=False):
    """A body without particles, at the end of scene.bodies."""
    core = scene._core.addBody(name, material._core, type._core)
    body = Body(scene, core, type, material, region)
    scene._bodies.append(body)
    scene.stepper.noteChange()
    try:
        body.inertiaScale, body.fbar, body.group = inertiaScale, fbar, group
        body.implicit = implicit
    except Exception:
        drop(scene, body)
        raise
    material._markUsed(name)
    type._markUsed(name)
    return body


def build(body, geometry):
    """Fills a body with particles: Boxes, or the cells of a Mesh."""
    if isinstance(geometry, tuple):
        _buildBoxes(body, geometry)
    else:
        keep(body, mesh=geometry)
        body._core.buildMesh(
            _array(geometry.points),
            _array(geometry.cells, np.int32),
            _array(geometry.slaves, np.int32),
            _array(geometry.masters, np.int32),
            _array(geometry.masterWeights),
        )


def _checkArguments(scene, name, region, material, type):
    if not (isinstance(name, str) and name):
        raise TypeError(f"Scene: name = {shown(name)} of a body; give a string")
    if not isinstance(material, Material):
        raise TypeError(f"body '{name}': material = {shown(material)}; give e.g. mpm.LinearElastic(...)")
    if not isinstance(type, ParticleType):
        raise TypeError(
            f"body '{name}': particles = {shown(type)}; give e.g. mpm.UGIMP(perCell=2) or mpm.APDI(size=...)"
        )
    if isinstance(region, Region) and region.dim != scene.dim:
        raise ValueError(f"body '{name}': the region is {region.dim}D, the scene {scene.dim}D; give another")


def _checkInside(scene, name, geometry):
    isBoxes = isinstance(geometry, tuple)
    positions = geometry.positions if isBoxes else geometry.points
    tolerance = 1e-9 * scene.cell
    if not isBoxes:
        _moveOntoWalls(scene, positions, tolerance)
    outside = ((positions < scene.lower - tolerance) | (positions > scene.upper + tolerance)).any(axis=1)
    if outside.any():
        at = positions[np.argmax(outside)]
        raise ValueError(
            f"body '{name}': {'particle' if isBoxes else 'vertex'} at {placeText(at)} is outside the grid "
            f"{placeText(scene.lower)} to {placeText(scene.upper)}; enlarge the grid or move the body"
        )


def _moveOntoWalls(scene, vertices, tolerance):
    """Vertices that a file in single precision has put behind a wall of the grid."""
    inside = np.clip(vertices, scene.lower, scene.upper)
    way = np.abs(vertices - inside)
    isRounded = (way > tolerance) & (way < limits.SINGLE_PRECISION * scene.cell)
    vertices[isRounded] = inside[isRounded]


def drop(scene, body):
    """Takes back the body added last; whoever still has it finds it empty, not dangling."""
    scene._bodies.pop()
    scene._core.dropBody()
    body.__dict__.update(_core=None, _fields=())


def _buildBoxes(body, boxes):
    outline = (_array(boxes.carriers, np.int32), _array(boxes.offsets), _array(boxes.areas))
    body._core.buildLattice(_array(boxes.positions), _array(boxes.halfSize), *outline)
    if boxes.shares is not None:
        for field in ("mass", "volume", "initialVolume"):
            setattr(body, field, getattr(body, field) * boxes.shares[body.id])


def addConverted(scene, body):
    """The body that takes over domains of `body` that become too distorted; empty at first."""
    spacing = scene.cell / 2 if body.type.matched is None else 2 * body.type.matched.halfSize
    name = body.name + " (converted)"
    options = body.inertiaScale, body.fbar, body.group, body.implicit
    other = newBody(scene, name, body.material, classes["UGIMP"](), None, *options)
    build(other, Boxes(np.zeros((0, scene.dim)), spacing / 2))
    body.convertTo(other)


def _areWholeBoxes(body):
    return body.cells is None and body.region is not None and not getattr(body.type, "cut", False)


def _innerBoxes(body):
    """Centres and half sizes of boxes that lie inside the domains of a body, for the check of overlaps."""
    if body.cells is None:
        share = body.initialVolume / (
            np.prod(2 * body.halfSize) * body.scene._thicknessAt(body.reference[:, 0])
        )
        # Of cut boxes, half of what they hold.
        return body.position, np.where(share > 1 - 1e-9, 1, share / 2)[:, None] * body.halfSize
    return body.position, 0.5 * np.abs(body.corners() - body.position[:, None]).min(axis=1)


def _array(values, dtype=np.float64):
    return np.ascontiguousarray(values, dtype=dtype)
