# SPDX-License-Identifier: GPL-2.0-or-later
"""Bending of a strip that is one or two cells thick, clamped at its foot, under a lateral body force.

Reference: the beam, w = g b L^4/(8 E I) with shear, times what a row of bilinear cells adds, which cannot
curve: with m cells across, n columns of particles in each and nu = 0 the bending stiffness is that of the
beam times k = 1 - 1/(n m)^2 + (1 - 1/n^2)/(2 m^2): sampling at the middles of the columns, and the shear of a
cell that bends (doc/theory/transfers.md). 1.125 for one cell and two columns, 1.406 for four.
Tolerance: 2.5 % of the deflection. Control: the beam itself is 11 to 29 % off.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

CELL, LENGTH, YOUNG = 0.25, 3.0, 1e5  # m, m, kPa
DEFLECTION = 1e-3  # over the length, of the beam


def deflection(columns, cells=1, scheme="MUSL"):
    """Deflection at rest near the top over that of the beam, -."""
    thickness = cells * CELL
    scene = mpm.Scene((0, -1), (2, LENGTH + 1), CELL, scheme=scheme, threads=1)
    steel = mpm.LinearElastic(density=1.0, young=YOUNG, poisson=0.0)
    region = box((0.75, -1), (0.75 + thickness, LENGTH))
    strip = scene.add("strip", region, steel, mpm.APDI(size=CELL / columns))
    rigidity = YOUNG * thickness**3 / 12
    force = DEFLECTION * 8 * rigidity / (thickness * LENGTH**3)  # m/s2
    clamp = mpm.Hold(box((0, -1), (2, 0)), velocity=(0, 0))
    scene.engines = chain(gravity=(force, 0), hold=clamp, damping=0.7)
    scene.dt = 0.5 * CELL / np.sqrt(YOUNG)
    start = strip.position.copy()
    top = start[:, 1] > LENGTH - 0.6 * CELL
    scene.run(until=3.0, progress=False)
    height = start[top, 1].mean() / LENGTH
    bent = force * thickness * LENGTH**4 / (24 * rigidity) * (height**4 - 4 * height**3 + 6 * height**2)
    sheared = force * LENGTH**2 * (height - height**2 / 2) / (5 / 6 * YOUNG / 2)
    return (strip.position[top, 0] - start[top, 0]).mean() / (bent + sheared)


def stiffness(columns, cells=1):
    return 1 - 1 / (columns * cells) ** 2 + (1 - 1 / columns**2) / (2 * cells**2)


@pytest.mark.parametrize("columns, cells", [(2, 1), (4, 1), (2, 2)])
@pytest.mark.verifies(
    "Bent strip of one or two cells: deflection",
    reference="stiffness of its cells, closed form",
    tolerance=0.025,
)
def test_a_thin_strip_is_as_stiff_as_its_cells(columns, cells, verified):
    found = deflection(columns, cells)
    verified(found, 1 / stiffness(columns, cells))
    assert cells > 1 or found < 0.9  # control: no beam, and the worse the more columns


def test_the_scheme_does_not_matter():
    assert deflection(2, scheme="USL") == pytest.approx(deflection(2), rel=0.02)
