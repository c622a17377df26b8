# SPDX-License-Identifier: GPL-2.0-or-later
"""pressureExponent of every law: elastic moduli that grow with a power of the pressure.

Set-up: points of soil, clay, grains, mud and elastic bodies too strong to yield, in compression and in closed
cycles; blocks and columns under pressure. Reference: dp/de = K_ref (p/p_ref)^m in closed form; the work of
the stress by the trapezoidal rule; the critical step falls with the root of the present moduli; cycles and
columns by hand.
Tolerance: 1e-9 of the pressure (2e-10 found; NeoHookean, whose pressure is not quite linear: 1 %, 0.6 %),
1e-9 of the step, 1e-12 of the stress there and back (1e-15), 1e-11 of the work (3e-12), 1 % of the energy
that a cycle makes (0.7 %).
Controls: constant moduli are told apart, hypoelastic laws make the energy that the cycle says, and a yielding
test ends at the strength of constant moduli.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from setups import strainUnderPressure, workOf
from yade_mpm.check import limits
from yade_mpm.scene.policy import LoopPolicy, followsStress

STRONG = dict(density=2.0, young=3e4, poisson=0.25, cohesion=1e6, frictionAngle=0.0)
SAND = dict(STRONG, cohesion=1.0, frictionAngle=0.55, dilatancyAngle=0.1)
BULK, SHEAR = 3e4 / (3 * 0.5), 1.2e4
CLAY = dict(density=2.0, young=3e4, poisson=0.25)
MUD = dict(density=2.0, bulk=BULK, shearModulus=SHEAR)
GRAINS = dict(staticFriction=0.5, fastFriction=0.6, grainSize=0.01)


def hypoelastic(points):
    """Linear elasticity whose moduli follow the pressure."""
    K, G = BULK * points.stiffening, SHEAR * points.stiffening
    stress = points.stress + 2 * G * points.strain
    stress[:3] += (K - 2 / 3 * G) * points.strain[:3].sum(axis=0)
    return stress


LAWS = {
    "MohrCoulomb": lambda **more: mpm.MohrCoulomb(**STRONG, **more),
    "MohrCoulombDruckerPrager": lambda **more: mpm.MohrCoulombDruckerPrager(**STRONG, **more),
    "Tresca": lambda **more: mpm.Tresca(**CLAY, undrainedStrength=1e4, **more),
    "MuI": lambda **more: mpm.MuI(**CLAY, staticFriction=1e3, fastFriction=1e3, grainSize=0.01, **more),
    "HerschelBulkley": lambda **more: mpm.HerschelBulkley(**MUD, yieldStress=1e4, consistency=1.0, **more),
    "PythonLaw": lambda **more: mpm.PythonLaw(hypoelastic, **CLAY, **more),
    "LinearElastic": lambda **more: mpm.LinearElastic(**CLAY, **more),
    "NeoHookean": lambda **more: mpm.NeoHookean(**CLAY, **more),
}
ELASTIC = "LinearElastic", "NeoHookean"
WITH_ENERGY = [law for law in LAWS if law != "PythonLaw"]
every = pytest.mark.parametrize("law", LAWS)
soils = pytest.mark.parametrize("law", ["MohrCoulomb", "MohrCoulombDruckerPrager"])


def at(law, pressure, **more):
    """A point at a pressure; one that is free of stress at the start is brought there."""
    if law != "NeoHookean":
        return mpm.MaterialPoint(LAWS[law](**more), -pressure * np.eye(3))
    point = mpm.MaterialPoint(LAWS[law](**more))
    while -np.trace(point.stress) / 3 < pressure:
        point.strain(-1e-5 * np.eye(3))
    return point


def meanPressure(point):
    """Of the Kirchhoff stress where that follows the strain."""
    J = np.linalg.det(point.deformationGradient) if type(point.material).__name__ in ELASTIC else 1
    return -J * np.trace(point.stress) / 3


@every
@pytest.mark.parametrize("m", [0.5, 1.0])
def testCompressionFollowsThePowerLaw(law, m):
    point = at(law, 50.0, pressureExponent=m)
    before = meanPressure(point)
    for _ in range(100):
        point.strain(-0.01 / 3 / 100 * np.eye(3))
    strain = 0.01 * BULK / 100**m
    exact = (before ** (1 - m) + (1 - m) * strain) ** (1 / (1 - m)) if m < 1 else before * np.exp(strain)
    error = 0.01 if law == "NeoHookean" else 1e-9
    if law == "NeoHookean" and m == 1:
        pytest.skip(
            "it comes from no stress: 5 % of volume, where its own energy is not that of small strains"
        )
    assert meanPressure(point) == pytest.approx(exact, rel=error)
    stiffer = (exact / 100) ** m
    if law in WITH_ENERGY:
        _, k, scale = strainUnderPressure(-exact * np.eye(3), BULK, SHEAR, m)
        assert m == 1 or k * scale == pytest.approx(stiffer, rel=1e-12)
        stiffer = k * scale
    assert point.stiffness[1] == pytest.approx(SHEAR * stiffer, rel=error)
    constant = at(law, 50.0)
    constant.strain(-0.01 / 3 * np.eye(3))
    assert meanPressure(point) != pytest.approx(meanPressure(constant), rel=0.05)


VOLUME = -2e-3 / 3 * np.eye(3)
SLIDE = 5e-4 * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])


def volumePower(law):
    """1: the stress of a law does its work by the initial volume; 0: by the present one."""
    return 1 if law in (*ELASTIC, "PythonLaw") else 0


def stored(law, point):
    """kJ/m3."""
    return np.linalg.det(point.deformationGradient) ** volumePower(law) * point.storedEnergy


@every
@pytest.mark.parametrize("m", [0.5, 1.0])
def testTheWayBackGivesWhatTheWayTook(law, m):
    """Compression and release, with shear: nothing is left, whatever the step."""
    for steps in (2, 200):
        point = at(law, 50.0, pressureExponent=m)
        stress, energy = point.stress, stored(law, point)
        there = workOf(point, VOLUME + SLIDE, steps, volumePower(law))
        gained, back = stored(law, point) - energy, workOf(point, -VOLUME - SLIDE, steps, volumePower(law))
        assert np.abs(point.stress - stress).max() < 1e-12 * 50
        assert there + back == pytest.approx(0, abs=1e-11 * there)
        assert stored(law, point) == pytest.approx(energy, rel=1e-12)
        assert law not in WITH_ENERGY or steps == 2 or gained == pytest.approx(there, rel=1e-5)


@every
@pytest.mark.parametrize("m", [0.5, 1.0])
def testAClosedCycleOfStrainMakesTheEnergyThatItsPageSays(law, m):
    """Pressed, sheared, released to the old pressure, and sheared back."""
    point = at(law, 50.0, pressureExponent=m)
    start, energy = point.stress, stored(law, point)
    work = sum(workOf(point, x, 400, volumePower(law)) for x in (5 * VOLUME, SLIDE))
    high, tau = meanPressure(point), point.stress[0, 1]
    work += workOf(point, -5 * VOLUME, 400, volumePower(law))
    low = meanPressure(point)
    lent = tau**2 / (2 * SHEAR * (low / 100) ** m)  # what the shear stress stores at the low pressure
    if law in WITH_ENERGY:
        work += workOf(point, -SLIDE, 400, volumePower(law))
        assert np.abs(point.stress - start).max() < 1e-11 * high
        assert work == pytest.approx(0, abs=1e-5 * lent)
    else:
        work += workOf(point, -SLIDE * point.stress[0, 1] / (2 * point.stiffness[1] * SLIDE[0, 1]))
        assert abs(point.stress[0, 1]) < 1e-10 * tau
        made = stored(law, point) - energy - work
        assert made == pytest.approx(lent * (1 - (low / high) ** m), abs=0.01 * lent)
        assert made > 0.4 * lent


@pytest.mark.parametrize("law", WITH_ENERGY)
def testRandomPathsStoreAllWork(law):
    rng = np.random.default_rng(7)
    for _ in range(5):
        point = at(law, 20.0, pressureExponent=0.7, smallestPressure=5.0)
        before, work = stored(law, point), 0.0
        for _ in range(5):
            x = 6e-4 * rng.normal(size=(3, 3))
            if law in ("MuI", "HerschelBulkley"):
                x -= np.trace(x) / 3 * np.eye(3) * 1.5  # grains without pressure part
            work += workOf(point, x + x.T, 200, volumePower(law))
        assert stored(law, point) - before == pytest.approx(work, abs=1e-5 * max(abs(work), before))


@pytest.mark.parametrize("name", ["LinearElastic", "MohrCoulomb", "MuI"])
def testUnitsOfStressDoNotMatter(name):
    more = {"MohrCoulomb": dict(frictionAngle=0.5), "MuI": dict(staticFriction=0.5, fastFriction=0.5)}
    found = []
    for kPa in (1.0, 1000.0):  # the second in Pa
        given = dict(density=2.0 * kPa, young=3e4 * kPa, poisson=0.25, pressureExponent=0.5)
        given |= dict(referencePressure=50 * kPa, smallestPressure=2 * kPa, **more.get(name, {}))
        given |= {"MohrCoulomb": dict(cohesion=3 * kPa), "MuI": dict(grainSize=0.01)}.get(name, {})
        point = mpm.MaterialPoint(getattr(mpm, name)(**given), -20 * kPa * np.eye(3))
        workOf(point, 2 * SLIDE + VOLUME, 10)
        found.append(point.stress / kPa)
    assert np.abs(found[1] - found[0]).max() < 1e-12 * np.abs(found[0]).max()


def testAnElasticBodyStartsFromItsStress():
    stress = -np.array([[60.0, 10, 0], [10, 90, -5], [0, -5, 75]])
    point = mpm.MaterialPoint(mpm.LinearElastic(**CLAY, pressureExponent=0.5), stress)
    before = point.stiffness
    after = point.gradient(np.zeros((3, 3)), 1.0)
    assert np.abs(after - stress).max() < 1e-10
    _, k, scale = strainUnderPressure(stress, BULK, SHEAR, 0.5)
    deviator = BULK / (scale * SHEAR) * 0.5 * ((stress + 75 * np.eye(3)) ** 2).sum()
    share = deviator / (75**2 + deviator)
    tangent = (np.sqrt(75**2 + deviator) / 100) ** 0.5
    bound = k + (tangent - k) * (share + np.sqrt(share * (1 - share)))
    assert before[1] == pytest.approx(SHEAR * scale * bound, rel=1e-12)


def testGravityOfALiquidStiffensIt():
    law = mpm.NewtonianLiquid(**MUD, viscosity=1e-3, pressureExponent=0.5)
    soft, stiff = (mpm.MaterialPoint(law, -p * np.eye(3)).stiffness for p in (25.0, 400.0))
    assert stiff[0] / soft[0] == pytest.approx(4, rel=1e-12)
    assert law.lameConstants[1] == pytest.approx(SHEAR * 0.1)  # at smallestPressure


@soils
def testShearIsOfThePressureAndStrengthIsNot(law):
    kind = getattr(mpm, law)
    soft, stiff = (
        mpm.elementTest.triaxial(kind(**SAND, pressureExponent=0.5), p, 0.06, steps=300) for p in (25, 400)
    )
    assert stiff.q[1] / soft.q[1] == pytest.approx(4, rel=0.05)
    constant = mpm.elementTest.triaxial(kind(**SAND), 400, 0.06, steps=300)
    assert stiff.q[-1] == pytest.approx(constant.q[-1], rel=1e-6)


def pressed(law, pressure, type_=None, **more):
    scene = mpm.Scene((0, 0), (8, 8), cell=1.0, threads=1)
    body = scene.add(
        "soil", mpm.box((1, 1), (7, 7)), LAWS[law](**more), type_ or mpm.UGIMP(perCell=2), implicit=False
    )
    if pressure:
        body.stress = -pressure * np.tile(np.eye(3), (body.count, 1, 1))
    return scene, body


@every
def testTheCriticalStepFollowsThePresentStiffness(law):
    if law == "NeoHookean":  # without a stress at the start: that of smallestPressure
        given = [dict(smallestPressure=p) for p in (25.0, 400.0)]
        steps = [pressed(law, 0, pressureExponent=0.5, **one)[0].criticalTimeStep() for one in given]
    else:
        steps = [pressed(law, p, pressureExponent=0.5)[0].criticalTimeStep() for p in (25.0, 400.0)]
    assert steps[0] / steps[1] == pytest.approx(2, rel=1e-9)


@pytest.mark.parametrize("type_", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.25)])
@pytest.mark.parametrize("law", ["LinearElastic", "NeoHookean", "MuI"])
def testABlockWithoutStressTakesItsWeight(law, type_):
    """From no stress on each of the first steps makes it stiffer: the automatic step falls as fast."""

    def block():
        scene = mpm.Scene((0, 0), (4, 4), cell=0.5, gravity=10.0, threads=1)
        scene.fix("bottom")
        scene.roller("left", "right")
        made = LAWS[law](pressureExponent=0.6)
        return scene, scene.add("soil", mpm.box((0, 0), (3, 3)), made, type_, implicit=False)

    def energy(scene, body):
        mass, height = body.mass, body.position[:, 1]
        moving = (0.5 * (body.velocity**2).sum(axis=1) + 10 * height) @ mass
        return mpm.diagnostics.storedEnergy(scene) + moving

    scene, body = block()
    before = energy(scene, body)
    scene.run(steps=10, progress=False)
    assert energy(scene, body) == pytest.approx(before, rel=2e-3)
    assert 60 < -body.stress.min() < 200  # at rest 60 kPa
    again, other = block()
    for _ in range(10):
        again.run(steps=1, progress=False)
    assert np.array_equal(other.stress, body.stress)


@pytest.mark.parametrize(
    "made",
    [
        lambda: mpm.MohrCoulomb(**STRONG | {"young": lambda x: 3e4 + 0 * x[:, 0]}, pressureExponent=0.5),
        lambda: mpm.LinearElastic(**CLAY | {"young": [(0, 3e4), (4, 2e4)]}, pressureExponent=0.5),
        lambda: mpm.HerschelBulkley(
            density=2, bulk=lambda x: 2e4 + x[:, 1], yieldStress=9.0, consistency=1.0, pressureExponent=0.5
        ),
        lambda: mpm.MuI(**CLAY | {"young": 200.0}, **GRAINS, pressureExponent=1.0),
    ],
)
def testTheStepFollowsModuliThatVaryOrAreSmall(made):
    scene = mpm.Scene((0, 0), (4, 4), cell=0.5, threads=1)
    scene.add("soil", mpm.box((0, 0), (3, 3)), made(), implicit=False)
    policy = LoopPolicy(scene, print)
    assert policy.lookPeriod == limits.DT_LOOK_PRESSED
    assert followsStress(made()) and not followsStress(mpm.LinearElastic(**CLAY))


def testTheStrengthOfClayIsNotThatOfThePressure():
    for p in (25, 400):
        law = mpm.Tresca(**CLAY, undrainedStrength=20, pressureExponent=0.5)
        curve = mpm.elementTest.triaxial(law, p, 0.06, drained=False, steps=1500)
        assert curve.q[-1] == pytest.approx(40, rel=1e-9)
        assert curve.q[1] == pytest.approx(3 * 1.2e4 * (p / 100) ** 0.5 * 0.06 / 1500, rel=1e-3)


def testClayIsStiffByItsStrengthOrByItsPressure():
    with pytest.raises(ValueError, match="rigidity = 100 and pressureExponent = 0.5 are given together"):
        mpm.Tresca(density=2, poisson=0.3, rigidity=100, undrainedStrength=20, pressureExponent=0.5)


def testTheExponentOfSanisandIsThatOfItsStiffness():
    given = dict(density=1.5, frictionAngle=0.54, criticalVoidRatio=0.934, compression=0.019)
    for power in (0.5, 0.8):
        law = mpm.Sanisand(**given, initialVoidRatio=0.8, pressureExponent=power)
        low, high = (mpm.MaterialPoint(law, -p * np.eye(3)).stiffness for p in (50.0, 200.0))
        assert high[1] / low[1] == pytest.approx(4**power, rel=1e-12)


@pytest.mark.parametrize("type_", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.5)])
def testASceneIsSavedAndGoesOnWithItsStiffness(type_, tmp_path):
    runs = []
    for law in ("LinearElastic", "MohrCoulomb"):
        scene, body = pressed(law, 40.0, type_, pressureExponent=0.5)
        body.velocity[:, 0] = 0.5 * (body.position[:, 1] - 4)
        scene.run(steps=20, progress=False)
        scene.save(tmp_path / "a.h5")
        again = mpm.load(tmp_path / "a.h5")
        for one in (scene, again):
            one.run(steps=20, progress=False)
        assert np.array_equal(again["soil"].stress, body.stress)
        assert again["soil"].material == body.material
        runs.append(body.stress)
    assert not np.array_equal(*runs)


def testAnImplicitBodySettlesAsAnExplicitOne():
    """A column under its weight, against J s = sqrt(M/K) P of the law with K = E/3 and G' = E of Poisson's
    ratio 0: the integral of the strain."""
    weight, smallest, M = 20 * np.linspace(0, 4, 2001), 10.0, 1e3 + 4 / 3 * 3e3
    strain = np.zeros(2001)
    for _ in range(20):
        P = weight * np.exp(-strain) * np.sqrt(1e3 / M)
        strain = 20 * np.minimum(P / np.sqrt(smallest), np.sqrt(P)) / np.sqrt(1e3 * M)
    exact = 4 * np.mean(1 - np.exp(-strain))
    for implicit, dt in ((False, 4e-3), (True, 0.05)):
        scene = mpm.Scene((0, 0), (1, 5), cell=0.25, gravity=10, damping=0.7, threads=1)
        scene.roller("bottom", "left", "right")
        law = mpm.LinearElastic(density=2, young=3e3, poisson=0.0, pressureExponent=0.5, smallestPressure=10)
        body = scene.add("column", mpm.box((0, 0), (1, 4)), law, mpm.APDI(size=0.25), implicit=implicit)
        scene.dt = dt
        scene.run(until=4.0, progress=False)
        assert abs(body.velocity).max() < 0.01
        assert 4 - body.vertices[:, 1].max() == pytest.approx(exact, rel=0.01)
    constant = 4 * 20 * 4 / 2 / 3e3  # with the moduli as given
    assert abs(exact - constant) > 0.2 * exact


@pytest.mark.parametrize("law", ["LinearElastic", "MohrCoulomb", "MuI"])
def testStiffnessMayVaryInSpaceBesideItsPressure(law):
    """Particles of two materials in one, and each alone."""
    stress = []
    for young in (lambda x: np.where(x[:, 0] < 4, 1e4, 3e4), 1e4, 3e4):
        scene = mpm.Scene((0, 0), (8, 8), cell=1.0, threads=1)
        made = LAWS[law](pressureExponent=0.5)
        made = type(made)(**{k: v for k, v in made.attributes().items() if k != "lame"} | {"young": young})
        body = scene.add("soil", mpm.box((1, 1), (7, 7)), made, mpm.UGIMP(perCell=2), fbar=False)
        body.stress = -30 * np.tile(np.eye(3), (body.count, 1, 1))
        body.velocity[...] = 0.1 * (4 - body.position)
        scene.dt, isLeft = 1e-4, body.position[:, 0] < 4
        scene.run(steps=1, progress=False)
        stress.append(body.stress.copy())
    assert np.array_equal(stress[0], np.where(isLeft[:, None, None], stress[1], stress[2]))


@cases(
    ("pressureExponent = 1.5", lambda: LAWS["LinearElastic"](pressureExponent=1.5)),
    ("pressureExponent = -0.5", lambda: LAWS["MuI"](pressureExponent=-0.5)),
    ("referencePressure = 0", lambda: LAWS["HerschelBulkley"](pressureExponent=0.5, referencePressure=0)),
    ("smallestPressure = -1", lambda: LAWS["NeoHookean"](pressureExponent=0.5, smallestPressure=-1)),
)
def testWhatIsNoPowerOrPressureIsRefused(named, make, kind):
    refused(named, make, kind)


def testALawWithoutConstantModuliHasNoSuchOption():
    for law in (mpm.UMAT, mpm.MFront, mpm.ModifiedCamClay):
        with pytest.raises((AttributeError, TypeError, ValueError), match="pressureExponent"):
            law(density=1.0, pressureExponent=0.5)


def testWavesLeaveThroughASideOfConstantModuliAlone():
    scene = mpm.Scene((0, 0), (4, 4), cell=1.0, threads=1)
    rock = LAWS["LinearElastic"](pressureExponent=0.5)
    scene.add("rock", mpm.box((0, 0), (4, 4)), rock, mpm.UGIMP(perCell=2))
    with pytest.raises(ValueError, match="viscous: behind = LinearElastic .* or one that varies"):
        scene.viscous("left", behind=rock)


@pytest.mark.parametrize("cell", [0.5, 0.25])
def testAColumnOfBoxesWithFbarSettlesAsByHand(cell):
    """Under sudden weight, held at its sides: s = P sqrt(M/K) with M = K + 4/3 G', P0 = sqrt(K M) e.

    -0.65 and -0.31 % found. Hypoelastic soil settled 0.05 and 1.15 % too much, more in smaller cells.
    """
    scene = mpm.Scene((0, 0), (2 * cell, 7), cell=cell, gravity=10.0, damping=0.5, threads=1)
    scene.roller("bottom", "left", "right")
    soil = scene.add(
        "soil",
        mpm.box((0, 0), (2 * cell, 6)),
        LAWS["MohrCoulomb"](pressureExponent=0.5),
        mpm.UGIMP(perCell=2),
        implicit=False,
    )
    top = soil.position[:, 1].max()
    scene.run(until=1.5, progress=False)
    weight = 20 * np.linspace(0, 6, 2001)
    M = BULK + 4 / 3 * 2 * SHEAR
    P = weight * np.sqrt(BULK / M)
    strain = 20 * np.minimum(P, np.sqrt(P)) / np.sqrt(BULK * M)
    exact = 6 * np.mean(1 - np.exp(-strain))
    assert top - soil.position[:, 1].max() == pytest.approx(exact, rel=0.01)
