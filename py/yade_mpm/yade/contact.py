# SPDX-License-Identifier: GPL-2.0-or-later
"""`scene.contact` for bodies of YADE: it names them once, and the scene has the engine that they touch."""

import sys

from ..base.wording import shown
from ..engine.rigidContact import RigidContact
from ..particle.body import Body
from ..scene import groups
from . import loop
from .bodies import Bodies


def touch(scene, ids, soils, friction, adhesion, **options):
    """Bodies of YADE touch the soil: a `RigidContact` before the GridSolver, and the `Bodies` that attaching
    the scene takes by itself. Arguments as of `scene.contact`."""
    _refuseAttached(scene)
    named = _soils(scene, soils)
    engine = RigidContact()
    bodies = Bodies(engine, ids, friction=friction, adhesion=adhesion, **options)
    bodies.named = named
    place = scene.engines.index(scene._gridSolver("contact"))
    scene.engines.insert(place, engine)
    scene._asked.add(engine)
    loop.kept.setdefault(scene, []).append(bodies)
    scene.stepper.noteChange()
    return bodies


def _refuseAttached(scene):
    if any(coupling.scene is scene for coupling in loop.attached.values()):
        raise RuntimeError(
            "contact: the scene runs inside YADE already; call contact before mpm.inYade, or take more "
            "bodies in by append(ids) of what contact has returned"
        )


def _soils(scene, given):
    """Names of the bodies of the scene that a call names; None: all."""
    if given is None:
        return None
    soils = tuple(given) if isinstance(given, (tuple, list)) else (given,)
    for soil in soils:
        if not isinstance(soil, Body):
            raise TypeError(f"contact: second = {shown(given)}; give bodies of the scene, or leave it out")
        if soil.scene is not scene:
            raise ValueError(f"contact: '{soil.name}' is in another scene; give a body of this one")
    return [soil.name for soil in soils]


def checkNamed(scene, bodies):
    """Raises ValueError where a body of the scene touches bodies of YADE and no call has named it."""
    if getattr(bodies, "named", None) is None:  # exchanges of a user, too
        return
    for body in scene.bodies:
        if body.count and not any(body.name == n or body.name.startswith(f"{n} (") for n in bodies.named):
            raise ValueError(
                f"contact: bodies {bodies.ids} of YADE touch every body of the scene, '{body.name}', too; "
                "name it in scene.contact, or leave out the second argument for all (friction may be a "
                "function of the two materials)"
            )


def _isOfYade(given):
    """Whether something may be numbers of bodies of YADE: what is no body of a scene, where YADE is there."""
    one = next(iter(given), None) if isinstance(given, (tuple, list)) else given
    return hasattr(sys.modules.get("yade"), "O") and not isinstance(one, Body)


groups.hosts.append((_isOfYade, touch))
