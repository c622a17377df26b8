# SPDX-License-Identifier: GPL-2.0-or-later
"""A body taken out of a scene between two runs, as in an excavation."""

import numpy as np

from ..base.attributes import keep
from ..base.kinds import NOT_NEGATIVE, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..engine.engines import classes
from ..engine.gridSolver import GridSolver
from ..engine.prescribed import Drive
from ..engine.rigidContact import RigidContact
from ..engine.supports import PointForce, Spring
from ..geometry.numbers import placeText
from ..geometry.region import Region
from ..material.materials import isBeam
from ..particle.body import Body
from ..particle.types import Boxes, MeshedType
from ..particle.types import classes as particleTypes
from .adding import build, drop, newBody
from .convertingToMesh import dropBoxes
from .filling import LEAST_SHARE
from .running import refuseDuringStep, refuseMidStep
from .wetting import waterOf

INSET = 1e-6  # of a domain: round-off of its corners
SAMPLES = 8  # along each edge of a box, to find what of it a region holds


@takes(over=NOT_NEGATIVE)
def remove(scene, body: Body | None = None, region: Region | None = None, over: float = 0.0) -> float:
    """Takes a body, or what is in a region, out of the scene between two runs: an excavation.

        scene.remove(region=mpm.box((8, 6), (16, 8)), over=1.0)  # the ground there, of whatever layer
        scene.remove(fill)  # a whole body, at once

    Mass, stress and momentum of the body are gone with the next step, and its weight counts no more in
    `initialStress`. The body itself stays in `scene.bodies`, empty, and its name is not free: contact and
    checkpoints know bodies by number. `internalWork` stays, so energy balances lack the kinetic energy alone
    that the body had. There is no way back but a checkpoint.

    Parameters
    ----------
    body : Body of this scene; default None: all that yield, so that walls and props stay.
    region : Region; default None: all of the body. Boxes that its edge cuts keep the mass, the volume and
        the centre of what is left of them; of a mesh whole domains go, by their centre, and a warning says
        how many are cut, and how `convert` makes boxes of them.
    over : s, time in which what the removed soil gave to the nodes, its internal forces and its weight, fades
        linearly (`ReleasedForces`), as finite elements release it in increments. Contact passed some of it on
        to a wall: that takes it over. Far longer than waves take through the ground, it gives the static
        answer. Default 0: at once, and the ground rebounds.

    Returns the mass that was taken out, Mg (plane strain: per metre; axisymmetric: of the whole
    circumference). Raises ValueError for a body of another scene, one that a Drive, a BoundaryLoad, a Spring
    or a Force is for, in scenes with a RigidContact, and for `over` with pore water, whose pressure it does
    not know, or under USF; TypeError for what is no body; RuntimeError during a step.
    """
    refuseDuringStep(scene, "remove")
    refuseMidStep(scene, "remove")
    if over > 0:
        return _removeSlowly(scene, body, region, over)
    return _remove(scene, body, region)


def _removeSlowly(scene, body, region, over):
    """The same, with forces that stay and fade."""
    if waterOf(scene):
        raise ValueError(
            f"Scene: remove(over={over:g}): the ground has pore water, whose pressure would go at once; "
            "leave over out, and dig in layers"
        )
    if scene.scheme == "USF":
        raise ValueError(
            f"Scene: remove(over={over:g}): under USF forces follow from stresses of the next step; give "
            "scheme='MUSL'"
        )
    labels = {engine.label for engine in scene.engines}
    names = ["released", *(f"released {k}" for k in range(2, len(labels) + 3))]
    released = classes["ReleasedForces"](over=over, label=next(n for n in names if n not in labels))
    released._core.set("begins", scene.time)
    _measure(scene, released)
    mass = _remove(scene, body, region)
    scene.engines.insert(scene.engines.index(scene._gridSolver("remove")), released)
    _measure(scene, released)
    return mass


def _measure(scene, released):
    """Lets it see the nodal forces of the particles as they are, with those of earlier removals."""
    scene.prepare()
    kinds = ("ParticleToGrid", "ReleasedForces")
    with scene._holder.held("remove"):
        for engine in [e for e in scene.engines if type(e).__name__ in kinds and e is not released]:
            scene._core.actAlone(engine._core)
        scene._core.actAlone(released._core)


def _remove(scene, body, region):
    if region is not None or body is None:
        return _removeRegion(scene, body, region)
    _check(scene, body)
    _refuseHeld(scene, body, body.id)
    mass = float(body.mass.sum())
    with scene._holder.held("remove"):
        empty = Boxes(np.zeros((0, scene.dim)), scene.cell / 4)
        if isinstance(body.type, MeshedType):
            dropDomains(scene, body, empty)
        else:
            build(body, empty)
        scene._geostaticLayers.pop(body.name, None)
        scene.stepper.noteChange()
    return mass


def _removeRegion(scene, body, region):
    if not isinstance(region, Region) or region.dim != scene.dim:
        raise TypeError(
            f"Scene: remove(region={shown(region)}); give a region of {scene.dim} dimensions, or a body"
        )
    if body is not None:
        _check(scene, body)
    bodies = [body] if body is not None else [b for b in scene.bodies if b.material._core.yields]
    found = [(one, *_partsOutside(one, region)) for one in bodies if isinstance(one, Body) and one.count]
    found = [(one, share, centre) for one, share, centre in found if (share < 1).any()]
    if not found:
        names = ", ".join(repr(b.name) for b in bodies) or "a body that yields"
        raise ValueError(
            f"Scene: remove: no particle of {names} is in {shown(region)}; give another region or the body"
        )
    for one, share, _ in found:
        _check(scene, one)
        if isBeam(one.material) and (share == 1).any():
            raise ValueError(
                f"body '{one.name}': remove: a part of a Beam cannot go; give two beams, one of which goes"
            )
        _refuseHeld(scene, one, one.id[share < 1])
    mass = 0.0
    for one, share, centre in found:
        before = float(one.mass.sum())
        if (share < LEAST_SHARE).all():
            _remove(scene, one, None)
        else:
            with scene._holder.held("remove"):
                _removeParts(scene, one, region, share, centre)
                scene.stepper.noteChange()
        mass += before - float(one.mass.sum())
    return mass


