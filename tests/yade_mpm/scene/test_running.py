# SPDX-License-Identifier: GPL-2.0-or-later
"""Nothing is lost: an error or a signal leaves a checkpoint and a message, and a non-zero exit code."""

import gc
import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
import weakref

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
import yade_mpm.base.attributes
import yade_mpm.scene.scene
from setups import chain
from yade_mpm import box

SCENE = """
import signal, sys, time
import yade_mpm as mpm
from yade_mpm import box
# which Python leaves out where the tests run in the background
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = mpm.Scene((0, 0), (2, 2), 0.25)
scene.add("a", box((0.5, 0), (1.5, 1)), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.UGIMP())
go = mpm.PyRunner(lambda: print("go", flush=True), iterPeriod=10, label="go")
scene.engines = [*scene.engines, go]
"""


@pytest.fixture(autouse=True)
def inItsOwnFolder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def smallScene(*engines, velocity=(0.0, 0.0)):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add(
        "soft", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.UGIMP()
    )
    body.velocity = velocity
    scene.engines = [*scene.engines, *engines]
    return scene


def pulledMesh(onDistortion):
    """A mesh of four large domains, one of which has a corner pulled almost to its diagonal."""
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add(
        "mesh",
        box((0.5, 0.5), (1.5, 1.5)),
        mpm.LinearElastic(density=1.3, lame=(1e3, 1e3)),
        mpm.APDI(size=0.5, onDistortion=onDistortion),
    )
    body.velocity = (0.3, -0.2)
    body.stress = np.diag([-3.0, -5.0, -4.0])
    body.vertices[0] += 0.247
    scene.dt = 1e-4
    return scene


def process(script, **options):
    environment = dict(os.environ, PYTHONPATH=os.path.dirname(os.path.dirname(mpm.__file__)))
    return subprocess.Popen(
        [sys.executable, "-c", SCENE + script],
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        **options,
    )


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
    assert (
        "interrupted at step" in message
        and "the state is in yade_mpm.checkpoint.h5 (continue with yade_mpm.load)" in message
    )
    scene = mpm.load("yade_mpm.checkpoint.h5", callbacks={"go": None})
    assert scene.steps >= 10
    scene.run(steps=5)


def bitsOf(file):
    """Arrays and clock of a checkpoint."""
    with h5py.File(file, "r") as h5:
        bits = {}
        h5.visititems(
            lambda name, data: bits.update({name: data[...].tobytes()}) if hasattr(data, "dtype") else None
        )
    return {name: values for name, values in bits.items() if name != "scene"}


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
    environment = dict(os.environ, PYTHONPATH=os.path.dirname(os.path.dirname(mpm.__file__)))
    pipes = dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
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
    subprocess.run([sys.executable, "-c", again], check=True, timeout=100, env=environment)
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
        "signal.signal(signal.SIGUSR1, lambda *_: print('mine', flush=True))\n"
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)\ngo.iterPeriod = 10**9\nprint('go', flush=True)\n"
        "scene.run(steps=10**9)"
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
    environment = dict(os.environ, PYTHONPATH=os.path.dirname(os.path.dirname(mpm.__file__)))
    tests = subprocess.run(
        [sys.executable, "-m", "pytest", "-s", "test_cut_off.py"],
        env=environment,
        text=True,
        capture_output=True,
        timeout=60,
    )
    assert tests.returncode == 143, tests.stdout
    assert "SIGTERM in test_cut_off.py::test_that_is_cut_off" in tests.stdout
    assert "1 failed" not in tests.stdout and "went on" not in tests.stdout


WITH_FILES = """
import os
def end(s):
    if s.steps == killedAt: os.kill(os.getpid(), 9)
scene["a"].velocity = (0.3, 0.0)
scene.engines = [*scene.engines[:-1], mpm.Recorder("out.vtkhdf", period=0.2),
    mpm.History(iterPeriod=7, file="out.csv"),
                 mpm.PyRunner(end, iterPeriod=50, label="end")]
scene.dt = 1e-3
mpm.scene.policy.SHARE = 1e6
"""


