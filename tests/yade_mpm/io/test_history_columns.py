# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns of a History that users give, and its file."""

# SPDX-License-Identifier: GPL-2.0-or-later
import json
import os

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from historyScenes import assertSameColumns, engines, makeScene, press, readCSV, runWith
from inputs import refused
from yade_mpm import diagnostics


def again(history):
    """A history as a checkpoint makes it."""
    other = mpm.History(**json.loads(json.dumps(history.spec())))
    other.restoreState(json.loads(json.dumps(history.state())))
    return other


def test_columns_of_the_user_are_functions_or_text():
    history = mpm.History(
        iterPeriod=20,
        columns={
            "toe": "scene['pile'].position[:, 1].min()",
            "N": lambda scene: diagnostics.sectionForce(scene["pile"], 1.25),
        },
    )
    scene = runWith(history, steps=60)
    assert history["toe"][-1] == scene["pile"].position[:, 1].min()
    assert history["N"][-1] == diagnostics.sectionForce(scene["pile"], 1.25) != 0
    history.columns["late"] = lambda scene: 7
    scene.run(steps=20, progress=False)
    assert np.array_equal(history["late"], [np.nan, np.nan, np.nan, 7], equal_nan=True)


def test_columns_that_are_added_together_are_looked_at_like_single_ones():
    history = mpm.History(iterPeriod=20)
    history.columns.update({"toe": "scene['pile'].position[:, 1].min()"}, at="scene.steps")
    scene = runWith(history, steps=20)
    assert history["toe"][-1] == scene["pile"].position[:, 1].min() and history["at"][-1] == 20
    with pytest.raises(TypeError, match="column 'a' = 7; give a function"):
        history.columns.update(a=7)


def test_one_function_may_give_several_columns_and_is_called_once_a_row():
    calls = []

    def both(scene):
        calls.append(scene.steps)
        return scene["pile"].position[:, 1].min(), np.float64(scene.steps)

    history = mpm.History(iterPeriod=20, columns={"first": "scene.time", ("toe", "at"): both, "last": "1"})
    scene = runWith(history, steps=60)
    assert history.names[-4:] == ["first", "toe", "at", "last"]
    assert calls == [20, 40, 60] == list(history["at"])
    assert history["toe"][-1] == scene["pile"].position[:, 1].min()
    assert history.spec()["columns"] == {"first": "scene.time", "toe": None, "at": None, "last": "1"}
    other = again(history)
    other.columns.update({("toe", "at"): both})
    scene.engines = [*scene.engines[:5], other]
    scene.run(steps=20, progress=False)
    assert other.names == history.names
    assert other["at"][-1] == 80
    assert other["toe"][-1] == scene["pile"].position[:, 1].min()


@pytest.mark.parametrize("found", ((1,), (1, 2, 3), 1, (1, None)))
def test_several_columns_need_a_number_each(found):
    with pytest.raises(ValueError, match=r"History: column '\('a', 'b'\)' \(a function\) gives no number"):
        runWith(mpm.History(iterPeriod=5, columns={("a", "b"): lambda scene: found}))


def test_csv_holds_the_same_numbers_with_units_in_the_header(tmp_path):
    history = mpm.History(iterPeriod=10, file=tmp_path / "a.csv")
    scene = runWith(history, steps=30)
    scene.run(steps=30, progress=False)  # appends
    header, rows = readCSV(tmp_path / "a.csv")
    assert header[0] == "time [s]" and "drive.fy [kN/m]" in header
    assert [h.split(" [")[0] for h in header] == history.names
    assert np.array_equal(np.array(rows).T, [history[n] for n in history.names], equal_nan=True)
    assert len(rows) == 6 and os.listdir(tmp_path) == ["a.csv"]


def test_csv_stays_rectangular_when_a_column_is_added(tmp_path):
    history = mpm.History(iterPeriod=10, file=tmp_path / "a.csv")
    scene = runWith(history, steps=20)
    history.columns["late"] = lambda scene: 7
    scene.run(steps=20, progress=False)
    header, rows = readCSV(tmp_path / "a.csv")
    assert header[-1] == "late" and {len(row) for row in rows} == {len(header)}
    assert np.array_equal([row[-1] for row in rows], [np.nan, np.nan, 7, 7], equal_nan=True)


@pytest.mark.parametrize("label, group", [("", "history"), ("forces", "history/forces")])
def test_the_recorders_file_holds_the_same_columns(tmp_path, label, group):
    history = mpm.History(iterPeriod=10, label=label)
    scene = runWith(history, steps=30, before=[mpm.Recorder(tmp_path / "a.h5", iterPeriod=20)])
    history.columns["late"] = lambda scene: 7
    scene.run(steps=30, progress=False)
    with h5py.File(tmp_path / "a.h5") as h5:
        for name in history.names:
            assert np.array_equal(h5[group][name], history[name], equal_nan=True), name
            assert h5[group][name].attrs["unit"] == history.units[name]
        assert h5["VTKHDF/Steps"].attrs["NSteps"] == 4


