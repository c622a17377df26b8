# SPDX-License-Identifier: GPL-2.0-or-later
"""MohrCoulomb, Tresca and ModifiedCamClay at a point, against the equations that define them.

Set-up: a single point, thousands of random trial stresses for the returns, paths of triaxial tests for the
clay.
Reference: of a return, the conditions that make it the only one: the stress is on the surface or inside, and
the plastic strain is a sum of the gradients of the planes that meet there with factors that are not negative
(NNLS). Of Cam-Clay: lines of compression and swelling, the undrained strength (M/2) p (R/2)^((lambda -
kappa)/lambda), the critical state. Of Tresca: the law of softening and rate in its own words.
Tolerance: returns 1e-10 of the stress; Cam-Clay 0.1 % (200 to 1000 steps of a path).
Controls: planes that do not meet there, associated for non-associated flow, and a strength 1 % off are told
apart.
"""

import numpy as np
import pytest
import scipy.optimize
import yade_mpm as mpm

K, G = 12e3, 7e3  # kPa
ELASTIC = {"density": 1.8, "lame": (K - 2 * G / 3, G)}
PLANES = [(i, j) for i in range(3) for j in range(3) if i != j]  # of major and minor principal stress


def gradients(angle):
    """Gradients of the six planes of f or g over the principal stresses, (6, 3)."""
    s, all = np.sin(angle), np.zeros((6, 3))
    for row, (i, j) in enumerate(PLANES):
        all[row, i], all[row, j] = 1 + s, -(1 - s)
    return all


def residual(trial, stress, c, phi, psi):
    """Of a return in principal axes: (largest yield function, what no sum of gradients explains of the
    plastic strain), both over the stress."""
    f = gradients(phi) @ stress - 2 * c * np.cos(phi)
    size = np.abs(trial).max()
    lost = trial - stress
    plastic = (lost - lost.mean()) / (2 * G) + lost.mean() / (3 * K)
    active = np.abs(f) < 1e-9 * size
    left = (
        scipy.optimize.nnls(gradients(psi)[active].T, plastic)[1] if active.any() else np.linalg.norm(plastic)
    )
    return f.max() / size, left * 2 * G / size


def returned(material, trial):
    """Principal stress of a point whose trial is `trial`, in the same axes and order."""
    rng = np.random.default_rng(1)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    stress = axes * trial @ axes.T
    point = mpm.MaterialPoint(material, (stress + stress.T) / 2)
    after = axes.T @ point.gradient(np.zeros((3, 3)), 1.0) @ axes
    assert np.abs(after - np.diag(np.diag(after))).max() < 1e-10 * np.abs(trial).max()
    return np.diag(after)


@pytest.mark.parametrize("phi, psi", [(0.6, 0.6), (0.6, 0.1), (0.5, 0.0), (0.0, 0.0)])
def testMohrCoulombReturnsAlongItsPotential(phi, psi):
    rng, c = np.random.default_rng(2), 10.0
    material = mpm.MohrCoulomb(**ELASTIC, cohesion=c, frictionAngle=phi, dilatancyAngle=psi)
    wrong, apexes = 0, 0
    for _ in range(1000):
        trial = rng.normal(size=3) * 10 ** rng.uniform(0, 2) + rng.uniform(-60, 30)
        stress = returned(material, trial)
        beyond, unexplained = residual(trial, stress, c, phi, psi)
        apex = c / np.tan(phi) if phi > 0 else np.inf
        atApex = np.abs(stress - apex).max() < 1e-9 * apex if phi > 0 else False
        apexes += atApex
        # psi = 0 has no flow that changes the volume: the apex takes what is beyond it all the same.
        assert beyond < 1e-10
        assert unexplained < 1e-10 or (atApex and psi < phi)
        wrong += residual(trial, stress, c, phi, psi + 0.2)[1] > 1e-6
    assert wrong > 300 and (apexes > 20 or phi == 0)


def testTrescaReturnsAlongItsSurface():
    rng, su = np.random.default_rng(3), 12.0
    material = mpm.Tresca(**ELASTIC, undrainedStrength=su)
    same = mpm.MohrCoulomb(**ELASTIC, cohesion=su, frictionAngle=0)
    for _ in range(1000):
        trial = rng.normal(size=3) * 10 ** rng.uniform(0, 2) + rng.uniform(-60, 60)
        stress = returned(material, trial)
        assert max(residual(trial, stress, su, 0, 0)) < 1e-10
        np.testing.assert_allclose(stress, returned(same, trial), atol=1e-10 * np.abs(trial).max())
        assert stress.mean() == pytest.approx(trial.mean(), abs=1e-12 * np.abs(trial).max())


