# SPDX-License-Identifier: GPL-2.0-or-later
"""The verification manual: its cases meet their references, and its page shows all of them."""

import re
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "doc"))
import verificationCases as cases  # noqa: E402

PAGE = (ROOT / "doc" / "explanation" / "verification-manual.md").read_text()


@pytest.fixture(autouse=True)
def noScreen():
    before = plt.get_backend()
    plt.switch_backend("Agg")
    yield
    plt.close("all")
    plt.switch_backend(before)


SLOW = ("D5", "D20", "GV")  # their own tests run by default


@pytest.mark.parametrize(
    "number", [pytest.param(n, marks=pytest.mark.slow if n in SLOW else ()) for n in cases.CASES]
)
def test_a_case_meets_its_reference_in_table_and_picture(number):
    table = cases.show(number)
    assert all(row.passes for row in table.rows), table.rows
    (axes,) = plt.gcf().axes
    labels = " ".join(axes.get_legend_handles_labels()[1])
    assert "reference" in labels and axes.get_xlabel() + axes.get_ylabel()
    text = table._repr_html_()
    assert text.count("<tr>") == len(table.rows) + 1 and table.version in text


def test_control_a_row_that_misses_its_tolerance_is_red(monkeypatch):
    row, *_ = cases.CASES["D12"](plt.figure().subplots())
    assert row.passes
    monkeypatch.setattr(cases.point, "elastic", lambda: cases.point.soil(cohesion=1e9))  # the other law
    table = cases.show("D12")
    assert not table.rows[0].passes and 'style="background:#fde4e1"' in table._repr_html_()


def test_the_page_shows_every_case_under_a_heading():
    assert re.findall(r'^cases\.show\("(\w+)"\)', PAGE, re.M) == list(cases.CASES)
    assert re.findall(r"^## (\w+):", PAGE, re.M) == list(cases.CASES)
