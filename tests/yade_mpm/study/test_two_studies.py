# SPDX-License-Identifier: GPL-2.0-or-later
"""Two studies in one folder: one at a time, each with its own functions."""

import pytest
import yade_mpm as mpm
from yade_mpm.study import state
from yade_mpm.study.lock import Held, holding
from yade_mpm.study.study import Study


def functions(number):
    def build(a):
        return mpm.Scene((0, 0), (1, 1), 0.5)

    def results(scene):
        return {"y": number}

    return build, results


def test_each_study_runs_its_own_functions(tmp_path):
    """Functions of the second one stood in the place of those of the first."""
    one, two = (
        Study(build, {"x": [x]}, tmp_path, results)
        for x, (build, results) in enumerate(map(functions, (2, 3)))
    )
    assert list(one.run(jobs=1, quiet=True)["y"]) == [2]
    assert list(two.run(jobs=1, quiet=True)["y"]) == [3]


def test_functions_that_see_other_values_are_other_cases(tmp_path):
    folders = [
        Study(b, {"x": [1]}, tmp_path, r).folders for b, r in (functions(2), functions(3), functions(2))
    ]
    assert folders[0] != folders[1] and folders[0] == folders[2]


def test_a_folder_in_use_is_refused_and_says_by_whom(tmp_path):
    study = Study(functions(2)[0], {"x": [1]}, tmp_path)
    with holding(tmp_path, "a study (mine.py)"):
        for start in (lambda: study.run(quiet=True), lambda: Study(functions(2)[0], {"x": [2]}, tmp_path)):
            with pytest.raises(RuntimeError, match=r"is in use by a study \(mine.py\), process \d+ on .*"):
                start()
    assert state.read(study.folders[0])["state"] == state.WAITING
    Study(functions(2)[0], {"x": [2]}, tmp_path)


def test_a_lock_waits_as_long_as_it_is_told(tmp_path):
    with holding(tmp_path, "one"):
        two = holding(tmp_path, "two", wait=0.2)
        with pytest.raises(Held, match="one, process"):
            two.__enter__()
