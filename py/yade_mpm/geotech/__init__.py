# SPDX-License-Identifier: GPL-2.0-or-later
"""Geotechnics: ground, what is pressed into it, its surface and its safety.

addGround, TYPES                            ground of uGIMP, of APDI, or of both
addLayers                                   layers, laws and stress of a borehole's table
readProfile                                 strength, K0 or OCR over the depth from a CPT
flowRegion                                  where the soil of a coarse run has flowed
groundSurface, Surface                      heave, trough and cavity of the ground surface
readRecord, responseSpectrum                an earthquake as a motion; spectra of histories
quadrilaterals, ring, wedgedColumn          structured meshes
travel, movingAverage, atSteps, scatter     curves over the way of a driven body

Modules to import by name, which draw with matplotlib: `penetration`, `reference`, `stability`.
"""

from .borehole import addLayers
from .curves import atSteps, movingAverage, scatter, travel
from .ground import TYPES, addGround, flowRegion
from .meshes import quadrilaterals, ring, wedgedColumn
from .profile import readProfile
from .shaking import readRecord, responseSpectrum
from .surface import Surface, groundSurface