def results():
    with h5py.File("out.vtkhdf") as file, open("out.csv") as table:
        return (
            file["VTKHDF/Steps/Values"][:].tolist(),
            file["VTKHDF/CellData/velocity"][:].tobytes(),
            table.read(),
        )


def test_a_killed_run_goes_on_from_what_was_saved_meanwhile():
    """SIGKILL, as where power fails: no handler is asked."""
    whole = process("killedAt = -1\n" + WITH_FILES + "scene.run(steps=300)")
    assert (
        whole.wait(timeout=30) == 0
        and not os.path.exists("yade_mpm.checkpoint.h5")
        and not os.path.exists("out.checkpoint.h5")
    )
    expected = results()
    killed = process("killedAt = 150\n" + WITH_FILES + "scene.run(steps=300, checkpointPeriod=0)")
    assert killed.wait(timeout=30) == -signal.SIGKILL
    scene = mpm.load("out.checkpoint.h5", callbacks={"end": None})
    assert 100 < scene.steps < 150
    scene.run(steps=300 - scene.steps)
    assert results() == expected


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


# --- errors -----------------------------------------------------------------------------------------------
def test_a_particle_that_leaves_the_grid_ends_the_run_and_is_named(capsys):
    scene = smallScene(velocity=(0.0, -20.0))
    with pytest.raises(
        RuntimeError,
        match=r"step \d+: particle \d+ of 'soft' at \(.*\) is outside the grid \(0, 0\) to \(2, 2\); "
        r"enlarge the grid",
    ):
        scene.run(until=1.0)
    assert f"the run failed at step {scene.steps}" in capsys.readouterr().err
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the state is that between two steps
        loaded = mpm.load("yade_mpm.checkpoint.failed.h5")
    assert loaded.steps == scene.steps and np.array_equal(loaded["soft"].position, scene["soft"].position)


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_an_inverted_domain_ends_the_run_and_is_named(scheme, recwarn):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=scheme)
    body = scene.add(
        "mesh", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(density=1.3, lame=(1e3, 1e3)), mpm.APDI()
    )
    scene.dt = 1e-4
    scene.run(steps=3)
    body.vertices[6] += 0.15
    with pytest.raises(
        RuntimeError,
        match=r"step \d: domain of particle 5 in 'mesh' at \(.*\) is (nearly )?inverted .*; use UGIMP there, "
        r'or APDI\(onDistortion="convert"\)',
    ):
        scene.run(steps=5)
    recwarn.clear()
    loaded = mpm.load("yade_mpm.checkpoint.failed.h5")
    assert np.array_equal(loaded["mesh"].vertices, body.vertices)
    assert [str(w.message)[:10] for w in recwarn] == (["checkpoint"] if scheme == "USF" else []), (
        "USF ends it within the step"
    )


@pytest.mark.parametrize("onDistortion", ["stop", "convert"])
def test_a_distorted_domain_is_warned_of_once_before_it_ends_the_run(onDistortion, capsys):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add(
        "mesh",
        box((0.5, 0.5), (1.5, 1.5)),
        mpm.LinearElastic(density=1.3, lame=(1e3, 1e3)),
        mpm.APDI(onDistortion=onDistortion),
    )
    scene.dt = 1e-6
    scene.run(steps=1)
    start = body.vertices[0].copy()
    body.vertices[0] = start + 0.44 * 0.25  # corner (1 - 2 a)/(1 - a) of the area = 0.214
    scene.run(steps=1)
    assert capsys.readouterr().err == "" and body.distortedCount == mpm.diagnostics.distortedCount(scene) == 0
    body.vertices[0] = start + 0.46 * 0.25  # 0.148
    scene.run(steps=1)
    said = capsys.readouterr().err
    assert body.distortedCount == mpm.diagnostics.distortedCount(scene) == 1
    assert (
        "warning: step 3: a domain of 'mesh' distorted, most that of particle 0 at (0.6" in said
        and "smallest corner 14.8 % of its area" in said
    )
    assert ("at 5 % the run stops; use UGIMP there, or APDI(onDistortion" in said) == (onDistortion == "stop")
    scene.run(steps=1)
    assert capsys.readouterr().err == ""


