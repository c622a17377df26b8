# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether the domains of a scene can go on: edges at interfaces, distortion, values that are not finite."""

import numpy as np

from ..engine.prescribed import FACES
from ..engine.rigidContact import RigidContact
from ..geometry.numbers import placeText
from ..material.materials import isBeam
from ..material.spatial import largestOf
from . import limits

HELD = 0.4  # of a cell: the way of a Hold from which on its load falls, measured with a strip footing


def checkInterface(scene, limit):
    """Refuses APDI edges that are too long beside uGIMP particles, or beside a mesh of another group.

    Parameters
    ----------
    scene : Scene
    limit : float, cells; longer edges within one cell of these raise ValueError (in a run RuntimeError).

    Returns what is wrong with the longest of those above INTERFACE_WARN, as text; or None.
    """
    fault = scene._core.interfaceFault(min(limit, limits.INTERFACE_WARN))
    if fault is None:
        return None
    meshed, other, where = fault["meshed"], fault["other"], fault["where"]
    edge, initial = fault["edge"], fault["initialEdge"]
    cell = fault["cell"]
    place = f"interface of '{meshed}' and '{other}' near {where}: an edge"
    isMesh = scene[other].type._core.isMeshed
    beside = "within one cell of " + ("a mesh of another group" if isMesh else "uGIMP particles")
    if initial > limits.INTERFACE_BUILD * cell:
        text = (
            f"{place} of {edge:.6g} m is longer than the cell {cell:.6g} m {beside}; "
            f"refine '{meshed}' there, e.g. APDI(size=..., matched=...)"
        )
    else:
        text = (
            f"{place} has stretched from {initial:.3g} to {edge:.3g} m, {edge / cell:.3g} cells, {beside}, "
            f"where the stress becomes wrong beyond one cell (a run ends at "
            f'{limits.INTERFACE_RUN:g}); use UGIMP there, or APDI(onDistortion="convert")'
        )
    if edge > limit * cell:
        raise (ValueError(text) if scene.steps == 0 else RuntimeError(f"step {scene.steps}: {text}"))
    return text


def deepOverlap(scene):
    """Which rigid body was the first to overlap with a particle by more than a quarter of its width, as
    text; or None."""
    for contact in (e for e in scene.engines if isinstance(e, RigidContact)):
        if (found := contact._core.deep()) is not None:
            body, soil, depth, step = found
            return (
                f"RigidContact: rigid body {body} was {depth:.3g} m deep in '{scene.bodies[soil].name}' in "
                f"step {step}, more than a quarter of the width of what it touches; at a whole width the run "
                "ends. Lower dt, give a larger stiffness, move the body more slowly, or give a thin shape a "
                "thickness"
            )
    return None


def costlyBodies(scene):
    """Which implicit bodies take most of the time of a step, as text; or None."""
    engine = next((e for e in scene.engines if type(e).__name__ == "ImplicitBodies"), None)
    total = sum(e.seconds for e in scene.engines) if engine else 0.0
    if total < limits.IMPLICIT_SECONDS or engine.seconds <= limits.IMPLICIT_SHARE * total:
        return None
    names = ", ".join(f"'{body.name}'" for body in scene.bodies if body.implicit and body.count)
    hasBeam = any(isBeam(body.material) for body in scene.bodies if body.implicit and body.count)
    explicit = "implicit=True out where the step is long enough (scene.criticalTimeStep(asIfExplicit=True))"
    cure = "draw a Beam thinner (two cells are enough)" if hasBeam else f"leave {explicit}"
    return (
        f"ImplicitBodies: {names} take {100 * engine.seconds / total:.0f} % of the time, "
        f"{1e3 * engine.seconds / engine.calls:.3g} ms in a step. It grows with the cells along a body and "
        f"the square of those across it: give larger cells there, model half of it beside a roller, or {cure}"
    )


def distortion(scene):
    """Which APDI domain is distorted most, if any is much, as text; or None."""
    poor = [
        (found["quality"], body, found["worst"], found["count"])
        for body in scene.bodies
        for found in [body._core.poorDomains(limits.POOR_QUALITY)]
        if found["count"]
    ]
    if not poor:
        return None
    quality, body, particle, count = min(poor, key=lambda p: p[0])
    number = f"{count} domains" if count > 1 else "a domain"
    converts = body.type._core.converts
    return (
        f"{number} of '{body.name}' distorted, most that of particle {body.id[particle]} at "
        f"{placeText(body.position[particle])}: smallest corner {100 * quality:.3g} % of its area, and at 5 "
        f"% {'it becomes uGIMP' if converts else 'the run stops'}; use UGIMP there"
        + ("" if converts else ', or APDI(onDistortion="convert")')
        + (", or half the time step, or MUSL: USF is first order in time" if scene.scheme == "USF" else "")
    )


