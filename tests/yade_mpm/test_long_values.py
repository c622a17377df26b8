# SPDX-License-Identifier: GPL-2.0-or-later
"""Errors show what was given, and stay short whatever that is."""

import ast
from pathlib import Path

import pytest
import yade_mpm as mpm
from yade_mpm.base.wording import shown

LONG = "a" * 200_000
HUGE = 10**5000  # which has no text
MOST = 500  # characters of an error


def scene():
    made = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    made.add("block", mpm.box((0, 0), (1, 1)), mpm.LinearElastic(density=2, young=1e4, poisson=0.3))
    return made


CALLS = {
    "text": lambda s, value: s.fix(value),
    "number": lambda s, value: setattr(s, "dt", value if value is LONG else -value),
    "key": lambda s, value: s[value],
    "argument": lambda s, value: s.run(until=value if value is LONG else -value),
    "body": lambda s, value: s.contact(value, s["block"]),
    "region": lambda s, value: s["block"].inside(value),
    "vector": lambda s, value: s.drive(s["block"], velocity=[value] * 100_000),
    "engine": lambda s, value: s.engines.__setitem__(0, value) or s.prepare(),
    "column": lambda s, value: s.history(every=1)[value],
    "period": lambda s, value: (
        mpm.PyRunner(value, iterPeriod=1) if value is HUGE else mpm.Recorder(value + ".vtu", period=1)
    ),
    "face": lambda s, value: s.faceNodes(value),
}


@pytest.mark.parametrize("value", [LONG, HUGE], ids=["text", "number"])
@pytest.mark.parametrize("kind", CALLS)
def testAnErrorIsShortWhateverWasGiven(kind, value):
    with pytest.raises((TypeError, ValueError, KeyError)) as told:
        CALLS[kind](scene(), value)
    assert len(str(told.value)) < MOST


def testNoErrorShowsAValueAsLongAsItIs():
    """`{value!r}` in a raise: a value of any size would stand in the message."""
    package = Path(mpm.__file__).parent
    found = [
        f"{path.name}:{part.lineno}"
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Raise)
        for part in ast.walk(node)
        if isinstance(part, ast.FormattedValue) and part.conversion == ord("r")
    ]
    assert [one for one in found if not one.startswith(("clock.py", "permissions.py"))] == []
    assert shown((0, 1.5)) == "(0, 1.5)" and shown("a") == "'a'"  # as they are
