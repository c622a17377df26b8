# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters that vary in space reach every particle, and stay with it."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, restarted

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


def testPerParticleMeansThatYouSetTheField():
    scene, body = block(clay("per particle"))
    with pytest.raises(ValueError, match="undrainedStrength"):
        scene.run(steps=1, progress=False)
    body.undrainedStrength = 7.0
    scene.run(steps=1, progress=False)


def testCutParticlesAndConvertedDomainsKeepTheirStrength():
    scene = mpm.Scene((0, 0), (6, 3), cell=0.5, threads=1)
    soil = mpm.MohrCoulomb(**ELASTIC, cohesion=linear, frictionAngle=0.3)
    body = scene.add("soil", mpm.box((1, 0), (3, 2)), soil, mpm.UGIMP(perCell=2, splitAt=1.2))
    scene.engines = chain(fixed="bottom")
    before = body.count
    body.velocity[:, 0] = 8 * (body.position[:, 0] - 2)
    scene.run(until=0.1, progress=False)
    assert body.count > before
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


def testARandomFieldHasItsMomentsAndItsLength():
    """Over 200 seeds at two points a distance apart; the same seed is the same field."""
    x = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]])
    values = np.array(
        [mpm.RandomField(10.0, 3.0, (1.0, 2.0), seed, lognormal=False)(x) for seed in range(2000)]
    )
    assert values.mean() == pytest.approx(10, abs=0.2)
    assert values.std(axis=0) == pytest.approx(3, abs=0.2)
    assert np.corrcoef(values.T)[0, 1:] == pytest.approx([np.exp(-1), np.exp(-1)], abs=0.06)
    field = mpm.RandomField(10.0, 3.0, 1.0, seed=1)
    np.testing.assert_array_equal(field(x), field(x[::-1])[::-1])
    many = np.random.default_rng(1).uniform(0, 300, size=(20000, 2))
    assert (field(many) > 0).all()
    assert field(many).mean() == pytest.approx(10, rel=0.03)
    assert field(many).std() == pytest.approx(3, rel=0.1)


@pytest.mark.parametrize(
    "mean, deviation, lengths", [(-1, 3, 1), (10, -3, 1), (10, np.nan, 1), (np.inf, 3, 1), (10, 3, 0)]
)
def testARandomFieldIsCheckedWhenItIsMade(mean, deviation, lengths):
    with pytest.raises(ValueError, match="RandomField: "):
        mpm.RandomField(mean, deviation, lengths, seed=1)


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