def test_a_history_loaded_from_a_checkpoint_continues_bitwise_in_memory_and_files(tmp_path):
    whole = mpm.History(iterPeriod=20, file=tmp_path / "whole.csv")
    runWith(whole, steps=120, before=[mpm.Recorder(tmp_path / "whole.h5", iterPeriod=20)])

    first = mpm.History(iterPeriod=20, file=tmp_path / "cut.csv")
    save = mpm.PyRunner(
        lambda scene: scene.steps == 50 and scene.save(tmp_path / "state.h5"), iterPeriod=1, label="save"
    )
    scene = makeScene()  # the state is saved amid two rows, after which the files go on for a while
    scene.engines = engines(mpm.Recorder(tmp_path / "cut.h5", iterPeriod=20), first, save, drive=press(scene))
    scene.run(steps=90, progress=False)
    assert len(first) == 4

    scene = mpm.load(tmp_path / "state.h5", callbacks={"save": None})
    second = scene.engines[6]
    assert list(second["step"]) == [20, 40]
    scene.run(steps=70, progress=False)
    assertSameColumns(second, whole)
    assert (tmp_path / "cut.csv").read_text() == (tmp_path / "whole.csv").read_text()
    with h5py.File(tmp_path / "cut.h5") as h5, h5py.File(tmp_path / "whole.h5") as other:
        assert list(h5["VTKHDF/Steps/step"]) == [0, 20, 40, 60, 80, 100, 120]
        for name in whole.names:
            assert np.array_equal(h5["history"][name], other["history"][name], equal_nan=True), name

    scene = mpm.load(tmp_path / "state.h5", callbacks={"save": None})
    spec, state = scene.engines[6].spec(), scene.engines[6].state()
    state["before"] = {}  # the control: of the steps since the checkpoint alone, the mean differs
    forgetful = mpm.History(**spec)
    forgetful.restoreState(state)
    scene.engines = [*scene.engines[:5], forgetful]
    scene.run(steps=70, progress=False)
    assert forgetful["drive.fy"][2] != whole["drive.fy"][2]
    assert forgetful["drive.fy"][3] == whole["drive.fy"][3]


def test_the_spec_keeps_text_columns_and_asks_for_functions_again():
    history = mpm.History(
        period=0.01, columns={"t": "scene.time", "f": lambda scene: 1}, average=False, label="h"
    )
    other = again(history)
    assert dict(other.columns) == {"t": "scene.time", "f": None}
    runWith(other, steps=20)
    assert np.array_equal(other["t"], other["time"]) and np.isnan(other["f"]).all()


def test_a_second_history_needs_a_label():
    with pytest.raises(ValueError, match="same label or file; give each its own"):
        runWith(mpm.History(iterPeriod=5), before=[mpm.History(iterPeriod=7)])
    named = mpm.History(iterPeriod=5, label="fast")
    runWith(named, steps=10, before=[mpm.History(iterPeriod=10)])
    assert len(named) == 2


def of(**columns):
    return {"iterPeriod": 5, "columns": columns}


@pytest.mark.parametrize(
    "given, error, named",
    [
        ({}, ValueError, "give one of the two, positive"),
        (dict(period=1.0, iterPeriod=2), ValueError, "give one of the two, positive"),
        (of(a=7), TypeError, "column 'a' = 7; give a function of the scene, or an expression"),
        (of(**{"a,b": "1"}), ValueError, "may hold no comma"),
        (dict(iterPeriod=5, columns={("a", "b,c"): print}), ValueError, "may hold no comma"),
        (dict(iterPeriod=5, columns={("a", "b"): "1, 2"}), TypeError, "= '1, 2'; give a function of the"),
        (of(a="1 +"), SyntaxError, "History: column 'a' = '1 +' is not allowed: ... ; give"),
    ],
)
def test_wrong_arguments_are_refused(given, error, named):
    refused(named, lambda: mpm.History(**given), error)


def test_a_file_that_cannot_be_written_is_refused_before_the_first_step(tmp_path):
    scene = makeScene()
    with pytest.raises(OSError, match="History '.*a.csv': there is no folder '.*missing'"):
        runWith(mpm.History(iterPeriod=5, file=tmp_path / "missing" / "a.csv"), scene=scene)
    assert scene.steps == 0


@pytest.mark.parametrize(
    "column, told",
    (
        ("1 / 0", r"\(1 / 0\) gives no number: ZeroDivisionError"),
        (lambda scene: scene["nobody"], r"\(a function\) .*KeyError"),
        (
            "scene.bodies[0].nothing.min()",
            r"\(scene.* gives no number: ValueError: body .* has no field 'nothing'",
        ),
    ),
)
def test_a_column_that_gives_no_number_ends_the_run_and_is_named(column, told):
    with pytest.raises(ValueError, match="History: column 'bad' " + told):
        runWith(mpm.History(iterPeriod=5, columns={"good": "1", "bad": column}))


def test_an_unknown_column_names_the_known_ones():
    history = mpm.History(iterPeriod=5)
    runWith(history, steps=5)
    with pytest.raises(KeyError, match="History: there is no column 'drive'; columns: drive.fx, drive.fy"):
        history["drive"]
