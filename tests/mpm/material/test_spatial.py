# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters that vary in space reach every particle, and stay with it.

Strengths are read by the laws themselves; any other number of any law is set in a copy of the law before it
treats a particle, and is a state variable of the particle, too.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import CAM_CLAY, chain, restarted
from yade_mpm.geotech.strength import divideStrength

ELASTIC = {"density": 1.7, "young": 5e3, "poisson": 0.3}
DEPTH = 2.0


def clay(strength):
    return mpm.Tresca(**ELASTIC, undrainedStrength=strength)


def block(material, type=None, dim=2, **options):
    scene = mpm.Scene((0,) * dim, (2,) * (dim - 1) + (3,), cell=0.5, threads=1)
    upper = (2,) * (dim - 1) + (DEPTH,)
    body = scene.add("soil", mpm.box((0,) * dim, upper), material, type or mpm.UGIMP(perCell=2), **options)
    sides = ("left", "right", "front", "back")[: 2 * dim - 2]
    scene.engines = chain(gravity=(0,) * (dim - 1) + (-9.81,), fixed="bottom", roller=sides, damping=0.2)
    return scene, body


def linear(x):
    return 5 + 1.3 * (DEPTH - x[:, -1])


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", [lambda: mpm.UGIMP(perCell=2), lambda: mpm.APDI(size=0.25)])
def testAFunctionAProfileAndAnArrayAreOne(dim, kind):
    _, byFunction = block(clay(linear), kind(), dim)
    _, byProfile = block(clay([(DEPTH, 5), (0, 5 + 1.3 * DEPTH)]), kind(), dim)
    ofIds = byFunction.byId("undrainedStrength")
    _, byArray = block(clay(ofIds), kind(), dim)
    np.testing.assert_allclose(byFunction.undrainedStrength, linear(byFunction.position), rtol=1e-14)
    np.testing.assert_allclose(byProfile.undrainedStrength, byFunction.undrainedStrength, rtol=1e-14)
    np.testing.assert_array_equal(byArray.undrainedStrength, byFunction.undrainedStrength)


@pytest.mark.parametrize("law", ["MohrCoulomb", "MohrCoulombDruckerPrager"])
@pytest.mark.parametrize("fbar", [True, False])
def testAConstantFunctionIsTheNumber(law, fbar):
    """To round-off, in a block that yields under its weight; another number is told apart."""

    def stress(cohesion, angle):
        material = getattr(mpm, law)(**ELASTIC, cohesion=cohesion, frictionAngle=angle)
        scene, body = block(material, fbar=fbar)
        scene.run(steps=300, progress=False)
        assert body.plasticShearStrain.max() > 1e-4
        return body.byId("stress")

    asNumber = stress(0.2, 0.2)
    for cohesion, angle in (
        (lambda x: 0.2, 0.2),
        (0.2, lambda x: 0.2),
        (lambda x: np.full(len(x), 0.2), lambda x: 0.2),
    ):
        np.testing.assert_allclose(stress(cohesion, angle), asNumber, atol=1e-9)
    assert np.abs(stress(lambda x: 0.21, 0.2) - asNumber).max() > 1e-3


def testStrengthsStayThroughARestart():
    scene, body = block(clay(linear))
    scene.run(steps=50, progress=False)
    again = restarted(scene, 50)
    assert again.bodies[0].material.undrainedStrength == "per particle"
    np.testing.assert_array_equal(again.bodies[0].byId("undrainedStrength"), body.byId("undrainedStrength"))


def testAPictureHasTheStrengthOfEachParticle():
    plt = pytest.importorskip("matplotlib.pyplot", reason="no matplotlib here (Debian: python3-matplotlib)")
    plt.switch_backend("Agg")
    scene, body = block(clay(linear))
    shown = scene.plot("undrainedStrength").collections[0].get_array()
    plt.close("all")
    np.testing.assert_allclose(np.sort(shown), np.sort(body.undrainedStrength), rtol=1e-12)
    assert np.ptp(shown) > 1


