# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of results appear whole or not at all."""

import json
import os

import numpy as np
import pytest
from yade_mpm import plot
from yade_mpm.io import files


class Broken:
    """Cannot be written, and is found out late."""


WRITERS = {
    "summary.json": (
        lambda file: files.saveJson(file, {"new": list(range(5000))}),
        lambda file: files.saveJson(file, {"new": list(range(5000)), "b": Broken()}),
    ),
    "table.csv": (
        lambda file: files.saveTable(file, {"x_m": np.arange(9.0)}),
        lambda file: files.saveTable(file, {"x_m": np.array([1.0, Broken()])}),
    ),
    "picture.png": (
        lambda file: plot.save(plot.plt.figure(), file),
        lambda file: plot.save(plot.plt.figure(), file, pil_kwargs={"compress_level": Broken()}),
    ),
}


@pytest.mark.parametrize("name", WRITERS)
def test_an_older_file_stays_until_the_new_one_is_complete(tmp_path, name):
    write, fail = WRITERS[name]
    file = tmp_path / name
    file.write_text("old")
    with pytest.raises((TypeError, AttributeError)):
        fail(str(file))
    assert file.read_text() == "old"
    assert os.listdir(tmp_path) == [name], "nothing half written is left"
    write(str(file))
    assert os.listdir(tmp_path) == [name]
    assert file.read_bytes()[:3] != b"old"


def test_what_is_in_the_files(tmp_path):
    files.saveJson(tmp_path / "a.json", {"at 0.5 m": 1.5})
    assert json.loads((tmp_path / "a.json").read_text()) == {"at 0.5 m": 1.5}
    files.saveTable(tmp_path / "a.csv", {"x_m": [0, 0.5], "y_m": [1, 2]})
    assert (tmp_path / "a.csv").read_text() == "x_m,y_m\n0,1\n0.5,2\n"
