# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints: values to the last bit, callbacks, files that are none."""

import os

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from byHand import describedAnew, opened
from inputs import refused
from yade_mpm import box


@pytest.mark.parametrize(
    "attributes",
    [dict(lame=(9.48e3, 6.31e3)), dict(young=1e4 / 3, poisson=0.3), dict(young=7.7, poisson=1 / 3)],
)
def test_elastic_constants_come_back_to_the_last_bit(tmp_path, attributes):
    scene = mpm.Scene((0, 0), (1, 1), 0.5)
    material = mpm.LinearElastic(density=1.0, **attributes)
    scene.add("a", box((0, 0), (1, 1)), material, mpm.UGIMP())
    scene.save(tmp_path / "a.h5")
    assert mpm.load(tmp_path / "a.h5")["a"].material.attributes() == material.attributes()


def test_a_scene_without_bodies_can_be_saved(tmp_path):
    mpm.Scene((0, 0), (1, 1), 0.5).save(tmp_path / "a.h5")
    assert mpm.load(tmp_path / "a.h5").bodies == ()


def smallScene():
    scene = mpm.Scene((0, 0), (1, 1), 0.5)
    scene.add("a", box((0, 0), (1, 1)), mpm.LinearElastic(density=1.0, lame=(1.0, 1.0)), mpm.UGIMP())
    return scene


class Counter(mpm.engine.Callback):
    """A callback that can be stored."""

    def __init__(self, start, **attributes):
        super().__init__(**attributes)
        self._count = start

    def act(self, scene):
        self._count += 1

    def spec(self):
        return {"start": self._count, "iterPeriod": self.iterPeriod}


class Forgetful(mpm.engine.Callback):
    """A callback that cannot."""

    def act(self, scene):
        pass


def test_callbacks_come_back_by_spec_or_by_label(tmp_path):
    scene, seen = smallScene(), []
    scene.engines = [
        *scene.engines,
        Counter(3, iterPeriod=1),
        mpm.PyRunner(lambda: None, iterPeriod=1, label="watch"),
        Forgetful(iterPeriod=2),
    ]
    scene.run(steps=2)
    scene.save(tmp_path / "a.h5")
    with pytest.raises(ValueError, match="has the callback 'watch', which cannot be stored"):
        mpm.load(tmp_path / "a.h5")
    with pytest.raises(TypeError, match="give an engine of the class Forgetful"):
        mpm.load(tmp_path / "a.h5", callbacks={"watch": None, "Forgetful": print})
    with pytest.raises(ValueError, match="has no callback 'wach'; check the labels"):
        mpm.load(tmp_path / "a.h5", callbacks={"watch": None, "Forgetful": None, "wach": None})
    loaded = mpm.load(
        tmp_path / "a.h5",
        callbacks={"watch": lambda s: seen.append(s.steps), "Forgetful": Forgetful(iterPeriod=2)},
    )
    loaded.run(steps=2)
    assert [type(e).__name__ for e in loaded.engines[-3:]] == ["Counter", "PyRunner", "Forgetful"]
    assert loaded.engines[-3]._count == 7 and seen == [3, 4] and loaded.engines[-2].label == "watch"


def test_files_that_are_no_checkpoint_are_refused(tmp_path):
    file = tmp_path / "a.h5"
    with pytest.raises(FileNotFoundError, match="load: there is no file"):
        mpm.load(file)
    file.write_text("hello")
    with pytest.raises(ValueError, match="is no checkpoint, or damaged: it is not an HDF5 file"):
        mpm.load(file)
    with h5py.File(file, "w") as h5:
        h5["x"] = [1.0]
    with pytest.raises(ValueError, match="is an HDF5 file without the checksum of a checkpoint"):
        mpm.load(file)
    smallScene().save(file)
    with opened(file) as h5:
        h5.attrs["formatVersion"], h5.attrs["package"] = 7, "9.9"
    with pytest.raises(ValueError, match="has format 7, written by yade_mpm 9.9; .* reads format 3"):
        mpm.load(file)


