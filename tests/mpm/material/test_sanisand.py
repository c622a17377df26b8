# SPDX-License-Identifier: GPL-2.0-or-later
"""Sanisand at a point: Toyoura sand of Dafalias & Manzari 2004 (their parameters are the defaults).

Set-up: triaxial tests and simple shear at constant volume, monotonic and cyclic. Reference: the rate
equations of the paper in triaxial space (p, q, scalars), in steps of 1e-6; the critical states, whatever
the initial pressure. Tolerance: 1 % of the largest stress, 1 % of the initial pressure in cycles. Controls:
dilatancy without fabric, and NorSand, which does not liquefy in cycles.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

M, E0, LAMBDA, XI, REFERENCE = 1.25, 0.934, 0.019, 0.7, 101.0
SAND = dict(density=1.5, frictionAngle=np.arcsin(3 * M / (6 + M)), criticalVoidRatio=E0, compression=LAMBDA)


def criticalPressure(e):
    return REFERENCE * ((E0 - e) / LAMBDA) ** (1 / XI)


def undrained(e, p0, amplitude=np.inf, reversals=0, most=0.1, step=1e-6, fabricRate=600.0):
    """Axial strain, q and p by the rate equations in triaxial space."""
    m, c, nu, A0, zMost = 0.01, 0.712, 0.05, 0.704, 4.0
    p, q, back, turned, fabric, strain, way, rows = p0, 0.0, 0.0, 0.0, 0.0, 0.0, 1, []
    while reversals >= 0 and abs(strain) < most:
        root = np.sqrt(p / REFERENCE)
        G = 125 * REFERENCE * (2.97 - e) ** 2 / (1 + e) * root
        K = 2 * (1 + nu) / (3 * (1 - 2 * nu)) * G
        psi, Mc = e - E0 + LAMBDA * (p / REFERENCE) ** XI, M if way > 0 else c * M
        if (back - turned) * way < 0:
            turned = back
        h = 125 * 7.05 * (1 - 0.968 * e) / root / max(abs(back - turned), 1e-9)
        hardening = h * (Mc * np.exp(-1.1 * psi) - m - way * back)
        D = A0 * (1 + max(way * fabric, 0)) * (Mc * np.exp(3.5 * psi) - m - way * back)
        ratio = way * q / p
        plastic = 3 * G * step / (p * hardening + 3 * G - K * D * ratio)
        plastic = max(plastic, 0) if ratio >= way * back + m - 1e-12 else 0
        q += way * 3 * G * (step - plastic)
        p -= K * D * plastic
        if plastic > 0:
            back = q / p - way * m
        fabric -= fabricRate * max(-D * plastic, 0) * (way * zMost + fabric)
        strain += way * step
        rows.append((strain, q, p))
        if way * q >= amplitude:
            way, reversals = -way, reversals - 1
    return np.array(rows)


def cyclicTriaxial(e, p0, amplitude, reversals, step=5e-6, **options):
    point = mpm.MaterialPoint(mpm.Sanisand(**SAND, initialVoidRatio=e, **options), -p0 * np.eye(3))
    strain, way, rows = 0.0, 1, []
    while reversals >= 0:
        s = point.strain(way * step * np.diag([0.5, 0.5, -1]))
        strain += way * step
        q = s[0, 0] - s[2, 2]
        rows.append((strain, q, -np.trace(s) / 3))
        if way * q >= amplitude:
            way, reversals = -way, reversals - 1
    return np.array(rows)


def pressuresAtNoShear(rows):
    """p wherever q passes zero."""
    return rows[1:, 2][np.diff(np.sign(rows[:, 1])) != 0]


@pytest.mark.parametrize("e", [0.735, 0.833, 0.907])
def testSandEndsAtTheCriticalStateOfItsDensity(e):
    for p0 in (100.0, 1000.0):
        law = mpm.Sanisand(**SAND, initialVoidRatio=e)
        curve = mpm.elementTest.triaxial(law, p0, 0.4, drained=False, steps=2000)
        assert curve.p[-1] == pytest.approx(criticalPressure(e), rel=0.02)
        assert curve.q[-1] == pytest.approx(M * curve.p[-1], rel=0.002)


@pytest.mark.parametrize("e, p0", [(0.735, 100.0), (0.833, 1000.0), (0.907, 1000.0)])
def testUndrainedTestsFollowTheRateEquations(e, p0):
    rows = undrained(e, p0)
    law = mpm.Sanisand(**SAND, initialVoidRatio=e)
    curve = mpm.elementTest.triaxial(law, p0, 0.1, drained=False, steps=1000)
    for k, found in ((1, curve.q), (2, curve.p)):
        error = np.interp(curve.strain, rows[:, 0], rows[:, k]) - found
        assert np.abs(error)[1:].max() < 0.01 * rows[:, k].max()


def testCyclesFollowTheRateEquations():
    for e, q in ((0.802, 27.44), (0.735, 40.0)):
        exact = pressuresAtNoShear(undrained(e, 98.0, q, 7))
        found = pressuresAtNoShear(cyclicTriaxial(e, 98.0, q, 7))
        assert len(found) == len(exact) > 5
        assert np.abs(found - exact).max() < 0.01 * 98
        withoutFabric = pressuresAtNoShear(undrained(e, 98.0, q, 7, fabricRate=0.0))
        assert e > 0.8 or np.abs(withoutFabric - exact).max() > 0.02 * 98


def shearCycles(law, tau, p0=98.0, most=12, step=2e-5):
    """Least pressure of cycles of simple shear at constant volume, kPa."""
    point, way, least = mpm.MaterialPoint(law, -p0 * np.eye(3)), 1, p0
    for _ in range(2 * most):
        shear = np.zeros((3, 3))
        shear[0, 2] = way * step
        for _ in range(1000):
            s = point.gradient(shear, 1.0)
            least = min(least, -np.trace(s) / 3)
            if way * s[0, 2] >= tau:
                break
        way = -way
    return least


def testCyclesOfShearLiquefySandAndDenseSandLess():
    loose, dense = (mpm.Sanisand(**SAND, initialVoidRatio=e) for e in (0.85, 0.69))
    assert shearCycles(loose, 14.0) < 0.2 * 98
    assert shearCycles(dense, 14.0) > 0.4 * 98
    given = dict(density=1.5, shearModulus=5e4, frictionAngle=SAND["frictionAngle"])
    norSand = mpm.NorSand(**given, criticalVoidRatio=0.92, compression=0.02, initialVoidRatio=0.85)
    assert shearCycles(norSand, 14.0) > 0.4 * 98


def testSandWithoutPressureHoldsNoShearAndResistsAgain():
    point = mpm.MaterialPoint(mpm.Sanisand(**SAND, initialVoidRatio=0.8), -20 * np.eye(3))
    for _ in range(50):
        stress = point.strain(np.diag([1e-3, 1e-3, 5e-4]))
    assert np.abs(stress).max() < 1.5
    for _ in range(300):
        stress = point.strain(np.diag([-1e-4, -1e-4, -2e-4]))
    assert -np.trace(stress) / 3 > 5


def testStepsOfAnySizeGiveAPossibleStress():
    rng = np.random.default_rng(5)
    for _ in range(40):
        law = mpm.Sanisand(**SAND, initialVoidRatio=rng.uniform(0.6, 0.95))
        point = mpm.MaterialPoint(law, -(10 ** rng.uniform(0, 3)) * np.eye(3))
        for _ in range(20):
            stress = point.gradient(10 ** rng.uniform(-6, -2) * rng.normal(size=(3, 3)), 1.0)
            p = -np.trace(stress) / 3
            q = np.sqrt(1.5 * ((stress + p * np.eye(3)) ** 2).sum())
            assert np.isfinite(stress).all() and p >= 0
            assert q <= 4 * M * p


@pytest.mark.parametrize("fbar", [True, False])
@pytest.mark.parametrize("rate", [8, 2])
def testSandThatIsTornApartGainsNoSpeed(rate, fbar):
    """All it gets is what it had stored. A pressure that stays would give it 27 % of its energy in 0.4 s."""
    scene = mpm.Scene((-2, -2), (8, 5), cell=0.5, threads=1)
    law = mpm.Sanisand(**SAND, stateParameter=-0.05)
    body = scene.add("sand", mpm.box((1, 0), (3, 2)), law, mpm.UGIMP(perCell=2), fbar=fbar)
    body.setStress(-20.0 * np.eye(3))
    history = mpm.History(iterPeriod=1)
    scene.engines = [*chain(), history]
    body.velocity[:, 0] = rate * (body.position[:, 0] - 2)
    stored = mpm.diagnostics.storedEnergy(scene)
    scene.run(until=0.8 / rate, progress=False)
    energy = history["kineticEnergy"]
    assert energy.max() < energy[0] + stored < 1.03 * energy[0]
    assert np.abs(body.stress).max() < 1e-9


@pytest.mark.parametrize(
    "given, error", [({}, "both missing"), ({"stateParameter": 0.0, "initialVoidRatio": 0.7}, "both given")]
)
def testWhatDoesNotFitIsRefused(given, error):
    with pytest.raises(ValueError, match=error):
        mpm.Sanisand(**SAND, **given)
    with pytest.raises(ValueError, match="compression is required"):
        mpm.Sanisand(**{k: v for k, v in SAND.items() if k != "compression"}, stateParameter=0.0)
