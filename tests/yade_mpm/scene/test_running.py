# SPDX-License-Identifier: GPL-2.0-or-later
"""Nothing is lost: an error or a signal leaves a checkpoint and a message, and a non-zero exit code."""

import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
import yade_mpm as mpm
import yade_mpm.base.attributes
import yade_mpm.scene.scene
from byHand import bitsOf
from processes import runPython
from runScenes import SCENE, process, smallScene


# --- signals ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("number, codes", [(signal.SIGINT, (130, -signal.SIGINT)), (signal.SIGTERM, (143,))])
@pytest.mark.parametrize(
    "script",
    [
        "scene.run(steps=10**9)",
        "scene.run(steps=10**9, background=True)\nscene.wait()",
        "scene.run(steps=10**9, background=True)\nwhile scene.running: time.sleep(0.01)",
    ],
)
def test_signals_leave_a_checkpoint_and_an_exit_code(script, number, codes):
    run = process(script)
    assert run.stdout.readline() == "go\n"
    run.send_signal(number)
    _, message = run.communicate(timeout=30)
    assert run.returncode in codes, message
    assert "interrupted at step" in message
    assert "the state is in yade_mpm.checkpoint.h5 (continue with yade_mpm.load)" in message
    scene = mpm.load("yade_mpm.checkpoint.h5", callbacks={"go": None})
    assert scene.steps >= 10
    scene.run(steps=5)


SETTLED = """
import signal, sys, threading, time
import yade_mpm as mpm
from yade_mpm import box
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = mpm.Scene((0, 0), (8, 4), 0.125)
elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
body = scene.add("a", box((0, 0), (8, 2)), elastic, mpm.UGIMP(perCell=2))
body.velocity = (1.0, -1.0)
scene.threads = 1
solver = mpm.GridSolver(gravity=(0, -9.81), roller=("left", "right"), fixed="bottom")
scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()]
"""


@pytest.mark.parametrize("recorder", [False, True])
@pytest.mark.parametrize("delay", [0.3, 0.35, 0.41])
def test_ctrl_c_in_wait_leaves_the_state_of_a_whole_step(delay, recorder):
    """It was saved while the solver stepped, for an interrupted join() took the thread for finished."""
    output = (
        "scene.engines = [*scene.engines, mpm.Recorder('out.vtkhdf', iterPeriod=3)]\n" if recorder else ""
    )
    script = (
        SETTLED + output + "scene.run(steps=10**9, background=True)\nprint('go', flush=True)\nscene.wait()"
    )
    pipes = dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    run = subprocess.Popen([sys.executable, "-c", script], **pipes)
    assert run.stdout.readline() == "go\n"
    time.sleep(delay)
    run.send_signal(signal.SIGINT)
    _, message = run.communicate(timeout=60)
    assert run.returncode in (130, -signal.SIGINT) and "interrupted at step" in message, message
    file = "out.checkpoint.h5" if recorder else "yade_mpm.checkpoint.h5"
    loaded = mpm.load(file)
    assert loaded.steps > 0
    again = SETTLED + f"scene.run(steps={loaded.steps}, progress=False)\nscene.save('whole.h5')"
    assert runPython("-c", again).returncode == 0
    bits, whole = bitsOf(file), bitsOf("whole.h5")
    assert [name for name in whole if bits[name] != whole[name]] == []


def test_ctrl_c_again_and_again_ends_a_run_whose_callback_hangs():
    script = (
        "go.dead = True\n"
        "hang = mpm.PyRunner(lambda: (print('in', flush=True), time.sleep(1000)), iterPeriod=5)\n"
        "scene.engines = [*scene.engines, hang]\nscene.run(steps=10**9, background=True)\nscene.wait()"
    )
    run = process(script)
    assert run.stdout.readline() == "in\n", run.stderr.read()
    for _ in range(40):
        time.sleep(0.3)
        if run.poll() is not None:
            break
        run.send_signal(signal.SIGINT)
    else:
        run.kill()
    assert run.wait(10) not in (0, -signal.SIGKILL)


@pytest.mark.parametrize("background", [False, True])
def test_sighup_saves_and_ends(background):
    run = process(f"scene.run(steps=10**9, background={background})\nscene.wait()")
    assert run.stdout.readline() == "go\n"
    run.send_signal(signal.SIGHUP)
    _, message = run.communicate(timeout=30)
    assert run.returncode == 128 + signal.SIGHUP, message
    assert "the state is in yade_mpm.checkpoint.h5" in message
    assert mpm.load("yade_mpm.checkpoint.h5", callbacks={"go": None}).steps >= 10


@pytest.mark.parametrize("background", [False, True])
def test_sigusr1_saves_and_the_run_goes_on(background):
    run = process(f"scene.run(steps=10**9, background={background})\nscene.wait()")
    assert run.stdout.readline() == "go\n"
    run.send_signal(signal.SIGUSR1)
    for _ in range(100):
        time.sleep(0.1)
        if os.path.exists("yade_mpm.checkpoint.h5"):
            break
    saved = mpm.load("yade_mpm.checkpoint.h5", callbacks={"go": None}).steps
    time.sleep(0.3)
    assert run.poll() is None
    run.send_signal(signal.SIGTERM)
    _, message = run.communicate(timeout=30)
    assert run.returncode == 143 and "the state is in yade_mpm.checkpoint.h5; the run goes on" in message
    assert mpm.load("yade_mpm.checkpoint.h5", callbacks={"go": None}).steps > saved > 0