def locking(body):
    """What is wrong with a body that flows without F-bar, or implicit, as text; or None."""
    if body.fbar or not body.count or "plasticShearStrain" not in body.fieldNames:
        return None
    share = np.mean(body.plasticShearStrain > limits.FLOW_STRAIN)
    if share <= limits.FLOW_SHARE:
        return None
    if body.implicit:
        return (
            f"body '{body.name}' yields and is implicit: {100 * share:.3g} % of its particles have a plastic "
            f"shear strain above {100 * limits.FLOW_STRAIN:g} %, and the solution adds elastic forces beyond "
            "their strength, on the unsafe side (by a third at twice the step of the explicit body, more at "
            "longer ones); leave implicit=True out, or take a shorter step"
        )
    return (
        f"body '{body.name}' yields without F-bar: {100 * share:.3g} % of its particles have a plastic shear "
        f"strain above {100 * limits.FLOW_STRAIN:g} %, and soil that locks is too strong, on the unsafe side "
        "(slopes, cuts and footings by 5 to 40 %); leave fbar=False out, unless the bare form is meant"
    )


def flowing(body):
    """What is wrong with a mesh with F-bar that flows, as text; or None."""
    isMesh = body.type._core.isMeshed and body.fbar and body.count
    if not isMesh or "plasticShearStrain" not in body.fieldNames:
        return None
    share = np.mean(body.plasticShearStrain > limits.MESH_FLOW_STRAIN)
    if share <= limits.MESH_FLOW_SHARE:
        return None
    isAmongBoxes = any(
        other.group == body.group and other.fbar and other.count and not other.type._core.isMeshed
        for other in body.scene.bodies
    )
    error = "on sand a strip footing resists up to 15 % too much"
    if isAmongBoxes:
        error = "beside boxes a strip footing resists up to 8 % too much"
    return (
        f"body '{body.name}' is a mesh and flows: {100 * share:.3g} % of its domains have a plastic shear "
        f"strain above {100 * limits.MESH_FLOW_STRAIN:g} %, and their edges stay straight where the flow "
        f"bends ({error}); make boxes (UGIMP) of all that flows, or compare with a run that has them"
    )


def opened(body):
    """Tells of soil that does not dilate and has gained volume, as text; or None."""
    given = body.material.attributes()
    mayClose = "closing" in body.material._attributeNames()
    if (
        not (body.count and mayClose)
        or given.get("closing", body.fbar)
        or largestOf(body, "dilatancyAngle") > 0
    ):
        return None
    growth = body.volume.sum() / body.initialVolume.sum() - 1
    if growth <= limits.OPENED_VOLUME:
        return None
    return (
        f"body '{body.name}' has gained {100 * growth:.3g} % of volume, though its soil does not dilate: it "
        "opened at the tip of its yield surface, and resists pressure before it has closed; leave "
        f"closing=False of {type(body.material).__name__} out, or give closing=True"
    )


BY_HAND = "set it before the next step"
OF_THE_RUN = (
    "either something has written it, or the particle was torn or turned inside out in the run: look at the "
    "last frames, lower dt or the loads (F-bar, closing and splitAt keep soil whole that flows "
    "far), and go on from an older checkpoint"
)


def checkFields(body, advice=BY_HAND):
    """Refuses values that are not finite, mass or volume that is not positive, and strengths out of range.

    Parameters
    ----------
    body : Body
    advice : str, what to do about them; default: what is right for values that were set between runs.
    """
    for ofDomains in (False, True):
        for name in (field["name"] for field in body._core.fields(ofDomains)):
            if name != "bodyForce" or body._core.hasBodyForce:
                _checkField(body, name, np.asarray(body._core.view(name, ofDomains)), advice)


def _checkField(body, name, values, advice):
    if name == "stress" and body.scene.dim == 2 and values[:, 2, :2].any():
        raise ValueError(
            f"body '{body.name}': stress has shear out of the plane, which plane strain does not have; "
            f"set its components xz and yz to zero, or make a 3D scene"
        )
    isWrong, allowed = ~np.isfinite(values), "finite"
    if not isWrong.any() and name in ("mass", "volume", "initialVolume"):
        isWrong, allowed = values <= 0, "positive"
    if isWrong.any():
        at = tuple(np.argwhere(isWrong)[0])
        who = f"entry {at[0]}{_ofParticle(body, name, at[0])}"
        raise ValueError(
            f"body '{body.name}': {name} = {values[at]:g} of {who} is not {allowed}, and "
            f"only {allowed} numbers are allowed; {advice}"
        )
    try:
        body.material._checkRange(name, values)
    except ValueError as error:
        raise ValueError(f"body '{body.name}': {error}; {advice}") from None


def _ofParticle(body, name, entry):
    """Which particle an entry is, as text; of a vertex nothing."""
    if name not in body.fieldNames:
        return ""
    return f" (particle {body.id[entry]} at {placeText(body.position[entry])})"


def leftBehind(scene, hold):
    """Text where a `Hold` has gone so far that the material leaves its nodes, which stay; else None."""
    way = np.abs(hold.follow(scene.time)) * np.ones(scene.dim)
    if isinstance(hold.where, str):  # along a face nothing leaves
        across = FACES[scene.dim][hold.where][0]
        way[np.arange(scene.dim) != across] = 0.0
    if (way < HELD * scene.cell).all():  # the smallest one
        return None
    cells = way / scene.cellSizeAt(scene.nodePositions()[hold._core.nodes]).min(axis=0)
    if cells.max() < HELD:
        return None
    return (
        f"Hold '{hold.name}' has gone {way[cells.argmax()]:.3g} m, {cells.max():.2g} of a cell: its nodes "
        "stay where they are and the material leaves them, so that the load falls; press a body by Drive"
    )
