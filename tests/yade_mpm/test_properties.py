# SPDX-License-Identifier: GPL-2.0-or-later
"""Any mesh and any expression works or is refused in words: made up by Hypothesis, seconds each.

YADE_MPM_FUZZ_SECONDS=600 scripts/test tests/yade_mpm/test_properties.py looks for longer.
"""

import os

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.io.expression import Expression

hypothesis = pytest.importorskip("hypothesis")  # of scripts/setup --test
given, settings, strategies = hypothesis.given, hypothesis.settings, hypothesis.strategies

BUDGET = float(os.environ.get("YADE_MPM_FUZZ_SECONDS", 3.0))  # s for each test, about
RATE = 30  # examples in a second, about
MOST_TEXT = 3000  # characters of an error
REFUSALS = (ValueError, TypeError, MemoryError)


madeUp = settings(  # the same examples every time, unless there is more time
    max_examples=int(RATE * BUDGET),
    deadline=None,
    database=None,
    derandomize=BUDGET <= 10,
    suppress_health_check=list(hypothesis.HealthCheck),
)


def refused(action):
    """What an action returns, or None if it was refused in words."""
    try:
        return action()
    except REFUSALS as error:
        assert str(error) and len(str(error)) < MOST_TEXT, repr(error)[:300]
        return None


points = strategies.lists(strategies.tuples(*[strategies.integers(0, 4)] * 2), min_size=1, max_size=9)
cells = strategies.lists(strategies.tuples(*[strategies.integers(-1, 9)] * 4), min_size=1, max_size=4)


@madeUp
@given(points, cells, strategies.lists(strategies.integers(-1, 9), max_size=2), strategies.data())
def test_a_mesh_is_right_or_refused(points, cells, slaves, data):
    masters = [data.draw(strategies.tuples(*[strategies.integers(-1, 9)] * 4)) for _ in slaves]
    weights = [data.draw(strategies.tuples(*[strategies.sampled_from([0, 0.5, 1.0])] * 4)) for _ in slaves]
    mesh = mpm.Mesh(
        np.array(points, float), np.array(cells), np.array(slaves, int), np.array(masters), np.array(weights)
    )
    if not slaves:
        mesh = mpm.Mesh(mesh.points, mesh.cells)
    scene = mpm.Scene((0, 0), (4, 4), 1.0)
    elastic = mpm.LinearElastic(density=1.0, lame=(1.0, 1.0))
    body = refused(lambda: scene.add("m", mesh, elastic, mpm.APDI()))
    if body is None:
        assert len(scene.bodies) == 0
        return
    assert body.volume.sum() <= 16 + 1e-9, "no place is covered twice"
    scene.engines  # noqa: B018 - made
    refused(lambda: scene.prepare())


@madeUp
@given(strategies.text(alphabet="scene.np()[]'abx0123456789+-*/<>=, _lambdiforg", max_size=40))
def test_an_expression_gives_a_value_or_is_refused(text):
    try:
        expression = Expression(text, "History: column 'a'")
        expression(mpm.Scene((0, 0), (1, 1), 0.5))
    except (*REFUSALS, LookupError, SyntaxError, ArithmeticError, AttributeError) as error:
        assert len(str(error)) < MOST_TEXT
