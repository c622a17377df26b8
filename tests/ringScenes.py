# SPDX-License-Identifier: GPL-2.0-or-later
"""The elastic material and the types of particles in tests of axial symmetry."""

import pytest
import yade_mpm as mpm

DENSITY, YOUNG, POISSON = 2.0, 1e3, 0.25
TYPES = {
    "UGIMP": lambda h: mpm.UGIMP(perCell=2),
    "APDI": lambda h: mpm.APDI(size=h),
    "BSpline": lambda h: mpm.BSpline(perCell=2),
}
both = pytest.mark.parametrize("kind", TYPES)


def elastic():
    return mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON)