def test_domains_are_looked_at_every_thousand_steps(capsys):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    body = scene.add(
        "mesh", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(density=1.3, lame=(1e3, 1e3)), mpm.APDI()
    )

    def distort():
        body.vertices[0] += 0.46 * 0.25 * (1 if scene.steps == 500 else -1)

    scene.engines = [*scene.engines, mpm.PyRunner(distort, iterPeriod=500, label="distort")]
    scene.dt = 1e-9
    scene.run(steps=1001)
    assert capsys.readouterr().err == ""  # there and back between two looks
    body.vertices[0] += 0.46 * 0.25
    scene.engines[-1].dead = True
    scene.run(steps=1500)
    assert "warning: step 2000: a domain of 'mesh' distorted" in capsys.readouterr().err


def test_conversion_conserves_mass_momentum_volume_and_stress():
    stopped, converted = pulledMesh("stop"), pulledMesh("convert")
    with pytest.raises(RuntimeError, match="inverted"):
        stopped.run(steps=1)
    converted.run(steps=1)
    assert converted["mesh"].converted == 1 and converted["mesh (converted)"].count > 0
    assert converted.particleCount == stopped.particleCount - 1 + 9, (
        "nine particles took the place of a domain"
    )
    for before, after in zip(totals(stopped), totals(converted)):
        scale = np.abs(before).max()
        assert np.abs(after - before).max() <= 1e-12 * scale
        assert np.abs(after * (1 + 1e-11) - before).max() > 1e-12 * scale, "the control"


MOVED = """
import numpy as np, sys
import yade_mpm as mpm
scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=sys.argv[1])
near = scene.add("boxes", mpm.box((1.5, 0.5), (1.75, 1.5)), mpm.LinearElastic(density=1.3, lame=(1e3, 1e3)),
                 mpm.UGIMP(perCell=2))
apdi = mpm.APDI(size=0.25, matched=near, onDistortion="convert")
mesh = scene.add("mesh", mpm.box((0.5, 0.5), (1.5, 1.5)), near.material, apdi)
mesh.velocity = near.velocity = (0.3, -0.2)
mesh.vertices[0] += 0.124
scene.dt, scene.threads = 1e-6, 2
scene.run(steps=5, progress=False)
before = np.vstack([b.byId("position") for b in scene.bodies])
scene.run(steps=20, progress=False)
assert mesh.converted == 1 and scene["mesh (converted)"].count > 0
for body in scene.bodies:
    assert np.abs(body.velocity - (0.3, -0.2)).max() < 1e-5, f"{body.name}: {body.velocity}"
moved = np.vstack([b.byId("position") for b in scene.bodies]) - before
assert np.abs(moved - 20e-6 * np.array((0.3, -0.2))).max() < 1e-9
"""


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_pieces_of_a_converted_domain_move_on_as_it_did(scheme):
    """In a process of its own: converted within a step, as under USF, it went round for ever."""
    environment = dict(os.environ, PYTHONPATH=os.path.dirname(os.path.dirname(mpm.__file__)))
    out = subprocess.run([sys.executable, "-c", MOVED, scheme], env=environment, timeout=60)
    assert out.returncode == 0


def totals(scene):
    """Mass, momentum, volume, volume times stress, and centre of mass of all bodies."""
    sums = [0, 0, 0, 0, 0]
    for b in scene.bodies:
        for k, values in enumerate(
            (
                b.mass,
                b.mass[:, None] * b.velocity,
                b.volume,
                b.volume[:, None, None] * b.stress,
                b.mass[:, None] * b.position,
            )
        ):
            sums[k] = sums[k] + values.sum(axis=0)
    return sums


