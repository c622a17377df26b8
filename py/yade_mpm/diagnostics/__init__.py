# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers that tell how a run is doing, each a function of a scene.

Masses, forces and energies are per metre of thickness in plane strain, and of the whole circumference in
axisymmetric scenes.
"""

from .balance import (
    contactEnergy,
    dampedEnergy,
    energyError,
    externalWork,
    freeKineticEnergy,
    implicitEnergy,
    internalWork,
    kineticEnergy,
    kineticRatio,
    mass,
    momentum,
    storedEnergy,
    unseenEnergy,
    workDone,
)
from .drainage import drainage
from .facePressure import FacePressure, facePressure, pressureImpulse
from .forces import checkerboard, meanStressAlong, sectionForce, stripes, unbalancedRatio
from .piezometer import piezometer
from .sections import SectionForces, bendingMoment, normalForce, sectionForces, shearForce
from .shapes import (
    convertedCount,
    cornerJacobians,
    distortedCount,
    hourglassAmplitude,
    hourglassEnergy,
    invertedCount,
    minJacobian,
    volumeRatio,
)

__all__ = [
    "mass",
    "drainage",
    "piezometer",
    "volumeRatio",
    "momentum",
    "kineticEnergy",
    "freeKineticEnergy",
    "unseenEnergy",
    "internalWork",
    "storedEnergy",
    "externalWork",
    "dampedEnergy",
    "contactEnergy",
    "implicitEnergy",
    "energyError",
    "workDone",
    "kineticRatio",
    "minJacobian",
    "hourglassAmplitude",
    "hourglassEnergy",
    "distortedCount",
    "invertedCount",
    "convertedCount",
    "cornerJacobians",
    "meanStressAlong",
    "checkerboard",
    "unbalancedRatio",
    "sectionForce",
    "sectionForces",
    "bendingMoment",
    "shearForce",
    "normalForce",
    "facePressure",
    "pressureImpulse",
]
