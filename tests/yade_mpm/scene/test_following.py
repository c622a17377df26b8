# SPDX-License-Identifier: GPL-2.0-or-later
"""The automatic time step follows what callbacks and particles do, in a run and in a loop of steps alike."""

import numpy as np
import pytest
import yade_mpm as mpm
from runScenes import oneByOne, throughRun
from setups import bits
from yade_mpm.check import limits
from yade_mpm.scene.policy import LoopPolicy


def inPieces(scene, steps):
    for piece in (20, 1, steps - 21):
        scene.run(steps=piece, progress=False)


LOOPS = [throughRun, oneByOne, inPieces]


def block(change):
    """An elastic block under its weight, and a callback that is called with it in every step."""
    scene = mpm.Scene((0, 0), (4, 2), 0.25, threads=1)
    soil = mpm.LinearElastic(density=2.0, young=1e3, poisson=0.2)
    body = scene.add("block", mpm.box((0, 0), (1, 1)), soil, mpm.UGIMP())
    scene.engines[1] = mpm.GridSolver(gravity=(0, -9.81), fixed="bottom")
    scene.engines.append(mpm.PyRunner(lambda s: change(s, body), iterPeriod=1))
    return scene


def stiffer(scene, body):
    if scene.steps == 20:
        body.material.young = 16e3


def lighter(scene, body):
    if scene.steps == 20:
        body.inertiaScale = 1 / 16


def damped(scene, body):
    if scene.steps == 20:
        scene.engines[1].damping, scene.engines[2].flip = 0.8, 0.1


def longest(scene):
    return scene._core.criticalTimeStep(1e-4, 300, False)["longestStable"]


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("change", [stiffer, lighter, damped])
def test_what_a_callback_changes_counts_from_the_next_step(change, loop):
    """The step stayed for up to 5000 steps, and a block 16 times as stiff was turned inside out in five."""
    scene, expected = block(change), block(change)
    loop(scene, 120)
    throughRun(expected, 120)
    assert bits(scene) == bits(expected) and scene.time == expected.time
    assert scene.dt <= 0.95 * longest(scene)
    assert change is damped or scene.dt == pytest.approx(limits.DT_SAFETY["MUSL"] * scene.dtCritical)


@pytest.mark.parametrize("loop", LOOPS)
def test_small_changes_in_every_step_are_cheap(loop, monkeypatch):
    """Stiffness grows by 0.5 % in each of 400 steps: an estimate each would take 45 times as long."""
    scene = block(lambda s, body: setattr(body.material, "young", 1.005 * body.material.young))
    estimates, estimate = [], type(scene.stepper).estimateCriticalStep
    monkeypatch.setattr(
        type(scene.stepper),
        "estimateCriticalStep",
        lambda self, *how: estimates.append(scene.steps) or estimate(self, *how),
    )
    for _ in range(4):
        loop(scene, 100)
        assert scene.dt <= limits.DT_SAFETY["MUSL"] * longest(scene)
    assert len(estimates) <= 2 + np.log(1.005**400) / np.log(limits.DT_GROWTH)


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("share, isTold", [(0.9, True), (0.2, False)])
def test_a_step_that_was_given_is_warned_of(loop, share, isTold, capsys):
    def change(scene, body):
        if scene.steps == 20:
            body.material.young = 4e3
        if scene.steps == 21:
            body.material.young = 1e3

    scene = block(change)
    scene.criticalTimeStep()
    scene.dt = share * scene.dtStable
    loop(scene, 30)
    told = capsys.readouterr().err.splitlines()
    assert len(told) == isTold and all("now exceeds the longest stable step" in line for line in told)


@pytest.mark.parametrize("part", ["stiffening", "refining"])
def test_a_loop_of_steps_follows_growth_and_cutting_as_a_run_does(part, monkeypatch):
    """The step was estimated before the first one only; sand under USL reached four times the longest."""
    monkeypatch.setattr(limits, "DT_LEAST_PERIOD", 60)
    one, other = block(lambda s, b: None), block(lambda s, b: None)
    monkeypatch.setattr(type(one.stepper), part, lambda stepper: 1.3 if stepper._scene.steps > 40 else 1.0)
    throughRun(one, 120)
    oneByOne(other, 120)
    assert one.stepper.estimatedAt == other.stepper.estimatedAt == 100
    assert bits(one) == bits(other) and one.time == other.time


def test_cut_particles_count_as_refined():
    scene = mpm.Scene((0, 0), (8, 2), 0.5, threads=1)
    soil = mpm.LinearElastic(density=2.0, young=1.0, poisson=0.2)
    body = scene.add("soil", mpm.box((0.5, 0.5), (1.5, 1.5)), soil, mpm.UGIMP(splitAt=1.3))
    body.velocity[:, 0] = 0.5 * (body.position[:, 0] - 1)
    scene.run(steps=1)
    assert scene.stepper.refining() == 1
    before = body.count
    while body.count == before:
        scene.run(steps=10, progress=False)
    assert scene.stepper.refining() == body.count / before


def test_groups_that_part_change_the_step():
    """Contact was put among the engines, and the step stayed that of one field of velocities."""
    scene = mpm.Scene((0, 0), (4, 4), 0.25, threads=1)
    hard = mpm.LinearElastic(density=0.2, young=1e5, poisson=0.2)
    soft = mpm.LinearElastic(density=20.0, young=1e3, poisson=0.2)
    scene.add("soft", mpm.box((1, 0), (2, 1)), soft, mpm.UGIMP())
    scene.add("hard", mpm.box((1.0, 1), (2, 1.125)), hard, mpm.UGIMP(), group="hard")
    scene.engines[1] = mpm.GridSolver(gravity=(0, -9.81), fixed="bottom")
    scene.run(steps=5, progress=False)
    before = scene.dt
    scene.engines.insert(2, mpm.Contact())
    scene.step()
    assert scene.dt < 0.9 * before


def test_the_policy_of_another_loop_follows_what_was_changed_outside():
    """As a callback of YADE does, which is none of the scene's."""
    scene = block(lambda s, body: None)
    throughRun(scene, 10)
    scene.bodies[0].material.young = 16e3
    policy = LoopPolicy(scene, print)
    before = scene.dt
    assert policy.followChanges() and scene.dt < before / 3.5
    assert not policy.followChanges()
