# SPDX-License-Identifier: GPL-2.0-or-later
"""A loop of one's own steps a scene through `scene.stepper`, with the same bits as `scene.run`."""

import signal
import time
from math import nan

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import refused
from runScenes import oneByOne, throughRun
from setups import bits, chain, soft
from yade_mpm import box
from yade_mpm.check import limits
from yade_mpm.scene.policy import LoopPolicy


def falling(scheme="MUSL"):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=scheme)
    material = mpm.LinearElastic(density=2.0, young=1e3, poisson=0.2)
    scene.add("block", box((0.5, 0), (1.5, 1)), material, mpm.UGIMP())
    scene.engines = chain(gravity=(0, -9.81), fixed="bottom")
    return scene


def atOnce(scene, steps):
    scene.prepare()
    scene.stepper.advance(steps)


def engineByEngine(scene, steps):
    scene.prepare()
    for _ in range(steps):
        for engine in scene.engines:
            scene.stepper.act(engine)
        scene.stepper.endStep(scene.time + scene.stepper.dt)


def withThePolicy(scene, steps):
    scene.prepare()
    policy = LoopPolicy(scene, say=print)
    end = scene.steps + steps
    while scene.steps < end:
        policy.beforeSteps()
        scene.stepper.advance(min(end - scene.steps, policy.stepsToNext()))
        policy.afterSteps()


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
@pytest.mark.parametrize("loop", [atOnce, oneByOne, engineByEngine, withThePolicy])
def test_every_loop_gives_the_same_bits(loop, scheme):
    one, other = falling(scheme), falling(scheme)
    throughRun(one, 30)
    loop(other, 30)
    assert bits(one) == bits(other) and (one.steps, one.time) == (other.steps, other.time)
    other.step()
    assert bits(one) != bits(other)  # control


@pytest.mark.parametrize("loop, isSame", [(withThePolicy, True), (atOnce, False)])
def test_a_loop_with_the_policy_estimates_the_critical_step_when_a_run_does(loop, isSame, monkeypatch):
    monkeypatch.setattr(limits, "DT_PERIOD", 10)
    one, other = falling(), falling()
    for scene in (one, other):
        scene.run(steps=5, progress=False)
        scene["block"].stress[...] = -50.0 * np.eye(3)
    throughRun(one, 40)
    loop(other, 40)
    assert (one.stepper.estimatedAt == other.stepper.estimatedAt == 40) == isSame
    assert not isSame or bits(one) == bits(other)


def test_a_change_is_seen_before_the_next_step():
    scene = falling()
    assert not scene.stepper.isReady
    scene.prepare()
    assert scene.stepper.isReady and scene.stepper.isPrepared
    scene["block"].inertiaScale = 4.0
    assert not scene.stepper.isReady  # the critical step is another one
    scene.prepare()
    scene.threads = 1
    assert not scene.stepper.isPrepared and scene.stepper.isChecked
    scene.prepare()
    scene.engines.append(mpm.PyRunner("pass", iterPeriod=1))
    assert not scene.stepper.isReady


def test_another_program_that_has_the_scene_is_asked():
    scene, asked = falling(), []

    class Loop:
        def isAlive(self):
            return True

        def isThisThread(self):
            return False

        def stop(self):
            asked.append("stop")

        def wait(self):
            asked.append("wait")

    scene._handOver(Loop())
    with pytest.raises(RuntimeError, match="a run is going on in the background"):
        scene.step()
    scene.pause()
    assert asked == ["stop", "wait"] and scene.running
    scene._handOver(None)
    scene.step()
    assert scene.steps == 1 and not scene.running


@pytest.mark.parametrize("loop", [mpm.UGIMP, 1, "a", object()])
def test_what_is_no_loop_is_not_given_the_scene(loop):
    """It was taken, and everything else then failed for want of isAlive."""
    scene = falling()
    with pytest.raises(TypeError, match="handOver: loop = .* is not allowed; give an object with isAlive"):
        scene._handOver(loop)
    if not callable(loop):
        told = "Stepper: onChange = ... is not allowed; give a function, or None"
        refused(told, lambda: setattr(scene.stepper, "onChange", loop), TypeError)
    scene.step()


