# SPDX-License-Identifier: GPL-2.0-or-later
"""The initial stress of ground with sloping layers and surfaces, K0 by layer, by function or by OCR."""

from __future__ import annotations

import numpy as np

from ..base.attributes import keep
from ..base.keywords import checked
from ..base.kinds import FINITE, POSITIVE, SOME_BODIES, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..geometry.numbers import floats, isNumber
from ..material.spatial import valuesAt
from ..particle.body import Body
from .geostatic import weightOf
from .running import refuseDuringStep, refuseMidStep
from .wetting import displaced

OUT = (
    0.02  # of the weight of a layer: horizontal forces that are out of balance, above which a warning says so
)


@checked("Scene.groundStress")
@takes(bodies=SOME_BODIES)
def groundStress(
    scene,
    K0,
    OCR=1.0,
    bodies: list[Body] | None = None,
    gravity: float | None = None,
    water: float | None = None,
    weightBelow=None,
) -> dict[str, float]:
    """Stress of the ground under its own weight, column by column: for sloping layers and surfaces, too.

        scene.groundStress(K0={clay: "jaky", sand: 0.45}, OCR={clay: 4.0})
        scene.groundStress(K0=lambda x, y: np.interp(y, heights, values))

    The vertical stress is the weight of all that stands straight above a particle, the horizontal one K0
    times that; there is no shear. Level ground is in equilibrium. Under a slope it is a first guess: run
    `scene.settle()` after it.

    Parameters
    ----------
    K0 : coefficient at rest, -: a number; "jaky", 1 - sin phi of the material (Jaky 1944); a function of the
        coordinates (arrays) of the particles; a profile, pairs (height, value), such as `readProfile` makes
        of a CPT; or a dict body -> one of these.
    OCR : overconsolidation ratio, -, at least 1, for "jaky": K0 = (1 - sin phi) OCR^(sin phi) (Mayne &
        Kulhawy 1982); as K0, without "jaky"; default 1.
    bodies : the ground; default None: all bodies that yield.
    gravity : m/s2; default that of the scene, 9.81 where it has none yet.
    water : m, height of the water table; default None: none. There are no pore pressures: below it the weight
        is `weightBelow`, and the stress the effective one.
    weightBelow : kN/m3, buoyant unit weight below the water, a number or a dict body -> number: the mass of
        the particles there is set to it.

    Returns a dict: name of a layer -> horizontal forces on its nodes out of balance, over its weight.
    Warns of layers above 0.02. Raises ValueError and TypeError for what is not allowed.
    """
    refuseDuringStep(scene, "groundStress")
    refuseMidStep(scene, "groundStress")
    gravity = weightOf(scene) if gravity is None else gravity
    ground = [b for b in (bodies or scene.bodies) if b.count and (bodies or b.material._core.yields)]
    if not ground:
        raise ValueError("groundStress: no body of the scene yields; give the ground by bodies=[...]")
    POSITIVE.check("groundStress", "m/s2", gravity=gravity)
    if water is not None:
        FINITE.check("groundStress", "m", water=water)
    _refuseUnknown(scene, K0=K0, OCR=OCR, weightBelow=weightBelow)
    if water is None and weightBelow is not None:
        raise ValueError(
            "groundStress: weightBelow is given, and no water; give water, the height of its table, m"
        )
    if water is not None and (wet := [b.name for b in ground if b._core.hasPores]):
        raise ValueError(
            f"groundStress: water = {water:g} is given, and '{wet[0]}' has a PoreWater, which knows its "
            "table; leave water out"
        )
    coefficients = [_coefficient(body, K0, OCR) for body in ground]
    if water is not None:
        _wet(ground, water, weightBelow, gravity)
    keep(scene, _geostaticGravity=float(gravity))
    for body, k, vertical in zip(ground, coefficients, _overburden(scene, ground, gravity)):
        stress = np.zeros((body.count, 3, 3))
        for axis in range(3):
            stress[:, axis, axis] = -vertical * (1.0 if axis == scene.dim - 1 else k)
        body.setStress(stress)
    found = _outOfBalance(scene, ground, gravity)
    if worst := {name: part for name, part in found.items() if part > OUT}:
        told = ", ".join(f"'{name}' {100 * part:.0f} %" for name, part in worst.items())
        warnUser(
            f"groundStress: horizontal forces are out of balance by these parts of the weight: {told}; run "
            "scene.settle() before anything else happens"
        )
    return found