@pytest.mark.parametrize(
    "gone", ["scene", "bodies/0", "bodies/0/particles/stress", "bodies/0/tables/blockStart"]
)
def test_what_is_missing_is_noticed(gone):
    smallScene().save("a.h5")
    with opened("a.h5") as h5:
        del h5[gone]
    with pytest.raises(ValueError, match="damaged|is missing"):
        mpm.load("a.h5")


@pytest.mark.parametrize(
    "change, message",
    [
        (
            lambda s: s["materials"][0].update({"class": "Unobtainium"}),
            "needs the class Unobtainium, which this installation",
        ),
        (lambda s: s["engines"][0].update({"class": "Warp"}), "needs the class Warp"),
    ],
)
def test_unknown_classes_are_named(tmp_path, change, message):
    scene = smallScene()
    scene.prepare()
    scene.save(tmp_path / "a.h5")
    describedAnew(tmp_path / "a.h5", change)
    with pytest.raises(ValueError, match=message):
        mpm.load(tmp_path / "a.h5")


def test_a_checkpoint_is_replaced_as_a_whole(tmp_path, monkeypatch):
    file, scene = tmp_path / "a.h5", smallScene()
    scene.save(file)
    before = file.read_bytes()
    monkeypatch.setattr(os, "fsync", lambda path: (_ for _ in ()).throw(OSError(28, "no space left")))
    told = "a.h5' could not be written: no space left; an older file ... as it was"
    refused(told, lambda: scene.save(file), OSError)
    assert file.read_bytes() == before and os.listdir(tmp_path) == ["a.h5"]


def test_settling_leaves_no_heavy_damping_in_a_checkpoint(tmp_path):
    scene = smallScene()
    scene.engines[1].damping = 0.05
    scene.engines = [
        *scene.engines,
        mpm.PyRunner(lambda s: s.save(tmp_path / "a.h5"), iterPeriod=10, label="save"),
    ]
    scene.settle(damping=0.8, tolerance=1e9, checkEvery=10)
    assert scene.engines[1].damping == 0.05
    with pytest.warns(UserWarning, match=r"was written during settle\(\): call settle\(\) again"):
        assert mpm.load(tmp_path / "a.h5", callbacks={"save": None}).engines[1].damping == 0.05


class Hill(mpm.Region):
    """A region of one's own, which no checkpoint can describe."""

    def __init__(self):
        super().__init__(2)

    def contains(self, points, closed=True):
        return points[:, 1] <= 1 + 0.5 * np.sin(points[:, 0])

    def bounds(self):
        return np.zeros(2), np.array([4.0, 2.0])


def test_a_body_in_a_region_of_ones_own_is_saved_without_it(tmp_path):
    scene = mpm.Scene((0, 0), (4, 3), 0.25, threads=1)
    elastic = mpm.LinearElastic(density=1, young=1e3, poisson=0)
    scene.add("hill", Hill() - mpm.disc((2, 0.5), 0.2), elastic, mpm.UGIMP())
    scene.engines[1] = mpm.GridSolver(gravity=(0, -9.81), fixed="bottom", roller=("left", "right"))
    file = str(tmp_path / "own.h5")
    scene.run(until=0.1, progress=False, checkpointPeriod=0.01, checkpointFile=file)
    scene.save(file)
    again = mpm.load(file)
    for one in (scene, again):
        one.run(steps=5, progress=False)
    assert np.array_equal(again["hill"].stress, scene["hill"].stress) and again["hill"].region is None
    with pytest.raises(ValueError, match="region, which was one of your own"):
        again["hill"].convert(box((0, 0), (1, 0.5)), mpm.APDI())
    with pytest.raises(ValueError, match=r"Hold: where = Hill\(\) is a region of your own"):
        mpm.Hold(Hill(), (0, 0))
