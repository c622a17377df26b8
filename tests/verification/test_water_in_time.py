# SPDX-License-Identifier: GPL-2.0-or-later
"""Heads and water tables that change within a run."""

import numpy as np
import pytest
import yade_mpm as mpm
from asModules import TESTS, moduleOf
from inputs import cases, refused
from setups import restarted
from yade_mpm import box
from yade_mpm.engine.poreWater import waterOf

WELLS = moduleOf(TESTS / "verification" / "test_water_wells.py")
K = WELLS.K


@pytest.mark.verifies("flow through a block as a head falls", reference="Darcy", tolerance=2e-3)
def test_the_flow_turns_as_a_head_falls_below_the_other(verified):
    """Over 2 m, steady before and after."""
    heads = {"left": [(0.2, 3.5), (0.25, 2.5)], "right": 3.0}
    scene, soil, water = WELLS.confined((0, 0), (2, 1), 0.25, 0.2, heads=heads)
    verified(water.outflow, 0.25 * K)
    assert water.head(soil).mean() == pytest.approx(3.25, abs=0.01)
    restarted(scene, 250)  # within the fall
    scene.run(until=0.5, progress=False)
    verified(water.outflow, 0.25 * K)
    assert water.head(soil).mean() == pytest.approx(2.75, abs=0.01)


def column(**water):
    scene = mpm.Scene((0, 0), (2, 1.5), 0.25, gravity=9.81, damping=0.5)
    scene.roller("left", "right", "bottom")
    elastic = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.2)
    given = mpm.PoreWater(permeability=1e-2, **water)
    soil = scene.add("soil", box((0, 0), (2, 1.5)), elastic, mpm.UGIMP(), water=given)
    scene.groundStress(K0=0.5, bodies=[soil])
    scene.run(until=0.06, progress=False)
    return scene, soil.porePressure.copy()


@pytest.mark.filterwarnings("error")
def test_a_table_by_time_is_one_that_rises_by_rows():
    """Control: a table that stays. Dry soil above the table is a drained boundary, of which nothing warns."""
    scene, falls = column(table={0: 1.3, 0.1: 0.8})
    assert falls == pytest.approx(column(table=1.3, rise=[(0, 0), (0.1, -0.5)])[1], abs=1e-9)
    assert np.abs(falls - column(table=1.3)[1]).max() > 0.5
    restarted(scene, 20)


def test_a_table_may_change_its_shape_and_be_given_again():
    water = mpm.PoreWater(table={0: [(0, 3), (4, 3)], 10: [(1, 3), (4, 1)], 20: 2.0})
    at = np.array([[0.0, 0.0], [2.5, 0.0], [4.0, 0.0]])
    for time, level in (
        (0, (3, 3, 3)),
        (5, (3, 2.5, 2)),
        (10, (3, 2, 1)),
        (15, (2.5, 2, 1.5)),
        (99, (2, 2, 2)),
    ):
        assert water.level(at, time) == pytest.approx(level)
    water.table = 1.5
    assert water.level(at, 10) == pytest.approx([1.5] * 3)


def test_tables_wait_while_the_ground_settles():
    """Once used up there without a word: the level was 0.8 m behind settle."""
    scene, _ = column(table={0: 1.3, 0.06: 1.3, 0.16: 0.8}, heads={"left": {0: 1.3, 0.06: 1.3, 0.16: 0.8}})
    soil, water, before = scene.bodies[0], waterOf(scene), scene.time
    scene.settle(progress=False)
    taken = scene.time - before
    assert taken > 0.1 and water.waited == pytest.approx(taken)
    assert soil.porePressure == pytest.approx(9.81 * np.maximum(1.3 - soil.position[:, 1], 0), abs=0.01)
    scene.run(until=scene.time + 0.05, progress=False)
    assert water.level(soil.position, scene.time) == pytest.approx(1.05)
    restarted(scene, 20)


def test_a_checkpoint_of_settling_has_the_tables_where_they_wait(tmp_path):
    scene, _ = column(table={0: 1.3, 0.16: 0.8})
    before = scene.time
    runner = mpm.PyRunner(lambda: scene.save(tmp_path / "half.h5"), iterPeriod=150, label="save")
    scene.engines.append(runner)
    scene.settle(progress=False)
    with pytest.warns(UserWarning, match="during settle"):
        again = mpm.load(tmp_path / "half.h5", callbacks={"save": None})
    water = waterOf(again)
    assert water.waited == pytest.approx(again.time - before) and not water.waits


def test_heads_and_rise_take_a_dict_of_times_as_a_table_does():
    dicts = mpm.PoreWater(table=1.0, rise={0: 0, 9: 1}, heads={"left": {0: 3, 9: 2}})
    rows = mpm.PoreWater(table=1.0, rise=[(0, 0), (9, 1)], heads={"left": [(0, 3), (9, 2)]})
    assert dicts.rise == rows.rise and dicts._named == rows._named


@cases(
    ("heads of 'left': times do not grow", lambda: mpm.PoreWater(heads={"left": {1: 2, 0: 3}})),
    ("heads of 'left' = [] is not allowed", lambda: mpm.PoreWater(heads={"left": {}})),
    ("rise: times do not grow", lambda: mpm.PoreWater(table=1, rise={1: 2, 0: 3})),
    ("heads of 'left': times do not grow", lambda: mpm.PoreWater(heads={"left": [(1, 2), (0, 3)]})),
    ("heads has '6' for 'left' ... or a dict time", lambda: mpm.PoreWater(heads={"left": "6"}), TypeError),
    ("table: times do not grow", lambda: mpm.PoreWater(table={1: 2.0, 0: 3.0})),
    ("table is an empty dict", lambda: mpm.PoreWater(table={})),
    ("table = 'high' is not allowed", lambda: mpm.PoreWater(table={0: "high"})),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)
