# SPDX-License-Identifier: GPL-2.0-or-later
"""The table of verification fits the tests that exist, and its pictures show a reference."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
import verificationRecords as records

sys.path.insert(0, str(Path(__file__).parents[1] / "doc"))
import verificationPictures  # noqa: E402

pytest_plugins = ["pytester"]


def test_the_table_has_the_cases_of_the_tests():
    stated = records.statements()
    table = {test: {name: row[name] for name in records.STATED} for test, row in records.committed().items()}
    assert table == stated, "run pytest --record"
    assert len(stated) > 50


def test_rows_without_an_error_are_slow_or_need_yade():
    missing = [test for test, row in records.committed().items() if row["error"] == records.NOT_RUN]
    for test in missing:
        path, _, name = test.partition("::")
        text = (records.TESTS / path).read_text()
        before = text.partition(f"def {name}(")[0].rpartition("\n\n\n")[2]
        assert "slow" in before or "needsYade" in text, test


def measure(pytester, monkeypatch, computed):
    """Runs a test of its own that has the mark."""
    monkeypatch.syspath_prepend(records.TESTS)
    pytester.makeconftest('pytest_plugins = ["verificationRecords"]')
    pytester.makepyfile(f"""
        import pytest

        @pytest.mark.verifies("weight", reference="exact", tolerance=0.02)
        def test_weight(verified):
            verified({computed}, 10.0, order=1.9)
    """)
    return pytester.runpytest_inprocess()


def test_an_error_within_the_tolerance_passes_and_is_recorded(pytester, monkeypatch):
    measure(pytester, monkeypatch, 10.1).assert_outcomes(passed=1)


def test_control_an_error_beyond_the_tolerance_fails(pytester, monkeypatch):
    done = measure(pytester, monkeypatch, 10.3)
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(["*weight: error 0.03, 10.3 instead of 10.0*"])


def test_errors_of_all_runs_make_a_row(monkeypatch, tmp_path):
    monkeypatch.setattr(records, "TABLE", tmp_path / "table.csv")
    test = next(test for test, row in records.statements().items() if "%" not in row["tolerance"])
    records.write({test: [[(-2e-15, 1e-15, None)], [(0.0, 3e-15, 1.96)]]})
    row = records.committed()[test]
    assert (row["error"], row["order"], row["runs"]) == ("3e-15", "2.0", "2")
    records.write({})  # a later run of other tests keeps it
    assert records.committed()[test] == row
    changed = records.statements()
    changed[test]["tolerance"] = "0.1 %"
    monkeypatch.setattr(records, "statements", lambda: changed)
    records.write({})  # but not what a test with another tolerance measured
    assert records.committed()[test]["error"] == records.NOT_RUN
    assert records.asText([-0.013, 0.00521], True) == "-1.3 to +0.52 %"


@pytest.fixture
def noScreen():
    before = plt.get_backend()
    plt.switch_backend("Agg")
    yield
    plt.close("all")
    plt.switch_backend(before)


SLOW = ("test_D05_hydrostatic_column", "test_D20_local_damping", "test_GV_generalized_vortex")


@pytest.mark.parametrize(
    "module",
    [
        pytest.param(m, marks=pytest.mark.slow if m.__name__ in SLOW else (), id=m.__name__)
        for m in verificationPictures.PICTURES
    ],
)
def test_a_picture_shows_its_reference(noScreen, module):
    _, axes = plt.subplots()
    verificationPictures.PICTURES[module](axes)
    assert any("reference" in text for text in axes.get_legend_handles_labels()[1])
    assert axes.get_xlabel() + axes.get_ylabel()
