# SPDX-License-Identifier: GPL-2.0-or-later
"""What a law has stored, and what it has dissipated.

Reference: the work of the stress, sum J sigma : de by the trapezoidal rule, in elastic strains of 1e-4 from
a stress; for Tresca in shear, su times the plastic strain. Tolerance: 1e-8 of the work, and 4e-4 of what is
stored at the start: hypoelastic laws have no potential, and miss it by twice the volumetric strain of 1.6e-4
(3.2e-4 found).
Control: the energy of the start.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import CAM_CLAY, workOf

START = -np.diag([60.0, 90.0, 75.0])
STRAIN = 1e-4 * np.array([[-2.0, 0.5, 0.3], [0.5, 1.0, -0.4], [0.3, -0.4, -0.6]])
LAWS = {
    "LinearElastic": (lambda: mpm.LinearElastic(density=1, lame=(9e3, 6e3)), START),
    "NeoHookean": (lambda: mpm.NeoHookean(density=1, lame=(9e3, 6e3)), None),
    "Tresca": (lambda: mpm.Tresca(density=1, lame=(9e3, 6e3), undrainedStrength=50), START),
    "MohrCoulomb": (
        lambda: mpm.MohrCoulomb(density=1, lame=(9e3, 6e3), cohesion=20, frictionAngle=0.5),
        START,
    ),
    "ModifiedCamClay": (lambda: mpm.ModifiedCamClay(density=1, preconsolidation=400, **CAM_CLAY), START),
}


@pytest.mark.parametrize("name", LAWS)
def test_elastic_work_is_stored(name):
    make, stress = LAWS[name]
    point = mpm.MaterialPoint(make(), stress)
    before = point.storedEnergy
    work = workOf(point, STRAIN, 200)
    J = np.linalg.det(point.deformationGradient)
    assert J * point.storedEnergy - before == pytest.approx(work, abs=1e-8 * work + 4e-4 * before)
    assert abs(point.storedEnergy - before) > 0.5 * abs(work)


def test_clay_dissipates_its_strength_times_the_plastic_shear():
    clay = mpm.Tresca(density=1, young=6e3, poisson=0.3, undrainedStrength=10)
    point = mpm.MaterialPoint(clay)
    work = workOf(point, np.diag([0.02, -0.02, 0.0]), 400)
    dissipated = work - point.storedEnergy
    assert dissipated == pytest.approx(10 * point.state["plasticShearStrain"], rel=1e-3)
