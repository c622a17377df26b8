# SPDX-License-Identifier: GPL-2.0-or-later
"""Stages of construction: names, digging by region, fill down to the surface that is there."""

import warnings

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from setups import restarted
from yade_mpm import box, polygon

SAND = dict(density=2.0, young=2e4, poisson=0.3, cohesion=20.0, frictionAngle=0.5)


def ground(kind=None, upper=2.0):
    scene = mpm.Scene((0, 0), (4, 3.5), 0.5, threads=1, gravity=10, damping=0.7)
    scene.fix("bottom")
    scene.roller("left", "right")
    soil = mpm.MohrCoulomb(**SAND)
    lower = scene.add("lower", box((0, 0), (4, 1)), soil, kind or mpm.UGIMP())
    top = scene.add("upper", box((0, 1), (4, upper)), soil, kind or mpm.UGIMP())
    scene.initialStress(surface=upper, K0=0.5, gravity=10)
    return scene, lower, top


@pytest.mark.parametrize("kind", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.5)])
def test_a_region_is_dug_out_of_all_layers(kind):
    scene, lower, top = ground(kind)
    mass = scene.remove(region=box((2, 0.5), (4, 2)))
    assert mass == pytest.approx(2.0 * 2 * 1.5)
    assert mpm.diagnostics.mass(scene) == pytest.approx(2.0 * (4 * 2 - 2 * 1.5))
    assert top.position[:, 0].max() < 2 and lower.position[lower.position[:, 0] > 2, 1].max() < 0.5
    scene.run(steps=20, progress=False)


def test_boxes_that_the_edge_cuts_keep_what_is_left_of_them():
    scene, lower, top = ground()
    region = polygon([(1, 2.0), (3, 2.0), (2.3, 1.3), (1.7, 1.3)])
    area = 0.7 * (2 + 0.6) / 2
    before = mpm.diagnostics.mass(scene)
    mass = scene.remove(region=region)
    assert mass == pytest.approx(2.0 * area, rel=0.02)
    assert before - mpm.diagnostics.mass(scene) == pytest.approx(mass)
    scene.run(steps=20, progress=False)


def test_a_layer_that_is_all_in_the_region_stays_as_an_empty_body():
    scene, lower, top = ground()
    scene.remove(region=box((0, 1), (4, 2)))
    assert top.count == 0 and lower.count == 64
    scene.run(steps=10, progress=False)
    restarted(scene, 10)


def test_what_is_dug_after_a_checkpoint_is_the_same(tmp_path):
    scene, *_ = ground()
    scene.run(steps=10, progress=False)
    scene.save(tmp_path / "c.h5")
    other = mpm.load(tmp_path / "c.h5")
    for one in (scene, other):
        one.remove(region=box((1.9, 1.2), (4, 2)))
        one.run(steps=20, progress=False)
    for name in ("lower", "upper"):
        assert np.array_equal(scene[name].stress, other[name].stress)


def test_a_structure_stays_when_a_region_is_dug():
    scene, *_ = ground()
    steel = mpm.LinearElastic(density=1.0, young=1e5, poisson=0.0)
    scene.add("cap", box((0, 2), (4, 2.5)), steel, mpm.APDI(size=0.5))
    scene.remove(region=box((2, 1), (4, 3)))
    assert scene["cap"].count == 8


def test_fill_is_cut_at_the_surface_that_is_there():
    """Ground that has settled unevenly, and heaved by a micrometre."""
    scene, lower, top = ground(upper=1.5)
    with pytest.raises(ValueError, match="overlap"):
        top.position[:, 1] += 6e-6
        scene.add("lift", box((1, 1.5), (3, 2.5)), mpm.MohrCoulomb(**SAND), mpm.UGIMP())
    left = top.position[:, 0] < 2
    top.position[left, 1] -= 0.1
    fill = scene.add("lift", box((0, 1.0), (4, 2.5)), mpm.MohrCoulomb(**SAND), mpm.UGIMP(), on=(lower, top))
    assert fill.mass.sum() == pytest.approx(2.0 * (2 * 1.1 + 2 * 1.0), rel=1e-3)
    scene.run(steps=20, progress=False)
    below = mpm.diagnostics.mass(scene)
    assert below == pytest.approx(2.0 * (4 * 1.5 + 4.2), rel=1e-3)


def test_control_fill_that_is_put_on_nothing_is_not_cut():
    scene, *_ = ground(upper=1.5)
    fill = scene.add("lift", box((0, 1.5), (4, 2.5)), mpm.MohrCoulomb(**SAND), mpm.UGIMP())
    assert fill.mass.sum() == pytest.approx(2.0 * 4)


def test_stages_are_kept_with_their_numbers(tmp_path):
    scene, lower, _ = ground()
    spring = mpm.Spring(lower, (2, 0.5), (2, 3), stiffness=10.0, prestress=1.0, label="prop")
    with scene.stage("prop") as first:
        scene.attach(spring)
        scene.run(steps=10, progress=False)
    with scene.stage("dig to 1 m", picture=tmp_path / "dig.png") as second:
        scene.remove(region=box((3, 1), (4, 2)))
        scene.run(steps=10, progress=False)
        second.note(moment=3.5)
    with pytest.raises(ZeroDivisionError), scene.stage("fails"):
        raise ZeroDivisionError
    assert [row["name"] for row in scene.stages] == ["prop", "dig to 1 m"]
    assert scene.stages[1]["begin"] == first.end == second.begin and scene.stages[1]["end"] == scene.time
    assert scene.stages[0]["values"].keys() == {"prop.force", "unbalanced"}
    assert scene.stages[0]["values"]["prop.force"] == pytest.approx(1.0, abs=0.1)
    assert scene.stages[1]["values"]["moment"] == 3.5
    assert (tmp_path / "dig.png").stat().st_size > 1000
    scene.save(tmp_path / "c.h5")
    assert mpm.load(tmp_path / "c.h5").stages == scene.stages


def test_a_stage_begins_with_its_block():
    scene, *_ = ground()
    scene.stage("forgotten")  # without a block
    with scene.stage("one"):
        pass
    assert [row["name"] for row in scene.stages] == ["one"]


def nested():
    scene, *_ = ground()
    with scene.stage("one"), scene.stage("two"):
        pass


def taken():
    scene, *_ = ground()
    for _ in range(2):
        with scene.stage("one"):
            pass


def noted():
    with ground()[0].stage("one") as stage:
        stage.note(moment="large")


def heldPart():
    scene, lower, _ = ground()
    scene.attach(mpm.Spring(lower, (2, 0.5), (2, 3), stiffness=10.0, label="prop"))
    scene.remove(region=box((0, 0), (4, 1)))


@cases(
    ("remove: no particle of 'lower', 'upper'", lambda: ground()[0].remove(region=box((8, 8), (9, 9)))),
    ("remove(region=None); give a region", lambda: ground()[0].remove(), TypeError),
    ("'lower': remove: a Spring", heldPart),
    ("stage: name = 3", lambda: ground()[0].stage(3), TypeError),
    ("'two' begins inside of 'one'", nested, RuntimeError),
    ("there is a stage 'one' already", taken),
    ("Stage 'one': moment = 'large'", noted, TypeError),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)


def test_a_mesh_that_the_region_cuts_warns():
    scene, *_ = ground(mpm.APDI(size=0.5))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene.remove(region=box((2, 0.7), (4, 2)))
    assert any("cuts 4 domains" in str(w.message) for w in caught)
