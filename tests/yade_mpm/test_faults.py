# SPDX-License-Identifier: GPL-2.0-or-later
"""Killed, out of disk, or sent signals: a run goes on from its checkpoint to the same bits, and nothing older
than that is lost. A few of each here, a hundred of them with --slow."""

import contextlib
import os
import random
import re
import signal
import subprocess
import sys
import time

import h5py
import pytest
import victim
from byHand import bitsOf

ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS="1")
SIZE = 4 << 20  # bytes of the small disk
PATIENCE = 600  # s for one run, also on a machine that has little time for it
MOST_BLOWS = 60  # on a run; then one start is spared, for it may not come further between two blows


class Fallen:
    """One start of the victim, and what became of it."""

    def __init__(self, *options):
        command = [sys.executable, victim.__file__, *options]
        self.process = subprocess.Popen(
            command, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        self.first = self.process.stdout.readline()  # when it begins to step
        assert self.first.startswith("go"), self.process.communicate()[1]

    def wait(self):
        out, self.said = self.process.communicate(timeout=PATIENCE)
        self.code = self.process.returncode
        steps = [int(line.split()[1]) for line in (self.first + out).splitlines() if " " in line]
        self.reached = max(steps)
        return self


def results():
    """What is in the files of a run that has come to its end."""
    with h5py.File("out.vtkhdf") as h5, open("out.csv") as table:
        return (
            bitsOf("end.h5"),
            h5["VTKHDF/Steps/Values"][:].tolist(),
            h5["VTKHDF/CellData/velocity"][:].tobytes(),
            table.read(),
        )


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Results of a run that nobody disturbs, and how long its steps take, s."""
    before = os.getcwd()
    os.chdir(tmp_path_factory.mktemp("undisturbed"))
    try:
        one = Fallen()
        began = time.monotonic()
        assert one.wait().code == 0, one.said
        return results(), time.monotonic() - began
    finally:
        os.chdir(before)


def bear(undisturbed, count, blow):
    """Runs go to their end in as many starts as it takes; blow(rng, process, seconds) falls on each of them,
    `count` times in all. Returns the starts."""
    expected, seconds = undisturbed
    rng, fallen = random.Random(count), []
    while len(fallen) < count:
        for file in os.listdir():
            os.remove(file)
        reached, said = 0, ""
        for start in range(MOST_BLOWS + 1):
            one = blow(rng, seconds) if len(fallen) < count and start < MOST_BLOWS else Fallen().wait()
            fallen.append(one)
            begun = int(one.first.split()[1])
            assert begun >= reached, f"step {reached} was saved, and it goes on from {begun}"
            reached, said = one.reached, said + one.said
            if os.path.exists("end.h5"):
                break
        assert os.path.exists("end.h5"), said
        found = results()
        for name, data in expected[0].items():
            assert found[0][name] == data, f"{name} has other bits"
        if re.search(r"OSError: .*out\.vtkhdf", said):  # for what had no room at the end of a process
            assert set(found[1]) <= set(expected[1]) and found[3] == expected[3]
        else:
            assert found[1:] == expected[1:]
    return fallen


def killed(rng, seconds):
    one = Fallen()
    time.sleep(rng.uniform(0, 0.7 * seconds))
    one.process.kill()
    return one.wait()


def room(rng):
    """Bytes: from a few to what all but the last rows and frames need."""
    return rng.choice([100, 4096, rng.randrange(2**16), rng.randrange(2**20)])


def limited(rng, seconds):
    """A limit on the size of files."""
    return endedInWords(Fallen("--limit", str(room(rng))))


def outOfDisk(rng, seconds):
    """No room on the disk but for some bytes, to which old files do not count."""
    disk = os.statvfs(".")
    with open("filler", "wb") as file:
        os.posix_fallocate(file.fileno(), 0, max(1, disk.f_bavail * disk.f_frsize - room(rng)))
    try:
        return endedInWords(Fallen())
    finally:
        os.remove("filler")


@contextlib.contextmanager
def smallDisk(folder):
    """The working folder is on a disk of its own; skipped where none can be made."""
    folder = folder / "small"
    folder.mkdir()
    before, options = os.getcwd(), ["-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(["mount", *options], capture_output=True).returncode != 0:
        pytest.skip("a disk of its own needs the right to mount one")
    try:
        os.chdir(folder)
        yield
    finally:
        os.chdir(before)
        subprocess.run(["umount", str(folder)], check=True)


def endedInWords(one):
    """A start of the victim that has ended without a signal, and has told what it could not write."""
    one.wait()
    assert one.code >= 0, f"it ended by a signal, {-one.code}"
    if one.code:
        assert re.search(r"OSError: .*('|\")?(out\.vtkhdf|out\.csv|saved\.h5|end\.h5)", one.said), one.said
    return one


def signalled(rng, seconds):
    one = Fallen(*rng.choice([[], ["--background"]]))
    number = rng.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1])
    time.sleep(rng.uniform(0, 0.7 * seconds))
    if one.process.poll() is None:
        one.process.send_signal(number)
    return one.wait()


BLOWS = {"killed": killed, "limited": limited, "out of disk": outOfDisk, "signalled": signalled}
COUNTS = {"killed": 100, "limited": 50, "out of disk": 50, "signalled": 50}


def bearThem(undisturbed, count, name, folder):
    with smallDisk(folder) if name == "out of disk" else contextlib.nullcontext():
        return bear(undisturbed, count, BLOWS[name])


@pytest.mark.parametrize("name", BLOWS)
def test_a_run_survives_a_few(undisturbed, name, tmp_path):
    bearThem(undisturbed, 1, name, tmp_path)


@pytest.mark.slow  # 10 minutes
@pytest.mark.parametrize("name, count", COUNTS.items())
def test_a_run_survives_many(undisturbed, name, count, tmp_path):
    fallen = bearThem(undisturbed, count, name, tmp_path)
    print(name, len(fallen), "starts, of which to the end:", sum(one.code == 0 for one in fallen))
