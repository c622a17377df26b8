# SPDX-License-Identifier: GPL-2.0-or-later
"""`scene.timing` says where threads wait."""

import time

import pytest
import yade_mpm as mpm
from yade_mpm import box

SLEEP, STEPS = 0.02, 5  # s


def block(threads, sleep=0.0):
    """A block at rest; a callback sleeps in every step."""
    scene = mpm.Scene((0, 0), (2, 2), 0.1, threads=threads, gravity=9.81)
    scene.fix("bottom")
    scene.add("block", box((0, 0), (2, 1)), mpm.LinearElastic(density=2.0, young=1e4, poisson=0.2))
    scene.engines = [*scene.engines, mpm.PyRunner(lambda: time.sleep(sleep), iterPeriod=1, label="sleeper")]
    scene.dt = 1e-4
    scene.run(steps=2, progress=False)
    before = scene.timing()
    scene.run(steps=STEPS, progress=False)
    return scene.timing().since(before)


def test_what_one_thread_does_alone_counts():
    timing = block(2, SLEEP)
    alone, busy, waiting = timing.threads["sleeper"]
    assert alone >= STEPS * SLEEP and busy == waiting == 0
    seconds, calls = timing["sleeper"]
    assert calls == STEPS and alone >= 0.99 * seconds >= 0.99 * STEPS * SLEEP
    every = list(timing.threads.values())
    assert timing.alone == pytest.approx(sum(u[0] for u in every) / sum(u[0] + u[1] for u in every))
    assert timing.imbalance >= 1 and 1 <= timing.bound <= 16
    assert timing.bound == pytest.approx(1 / (timing.alone + (1 - timing.alone) / 16))


def test_engines_share_their_loops():
    timing = block(2)
    assert timing.threads["ParticleToGrid"][1] > 0
    assert (
        sum(u[0] + (u[1] + u[2]) / 2 for u in timing.threads.values())
        >= sum(t[0] for t in timing.values()) * 0.9
    )


def test_the_table_has_a_line_of_threads():
    text = str(block(2))
    assert text.splitlines()[-1].startswith("threads: ") and "ParticleToGrid" in text
    assert str(block(1)).splitlines()[-1].startswith("threads: not measured; run on two or more; memory: ")
    assert block(1).alone is None


def test_the_bandwidth_is_what_the_particles_hold_read_and_written_in_each_step():
    scene = mpm.Scene((0, 0), (2, 2), 0.1, threads=1, gravity=9.81)
    scene.fix("bottom")
    soil = scene.add("block", box((0, 0), (2, 1)), mpm.LinearElastic(density=2.0, young=1e4, poisson=0.2))
    scene.dt = 1e-4
    assert scene.timing().bandwidth is None and "memory" not in scene.timing().line()
    scene.run(steps=STEPS, progress=False)
    timing = scene.timing()
    assert timing.memory == pytest.approx(soil.bytesPerParticle * soil.count)
    seconds = sum(seconds for seconds, _ in timing.values())
    assert timing.bandwidth == pytest.approx(2 * timing.memory * STEPS / seconds)


def test_engines_of_a_kind_have_lines_of_their_own_and_may_come_later():
    scene = mpm.Scene((0, 0), (2, 2), 0.25, threads=1, gravity=9.81)
    scene.fix("bottom")
    scene.add("block", box((0, 0), (2, 1)), mpm.LinearElastic(density=2.0, young=1e4, poisson=0.2))
    scene.engines.append(mpm.PyRunner(lambda: time.sleep(SLEEP), iterPeriod=1))
    scene.dt = 1e-4
    scene.run(steps=1, progress=False)
    before = scene.timing()
    scene.engines.append(mpm.PyRunner(lambda: None, iterPeriod=1))
    scene.run(steps=2, progress=False)
    timing = scene.timing().since(before)
    assert timing["PyRunner"][0] >= 2 * SLEEP > timing["PyRunner 2"][0]
    assert timing["PyRunner"][1] == timing["PyRunner 2"][1] == 2