def test_an_engine_that_is_not_on_turn_is_refused():
    """Without the particles' places in the grid it went round for ever, or crashed."""
    scene = falling()
    act = scene.stepper.act
    refused("Stepper.act: GridSolver( ... not in the chain as it was prepared", lambda: act(scene.engines[1]))
    scene.prepare()
    act(scene.engines[0])
    scene.stepper.endStep(scene.dt)
    told = "GridToParticle cannot act before ParticleToGrid has found the part"
    refused(told, lambda: act(scene.engines[2]))
    refused("is not in the chain", lambda: act(mpm.GridSolver()))
    scene.engines[0].dead = True
    told = "do not leave that out (dead), and act in the order of scene.eng"
    refused(told, lambda: scene.run(steps=2, progress=False))


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.add("late", box((0, 1), (0.5, 1.5)), s["block"].material, mpm.UGIMP()),
        lambda s: setattr(s["block"], "group", "other"),
        lambda s: s.engines.append(mpm.PyRunner("pass", iterPeriod=1)),
    ],
)
def test_a_scene_that_is_not_prepared_as_it_stands_is_not_stepped(change):
    """It went on with its old chain and groups; a scene that was never prepared took no step."""
    scene, told = falling(), "the scene is not prepared, or has changed since"
    with pytest.raises(RuntimeError, match=f"Stepper.advance: {told}"):
        scene.stepper.advance(1)
    scene.prepare()
    scene.stepper.advance(1)
    change(scene)
    with pytest.raises(RuntimeError, match=f"Stepper.advance: {told}"):
        scene.stepper.advance(1)
    with pytest.raises(RuntimeError, match=f"Stepper.act: {told}"):
        scene.stepper.act(scene.engines[0])
    scene.prepare()
    scene.stepper.advance(1)
    assert scene.steps == 2


@pytest.mark.parametrize(
    "action",
    [
        lambda s: s.stepper.advance(1),
        lambda s: s.stepper.act(s.engines[-1]),
        lambda s: s.prepare(),
        lambda s: s._checkTimeStep(),
        lambda s: setattr(s["block"], "implicit", True),
        lambda s: setattr(s["block"], "group", "other"),
        lambda s: s["block"].convertTo(s["block"]),
        lambda s: [s.engines.pop(), s.criticalTimeStep()],
    ],
)
def test_a_callback_cannot_step_the_scene_nor_change_what_a_step_is_made_of(action):
    scene = falling()
    scene.engines = [*scene.engines, mpm.PyRunner(action, iterPeriod=1)]
    with pytest.raises(RuntimeError, match="a step is going on"):
        scene.run(steps=3, progress=False)


def test_what_a_callback_does_to_the_list_of_engines_counts_from_the_next_step():
    """The run went on with the replaced engines, and their list said something else."""
    scene = falling()
    history = mpm.History(iterPeriod=1)
    runner = mpm.PyRunner(lambda s: s.engines.append(history) if s.steps == 2 else None, iterPeriod=1)
    scene.engines = [*scene.engines, runner]
    scene.run(steps=5, progress=False)
    assert history["step"].tolist() == [3, 4, 5]
    scene.engines[-1] = mpm.PyRunner(lambda s: s.engines.clear(), iterPeriod=1)
    with pytest.raises(ValueError, match="missing among the engines"):
        scene.run(steps=3, progress=False)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, "1", None])
def test_clocks_and_steps_that_cannot_be_are_refused(value):
    scene = falling()
    scene.prepare()
    for what, change in {
        "dt": lambda: setattr(scene.stepper, "dt", value),
        "setTime": lambda: scene.stepper.setTime(value),
        "endStep": lambda: scene.stepper.endStep(value),
        "advance": lambda: scene.stepper.advance(value),
    }.items():
        with pytest.raises(ValueError, match=f"Stepper.*{what}.*is not allowed; give"):
            change()
    assert (scene.time, scene.steps) == (0, 0)