def testPerParticleMeansThatYouSetTheField():
    scene, body = block(clay("per particle"))
    with pytest.raises(ValueError, match="undrainedStrength"):
        scene.run(steps=1, progress=False)
    body.undrainedStrength = 7.0
    scene.run(steps=1, progress=False)


def pulledApart(soil):
    """A scene and its block of boxes, some of which have been cut, and how many there were."""
    scene = mpm.Scene((0, 0), (6, 3), cell=0.5, threads=1)
    body = scene.add("soil", mpm.box((1, 0), (3, 2)), soil, mpm.UGIMP(perCell=2, splitAt=1.2))
    scene.engines = chain(fixed="bottom")
    before = body.count
    body.velocity[:, 0] = 8 * (body.position[:, 0] - 2)
    scene.run(until=0.1, progress=False)
    assert body.count > before
    return scene, body, before


def testCutParticlesAndConvertedDomainsKeepTheirStrength():
    soil = mpm.MohrCoulomb(**ELASTIC, cohesion=linear, frictionAngle=0.3)
    scene, body, before = pulledApart(soil)
    assert body.cohesion.min() >= 5
    assert np.unique(body.cohesion).size == np.unique(body.byId("cohesion")[:before]).size


@pytest.mark.parametrize(
    "given, error",
    [
        (lambda x: np.zeros(3), "shape|broadcast"),
        (lambda x: np.full(len(x), np.nan), "not finite at"),
        (lambda x: 5 - 10 * x[:, 1], "a positive number"),
        ([1.0, 2.0, 3.0], "order of body.id"),
        ([(0, 1), (0, 2)], "two values at one elevation"),
        (lambda x: "much", "not made of numbers"),
    ],
)
def testWhatIsNoStrengthIsRefused(given, error):
    with pytest.raises(ValueError, match=error):
        block(clay(given))


def testWhatParticlesHaveCannotBeChangedInTheMaterial():
    _, body = block(clay(linear))
    with pytest.raises(ValueError, match="set body.undrainedStrength"):
        body.material.undrainedStrength = 4.0
    soil = mpm.MohrCoulomb(**ELASTIC, cohesion=5, frictionAngle=0.3)
    _, body = block(soil)
    soil.cohesion = 6.0  # of all particles
    with pytest.raises(ValueError, match="before scene.add"):
        soil.cohesion = linear


@pytest.mark.parametrize("young", [{"young": 6e3}, {"rigidity": 100}])
@pytest.mark.parametrize("value", [0, -5])
def testAStrengthThatIsSetByHandIsCheckedBeforeTheRun(young, value):
    scene, body = block(mpm.Tresca(density=1.7, poisson=0.45, undrainedStrength="per particle", **young))
    body.undrainedStrength = np.where(body.id < 3, value, 20)
    with pytest.raises(ValueError, match="'soil'.*undrainedStrength.*positive"):
        scene.run(steps=1, progress=False)


def testRigidityFollowsTheStrengthOfEachParticle():
    """G = rigidity su; the particles are those of clay with that young and poisson, to round-off."""
    given = dict(density=1.7, poisson=0.45, undrainedStrength=lambda x: np.full(len(x), 8.0))
    stress = []
    for elastic in ({"rigidity": 100}, {"young": 2 * 1.45 * 800}, {"rigidity": 110}):
        scene, body = block(mpm.Tresca(**given, **elastic))
        scene.run(steps=300, progress=False)
        stress.append(body.byId("stress"))
    np.testing.assert_allclose(stress[0], stress[1], atol=1e-9)
    assert np.abs(stress[2] - stress[1]).max() > 1e-3


@pytest.mark.parametrize("dim", [2, 3])
def testTheStepFollowsTheStrongestClay(dim):
    def step(strength):
        scene, _ = block(
            mpm.Tresca(density=1.7, poisson=0.45, rigidity=100, undrainedStrength=strength), dim=dim
        )
        return scene.criticalTimeStep()

    of = {
        name: step(strength)
        for name, strength in (("strongest", linear(np.zeros((1, 1)))[0]), ("weakest", 5))
    }
    assert of["strongest"] < step(linear) < 0.95 * of["weakest"]


