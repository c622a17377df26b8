# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters declared once: command line, defaults that follow from others, checks, words of a case."""

import argparse
import json
from pathlib import Path

import pytest
import yade_mpm as mpm
from asModules import moduleOf
from matplotlib.figure import Figure
from yade_mpm import Parameter, Parameters, app, plot
from yade_mpm.app import commandLine
from yade_mpm.base import program

SCRIPTS = Path(__file__).resolve().parents[3] / "scripts"
INSIDE_YADE = "from yade import"  # such a scene can be read by YADE's Python alone
SCENES = sorted(
    f
    for f in SCRIPTS.rglob("*.py")
    if "\nPARAMETERS = mpm.Parameters(" in f.read_text() and INSIDE_YADE not in f.read_text()
)


def refuse(a, given):
    return "--cell must not be --size" if a.cell == a.size else None


def parameters(**more):
    return Parameters(
        "demo",
        "A demo.",
        Parameter("types", "hybrid", "particle types", choices=("hybrid", "ugimp")),
        Parameter("cell", 0.25, "cells", unit="m", partOf=2.0),
        Parameter("size", lambda a: a.cell / 2, "of boxes", unit="m", above=0),
        Parameter("phi", 30.0, "friction", unit="degrees", least=0, below=60),
        Parameter("count", 3, "how many", least=1, whole=True),
        Parameter("fine", False, "everything smaller", sets={"size": lambda a: a.cell / 4, "phi": 20.0}),
        smoke={"cell": 0.5},
        **{"fixed": {"ramp": 0.5}, "derived": {"area": lambda a: a.size**2}, "check": refuse, **more},
    )


def parse(*words, **more):
    return parameters(**more).parse([*words])


def test_defaults_follow_from_what_is_given():
    assert (parse().size, parse("--cell", "1").size, parse("--cell", "1", "--size", "3").size) == (
        0.125,
        0.5,
        3,
    )
    assert parse("--cell", "1").area == 0.25 and parse().ramp == 0.5


def test_a_switch_sets_defaults_but_not_what_is_given_or_smoke_has():
    a = parse("--fine", "--cell", "1")
    assert (a.size, a.phi, a.fine) == (0.25, 20.0, True)
    assert parse("--fine", "--phi", "10").phi == 10
    assert parse("--smoke").cell == 0.5 and parse("--smoke", "--cell", "1").cell == 1


MEANINGLESS = "coarse, thick and fast: no numbers"


@pytest.mark.parametrize("words, isSmoke", [(["--smoke"], True), (["--cell", "1"], False)])
def test_a_smoke_run_ends_with_what_its_numbers_are_worth(words, isSmoke, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("sys.argv", ["demo", *words])
    monkeypatch.setattr(commandLine, "_drawToFiles", lambda: None)
    monkeypatch.setattr(program, "isSmoke", False)
    picture = Figure()

    def main():
        app.printCheck("quasi-static: every ratio is within its limit")
        plot.save(picture, tmp_path / "a.png")
        print("805 kN/m")

    app.run(main)
    ends = f"--smoke: {MEANINGLESS}" if isSmoke else "805 kN/m"
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == ends
    assert lines[0].startswith(
        "--smoke: the check below judges the run, not the soil" if isSmoke else "quasi"
    )
    assert [text.get_text() for text in picture.texts] == ["coarse: no numbers"] * isSmoke
    said = " ".join(parameters().parser().format_help().split())
    assert MEANINGLESS in said and "number of threads (default: automatic)" in said


@pytest.mark.parametrize(
    "words, message",
    [
        ("--cell 0.3", "--cell: 0.3 is not allowed; give 2 m divided by a whole number, e.g. 0.125"),
        ("--phi 60", "--phi: 60 is not allowed; give a number from 0 to below 60"),
        ("--phi nan", "--phi: nan is not allowed"),
        ("--count 1.5", "--count: 1.5 is not allowed; give a whole number from 1 on"),
        ("--size 0", "--size: 0 is not allowed; give a positive number"),
        ("--types gimp", "invalid choice: 'gimp'"),
        ("--size 0.25", "--cell must not be --size"),
    ],
)
def test_what_is_not_allowed_is_said_before_anything_runs(words, message, capsys):
    assert message in parameters().problem(words.split())
    with pytest.raises(SystemExit):
        parse(*words.split())
    assert message in capsys.readouterr().err


def test_a_default_outside_of_its_range_is_refused():
    with pytest.raises(ValueError, match="Parameter phi: the default 70.0 is not allowed"):
        Parameter("phi", 70.0, most=60)
    with pytest.raises(ValueError, match="smoke names \\['cells'\\]"):
        Parameters("demo", "", smoke={"cells": 1})


def test_choices_without_end_are_refused():
    with pytest.raises(ValueError, match="Parameter n: more than 1000 choices; give a range by `least` and"):
        Parameter("n", 1, choices=range(10**9))


def test_help_tells_default_unit_and_range():
    text = " ".join(parameters().parser().format_help().split())
    assert "--phi degrees friction; degrees; a number from 0 to below 60 (default 30)" in text
    assert "--fine everything smaller; unless given: " in text


def test_words_of_a_case_are_read_as_the_case():
    case = {"types": "ugimp", "cell": 1 / 3 * 3, "fine": True, "count": 4, "phi": 12.3}
    a = vars(parse(*parameters().words(case)))
    assert {name: a[name] for name in case} == case
    assert parameters().words({"fine": False}) == []
    with pytest.raises(ValueError, match="there is no parameter 'fi'; it has cell, count"):
        parameters().words({"fi": 1})


def test_texts_are_read_as_the_command_line_reads_them():
    read = parameters().read
    assert (read("phi", "25"), read("fine", "yes"), read("count", "2")) == (25.0, True, 2)
    with pytest.raises(ValueError, match="demo: --phi: 99 is not allowed"):
        read("phi", "99")


def test_a_study_has_the_parameters_of_its_scene_and_more():
    more = parameters().extended("more", "", Parameter("ramp", 0.1, least=0), check=None)
    assert more.parse([]).ramp == 0.1 and more.parse(["--ramp", "2", "--size", "0.25"]).ramp == 2


def test_what_is_derived_is_found_again_in_a_resumed_run(tmp_path):
    (tmp_path / "c.h5").touch()
    kept = {**vars(parse(resume=("count",))), "out": str(tmp_path), "area": -1}
    (tmp_path / "arguments.json").write_text(json.dumps(kept))
    (tmp_path / "c.h5").touch()
    a = parse("--resume", str(tmp_path / "c.h5"), "--count", "7", resume=("count",))
    assert (a.area, a.count, a.size) == (0.125**2, 7, 0.125)


@pytest.mark.parametrize("file", SCENES, ids=lambda f: f.stem)
def test_every_scene_takes_its_own_defaults(file):
    known = moduleOf(file).PARAMETERS
    assert isinstance(known, mpm.Parameters) and known.scene == file.stem and len(list(known)) > 0
    a = known.parse([])
    given = {p.name: p.default for p in known if not callable(p.default)}
    assert isinstance(a, argparse.Namespace) and vars(known.parse(known.words(given))) == vars(a)
    assert not any(map(callable, vars(a).values())) and json.dumps(vars(a))
