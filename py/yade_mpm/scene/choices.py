# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene chooses where the user leaves it out: particles of a body, and which bodies are implicit.

`body._chosen` has the reason of each choice, by name; what the user sets is no choice any more.
"""

import numpy as np

from ..geometry.particleSet import ParticleSet
from ..geometry.region import Region
from ..geometry.terrain import Layer
from ..particle.types import classes
from .groups import arrange

SPLIT = 1.3  # stretch at which boxes are cut (doc/explanation/numerical-fracture.md)
# Least ratio of wave speeds, -, at which an elastic body is implicit: the step of the scene grows by up to
# that, which is to pay for the equations of the body's nodes. Soils differ by less, steel from soil by more.
STIFFER = 4.0


def particlesFor(scene, region, material):
    """The particle type that suits a body, and the reason, as text."""
    if isinstance(region, ParticleSet):
        options = {"splitAt": SPLIT} if material._core.yields else {}
        return classes["UGIMP"](**options), "particles were given"
    if not isinstance(region, Region):
        return classes["APDI"](), "a mesh was given"
    if isinstance(region, Layer):
        return (
            classes["UGIMP"](perCell=2, cut=True, outline=False, splitAt=SPLIT),
            "a layer on a terrain is cut to its surfaces",
        )
    if material._core.yields:
        return classes["UGIMP"](perCell=2, splitAt=SPLIT), "the material yields and may flow"
    size = tuple((np.array(scene._core.cell) / 2).tolist())
    return classes["APDI"](size=size), "the material is elastic; contact and bending need a surface"


def update(scene, isFinal=False):
    """Makes the choices again that depend on all bodies, before the first step.

    isFinal : whether all bodies are there; ValueError then where the groups of contact are not clear.
    """
    if scene.steps == 0:
        _chooseImplicit(scene)
        arrange(scene, isFinal)


def _chooseImplicit(scene):
    """Elastic bodies whose waves are much faster than those of all bodies that stay explicit."""
    bodies = [body for body in scene.bodies if body.count]
    free = [b for b in bodies if "implicit" in b._chosen and not b.material._core.yields]
    free.sort(key=lambda body: body.material.waveSpeed)
    fastest = max((b.material.waveSpeed for b in bodies if b not in free and not b.implicit), default=0.0)
    for body in free:
        speed = body.material.waveSpeed
        isImplicit = 0 < STIFFER * fastest <= speed
        fastest = fastest if isImplicit else speed
        than = "" if fastest == speed else f", {speed / fastest:.2g} times those of the bodies round it"
        _setImplicit(body, isImplicit, f"its waves run at {speed:.3g} m/s{than}")


def _setImplicit(body, isImplicit, reason):
    own = [body] if body.convertsTo is None else [body, body.scene[body.convertsTo]]
    for one in own:
        if one.implicit != isImplicit:
            one.implicit = isImplicit
        one._chosen["implicit"] = reason