def test_an_error_in_a_callback_ends_the_run(capsys):
    def fail():
        raise ZeroDivisionError("mine")

    scene = smallScene(mpm.PyRunner(fail, iterPeriod=5))
    with pytest.raises(ZeroDivisionError, match="mine"):
        scene.run(steps=100)
    assert scene.steps == 5 and "the run failed at step 5" in capsys.readouterr().err
    assert mpm.load("yade_mpm.checkpoint.failed.h5", callbacks={"fail": None}).steps == 5
    scene.engines[-1].dead = True
    scene.run(steps=1)  # the scene is still usable


def test_leaving_the_program_in_a_callback_saves_too():
    run = process(
        "go.dead = True\nscene.engines = [*scene.engines, mpm.PyRunner('sys.exit(7)', "
        "iterPeriod=4)]\nscene.run(steps=100)"
    )
    run.communicate(timeout=30)
    assert run.returncode == 7
    assert mpm.load("yade_mpm.checkpoint.failed.h5", callbacks={"go": None}, trust=True).steps == 4


def test_errors_of_a_script_give_an_exit_code():
    run = process("scene['a'].velocity = (0.0, 100.0)\nscene.run(steps=1000)")
    _, message = run.communicate(timeout=30)
    assert run.returncode == 1 and "is outside the grid" in message


def test_a_callback_cannot_run_the_scene():
    for command in ("scene.run(steps=1)", "scene.step()"):
        with pytest.raises(RuntimeError, match="a callback cannot"):
            smallScene(mpm.PyRunner(command, iterPeriod=1)).run(steps=2)


# --- runs -------------------------------------------------------------------------------------------------
def test_a_background_run_is_waited_for_and_paused():
    scene = smallScene()
    scene.run(steps=50, background=True)
    scene.wait()
    assert scene.steps == 50 and not scene.running
    scene.run(steps=10**9, background=True)
    while scene.steps == 50:
        time.sleep(0.001)
    for forbidden in (
        lambda: scene.run(steps=1),
        scene.step,
        lambda: scene.save("x.h5"),
        scene.criticalTimeStep,
        lambda: scene.add("b", box((0, 0), (0.5, 0.5)), scene["soft"].material, mpm.UGIMP()),
    ):
        with pytest.raises(RuntimeError, match="a run is going on in the background"):
            forbidden()
    scene.pause()
    assert not scene.running
    reached = scene.steps
    time.sleep(0.05)
    assert scene.steps == reached > 50


def test_wait_raises_what_went_wrong_in_the_background(capsys):
    scene = smallScene(mpm.PyRunner("1 / 0", iterPeriod=3))
    scene.run(steps=10, background=True)
    with pytest.raises(ZeroDivisionError):
        scene.wait()
    scene.wait()  # once
    assert scene.steps == 3 and "the run failed at step 3" in capsys.readouterr().err
    assert mpm.load("yade_mpm.checkpoint.failed.h5", trust=True).steps == 3


@pytest.mark.parametrize("period", [dict(iterPeriod=7), dict(period=0.05)])
@pytest.mark.parametrize("background", [False, True])
def test_pause_in_a_callback_stops_after_that_step(period, background):
    scene = smallScene(mpm.PyRunner(lambda s: s.pause(), **period))
    stops = []
    for _ in range(3):
        scene.run(steps=10**6, background=background)
        scene.wait()
        stops.append(scene.steps if "iterPeriod" in period else scene.time)
    assert np.allclose(
        stops, [7, 14, 21] if "iterPeriod" in period else [0.05, 0.1, 0.15], rtol=0, atol=0.5 * scene.dt
    )


