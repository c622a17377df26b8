# SPDX-License-Identifier: GPL-2.0-or-later
"""The initial stress of level ground, a method of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..base.attributes import keep
from ..base.keywords import checked
from ..base.kinds import FINITE, LIST, NOT_NEGATIVE, POSITIVE, TEXT, Kind, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..engine.gridSolver import GridSolver
from ..material.materials import isBeam
from ..particle.body import Body


@dataclass
class Layer:
    """What initialStress made of a body: a layer of a unit weight, kN/m3, and K0."""

    weight: float
    K0: float
    lower: np.ndarray  # corners of the box round it, m; it ends at the surface
    upper: np.ndarray
    lowest: float  # height of its lowest particle, m: boxes that are cut reach below it

    def overburden(self, points, height):
        """Pressure on points (N, dim), kPa; zero where it is not above them, or reaches below `height`."""
        tolerance = 1e-6 * (self.upper - self.lower)
        isUnder = self.lowest > height - tolerance[-1]
        isWithin = (points > self.lower - tolerance)[:, :-1] & (points < self.upper + tolerance)[:, :-1]
        thickness = self.upper[-1] - max(self.lower[-1], height)
        return np.where(isUnder & isWithin.all(axis=1), self.weight * thickness, 0.0)


STANDARD = 9.81  # m/s2


def weightOf(scene):
    """Gravity of a scene downwards, m/s2; the standard one where it has none yet."""
    solver = next((e for e in scene._engines or () if isinstance(e, GridSolver)), None)
    down = -solver.gravity[-1] if solver is not None and solver.gravity else 0.0
    return down if down > 0 else STANDARD


LISTED = Kind("a list of bodies", lambda value: LIST.isOne(value) or TEXT.isOne(value))


@checked("Scene.initialStress")
@takes(bodies=LISTED)
def initialStress(
    scene,
    surface: float,
    K0: float,
    gravity: float | None = None,
    bodies: Iterable[Body | str] | None = None,
    unitWeight: float | None = None,
) -> None:
    """Geostatic stress below a level surface: sigma_v = -q - gamma z, sigma_h = K0 sigma_v, z the depth.

    Under a slope this is a first guess: run `scene.settle()` after it, which finds the stress of the slope.

    Ground of several layers takes one call for each: `bodies` are those of the layer, `surface` its top. q is
    the weight of the layers above, whether their call comes before or after; of bodies that stand beside each
    other only what lies straight above counts.

    Parameters
    ----------
    surface : float, m, height of the ground surface, or of the top of a layer (last axis).
    K0 : float, earth pressure coefficient at rest.
    gravity : float, m/s2; default that of the scene, 9.81 where it has none yet.
    bodies : list of Body; default: all that do not rise above the surface.
    unitWeight : float, kN/m3, gamma; default: density of each body times gravity.

    Warns where `surface` is not the top of the ground, by more than half a particle; ground of the same unit
    weight that stands above given bodies counts as theirs. Warns where the ground is lower over a part of the
    plan, column by column of cells, and of soil that the surface cuts and that is left out: a body whose
    material is of a type that the ground has, too. Warns where a layer stands on another one but
    reaches below its top, as inclined layers do: what it weighs there does not count. Raises ValueError when
    nothing lies below the surface or layers of different weight need a call each.
    """
    scene._refuseWhileRunning("initialStress")
    gravity = weightOf(scene) if gravity is None else gravity
    FINITE.check("initialStress", "m", surface=surface)
    NOT_NEGATIVE.check("initialStress", K0=K0)
    weighed = {} if unitWeight is None else {"unitWeight": unitWeight}
    POSITIVE.check("initialStress", gravity=gravity, **weighed)
    if bodies is not None:
        bodies = [bodies] if isinstance(bodies, str) else list(bodies)
        if not bodies:
            raise ValueError("initialStress: bodies is empty; give one or more, or leave it out for all")
    for body in bodies or ():
        if not isinstance(body, Body):
            instead = f"give scene[{body!r}]" if isinstance(body, str) else "give what scene.add returns"
            raise TypeError(f"initialStress: {shown(body)} among the bodies is not a body; {instead}")
    solid = [b for b in scene.bodies if b.count and not isBeam(b.material)]
    ground = bodies or [b for b in solid if b.position[:, -1].max() < surface]
    if not any(body.count for body in ground):
        raise ValueError(f"initialStress: {_whyNone([] if bodies else solid, surface)}")
    if wet := [b.name for b in ground if b._core.hasPores]:
        raise ValueError(
            f"initialStress: '{wet[0]}' has water; call scene.groundStress(K0=...), which knows its buoyancy"
        )
    weights = {b.material.density * gravity for b in ground} if unitWeight is None else {unitWeight}
    if len(weights) > 1:
        raise ValueError(
            f"initialStress: the bodies weigh {sorted(weights)} kN/m3; call it for each layer, with "
            f"bodies=[...] and the top of the layer as surface, or give unitWeight, or set body.stress"
        )
    keep(scene, _geostaticGravity=float(gravity) if unitWeight is None else None)
    weight = weights.pop()
    layers = scene._geostaticLayers
    ground = [body for body in ground if body.count]
    replaced = {body.name: layers.pop(body.name) for body in ground if body.name in layers}
    made = {body.name: _layerOf(body, weight, K0, surface) for body in ground}
    for body in ground:
        vertical = -weight * (surface - body.position[:, -1])
        for layer in layers.values():
            vertical = vertical - layer.overburden(body.position, surface)
        body.setStress(_stress(vertical, K0, scene.dim))
    for name, layer in layers.items():  # made before, and now under something
        body, height = scene[name], layer.upper[-1]
        added = np.zeros(body.count)
        for sign, some in ((-1, made), (1, replaced)):
            for above in some.values():
                added += sign * above.overburden(body.position, height)
        if added.any():
            body.setStress(body.stress + _stress(added, layer.K0, scene.dim))
    layers.update(made)
    isAlike = [unitWeight is not None or b.material.density * gravity == weight for b in scene.bodies]
    alike = [b for b, isSo in zip(scene.bodies, isAlike) if isSo and b.count]
    if not _warnOfSurface(ground, alike if bodies else ground, surface, weight):
        _warnOfSlope(scene, ground, surface, weight)
    if not bodies:
        _warnOfCut(scene, ground, surface)
    _warnOfInclined(scene, layers, made)


def _whyNone(solid, surface):
    """Why no body is ground below a surface, and what to do."""
    if not solid:
        return "there is no body with particles; call it after scene.add"
    axis = "xyz"[solid[0].scene.dim - 1]
    lowest = min(solid, key=lambda body: body.position[:, -1].min())
    top = _topOf(lowest)[0]
    if lowest.position[:, -1].min() >= surface:
        bottom = lowest.corners()[..., -1].min()
        return (
            f"no body lies below the surface {surface:g} m: the lowest, '{lowest.name}', begins at {axis} = "
            f"{bottom:g} m; give the height of the ground along {axis}"
        )
    return (
        f"body '{lowest.name}' rises above the surface {surface:g} m, to {axis} = {top:g} m; give that "
        f"height as surface, or name the ground by bodies=[scene['{lowest.name}']]"
    )


def _warnOfSurface(ground, alike, surface, weight):
    """Warns of a surface above the top of all bodies of that weight, or below that of the ground itself;
    whether it did."""
    isOff = False
    for bodies, sign, says in ((alike, 1, "more than there is"), (ground, -1, "less, with tension above it")):
        top, tolerance, name = max(_topOf(body) for body in bodies)
        if sign * (surface - top) > tolerance:
            isOff = True
            warnUser(
                f"initialStress: surface = {surface:g} m, but the top of '{name}' is at {top:g} m: the "
                f"stress is that of {abs(surface - top):g} m of ground {says}, "
                f"{weight * abs(surface - top):.3g} kPa; give the top of the bodies, a call for each layer"
            )
    return isOff


def _warnOfSlope(scene, ground, surface, weight):
    """Warns where the top of the ground, with all that stands on it, is lower over a part of the plan."""
    lines = scene.lines[:-1]
    shape = [len(x) + 1 for x in lines]
    top, slack, isGround = np.full(shape, -np.inf), np.zeros(shape), np.zeros(shape, dtype=bool)
    for body in scene.bodies:
        if not body.count:
            continue
        corners = body.corners()
        height, half = corners[..., -1].max(axis=1), corners[..., -1].max(axis=1) - body.position[:, -1]
        inside = body.position[:, None, :-1] * 1e-6 + corners[..., :-1] * (1 - 1e-6)
        for at in _columnsOf(inside, lines):
            np.maximum.at(top, at, height)
            isTop = height == top[at]
            np.maximum.at(slack, tuple(i[isTop] for i in at), half[isTop])
        if body in ground:
            isGround[next(_columnsOf(body.position[:, None, :-1], lines))] = True
    missing = np.where(isGround & (surface - top > slack * (1 + 1e-6)), surface - top, 0.0)
    if not missing.any():
        return
    at = np.unravel_index(missing.argmax(), shape)
    place = ", ".join(f"{name} = {(x[i - 1] + x[i]) / 2:g}" for name, x, i in zip("xy", lines, at))
    warnUser(
        f"initialStress: surface = {surface:g} m, but the ground is lower over "
        f"{100 * (missing > 0).sum() / isGround.sum():.0f} % of its plan, most at {place} m with its top at "
        f"{top[at]:g} m: the stress there is that of {missing[at]:g} m of ground more than there is, "
        f"{weight * missing[at]:.3g} kPa; a level surface is a first guess of a slope: run scene.settle() "
        "before anything else happens, or set body.stress"
    )


def _columnsOf(points, lines):
    """Columns of cells that the boxes round points (N, M, dim - 1) reach, as index arrays to go through."""
    first, last = (
        [np.searchsorted(x, edge[:, k]) for k, x in enumerate(lines)]
        for edge in (points.min(axis=1), points.max(axis=1))
    )
    for step in np.ndindex(*(1 + int((b - a).max()) for a, b in zip(first, last))):
        yield tuple(np.minimum(a + i, b) for a, b, i in zip(first, last, step))


def _warnOfCut(scene, ground, surface):
    """Warns of soil that the surface cuts, so that it is left out."""
    kinds = {type(body.material) for body in ground}
    for body in scene.bodies:
        if body in ground or not body.count or type(body.material) not in kinds:
            continue
        lowest, highest = body.position[:, -1].min(), body.position[:, -1].max()
        if lowest < surface <= highest:
            bottom, top = (float(f(body.corners()[..., -1])) for f in (np.min, np.max))
            warnUser(
                f"initialStress: surface = {surface:g} m cuts '{body.name}', which reaches from {bottom:g} "
                f"to {top:g} m: it is left out and keeps its stress; call initialStress for it with "
                f"bodies=[...] and its top as surface, and name the bodies of this call, too"
            )


def _topOf(body):
    """Height of the top, m; half the height of the particle there, to which a lattice meets it; name."""
    top = float(body.corners()[..., -1].max())
    return top, top - float(body.position[:, -1].max()), body.name


def _warnOfInclined(scene, layers, made):
    for name, below in layers.items():
        for other, above in layers.items():
            top = below.upper[-1]
            if name == other or above.lowest > top or not {name, other} & set(made):
                continue
            points = scene[other].position
            if _standsOn(scene[name].position, points[points[:, -1] > top]):
                warnUser(
                    f"initialStress: '{other}' stands on '{name}', but reaches from {above.lower[-1]:g} to "
                    f"{above.upper[-1]:g} m, below its top of {top:g} m: its weight is left out there, for "
                    "layers have to be level; set body.stress, or let gravity grow and settle"
                )


def _standsOn(points, above):
    """Whether some points (N, dim) are straight below the box round others."""
    if not len(above):
        return False
    plan, ends = points[:, :-1], above[:, :-1]
    return bool(((plan > ends.min(axis=0)) & (plan < ends.max(axis=0))).all(axis=1).any())


def _stress(vertical, K0, dim):
    stress = np.zeros((len(vertical), 3, 3))
    for k in range(3):
        stress[:, k, k] = vertical * (1.0 if k == dim - 1 else K0)
    return stress


def _layerOf(body, weight, K0, surface):
    corners = body.corners().reshape(-1, body.scene.dim)
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    upper[-1] = surface
    return Layer(weight, K0, lower, upper, float(body.position[:, -1].min()))
