# SPDX-License-Identifier: GPL-2.0-or-later
"""Studies: cases that end in every way, one table, what runs again and what does not; functions."""

import io
import json
import os
import shutil
from pathlib import Path

import pandas
import pytest
import yade_mpm as mpm
from yade_mpm.study import program, state
from yade_mpm.study.execution import jobsAndThreads
from yade_mpm.study.identity import codeVersion, sceneSource
from yade_mpm.study.live import Live
from yade_mpm.study.study import Study

SCENE = Path(__file__).with_name("demo_scene.py")
TIMEOUT = 3  # s

ENDS = {  # state, message, what the log tells
    "well": (state.DONE, "", "hello of well"),
    "raises": (state.FAILED, "ZeroDivisionError: on purpose", "Traceback"),
    "refused": (state.FAILED, "demo_scene: does not want to", "does not want to"),
    "nan": (state.FAILED, "not a number: height", "hello of nan"),
    "killed": (state.FAILED, "killed by SIGKILL", "hello of killed"),
    "silent": (state.FAILED, "ended with 3: hello of silent", "hello of silent"),
    "sleeps": (state.TIMED_OUT, f"after {TIMEOUT} s", ""),  # may end before it has said hello
}


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """Study of every end, run once; its table, and what it said."""
    out = tmp_path_factory.mktemp("study")
    Study(SCENE, {"end": ["sleeps"]}, out, threads=1).run(jobs=1, timeout=TIMEOUT, quiet=True)
    study = Study(SCENE, {"end": list(ENDS)}, out, threads=1)
    return study, study.run(jobs=3, quiet=True)


@pytest.mark.parametrize("end", ENDS)
def test_a_case_that_fails_is_told_and_touches_no_other(studied, end):
    study, table = studied
    how, message, said = ENDS[end]
    row = table[table["end"] == end].iloc[0]
    assert (row["state"], row["message"]) == (how, message)
    folder = study.folders[list(ENDS).index(end)]
    assert said in state.endOfLog(folder)


def test_the_table_is_tidy(studied):
    study, table = studied
    assert list(table["case"]) == [os.path.basename(f) for f in study.folders]
    done = table[table["state"] == state.DONE]
    assert done["fallen"].iloc[0] == pytest.approx(0.5 * 10 * 0.1**2, rel=0.02)
    assert table["fallen"].notna().sum() == len(done) == 1
    written = pandas.read_csv(Path(study.out) / "results.csv")
    assert list(written.columns) == list(table.columns) and len(written) == len(ENDS)


def test_finished_cases_are_not_run_again_and_failed_ones_if_asked(studied, tmp_path):
    study, _ = studied
    started = (Path(study.out) / "started").read_text()
    again = Study(SCENE, {"end": list(ENDS)}, study.out, threads=1)
    assert again.folders == study.folders and again.waiting() == []
    again.run(quiet=True)
    assert (Path(study.out) / "started").read_text() == started
    assert len(again.waiting(retry=True)) == len(ENDS) - 1
    refused = Study(SCENE, {"end": ["refused"]}, study.out, threads=1)
    attempts = state.read(refused.folders[0])["attempts"]
    refused.run(quiet=True, retry=True)
    assert state.read(refused.folders[0])["attempts"] > attempts


def test_other_arguments_another_scene_or_another_code_make_another_case(studied, tmp_path, monkeypatch):
    name = os.path.basename(studied[0].folders[0])

    def names(scene, **values):
        return os.path.basename(Study(scene, [{"end": "well", **values}], tmp_path / "o").folders[0])

    copy = shutil.copy(SCENE, tmp_path)
    assert names(copy) == name == names(SCENE, gravity=10.0) != names(SCENE, gravity=9.0)
    Path(copy).write_text(SCENE.read_text() + "\n# changed\n")
    assert names(copy) != name
    monkeypatch.setattr("yade_mpm.study.identity.codeVersion", lambda: codeVersion() + "x")
    assert names(SCENE) != name


def test_the_source_of_a_scene_has_what_it_imports_from_beside_it(tmp_path):
    (tmp_path / "a.py").write_text("import b\nimport os\n")
    (tmp_path / "b.py").write_text("x = 1\n")
    before = sceneSource(tmp_path / "a.py")
    assert sceneSource(tmp_path / "a.py") == before
    (tmp_path / "b.py").write_text("x = 2\n")
    assert sceneSource(tmp_path / "a.py") != before


