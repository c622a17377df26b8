# SPDX-License-Identifier: GPL-2.0-or-later
"""D15: cantilever under sudden gravity (scripts/cantilever.py).

Set-up: 4 x 1 m, plane strain, E = 1e7 Pa, nu = 0.3, rho = 1050 kg/m3, g = 10 m/s2, neo-Hookean, clamped at
x = 0; APDI,
two domains per cell and direction, h = 1/8 (1/16 in the slow test).
Reference: tip at mid-height and centre of mass at t = 0.25 ... 1.5 s of a total-Lagrangian finite element
solution
(64 x 16 bilinear quadrilaterals).
Source: our finite element solution; Sadeghirad, Brannon & Burghardt 2011, Int. J. Numer. Meth. Eng. 86(12),
use the same
4 x 1 family.
Tolerance: 1.5 % of the largest deflection, 0.766 m.
"""

import numpy as np
import pytest
from asModules import script
from setups import elasticEnergy

TIMES = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5])
TIP = np.array([-0.380, -0.766, -0.395, -0.001, -0.366, -0.765])
CENTRE = np.array([-0.158, -0.319, -0.166, -0.001, -0.151, -0.318])
LARGEST = 0.766  # m
TOLERANCE = 0.015 * LARGEST


@pytest.fixture(scope="module")
def cantilever():
    return script("cantilever")


def largestMiss(cantilever, **arguments):
    """Largest difference from the reference, tip and centre of mass, m."""
    _, history = cantilever.run(progress=False, **arguments)
    return np.abs(history.at(TIMES) - np.stack([TIP, CENTRE], axis=1)).max(axis=0)


@pytest.mark.parametrize("cell", [0.125, pytest.param(0.0625, marks=pytest.mark.slow)])
@pytest.mark.verifies(
    "Cantilever under sudden gravity: deflection over the largest",
    reference="finite elements",
    tolerance=0.015,
)
def test_deflections_are_those_of_finite_elements(cantilever, cell, verified):
    verified(largestMiss(cantilever, cell=cell), 0, scale=LARGEST)


def test_stress_update_first_gives_the_same_deflections(cantilever):
    assert np.all(largestMiss(cantilever, cell=0.125, scheme="USF") <= TOLERANCE)


def test_energy_of_the_swing_is_kept(cantilever):
    """Gravity's work is what the beam holds as kinetic and elastic energy, within 2 % of its largest
    value."""
    scene, _ = cantilever.run(until=0.25, progress=False, cell=0.125)
    beam = scene["beam"]
    kinetic = 0.5 * (beam.mass * (beam.velocity**2).sum(axis=1)).sum()
    work = scene._core.energies["gravity"]
    fallen = beam.mass @ (beam.reference[:, 1] - beam.position[:, 1]) * 10
    assert work == pytest.approx(fallen, rel=0.01)
    assert kinetic + elasticEnergy(beam) == pytest.approx(work, rel=0.02)


def test_control_five_per_cent_more_gravity_misses_the_tolerance(cantilever):
    assert largestMiss(cantilever, cell=0.125, gravity=10.5)[0] > TOLERANCE
