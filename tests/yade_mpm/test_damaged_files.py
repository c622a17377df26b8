# SPDX-License-Identifier: GPL-2.0-or-later
"""Damaged and hand-made files are refused in words: no crash, no hang, nothing taken that was changed."""

import ctypes
import os
import signal
import time

import blows
import damagedFiles
import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.base.inChild import LostInChild, inChild
from yade_mpm.geometry import meshInput
from yade_mpm.io import checkpoint

ROOM = 1 << 30  # bytes


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
    with pytest.raises(LostInChild, match=r"it crashed \(SIGSEGV\)"):
        here(lambda: ctypes.string_at(0))
    with pytest.raises(LostInChild, match=r"it crashed \(exit code 1\)"):
        here(lambda: os._exit(1))
    began = time.monotonic()
    with pytest.raises(LostInChild, match="it is not ready in time"):
        here(lambda: time.sleep(100), seconds=0.3)
    assert time.monotonic() - began < 10
    with pytest.raises(MemoryError):
        here(lambda: bytearray(2 * ROOM))
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)  # none is left behind


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
    with pytest.raises(ValueError, match=r"checkpoint 'a.h5' is damaged: .*it crashed \(SIGSEGV\)"):
        mpm.load("a.h5")


def test_damaged_files_do_no_harm():
    results = blows.survey(damagedFiles.__file__, 40)
    assert blows.harmful(results) == []
    assert blows.summary(results)["refused"] > 20


@pytest.mark.slow  # 5 minutes
def test_two_thousand_damaged_files_do_no_harm():
    results = blows.survey(damagedFiles.__file__, 2000, seed=2)
    found = blows.summary(results)
    harm = [found[k] for k in ("crash", "hang", "silent")]
    assert harm == [0, 0, 0] and found["unclear"] < 20, blows.harmful(results)
