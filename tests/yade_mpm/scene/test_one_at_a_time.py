# SPDX-License-Identifier: GPL-2.0-or-later
"""One thread has a scene at a time, and a process made by fork can run scenes of its own."""

import multiprocessing
import signal
import threading

import numpy as np
import pytest
import yade_mpm as mpm
from processes import runPython
from yade_mpm import box


def makeScene(*engines, threads=1):
    scene = mpm.Scene((0, 0), (4, 2), 0.25, threads=threads)
    elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    body = scene.add("soft", box((0.5, 0.5), (3.5, 1.5)), elastic, mpm.UGIMP(perCell=2))
    body.velocity = (0.1, -0.2)
    scene.engines = [*scene.engines, *engines]
    return scene


@pytest.mark.parametrize("place", [1, 2, 4])
def test_a_body_added_by_a_callback_is_refused_with_what_to_do(place):
    """Between two stages it went round for ever in the solver."""

    def add(scene):
        scene.add("late", box((0, 0), (0.5, 0.25)), scene["soft"].material, mpm.UGIMP(perCell=2))

    scene = makeScene()
    chain = scene.engines
    scene.engines = [*chain[:place], mpm.PyRunner(add, iterPeriod=2), *chain[place:]]
    with pytest.raises(RuntimeError, match=r"add: a step is going on, .*; pause\(\) in the callback"):
        scene.run(steps=4, progress=False)
    assert len(scene.bodies) == 1


def test_two_threads_cannot_run_one_scene(capsys):
    begun, goOn, scene = threading.Event(), threading.Event(), makeScene()
    wait = mpm.PyRunner(lambda: (begun.set(), goOn.wait(20)), iterPeriod=3)
    scene.engines = [*scene.engines, wait]
    first = threading.Thread(target=lambda: scene.run(steps=5, progress=False), name="first")
    first.start()
    assert begun.wait(20)
    told = r"thread 'first' is at work with the scene \(run\); wait for it, or make a scene for each thread"
    elastic = scene["soft"].material
    for action in (
        lambda: scene.run(steps=5),
        scene.step,
        lambda: scene.save("a.h5"),
        scene.criticalTimeStep,
        lambda: setattr(scene, "dt", 1e-3),
        lambda: scene.run(steps=5, background=True),
    ):
        with pytest.raises(RuntimeError, match=told):
            action()
    with pytest.raises(RuntimeError, match="is at work with the scene|a step is going on"):
        scene.add("b", box((0, 0), (0.5, 0.25)), elastic, mpm.UGIMP(perCell=2))
    goOn.set()
    first.join()
    assert scene.steps == 5
    scene.run(steps=5, progress=False)
    assert scene.steps == 10


def test_two_threads_cannot_step_one_scene():
    """The process ended: an error in one of them came through the solver's threads of the other."""
    scene, told = makeScene(), []
    scene["soft"].velocity = (0, 0)
    scene.prepare()

    def step():
        try:
            scene.stepper.advance(3000)
        except RuntimeError as error:
            told.append(str(error))

    threads = [threading.Thread(target=step) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert scene.steps == 3000 * (3 - len(told))
    assert all("at work with the scene" in text for text in told), told


def test_a_run_in_the_background_keeps_its_chain_and_its_bodies():
    scene = makeScene()
    scene.run(steps=10**9, background=True, progress=False)
    for action in (
        scene.prepare,
        scene._checkTimeStep,
        lambda: scene.stepper.advance(1),
        lambda: scene.stepper.act(scene.engines[0]),
        lambda: setattr(scene["soft"], "implicit", True),
        lambda: setattr(scene["soft"], "group", "other"),
        lambda: scene.initialStress(1.6, K0=0.5),
        scene.stepper.prepare,
        scene.stepper.checkTimeStep,
        scene.stepper.estimateCriticalStep,
        scene.stepper.takeSafeDt,
        scene.stepper.actOf(scene.engines[0]),
        lambda: scene.stepper.setTime(99.0),
        lambda: scene.stepper.endStep(99.0),
        lambda: setattr(scene.stepper, "dt", 1e-9),
        lambda: scene.stepper.restore(True, 0, {}, 1e-9),
    ):
        with pytest.raises(RuntimeError, match="a run is going on in the background|is at work with the sce"):
            action()
    scene.pause()
    assert scene.time < 99 and scene.stepper.dt > 1e-6
    assert not scene["soft"].implicit and scene["soft"].group == "main"


def test_interrupts_at_any_moment_of_wait_are_nothing_but_interrupts(monkeypatch):
    """Two close to each other made it end with "release unlocked lock", while the run went on."""
    scene, count = makeScene(), 0
    scene["soft"].velocity = (0, 0)
    scene.run(steps=10**9, background=True, progress=False)
    monkeypatch.setattr(scene._loop, "interrupt", lambda number: None)
    wait = type(scene._loop).wait.__code__

    def interrupt(number, frame):
        while frame is not None and frame.f_code is not wait:
            frame = frame.f_back
        if frame is not None:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 1e-3, 2e-4)
    try:
        while count < 100:
            with pytest.raises(KeyboardInterrupt):
                scene._loop.wait()
            count += 1
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    scene.pause()


