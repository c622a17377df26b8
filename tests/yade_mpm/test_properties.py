# SPDX-License-Identifier: GPL-2.0-or-later
"""Whatever is given to scenes and readers works or is refused in words: made up by Hypothesis, seconds each.

YADE_MPM_FUZZ_SECONDS=600 scripts/test tests/yade_mpm/test_properties.py looks for longer.
"""

import datetime
import io
import json
import os

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.io import checkpoint
from yade_mpm.io.expression import Expression

hypothesis = pytest.importorskip("hypothesis")  # of scripts/setup --test
given, settings, strategies = hypothesis.given, hypothesis.settings, hypothesis.strategies

BUDGET = float(os.environ.get("YADE_MPM_FUZZ_SECONDS", 3.0))  # s for each test, about
RATE = 30  # examples in a second, about
MOST_TEXT = 3000  # characters of an error
REFUSALS = (ValueError, TypeError, MemoryError)


def examples(*arguments):
    """A property of what Hypothesis makes up; the same every time, unless there is more time."""

    def decorate(function):
        def test():
            @settings(
                max_examples=int(RATE * BUDGET),
                deadline=None,
                database=None,
                derandomize=BUDGET <= 10,
                suppress_health_check=list(hypothesis.HealthCheck),
            )
            @given(strategies.tuples(*arguments))
            def once(values):
                function(*values)

            once()

        return test

    return decorate


def refused(action):
    """What an action returns, or None if it was refused in words."""
    try:
        return action()
    except REFUSALS as error:
        assert str(error) and len(str(error)) < MOST_TEXT, repr(error)[:300]
        return None


numbers = strategies.one_of(
    strategies.floats(), strategies.floats(0.01, 10), strategies.integers(), strategies.integers(0, 5)
)
junk = strategies.one_of(
    numbers,
    strategies.none(),
    strategies.booleans(),
    strategies.text(max_size=8),
    strategies.dates(datetime.date(2000, 1, 1), datetime.date(2030, 1, 1)),
    strategies.lists(numbers, max_size=4),
    strategies.builds(np.array, strategies.lists(strategies.floats(), max_size=4)),
)
corners = strategies.one_of(junk, strategies.lists(strategies.integers(-3, 3), min_size=2, max_size=3))


@examples(corners, corners, junk)
def test_a_scene_is_made_or_refused(lower, upper, cell):
    try:  # of huge grids another test tells
        if np.prod((np.subtract(upper, lower, dtype=float)) / np.asarray(cell, float)) > 1e5:
            return
    except (TypeError, ValueError):
        pass
    scene = refused(lambda: mpm.Scene(lower, upper, cell))
    assert scene is None or (np.isfinite(scene.lower).all() and (scene.cell > 0).all())


@examples(junk, junk, junk)
def test_materials_have_constants_that_mean_something_or_are_refused(density, young, poisson):
    material = refused(lambda: mpm.LinearElastic(density=density, young=young, poisson=poisson))
    if material is not None:
        lame, mu = material.lameConstants
        assert material.density > 0 and mu > 0 and np.isfinite(lame)


points = strategies.lists(strategies.tuples(*[strategies.integers(0, 4)] * 2), min_size=1, max_size=9)
cells = strategies.lists(strategies.tuples(*[strategies.integers(-1, 9)] * 4), min_size=1, max_size=4)


@examples(points, cells, strategies.lists(strategies.integers(-1, 9), max_size=2), strategies.data())
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


@examples(strategies.text(alphabet="scene.np()[]'abx0123456789+-*/<>=, _lambdiforg", max_size=40))
def test_an_expression_gives_a_value_or_is_refused(text):
    try:
        expression = Expression(text, "History: column 'a'")
        expression(mpm.Scene((0, 0), (1, 1), 0.5))
    except (
        ValueError,
        TypeError,
        KeyError,
        IndexError,
        SyntaxError,
        ArithmeticError,
        AttributeError,
    ) as error:
        assert len(str(error)) < MOST_TEXT


def storedScene():
    scene = mpm.Scene((0, 0), (2, 2), 0.5)
    elastic = mpm.LinearElastic(density=1.0, lame=(100.0, 50.0))
    near = scene.add("boxes", mpm.box((0, 0), (1, 0.5)), elastic, mpm.UGIMP(perCell=4))
    scene.add("mesh", mpm.box((1, 0), (2, 1)), elastic, mpm.APDI(size=0.5, matched=near))
    scene.engines = [*scene.engines, mpm.History(iterPeriod=1)]
    scene.run(steps=3, progress=False)
    scene.save("whole.h5")
    with open("whole.h5", "rb") as f:
        return f.read()


def loads(content):
    with open("b.h5", "wb") as f:
        f.write(content)
    scene = refused(lambda: mpm.load("b.h5"))
    if scene is not None:  # what was taken can be stepped, or the run is refused or fails in words
        try:
            scene.threads = 1
            scene.run(steps=2, progress=False)
        except (RuntimeError, *REFUSALS) as error:
            assert len(str(error)) < MOST_TEXT
    return scene


WHOLE = []


def whole():
    return WHOLE[0] if WHOLE else WHOLE.append(storedScene()) or WHOLE[0]


@examples(strategies.data())
def test_bytes_of_a_checkpoint_that_are_changed_are_noticed(data):
    content = bytearray(whole())
    place = data.draw(strategies.integers(0, len(content) - 1))
    content[place] ^= data.draw(strategies.integers(1, 255))
    assert loads(bytes(content)) is None


@pytest.mark.skipif(BUDGET <= 10, reason="on demand: HDF5 itself may crash (SECURITY.md)")
@examples(strategies.data())
def test_a_checkpoint_made_by_hand_with_a_valid_sum_does_no_harm(data):
    """Bytes of the HDF5 file are changed, the sum is made anew: what the reader takes the solver can bear."""
    content = bytearray(whole()[checkpoint.SEAL :])
    for _ in range(data.draw(strategies.integers(1, 3))):
        content[data.draw(strategies.integers(0, len(content) - 1))] ^= data.draw(strategies.integers(1, 255))
    loads(checkpoint.sealOf(bytes(content)) + bytes(content))


@examples(strategies.data())
def test_arrays_of_any_numbers_with_a_valid_sum_do_no_harm(data):
    image = io.BytesIO(whole())
    with h5py.File(image, "r+") as h5:
        names = []
        h5["bodies"].visititems(lambda name, x: names.append(name) if isinstance(x, h5py.Dataset) else None)
        one = h5["bodies"][data.draw(strategies.sampled_from(names))]
        if one.size:
            at = np.unravel_index(data.draw(strategies.integers(0, one.size - 1)), one.shape)
            most = 2**31 - 1 if one.dtype.kind == "i" else None
            values = strategies.integers(-most, most) if most else strategies.floats()
            one[at] = data.draw(strategies.one_of(values, strategies.integers(-2, 40)))
    content = image.getvalue()[checkpoint.SEAL :]
    loads(checkpoint.sealOf(content) + content)


@examples(
    strategies.recursive(
        junk.filter(lambda v: isinstance(v, (int, float, str, type(None)))), strategies.lists
    )
)
def test_a_description_of_anything_is_refused(value):
    image = io.BytesIO(whole())
    with h5py.File(image, "r+") as h5:
        del h5["scene"]
        h5["scene"] = np.frombuffer(json.dumps(value).encode(), np.uint8)
    content = image.getvalue()[checkpoint.SEAL :]
    assert loads(checkpoint.sealOf(content) + content) is None
