# SPDX-License-Identifier: GPL-2.0-or-later
"""A checkpoint is data: it runs nothing, writes nowhere else, and damage is told, not computed with."""

import os
import shutil

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from byHand import describedAnew, opened
from inputs import refused
from setups import chain
from yade_mpm import box


def makeScene(*engines):
    """Boxes, one body of them cut, beside a mesh with hanging vertices."""
    scene = mpm.Scene((0, 0), (2, 2), 0.5)
    elastic = mpm.LinearElastic(density=1.0, lame=(100.0, 50.0))
    near = scene.add("boxes", box((0, 0), (1, 0.5)), elastic, mpm.UGIMP(perCell=4))
    scene.add("mesh", box((1, 0), (2, 1)), elastic, mpm.APDI(size=0.5, matched=near))
    scene.add("cut", mpm.disc((0.5, 1.5), 0.3), elastic, mpm.UGIMP(perCell=4, cut=True))
    scene.engines = [*chain(gravity=(0, -1), fixed="bottom"), *engines]
    scene.run(steps=10, progress=False)
    return scene


# --- text -------------------------------------------------------------------------------------------------
def test_text_runs_only_if_the_caller_says_so_and_is_shown(tmp_path):
    text = f"open({str(tmp_path / 'ran')!r}, 'w').close()"
    makeScene(mpm.PyRunner("pass", iterPeriod=1, label="harmless")).save("a.h5")
    describedAnew("a.h5", lambda spec: spec["engines"][-1]["spec"].update(command=text))
    with pytest.raises(ValueError, match=r"(?s)a run would execute:\n    harmless: open\(.*trust=True"):
        mpm.load("a.h5")
    mpm.load("a.h5", callbacks={"harmless": None}).run(steps=2)
    calls = []
    mpm.load("a.h5", callbacks={"harmless": calls.append}).run(steps=2)
    assert not os.path.exists("ran") and len(calls) == 2
    mpm.load("a.h5", trust=True).run(steps=2)
    assert os.path.exists("ran")
    with pytest.raises(TypeError, match="trust = 1 is not allowed; give True or False"):
        mpm.load("a.h5", trust=1)


@pytest.mark.parametrize("name", ["PyRunner", "Recorder", "History", "Callback"])
def test_a_callback_is_made_from_nothing_but_what_was_looked_at(name):
    """Text among the attributes of a PyRunner ran without trust."""
    makeScene().save("a.h5")
    attributes = dict(command="open('ran', 'w').close()", file="../ran", iterPeriod=1)
    kept = {"PyRunner": ["command", "iterPeriod"], "Recorder": ["file", "iterPeriod"]}.get(
        name, ["iterPeriod"]
    )
    engine = {"class": name, "attributes": {key: attributes[key] for key in kept}}
    describedAnew("a.h5", lambda spec: spec["engines"].append(engine))
    with pytest.raises(ValueError, match="checkpoint 'a.h5' (has a PyRunner without|needs the class)"):
        mpm.load("a.h5").run(steps=2)
    assert not os.path.exists("ran") and not os.path.exists("../ran")


@pytest.mark.parametrize("state", [dict(nodes=[2**30]), dict(lower=[]), dict(velocity=[]), dict(body="none")])
def test_the_state_of_a_motion_is_nothing_that_the_solver_goes_by(state):
    """Numbers of nodes from the file were written to as they came."""
    scene = makeScene()
    scene.engines = chain(drive=mpm.Drive(scene["boxes"], (0, 0.1)), fixed="bottom")
    scene.run(steps=1, progress=False)
    scene.save("a.h5")
    mpm.load("a.h5").run(steps=1, progress=False)  # control
    describedAnew("a.h5", lambda spec: spec["engines"][1]["drive"][0]["state"].update(state))
    with pytest.raises(ValueError, match="the state of 'drive' has '.*', which is none of it"):
        mpm.load("a.h5")


