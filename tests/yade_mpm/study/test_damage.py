# SPDX-License-Identifier: GPL-2.0-or-later
"""One damaged file, one odd name or one negative number costs one case at most, never the study."""

import warnings
from pathlib import Path

import pytest
from yade_mpm.study import cases, identity, state
from yade_mpm.study.study import Study, parametersOf

SCENE = Path(__file__).with_name("curve_scene.py")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("whole")
    study = Study(SCENE, {"x": [1.0, 2.0, 3.0]}, out)
    study.run(jobs=3, quiet=True)
    return study


@pytest.mark.parametrize(
    "name, text",
    [(n, t) for n in ("state.json", "summary.json") for t in ("", "[1]", '{"a', None, "\0")]
    + [("state.json", "{}"), ("case.json", '{"a')],
)
def test_a_damaged_file_is_a_case_that_is_run_again(whole, name, text):
    file = Path(whole.folders[1], name)
    kept = file.read_text()
    file.unlink() if text is None else file.write_text(text)
    again = Study(SCENE, whole.cases, whole.out)
    assert again.waiting() == ([] if name == "case.json" else [whole.folders[1]])
    if name == "summary.json":
        assert f"{file} is missing or damaged" in state.read(whole.folders[1])["message"]
    elif name == "state.json" and text is not None:
        assert f"{file} is damaged" in state.read(whole.folders[1])["message"]
    if text == "":
        table = again.run(jobs=1, quiet=True)
        assert list(table["state"]) == [state.DONE] * 3 and list(table["y"]) == [1, 2, 3]
    else:
        file.write_text(kept)


def test_a_name_that_is_no_formula_does_not_end_a_study(tmp_path):
    def build(a):
        raise RuntimeError("no")

    study = Study(build, {"$x_": [1.0, 2.0], r"\frac{": [1, 2]}, tmp_path)
    for folder in study.folders:
        state.saveJson(f"{folder}/summary.json", {"$y^": 1.0 + len(folder), "z": float(folder[-1] > "7")})
        state.write(folder, state.DONE, seconds=1.0)
    study.write()
    assert "$x_" in (tmp_path / "report.html").read_text()


def test_a_report_never_ends_a_run(whole, monkeypatch):
    def fails(*_):
        raise ZeroDivisionError("odd")

    monkeypatch.setattr("yade_mpm.study.report.write", fails)
    with pytest.warns(UserWarning, match="the report of .* is not written: ZeroDivisionError: odd"):
        assert list(whole.run(quiet=True)["state"]) == [state.DONE] * 3
    with pytest.raises(ZeroDivisionError):
        whole.write()


def test_negative_numbers_and_words_are_values(tmp_path):
    """argparse takes -1e-5 for an option."""
    parameters = parametersOf(SCENE)
    for values in ({"x": -1e-5}, {"x": -2.0}, {"how": "-none"}):
        name, value = next(iter(values.items()))
        assert getattr(parameters.parse(parameters.words(values)), name) == value
    assert parameters.parse(["--x", "-1e-05"]).x == -1e-5
    assert cases.fromWords(["x=-1e-5,-2"], parameters) == [{"x": -1e-5}, {"x": -2.0}]
    study = Study(SCENE, [{"x": -1e-5}], tmp_path, words=["--how", "falls"])
    assert list(study.run(jobs=1, quiet=True)["y"]) == [-1e-5]


@pytest.mark.parametrize("text", ["\ufeffx,how\n1,falls\n", "x;how\n1;falls\n", "\ufeffx;how\r\n1;falls\r\n"])
def test_tables_of_spreadsheets_are_read(text):
    Path("t.csv").write_text(text, encoding="utf-8")
    assert cases.readTable("t.csv", parametersOf(SCENE)) == [{"x": 1.0, "how": "falls"}]


def test_a_column_that_is_there_twice_is_refused():
    Path("t.csv").write_text("x,how,x\n1,falls,2\n")
    with pytest.raises(ValueError, match="t.csv: there are two columns 'x'; give each once"):
        cases.readTable("t.csv", parametersOf(SCENE))


@pytest.mark.parametrize(
    "words", [["x=0:1e9:1"], ["x=0:1e4:1", "how=rises,falls,turns", "z=0:10:1"], ["x=0:inf:1"]]
)
def test_too_many_cases_are_refused_at_once(words):
    class Any:
        def read(self, name, text):
            return text

    with pytest.raises(ValueError, match="cases are too many; give at most 100000|is not allowed"):
        cases.fromWords(words, Any())


def test_a_dashboard_without_a_scheduler_is_refused(whole):
    with pytest.raises(ValueError, match="the dashboard is that of a Dask scheduler; give --scheduler"):
        whole.run(dashboard=True, quiet=True)


def test_the_number_of_cases_costs_linear_time(tmp_path, monkeypatch):
    """Parameters that differ were looked for once for each label, and equal cases by a search of a list."""
    looked = []

    class Values(dict):
        def get(self, *name):
            looked.append(name)
            return super().get(*name)

    monkeypatch.setattr(identity, "codeVersion", lambda: "1")
    study = Study(lambda a: None, {"x": [float(i) for i in range(300)]}, tmp_path)
    study.cases = [Values(case) for case in study.cases]
    del study.__dict__["varied"]
    with warnings.catch_warnings():
        study.labels = dict(zip(study.folders, map(study._label, study.cases)))
    assert len(looked) <= 3 * 300