# --- any number of any law
SOIL = dict(**ELASTIC, cohesion=5, frictionAngle=0.5, dilatancyAngle=0.1)
SANDS = dict(density=1.5, frictionAngle=0.5, criticalVoidRatio=0.9, compression=0.02, stateParameter=-0.05)
SOFTENING = dict(softeningStrain=0.05, softeningLength=0.4, residualCohesion=1.0, residualFrictionAngle=0.4)
LAWS = {
    "LinearElastic": ELASTIC,
    "NeoHookean": ELASTIC,
    "MohrCoulomb": dict(SOIL, **SOFTENING, tensileStrength=2.0, pressureExponent=0.5, smallestPressure=2.0),
    "MohrCoulombDruckerPrager": dict(SOIL, dilatancyLimit=0.05, tensionCutOff=4.0, referencePressure=90.0),
    "Tresca": dict(
        density=1.7,
        poisson=0.45,
        rigidity=80.0,
        undrainedStrength=20.0,
        remouldedRatio=0.4,
        softeningStrain=0.1,
        rateFactor=0.1,
        referenceRate=1e-3,
    ),
    "ModifiedCamClay": dict(CAM_CLAY, density=1.7, overconsolidationRatio=1.5, waterBulk=1e4),
    "NorSand": dict(SANDS, shearModulus=3e4, overconsolidationRatio=1.2),
    "Sanisand": dict(SANDS, hardening=6.0),
    "MuI": dict(ELASTIC, staticFriction=0.4, fastFriction=0.6, grainSize=0.01),
    "HerschelBulkley": dict(density=1.7, bulk=1e4, yieldStress=5.0, consistency=0.1, flowIndex=0.5),
    "NewtonianLiquid": dict(density=1.7, bulk=1e4, viscosity=0.1),
}


OF_BODIES = "density", "softeningLength"


def sheared(material, state=None, elastic=False):
    """Stress, moduli, energy and state of a point after a path with a turn."""
    point = mpm.MaterialPoint(material, -(0.0 if elastic else 50.0) * np.eye(3), state)
    for way in (1, 1, 1, -1):
        point.gradient(2e-3 * np.array([[0.4, way, 0.0], [0.2, -0.5, 0.1], [0.0, way, 0.05]]), 1.0)
    left = {name: value for name, value in point.state.items() if name not in (state or {})}
    return point.stress, point.stiffness, point.storedEnergy, left


@pytest.mark.parametrize(
    "law, name", [(law, name) for law, given in LAWS.items() for name in given if name not in OF_BODIES]
)
def testAnyNumberOfAnyLawMayVary(law, name):
    """Bit by bit what the law with that number gives, and not what another number does."""
    given, isElastic = LAWS[law], law in ("LinearElastic", "NeoHookean")
    kind = getattr(mpm, law)
    stress, stiffness, energy, state = sheared(kind(**given), elastic=isElastic)
    own = kind(**{**given, name: "per particle"})
    found = sheared(own, {name: given[name]}, isElastic)
    np.testing.assert_array_equal(found[0], stress)
    assert found[1:3] == (stiffness, energy)
    assert found[3].items() <= state.items()


@pytest.mark.parametrize(
    "law, name", [(law, n) for law, given in LAWS.items() for n in OF_BODIES if n in given]
)
def testWhatIsOfABodyDoesNotVary(law, name):
    kind, given = getattr(mpm, law), LAWS[law]
    with pytest.raises(ValueError, match=f"{name} = .* is not allowed"):
        kind(**{**given, name: lambda x: np.full(len(x), 1.5)})


