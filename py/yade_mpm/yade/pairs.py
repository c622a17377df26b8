# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction and adhesion of pairs of materials, of YADE and of the soil, by a rule as Ip2 functors are."""

import math

import numpy as np

from ..base.wording import shown
from ..geometry.numbers import isNumber

NO_LIMIT = 1e30  # coefficient of friction of a soil that has none of its own


def smallerFriction(ofBody, ofSoil):
    """Coefficient of Ip2_FrictMat_FrictMat_FrictPhys: tangent of the smaller `frictionAngle`; a body without
    the attribute is smooth, a soil without it sets no limit."""
    angle = getattr(ofBody, "frictionAngle", 0.0)
    return min(float(np.tan(angle)), limitOf(ofSoil))


def limitOf(soil):
    """Coefficient of friction that the material of a soil allows."""
    angle = getattr(soil, "frictionAngle", None)
    if angle is None:
        return NO_LIMIT
    if not isNumber(angle):
        raise ValueError(
            f"{type(soil).__name__}: frictionAngle varies in space, friction against bodies is one number "
            "a pair; give it: friction=..."
        )
    return math.tan(angle)


def materialOf(omega, body):
    """Material of a body of YADE; of a clump that of its first member."""
    return omega.bodies[min(body.shape.members.keys())].material if body.isClump else body.material


class Laws:
    """Friction (-) and adhesion (kPa) of bodies of YADE against the soil: numbers, or functions of the two
    materials; None: friction by `smallerFriction`.

    Raises TypeError and ValueError for others.
    """

    def __init__(self, friction, adhesion):
        _check("friction", "-", friction)
        _check("adhesion", "kPa", adhesion)
        self._friction, self._adhesion = friction, adhesion

    def noted(self):
        """Dict of what can be saved."""
        numbers = {"friction": self._friction, "adhesion": self._adhesion}
        return {name: law for name, law in numbers.items() if not callable(law)}

    def ofBody(self, material, friction=None):
        """Dict of friction and adhesion of a body by itself, as far as no rule for pairs gives them.

        material : of the body. friction : of this body alone; None: as for the others.
        """
        _check("friction", "-", friction)
        friction = self._friction if friction is None else friction
        if friction is None or callable(friction):
            friction = smallerFriction(material, None)
        return {"friction": friction, "adhesion": 0.0 if callable(self._adhesion) else self._adhesion}

    def pairUp(self, contact, materials, soils):
        """Tells a contact what holds for pairs.

        contact : `RigidContact`. materials : dict of those of the bodies of YADE by the number of the rigid
        body. soils : list of the materials of the scene.
        """
        if self._friction is None and len(contact.soilFriction) == 0:
            contact._core.set("soilFriction", [limitOf(soil) for soil in soils])
        if not (callable(self._friction) or callable(self._adhesion)):
            return
        friction = smallerFriction if self._friction is None else self._friction
        contact.setPairs(
            [
                (
                    k,
                    s,
                    _number("friction", friction, own, soil),
                    _number("adhesion", self._adhesion, own, soil),
                )
                for k, own in materials.items()
                for s, soil in enumerate(soils)
            ]
        )


def _check(name, unit, given):
    if given is None or callable(given):
        return
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise TypeError(
            f"yade.Bodies: {name} = {shown(given)}; give a number ({unit}), or a function of the materials "
            "of body and soil"
        )
    if not 0 <= given < math.inf:
        raise ValueError(
            f"yade.Bodies: {name} = {shown(given)} is not allowed; give zero or a positive number"
        )


def _number(name, law, ofBody, ofSoil):
    value = law(ofBody, ofSoil) if callable(law) else law
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < math.inf:
        raise ValueError(
            f"yade.Bodies: the rule for {name} has returned {shown(value)} for {shown(ofBody)} and "
            f"{shown(ofSoil)}; it has to return zero or a positive number"
        )
    return float(value)