BETWEEN = """
import os
import yade_mpm.scene.settling as settling
look = settling._look
def asked(scene, damping):
    if scene.steps <= {last}:
        os.kill(os.getpid(), signal.{name})
    return look(scene, damping)
settling._look = asked
solver = mpm.GridSolver(gravity=(0, -9.81), fixed="bottom")
scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater()]
print(scene.settle(checkEvery=20), scene.steps, flush=True)
"""


@pytest.mark.parametrize("name, code", [("SIGUSR1", 0), ("SIGTERM", 143), ("SIGHUP", 129), ("SIGINT", 130)])
def test_signals_between_the_runs_of_settle_are_not_lost(name, code):
    run = process(BETWEEN.format(name=name, last=30))
    told, message = run.communicate(timeout=60)
    assert run.returncode in (code, -signal.SIGINT if code == 130 else code), message
    saved = mpm.load("yade_mpm.checkpoint.h5").steps
    if code == 0:
        taken, steps = map(int, told.split())
        assert taken > 20 and steps > saved >= 20 and "; the run goes on" in message
    else:
        assert saved >= 20 and "interrupted at step" in message


def test_a_signal_behind_the_last_run_of_settle_is_not_lost():
    run = process(BETWEEN.format(name="SIGUSR1", last=10**9))
    told, message = run.communicate(timeout=60)
    steps = int(told.split()[1])
    assert run.returncode == 0 and f"step {steps}: the state is in yade_mpm.checkpoint.h5" in message


def test_what_the_user_catches_is_left_to_it_and_nohup_holds():
    run = process(
        "signal.signal(signal.SIGUSR1, lambda *_: print('mine', flush=True))\nsignal.signal(signal.SIGHUP, "
        "signal.SIG_IGN)\ngo.iterPeriod = 10**9\nprint('go', flush=True)\nscene.run(steps=10**9)"
    )
    assert run.stdout.readline() == "go\n"
    time.sleep(0.5)
    run.send_signal(signal.SIGHUP)
    run.send_signal(signal.SIGUSR1)
    assert run.stdout.readline() == "mine\n" and run.poll() is None
    assert not os.path.exists("yade_mpm.checkpoint.h5")
    run.kill()


TESTS = """
import os, signal
def test_that_is_cut_off():
    scene.engines = [*scene.engines[:-1], mpm.PyRunner(lambda: os.kill(os.getpid(), signal.SIGTERM),
        iterPeriod=5)]
    scene.run(steps=100)
def test_that_would_be_next():
    print("went on")
"""


def test_a_signal_ends_these_tests_and_is_no_test_that_failed(pytestconfig):
    """A time limit on a long run of the tests would leave a failure without a cause, of the test that it
    happened to cut off."""
    for name in ("conftest.py", "verificationRecords.py"):
        shutil.copy(pytestconfig.rootpath / "tests" / name, ".")
    with open("test_cut_off.py", "w") as file:
        file.write(SCENE + TESTS)
    tests = runPython("-m", "pytest", "-s", "test_cut_off.py")
    assert tests.returncode == 143, tests.stdout
    assert "SIGTERM in test_cut_off.py::test_that_is_cut_off" in tests.stdout
    assert "1 failed" not in tests.stdout and "went on" not in tests.stdout


def test_what_cannot_be_saved_meanwhile_is_said_and_the_run_goes_on(capsys):
    scene = smallScene()
    os.mkdir("folder")
    engine = mpm.PyRunner(lambda: os.path.isdir("folder") and os.rmdir("folder"), iterPeriod=1)
    scene.engines = [*scene.engines, engine]
    scene.run(steps=3, checkpointFile="folder/state.h5", checkpointPeriod=0)
    assert "warning: step 1: checkpoint 'folder/state.h5'" in capsys.readouterr().err and scene.steps == 3


def test_the_end_of_the_program_does_not_lose_a_background_run():
    run = process("scene.run(steps=10**9, background=True)\ntime.sleep(0.2)")
    _, message = run.communicate(timeout=30)
    assert "interrupted at step" in message and run.returncode == 0
    assert mpm.load("yade_mpm.checkpoint.h5", callbacks={"go": None}).steps > 0


def test_an_interrupt_while_nothing_can_be_written_still_interrupts(tmp_path):
    run = process("import os\nscene.run(steps=10**9, checkpointFile='gone/c.h5')", cwd=tmp_path)
    _, message = run.communicate(timeout=30)
    assert run.returncode == 1 and "FileNotFoundError: checkpoint 'gone/c.h5': there is no folder" in message
    (tmp_path / "gone").mkdir()
    run = process("scene.run(steps=10**9, checkpointFile='gone/c.h5')", cwd=tmp_path)
    assert run.stdout.readline() == "go\n"
    (tmp_path / "gone").rmdir()
    run.send_signal(signal.SIGTERM)
    _, message = run.communicate(timeout=30)
    assert run.returncode == 143 and "the state could not be saved" in message


def test_handlers_of_the_host_come_back():
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    scene = smallScene()
    scene.run(steps=1)
    scene.run(steps=1, background=True)
    scene.wait()
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
