# SPDX-License-Identifier: GPL-2.0-or-later
"""Damaged and hand-made files are refused in words: no crash, no hang, nothing taken that was changed."""

import os
import threading
from pathlib import Path

import blows
import damagedFiles
import h5py
import handMadeFiles
import numpy as np
import pytest
import yade_mpm as mpm
from byHand import describedAnew, opened
from setups import chain
from yade_mpm.geometry import meshReader
from yade_mpm.io import pagedFile


def withMeshio(monkeypatch, text):
    """A file for a meshio whose `read` is that text."""
    Path("a.msh").touch()
    Path("fake").mkdir()
    Path("fake/meshio.py").write_text(f"def read(path):\n    {text}\n")
    monkeypatch.syspath_prepend(os.path.abspath("fake"))
    monkeypatch.setattr(meshReader, "SECONDS", 1.0)
    monkeypatch.setattr(meshReader, "WAITING", 1 if "sleep" in text else 600)


@pytest.mark.parametrize(
    "text, told",
    [
        ("while True: pass", "ended by signal"),
        ("import time; time.sleep(100)", "not read after 1 s"),
        ("import ctypes; ctypes.string_at(0)", "ended by signal 11"),
        ("import os; os._exit(3)", "meshio ended with code 3"),
        ("exit(2)", "meshio ended with code 2"),
        ("bytearray(1 << 40)", "MemoryError"),
        ("raise ValueError('odd')", "ValueError: odd"),
    ],
)
def test_a_mesh_file_that_its_reader_does_not_survive_is_refused(monkeypatch, text, told):
    withMeshio(monkeypatch, text)
    with pytest.raises(ValueError, match=f"'m': a.msh is not a mesh file that meshio can read: .*{told}"):
        mpm.meshFromFile("a.msh", "m")


def test_a_mesh_is_read_from_regular_files_only():
    os.mkfifo("pipe.msh")
    for file in ("pipe.msh", "/dev/zero", "."):
        with pytest.raises(ValueError, match="is no regular file"):
            mpm.meshFromFile(file, "m")


def test_hdf5_sees_no_byte_of_a_checkpoint_that_was_changed(monkeypatch):
    content = bytearray(damagedFiles.checkpoint())
    content[-1] ^= 1
    Path("a.h5").write_bytes(content)
    monkeypatch.setattr(h5py, "File", None)
    with pytest.raises(ValueError, match="checkpoint 'a.h5' is damaged: it is not what was written"):
        mpm.load("a.h5")


def held(lock):
    """A thread that holds a lock until the event is set: a run that writes a frame."""
    isHeld, isEnough = threading.Event(), threading.Event()

    def hold():
        with lock:
            isHeld.set()
            isEnough.wait()

    thread = threading.Thread(target=hold)
    thread.start()
    isHeld.wait()
    return thread, isEnough


@pytest.mark.parametrize("what", ["results", "checkpoint"])
def test_files_are_read_while_a_run_writes_others(what):
    """A child made by fork would wait for ever for a lock whose holder it does not have."""
    written()
    Path("a.h5").write_bytes(damagedFiles.checkpoint())
    thread, isEnough = held(h5py._objects.phil)
    threading.Timer(0.3, isEnough.set).start()
    assert len(mpm.read("a.vtkhdf")) == 4 if what == "results" else mpm.load("a.h5").steps == 3
    thread.join()


def test_no_half_frame_is_read():
    """A reader of the same process waits while pages of the file change."""
    results, found = mpm.read(written()), []
    thread, isEnough = held(pagedFile.committing)
    reader = threading.Thread(target=lambda: found.append(len(results)))
    reader.start()
    reader.join(0.2)
    assert found == []
    isEnough.set()
    reader.join()
    thread.join()
    assert found == [4]