def stressOf(threads=2):
    scene = makeScene(threads=threads)
    scene.run(steps=30, progress=False)
    return scene["soft"].stress[scene["soft"].id.argsort()].tobytes()


def test_processes_made_by_fork_run_on_two_threads_to_the_same_bits():
    """They waited for ever for the threads that a run before the fork had left in the parent only."""
    mine = stressOf()
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(stressOf, [2, 2, 1, 2]).get(60) == [mine] * 4
    assert stressOf() == mine


FORK = """
import os, sys
import yade_mpm as mpm
from yade_mpm import box

def makeScene(*engines):
    scene = mpm.Scene((0, 0), (4, 2), 0.25, threads=2)
    elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
    scene.add("soft", box((0.5, 0.5), (3.5, 1.5)), elastic, mpm.UGIMP())
    scene.engines = [*scene.engines, *engines]
    return scene

def inChild(work):
    child = os.fork()
    if child == 0:
        try:
            work()
        except RuntimeError as error:
            print("refused:", error, flush=True)
            os._exit(3)
        except BaseException as error:
            print(repr(error), flush=True)
            os._exit(4)
        os._exit(0)
    print("child", os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


def forked(script):
    return runPython("-c", FORK + script)


def test_a_fork_in_a_callback_leaves_a_child_that_can_run_scenes():
    run = forked("""
def fork(scene):
    inChild(lambda: makeScene().run(steps=20, progress=False))

scene = makeScene(mpm.PyRunner(fork, iterPeriod=10))
scene.run(steps=20, progress=False)
print("parent", scene.steps)
""")
    assert run.stdout.split() == ["child", "0", "child", "0", "parent", "20"], run.stdout + run.stderr


def test_a_scene_that_ran_in_the_background_at_the_fork_is_refused_in_the_child():
    run = forked("""
scene = makeScene()
scene.run(steps=10**9, background=True)
while scene.steps < 100:
    pass
inChild(lambda: scene.run(steps=20, progress=False))
inChild(lambda: makeScene().run(steps=20, progress=False))
scene.pause()
inChild(lambda: scene.run(steps=20, progress=False))
""")
    assert (
        "refused: run: thread 'yade_mpm run' was at work with the scene (run) when this process was forked"
        in run.stdout
    )
    assert [line for line in run.stdout.splitlines() if line.startswith("child")] == [
        "child 3",
        "child 0",
        "child 0",
    ], run.stdout + run.stderr


@pytest.mark.parametrize(
    "arguments, told",
    [
        (dict(tolerance=np.nan), "settle: tolerance = nan is not allowed; give a positive number"),
        (dict(tolerance=0), "settle: tolerance = 0 is not allowed"),
        (dict(checkEvery=0), "settle: checkEvery = 0 is not allowed; give a whole number from 1 on"),
        (dict(maxSteps=1.5), "settle: maxSteps = 1.5 is not allowed"),
        (dict(damping=-1), "settle: damping = -1 is not allowed; give a number from 0 to 1"),
    ],
)
def test_settling_by_numbers_that_have_no_meaning_is_refused(arguments, told):
    with pytest.raises(ValueError, match=told):
        makeScene().settle(**arguments)
