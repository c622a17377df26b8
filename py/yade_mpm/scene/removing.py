# SPDX-License-Identifier: GPL-2.0-or-later
"""A body taken out of a scene between two runs, as in an excavation."""

import numpy as np

from ..base.attributes import keep
from ..base.wording import shown
from ..engine.boundaryLoad import BoundaryLoad
from ..engine.gridSolver import GridSolver
from ..engine.prescribed import Drive
from ..engine.rigidContact import RigidContact
from ..particle.body import Body
from ..particle.types import Boxes, MeshedType, classes
from .adding import build, drop, newBody
from .running import refuseDuringStep, refuseMidStep


def remove(scene, body: Body) -> None:
    """Takes all particles of a body out of the scene, between two runs: an excavation.

    Weight, stress and momentum of the body are gone with the next step, and its weight counts no more in
    `initialStress`. The body itself stays in `scene.bodies`, empty, and its name is not free: contact and
    checkpoints know bodies by number. `internalWork` stays, so energy balances lack the kinetic energy alone
    that the body had. There is no way back but a checkpoint.

    Parameters
    ----------
    body : Body of this scene.

    Raises ValueError for a body of another scene, one that a Drive or a BoundaryLoad is for,
    and in scenes with a RigidContact; TypeError for what is no body; RuntimeError during a step.
    """
    refuseDuringStep(scene, "remove")
    refuseMidStep(scene, "remove")
    _check(scene, body)
    with scene._holder.held("remove"):
        empty = Boxes(np.zeros((0, scene.dim)), scene.cell / 4)
        if isinstance(body.type, MeshedType):
            _dropDomains(scene, body, empty)
        else:
            build(body, empty)
        scene._geostaticLayers.pop(body.name, None)
        scene.stepper.noteChange()


def _dropDomains(scene, body, empty):
    """Domains leave a mesh by becoming boxes; those go with a body of their own."""
    name = f"{body.name} (removed)"
    boxes = newBody(scene, name, body.material, classes["UGIMP"](), None, 1.0, body.fbar, body.group)
    build(boxes, empty)
    scene._core.convertDomains(body.name, name, np.arange(body.count, dtype=np.int32))
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
            what = f"Drive '{part.name}'" if isinstance(part, Drive) else "BoundaryLoad"
            raise ValueError(
                f"{who}: a {what} is for it; take that out of {_place(part)} first, and remove the body then"
            )
    if any(isinstance(engine, RigidContact) for engine in scene.engines):
        raise ValueError(
            f"{who}: RigidContact knows what touches by the number of its particle; build the scene without "
            "the body, and copy the fields of the others"
        )


def _place(part):
    return "scene.engines" if isinstance(part, BoundaryLoad) else "the GridSolver"
