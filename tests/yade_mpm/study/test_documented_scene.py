# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene of doc/howto/studies.md, by the study command."""

import argparse
import json
import shutil
from pathlib import Path

import pandas
import pytest
import yade_mpm as mpm
from yade_mpm.study import program
from yade_mpm.study.study import parametersOf

SCENE = Path(__file__).resolve().parents[3] / "doc" / "howto" / "my_scene.py"


def test_the_scene_of_the_page_can_be_studied(tmp_path):
    shutil.copy(SCENE, tmp_path)
    program.main(["my_scene.py", "young=500,1000", "--smoke", "--until", "0.1", "--out", "mine"])
    table = pandas.read_csv("mine/results.csv")
    assert list(table["state"]) == ["done", "done"] and (table["settlement"] > 0).all()
    (case, *_) = (tmp_path / "mine" / "cases").iterdir()
    assert (case / "curve_settlement.csv").exists()
    assert json.loads((case / "summary.json").read_text())["settlement"] > 0


def test_a_scene_that_runs_when_it_is_read_is_refused(tmp_path):
    file = tmp_path / "eager.py"
    file.write_text(
        "import yade_mpm as mpm\nPARAMETERS = mpm.Parameters('eager', 'A scene.', mpm.Parameter('cell', "
        "1.0))\na = PARAMETERS.parse()\n"
    )
    with pytest.raises(
        ValueError, match="it runs when it is read, for a study: .* below `if __name__ =="
    ) as told:
        parametersOf(str(file))
    assert str(file) in str(told.value)


def test_a_run_needs_until_and_resume(tmp_path):
    with pytest.raises(ValueError, match="the arguments have no `until` or no `resume`; give Parameters"):
        mpm.app.Run(argparse.Namespace(out=str(tmp_path)), lambda: None)