def _refuseUnknown(scene, **tables):
    """ValueError for a dict that gives a value to what is no body."""
    for name, table in tables.items():
        for key in table if isinstance(table, dict) else ():
            if not any(key is body or key == body.name for body in scene.bodies):
                known = ", ".join(repr(body.name) for body in scene.bodies)
                raise ValueError(
                    f"groundStress: {name} has a value for {shown(key)}, which is no body of the scene; "
                    f"there are {known}"
                )


def _of(given, body):
    """What was given for a body, alone or in a dict by bodies or their names."""
    if not isinstance(given, dict):
        return given
    for key in (body, body.name):
        for known, value in given.items():
            if known is key or isinstance(known, str) and known == key:
                return value
    raise ValueError(f"groundStress: nothing is given for '{body.name}'; give a value for each layer")


def _values(name, given, body, least=0.0):
    """A number for each particle, `least` or more."""
    try:
        value = given(*body.position.T) if callable(given) else given
        if isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) == 2:
            value = valuesAt(name, value, body.position, body.id)
        values = np.broadcast_to(floats(value), body.count)
    except (TypeError, ValueError):
        values = np.full(1, np.nan)
    if not (np.isfinite(values).all() and (values >= least).all()):
        raise ValueError(
            f"groundStress: {name} = {shown(given)} of '{body.name}' is not allowed; give a number of at "
            f"least {least:g}, a function of the coordinates that returns such numbers, or pairs (height, "
            "number)"
        )
    return values


def _coefficient(body, K0, OCR):
    given = _of(K0, body)
    if not isinstance(given, str):
        if not (isNumber(_of(OCR, body)) and _of(OCR, body) == 1):
            raise ValueError(
                f"groundStress: OCR of '{body.name}' has no meaning beside K0 = {shown(given)}; "
                "give K0='jaky', or leave OCR out"
            )
        return _values("K0", given, body)
    if given != "jaky":
        raise ValueError(
            f"groundStress: K0 = {shown(given)} is not allowed; give a number, 'jaky' or a function"
        )
    phi = getattr(body.material, "frictionAngle", None)
    if not isNumber(phi):
        raise ValueError(
            f"groundStress: K0 = 'jaky' needs one frictionAngle, which the material of '{body.name}' does "
            "not have; give a number or a function"
        )
    return (1 - np.sin(phi)) * _values("OCR", _of(OCR, body), body, least=1.0) ** np.sin(phi)


def _wet(ground, water, weightBelow, gravity):
    weights = [_of(weightBelow, body) for body in ground]
    for body, weight in zip(ground, weights):
        if not (isNumber(weight) and 0 < weight < np.inf):
            raise ValueError(
                f"groundStress: weightBelow = {shown(weight)} of '{body.name}' is not allowed; give the "
                "buoyant unit weight below the water, kN/m3"
            )
    for body, weight in zip(ground, weights):
        below = body.position[:, -1] < water
        body.mass[below] = weight / gravity * body.volume[below]
        body._core.massesChanged()


def _overburden(scene, ground, gravity):
    """Weight of what stands straight above each particle over the area of its strip in plan, kPa: (N,) for
    each body. Domains count in the strips of half a cell that they reach, by their part in them."""
    width = 0.5 * scene.cell[:-1]
    bodies = [body for body in scene.bodies if body.count]
    pieces = [_pieces(scene, body, width, gravity) for body in bodies]
    own = np.repeat(np.arange(len(bodies)), [len(piece[0]) for piece in pieces])
    strip, low, high, weight = (np.concatenate(x) for x in zip(*pieces))
    for k in (k for k, body in enumerate(bodies) if body not in ground):
        weight[own == k] *= _heldDown(strip, high, weight, own == k)
    order = np.argsort(strip, kind="stable")
    strip, low, high, weight = strip[order], low[order], high[order], weight[order]
    result = []
    for body in ground:
        own = _stripOf(scene, body.position[:, :-1], width)
        y, vertical = body.position[:, -1], np.zeros(body.count)
        for k in np.unique(own):
            a, b = np.searchsorted(strip, [k, k + 1])
            mine = np.flatnonzero(own == k)
            part = (high[a:b] - y[mine, None]) / np.maximum(high[a:b] - low[a:b], 1e-300)
            vertical[mine] = np.clip(part, 0, 1) @ weight[a:b]
        middle = scene.lower[0] + (own + 0.5) * width[0]
        result.append(vertical / (scene._thicknessAt(middle) * np.prod(width)))
    return result


