# SPDX-License-Identifier: GPL-2.0-or-later
"""When a loop looks at the domains, estimates the critical step and saves."""

from types import SimpleNamespace

import pytest
from yade_mpm.check import limits
from yade_mpm.scene import policy


class Scene:
    """Counts what a policy asks of it."""

    def __init__(self, steps=0, estimatedAt=-1, callEvery=None):
        self.steps, self._dt, self.estimates, self.looks = steps, 1e-3, [], []
        self.allowUnstable, self._warnedOf, self.stiffest = False, set(), None
        self.dtCritical, self.dtStable, self.bodies = 1.0, 1.0, []
        self.stepper = SimpleNamespace(
            estimatedAt=estimatedAt,
            estimateCriticalStep=self.estimate,
            noteEstimate=self.noteEstimate,
            stiffening=lambda: 1.0,
        )
        period = callEvery or 1 << 30
        self.engines = [SimpleNamespace(stepsToCall=lambda scene: period - scene.steps % period)]

    def estimate(self):
        self.estimates.append(self.steps)
        return 1.0

    def noteEstimate(self):
        self.stepper.estimatedAt = self.steps


@pytest.fixture(autouse=True)
def looksAreCounted(monkeypatch):
    monkeypatch.setattr(limits, "CHECK_PERIOD", 10)
    monkeypatch.setattr(limits, "DT_PERIOD", 25)
    monkeypatch.setattr(limits, "DT_LOOK", 1 << 40)
    monkeypatch.setattr(policy, "checkInterface", lambda scene, longest: scene.looks.append(scene.steps))
    monkeypatch.setattr(policy, "distortion", lambda scene: None)


def run(scene, end, stride=1, **options):
    """Steps at which the loop stood between its steps."""
    loop, stood = policy.LoopPolicy(scene, print, stride=stride, **options), []
    while scene.steps < end:
        loop.beforeSteps()
        stood.append(scene.steps)
        scene.steps += stride if stride > 1 else min(end - scene.steps, loop.stepsToNext())
        loop.afterSteps()
    return stood


def test_the_loop_stands_where_something_is_due():
    scene = Scene()
    assert run(scene, 60) == [0, 10, 20, 25, 30, 40, 50]
    assert scene.looks == [10, 20, 30, 40, 50] and scene.estimates == [25, 50]


def test_a_callback_may_stop_the_loop_when_it_has_been_called():
    assert run(Scene(callEvery=4), 12) == [0, 4, 8, 10]


@pytest.mark.parametrize("stride", [1, 3, 7])
def test_cycles_that_need_nothing_end_at_what_is_due(stride):
    """A check is due before a cycle, a callback is called in one."""
    for callEvery, isDue in ((None, lambda s: s >= 10), (4, lambda s: s + stride >= 4)):
        scene = Scene(callEvery=callEvery)
        expected = next(k for k in range(20) if isDue(k * stride))
        assert policy.LoopPolicy(scene, print, stride=stride).cyclesToNext(stride) == expected


def test_looks_of_others_count(monkeypatch):
    """A loop that stands between two looks at growth does not take one more."""
    monkeypatch.setattr(limits, "DT_LOOK", 5)
    scene, looked = Scene(), []
    scene.stepper.stiffening = lambda: looked.append(scene.steps) or 1.0
    scene.stepper.refining = lambda: 1.0
    loop = policy.LoopPolicy(scene, print)
    assert loop.nextLook == 5
    scene.steps = 7
    loop.noteLooks(10)  # of step 5
    loop.beforeSteps()
    assert looked == [] and loop.nextLook == 10
    loop.noteLooks(-1)  # nobody has
    scene.steps = 11
    loop.beforeSteps()
    assert looked == [11] and loop.nextLook == 15


@pytest.mark.parametrize("stride", [1, 3, 7])
@pytest.mark.parametrize("cut", [21, 42, 63])
def test_a_loop_that_is_continued_does_what_one_without_a_break_does(stride, cut):
    whole, first = Scene(), Scene()
    run(whole, 105, stride)
    run(first, cut, stride)
    second = Scene(cut, first.stepper.estimatedAt)
    run(second, 105, stride)
    assert first.estimates + second.estimates == whole.estimates
    assert first.looks + second.looks == whole.looks


def test_what_was_estimated_at_this_step_is_not_estimated_again():
    scene = Scene(steps=50, estimatedAt=50)
    run(scene, 55)
    assert scene.estimates == []
    other = Scene(steps=50, estimatedAt=25)  # control
    run(other, 55)
    assert other.estimates == [50]


def test_checkpoints_take_a_hundredth_of_the_time(monkeypatch):
    now, saved = [0.0], []
    monkeypatch.setattr(policy.time, "monotonic", lambda: now[0])

    def save():
        saved.append(now[0])
        now[0] += 2.0

    loop = policy.LoopPolicy(Scene(), print, save, savePeriod=60.0)
    for _ in range(1000):
        now[0] += 1.0
        loop.afterSteps()
    assert saved[0] == 60.0 and saved[1] == pytest.approx(62.0 + 2.0 / policy.SHARE, abs=1.1)


def test_a_checkpoint_that_cannot_be_written_is_a_warning():
    said = []

    def save():
        raise OSError("no space left")

    policy.LoopPolicy(Scene(steps=7), said.append, save, savePeriod=0.0).afterSteps()
    assert said == ["warning: step 7: no space left; the run goes on"]