def testTensileStrengthBoundsEveryPrincipalStress():
    rng = np.random.default_rng(4)
    material = mpm.MohrCoulomb(**ELASTIC, cohesion=20, frictionAngle=0.4, tensileStrength=3)
    without = mpm.MohrCoulomb(**ELASTIC, cohesion=20, frictionAngle=0.4)
    cut = 0
    for _ in range(300):
        trial = rng.normal(size=3) * 30 + rng.uniform(-40, 20)
        stress = returned(material, trial)
        assert stress.max() <= 3 + 1e-10
        assert residual(trial, stress, 20, 0.4, 0)[0] < 1e-10
        cut += returned(without, trial).max() > 3
    assert cut > 50


@pytest.mark.parametrize("lode, ratio", [(0, 1.0), (15, 0.928), (30, 1.0), (45, 0.928), (60, 1.0)])
def testTheTwoSoilsDissipateAlikeInTriaxialStatesAndPureShear(lode, ratio):
    """Between them the potential of MohrCoulombDruckerPrager goes through less work: cos 30/(cos a cos(30 -
    a))."""
    step = np.diag(np.cos(np.radians(lode + np.array([0, -120, 120]))))
    work = []
    for law in (mpm.MohrCoulombDruckerPrager, mpm.MohrCoulomb):
        point = mpm.MaterialPoint(law(**ELASTIC, cohesion=10, frictionAngle=0.0))
        for _ in range(100):
            stress = point.strain(1e-4 * step)
        work.append((stress * step).sum())
    assert work[0] / work[1] == pytest.approx(ratio, abs=1e-3)
    assert work[1] == pytest.approx(10 * np.abs(step).sum(), rel=1e-9)  # of Tresca


def sheared(material, xi, step=1e-4, dt=1.0):
    """Half the difference of principal stresses after shear in the plane by xi, without change of volume."""
    point = mpm.MaterialPoint(material)
    for _ in range(int(round(xi / step))):
        stress = point.gradient(np.array([[0, step / dt, 0], [0, 0, 0], [0, 0, 0]]), dt)
    ends = np.linalg.eigvalsh(stress)
    return (ends[2] - ends[0]) / 2, point.state["plasticShearStrain"]


def testClaySoftensAndHardensWithTheRateAsItsLawSays():
    given = {**ELASTIC, "undrainedStrength": 10.0, "remouldedRatio": 0.25, "softeningStrain": 0.5}
    su, xi = sheared(mpm.Tresca(**given), 0.4)
    assert su == pytest.approx(10 * (0.25 + 0.75 * np.exp(-3 * xi / 0.5)), rel=1e-3)
    assert su != pytest.approx(10 * (0.25 + 0.75 * np.exp(-3 * xi / 0.505)), rel=1e-3)
    given = {**ELASTIC, "undrainedStrength": 10.0, "rateFactor": 0.1, "referenceRate": 1e-6}
    for dt, gain in ((1e2, 1.0), (1.0, 1.2), (0.01, 1.4)):  # rates of 1e-6, 1e-4, 1e-2 1/s
        assert sheared(mpm.Tresca(**given), 0.02, dt=dt)[0] == pytest.approx(10 * gain, rel=1e-6)


@pytest.mark.parametrize("law", ["MohrCoulomb", "MohrCoulombDruckerPrager"])
def testSoilSoftensToItsResidualStrength(law):
    given = {"cohesion": 10, "frictionAngle": 0.0, "residualCohesion": 4, "softeningStrain": 0.1}
    su, xi = sheared(getattr(mpm, law)(**ELASTIC, **given), 0.05)
    assert su == pytest.approx(4 + 6 * np.exp(-3 * xi / 0.1), rel=2e-3)
    assert sheared(getattr(mpm, law)(**ELASTIC, **given), 0.5)[0] == pytest.approx(4, rel=1e-3)


# --- Modified Cam-Clay
LAMBDA, KAPPA, E0, PHI = 0.2, 0.04, 1.0, np.radians(25)
M = 6 * np.sin(PHI) / (3 - np.sin(PHI))
CLAY = {
    "density": 1.7,
    "compression": LAMBDA,
    "swelling": KAPPA,
    "frictionAngle": PHI,
    "initialVoidRatio": E0,
    "poisson": 0.2,
}


def clay(p, **pc):
    return mpm.MaterialPoint(mpm.ModifiedCamClay(**CLAY, **pc), -p * np.eye(3))


def pressure(stress):
    return -np.trace(stress) / 3


@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0, 10.0])
def testUndrainedStrengthOfCamClay(ratio):
    p0 = 100.0
    point = clay(p0, overconsolidationRatio=ratio)
    assert point.state["preconsolidation"] == pytest.approx(ratio * p0)
    for _ in range(1000):
        stress = point.strain(np.diag([1.0, 1.0, -2.0]) * 2.5e-4)
    q = stress[0, 0] - stress[2, 2]
    assert q / 2 == pytest.approx(M / 2 * p0 * (ratio / 2) ** ((LAMBDA - KAPPA) / LAMBDA), rel=1e-3)
    assert q == pytest.approx(M * pressure(stress), rel=1e-3)  # the critical state


