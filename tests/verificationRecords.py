# SPDX-License-Identifier: GPL-2.0-or-later
"""Verification cases: a test states once what it verifies, and its errors become a table of the manual.

    @pytest.mark.verifies("stress at the base", reference="weight above", tolerance=0.02)
    def test_stress_is_the_weight_above(kind, verified):
        verified(computed, exact)

asserts that |computed - exact| / |exact| is within the tolerance. `pytest --record` writes what such tests
measured, and the day, to doc/explanation/verification.csv, which the site shows as a table. Rows of tests
that did not run stay as they are, unless the test states something else.
"""

import ast
import csv
from collections import defaultdict
from datetime import date
from pathlib import Path

import numpy as np
import pytest

TESTS = Path(__file__).resolve().parent
TABLE = TESTS.parent / "doc" / "explanation" / "verification.csv"
STATED = ("test", "what", "reference", "tolerance")
MEASURED = ("error", "order", "runs", "day")
NOT_RUN = "slow, not measured"


def pytest_addoption(parser):
    parser.addoption(
        "--record", action="store_true", help=f"write the errors of verification to {TABLE.name}"
    )


def pytest_configure(config):
    text = (
        "verifies(what, reference, tolerance): the test compares with a reference by the fixture `verified`"
    )
    config.addinivalue_line("markers", text)


@pytest.fixture
def verified(request):
    """Function that asserts the tolerance of the test's mark `verifies`, and records the error."""
    mark = request.node.get_closest_marker("verifies")
    assert mark, "the test has no mark: pytest.mark.verifies(what, reference=..., tolerance=...)"
    measured = []  # smallest error, largest, order

    def check(computed, exact, scale=None, within=None, order=None):
        """scale : what the error is related to, else |exact|. within : tolerance, where it is smaller than
        that of the mark. order : of convergence, which is recorded."""
        tolerance = mark.kwargs["tolerance"] if within is None else within
        assert np.max(tolerance) <= mark.kwargs["tolerance"], "the mark states the largest tolerance"
        exact = np.asarray(exact, dtype=float)
        error = (np.asarray(computed) - exact) / (np.abs(exact) if scale is None else scale)
        measured.append((float(error.min()), float(error.max()), None if order is None else float(order)))
        worst = np.abs(error).max()
        assert (np.abs(error) <= tolerance).all(), (
            f"{mark.args[0]}: error {worst:.3g}, {computed} instead of {exact}"
        )

    request.node.user_properties.append(("verified", measured))
    return check


def statements():
    """Row of each test with the mark: what stands in the source alone."""
    rows = {}
    for path in sorted(TESTS.rglob("test_*.py")):
        text = path.read_text()
        if "mark.verifies(" not in text:
            continue
        tree = ast.parse(text)
        for function in tree.body:
            for mark in getattr(function, "decorator_list", ()):
                if ast.unparse(mark).startswith("pytest.mark.verifies("):
                    test = f"{path.relative_to(TESTS)}::{function.name}"
                    stated = {word.arg: ast.literal_eval(word.value) for word in mark.keywords}
                    what = ast.literal_eval(mark.args[0])
                    allowed = asText([stated["tolerance"]], stated["tolerance"] >= 1e-4)
                    values = test, what, stated["reference"], allowed.lstrip("+")
                    rows[test] = dict(zip(STATED, values))
    return rows


def asText(errors, isPercent):
    """Smallest and largest of the errors in percent, or the largest one where the tolerance is round-off."""
    if not isPercent:
        return f"{max(map(abs, errors)):.0e}"
    percents = (100 * error for error in (min(errors), max(errors)))
    ends = dict.fromkeys(f"{p:+.0f}" if abs(p) >= 10 else f"{round(p, 4) + 0.0:+.2g}" for p in percents)
    return " to ".join(ends) + " %"


def committed():
    """Rows of the table as it stands."""
    if not TABLE.exists():
        return {}
    with TABLE.open(newline="") as file:
        return {row["test"]: row for row in csv.DictReader(file)}


def pytest_terminal_summary(terminalreporter, config):
    if not config.getoption("--record"):
        return
    measured = defaultdict(list)
    for report in terminalreporter.getreports("passed"):
        test = report.nodeid.partition("[")[0].removeprefix(f"{TESTS.name}/")
        measured[test] += [values for name, values in report.user_properties if name == "verified" and values]
    write(measured)
    terminalreporter.line(f"{TABLE}: {sum(map(bool, measured.values()))} rows are measured")


def write(measured):
    """measured : for each test and each of its runs, a list of (smallest error, largest error, order)."""
    before, rows = committed(), statements()
    for test, row in rows.items():
        old = before.get(test, {})
        isKept = row.items() <= old.items()
        row.update({name: old[name] if isKept else "" for name in MEASURED})
        row["error"] = row["error"] or NOT_RUN
        if runs := measured.get(test):
            errors = [error for values in runs for low, high, _ in values for error in (low, high)]
            orders = [order for values in runs for *_, order in values if order is not None]
            row["error"], row["runs"] = asText(errors, "%" in row["tolerance"]), len(runs)
            row["order"] = f"{min(orders):.1f}" if orders else ""
            row["day"] = str(date.today())
    with TABLE.open("w", newline="") as file:
        table = csv.DictWriter(file, [*STATED, *MEASURED], lineterminator="\n")
        table.writeheader()
        table.writerows(rows.values())
