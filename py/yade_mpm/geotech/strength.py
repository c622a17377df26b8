# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength of the soils of a scene, divided by a factor."""

import numpy as np

from ..base.kinds import POSITIVE, SCENE, takes

# kPa; parameters of soil laws by these names, a plugin's, too. Residual values may not be above the others.
STRENGTHS = (
    "residualCohesion",
    "cohesion",
    "undrainedStrength",
    "yieldStress",
    "tensileStrength",
    "tensionCutOff",
)
ANGLES = {  # rad: friction, and the dilatancy that may not be above it
    "residualFrictionAngle": "residualDilatancyAngle",
    "frictionAngle": "dilatancyAngle",
}


@takes(scene=SCENE, factor=POSITIVE)
def divideStrength(scene, factor):
    """Divides cohesion, undrained and tensile strength and tan(phi) of all soils of a scene by a factor.

    Parameters
    ----------
    scene : the scene; the materials of its bodies change. Where psi would be above phi it becomes phi.
    factor : -, above 1 the soil gets weaker.

    Raises ValueError where no material has a strength.
    """
    materials = {id(body.material): body.material for body in scene.bodies}.values()
    owners = [*((m, _ofAll(m)) for m in materials), *((b, _ofEach(b)) for b in scene.bodies)]
    found = [_divide(owner, values, factor) for owner, values in owners]
    if not any(found):
        names = ", ".join(sorted({type(body.material).__name__ for body in scene.bodies}))
        raise ValueError(
            f"divideStrength: no material has a strength to divide (there is {names or 'no body'}); give "
            f"soil with {', '.join((*STRENGTHS, *ANGLES))}"
        )


def _ofAll(material):
    """Parameters of a material that are one number for all particles."""
    return {n: v for n, v in material.attributes().items() if n not in _stateNames(material)}


def _ofEach(body):
    """Fields of a body that are parameters of its material, of each particle."""
    return {n: getattr(body, n) for n in _stateNames(body.material) if n in body.material.attributes()}


def _stateNames(material):
    return [variable[0] for variable in material._core.stateVariables()]


def _divide(owner, values, factor):
    """Divides what an owner has a number or an array of; returns whether there was any."""
    new = {name: values[name] / factor for name in STRENGTHS if _isNumeric(values.get(name))}
    for friction, dilatancy in ANGLES.items():
        if _isNumeric(values.get(friction)):
            phi = np.arctan(np.tan(values[friction]) / factor)
            if _isNumeric(values.get(dilatancy)):
                new[dilatancy] = np.minimum(values[dilatancy], phi)
            new[friction] = phi  # behind psi, which may not be above it
    for name, value in new.items():
        setattr(owner, name, value if np.ndim(value) else float(value))
    return bool(new)


def _isNumeric(value):
    return isinstance(value, (int, float, np.ndarray)) and not isinstance(value, bool)
