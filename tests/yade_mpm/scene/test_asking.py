# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene in the words of its problem: what the calls choose, the long form that does the same, errors."""

import contextlib
import io
import re

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, restarted

SAND = dict(density=1.8, young=2e4, poisson=0.3, cohesion=2, frictionAngle=0.55)
STEEL = dict(density=7.8, young=2.1e6, poisson=0.3)


def pileScene(dim=2):
    """A pile that is pressed into sand, in the calls of a user."""
    low, up = (0,) * dim, (3,) + (1,) * (dim - 2) + (3,)
    scene = mpm.Scene(low, up, cell=0.25, gravity=9.81, damping=0.05, threads=1)
    scene.fix("bottom")
    scene.roller("left", "right", *(("front", "back") if dim == 3 else ()))
    depth = (1,) * (dim - 2)
    hole = mpm.box(low[:-1] + (1.5,), (0.5, *depth, 2))
    ground = mpm.box(low, (3, *depth, 2)) - hole
    soil = scene.add("soil", ground, mpm.MohrCoulomb(**SAND))
    pile = scene.add("pile", mpm.box(low[:-1] + (1.5,), (0.5, *depth, 2.75)), mpm.LinearElastic(**STEEL))
    scene.contact(pile, soil, friction=0.3)
    press = scene.drive(pile.above(2.5), velocity=(0,) * (dim - 1) + (-0.1,))
    return scene, soil, pile, press


@pytest.mark.parametrize("dim", [2, 3])
def testTheLongFormDoesTheSameBitByBit(dim):
    scene, soil, _, press = pileScene(dim)
    scene.history(every=0.01)
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        scene.describe(long=True)
    names = {}
    exec(text.getvalue(), names)
    other = names["scene"]
    for one in (scene, other):
        one.run(steps=20, progress=False)
    for a, b in zip(scene.bodies, other.bodies):
        for field in ("position", "velocity", "stress"):
            np.testing.assert_array_equal(a.byId(field), b.byId(field))
    drive = other._gridSolver("test").drives[0]
    np.testing.assert_array_equal(press.impulse, drive.impulse)
    assert np.abs(press.impulse).max() > 0


def testTheSceneChoosesWhatSuits():
    scene, soil, pile, _ = pileScene()
    assert isinstance(soil.type, mpm.UGIMP) and soil.type.splitAt == 1.3 and soil.fbar
    assert isinstance(pile.type, mpm.APDI) and not pile.fbar and pile.implicit and not soil.implicit
    assert soil.group != pile.group
    kinds = [type(engine).__name__ for engine in scene.engines]
    assert kinds.index("GridSolver") < kinds.index("Contact") < kinds.index("GridToParticle")
    scene.run(steps=2, progress=False)
    assert any(isinstance(engine, mpm.History) for engine in scene.engines)
    assert not scene.quasiStatic().isQuasiStatic


def testDescribeTellsEveryChoiceWithItsReason(capsys):
    scene, *_ = pileScene()
    scene.describe()
    said = capsys.readouterr().out
    assert "bottom fixed; left, right on rollers" in said
    assert "UGIMP(splitAt=1.3): the material yields" in said
    assert "Threads   1, as given" in said
    scene.threads = None
    scene.describe()
    assert re.search(r"Threads   \d+ of \d+, one for every 1000 particles", capsys.readouterr().out)
    assert "implicit: its waves run at" in said and "group 'pile'" in said
    assert "Contact   'pile' and 'soil': friction 0.3" in said and "Engines   ParticleToGrid" in said