@pytest.mark.parametrize("trust", [False, True])
def test_a_column_that_a_file_brings_is_an_expression_and_no_python(trust):
    makeScene(mpm.History(iterPeriod=1, columns={"a": "scene.time"})).save("a.h5")
    text = "__import__('os').mkdir('ran')"
    describedAnew("a.h5", lambda spec: spec["engines"][-1]["spec"]["columns"].update(a=text))
    with pytest.warns(UserWarning, match="column 'a' = .* is not allowed: .*; the column is nan until then"):
        scene = mpm.load("a.h5", trust=trust)
    scene.run(steps=1, progress=False)
    history = next(e for e in scene.engines if isinstance(e, mpm.History))
    assert not os.path.exists("ran") and np.isnan(history["a"][-1])


# --- places -----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("kind", [mpm.Recorder, mpm.History])
@pytest.mark.parametrize("place", ["../elsewhere", "absolute", "link/elsewhere", "run/../../elsewhere"])
def test_a_file_of_a_checkpoint_stays_in_its_folder(tmp_path, kind, place):
    folder, other = tmp_path / "a", tmp_path / "b"
    folder.mkdir(), other.mkdir()
    (folder / "link").symlink_to(other)
    name = str(other / "elsewhere") if place == "absolute" else place
    makeScene(kind(file=folder / "out.h5", iterPeriod=5)).save(folder / "a.h5")
    describedAnew(folder / "a.h5", lambda spec: spec["engines"][-1]["spec"].update(file=name))
    told = f"would write to '{name}', which is not in its folder; give load(file, files="
    refused(told, lambda: mpm.load(folder / "a.h5"))
    scene = mpm.load(folder / "a.h5", files={name: tmp_path / "mine.h5"})
    scene.run(steps=10, progress=False)
    assert (tmp_path / "mine.h5").exists()
    left = [e for e in mpm.load(folder / "a.h5", files={name: None}).engines if isinstance(e, kind)]
    assert left == [] if kind is mpm.Recorder else left[0].file is None
    found = mpm.load(folder / "a.h5", trust=True).engines[-1].file
    assert os.path.realpath(found) == os.path.realpath(folder / name)
    with pytest.raises(ValueError, match="names no file 'nothing'; check the names"):
        mpm.load(folder / "a.h5", files={name: None, "nothing": "x"})


@pytest.mark.parametrize(
    "writer, name, why",
    [
        ("History", ".bashrc", "is hidden"),
        ("History", ".ssh/rc.csv", "is hidden"),
        ("History", "Makefile", r"is no file of a History \(which end in .csv"),
        ("History", "conftest.py", "is no file of a History"),
        ("Recorder", "out.csv", "is no file of a Recorder"),
        ("Recorder", ".out.vtkhdf", "is hidden"),
    ],
)
def test_a_checkpoint_names_files_of_results_only(writer, name, why):
    """A History took the place of ~/.bashrc, and a column name ran in the next shell."""
    mine = {"History": mpm.History(iterPeriod=1, file="a.csv"), "Recorder": mpm.Recorder("a.vtkhdf", 1.0)}
    makeScene(mine[writer]).save("a.h5")
    describedAnew("a.h5", lambda spec: spec["engines"][-1]["spec"].update(file=name))
    with pytest.raises(ValueError, match=f"would write to '{name}', which {why}"):
        mpm.load("a.h5")
    mpm.load("a.h5", files={name: None})


def test_a_link_to_a_hidden_file_is_no_way_round():
    makeScene(mpm.History(iterPeriod=1, file="a.csv")).save("a.h5")
    os.remove("a.csv")
    os.symlink(os.path.abspath(".profile"), "a.csv")
    with pytest.raises(ValueError, match="'a.csv', which is hidden"):
        mpm.load("a.h5")


@pytest.mark.parametrize(
    "text, whose", [("precious\n", "no History"), ("time [s],step [-],\n9.0,9,\n", "another run")]
)
def test_a_file_of_somebody_else_is_not_replaced(text, whose):
    makeScene(mpm.History(iterPeriod=1, file="a.csv")).save("a.h5")
    with open("a.csv", "w") as f:
        f.write(text)
    with pytest.raises(FileExistsError, match=f"'a.csv' is there, and {whose} has written it; move it away"):
        mpm.load("a.h5").run(steps=1, progress=False)
    with open("a.csv") as f:
        assert f.read() == text


