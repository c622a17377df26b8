# SPDX-License-Identifier: GPL-2.0-or-later
"""Damaged and hand-made files are refused in words: no crash, no hang, nothing taken that was changed."""

import ctypes
import os
import signal
import time

import blows
import damagedFiles
import handMadeFiles
import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.base import inChild as childs
from yade_mpm.base.inChild import LostInChild, inChild
from yade_mpm.geometry import meshInput
from yade_mpm.io import checkpoint, pagedFile, recorder, resultsFile

ROOM = 1 << 30  # bytes
CRASHED = r"it crashed \((SIGSEGV|exit code 1)\)"  # the address sanitizer makes the latter of it


def here(work, seconds=20.0):
    return inChild(work, seconds, ROOM)


def test_a_child_hands_over_what_it_finds_and_what_goes_wrong():
    assert np.array_equal(here(lambda: np.arange(10**6)), np.arange(10**6))
    with pytest.raises(ValueError, match="^no$"):
        here(lambda: (_ for _ in ()).throw(ValueError("no")))
    with pytest.raises(SystemExit):
        here(lambda: exit(3))
    with pytest.raises(RuntimeError, match="Odd: 5"):
        here(_raiseOdd)


def _raiseOdd():
    class Odd(Exception):  # of no module: cannot be pickled
        pass

    raise Odd(5)


def test_a_child_that_crashes_hangs_or_eats_does_no_harm():
    with pytest.raises(LostInChild, match=CRASHED):
        here(lambda: ctypes.string_at(0))
    with pytest.raises(LostInChild, match=r"it crashed \(exit code 1\)"):
        here(lambda: os._exit(1))
    began = time.monotonic()
    with pytest.raises(LostInChild, match="it is not ready in time"):
        here(lambda: time.sleep(100), seconds=0.3)
    assert time.monotonic() - began < 10
    with pytest.raises(LostInChild, match="it is not ready in time"):
        here(lambda: [None for _ in iter(int, 1)], seconds=0.3)  # goes round for ever
    with pytest.raises(MemoryError):
        here(lambda: bytearray(2 * ROOM))
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)  # none is left behind


def test_a_child_that_is_kept_waiting_has_time(monkeypatch):
    """Beside other jobs a file was refused that reads in a second."""
    here(lambda: time.sleep(0.6), seconds=0.2)
    monkeypatch.setattr(childs, "WAITING", 1)
    with pytest.raises(LostInChild, match="it is not ready in time"):
        here(lambda: time.sleep(0.6), seconds=0.2)


def test_handlers_of_the_parent_are_not_those_of_the_child():
    before = signal.signal(signal.SIGTERM, lambda *_: None)
    try:
        with pytest.raises(LostInChild, match="SIGTERM"):
            here(lambda: os.kill(os.getpid(), signal.SIGTERM))
    finally:
        signal.signal(signal.SIGTERM, before)


def test_a_mesh_file_that_keeps_its_reader_busy_is_refused(monkeypatch):
    import meshio

    monkeypatch.setattr(meshio, "read", lambda path: time.sleep(100))
    monkeypatch.setattr(meshInput, "READ_SECONDS", 0.3)
    open("a.msh", "w").close()
    with pytest.raises(
        ValueError, match="'m': a.msh is not a mesh file that meshio can read: it is not ready"
    ):
        mpm.meshFromFile("a.msh", "m")


def test_a_checkpoint_that_crashes_hdf5_is_refused(monkeypatch):
    with open("a.h5", "wb") as f:
        f.write(damagedFiles.checkpoint())
    monkeypatch.setattr(checkpoint, "_read", lambda file: ctypes.string_at(0))
    with pytest.raises(ValueError, match=f"checkpoint 'a.h5' is damaged: .*{CRASHED}"):
        mpm.load("a.h5")


def written():
    with open("a.vtkhdf", "wb") as f:
        f.write(damagedFiles.results())
    return "a.vtkhdf"


def test_a_file_of_results_that_crashes_hdf5_is_refused(monkeypatch):
    file = mpm.read(written())
    assert len(file) == 4 and file.history()["time"].shape == (3,)
    monkeypatch.setattr(resultsFile, "frame", lambda *_: ctypes.string_at(0))
    with pytest.raises(ValueError, match=f"read: 'a.vtkhdf' is damaged: .*{CRASHED}; give a"):
        file[0]


@pytest.mark.parametrize(
    "pages, size, filled",
    [([0, 1], 10**15, 2), ([0, 2**40], 10**4, 2), ([-1, 0], 10**4, 2), ([1, 0], 10**4, 2), ([0, 1], 0, 1)],
)
def test_a_journal_made_by_hand_writes_nowhere_else(pages, size, filled):
    file, numbers = written(), np.array(pages, np.int64)
    with open("a.vtkhdf.journal", "wb") as f:
        f.write(pagedFile._journal(numbers, size, bytes(filled * pagedFile.PAGE)))
    with pytest.raises(ValueError, match="'a.vtkhdf.journal' is not as it was written, or of another file"):
        mpm.Recorder.recover(file)
    with open(file, "rb") as f:
        assert f.read() == damagedFiles.results()


@pytest.mark.parametrize("at", [0, 8, 20, 5000, -1])
def test_a_journal_with_another_bit_is_refused(at):
    file = written()
    content = bytearray(pagedFile._journal(np.array([0, 1]), 10**4, damagedFiles.results()[: 2 * 4096]))
    content[at] ^= 1
    with open("a.vtkhdf.journal", "wb") as f:
        f.write(content)
    with pytest.raises(ValueError, match="is not as it was written"):
        mpm.Recorder.recover(file)
    content[at] ^= 1
    with open("a.vtkhdf.journal", "wb") as f:
        f.write(content)
    assert mpm.Recorder.recover(file)


def test_a_run_does_not_go_on_in_a_damaged_file_of_results(monkeypatch):
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    scene.add("mesh", mpm.box((1, 0), (2, 1)), damagedFiles.elastic(mpm), mpm.APDI(size=0.25))
    scene.engines = [*scene.engines, mpm.Recorder("a.vtkhdf", iterPeriod=1)]
    scene.run(steps=2, progress=False)
    scene.save("a.h5")
    monkeypatch.setattr(recorder, "cutAfter", lambda *_: ctypes.string_at(0))
    with pytest.raises(ValueError, match=f"Recorder: '.*a.vtkhdf' is damaged: .*{CRASHED}; move it away"):
        mpm.load("a.h5").run(steps=1, progress=False)


@pytest.mark.parametrize("script", [damagedFiles.__file__, handMadeFiles.__file__])
def test_damaged_and_hand_made_files_do_no_harm(script):
    results = blows.survey(script, 40)
    assert blows.harmful(results) == []
    assert blows.summary(results)["refused"] > 20


@pytest.mark.slow  # 5 minutes
@pytest.mark.parametrize("script", [damagedFiles.__file__, handMadeFiles.__file__])
def test_two_thousand_files_do_no_harm(script):
    results = blows.survey(script, 1000, seed=2)
    found = blows.summary(results)
    harm = [found[k] for k in ("crash", "hang", "silent")]
    assert harm == [0, 0, 0] and found["unclear"] < 10, blows.harmful(results)
