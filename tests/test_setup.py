# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/setup: what it says of a build, of a machine without network or rights, of a read-only checkout."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

SETUP = Path(__file__).parents[1] / "scripts" / "setup"


def call(command, folder, **environment):
    """Runs a command in a shell that knows the functions of scripts/setup."""
    shell = f". '{SETUP}'\nquiet=yes test=yes yade=no withoutYade=no root=()\n{command}"
    return subprocess.run(
        ["bash", "-c", shell], cwd=folder, capture_output=True, text=True, env={**os.environ, **environment}
    )


@pytest.mark.parametrize("quiet", ["yes", "no"])
def test_a_command_that_takes_long_says_what_it_does(quiet, tmp_path):
    """Here after each second without a word: a compiler that is silent for minutes says so, too."""
    (tmp_path / "build").mkdir()
    slow = "logged build building bash -c 'echo \"[1/9] Building a.cpp\"; sleep 2.5; echo done'"
    said = call(f"quiet={quiet}; {slow}", tmp_path, SETUP_PERIOD="1")
    assert {"setup: building", "setup: ... [1/9] Building a.cpp"} <= set(said.stderr.splitlines())
    assert said.stdout == ("" if quiet == "yes" else "[1/9] Building a.cpp\ndone\n")
    assert (tmp_path / "build" / "build.log").read_text() == "[1/9] Building a.cpp\ndone\n"
    assert call("logged build building true", tmp_path).stderr == ""  # control: nothing to say at once


def test_a_build_that_fails_shows_the_end_of_its_log(tmp_path):
    (tmp_path / "build").mkdir()
    failed = call("logged build building bash -c 'echo error: no member; exit 1'", tmp_path)
    assert failed.returncode == 1 and "error: no member" in failed.stderr


@pytest.mark.parametrize(
    "log, isThere",
    [
        ("Err:1 http://mirror bookworm InRelease\n  Temporary failure resolving 'mirror'", False),
        ("NewConnectionError: Failed to establish a new connection", False),
        ("E: Unable to locate package yade", True),
    ],
)
def test_no_network_is_told_from_a_package_that_is_not_there(log, isThere, tmp_path):
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "packages.log").write_text(log)
    assert (call("hasNoNetwork packages", tmp_path).returncode != 0) == isThere


APT = """#!/bin/sh
case "$0 $1" in *apt-cache*) exit 1 ;; *update) echo "Temporary failure resolving 'mirror'"; exit 100 ;; esac
"""


def commands(folder, *names):
    """A folder of commands to be found instead of those of the machine: apt without network, no yade."""
    folder.mkdir()
    for name in ("bash", "grep", "id", "touch", "cat", "tee", "tail"):
        (folder / name).symlink_to(shutil.which(name))
    for name in names:
        (folder / name).write_text(APT)
        (folder / name).chmod(0o755)
    return str(folder)


def test_yade_is_not_asked_for_where_it_cannot_be_had(tmp_path):
    (tmp_path / "build").mkdir()
    withApt = commands(tmp_path / "apt", "apt-get", "apt-cache")
    without = commands(tmp_path / "none")
    mayBe = "mayInstall() { command -v apt-get >/dev/null; }\n"  # root, or sudo, or not: not this machine's
    said = [call(mayBe + "wantYade; echo $yade", tmp_path, PATH=path) for path in (withApt, without)]
    assert [s.stdout for s in said] == ["no\n", "no\n"]
    assert "no network, and YADE is not installed" in said[0].stderr
    assert said[1].stderr == "setup: YADE is not installed: the tests that need it are skipped\n"
    assert not (tmp_path / "build" / "without-yade.txt").exists()  # the next call looks again
    quiet = call(mayBe + "withoutYade=yes; wantYade", tmp_path, PATH=withApt)
    assert quiet.stderr == "" and quiet.returncode == 0


@pytest.fixture
def readOnly():
    """A checkout with a build that nobody may write to, and how to run its scripts/setup."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("scripts", "pkg", "build/python/yade_mpm"):
            (folder / part).mkdir(parents=True)
        shutil.copy(SETUP, folder / "scripts" / "setup")
        (folder / "pkg" / "a.cpp").write_text("")
        (folder / "CMakeLists.txt").write_text("")
        folders = [folder, *(path for path in folder.rglob("*") if path.is_dir())]

        def run():
            for path in folders:
                path.chmod(0o555)
            nobody = {"user": 65534, "group": 65534} if os.geteuid() == 0 else {}
            done = subprocess.run(
                [folder / "scripts" / "setup", "--quiet"], capture_output=True, text=True, **nobody
            )
            for path in folders:
                path.chmod(0o755)
            return done

        yield folder, run


def test_a_build_that_is_up_to_date_runs_in_a_read_only_folder(readOnly):
    folder, run = readOnly
    assert "there is no build in it" in run().stderr
    solver = folder / "build/python/yade_mpm/_core.so"
    solver.write_text("")
    assert (run().returncode, run().stderr) == (0, "")
    os.utime(solver, (1, 1))  # control: older than a source
    assert run().returncode == 1 and "is older than" in run().stderr