@pytest.mark.parametrize(
    "cases, message",
    [
        ([], "there is no case"),
        ([{"gravity": -1}], r"case 1 \(gravity -1\): argument --gravity: -1 is not allowed"),
        ([{"g": 1}], "there is no parameter 'g'"),
        ([{"gravity": 1}, {"gravity": 1.0}], "cases 1 and 2 are the same"),
    ],
)
def test_what_the_scene_does_not_allow_is_said_before_anything_runs(cases, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        Study(SCENE, cases, tmp_path)
    (tmp_path / "none.py").write_text("")
    with pytest.raises(ValueError, match="has no PARAMETERS"):
        Study(tmp_path / "none.py", [{}], tmp_path)


def test_a_parameter_may_not_be_named_as_a_column_of_the_table(tmp_path):
    with pytest.raises(ValueError, match="a parameter is named 'seconds', as a column of its table is"):
        Study(lambda a: None, [{"seconds": 1.0}], tmp_path / "o")


def test_functions_are_studied_too_with_the_bits_of_a_run_alone(tmp_path):
    import demo_scene

    def results(scene):
        return {"height": float(scene["block"].position[:, 1].mean()), "steps": scene.steps}

    axes = {"gravity": [5.0, 10.0]}
    how = dict(until=0.05, out=tmp_path, parameters=demo_scene.PARAMETERS, jobs=2, threads=1, quiet=True)
    table = mpm.study.run(demo_scene.build, axes, results, **how)
    assert list(table["state"]) == [state.DONE] * 2 and list(table["gravity"]) == axes["gravity"]
    for gravity, height in zip(table["gravity"], table["height"]):
        scene = demo_scene.build(demo_scene.PARAMETERS.parse(["--gravity", str(gravity)]))
        scene.run(until=0.05)
        assert results(scene)["height"] == height
    assert mpm.study.run(demo_scene.build, axes, results, **how).equals(table)


def test_a_build_that_forgets_to_return_its_scene_is_told(tmp_path):
    def build(a):
        mpm.Scene((0, 0), (1, 1), 0.25)

    table = mpm.study.run(
        build, {"x": [1]}, lambda scene: {"n": scene.steps}, out=tmp_path, jobs=1, quiet=True
    )
    assert table["message"][0] == "TypeError: build returned None; end it with `return scene`"


def test_a_command_line_runs_a_study(tmp_path, capsys, monkeypatch):
    (tmp_path / "t.csv").write_text("gravity\n5\n10\n")
    words = [str(SCENE), "--table", "t.csv", "perCell=1,2", "--until", "0.02", "--out", "o", "--jobs", "3"]
    program.main([*words, "--yade-table", "y.table"])
    assert Path("y.table").read_text().splitlines()[:2] == ["gravity  perCell", "5.0  1"]
    program.main(words)
    assert "4 done; see " in capsys.readouterr().out and Path("o/report.html").exists()
    kept = [json.loads(f.read_text()) for f in Path("o/cases").glob("*/arguments.json")]
    assert sorted((a["gravity"], a["perCell"], a["until"]) for a in kept) == [
        (gravity, n, 0.02) for gravity in (5, 10) for n in (1, 2)
    ]
    with pytest.raises(SystemExit) as end:
        program.main([str(SCENE), "end=refused", "--out", "p"])
    assert end.value.code == 1 and "does not want to" in capsys.readouterr().out


def test_jobs_and_threads_fill_the_cores(monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda who: set(range(8)))
    assert jobsAndThreads(100, memory=0.01) == (8, 1) and jobsAndThreads(2, memory=0.01) == (2, 4)
    assert jobsAndThreads(100, threads=2, memory=0.01) == (4, 2)
    assert jobsAndThreads(100, jobs=3, memory=0.01) == (3, 2)
    assert jobsAndThreads(100, memory=1e9) == (1, 8)


def test_the_terminal_shows_what_runs(tmp_path):
    folders = [str(tmp_path / name) for name in "abc"]
    for folder in folders:
        os.makedirs(folder)
    said = io.StringIO()
    said.isatty = lambda: True
    live = Live(dict(zip(folders, ("one", "two", "three"))), 2, said)
    live.ended(folders[0], state.write(folders[0], state.DONE, seconds=1.0))
    state.write(folders[1], state.RUNNING, began=0)
    live.look()
    assert "1/3 done in 1.0 s  one" in said.getvalue()
    assert "1 done, 1 running, 1 waiting; two" in live.headline()
