# SPDX-License-Identifier: GPL-2.0-or-later
"""What newcomers write first: one clear line for each; nothing of an earlier run is lost without a word."""

import copy
import pickle
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box
from yade_mpm.scene import progress

SOIL = dict(density=2.0, young=1e4, poisson=0.3)


def makeScene(*engines, **solver):
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    scene.add("block", box((0.5, 0.5), (1.5, 1.5)), mpm.LinearElastic(**SOIL), mpm.UGIMP())
    if solver or engines:
        scene.engines[1] = mpm.GridSolver(**solver)
        scene.engines = [*scene.engines, *engines]
    return scene


def test_walls_and_motions_are_told_the_call_that_makes_them():
    scene = makeScene()
    calls = {"fixed": "fix", "roller": "roller", "fix": "fix", "drive": "drive", "hold": "drive"}
    for name, call in (calls | {"contact": "contact"}).items():
        with pytest.raises(AttributeError, match=rf"{name}.*; call scene\.{call}\("):
            setattr(scene, name, 1)
    with pytest.raises(AttributeError, match="'threads'"):  # control: another name
        scene.thread = 1


def test_a_drive_is_no_engine_however_it_gets_there():
    scene = makeScene(fixed="bottom")
    drive = mpm.Drive(scene["block"].above(1), (0, -1))
    told = r"GridSolver\(drive="
    with pytest.raises(TypeError, match=told):
        scene.engines = [*scene.engines, drive]
    scene.engines.append(drive)
    with pytest.raises(TypeError, match=told):
        scene.run(steps=1)


def test_arguments_that_have_names_are_told():
    with pytest.raises(TypeError, match="2 were given"):
        mpm.UGIMP(2)
    with pytest.raises(TypeError, match=r"box.*4 were given"):
        box(0, 0, 4, 2)


@pytest.mark.parametrize("taken", [pickle.dumps, copy.deepcopy])
def test_scenes_bodies_and_drives_are_not_copied(taken):
    scene = makeScene()
    drive = mpm.Drive(scene["block"], (0, -1))
    for thing, told in ((scene, "scene.save"), (scene["block"], "copies a field"), (drive, "make another")):
        with pytest.raises(TypeError, match=told):
            taken(thing)


def test_a_scene_that_nothing_will_ever_move_says_so():
    with pytest.warns(UserWarning, match="no engines were given"):
        makeScene().run(steps=1)
    thrown = makeScene()
    thrown["block"].velocity[:] = 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        thrown.run(steps=1)
        makeScene(gravity=(0, -9.81)).run(steps=1)


def test_results_of_an_earlier_run_are_not_replaced_without_a_word(tmp_path):
    def engines():
        return (
            mpm.Recorder(tmp_path / "a.vtkhdf", iterPeriod=1),
            mpm.History(iterPeriod=1, file=tmp_path / "a.csv"),
        )

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = makeScene(*engines(), fixed="bottom")
        scene.run(steps=2)
        scene.run(steps=2)  # goes on, and so does what its checkpoint brings back
        scene.save(tmp_path / "half.h5")
        mpm.load(tmp_path / "half.h5").run(steps=2)
    with pytest.warns(UserWarning) as told:
        makeScene(*engines(), fixed="bottom").run(steps=2)
    said = [str(w.message) for w in told]
    assert any("Recorder: " in s and "a.vtkhdf" in s for s in said)
    assert any("History: " in s and "a.csv" in s for s in said)


def test_an_option_is_not_cut_short_but_the_right_one_is_named():
    scene = Path(__file__).parents[3] / "scripts" / "cantilever.py"
    wrong = subprocess.run([sys.executable, scene, "--cel", "0.5"], capture_output=True, text=True)
    assert wrong.returncode == 2 and "'--cell'" in wrong.stderr


def test_the_first_line_of_progress_comes_at_once(capsys):
    scene = makeScene(gravity=(0, -9.81))
    shown = progress.Progress(scene, None, lambda: 100)
    shown.hasBar = False
    shown.update()
    assert capsys.readouterr().err == ""  # control: a short run says nothing
    shown.began -= shown.WAIT
    shown.update()
    shown.update()
    assert len(capsys.readouterr().err.splitlines()) == 1  # and the next one half a minute later


def test_a_notebook_has_a_bar(monkeypatch, capsys):
    class ZMQInteractiveShell:
        pass

    class IPython:
        get_ipython = staticmethod(ZMQInteractiveShell)

    assert not progress.isNotebook()
    monkeypatch.setitem(sys.modules, "IPython", IPython)
    assert progress.isNotebook()
    shown = progress.Progress(makeScene(gravity=(0, -9.81)), True, lambda: 100)
    monkeypatch.delitem(sys.modules, "IPython")
    shown.update()
    assert shown.bar.total == 100
    shown.close()
    assert "0/100" in "".join(capsys.readouterr()) and np.isinf(shown.lastLine)


def test_numbers_in_texts_have_no_power_of_ten_and_one_body_is_no_bodies():
    assert [progress.significant(x) for x in (1684.3, 41.23, 0.5, 23456.0)] == [
        "1680",
        "41.2",
        "0.5",
        "23500",
    ]
    scene = mpm.Scene((0, 0), (2, 2), 0.5)
    for name, said in (("a", ", 1 body, "), ("b", ", 2 bodies, ")):
        at = float(len(scene.bodies))
        scene.add(name, mpm.box((at, 0), (at + 1, 1)), mpm.LinearElastic(density=1, lame=(1, 1)), mpm.UGIMP())
        assert said in repr(scene)