def test_runs_can_be_cut_in_pieces(monkeypatch):
    monkeypatch.setattr(mpm.base.limits, "DT_PERIOD", 10)
    whole, pieces = smallScene(velocity=(0.1, 0.2)), smallScene(velocity=(0.1, 0.2))
    whole.run(steps=40)
    for steps in (0, 3, 7, 1, 19, 10):
        pieces.run(steps=steps)
    assert (
        pieces.steps == 40
        and np.array_equal(whole["soft"].stress, pieces["soft"].stress)
        and whole.time == pieces.time
    )
    stepped = smallScene(velocity=(0.1, 0.2))
    for _ in range(5):
        stepped.step()
    assert stepped.steps == 5


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_loads_act_under_every_scheme_wherever_the_updater_was_put(scheme):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme=scheme)
    body = scene.add(
        "mesh", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.APDI()
    )
    scene.engines = chain(mpm.BoundaryLoad(body, traction=(1.0, 0.0)))
    scene.run(steps=10)
    assert (body.mass * body.velocity[:, 0]).sum() == pytest.approx(4.0 * scene.time, rel=0.02)


def test_vertices_and_particles_follow_the_same_nodes_under_a_load():
    """Under USL vertices move with the solution on the nodes, and so do particles with flip = 0: their
    velocity is the mean of their corners'."""
    scene = mpm.Scene((0, 0), (2, 2), 0.25, scheme="USL")
    body = scene.add(
        "mesh",
        box((0.5, 0.5), (1.5, 1.5)),
        mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)),
        mpm.APDI(size=0.25),
    )
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.BoundaryLoad(body, traction=(1.0, 2.0)),
        mpm.GridSolver(gravity=(0.0, -9.81)),
        mpm.GridToParticle(flip=0.0),
        mpm.DomainUpdater(),
    ]
    scene.dt = 1e-4
    before = body.vertices.copy()
    scene.run(steps=1)
    corners = (body.vertices - before)[body.cells].mean(axis=1) / scene.dt
    assert body.velocity == pytest.approx(corners, rel=1e-6, abs=1e-10)
    assert (body.mass[:, None] * body.velocity).sum(axis=0) == pytest.approx(
        [4.0 * scene.dt, (8.0 - 9.81) * scene.dt], rel=1e-9
    )


def test_estimates_of_the_time_step_leave_no_trace(monkeypatch):
    """Neither in the fields nor in the work of the loads, which is that on the vertices."""
    monkeypatch.setattr(mpm.base.limits, "DT_PERIOD", 5)
    scene = pulledMesh("stop")
    body = scene["mesh"]
    body.vertices[0] -= 0.247
    body.stress = 0
    scene.engines = [mpm.ParticleToGrid(), mpm.BoundaryLoad(body, traction=(1.0, 0.0)), *scene.engines[1:]]
    scene.run(steps=20)
    before = body.velocityGradient.copy(), scene._core.energies["loads"]
    scene.criticalTimeStep()
    assert np.array_equal(before[0], body.velocityGradient)
    assert before[1] == pytest.approx(4.0 * 0.3 * scene.time, rel=0.05)  # force times velocity times time


@pytest.mark.parametrize("dim", [2, 3])
def test_rates_stay_with_their_particles_where_an_estimate_sorts_these(dim):
    scene = mpm.Scene((0,) * dim, (2,) * dim, 0.25)
    body = scene.add(
        "soft", box((0.5,) * dim, (1.5,) * dim), mpm.LinearElastic(density=1.0, lame=(1e3, 1e3)), mpm.UGIMP()
    )
    body.velocity = (0.0,) * (dim - 1) + (-3.0,)
    scene.dt, sorts = 1e-3, 0
    for _ in range(150):
        scene.run(steps=1)
        ids = body.id.copy()
        body.velocityGradient = np.random.default_rng(1).normal(size=body.velocityGradient.shape)
        expected = dict(zip(ids, body.velocityGradient.copy()))
        scene.criticalTimeStep(iterations=1)
        sorts += not np.array_equal(ids, body.id)
        assert all(np.array_equal(L, expected[i]) for i, L in zip(body.id, body.velocityGradient))
    assert sorts > 0


def test_until_is_reached_and_not_passed():
    scene = smallScene()
    scene.dt = 1e-3
    scene.run(until=0.05)
    assert scene.steps == 50 and scene.time == pytest.approx(0.05)