def byDepth(top, bottom):
    return lambda x: bottom + (top - bottom) * x[:, -1] / DEPTH


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("law", ["LinearElastic", "MohrCoulomb", "MohrCoulombDruckerPrager"])
def testEachParticleHasTheStiffnessOfItsPlace(law, dim):
    """One step of uniform compression: the stress is that of each particle's moduli."""
    young, poisson = byDepth(5e3, 2e4), byDepth(0.35, 0.2)
    strength = {} if law == "LinearElastic" else dict(cohesion=1e3, frictionAngle=0.3)
    material = getattr(mpm, law)(density=1.7, young=young, poisson=poisson, **strength)
    scene, body = block(material, dim=dim, fbar=False)
    scene.engines = chain(gravity=(0,) * dim)
    body.velocity[:, -1] = -0.01 * body.position[:, -1]
    np.testing.assert_allclose(body.young, young(body.position), rtol=1e-14)
    scene.run(steps=1, progress=False)
    E, nu = body.young, body.poisson
    M = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    strain = body.velocityGradient[:, -1, -1] * scene.dt
    np.testing.assert_allclose(body.stress[:, dim - 1, dim - 1], M * strain, rtol=1e-3)
    assert material.lameConstants[1] == pytest.approx((E / (2 * (1 + nu))).max(), rel=1e-12)
    assert material.waveSpeed == pytest.approx(np.sqrt(M.max() / 1.7), rel=0.2)


def testTheStepFollowsTheStiffestParticle():
    def step(young):
        soil = mpm.MohrCoulombDruckerPrager(**{**SOIL, "young": young})
        return block(soil)[0].criticalTimeStep()

    assert step(2e4) < step(byDepth(5e3, 2e4)) < 0.8 * step(5e3)


def testOverconsolidationByDepth():
    ratio = byDepth(4.0, 1.5)
    scene, body = block(mpm.ModifiedCamClay(**CAM_CLAY, density=1.7, overconsolidationRatio=ratio))
    scene.initialStress(surface=DEPTH, K0=1.0)
    p = np.maximum(-np.trace(body.stress, axis1=1, axis2=2) / 3, 1.0)
    np.testing.assert_allclose(body.preconsolidation, ratio(body.position) * p, rtol=1e-12)


def stiffBelow(x):
    return np.where(x[:, -1] > 1, 5e3, 2e4)


def testStiffnessStaysWhenParticlesAreCutConvertedAndTakenAway():
    soil = mpm.MohrCoulomb(density=1.7, young=stiffBelow, poisson=0.3, cohesion=5, frictionAngle=0.3)
    scene, body, before = pulledApart(soil)
    assert set(np.unique(body.young)) == {5e3, 2e4}
    assert (body.young[body.position[:, 1] > 1.3] == 5e3).all()
    scene.remove(region=mpm.box((0, 1.2), (6, 3)))
    assert 0 < body.count < before * 2 and (body.young == 2e4).sum() >= before / 2


def testDomainsKeepTheirStiffnessWhenTheyConvert():
    soil = mpm.MohrCoulomb(density=1.7, young=stiffBelow, poisson=0.3, cohesion=1.0, frictionAngle=0.1)
    scene = mpm.Scene((0, 0), (6, 3), cell=0.5, threads=1)
    body = scene.add("soil", mpm.box((1, 0), (3, 2)), soil, mpm.APDI(size=0.5, onDistortion="convert"))
    scene.engines = chain(fixed="bottom")
    body.velocity[:, 0] = 6 * (body.position[:, 1] - 1)
    scene.run(until=0.4, progress=False)
    boxes = scene[body.convertsTo]
    assert boxes.count > 0
    assert set(np.unique(boxes.young)) <= {5e3, 2e4}


def testOwnParametersStayThroughARestart():
    soil = mpm.MohrCoulomb(**{**SOIL, "young": byDepth(5e3, 2e4), "tensileStrength": byDepth(1.0, 3.0)})
    scene, body = block(soil)
    scene.run(steps=50, progress=False)
    again = restarted(scene, 50)
    assert again.bodies[0].material.young == "per particle"
    scene.run(steps=20, progress=False)
    again.run(steps=20, progress=False)
    for name in ("young", "tensileStrength", "stress", "position"):
        np.testing.assert_array_equal(again.bodies[0].byId(name), body.byId(name))


