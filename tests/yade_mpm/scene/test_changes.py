# SPDX-License-Identifier: GPL-2.0-or-later
"""What was changed between runs is noted, and undone to the last checkpoint."""

import json

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain


@pytest.fixture
def scene(tmp_path):
    one = mpm.Scene((0, 0), (2, 2), 0.25, threads=1)
    rubber = mpm.LinearElastic(density=1, lame=(100, 100))
    one.add("block", mpm.box((0.5, 0.5), (1, 1)), rubber, mpm.UGIMP(perCell=2))
    history = mpm.History(
        period=0.005, file=str(tmp_path / "h.csv"), columns={"top": lambda s: s["block"].position.max()}
    )
    one.engines = [
        *chain(gravity=(0, -10.0), drive=mpm.Drive(one["block"].above(0.9), velocity=(0, -0.1))),
        mpm.Recorder(str(tmp_path / "r.vtkhdf"), period=0.005),
        history,
        mpm.PyRunner(lambda: None, iterPeriod=5, label="nothing"),
    ]
    one.dt = 1e-3
    one.run(steps=10)
    return one


def test_nothing_is_noted_where_nothing_changes(scene):
    scene.run(steps=5)
    scene.run(steps=5)
    assert scene.changes == []


def test_changes_between_runs_are_noted_with_step_and_time(scene, tmp_path):
    solver = scene.engines[1]
    solver.damping = 0.3
    solver.drives[0].velocity = (0, -0.2)
    scene["block"].material.lame = (200, 100)
    scene["block"].isDamped = False
    scene.run(steps=10)
    scene.dt = 5e-4
    scene.run(steps=10)
    noted = {(c["step"], c["what"], str(c["before"]), str(c["after"])) for c in scene.changes}
    assert noted == {
        (10, "GridSolver.damping", "0.0", "0.3"),
        (10, "drive.velocity", "[0.0, -0.1]", "[0.0, -0.2]"),
        (10, "'block'.material.lame", "[100.0, 100.0]", "[200.0, 100.0]"),
        (10, "'block'.material.young", "250.0", str(800 / 3)),  # the same told otherwise
        (10, "'block'.material.poisson", "0.25", str(1 / 3)),
        (10, "'block'.isDamped", "True", "False"),
        (20, "scene.dt", "0.001", "0.0005"),
    }
    assert scene.changes[0]["time"] == pytest.approx(0.01)
    with h5py.File(tmp_path / "r.vtkhdf") as h5:
        assert json.loads(h5["VTKHDF"].attrs["changes"]) == scene.changes


def test_a_checkpoint_keeps_them_and_what_is_changed_behind_it_is_noted_too(scene, tmp_path):
    scene.engines[1].damping = 0.3
    scene.save(tmp_path / "c.h5")
    other = mpm.load(tmp_path / "c.h5", callbacks={"nothing": None})
    assert [c["after"] for c in other.changes] == [0.3]
    other.run(steps=1)
    assert len(other.changes) == 1
    other.engines[1].damping = 0.4
    other.run(steps=1)
    assert [c["after"] for c in other.changes] == [0.3, 0.4]


def test_undo_goes_back_to_the_last_checkpoint_and_on_with_the_same_bits(scene, tmp_path):
    scene.save(tmp_path / "c.h5")
    scene.run(steps=20)
    there, rows = scene["block"].position.copy(), (tmp_path / "h.csv").read_text()
    back = mpm.undo(scene)
    assert (back.steps, scene.steps) == (10, 30)
    back.engines[1].damping = 0.5
    back.run(steps=10)
    again = mpm.undo(back)
    assert again.changes == [] and len(back.changes) == 1
    again.run(steps=20)
    assert np.array_equal(again["block"].position, there) and (tmp_path / "h.csv").read_text() == rows


def test_without_a_checkpoint_there_is_nothing_to_undo(scene, tmp_path):
    with pytest.raises(ValueError, match="wrote no checkpoint; give scene.save"):
        mpm.undo(scene)
    scene.save(tmp_path / "c.h5")
    (tmp_path / "c.h5").write_bytes(b"other")
    with pytest.raises(ValueError, match="has changed"):
        mpm.undo(scene)


def test_what_contact_counts_is_no_change():
    scene = mpm.Scene((0, 0), (2, 2), 0.25, threads=1)
    rubber = mpm.LinearElastic(density=1, lame=(100, 100))
    for name, bottom in (("lower", 0), ("upper", 0.5)):
        body = scene.add(name, mpm.box((0.5, bottom), (1, bottom + 0.5)), rubber, mpm.UGIMP(), group=name)
    body.velocity[...] = (0.1, -0.1)
    contact = mpm.Contact(friction=0.3)
    scene.engines = chain(contact=contact, fixed="bottom")
    scene.run(steps=10)
    scene.run(steps=10)
    assert contact.frictionWork > 0 and scene.changes == []


def test_a_scene_whose_last_body_was_removed_says_what_it_lacks():
    scene = mpm.Scene((0, 0), (2, 2), 0.25, threads=1)
    rubber = mpm.LinearElastic(density=1, lame=(100, 100))
    body = scene.add("block", mpm.box((0.5, 0.5), (1, 1)), rubber, mpm.UGIMP())
    engines = chain()
    scene.engines = engines
    scene.run(steps=1)
    scene.remove(body)
    with pytest.raises(ValueError, match="none has particles"):
        scene.run(steps=1)