@pytest.mark.parametrize("field", ["mass", "volume"])
@pytest.mark.parametrize("way", ["callback", "loop"])
def test_particles_without_matter_end_the_next_step(field, way):
    """The next stress update hid a volume of -1; the forces of one step had the wrong sign."""
    scene = falling()

    def change(scene):
        if scene.steps == 2:
            getattr(scene["block"], field)[3] = -1.0

    if way == "callback":
        scene.engines = [*scene.engines, mpm.PyRunner(change, iterPeriod=1)]
    with pytest.raises(RuntimeError, match=rf"step 2: body 'block': {field} = -1 of entry 3 is not positive"):
        if way == "callback":
            scene.run(steps=10, progress=False)
        for _ in range(10):
            scene.step()
            change(scene)


def test_what_the_last_step_of_a_run_has_left_is_looked_at():
    """A body that its neighbour blew away had volumes below zero, and the run had gone well."""
    scene = mpm.Scene((0, 0), (4, 4), 0.5)
    elastic = soft()
    boxes = scene.add("boxes", box((1, 1), (2, 2)), elastic, mpm.UGIMP())
    scene.add("mesh", box((2, 1), (3, 2)), elastic, mpm.APDI(size=0.5, matched=boxes)).stretchZZ = 1e30
    with pytest.raises(RuntimeError, match="step 2: body 'boxes': volume = -.* is not positive"):
        scene.run(steps=2, progress=False)


@pytest.mark.parametrize(
    "name", ["constraints", "acting", "estimatedAt", "estimatedStiffness", "automaticDt"]
)
def test_what_a_stepper_knows_is_read_only(name):
    """`acting` that was set by hand stopped a run with an error of Python."""
    scene = falling()
    scene.run(steps=2, progress=False)
    before = getattr(scene.stepper, name)
    with pytest.raises(AttributeError, match=f"Stepper: {name} can be read, not set"):
        setattr(scene.stepper, name, 7)
    if isinstance(before, (list, dict)):
        assert before
        getattr(scene.stepper, name).clear()
    assert getattr(scene.stepper, name) == before
    scene.run(steps=2, progress=False)


@pytest.mark.parametrize(
    "wrong",
    [
        {"isChecked": 1},
        {"estimatedAt": "a"},
        {"estimatedAt": -2},
        {"estimatedAt": 3},
        {"estimatedStiffness": [1.0]},
        {"estimatedStiffness": {"block": 1.0}},
        {"estimatedStiffness": {"block": [1.0, 1.0]}},
        {"estimatedStiffness": {"block": [1.0, nan, 1.0]}},
        {"automaticDt": 0.0},
        {"automaticDt": "0.1"},
    ],
)
def test_an_estimate_that_no_scene_has_is_not_restored(wrong):
    scene = falling()
    scene.run(steps=2, progress=False)
    stepper, three = scene.stepper, [1e4, 1e3, 16.0]
    right = {"isChecked": True, "estimatedAt": 2, "estimatedStiffness": {"block": three}, "automaticDt": None}
    stepper.restore(**right)
    with pytest.raises(ValueError, match=f"Stepper.restore: .*{next(iter(wrong))} = .* is not allowed; give"):
        stepper.restore(**{**right, **wrong})


def test_ctrl_c_comes_through_between_two_steps():
    one, other = falling(), falling()
    one.prepare()
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(KeyboardInterrupt):
            one.stepper.advance(10**9)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    atOnce(other, one.steps)
    assert bits(one) == bits(other)


def test_steps_end_behind_the_time_that_they_are_given():
    one = falling()
    one.prepare()
    began = time.monotonic()
    one.stepper.advance(10**9, seconds=0.3)
    assert 0.3 <= time.monotonic() - began < 5 and one.steps > 0