def testTheVerdictBehindSettleLeavesItsDampingOut(tmp_path):
    """Soil that settles heavily damped, then stands under a small load: the damping of settle is meant."""
    scene = mpm.Scene((0, 0), (1, 2), cell=0.25, gravity=9.81, threads=1)
    scene.fix("bottom")
    scene.roller("left", "right")
    soft = mpm.LinearElastic(density=2, young=2e3, poisson=0.3)
    column = scene.add("column", mpm.box((0, 0), (1, 1.5)), soft, mpm.UGIMP())
    press = scene.drive(column.above(1.375), velocity=(None, 0))
    history = scene.history(every=0.01)
    scene.settle(progress=False)
    press.velocity = (None, -0.02)
    scene.run(until=scene.time + 1, progress=False)
    verdict = scene.quasiStatic()
    plain = mpm.quasiStatic(history)
    assert verdict.dampedRatio < 0.2 * plain.dampedRatio and verdict.energyError < 0.02 < plain.energyError
    scene.save(tmp_path / "rested.h5")
    assert mpm.load(tmp_path / "rested.h5").quasiStatic().dampedRatio == verdict.dampedRatio


def testPrintOfDescribeSaysItOnce(capsys):
    scene, *_ = pileScene()
    told = scene.describe()
    said = capsys.readouterr().out
    print(told)
    assert said.rstrip("\n") == "".join(told) and capsys.readouterr().out == "\n" and repr(told) == ""


def testAHistoryHasTheDisplacementOfADrivenPart():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    press = scene.drive(block(scene, lower=(1, 1)).above(1.5), velocity=(None, 0.1))
    history = scene.history(every=0.01)
    scene.run(until=0.5, progress=False)
    assert history["block.uy"][-1] == pytest.approx(0.1 * history["time"][-1], rel=0.03)
    np.testing.assert_allclose(press.displacement[1], history["block.uy"][-1], rtol=0.03)
    with pytest.raises(KeyError, match="columns: block.fx, block.fy"):
        history["force"]


def testCompletionShowsTheWordsOfAUser():
    scene = mpm.Scene((0, 0), (1, 1), cell=0.25, threads=1)
    shown = {name for name in dir(scene) if not name.startswith("_")}
    assert {"add", "fix", "contact", "drive", "load", "run", "settle", "describe"} <= shown and len(
        shown
    ) <= 44
    assert scene.dim == 2 and scene.timing() is not None  # they are there
    with pytest.raises(AttributeError, match="did you mean 'timing'"):
        scene.timings  # noqa: B018


def testWhatIsGivenIsKept():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    box = mpm.box((0, 0), (1, 1))
    body = scene.add("block", box, mpm.LinearElastic(**STEEL), mpm.UGIMP(perCell=3))
    assert body.type.perCell == (3.0,) and not body.implicit and body.group == "main"


def testGravityIsANumberDownwardsOrAVector():
    scene = mpm.Scene((0, 0, 0), (1, 1, 1), cell=0.5, gravity=9.81)
    np.testing.assert_array_equal(scene.gravity, (0, 0, -9.81))
    scene.gravity = (1.0, 0.0, -9.0)
    np.testing.assert_array_equal(scene._gridSolver("test").gravity, (1, 0, -9))
    for wrong in (-9.81, (0, 9.81), "down", np.nan, None):
        with pytest.raises((ValueError, TypeError)):
            scene.gravity = wrong


def testBodiesThatMeetAndAreNotNamedStickTogether():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    sand = mpm.MohrCoulomb(**SAND)
    lower = scene.add("lower", mpm.box((0, 0), (3, 1)), sand)
    upper = scene.add("upper", mpm.box((0, 1), (3, 2)), sand)
    block = scene.add("block", mpm.box((1, 2), (2, 2.5)), mpm.LinearElastic(**STEEL))
    scene.contact(block, upper, friction=0.2)
    assert lower.group == upper.group != block.group
    law = scene.contact(block, lower, friction=0.2)
    assert law is scene.contact(block, upper, friction=0.2)


def testABodyThatWouldStickToBothSidesIsTold():
    """A cap stands on soil and pile: with one contact alone it is not clear on which of them it slips."""
    scene, soil, pile, _ = pileScene()
    cap = scene.add("cap", mpm.box((0.5, 2), (1, 2.5)), mpm.LinearElastic(**STEEL))
    with pytest.raises(ValueError, match=r"'cap' and '\w+' meet on the grid and no call names them"):
        scene.prepare()
    scene.contact((pile, cap), soil, friction=0.3)
    assert cap.group == pile.group != soil.group
    scene.prepare()


