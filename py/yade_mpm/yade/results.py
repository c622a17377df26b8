# SPDX-License-Identifier: GPL-2.0-or-later
"""Results where a user of YADE looks for them: interactions, energies, materials, unbalanced force."""

import math
from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np

from .. import diagnostics
from ..base.wording import shown
from ..engine.rigidContact import RigidContact


def _ofRigid(name):
    """A function of a scene: the sum of an attribute over its contacts with rigid bodies, kJ."""
    return lambda scene: sum(getattr(e, name) for e in scene.engines if isinstance(e, RigidContact))


_bodyWork, _soilWork = _ofRigid("bodyWork"), _ofRigid("soilWork")
ENERGIES = {
    "kinetic": diagnostics.kineticEnergy,
    "internalWork": diagnostics.internalWork,
    "damped": diagnostics.dampedEnergy,
    "contact": diagnostics.contactEnergy,
    "implicit": diagnostics.implicitEnergy,
    "friction": _ofRigid("frictionWork"),
    "springs": _ofRigid("springEnergy"),
    "externalWork": lambda scene: _soilWork(scene) - diagnostics.externalWork(scene),
    "bodyWork": lambda scene: -_bodyWork(scene),
}  # rows of O.energy; with the row "error" they add up to what the scene began with
ENERGY_PERIOD = 100  # DEM steps between two looks: they go through all particles


def interactionsOf(bodies, scene):
    """Contacts of bodies of YADE with the soil in the last step, with the names of YADE's interactions.

    id1 : number of the body of YADE; id2 : number of the particle or vertex in its body of the scene; soil :
    name of that. geom : normal (out of the body of YADE), penetrationDepth (m), contactPoint. phys :
    normalForce and shearForce on the soil, kN. Vectors in the axes of YADE, forces times the thickness.
    """
    table, plane = bodies.contact.contactTable(), bodies.plane
    normal, point = plane.toYade(table["normal"]), plane.toYade(table["point"])
    force = plane.toYade(table["force"]) * (bodies.thickness if scene.dim == 2 else 1)
    pushed = (force * normal).sum(axis=1, keepdims=True) * normal
    return [
        SimpleNamespace(
            id1=bodies.ids[table["body"][k]],
            id2=int(table["id"][k]),
            soil=scene.bodies[table["soil"][k]].name,
            geom=SimpleNamespace(
                normal=normal[k], penetrationDepth=-float(table["gap"][k]), contactPoint=point[k]
            ),
            phys=SimpleNamespace(normalForce=pushed[k], shearForce=force[k] - pushed[k]),
        )
        for k in range(len(force))
    ]


def unbalancedForce(coupling, useMaxForce=False):
    """What utils.unbalancedForce() tells, with the contacts of the soil: mean (or largest) resultant force on
    the bodies that may move, over the mean force of all contacts; nan without a contact."""
    omega = coupling._omega
    newton = next((e for e in omega.engines if type(e).__name__ == "NewtonIntegrator"), None)
    gravity = np.zeros(3) if newton is None else np.array(newton.gravity)
    resultants = [
        np.linalg.norm(np.array(omega.forces.f(b.id, sync=True)) + b.state.mass * gravity)
        for b in omega.bodies
        if b is not None and b.dynamic and not b.isClumpMember and b.state.mass > 0
    ]
    contacts = [i.phys.normalForce + i.phys.shearForce for i in omega.interactions if i.isReal]
    contacts += [i.phys.normalForce + i.phys.shearForce for i in coupling.interactions]
    if not contacts or not resultants:
        return float("nan")
    mean = np.mean([np.linalg.norm(f) for f in contacts])
    return float((np.max if useMaxForce else np.mean)(resultants) / mean)


class Energies:
    """Rows of a scene in O.energy while O.trackEnergy is set: label_kinetic, label_internalWork ..., kJ. The
    row label_error is what the others lack of their sum when the scene was attached.

    omega : O of YADE. scene : Scene. label : of the coupling.
    """

    def __init__(self, omega, scene, label):
        self._omega, self._scene, self._label, self._lookAt = omega, scene, label, 0
        self._start = sum(function(scene) for function in ENERGIES.values())

    def stepsToNext(self):
        """DEM steps before the next look."""
        return self._lookAt - self._omega.iter - 1 if self._omega.trackEnergy else math.inf

    def note(self, isDue=False):
        """Writes the rows every 100 steps, or now."""
        if not self._omega.trackEnergy or not (isDue or self._omega.iter >= self._lookAt):
            return
        self._lookAt = self._omega.iter + ENERGY_PERIOD
        rows = {name: function(self._scene) for name, function in ENERGIES.items()}
        rows["error"] = self._start - sum(rows.values())
        for name, value in rows.items():
            self._omega.energy[f"{self._label}_{name}"] = value


class Materials(Sequence):
    """The materials of a scene, by number or by the name of a body, as O.materials has those of YADE."""

    def __init__(self, scene):
        self._bodies = scene.bodies

    def __len__(self):
        return len(self._bodies)

    def __getitem__(self, key):
        if not isinstance(key, str):
            return self._bodies[key].material
        for body in self._bodies:
            if body.name == key:
                return body.material
        raise KeyError(
            f"materials: there is no body {shown(key)}; bodies: {', '.join(b.name for b in self._bodies)}"
        )

    def __repr__(self):
        return "\n".join(f"{body.name}: {body.material!r}" for body in self._bodies)
