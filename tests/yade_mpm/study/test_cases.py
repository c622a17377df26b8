# SPDX-License-Identifier: GPL-2.0-or-later
"""Cases of a study from tables, grids and samples."""

import re

import numpy as np
import pytest
from yade_mpm import Parameter, Parameters
from yade_mpm.study import cases

PARAMETERS = Parameters(
    "demo",
    "",
    Parameter("phi", 30.0, least=0, below=60),
    Parameter("psi", 10.0, least=0),
    Parameter("count", 3, least=1, whole=True),
    Parameter("types", "hybrid", choices=("hybrid", "ugimp")),
    Parameter("fbar", False),
)


def words(*given, **how):
    return cases.fromWords(given, PARAMETERS, **how)


def test_a_grid_has_all_combinations():
    assert words("phi=25:35:5", "types=hybrid,ugimp") == [
        {"phi": phi, "types": kind} for phi in (25, 30, 35) for kind in ("hybrid", "ugimp")
    ]
    assert [c["phi"] for c in words("phi=0:0.3:0.1")] == [0, 0.1, 0.2, 0.3]
    assert words("fbar=on,off") == [{"fbar": True}, {"fbar": False}]
    assert words() == [{}]


@pytest.mark.parametrize(
    "word, message",
    [
        ("phi", "give NAME=A,B"),
        ("phi=", "give NAME=A,B"),
        ("fi=3", "there is no parameter 'fi'"),
        ("phi=70", "phi: 70 is not allowed"),
        ("phi=3_0", "phi: 3_0 is not allowed"),
        ("phi=３０", "phi: ３０ is not allowed"),
        ("phi=3_0:35:5", "give FROM:TO:STEP"),
        ("phi=3:1:1", "give FROM:TO:STEP"),
        ("phi=1:3:0", "give FROM:TO:STEP"),
        ("phi=1..3", "ranges need --sample"),
    ],
)
def test_words_that_mean_nothing_are_refused(word, message):
    with pytest.raises(ValueError, match=message):
        words(word)


@pytest.mark.parametrize(
    "word, sample, message",
    [
        ("types=hybrid..ugimp", ("lhs", 4), "NAME=FROM..TO of a number"),
        ("phi=3..1", ("lhs", 4), "lower end first"),
        ("phi=1..3", ("sobol", 5), "power of two, e.g. sobol:4"),
        ("phi=1..3", ("random", 5), "give lhs or sobol"),
        ("phi=1,3", ("lhs", 4), "a sample needs ranges"),
    ],
)
def test_samples_that_mean_nothing_are_refused(word, sample, message):
    with pytest.raises(ValueError, match=message):
        words(word, sample=sample)


@pytest.mark.parametrize("how", ["lhs", "sobol"])
def test_a_sample_fills_its_ranges_evenly_and_is_the_same_for_a_seed(how):
    found = words("phi=20..40", "count=1..9", "types=hybrid,ugimp", sample=(how, 16))
    assert len(found) == 32
    assert found == words("phi=20..40", "count=1..9", "types=hybrid,ugimp", sample=(how, 16))
    phi = np.sort([c["phi"] for c in found[::2]])
    assert (np.floor((phi - 20) / 20 * 16) == np.arange(16)).all()  # one in each sixteenth
    assert all(isinstance(c["count"], int) for c in found)
    assert found != words("phi=20..40", "count=1..9", "types=hybrid,ugimp", sample=(how, 16), seed=1)


def test_tables_are_csv_or_yades(tmp_path):
    (tmp_path / "a.csv").write_text("# three\nphi, types ,fbar\n25,ugimp,1\n,hybrid,\n")
    assert cases.readTable(tmp_path / "a.csv", PARAMETERS) == [
        {"phi": 25.0, "types": "ugimp", "fbar": True},
        {"types": "hybrid"},
    ]
    yade = 'description phi types !OMP_NUM_THREADS\none 25 "ugimp" 2\ntwo * = 2  # as above\n'
    (tmp_path / "b.table").write_text(yade)
    assert cases.readTable(tmp_path / "b.table", PARAMETERS) == [
        {"description": "one", "phi": 25.0, "types": "ugimp"},
        {"description": "two", "types": "ugimp"},
    ]


def test_a_table_written_for_yade_is_read_as_it_was(tmp_path):
    listed = [{"phi": 25.0, "types": "ugimp"}, {"phi": 1 / 3, "fbar": True}]
    cases.writeYadeTable(tmp_path / "t", listed)
    assert cases.readTable(tmp_path / "t", PARAMETERS) == listed


@pytest.mark.parametrize(
    "text, message",
    [
        ("phi\n", "there is no case in it"),
        ("phi,psi\n1\n", "line 2: 1 columns are not allowed; give 2"),
        ("phi,psi\n1,2\n70,1\n", "line 3: demo: --phi: 70 is not allowed"),
        ("phi,fi\n1,2\n", "line 2: demo: there is no parameter 'fi'"),
    ],
)
def test_a_wrong_table_is_told_with_its_line(tmp_path, text, message):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        cases.readTable(tmp_path / "t.csv", PARAMETERS)


@pytest.mark.parametrize(
    "content, message",
    [
        (b"phi\n0.3 \xff\n", "it is no text in UTF-8 (invalid start byte); save it as such"),
        (b"phi  v\n0.3 'a\n", "line 2: No closing quotation; correct the line"),
        (b"phi,v\n0.3," + b"9" * 2000 + b"\n", "line 2: a cell has 2000 characters; correct the line"),
    ],
    ids=["bytes", "quote", "long cell"],
)
def test_a_table_that_is_damaged_is_refused_by_its_name(tmp_path, content, message):
    (tmp_path / "t.csv").write_bytes(content)
    with pytest.raises(ValueError, match=f"t.csv.*{re.escape(message)}"):
        cases.readTable(tmp_path / "t.csv", PARAMETERS)