def testThreadsAndOrderDoNotChangeABit():
    def stress(threads):
        soil = mpm.MohrCoulombDruckerPrager(**{**SOIL, "cohesion": 0.2, "young": byDepth(5e3, 2e4)})
        scene, body = block(soil)
        scene.threads = threads
        scene.run(steps=100, progress=False)
        return body.byId("stress")

    np.testing.assert_array_equal(stress(1), stress(2))


@pytest.mark.parametrize(
    "given, error",
    [
        (
            {"swelling": lambda x: np.where(x[:, 1] < 1, 0.04, 0.5)},
            r"particle \d+ at .*swelling = 0.5 is not",
        ),
        ({"swelling": lambda x: -0.04 + 0 * x[:, 0]}, "swelling = -0.04 is not allowed"),
        ({"poisson": [(0, 0.3), (1, 0.5)]}, "poisson = 0.5"),
    ],
)
def testValuesThatDoNotFitAreRefusedWithTheirPlace(given, error):
    clay = mpm.ModifiedCamClay(**{**CAM_CLAY, "density": 1.7, "overconsolidationRatio": 2.0, **given})
    with pytest.raises(ValueError, match=error):
        block(clay)


def testAWrongValueSetByHandIsRefusedBeforeTheRun():
    scene, body = block(mpm.LinearElastic(**{**ELASTIC, "young": "per particle"}))
    with pytest.raises(ValueError, match="young"):
        scene.run(steps=1, progress=False)
    body.young = np.where(body.id < 3, -1.0, 5e3)
    with pytest.raises(ValueError, match="'soil'.*young.*positive"):
        scene.run(steps=1, progress=False)
    body.young = 5e3
    scene.run(steps=1, progress=False)


@pytest.mark.parametrize(
    "law, name",
    [
        ("ModifiedCamClay", "compression"),
        ("NorSand", "overconsolidationRatio"),  # its state would be no number
        ("Sanisand", "stateParameter"),
        ("Tresca", "rigidity"),
    ],
)
def testAnInitialStressComesAfterTheValuesThatItsStateFollowsFrom(law, name):
    scene, body = block(getattr(mpm, law)(**{**LAWS[law], name: "per particle"}))
    with pytest.raises(ValueError, match=f"'soil': {name} is \"per particle\".*set body.{name} before"):
        scene.initialStress(surface=DEPTH, K0=0.5)
    setattr(body, name, LAWS[law][name])
    scene.initialStress(surface=DEPTH, K0=0.5)
    scene.run(steps=2, progress=False)


def testAStrengthMayFollowTheInitialStress():
    scene, body = block(clay("per particle"))
    scene.initialStress(surface=DEPTH, K0=0.5)
    body.undrainedStrength = 7.0
    scene.run(steps=1, progress=False)


def testLameConstantsAreThoseOfTheStiffestParticle():
    soil = mpm.Tresca(density=1.7, poisson=0.45, rigidity=100, undrainedStrength=[(0, 30), (DEPTH, 5)])
    assert np.isnan(soil.waveSpeed)  # no particle yet
    _, body = block(soil)
    mu = 100 * body.undrainedStrength.max()
    assert soil.lameConstants == pytest.approx((9 * mu, mu), rel=1e-12)
    assert soil.waveSpeed == pytest.approx(np.sqrt(11 * mu / 1.7), rel=1e-12)


def testASafetyFactorDividesStrengthsOfEachParticle():
    soil = mpm.MohrCoulomb(**{**SOIL, **SOFTENING, "residualCohesion": byDepth(1.0, 2.0)})
    scene, body = block(soil)
    before = body.residualCohesion.copy()
    divideStrength(scene, 2.0)
    np.testing.assert_allclose(body.residualCohesion, before / 2, rtol=1e-14)
    assert soil.cohesion == 2.5