def testWhatSticksTogetherHasOneLaw():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    lower, upper = (
        scene.add(name, mpm.box((0, y), (1.5, y + 1)), mpm.MohrCoulomb(**SAND))
        for name, y in (("lower", 0), ("upper", 1))
    )
    wall = scene.add("wall", mpm.box((1.5, 0), (2, 2)), mpm.LinearElastic(**STEEL))
    scene.contact(wall, lower, friction=0.2)
    with pytest.raises(ValueError, match="what sticks together has one law"):
        scene.contact(wall, upper, friction=0.3)
    scene.contact(wall, upper, friction=0.2)  # the call that was refused is forgotten


@pytest.mark.parametrize("ratio, isImplicit", [(2, False), (3.9, False), (4.1, True), (8, True)])
def testAnElasticBodyIsImplicitFromFourTimesTheWaveSpeedOn(ratio, isImplicit):
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    soil = scene.add("soil", mpm.box((0, 0), (1, 1)), mpm.MohrCoulomb(**SAND))
    solid = mpm.LinearElastic(density=1.8, young=2e4 * ratio**2, poisson=0.3)
    body = scene.add("solid", mpm.box((1, 0), (2, 1)), solid)
    assert body.implicit == isImplicit and not soil.implicit
    body.implicit = not isImplicit  # what the user sets stays
    scene.prepare()
    assert body.implicit != isImplicit


def block(scene, name="block", lower=(0, 0), **options):
    upper = tuple(np.add(lower, 1.0))
    return scene.add(name, mpm.box(lower, upper), mpm.LinearElastic(**STEEL), **options)


@pytest.mark.parametrize(
    "call, error",
    [
        (lambda s, b: s.fix(), "give names"),
        (lambda s, b: s.fix("botom"), "did you mean 'bottom'"),
        (lambda s, b: (s.fix("bottom"), s.roller("bottom")), "is fixed already"),
        (lambda s, b: s.roller(3), "give names"),
        (lambda s, b: s.contact(b, b), "on both sides"),
        (lambda s, b: s.contact(b, "soil"), "give a body"),
        (lambda s, b: s.contact(b, ()), "empty"),
        (lambda s, b: s.contact(b, block(s, "other", (1, 0)), friction=-1), "friction = -1"),
        (lambda s, b: s.drive(3, (0, 0)), "give a body"),
        (lambda s, b: s.drive(b, (0, 0, 0)), "velocity"),
        (lambda s, b: s.record("x.vtkhdf", every=0), "every = 0"),
        (lambda s, b: s.history(every=-1), "every = -1"),
        (lambda s, b: s.quasiStatic(), "call scene.history"),
    ],
)
def testWrongCallsAreTold(call, error):
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    with pytest.raises((ValueError, TypeError), match=error):
        call(scene, block(scene))


def testAChainWithoutTheEngineThatACallEditedIsRefused():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, gravity=9.81, threads=1)
    block(scene)
    with pytest.raises(ValueError, match="without the GridSolver"):
        scene.engines = chain()


def testARestartGoesOnBitByBit():
    scene, *_ = pileScene()
    scene.history(every=0.01)
    scene.run(steps=10, progress=False)
    restarted(scene, 10)


def testAnEngineOfTheUserMayStandBeforeOneThatTheSceneHasAdded():
    """The scene has put ImplicitBodies behind the GridSolver, where the user puts a Contact."""

    def kinds(place):
        scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
        ground = mpm.box((0, 0), (3, 1))
        scene.add("ground", ground, mpm.LinearElastic(**STEEL), mpm.APDI(size=0.125), group="ground")
        block(scene, lower=(1, 1), particles=mpm.APDI(size=0.125), implicit=True, group="block")
        scene.criticalTimeStep()
        scene.engines.insert(place, mpm.Contact(friction=0.3))
        scene.run(steps=2, progress=False)
        return [type(engine).__name__ for engine in scene.engines]

    assert kinds(2) == kinds(3) and kinds(2)[1:4] == ["GridSolver", "ImplicitBodies", "Contact"]


