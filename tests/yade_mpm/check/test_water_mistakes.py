# SPDX-License-Identifier: GPL-2.0-or-later
"""Mistakes with pore water that a scene warns of or refuses, and what is read of it."""

import warnings

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from yade_mpm import box

LAW = dict(density=2.0, young=1e4, poisson=0.3, cohesion=5.0, frictionAngle=0.4, dilatancyAngle=0)


def ground(height=0.5, before=9.81, after=None, **water):
    """Wet ground in a grid of 1 x 1 m."""
    scene = mpm.Scene((0, 0), (1, 1), 0.25, gravity=before)
    scene.fix("bottom")
    scene.roller("left", "right", "top")
    soil = box((0, 0), (1, height))
    body = scene.add("soil", soil, mpm.MohrCoulomb(**LAW), mpm.UGIMP(), water=mpm.PoreWater(**water))
    if after is not None:
        scene.gravity = after
    scene.groundStress(K0=0.5)
    return scene, body


UNDRAINED, NO_GRAVITY = "no drained boundary: undrained for ever", "give gravity before scene.add"


@pytest.mark.parametrize(
    "told, options",
    [
        (UNDRAINED, dict(sealed=True)),
        (UNDRAINED, dict(height=1.0)),
        (None, dict()),
        (None, dict(sealed=True, permeability=0.0)),
        (None, dict(sealed=True, heads={"left": 0.5})),
        (None, dict(sealed=True, drained="left")),
        (None, dict(height=1.0, heads={"bottom": 1.0})),
        (NO_GRAVITY, dict(before=0.0, after=9.81, table=0.5)),
        (None, dict(table=0.5)),
        (None, dict(table=0.3)),
    ],
)
def test_what_water_is_warned_of(told, options):
    scene, _ = ground(**options)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        scene.run(steps=1, progress=False)
    texts = [str(w.message) for w in found if "PoreWater" in str(w.message)]
    assert len(texts) == (told is not None) and all(told in text for text in texts)


@cases(
    (
        "has a PoreWater, which knows its table; leave water out",
        lambda: ground(table=0.5)[0].groundStress(0.5, water=0.5, weightBelow=10),
    )
)
def test_a_table_is_given_once(named, make, kind):
    refused(named, make, kind)


@cases(
    (
        "'left' is in heads and in drained; give it one of them",
        lambda: mpm.PoreWater(table=1, heads={"left": 1}, drained="left"),
    ),
    (
        "'left' is in inflows and in drained; give it one of them",
        lambda: mpm.PoreWater(table=1, inflows={"left": 1e-6}, drained=["right", "left"]),
    ),
    (
        "'top' is in heads and in inflows; give it one of them",
        lambda: mpm.PoreWater(table=1, heads={"top": 1}, inflows={"top": 1e-6}),
    ),
    ("drained = True; give a face, or a list of faces", lambda: mpm.PoreWater(drained=True), TypeError),
)
def test_a_face_has_one_condition(named, make, kind):
    refused(named, make, kind)


def test_excess_and_head_belong_to_the_table():
    scene, body = ground(table=0.4)
    water = next(e for e in scene.engines if isinstance(e, mpm.PoreWater))
    wet = body.saturation > 0
    assert water.excess(body) == pytest.approx(0, abs=1e-12)
    assert water.head(body)[wet] == pytest.approx(0.4) and np.isnan(water.head(body)[~wet]).all()
    body.porePressure[wet] += 2.0
    assert water.excess(body) == pytest.approx(2.0 * wet)
    assert water.head(body)[wet] == pytest.approx(0.4 + 2 / 9.81)


def test_a_history_has_the_flow_and_the_iterations():
    scene, _ = ground(height=1.0, before=0.0, heads={"left": 1.0, "right": 0.0}, permeability=1e-3)
    scene.gravity = 9.81
    history = scene.history(every=1e-3)
    scene.run(steps=20, progress=False)
    water = next(e for e in scene.engines if isinstance(e, mpm.PoreWater))
    assert history["water.outflow"][-1] == water.outflow != 0
    assert history["water.inflow"][-1] == water.inflow != 0
    assert history["water.iterations"][-1] == water.iterations > 0
    assert history.units["water.outflow"] == "m3/s/m"
