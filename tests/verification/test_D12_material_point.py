# SPDX-License-Identifier: GPL-2.0-or-later
"""D12 objective rates, and D10 Mohr-Coulomb strengths, on single points through the public MaterialPoint.

D12 set-up: elastic simple shear to gamma = 1 and 2 at constant volume; a stressed point turned by 360
degrees in 1000
steps. Reference, in units of mu: logarithmic law tau_12 = 4 asinh(gamma/2)/sqrt(4 + gamma^2): 0.86082 and
1.24645; rate
of Jaumann (the elastic law of the soil) sigma_12 = sin(gamma): 0.84147 and 0.90930, sigma_11 = 1 -
cos(gamma).
Tolerances: shear 1e-5; drift in the rotation 1e-4 (Hughes-Winget) and 1e-12 (logarithmic), relative.

D10 set-up: c = 8.5 kPa, phi = 30 degrees, psi = 10 degrees; triaxial tests at constant lateral stress.
Reference: K_p = 3,
axial strengths 59.4449, 179.4449, 329.4449 kPa at 10, 50, 100 kPa; uniaxial compression 29.4449, tension
9.8150,
isotropic apex 14.7224 kPa; dilatancy in triaxial compression, beta = 0.057594: sin(psi_tc) = 3 sqrt3
beta/(2 + sqrt3
beta), 8.194 degrees. Tolerance: 1e-6 relative (of the closed form; the printed figures are rounded).
Controls: the two laws exclude one another at gamma = 1; a law without rotation would miss sin(gamma); the
dilatancy of
another cone fit, and 1e-5 more cohesion, must be noticed.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import softSoil

COHESION, PHI, PSI = 8.5, np.radians(30), np.radians(10)


def elastic():
    return mpm.LinearElastic(density=1.53, young=16408.4, poisson=0.3002)


def soil(cohesion=COHESION, **attributes):
    given = dict(density=1.53, young=16408.4, poisson=0.3002, frictionAngle=PHI, dilatancyAngle=PSI)
    return softSoil(cohesion, **given, **attributes)


def strong():
    """The soil, too strong to yield."""
    return soil(cohesion=1e9)


# --- D12
# -----------------------------------------------------------------------------------------------------
def simpleShear(material, gamma, steps=2000):
    """Cauchy stress over mu after a simple shear at constant volume."""
    point = mpm.MaterialPoint(material)
    L = np.zeros((3, 3))
    L[0, 1] = gamma
    for _ in range(steps):
        stress = point.gradient(L, 1 / steps)
    return stress / material.lameConstants[1]


@pytest.mark.parametrize("gamma, shear", [(1.0, 0.86082), (2.0, 1.24645)])
@pytest.mark.verifies(
    "Elastic simple shear to 2, logarithmic law: stress", reference="closed form", tolerance=1e-10
)
def test_simple_shear_of_the_logarithmic_law(gamma, shear, verified):
    stress = simpleShear(elastic(), gamma)
    verified(stress[0, 1], 4 * np.arcsinh(gamma / 2) / np.sqrt(4 + gamma**2))
    assert stress[0, 1] == pytest.approx(shear, abs=1e-5)
    assert stress[0, 1] != pytest.approx(np.sin(gamma), abs=1e-2)


@pytest.mark.parametrize("gamma, shear", [(1.0, 0.84147), (2.0, 0.90930)])
@pytest.mark.verifies(
    "Elastic simple shear to 2, Jaumann rate: stress", reference="closed form", tolerance=1e-06
)
def test_simple_shear_of_the_jaumann_rate(gamma, shear, verified):
    stress = simpleShear(strong(), gamma)
    verified(stress[0, 1], np.sin(gamma))
    assert stress[0, 1] == pytest.approx(shear, abs=1e-5)
    assert stress[0, 0] == pytest.approx(1 - np.cos(gamma), abs=1e-5)
    assert stress[0, 1] != pytest.approx(gamma, abs=1e-2)  # without rotation


INITIAL = np.array([[-40.0, 12.0, 5.0], [12.0, -90.0, -7.0], [5.0, -7.0, -55.0]])


def turned(material, axis):
    """Stress after a full turn in 1000 steps, each of them an exact rotation."""
    point = mpm.MaterialPoint(material, stress=INITIAL)
    angle = 2 * np.pi / 1000
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    turn = np.zeros(
        (3, 3)
    )  # R - I; cos - 1 by the half angle, because a thousand roundings of the cosine add up
    turn[i, i] = turn[j, j] = -2 * np.sin(angle / 2) ** 2
    turn[i, j], turn[j, i] = -np.sin(angle), np.sin(angle)
    quarter = None
    for n in range(1000):
        point.gradient(turn, 1.0)
        quarter = point.stress if n == 249 else quarter
    return quarter, point.stress


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("material, tolerance", [(elastic, 1e-12), (strong, 1e-4)])
@pytest.mark.verifies(
    "Stressed point turned by 360 degrees: stress", reference="that of the start", tolerance=0.0001
)
def test_a_full_turn_brings_the_stress_back(material, tolerance, axis, verified):
    quarter, full = turned(material(), axis)
    scale = abs(INITIAL).max()
    verified(full, INITIAL, scale=scale, within=tolerance)
    assert abs(quarter - INITIAL).max() > 0.1 * scale  # control: it did turn
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    assert quarter[i, i] == pytest.approx(INITIAL[j, j], abs=tolerance * scale)


def test_control_a_stretch_of_a_millionth_per_step_is_noticed():
    point = mpm.MaterialPoint(elastic(), stress=INITIAL)
    for _ in range(1000):
        point.gradient(1e-6 * np.eye(3), 1.0)
    assert abs(point.stress - INITIAL).max() > 1e-4 * abs(INITIAL).max()


# --- D10
# -----------------------------------------------------------------------------------------------------
def triaxial(lateral, direction, material=None, steps=200, size=1e-4):
    """Axial stress and last increments (axial, volumetric) of a test at constant lateral stress, kPa,
    tension positive.

    The lateral increment is found by secants on copies of the point.
    """
    point = mpm.MaterialPoint(material or soil(), stress=lateral * np.eye(3))
    guess = -0.3 * direction * size

    def tryOut(radial):
        copy = point.copy()
        return copy.strain(np.diag([radial, radial, direction * size]))[0, 0] - lateral

    for _ in range(steps):
        a, b = guess, guess + 0.1 * size
        fa, fb = tryOut(a), tryOut(b)
        for _ in range(30):
            if abs(fb) < 1e-11 * (1 + abs(lateral)) or fa == fb:
                break
            a, b, fa = b, b - fb * (b - a) / (fb - fa), fb
            fb = tryOut(b)
        guess = b
        stress = point.strain(np.diag([guess, guess, direction * size]))
    assert abs(stress[0, 0] - lateral) < 1e-8 * (1 + abs(lateral))
    return stress[2, 2], direction * size, direction * size + 2 * guess


KP = 3.0


@pytest.mark.parametrize(
    "confinement, printed", [(0.0, 29.4449), (10.0, 59.4449), (50.0, 179.4449), (100.0, 329.4449)]
)
@pytest.mark.verifies("Soil, triaxial compression: strength", reference="Mohr-Coulomb", tolerance=1e-06)
def test_strength_in_triaxial_compression(confinement, printed, verified):
    axial, _, _ = triaxial(-confinement, -1)
    strength = KP * confinement + 2 * COHESION * np.sqrt(KP)
    verified(-axial, strength)
    assert -axial == pytest.approx(printed, abs=1e-4)


@pytest.mark.verifies("Soil, uniaxial tension: strength", reference="Mohr-Coulomb", tolerance=1e-06)
def test_strength_in_uniaxial_tension(verified):
    axial, _, _ = triaxial(0.0, +1)
    verified(axial, 2 * COHESION / np.sqrt(KP))
    assert axial == pytest.approx(9.8150, abs=1e-4)


def test_isotropic_extension_ends_at_the_apex():
    point = mpm.MaterialPoint(soil())
    for _ in range(100):
        stress = point.strain(1e-4 * np.eye(3))
    assert stress == pytest.approx(COHESION / np.tan(PHI) * np.eye(3), rel=1e-6, abs=1e-9)
    assert stress[0, 0] == pytest.approx(14.7224, abs=1e-4)


def dilatancyAngle(**attributes):
    """Angle from the last, purely plastic increments of a triaxial compression, degrees."""
    _, axial, volumetric = triaxial(-50.0, -1, soil(**attributes), steps=400)
    return np.degrees(np.arcsin(volumetric / (volumetric - 2 * axial)))


@pytest.mark.verifies(
    "Soil, triaxial compression: dilatancy angle", reference="closed form", tolerance=1.2e-4
)
def test_dilatancy_in_triaxial_compression(verified):
    beta = 0.057594
    expected = np.degrees(np.arcsin(3 * np.sqrt(3) * beta / (2 + np.sqrt(3) * beta)))
    assert expected == pytest.approx(8.194, abs=1e-3)
    verified(dilatancyAngle(), expected)


def test_control_another_cone_dilates_differently():
    assert dilatancyAngle(coneFit="triaxialCompression") == pytest.approx(10.0, abs=1e-3)


def test_control_a_little_more_cohesion_is_noticed():
    axial, _, _ = triaxial(-50.0, -1, soil(cohesion=COHESION * (1 + 1e-5)))
    assert -axial != pytest.approx(KP * 50 + 2 * COHESION * np.sqrt(KP), rel=1e-6)