def _partsOutside(body, region):
    """Of each particle the part outside of a region, -, and the centre of that part, m (N, dim)."""
    dim = body.scene.dim
    if isinstance(body.type, MeshedType):
        return np.where(region.contains(body.position), 0.0, 1.0), body.position
    half = body.halfSize * np.abs(np.diagonal(body.deformationGradient, axis1=1, axis2=2)[:, :dim])
    share, centre = np.zeros(body.count), np.zeros((body.count, dim))
    for step in np.ndindex(*[SAMPLES] * dim):
        points = body.position + ((2 * np.array(step) + 1) / SAMPLES - 1) * half
        isOut = ~region.contains(points)
        share += isOut / SAMPLES**dim
        centre += isOut[:, None] * points / SAMPLES**dim
    return share, np.where(share[:, None] > 0, centre / np.maximum(share, 1e-9)[:, None], body.position)


def _removeParts(scene, body, region, share, centre):
    gone = np.flatnonzero(share < LEAST_SHARE)
    if isinstance(body.type, MeshedType):
        _warnOfCutDomains(body, region)
        dropDomains(scene, body, Boxes(np.zeros((0, scene.dim)), scene.cell / 4), gone)
        return
    part = np.flatnonzero((share >= LEAST_SHARE) & (share < 1))
    for name in ("mass", "volume", "initialVolume"):
        getattr(body, name)[part] *= share[part]
    body.reference[part] += centre[part] - body.position[part]
    body.position[part] = centre[part]
    if len(gone):
        dropBoxes(body, gone)
    body._core.massesChanged()


def _warnOfCutDomains(body, region):
    """Warns of domains with corners on both sides, with the line that makes boxes of them."""
    corners = body.corners()
    middle = body.position[:, None]
    within = middle + (1 - INSET) * (corners - middle)  # corners on the edge of the region are on one side
    isIn = region.contains(within.reshape(-1, body.scene.dim)).reshape(corners.shape[:2])
    cut = isIn.any(axis=1) & ~isIn.all(axis=1)
    if not cut.any():
        return
    lower, upper = (placeText(f(corners[cut].reshape(-1, body.scene.dim), axis=0)) for f in (np.min, np.max))
    warnUser(
        f"body '{body.name}': remove: the region cuts {cut.sum()} domains of its mesh, which go or stay "
        "whole; end it where domains end, or make boxes of them before it, which are cut: "
        f"scene['{body.name}'].convert(mpm.box({lower}, {upper}), mpm.UGIMP())"
    )


def _refuseHeld(scene, body, ids):
    """Springs and forces act on particles by their ids."""
    for engine in (e for e in scene.engines if isinstance(e, (Spring, PointForce))):
        for name, own in (("body", "ids"), ("toBody", "toIds")):
            held = getattr(engine, own, ()) if getattr(engine, name, None) == body.name else ()
            if np.isin(ids, np.array(held, int)).any():
                raise ValueError(
                    f"body '{body.name}': remove: {type(engine).__name__} '{engine.label}' acts on particles "
                    "there; call scene.detach of it first"
                )


def dropDomains(scene, body, empty, numbers=None):
    """Domains leave a mesh by becoming boxes; those go with a body of their own."""
    name = f"{body.name} (removed)"
    type = particleTypes["UGIMP"]()
    boxes = newBody(scene, name, body.material, type, None, 1.0, body.fbar, body.group, body.implicit)
    build(boxes, empty)
    scene._core.convertDomains(
        body.name,
        name,
        np.arange(body.count, dtype=np.int32) if numbers is None else np.asarray(numbers, np.int32),
    )
    drop(scene, boxes)
    keep(body, mesh=None)


def _check(scene, body):
    if not isinstance(body, Body):
        raise TypeError(f"Scene: remove({shown(body)}); give a body, e.g. scene.remove(scene['soil'])")
    who = f"body '{body.name}': remove"
    if not any(body is other for other in scene.bodies):
        raise ValueError(f"{who}: it is not a body of this scene; give one of scene.bodies")
    drives = [drive for e in scene.engines if isinstance(e, GridSolver) for drive in e.drives]
    inUse = {id(part) for part in (*scene.engines, *drives)}
    for part in scene._loadsAndDrives:
        of = part.part.body.name if isinstance(part, Drive) else part.body
        if of == body.name and id(part) in inUse:
            what = f"Drive '{part.name}'" if isinstance(part, Drive) else type(part).__name__
            raise ValueError(
                f"{who}: a {what} is for it; take that out of {_place(part)} first, and remove the body then"
            )
    if any(isinstance(engine, RigidContact) for engine in scene.engines):
        raise ValueError(
            f"{who}: RigidContact knows what touches by the number of its particle; build the scene without "
            "the body, and copy the fields of the others"
        )


def _place(part):
    return "the GridSolver" if isinstance(part, Drive) else "scene.engines"