def testADrivenPartKeepsItsParticles():
    """A block sinks out of the part above 1.5 m: what is driven stays driven, and by height it is let go."""

    def speed(byHeight):
        scene = mpm.Scene((0, 0), (2, 3), cell=0.25, threads=1)
        body = scene.add("block", mpm.box((0.5, 1), (1.5, 2)), mpm.LinearElastic(**STEEL), implicit=False)
        scene.drive(body.above(1.75), velocity=(0, -1.0), byHeight=byHeight)
        scene.run(until=0.5, progress=False)
        return body.position[:, 1].max(), np.abs(body.velocity[:, 1] + 1).max()

    lowest, error = speed(False)
    assert lowest < 1.5 and error < 0.05
    high, _ = speed(True)
    assert high > lowest  # let go at 1.75 m, it is not at the speed of the drive
    with pytest.raises(ValueError, match="no particle"):
        scene = mpm.Scene((0, 0), (2, 3), cell=0.25, threads=1)
        scene.drive(block(scene).above(2.5), velocity=(0, 1))


def testAWholeBodyIsDrivenAsAWhole():
    """No list of particles: pieces that are cut off belong to it, and contact knows that all of it moves."""
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    body = block(scene)
    assert scene.drive(body, velocity=(0, -1)).part.ids is None
    assert len(scene.drive(body.above(0.5), velocity=(0, -1)).part.ids) == body.count // 2


@pytest.mark.parametrize("flow", [mpm.box((0, 1), (1.5, 2)), (mpm.box((0, 1.5), (0.5, 2)), 0.5), "pile"])
def testSoilIsBoxesWhereItFlowsAndAMeshElsewhere(flow):
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, gravity=9.81, damping=0.05, threads=1)
    scene.fix("bottom")
    scene.roller("left", "right")
    hole = mpm.box((0, 1.5), (0.5, 2))
    pile = scene.add("pile", hole, mpm.LinearElastic(**STEEL))
    flow = (pile, 0.5) if flow == "pile" else flow
    soil = scene.add("soil", mpm.box((0, 0), (3, 2)) - hole, mpm.MohrCoulomb(**SAND), flow=flow)
    rest = scene["soil (mesh)"]
    assert isinstance(soil.type, mpm.UGIMP) and isinstance(rest.type, mpm.APDI) and rest.type.matched is soil
    assert soil.initialVolume.sum() + rest.initialVolume.sum() == pytest.approx(6 - 0.25)
    assert np.all(np.abs(soil.position - (0, 1.5)).max(axis=0) <= (1.5, 0.5))
    scene.contact(pile, soil, friction=0.3)
    assert soil.group == rest.group != pile.group
    scene.drive(pile, velocity=(0, -0.1))
    scene.run(until=0.1, progress=False)


def testWhatIsNoFlowIsTold():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    for flow in ("here", (3, 2), (mpm.box((0, 0), (1, 1)), -1)):
        with pytest.raises(TypeError, match="give the region that flows"):
            scene.add("soil", mpm.box((0, 0), (3, 2)), mpm.MohrCoulomb(**SAND), flow=flow)
    with pytest.raises(ValueError, match="together"):
        block = mpm.box((0, 0), (1, 1))
        scene.add("soil", block, mpm.MohrCoulomb(**SAND), mpm.UGIMP(perCell=2), flow=block)


def testACoarseRunFindsWhereTheSoilFlows():
    scene, soil, *_ = pileScene()
    with pytest.raises(ValueError, match="no soil of the scene"):
        mpm.geotech.flowRegion(scene)
    scene.run(until=0.3, progress=False)
    lower, upper = mpm.geotech.flowRegion(scene, strain=0.003).bounds()
    flows = soil.position[soil.plasticShearStrain > 0.003]
    assert len(flows) and np.all(flows >= lower) and np.all(flows <= upper)
    assert upper[0] < 3
    fine = mpm.Scene((0, 0), (3, 3), cell=0.125, threads=1)
    zone = mpm.geotech.flowRegion(scene, strain=0.003)
    soil = fine.add("soil", mpm.box((0, 0), (3, 2)), mpm.MohrCoulomb(**SAND), flow=zone)
    assert 0 < soil.initialVolume.sum() < 6