def test_a_file_that_another_process_changes_is_read_once_more(monkeypatch):
    file, calls = written(), []

    def work(h5):
        calls.append(1)
        if len(calls) < 3:  # a frame came meanwhile, and half of it was read
            with open(file, "ab") as f:
                f.write(b"0")
            raise OSError("half a frame")
        return len(h5)

    from yade_mpm.recorded import resultsFile

    assert resultsFile.asked(file, work) == 2 and len(calls) == 3


def written():
    Path("a.vtkhdf").write_bytes(damagedFiles.results())
    return "a.vtkhdf"


@pytest.mark.parametrize(
    "pages, size, filled",
    [([0, 1], 10**15, 2), ([0, 2**40], 10**4, 2), ([-1, 0], 10**4, 2), ([1, 0], 10**4, 2), ([0, 1], 0, 1)],
)
def test_a_journal_made_by_hand_writes_nowhere_else(pages, size, filled):
    file, numbers = written(), np.array(pages, np.int64)
    Path("a.vtkhdf.journal").write_bytes(pagedFile._journal(numbers, size, bytes(filled * pagedFile.PAGE)))
    with pytest.raises(ValueError, match="'a.vtkhdf.journal' is not as it was written, or of another file"):
        mpm.Recorder.recover(file)
    assert Path(file).read_bytes() == damagedFiles.results()


@pytest.mark.parametrize("at", [0, 8, 20, 5000, -1])
def test_a_journal_with_another_bit_is_refused(at):
    file, journal = written(), Path("a.vtkhdf.journal")
    content = bytearray(pagedFile._journal(np.array([0, 1]), 10**4, damagedFiles.results()[: 2 * 4096]))
    content[at] ^= 1
    journal.write_bytes(content)
    with pytest.raises(ValueError, match="is not as it was written"):
        mpm.Recorder.recover(file)
    content[at] ^= 1
    journal.write_bytes(content)
    assert mpm.Recorder.recover(file)


def test_a_run_does_not_go_on_in_a_damaged_file_of_results():
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    scene.add("mesh", mpm.box((1, 0), (2, 1)), damagedFiles.elastic(mpm), mpm.APDI(size=0.25))
    scene.engines = [*scene.engines, mpm.Recorder("a.vtkhdf", iterPeriod=1)]
    scene.run(steps=2, progress=False)
    scene.save("a.h5")
    with h5py.File("a.vtkhdf", "r+") as h5:
        del h5["VTKHDF/Types"]
    before = Path("a.vtkhdf").read_bytes()
    with pytest.raises(ValueError, match="Recorder: '.*a.vtkhdf' is damaged: .*; move it away"):
        mpm.load("a.h5").run(steps=1, progress=False)
    assert Path("a.vtkhdf").read_bytes() == before