def testTheUndrainedPathOfCamClay():
    """p0/p = (1 + (q/p/M)^2)^((lambda - kappa)/lambda) of normally consolidated clay."""
    law = mpm.ModifiedCamClay(**CLAY, overconsolidationRatio=1.0)
    path = mpm.elementTest.triaxial(law, pressure=100, strain=0.2, drained=False, steps=1000)
    power = (LAMBDA - KAPPA) / LAMBDA
    exact = 100 * (1 + (path.q / path.p / M) ** 2) ** -power
    assert np.abs(path.p / exact - 1).max() < 2e-3
    assert np.abs(path.p / (100 * (1 + (path.q / path.p / (1.01 * M)) ** 2) ** -power) - 1).max() > 2e-3
    assert path.p[-1] < 60


def testLinesOfCompressionAndSwelling():
    point = clay(50.0, preconsolidation=50.0)

    def slope(total, steps=400):
        before, e = pressure(point.stress), voidRatio(point)
        for _ in range(steps):
            point.strain(total / steps / 3 * np.eye(3))
        return -(voidRatio(point) - e) / np.log(pressure(point.stress) / before)

    assert slope(-0.1) == pytest.approx(LAMBDA, rel=2e-3)
    assert slope(0.02) == pytest.approx(KAPPA, rel=2e-3)
    assert slope(-0.015) == pytest.approx(KAPPA, rel=2e-3)  # back, elastic


def voidRatio(point):
    return (1 + E0) * np.linalg.det(point.deformationGradient) - 1


def testDrainedTriaxialEndsAtTheCriticalState():
    """Constant radial stress: q_f = 3 M p0/(3 - M) of normally consolidated clay."""
    p0 = 100.0
    point = clay(p0, overconsolidationRatio=1.0)
    axial = -2e-4

    def radialStress(radial):
        return point.copy().strain(np.diag([radial, radial, axial]))[0, 0] + p0

    for _ in range(4000):
        radial = scipy.optimize.brentq(radialStress, -3e-4, 3e-4, xtol=1e-12)
        stress = point.strain(np.diag([radial, radial, axial]))
    assert stress[0, 0] - stress[2, 2] == pytest.approx(3 * M * p0 / (3 - M), rel=2e-3)


def testCamClayBearsNoTensionAndPressureAgain():
    point = clay(20.0, overconsolidationRatio=2.0)
    for _ in range(200):
        stress = point.strain(1e-3 * np.eye(3))
        assert pressure(stress) >= -1e-12
    for _ in range(400):
        stress = point.strain(-1e-3 * np.eye(3))
    assert np.isfinite(stress).all() and pressure(stress) > 2


SAND = {"cohesion": 5, "frictionAngle": 0.5}


@pytest.mark.parametrize(
    "law, given, error",
    [
        ("Tresca", {}, "undrainedStrength is required"),
        ("Tresca", {"undrainedStrength": 5, "softeningStrain": 1}, "without remouldedRatio"),
        ("Tresca", {"undrainedStrength": 5, "rateFactor": 0.1}, "belong together"),
        ("Tresca", {"undrainedStrength": 5, "rigidity": 100}, "rigidity = 100 is given with lame"),
        ("Tresca", {"undrainedStrength": 5, "softeningLength": 0.1}, "without softeningStrain"),
        ("MohrCoulomb", {**SAND, "residualCohesion": 2}, "without softeningStrain"),
        ("MohrCoulomb", {**SAND, "residualCohesion": 9, "softeningStrain": 0.1}, "exceeds cohesion"),
        ("MohrCoulombDruckerPrager", {**SAND, "softeningStrain": 0.1}, "without a residual strength"),
    ],
)
def testWhatDoesNotFitIsRefused(law, given, error):
    with pytest.raises(ValueError, match=error):
        getattr(mpm, law)(**ELASTIC, **given)


def testTheWidthOfABandIsDeprecated():
    softens = dict(undrainedStrength=5, softeningStrain=1, remouldedRatio=0.3)
    with pytest.warns(DeprecationWarning, match="Tresca.bandWidth is deprecated.*give softeningLength"):
        clay = mpm.Tresca(**ELASTIC, **softens, bandWidth=0.1)
    with pytest.raises(ValueError, match="softeningLength = 0.2 m and bandWidth = 0.1 m are given together"):
        clay.softeningLength = 0.2


def testRigidityNeedsPoisson():
    with pytest.raises(ValueError, match="rigidity = 100 is given without poisson"):
        mpm.Tresca(density=1.7, undrainedStrength=5, rigidity=100)


def testCamClayNeedsOneWayToItsPreconsolidation():
    with pytest.raises(ValueError, match="both missing"):
        mpm.ModifiedCamClay(**CLAY)
    with pytest.raises(ValueError, match="both given"):
        mpm.ModifiedCamClay(**CLAY, preconsolidation=100, overconsolidationRatio=2)
    with pytest.raises(ValueError, match="swelling = 0.3"):
        mpm.ModifiedCamClay(**{**CLAY, "swelling": 0.3}, preconsolidation=100)
