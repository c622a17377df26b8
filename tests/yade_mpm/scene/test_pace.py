# SPDX-License-Identifier: GPL-2.0-or-later
"""A run that may choose its number of threads takes one while other jobs have the processors, and many when
they have gone."""

from types import SimpleNamespace

from yade_mpm.engine import Engine
from yade_mpm.scene import pace


class Clock:
    """A scene whose steps take as long as `stepTime` says for a number of threads, seen from a clock of its
    own."""

    def __init__(self, stepTime, threads=4, given=None):
        self.now, self.stepTime, self.used = 0.0, stepTime, {}
        stage = type("Stage", (), dict(stepsToCall=Engine.stepsToCall, seconds=0.0))()
        output = type(
            "Output", (), dict(stepsToCall=lambda self, scene: 5, seconds=0.0)
        )()  # called now and then: not counted
        self.scene = SimpleNamespace(
            threads=threads,
            _threads=given,
            steps=0,
            _core=SimpleNamespace(threads=0),
            engines=[stage, output],
        )
        self.pace = pace.Pace(self.scene, lambda: self.now)

    def run(self, seconds, slice_=0.05):
        """Share of the time that each number of threads had."""
        self.used, end = {}, self.now + seconds
        while self.now < end:
            self.pace.look()
            n = self.scene._core.threads
            self.scene.steps += int(slice_ / self.stepTime[n])
            self.now += slice_
            self.scene.engines[0].seconds += slice_
            self.scene.engines[1].seconds += 1e3 * n
            self.used[n] = self.used.get(n, 0) + slice_ / seconds
        return self.used


QUIET, BUSY = {1: 3e-3, 4: 1e-3}, {1: 2e-3, 4: 5e-3}


def test_many_threads_where_they_are_faster():
    assert Clock(QUIET).run(100)[4] > 0.97


def test_one_thread_beside_other_jobs_and_many_again_after_them():
    clock = Clock(BUSY)
    assert clock.run(100)[1] > 0.97
    clock.stepTime = QUIET
    clock.run(2 * pace.LATER)
    assert clock.run(100)[4] > 0.97
    clock.stepTime = BUSY
    clock.run(2 * pace.LATER)
    assert clock.run(100)[1] > 0.97


def test_little_difference_changes_nothing():
    assert Clock({1: 0.95e-3, 4: 1e-3}).run(100)[4] > 0.95


def test_a_number_that_was_given_is_kept():
    assert list(Clock(BUSY, given=4).run(100)) == [4]
