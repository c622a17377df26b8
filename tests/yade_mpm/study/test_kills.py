# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies that are interrupted or lose a case, a worker or their scheduler: nothing finished is lost."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from yade_mpm.study import state

SCENE = Path(__file__).with_name("demo_scene.py")
PATIENCE = 300  # s: beside fourteen other jobs on two cores a first case begins after more than a minute
WORDS = ["gravity=5,6,7,8,9,10", "--pause", "0.1", "--held", "--threads", "1", "--out", "o"]  # 1 s of pauses
HELD = [Path(f"hold{gravity}") for gravity in range(6, 11)]  # all cases but the first


@pytest.fixture(autouse=True)
def allButOneAreHeld(tmp_path):
    """Before their last steps, until the blow has fallen: no case outruns it, however busy the machine is."""
    for file in HELD:
        file.touch()


def letThemGo():
    for file in HELD:
        file.unlink()


def start(*more, words=WORDS):
    code = "from yade_mpm import commandLine; from yade_mpm.study.program import main; app.run(main)"
    command = [sys.executable, "-c", code, str(SCENE), *words, *more]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def states():
    return sorted(json.loads(f.read_text())["state"] for f in Path("o/cases").glob("*/state.json"))


def histories(folder):
    return {
        json.loads((f.parent / "arguments.json").read_text())["gravity"]: f.read_bytes()
        for f in Path(folder).glob("cases/*/history.csv")
    }


def waitFor(condition, seconds=PATIENCE):
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, states()
        time.sleep(0.05)


def isUnderWay():
    """One case is finished, and one that began after that takes its steps."""
    cases = {f.parent: json.loads(f.read_text()) for f in Path("o/cases").glob("*/state.json")}
    ended = min((at["ended"] for at in cases.values() if at["state"] == state.DONE), default=None)
    return ended is not None and any(
        at["state"] == state.RUNNING and at["began"] > ended and isStepping(folder / "log.txt")
        for folder, at in cases.items()
    )


def isStepping(log):
    return "particles; " in log.read_text()


def running():
    """Process of a case that is at work."""
    found = [json.loads(file.read_text()) for file in Path("o/cases").glob("*/state.json")]
    return next(at["pid"] for at in found if at["state"] == state.RUNNING and isAlive(at["pid"]))


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Histories of the same cases, each run without a study."""
    folder = tmp_path_factory.mktemp("alone")
    for gravity in range(5, 11):
        out = folder / "cases" / str(gravity)
        out.mkdir(parents=True)
        words = ["--gravity", str(gravity), "--threads", "1", "--out", str(out)]
        subprocess.run([sys.executable, SCENE, *words], check=True, capture_output=True)
    return histories(folder)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_study_goes_on_from_its_checkpoints(number, tmp_path, alone):
    study = start("--jobs", "2")
    waitFor(isUnderWay)
    began = time.monotonic()
    study.send_signal(number)
    said = study.communicate(timeout=PATIENCE)[0]
    assert study.returncode == 130 and "give the same command to go on" in said
    assert time.monotonic() - began < 30
    assert state.RUNNING not in states() and state.INTERRUPTED in states() and states().count(state.DONE) == 1
    letThemGo()
    assert "5/5 " in start("--jobs", "2").communicate(timeout=PATIENCE)[0]
    assert states() == [state.DONE] * 6 and histories("o") == alone
    logs = "".join(f.read_text() for f in Path("o/cases").glob("*/log.txt"))
    assert "--resume" in logs and "interrupted at step" in logs


@pytest.mark.slow
def test_a_study_that_is_killed_leaves_no_case_behind_and_goes_on(tmp_path, alone):
    study = start("--jobs", "2")
    waitFor(isUnderWay)
    study.kill()
    study.wait()
    waitFor(lambda: not any(map(isAlive, pids())))
    assert states().count(state.DONE) == 1
    letThemGo()
    assert "0 failed" not in start().communicate(timeout=PATIENCE)[0]
    assert states() == [state.DONE] * 6 and histories("o") == alone


def pids():
    return [json.loads(f.read_text()).get("pid", 0) for f in Path("o/cases").glob("*/state.json")]


def isAlive(pid):
    with contextlib.suppress(OSError):
        return pid and b"caseProcess" in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False


@contextlib.contextmanager
def cluster(workers):
    """A Dask scheduler and workers on this machine: address, processes."""
    program = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--no-dashboard"]
    scheduler = subprocess.Popen(
        [*program, "--host", "127.0.0.1", "--port", "0", "--scheduler-file", "scheduler.json"],
        stderr=subprocess.DEVNULL,
    )
    waitFor(Path("scheduler.json").exists)
    waitFor(lambda: Path("scheduler.json").read_text().strip().endswith("}"))
    address = json.loads(Path("scheduler.json").read_text())["address"]
    program = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-dashboard", "--no-nanny"]
    started = [
        subprocess.Popen([*program, "--nthreads", "1"], stderr=subprocess.DEVNULL) for _ in range(workers)
    ]
    try:
        yield address, scheduler, started
    finally:
        for process in (*started, scheduler):
            process.kill()
            process.wait()


@pytest.mark.slow
def test_a_cluster_of_two_workers_gives_the_bits_of_a_run_alone(tmp_path, alone):
    letThemGo()
    with cluster(2) as (address, _, _):
        said = start("--scheduler", address).communicate(timeout=PATIENCE)[0]
    assert "6 done; see" in said and histories("o") == alone


@pytest.mark.slow
@pytest.mark.parametrize("victim", ["case", "worker", "scheduler"])
def test_what_is_finished_survives_a_kill_at_random(victim, tmp_path, alone):
    after = random.SystemRandom().uniform(0, 1)
    with cluster(2) as (address, scheduler, workers):
        study = start("--scheduler", address)
        waitFor(isUnderWay)
        time.sleep(after)
        if victim == "case":
            os.kill(running(), signal.SIGKILL)
        else:
            (workers[0] if victim == "worker" else scheduler).kill()
        assert states().count(state.DONE) == 1
        letThemGo()
        said = study.communicate(timeout=PATIENCE)[0]
    if victim == "case":
        assert states() == [state.DONE] * 5 + [state.FAILED] and "killed by SIGKILL" in said
        said = start("--retry", "--jobs", "2").communicate(timeout=PATIENCE)[0]
    elif victim == "scheduler":
        assert study.returncode == 1 and "the scheduler is lost; finished cases are kept" in said
        waitFor(lambda: not any(map(isAlive, pids())))
        said = start("--jobs", "2").communicate(timeout=PATIENCE)[0]
    assert states() == [state.DONE] * 6 and histories("o") == alone, said
