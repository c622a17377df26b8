# SPDX-License-Identifier: GPL-2.0-or-later
"""Mistakes with pore water that a scene warns of or refuses, and what is read of it."""

import warnings

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from yade_mpm import box

LAW = dict(density=2.0, young=1e4, poisson=0.3, cohesion=5.0, frictionAngle=0.4, dilatancyAngle=0)


def ground(height=0.5, before=9.81, after=None, axisymmetric=False, **water):
    """Wet ground in a grid of 1 x 1 m."""
    scene = mpm.Scene((0, 0), (1, 1), 0.25, gravity=before, axisymmetric=axisymmetric)
    scene.fix("bottom")
    scene.roller("left", "right", "top")
    soil = box((0, 0), (1, height))
    body = scene.add("soil", soil, mpm.MohrCoulomb(**LAW), mpm.UGIMP(), water=mpm.PoreWater(**water))
    if after is not None:
        scene.gravity = after
    scene.groundStress(K0=0.5)
    return scene, body


UNDRAINED, NO_GRAVITY = "no drained boundary: undrained for ever", "give gravity before scene.add"
PASCAL, PER_DAY = "is in kPa: give 2.2e6", "8.6 m/d are 9.95e-05"


@pytest.mark.parametrize(
    "told, options",
    [
        (UNDRAINED, dict(sealed=True)),
        (UNDRAINED, dict(height=1.0)),
        (UNDRAINED, dict(height=1.0, axisymmetric=True)),
        (None, dict()),
        (None, dict(axisymmetric=True)),
        (None, dict(sealed=True, permeability=0.0)),
        (None, dict(sealed=True, heads={"left": 0.5})),
        (None, dict(sealed=True, drained="left")),
        (None, dict(height=1.0, heads={"bottom": 1.0})),
        (NO_GRAVITY, dict(before=0.0, after=9.81, table=0.5)),
        (None, dict(table=0.5)),
        (None, dict(table=0.3)),
        (PASCAL, dict(bulkModulus=2.2e9)),
        (None, dict(bulkModulus=2.2e6 * 4)),
        (PER_DAY, dict(permeability=8.6)),
        (None, dict(permeability=0.5)),
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


def twice():
    """One PoreWater in two scenes."""
    water = mpm.PoreWater(table=0.5)
    for _ in range(2):
        scene = mpm.Scene((0, 0), (1, 1), 0.25, gravity=9.81)
        scene.add("soil", box((0, 0), (1, 0.5)), mpm.MohrCoulomb(**LAW), mpm.UGIMP(), water=water)


@cases(
    ("rise is given, and no table that rises", lambda: ground(rise=[(0, 0), (10, -1)])),
    ("less than the 400 Mg/m3 of the water in its pores", lambda: ground(table=0.5, density=1000)),
    ("porosity = 35 is not allowed; give a number in (0, 1)", lambda: mpm.PoreWater(porosity=35)),
    ("it was used by another scene; make a new one for each scene", twice),
)
def test_wrong_units_and_half_given_water_are_refused(named, make, kind):
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


def pressed(sand, **options):
    """Clay under a plate; sand: the water of a layer on it, or None."""
    scene = mpm.Scene((0, 0), (2, 1.5), 0.25, gravity=9.81)
    scene.fix("bottom")
    scene.roller("left", "right")
    if sand:
        scene.add("sand", box((0, 0.5), (2, 1)), mpm.MohrCoulomb(**LAW), mpm.UGIMP(), water=sand)
    clay = scene.add("clay", box((0, 0), (2, 0.5)), mpm.MohrCoulomb(**LAW), mpm.UGIMP(), **options)
    scene.groundStress(K0=0.6)
    top = 1.0 if sand else 0.5
    scene.drive(box((0, top - 1e-6), (0.5, top + 0.5)), velocity=(0, -0.05), name="plate")
    scene.run(steps=20, progress=False)
    return scene, clay


def test_undrained_is_water_that_does_not_flow():
    """To the bit; in a scene with water its table counts, and the other soil drains as before."""
    scene, clay = pressed(None, undrained=True)
    _, same = pressed(None, water=mpm.PoreWater(permeability=0.0))
    for field in ("stress", "porePressure", "velocity"):
        assert np.array_equal(getattr(clay, field), getattr(same, field)), field
    assert clay.porePressure.max() > 0.1 and (clay.saturation == 1).all()
    assert "undrained, as its permeability of 0 says" in str(scene.quasiStatic())
    water = mpm.PoreWater(table=1.25, permeability=1e-3)
    scene, clay = pressed(water, undrained=True)
    assert len([e for e in scene.engines if isinstance(e, mpm.PoreWater)]) == 1
    assert (clay.permeability == 0).all() and (scene["sand"].permeability == 1e-3).all()
    assert clay.porePressure.max() > 9.81 * 1.0


def test_uniform_along_with_water_is_refused():
    scene, _ = ground(table=0.5)
    scene.engines.insert(1, mpm.UniformAlong(axis="x"))
    with pytest.raises(ValueError, match="UniformAlong makes rows of nodes alike"):
        scene.run(steps=1, progress=False)


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