@pytest.mark.parametrize("count", [40, pytest.param(1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("script", [damagedFiles.__file__, handMadeFiles.__file__])
def test_damaged_and_hand_made_files_do_no_harm(script, count):
    results = blows.survey(script, count)
    found = blows.summary(results)
    assert found["crash"] + found["hang"] + found["silent"] == 0, blows.harmful(results)
    assert found["unclear"] <= 0.01 * count and found["refused"] > count / 2, blows.harmful(results)


def instead(place, make):
    """A file of results with something else at a place."""
    file = written()
    with h5py.File(file, "r+") as h5:
        group, name = h5[place.rpartition("/")[0]], place.rpartition("/")[2]
        data = group[name][()]
        del group[name]
        make(group, name, data)
    return file


def zippedTwice(group, name, data):
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_chunk((1, *data.shape[1:]))
    plist.set_deflate(9)
    plist.set_deflate(9)
    space, kind = h5py.h5s.create_simple(data.shape), h5py.h5t.py_create(data.dtype)
    h5py.h5d.create(group.id, name.encode(), kind, space, plist)


ELSEWHERE = {
    "link to a file": lambda group, name, data: group.__setitem__(name, h5py.ExternalLink("pipe", "/x")),
    "raw numbers": lambda group, name, data: group.create_dataset(
        name, data.shape, data.dtype, external=[("pipe", 0, h5py.h5f.UNLIMITED)]
    ),
    "link inside": lambda group, name, data: group.__setitem__(name, h5py.SoftLink("/VTKHDF/Steps/step")),
    "zipped twice": zippedTwice,
}


@pytest.mark.parametrize("how", ELSEWHERE)
@pytest.mark.parametrize("place", ["VTKHDF/Points", "history/time"])
def test_results_are_in_their_file_only(how, place):
    os.mkfifo("pipe")  # whoever opens it waits
    file = instead(place, ELSEWHERE[how])
    with pytest.raises(
        ValueError, match="read: 'a.vtkhdf' is damaged: .* is (a link to|compressed, or) else"
    ):
        mpm.read(file)


def ofNothing(group, name, data):
    group.create_dataset(name, (2**40, 3), chunks=(64, 3))


@pytest.mark.parametrize(
    "place, make, told",
    [
        ("NumberOfCells", -16, "Connectivity|cannot reshape|rows"),
        ("NumberOfPoints", 10**6, "Points has .* rows, and not 1000000 from 0 on"),
        ("NumberOfConnectivityIds", -4, "Connectivity has .* rows, and not -4"),
        ("Connectivity", 2**40, "cells have corners 1099511627776 to 1099511627776 of 25 points"),
        ("Connectivity", -1, "cells have corners -1 to -1"),
        ("Steps/PartOffsets", -1, "has 1 rows, and not 1 from -1 on"),
        ("Points", ofNothing, "Points with the shape .* is larger than the file"),
    ],
)
def test_results_with_impossible_counts_are_refused(place, make, told):
    whole = make if callable(make) else lambda group, name, data: group.__setitem__(name, data * 0 + make)
    file = instead("VTKHDF/" + place, whole)
    with pytest.raises(ValueError, match=f"read: 'a.vtkhdf' is damaged: ValueError: .*({told})"):
        mpm.read(file)[0]


@pytest.mark.parametrize("row", [["a", "b", "c", "d"], [0.0], "text"])
def test_integrals_of_a_history_are_checked_on_loading(row):
    scene = mpm.Scene((0, 0), (2, 2), 0.5, threads=1)
    scene.add("mesh", mpm.box((1, 0), (2, 1)), damagedFiles.elastic(mpm), mpm.APDI(size=0.25))
    scene.engines = [*chain(gravity=(0, -9.81), fixed="bottom"), mpm.History(iterPeriod=1)]
    scene.run(steps=1, progress=False)
    scene.save("a.h5")

    def change(spec):
        state = spec["engines"][-1]["state"]
        state["before"] = dict.fromkeys(state["before"], row)

    describedAnew("a.h5", change)
    with pytest.raises(ValueError, match="History: .*(no number|not complete)"):
        mpm.load("a.h5").run(steps=1, progress=False)


def test_a_pipe_is_no_file_of_results():
    os.mkfifo("a.vtkhdf")
    for work in (mpm.read, mpm.Recorder.recover):
        with pytest.raises(ValueError, match="'a.vtkhdf' is no regular file"):
            work("a.vtkhdf")


def test_a_pipe_is_no_journal_and_no_plugin():
    file = written()
    os.mkfifo("a.vtkhdf.journal")
    for work in (mpm.Recorder.recover, lambda file: pagedFile.appendingTo(file).__enter__()):
        with pytest.raises(ValueError, match="recover: 'a.vtkhdf.journal' is no regular file"):
            work(file)
    with pytest.raises(ValueError, match="loadPlugin: 'a.vtkhdf.journal' is no regular file"):
        mpm.loadPlugin("a.vtkhdf.journal")


def test_a_checkpoint_whose_body_is_in_another_file_is_refused():
    Path("a.h5").write_bytes(damagedFiles.checkpoint())
    os.mkfifo("pipe")
    with opened("a.h5") as h5:
        del h5["bodies/0"]
        h5["bodies/0"] = h5py.ExternalLink("pipe", "/x")
    with pytest.raises(ValueError, match="0 is a link to elsewhere"):
        mpm.load("a.h5")