def _stripOf(scene, plan, width):
    """Number of the strip in plan that points (N, dim - 1) are in."""
    counts = np.ceil((scene.upper - scene.lower)[:-1] / width).astype(int) + 1
    index = np.clip(((plan - scene.lower[:-1]) / width).astype(int), 0, counts - 1)
    return index[:, 0] if len(width) == 1 else index[:, 0] + counts[0] * index[:, 1]


def _heldDown(strip, high, weight, isOwn):
    """Share of the weight of each piece of a structure that counts: one that floats does not pull the ground
    below it, so no more of its uplift than what stands on it in the strip."""
    own = strip[isOwn]
    count = strip.max() + 1
    top = np.full(count, -np.inf)
    np.maximum.at(top, own, high[isOwn])
    isOn = ~isOwn & (high > top[strip])
    uplift, above = -np.bincount(own, weight[isOwn], count), np.bincount(strip[isOn], weight[isOn], count)
    share = np.clip(above, 0, np.maximum(uplift, 0)) / np.where(uplift > 0, uplift, 1.0)
    return np.where(uplift > 0, share, 1.0)[own]


def _pieces(scene, body, width, gravity):
    """Strip, lower and upper end (m) and weight (kN) of the parts of domains in strips."""
    corners = body.corners()
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    first = np.floor((lower[:, :-1] - scene.lower[:-1]) / width + 1e-9).astype(int)
    last = np.ceil((upper[:, :-1] - scene.lower[:-1]) / width - 1e-9).astype(int)
    mass = body.mass - displaced(scene, body)
    found = []
    for step in np.ndindex(*(last - first).max(axis=0)):
        left = scene.lower[:-1] + (first + step) * width
        inside = np.minimum(left + width, upper[:, :-1]) - np.maximum(left, lower[:, :-1])
        part = (np.maximum(inside, 0) / (upper - lower)[:, :-1]).prod(axis=1)
        some = part > 0
        strip = _stripOf(scene, left[some] + 0.5 * width, width)
        found.append((strip, lower[some, -1], upper[some, -1], gravity * (part * mass)[some]))
    return tuple(np.concatenate(x) for x in zip(*found))


def _outOfBalance(scene, ground, gravity):
    """Sum of the horizontal forces that nodes of a layer do not have in balance, over its weight, by name.
    Nodes on the sides of the grid and in structures are left out, for these hold them."""
    at, names = {}, [body.name for body in ground]
    touched = set()  # nodes that a structure moves, too, which holds the ground there
    for body in (b for b in scene.bodies if b.count and b not in ground):
        touched |= set(map(tuple, np.reshape(body._core.internalForces()["position"], (-1, scene.dim))))
    for body in ground:
        found = body._core.internalForces()
        x, f = (np.reshape(found[name], (-1, scene.dim)) for name in ("position", "force"))
        inside = ((x > scene.lower + 1e-9) & (x < scene.upper - 1e-9)).all(axis=1)
        for place, force in zip(map(tuple, x[inside]), f[inside, :-1]):
            if place in touched:
                continue
            at.setdefault(place, {})[body.name] = force
    sums = dict.fromkeys(names, 0.0)
    for forces in at.values():
        size = {name: np.linalg.norm(force) for name, force in forces.items()}
        left, all_ = np.linalg.norm(sum(forces.values())), sum(size.values())
        for name in forces:
            sums[name] += left * size[name] / all_ if all_ > 0 else 0.0
    return {body.name: sums[body.name] / (gravity * float(body.mass.sum())) for body in ground}