def test_a_recorder_replaces_files_of_recorders_only():
    scene = makeScene()
    scene.save("a.h5")
    with pytest.raises(FileExistsError, match="'a.h5' is there, and no Recorder has written it"):
        makeScene(mpm.Recorder("a.h5", iterPeriod=1))
    assert mpm.load("a.h5").steps == 10


def test_results_and_checkpoint_move_together(tmp_path):
    os.mkdir("first")
    scene = makeScene(
        mpm.Recorder("first/out.vtkhdf", iterPeriod=5), mpm.History(iterPeriod=5, file="first/out.csv")
    )
    scene.save("first/a.h5")
    shutil.move("first", "second")
    mpm.load("second/a.h5").run(steps=10, progress=False)
    assert not os.path.exists("first") and len((tmp_path / "second/out.csv").read_text().splitlines()) == 5


# --- damage -----------------------------------------------------------------------------------------------
def test_every_flipped_bit_and_every_missing_end_is_noticed(tmp_path):
    makeScene().save("a.h5")
    whole = (tmp_path / "a.h5").read_bytes()
    random = np.random.default_rng(1)
    places = [*range(0, 600, 31), *random.integers(0, len(whole), 150)]
    for place in places:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(random.integers(8))
        (tmp_path / "b.h5").write_bytes(damaged)
        with pytest.raises(ValueError, match="'b.h5'"):
            mpm.load("b.h5")
    for end in random.integers(0, len(whole), 20):
        (tmp_path / "b.h5").write_bytes(whole[:end])
        with pytest.raises(ValueError, match="'b.h5'"):
            mpm.load("b.h5")


OTHER_KIND_OR_ORDER = {  # numbers of rows and ranges: test_tables.py
    "bodies/0/tables/blockStart": lambda v: v[::-1],
    "bodies/0/particles/id": lambda v: v.astype(float),
    "bodies/0/particles/mass": lambda v: v[:, None],
    "bodies/0/particles/position": lambda v: v.astype(int),
    "bodies/1/tables/corners": lambda v: v.astype("i8"),
    "bodies/1/tables/slaves": lambda v: v[::-1],
    "bodies/1/tables/blockOrder": lambda v: 0 * v,
}


@pytest.mark.parametrize("name", OTHER_KIND_OR_ORDER)
def test_arrays_of_another_kind_or_order_are_refused(name):
    makeScene().save("a.h5")
    with opened("a.h5") as h5:
        values = OTHER_KIND_OR_ORDER[name](h5[name][...])
        del h5[name]
        h5[name] = values
    with pytest.raises(ValueError, match="checkpoint 'a.h5'"):
        mpm.load("a.h5")


def test_an_array_larger_than_the_file_is_refused_before_memory_is_taken(tmp_path):
    makeScene().save("a.h5")
    for options in ({"compression": "gzip"}, {"chunks": (2**20,)}, {}):
        with opened("a.h5") as h5:
            del h5["bodies/0/particles/mass"]
            h5.create_dataset("bodies/0/particles/mass", (2**32,), float, **options)  # 32 GB of nothing
        with pytest.raises(
            ValueError, match="mass (is compressed|with the shape .* is larger than the file)"
        ):
            mpm.load("a.h5")


def test_an_array_in_another_file_is_refused(tmp_path):
    makeScene().save("a.h5")
    with h5py.File("b.h5", "w") as h5:
        h5["mass"] = np.ones(16)
    with opened("a.h5") as h5:
        del h5["bodies/0/particles/mass"]
        h5["bodies/0/particles/mass"] = h5py.ExternalLink("b.h5", "/mass")
    with pytest.raises(ValueError, match="mass is a link to elsewhere"):
        mpm.load("a.h5")