def test_the_ramp_of_a_later_drive_counts_from_its_first_run():
    scene = smallScene()
    scene.run(until=0.5)
    drive = mpm.Drive(scene["soft"], velocity=(0.1, None), ramp=0.2)
    scene.engines = chain(drive=drive)
    start = scene.time
    scene.run(until=start + 0.1)
    assert scene["soft"].velocity[:, 0] == pytest.approx(0.05, rel=0.2)


def test_a_stretched_domain_is_converted_and_its_pieces_fill_it():
    """Domains of two cells, one edge of which is drawn out: by 14 % it stays, by 16 % it goes, in pieces of
    about a box each."""
    for stretch, converted in ((0.14, 0), (0.16, 1)):
        scene = pulledMesh("convert")
        body = scene["mesh"]
        body.vertices[0] -= 0.247  # undone
        lower = body.vertices[:, 0] < 0.51
        corner = lower & (body.vertices[:, 1] < 0.51)
        body.vertices[corner] -= (0.5 * stretch, 0)
        scene.run(steps=1)
        assert body.converted == converted
    pieces = scene["mesh (converted)"]
    assert pieces.count == 4 * 4, "mean edges of 0.54 and 0.5 m, boxes of 0.125 m"
    assert (pieces.mass > 0).all() and (pieces.volume > 0).all() and (pieces.initialVolume > 0).all()
    assert pieces.position[:, 0].min() < 0.53 and pieces.position[:, 1].max() > 0.9


def test_a_folded_domain_leaves_no_piece_without_mass():
    scene = pulledMesh("convert")
    scene["mesh"].vertices[0] += 0.2  # far beyond the diagonal: concave
    before = scene["mesh"].mass.sum()
    scene.run(steps=1)
    pieces = scene["mesh (converted)"]
    assert pieces.count == 6, "three of nine lie in the fold"
    assert (pieces.mass > 0).all() and (pieces.volume > 0).all() and (pieces.initialVolume > 0).all()
    assert scene["mesh"].mass.sum() + pieces.mass.sum() == pytest.approx(before, rel=1e-13)


def test_a_domain_turned_inside_out_is_refused_not_converted():
    scene = pulledMesh("convert")
    scene["mesh"].vertices[0] += 0.4  # far beyond the opposite corner's diagonal: the area is negative
    with pytest.raises(
        RuntimeError,
        match=r"step \d: domain of particle 0 in 'mesh' at \(.*\) turned inside out within one step "
        r"\(-.* of 0.25 m2\): its stress has no meaning and it cannot be converted; lower dt",
    ):
        scene.run(steps=1)
    assert scene["mesh"].count == 4 and scene["mesh (converted)"].count == 0


# --- views ------------------------------------------------------------------------------------------------
def test_views_never_dangle():
    scene = pulledMesh("convert")
    body = scene["mesh"]
    views = [body.position, body.stress, body.vertices, scene["mesh (converted)"].velocity]
    copies = [v.copy() for v in views]
    scene.run(steps=1)  # converts, hence resizes
    assert body.count == len(copies[0]) - 1 and [len(v) for v in views] == [len(c) for c in copies]
    kept = body.position
    expected = kept.copy()
    del scene, body
    gc.collect()
    junk = [np.full(3000, np.nan) for _ in range(300)]
    assert np.array_equal(kept, expected) and all(np.isfinite(v).all() for v in views) and junk


def test_a_body_keeps_its_scene_and_a_refused_body_is_empty():
    body = smallScene()["soft"]
    gc.collect()
    assert body.count == 64 and body.corners().shape == (64, 4, 2)
    seen = []
    original = mpm.scene.adding.build
    scene = smallScene()
    try:
        mpm.scene.adding.build = lambda body, geometry: (seen.append(body), original(body, geometry))
        with pytest.raises(ValueError, match="overlap"):
            scene.add("twice", box((0.5, 0.5), (1, 1)), scene["soft"].material, mpm.UGIMP())
    finally:
        mpm.scene.adding.build = original
    with pytest.raises(AttributeError):
        print(seen[0].count)
    assert len(scene.bodies) == 1


