# SPDX-License-Identifier: GPL-2.0-or-later
"""What a history records besides the columns of its user: scene, reactions, contacts, energies."""

import math

from .. import diagnostics
from ..engine.contact import Contact
from ..engine.poreWater import PoreWater
from ..engine.prescribed import Drive, Hold
from ..engine.supports import PointForce, Spring, SurfaceLoad

STANDARD = {  # name -> (unit in 3D, function of the scene)
    "time": ("s", lambda scene: scene.time),
    "step": ("-", lambda scene: scene.steps),
    "dt": ("s", lambda scene: scene.stepper.dt),
    "dtCritical": ("s", lambda scene: math.nan if scene.dtCritical is None else scene.dtCritical),
    "particles": ("-", lambda scene: scene.particleCount),
    "mass": ("Mg", diagnostics.mass),
    "kineticEnergy": ("kJ", diagnostics.kineticEnergy),
    "unseenEnergy": ("kJ", diagnostics.unseenEnergy),
    "internalWork": ("kJ", diagnostics.internalWork),
    "externalWork": ("kJ", diagnostics.externalWork),
    "dampedEnergy": ("kJ", diagnostics.dampedEnergy),
    "contactEnergy": ("kJ", diagnostics.contactEnergy),
    "workDone": ("kJ", diagnostics.workDone),
    "unbalancedRatio": ("-", diagnostics.unbalancedRatio),
    "minJacobian": ("-", diagnostics.minJacobian),
    "hourglassAmplitude": ("-", diagnostics.hourglassAmplitude),
    "hourglassEnergy": ("kJ", diagnostics.hourglassEnergy),
    "distortedCount": ("-", diagnostics.distortedCount),
    "invertedCount": ("-", diagnostics.invertedCount),
    "convertedCount": ("-", diagnostics.convertedCount),
    "volumeRatio": ("-", diagnostics.volumeRatio),
}


EXTENSIVE = ("kN", "kN m", "kJ", "Mg", "Mg m/s", "m3/s")  # per metre of thickness in plane strain


def measured(scene, means):
    """Dict name -> (unit in 3D, value) of all standard columns.

    Parameters
    ----------
    scene : Scene
    means : dict name -> mean of what `timeIntegrals` has, since the last row; values of the last step where
        missing.
    """
    row = {}
    for name, (unit, function) in STANDARD.items():
        row[name] = (unit, function(scene))
        if name == "particles":
            row.update(_reactions(scene, means))
            row.update(_contacts(scene, means))
            row.update(_supports(scene, means))
            row.update(_water(scene))
        elif name == "mass":
            momentum = diagnostics.momentum(scene)
            row.update((f"momentum.{axis}", ("Mg m/s", p)) for axis, p in zip("xyz", momentum))
        elif name == "contactEnergy":
            if any(body.implicit for body in scene.bodies):
                row["implicitEnergy"] = ("kJ", diagnostics.implicitEnergy(scene))
            error = diagnostics.energyError(scene, kinetic=row["kineticEnergy"][1])
            row["energyError"] = ("kJ", error)
        elif name == "workDone":
            row["kineticRatio"] = ("-", diagnostics.kineticRatio(scene, row["kineticEnergy"][1]))
            if any(isinstance(c, Drive) for c in scene.constraints):
                row["freeKineticEnergy"] = ("kJ", diagnostics.freeKineticEnergy(scene))
    return row


def _reactions(scene, means):
    """Reaction, moment and work of every prescribed motion; of a driven part, its displacement."""
    row, dim = {}, scene.dim
    for c in scene.constraints:
        six = means.get(c.name, [*c._core.reaction, *c._core.moment])
        row.update((f"{c.name}.f{axis}", ("kN", f)) for axis, f in zip("xyz"[:dim], six))
        isFace = isinstance(c, Hold) and isinstance(c.where, str) and c.name == c.where
        if not isFace:
            axes = (2,) if dim == 2 else (0, 1, 2)
            row.update((f"{c.name}.m{'xyz'[k]}", ("kN m", six[3 + k])) for k in axes)
        row[f"{c.name}.work"] = ("kJ", c.work)
        if isinstance(c, Drive):
            row.update((f"{c.name}.u{axis}", ("m", u)) for axis, u in zip("xyz", c.displacement))
            row[f"{c.name}.rowsCrossed"] = ("-", c.rowsCrossed)
    return row


def _contacts(scene, means):
    """Force between each pair of groups; work of friction and overlap of all."""
    contact = _contactOf(scene)
    if contact is None:
        return {}
    row = {}
    for pair, force in contact.forces().items():
        name = _nameOf(pair)
        components = zip("xyz"[: scene.dim], means.get(name, force))
        row.update((f"{name}.f{axis}", ("kN", f)) for axis, f in components)
    row["contact.frictionWork"] = ("kJ", contact.frictionWork)
    row["contact.largestPenetration"] = ("m", contact.largestPenetration)
    return row


def _supports(scene, means):
    """Force of every spring, and of forces and loads."""
    row, axes = {}, "xyz"[: scene.dim]
    for engine in _supportsOf(scene):
        if isinstance(engine, Spring):
            row[f"{engine.label}.force"] = ("kN", *means.get(_nameOfSupport(engine), [engine.force]))
        else:
            force = means.get(_nameOfSupport(engine), engine.force or [0.0] * scene.dim)
            row.update((f"{engine.label}.f{axis}", ("kN", f)) for axis, f in zip(axes, force))
    return row


def _water(scene):
    """Flow out of the soil, and what its solution took."""
    water = next((e for e in scene.engines if isinstance(e, PoreWater) and not e.dead), None)
    if water is None:
        return {}
    row = {f"water.{name}": ("m3/s", getattr(water, name)) for name in ("outflow", "inflow")}
    return row | {"water.iterations": ("-", water.iterations)}


def _supportsOf(scene):
    kinds = Spring, PointForce, SurfaceLoad
    return [engine for engine in scene.engines if isinstance(engine, kinds) and engine.label]


def _nameOfSupport(engine):
    return f"{type(engine).__name__} {engine.label}"


def _contactOf(scene):
    """The Contact among the engines of a scene, or None."""
    return next((e for e in scene.engines if isinstance(e, Contact) and not e.dead), None)


def _nameOf(pair):
    return "contact.{}-{}".format(*pair)


def timeIntegrals(scene):
    """Dict name -> time integrals of what a history averages.

    These are reaction and moment of each prescribed motion, and the force between each pair of groups.
    """
    integrals = {c.name: [*c._core.impulse, *c._core.angularImpulse] for c in scene.constraints}
    contact = _contactOf(scene)
    if contact is not None:
        integrals.update(
            (_nameOf(pair), impulse.tolist()) for pair, impulse in contact.forceImpulses().items()
        )
    for engine in _supportsOf(scene):
        if isinstance(engine, Spring):
            integrals[_nameOfSupport(engine)] = [engine.impulse]
        else:
            integrals[_nameOfSupport(engine)] = list(engine.impulse or [0.0] * scene.dim)
    return integrals


def perMetre(unit):
    return unit + "/m" if unit in EXTENSIVE else unit
