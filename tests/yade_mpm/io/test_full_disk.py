# SPDX-License-Identifier: GPL-2.0-or-later
"""A disk that becomes full costs what has no room, nothing that was written, and not the run."""

import os
import subprocess
import sys

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from processes import runPython

SIZE = 8 << 20  # bytes of the small disk
SCENE = """
import os, resource, sys, time
import numpy as np
import yade_mpm as mpm
from yade_mpm import box

scene = mpm.Scene((0, 0), (4, 2), 0.25)
elastic = mpm.LinearElastic(density=1.0, lame=(1e3, 1e3))
body = scene.add("a", box((0, 0), (4, 1)), elastic, mpm.UGIMP(perCell=2))
scene.engines = [
    *(mpm.ParticleToGrid(), mpm.GridSolver(gravity=(0, -9.81), fixed="bottom")),
    *(mpm.GridToParticle(), mpm.DomainUpdater()),
]

def fill(left):
    "Leaves so many bytes on the disk."
    free = os.statvfs("full").f_bavail * os.statvfs("full").f_frsize
    with open("full/filler", "ab") as file:
        os.posix_fallocate(file.fileno(), os.path.getsize("full/filler"), max(1, free - left))

def makeRoom():
    os.remove("full/filler")

"""


@pytest.fixture
def disk(tmp_path):
    """A folder "full" on a disk of its own; skipped where none can be made: below a test with a limit."""
    folder = tmp_path / "full"
    folder.mkdir()
    options = ["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(options, capture_output=True).returncode != 0:
        pytest.skip("a disk of its own needs the right to mount one")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def ran(script):
    run = runPython("-c", SCENE + script)
    assert run.returncode == 0, run.stderr
    return run.stdout + run.stderr


@pytest.mark.parametrize("left", [0, 4096, 16384, 65536])
def test_a_checkpoint_for_which_there_is_no_room_leaves_the_one_before(disk, left):
    told = ran(f"""
scene.run(steps=10, progress=False)
scene.save("full/a.h5")
before = open("full/a.h5", "rb").read()
scene.run(steps=10, progress=False)
fill({left})
try:
    scene.save("full/a.h5")
except OSError as error:
    print(error.errno, error)
assert open("full/a.h5", "rb").read() == before and sorted(os.listdir("full")) == ["a.h5", "filler"]
makeRoom()
scene.save("full/a.h5")
""")
    assert "28 [Errno 28] checkpoint 'full/a.h5' could not be written: No space left on device" in told
    assert mpm.load("full/a.h5").steps == 20


def test_a_run_goes_on_without_its_periodic_checkpoints_and_says_so(disk):
    told = ran("""
fill(4096)
scene.run(steps=50, progress=False, checkpointFile="full/a.h5", checkpointPeriod=0.0)
assert scene.steps == 50 and os.listdir("full") == ["filler"]
""")
    assert told.count("checkpoint 'full/a.h5' could not be written: No space left on device") >= 1
    assert "the run goes on" in told


@pytest.mark.parametrize("left", [0, 4096, 32768])
def test_a_recorder_that_finds_no_room_at_the_start_says_so(disk, left):
    told = ran(f"""
fill({left})
scene.engines = [*scene.engines, mpm.Recorder("full/out.vtkhdf", iterPeriod=5)]
try:
    scene.run(steps=10, progress=False)
except OSError as error:
    print(error)
assert os.listdir("full") == ["filler"] and scene.steps == 0
""")
    assert "Recorder: 'full/out.vtkhdf' cannot be written (No space left on device)" in told


@pytest.mark.parametrize("left", [0, 3 * 4096, 60000])
def test_frames_and_rows_without_room_come_when_there_is_room_and_none_is_torn(disk, left):
    told = ran(f"""
scene.engines = [
    *scene.engines,
    mpm.Recorder("full/out.vtkhdf", iterPeriod=5),
    mpm.History(iterPeriod=1, file="full/out.csv"),
    mpm.PyRunner(lambda s: fill({left}) if s.steps == 22 else None, iterPeriod=1),
]
import yade_mpm.io.history as history
history.FLUSH = 0.0  # s: rows go to the file at once
open("full/filler", "w").close()
try:
    scene.run(steps=60, progress=False)
except OSError as error:
    print("at the end:", error)
recorder = next(e for e in scene.engines if isinstance(e, mpm.Recorder))
print("frames", recorder.frames)
rows = open("full/out.csv").read()
assert rows.endswith("\\n") and len({{line.count(",") for line in rows.splitlines()}}) == 1
makeRoom()
scene.run(steps=5, progress=False)
assert recorder.frames == 14
assert len(open("full/out.csv").read().splitlines()) == 66
""")
    assert told.count("Recorder 'full/out.vtkhdf': No space left on device; frames are kept in memory") == 1
    assert "at the end: [Errno 28] No space left on device: 'full/out." in told
    with h5py.File("full/out.vtkhdf") as h5:
        assert list(h5["VTKHDF/Steps/step"]) == list(range(0, 66, 5))
        assert len(h5["VTKHDF/CellData/body"]) == 14 * 256 and np.isfinite(h5["VTKHDF/Points"]).all()


def test_a_limit_on_the_size_of_files_is_met_like_a_full_disk(tmp_path):
    """For those who may not mount a disk."""
    told = ran("""
os.mkdir("full")
scene.save("full/a.h5")
before = open("full/a.h5", "rb").read()
scene.engines = [*scene.engines, mpm.Recorder("full/out.vtkhdf", iterPeriod=5)]
scene.run(steps=20, progress=False)
size = os.path.getsize("full/out.vtkhdf")
resource.setrlimit(resource.RLIMIT_FSIZE, (size + 10000, resource.RLIM_INFINITY))
try:
    scene.run(steps=20, progress=False)
except OSError as error:
    print("at the end:", error)
resource.setrlimit(resource.RLIMIT_FSIZE, (10000, resource.RLIM_INFINITY))
try:
    scene.save("full/a.h5")
except OSError as error:
    print(error)
assert open("full/a.h5", "rb").read() == before and not [f for f in os.listdir("full") if f.endswith("part")]
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
scene.run(steps=5, progress=False)
assert scene.engines[-1].frames == 10
""")
    assert "at the end: [Errno 27] File too large: 'full/out.vtkhdf'" in told
    assert "checkpoint 'full/a.h5' could not be written: File too large" in told


@pytest.mark.parametrize("most, frames", [(1 << 13, 1), (1 << 20, 9)])
def test_frames_that_wait_for_room_are_bounded_and_said_once(tmp_path, most, frames):
    """256 particles take 40 kB a frame: a bound below one of them ends the run, one above all does not."""
    told = ran(f"""
import yade_mpm.io.recorder as recorder
recorder.MOST_WAITING = {most}
os.mkdir("full")
scene.engines = [*scene.engines, mpm.Recorder("full/out.vtkhdf", iterPeriod=5)]
scene.run(steps=5, progress=False)
size = os.path.getsize("full/out.vtkhdf")
resource.setrlimit(resource.RLIMIT_FSIZE, (size + 10000, resource.RLIM_INFINITY))
try:
    scene.run(steps=45, progress=False)
except OSError as error:
    print(error)
print("steps", scene.steps)
""")
    isEnough = most == 1 << 20
    assert f"steps {50 if isEnough else 9 + frames}" in told
    assert ("of them take more than 0 MB; make room" in told) != isEnough
    assert told.count("frames are kept in memory until there is room") == isEnough


def test_a_temporary_file_follows_no_link_and_cannot_be_foreseen(tmp_path):
    from yade_mpm.io import files

    (tmp_path / "precious").write_text("precious")
    names = set()
    for _ in range(3):
        with files.replacing(tmp_path / "a") as part:
            names.add(part)
            assert os.stat(part).st_size == 0
    assert len(names) == 3
    for name in ("a.h5.part", "out.vtkhdf.part", f"a.h5.{os.getpid()}-1.part"):
        os.symlink("precious", name)
    scene = mpm.Scene((0, 0), (1, 1), 0.5)
    scene.add("a", mpm.box((0, 0), (1, 1)), mpm.LinearElastic(density=1.0, lame=(1.0, 1.0)), mpm.UGIMP())
    scene.engines = [*scene.engines, mpm.Recorder("out.vtkhdf", iterPeriod=1)]
    scene.run(steps=3, progress=False)
    scene.save("a.h5")
    assert (tmp_path / "precious").read_text() == "precious"


def test_what_a_killed_process_left_is_removed_and_what_a_living_one_writes_is_not(tmp_path):
    from yade_mpm.io import files

    dead = subprocess.Popen([sys.executable, "-c", "pass"])
    dead.wait()
    left = tmp_path / f"a.{files.HOST}-{dead.pid}-{'0' * 16}.part"
    living = tmp_path / f"a.{files.HOST}-{os.getppid()}-{'0' * 16}.part"
    other = tmp_path / f"a.elsewhere-{dead.pid}-{'0' * 16}.part"
    for file in (left, living, other):
        file.write_text("half")
    files.writeWhole(tmp_path / "a", b"whole")
    assert not left.exists() and living.exists() and other.exists()