def test_scenes_with_callbacks_are_freed():
    scene = smallScene(mpm.PyRunner(lambda s: None, iterPeriod=1), mpm.PyRunner("pass", iterPeriod=1))
    scene.run(steps=3)
    gone = weakref.ref(scene)
    del scene
    gc.collect()
    assert gone() is None


def test_material_constants_may_be_changed_between_runs():
    """The hourglass stiffness and the check of the time step take the new ones; a restart changes nothing."""
    scene = pulledMesh("stop")
    scene["mesh"].vertices[0] -= 0.2
    scene.run(steps=2)
    scene["mesh"].material.lame = (5e3, 5e3)
    scene.save("a.h5")
    loaded = mpm.load("a.h5")
    for s in (scene, loaded):
        s.run(steps=5)
    assert np.array_equal(scene["mesh"].vertices, loaded["mesh"].vertices)
    scene["mesh"].material.lame = (1e9, 1e9)
    with pytest.raises(ValueError, match="exceeds the longest stable step"):
        scene.run(steps=1)
    with pytest.raises(ValueError, match="exceeds the longest stable step"):
        scene.step()


@pytest.mark.parametrize("scheme", ["MUSL", "USL", "USF"])
def test_a_distorted_mesh_settles(scheme):
    """Hourglass control leaves forces on its nodes, 0.4 % of the mean, that no particle feels."""
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 2.5, 11))
    x += 0.05 * np.sin(2 * np.pi * x) * np.sin(np.pi * y / 2.5)
    mesh = (
        np.stack([x.ravel(), y.ravel()], axis=1),
        [(k, k + 1, k + 6, k + 5) for k in range(50) if k % 5 < 4],
    )
    scene = mpm.Scene((0, 0), (1, 3), 0.25, scheme=scheme)
    column = scene.add("column", mesh, mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3), mpm.APDI())
    scene.engines = [
        mpm.GridSolver(gravity=(0, -9.81), fixed="bottom", roller=("left", "right"))
        if isinstance(e, mpm.GridSolver)
        else e
        for e in scene.engines
    ]
    assert scene.unbalancedForce() > 0.1  # control: gravity has just begun
    scene.settle(tolerance=1e-4, maxSteps=5000)
    error = column.stress[:, 1, 1] + 2.0 * 9.81 * (2.5 - column.reference[:, 1])
    assert np.abs(error).max() < 0.0025 * 2.0 * 9.81 * 2.5


def test_a_ramp_counts_from_the_end_of_settling():
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    block = scene.add(
        "block", box((0, 0), (1, 0.5)), mpm.LinearElastic(density=1.0, young=1e3, poisson=0.2), mpm.UGIMP()
    )
    drive = mpm.Drive(block.above(0.4), (None, 0), ramp=0.1)
    scene.engines = chain(gravity=(0, -1), fixed="bottom", drive=drive)
    assert scene.settle() > 0 and scene.time > 0.1
    drive.velocity = (None, -0.1)
    before = block.position[:, 1].max()
    scene.run(until=scene.time + 0.1)
    assert before - block.position[:, 1].max() == pytest.approx(0.005, rel=0.2)  # without the ramp 0.01


def test_a_run_looks_up_no_more_than_it_must(monkeypatch):
    """Loops of short runs are common: similar names and the nodes of faces are not searched in each run."""
    scene = smallScene(mpm.PyRunner(lambda: None, iterPeriod=5))
    scene.engines[1] = mpm.GridSolver(
        gravity=(0, -9.81), fixed=("bottom",), hold=mpm.Hold(box((0.4, 0.4), (0.8, 0.8)), (0, None))
    )
    scene.run(steps=1)

    def refuse(*arguments):
        raise AssertionError("looked up again")

    monkeypatch.setattr(yade_mpm.base.attributes, "didYouMean", refuse)
    monkeypatch.setattr(mpm.Scene, "nodePositions", refuse)
    scene.run(steps=3)
    assert scene.steps == 4 and scene.constraints[-1].heldNodes == 4
