# SPDX-License-Identifier: GPL-2.0-or-later
"""The dilatancy of MohrCoulombDruckerPrager ends exactly at a plastic volumetric strain, or at a critical
void ratio.

Set-up: single points of c-phi soil, phi = 30 and psi = 10 degrees: triaxial and plane-strain compression at
constant lateral
stress, simple shear at constant normal stress, isotropic extension; a scene in which a domain is converted.
Reference, closed form:
- triaxial compression along the potential q + beta I1: eps_v = dsigma/(3K) + min(3 beta/(1/sqrt3 - beta)
  (eps_a - dsigma/E), limit),
  with the strength dsigma = (K_p - 1) sigma_3 + 2 c sqrt(K_p);
- plane strain at constant stress: d(eps_v)/d(eps_1 - eps_3) = sin(psi), simple shear: d(eps_v)/d(gamma) =
  tan(psi);
- a step across the limit is the step up to the limit followed by one without dilatancy.
Tolerance: 1e-12 of the strain where it is exact; 2 % for the slope in simple shear, whose stresses turn.
Controls: without the limit the volume goes on growing; a limit that is 1e-9 higher is noticed.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, restarted, softSoil

C, PHI, PSI = 8.5, np.radians(30), np.radians(10)
LAMBDA, MU = 9.48e3, 6.31e3
BULK, YOUNG = LAMBDA + 2 / 3 * MU, MU * (3 * LAMBDA + 2 * MU) / (LAMBDA + MU)
BETA = np.tan(PSI) / np.sqrt(9 + 12 * np.tan(PSI) ** 2)
LIMIT, LATERAL = 0.004, -50.0
I = np.eye(3)


def soil(cohesion=C, **attributes):
    given = dict(density=1.53, lame=(LAMBDA, MU), frictionAngle=PHI, dilatancyAngle=PSI)
    return softSoil(cohesion, **given, **attributes)


def plasticVolume(point):
    return point.state["plasticVolumetricStrain"]


def heldStep(point, gradient, free, stress, guess):
    """One step in which the gradient g + x free keeps <free, sigma>/<free, free> at `stress`; returns x. By
    secants on copies."""

    def miss(x):
        return (point.copy().gradient(gradient + x * free, 1.0) * free).sum() / (free * free).sum() - stress

    size = np.abs(gradient).max()
    a, b = guess, guess + 0.1 * size
    fa, fb = miss(a), miss(b)
    for _ in range(40):
        if abs(fb) < 1e-11 or fa == fb:
            break
        a, b, fa = b, b - fb * (b - a) / (fb - fa), fb
        fb = miss(b)
    point.gradient(gradient + b * free, 1.0)
    return b


def compressed(material, free, steps, size=2e-5):
    """Axial compression at constant stress along `free`: axial and volumetric logarithmic strain after each
    step, and the point."""
    point, x, axial, volume = mpm.MaterialPoint(material, stress=LATERAL * I), 0.3 * size, [], []
    for n in range(steps):
        x = heldStep(point, np.diag([0, 0, -size]), free, LATERAL, x)
        axial.append((n + 1) * -np.log1p(-size))
        volume.append(np.log(np.linalg.det(point.deformationGradient)))
    return np.array(axial), np.array(volume), point


def triaxialVolume(axial, limit):
    """Closed form of the volumetric strain, compression of the axis positive."""
    kp = (1 + np.sin(PHI)) / (1 - np.sin(PHI))
    strength = (kp - 1) * -LATERAL + 2 * C * np.sqrt(kp)
    atYield = strength / YOUNG
    plastic = 3 * BETA / (1 / np.sqrt(3) - BETA) * np.maximum(axial - atYield, 0)
    return -np.minimum(axial / atYield, 1) * strength / (3 * BULK) + np.minimum(plastic, limit)


RADIAL = np.diag([1.0, 1.0, 0.0])


@pytest.mark.parametrize("limit", [0.0, LIMIT, None])
def test_volume_in_triaxial_compression_grows_to_the_limit_and_no_further(limit):
    axial, volume, point = compressed(soil(dilatancyLimit=limit), RADIAL, 1500)
    expected = triaxialVolume(axial, np.inf if limit is None else limit)
    # the elastic law sums 2 tanh(x/2) for x = ln(1 + g): 1e-10 of the strain with these steps
    assert np.abs(volume - expected).max() < 1e-9 * axial[-1]
    if limit is not None:
        assert abs(plasticVolume(point) - limit) < 1e-15
        assert np.ptp(volume[-300:]) < 1e-12
        assert np.abs(volume - triaxialVolume(axial, limit + 1e-9)).max() > 5e-10  # control
    else:
        assert np.ptp(volume[-300:]) > 1e-3  # control


def test_volume_in_plane_strain_grows_with_the_sine_of_the_dilatancy_angle():
    axial, volume, point = compressed(soil(dilatancyLimit=LIMIT), np.diag([1.0, 0.0, 0.0]), 1500, size=1e-4)
    _, freely, _ = compressed(soil(), np.diag([1.0, 0.0, 0.0]), 500, size=1e-4)
    slope = np.diff(freely)[-1] / np.diff(axial)[0]  # (eps_1 + eps_3)/-eps_3, once the stress is steady
    assert slope / (2 + slope) == pytest.approx(np.sin(PSI), rel=1e-4)
    assert abs(plasticVolume(point) - LIMIT) < 1e-15 and np.ptp(volume[-100:]) < 1e-12
    assert np.diff(freely)[-1] > 1e-5  # control


def sheared(material, steps=400, size=1e-3):
    """Simple shear at constant normal stress: growth of the volumetric strain per shear strain in each
    step, and the point."""
    point, x, volume = mpm.MaterialPoint(material, stress=LATERAL * I), 0.0, [0.0]
    for _ in range(steps):
        g = np.zeros((3, 3))
        g[0, 1] = size
        x = heldStep(point, g, np.diag([0.0, 1.0, 0.0]), LATERAL, x)
        volume.append(np.log(np.linalg.det(point.deformationGradient)))
    return np.diff(volume) / size, point


def test_volume_in_simple_shear_grows_with_the_tangent_of_the_dilatancy_angle():
    slope, point = sheared(soil(dilatancyLimit=0.02))
    assert slope[90] == pytest.approx(np.tan(PSI), rel=1e-3)  # the limit comes in step 119
    assert abs(plasticVolume(point) - 0.02) < 1e-15 and np.abs(slope[-50:]).max() < 1e-9
    freely, _ = sheared(soil())
    assert freely[-1] == pytest.approx(np.tan(PSI), rel=1e-3)  # control


# --- the step that reaches the limit
# ---------------------------------------------------------------------------
STEP = np.diag([0.004, 0.003, -0.012]) + 0.002 * (np.eye(3, k=1) + np.eye(3, k=-1))
BEFORE = np.diag([-50.0, -60.0, -120.0])


def test_the_step_that_reaches_the_limit_ends_there():
    """And is the step up to the limit, taken with that part of the gradient, followed by one without
    dilatancy."""
    whole = mpm.MaterialPoint(soil(), stress=BEFORE)
    whole.strain(STEP)
    full = plasticVolume(whole)
    assert full > 1e-3
    for limit in (0.0, 0.3 * full, 0.999 * full):
        point = mpm.MaterialPoint(soil(dilatancyLimit=limit), stress=BEFORE)
        point.strain(STEP)
        assert abs(plasticVolume(point) - limit) < 1e-17
    free = mpm.MaterialPoint(soil(dilatancyLimit=1.001 * full), stress=BEFORE)
    free.strain(STEP)
    assert np.abs(free.stress - whole.stress).max() < 1e-11
    assert plasticVolume(free) == pytest.approx(full, rel=1e-12)


def test_a_soil_at_its_limit_is_one_without_dilatancy():
    stress = []
    for material in (
        soil(dilatancyLimit=0.0),
        mpm.MohrCoulombDruckerPrager(density=1.53, lame=(LAMBDA, MU), cohesion=C, frictionAngle=PHI),
    ):
        point = mpm.MaterialPoint(material, stress=BEFORE)
        for _ in range(5):
            point.strain(STEP)
        stress.append(point.stress)
        assert plasticVolume(point) == 0
    assert np.abs(stress[0] - stress[1]).max() < 1e-11
    control = mpm.MaterialPoint(soil(), stress=BEFORE)
    assert (
        np.abs(
            control.strain(STEP) - mpm.MaterialPoint(soil(dilatancyLimit=0.0), stress=BEFORE).strain(STEP)
        ).max()
        > 1
    )


# --- void ratios
# -----------------------------------------------------------------------------------------------
def test_the_void_ratio_ends_at_the_critical_one():
    e0, critical = 0.60, 0.61
    _, _, point = compressed(soil(initialVoidRatio=e0, criticalVoidRatio=critical), RADIAL, 2200)
    assert (1 + e0) * np.exp(plasticVolume(point)) - 1 == pytest.approx(critical, abs=1e-15)
    material = soil(
        initialVoidRatio=e0, criticalVoidRatio=0.6001
    )  # may be changed on the way, as any attribute
    _, _, other = compressed(material, RADIAL, 1000)
    assert (1 + e0) * np.exp(plasticVolume(other)) - 1 == pytest.approx(0.6001, abs=1e-15)
    material.criticalVoidRatio = critical
    point = other.copy()
    for _ in range(200):
        point.strain(STEP / 10)
    assert (1 + e0) * np.exp(plasticVolume(point)) - 1 == pytest.approx(critical, abs=1e-15)


# --- opening
# ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "attributes, highest", [({}, C / np.tan(PHI)), ({"tensionCutOff": 5.0}, 5.0)], ids=["apex", "cut-off"]
)
def test_opening_is_not_held_back_but_counts(attributes, highest):
    point = mpm.MaterialPoint(soil(dilatancyLimit=LIMIT, **attributes))
    for _ in range(400):
        stress = point.strain(1e-5 * I)
    assert stress == pytest.approx(highest * I, rel=1e-12, abs=1e-9)
    assert plasticVolume(point) == pytest.approx(400 * 3e-5 - highest / BULK, rel=1e-9)
    assert plasticVolume(point) > LIMIT
    opened = plasticVolume(point)
    point.strain(
        -(100 + highest) / (3 * BULK) * I
    )  # back to -100 kPa, elastically: the opening is not taken back
    assert plasticVolume(point) == opened
    point.strain(STEP)
    assert plasticVolume(point) == opened and point.state["plasticShearStrain"] > 1e-3
    dense = mpm.MaterialPoint(soil(dilatancyLimit=2 * opened), stress=-100 * I)  # control: not opened
    dense.strain(STEP)
    assert plasticVolume(dense) > 1e-4


# --- in a scene
# ------------------------------------------------------------------------------------------------
def shearedBlock(limit):
    """A strong block, sheared until its middle is at the limit; a domain there is pulled out of shape and
    becomes particles.

    Returns the scene and the plastic volume of that domain just before.
    """
    scene = mpm.Scene((0, 0), (6, 3), 0.5, threads=1)
    body = scene.add(
        "soil",
        mpm.box((1, 0), (3, 2)),
        soil(cohesion=200, dilatancyLimit=limit),
        mpm.APDI(size=0.25, onDistortion="convert"),
        fbar=False,  # it exchanges elastic against plastic volume within a cell
    )
    top = mpm.Drive(body.above(1.7), velocity=(2.0, 0.0))
    scene.engines = chain(fixed=("bottom",), drive=top)
    scene.dt = 2e-4
    scene.run(steps=400, progress=False)
    middle = np.argmin(np.linalg.norm(body.position - (2.1, 1.1), axis=1))
    corner, dilated = body.cells[middle], float(body.plasticVolumetricStrain[middle])
    body.vertices[corner[2]] += 0.5 * (body.vertices[corner[0]] - body.vertices[corner[2]])
    scene.run(steps=1, progress=False)
    return scene, dilated


def test_the_plastic_volume_goes_through_a_conversion_and_on_from_a_checkpoint():
    scene, dilated = shearedBlock(LIMIT)
    assert abs(dilated - LIMIT) < 1e-15
    after = scene["soil (converted)"].plasticVolumetricStrain
    assert scene["soil"].converted == 4, (
        "with its neighbours at the pulled vertex, whose edges grew by more than 15 %"
    )
    assert len(after) >= 4 and (np.abs(after - LIMIT) < 1e-15).all()
    loaded = restarted(scene, 50)
    for body in scene.bodies:
        assert loaded[body.name].material.dilatancyLimit == LIMIT
        assert np.array_equal(loaded[body.name].plasticVolumetricStrain, body.plasticVolumetricStrain)
    _, freely = shearedBlock(None)
    assert freely > 1.5 * LIMIT  # control
