# SPDX-License-Identifier: GPL-2.0-or-later
"""A file of results has one owner: the engine whose run began last, of one process."""

import gc
import os
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest
import yade_mpm as mpm

LOST = "belongs to another scene, which has written to it since; go on with that one"
OF_ANOTHER_PROCESS = """
import sys
sys.path += sys.argv[1:]
import test_owners
scene = test_owners.makeScene(test_owners.history())
test_owners.run(scene)
print("written", flush=True)
sys.stdin.read()
"""


def makeScene(*engines):
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    scene.add("a", mpm.box((0, 0), (1, 1)), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.UGIMP())
    solver = mpm.GridSolver(gravity=(0, -10), fixed="bottom", label="solver")
    scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater(), *engines]
    return scene


def history():
    return mpm.History(iterPeriod=1, file="a.csv")


def run(scene, steps=3):
    scene.run(steps=steps, progress=False)


def stepsInFile():
    with open("a.csv") as f:
        return [int(line.split(",")[1]) for line in f.readlines()[1:]]


def test_after_undo_the_replaced_scene_writes_no_more():
    """Rows and frames of both alternated, without an error."""
    scene = makeScene(history(), mpm.Recorder("a.vtkhdf", iterPeriod=1))
    run(scene)
    scene.save("a.h5")
    run(scene)
    back = mpm.undo(scene)
    run(back)
    with pytest.raises(RuntimeError, match=LOST):
        run(scene)
    run(back)
    assert stepsInFile() == list(range(1, 10)) and list(mpm.read("a.vtkhdf").steps) == list(range(10))


def test_two_scenes_do_not_share_a_csv():
    one, two = makeScene(history()), makeScene(history())
    run(one)
    run(two)
    with pytest.raises(RuntimeError, match=LOST):
        run(one)
    assert stepsInFile() == [1, 2, 3]


def test_a_file_that_a_run_in_the_background_writes_is_refused():
    one, two = makeScene(history()), makeScene(history())
    one.run(steps=10**8, background=True, progress=False)
    while not one.steps:  # until it has begun
        time.sleep(0.001)
    with pytest.raises(RuntimeError, match="another scene, which is writing to it"):
        run(two)
    one.pause()
    one.wait()


def test_a_scene_that_is_gone_owns_nothing():
    one, two = makeScene(history()), makeScene(history())
    run(one)
    run(two)
    del two
    gc.collect()
    run(one)
    assert stepsInFile() == [1, 2, 3, 4, 5, 6]


@contextmanager
def anotherProcess():
    """A process that has run a scene, and has not ended."""
    words = [sys.executable, "-c", OF_ANOTHER_PROCESS, os.path.dirname(__file__)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "written\n"
        yield


def test_a_csv_that_another_process_writes_is_refused_until_it_ends():
    scene = makeScene(history())
    with anotherProcess(), pytest.raises(RuntimeError, match="'a.csv' is written by another process"):
        run(scene)
    run(scene)


def test_a_csv_that_another_process_has_begun_meanwhile_is_refused():
    scene = makeScene(history())
    scene.prepare()  # when the file is not there yet
    with anotherProcess(), pytest.raises(RuntimeError, match="is written by another process"):
        run(scene)


def test_files_of_scenes_that_are_gone_are_not_kept_open():
    run(makeScene(history()))
    gc.collect()
    left = [os.path.realpath(f"/proc/self/fd/{n}") for n in os.listdir("/proc/self/fd")]
    assert not [name for name in left if name.endswith("a.csv")]
