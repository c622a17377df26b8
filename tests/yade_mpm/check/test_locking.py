# SPDX-License-Identifier: GPL-2.0-or-later
"""Soil that flows without F-bar is warned of, once for each body."""

import pytest
import yade_mpm as mpm
from inputs import warningsOf
from yade_mpm import box

CLAY = dict(density=2.0, young=5e3, poisson=0.3, cohesion=10.0, frictionAngle=0.0)


def sheared(rate=1.0, material=None, **more):
    """Two blocks that shear at a rate, 1/s, for a hundredth of a second, twice."""
    scene = mpm.Scene((0, 0), (8, 4), 0.5, threads=1)
    clay = material or mpm.MohrCoulombDruckerPrager(**CLAY)
    for name, left in (("one", 1), ("other", 5)):
        body = scene.add(name, box((left, 1), (left + 2, 3)), clay, mpm.UGIMP(perCell=2), **more)
        body.velocity[:, 0] = rate * body.position[:, 1]
    for until in (0.01, 0.02):
        scene.run(until=until, progress=False)
    return scene


def told(capsys):
    return [line for line in capsys.readouterr().err.splitlines() if "without F-bar" in line]


def test_each_body_that_flows_without_fbar_is_told_of_once(capsys):
    sheared(fbar=False)
    lines = told(capsys)
    assert len(lines) == 2
    for line, name in zip(lines, ("one", "other")):
        assert f"body '{name}' yields without F-bar: " in line
        assert "too strong, on the unsafe side" in line and "leave fbar=False out" in line


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"fbar": False, "rate": 0.1},
        {"fbar": False, "material": mpm.LinearElastic(density=2.0, young=5e3, poisson=0.3)},
    ],
)
def test_control_with_fbar_far_from_yield_or_elastic_nothing_is_said(given, capsys):
    sheared(**given)
    assert told(capsys) == []


def test_an_implicit_body_that_yields_is_told_of_as_such(capsys):
    scene = mpm.Scene((0, 0), (4, 4), 0.5, threads=1)
    clay = mpm.MohrCoulombDruckerPrager(**CLAY)
    body = scene.add("one", box((1, 1), (3, 3)), clay, mpm.UGIMP(perCell=2), implicit=True, fbar=False)
    body.velocity[:, 0] = body.position[:, 1]
    scene.dt = 1e-4
    scene.run(until=0.01, progress=False)
    said = [line for line in capsys.readouterr().err.splitlines() if "yields" in line]
    assert len(said) == 1 and "body 'one' yields and is implicit: " in said[0]
    assert "leave implicit=True out" in said[0] and "F-bar" not in said[0]


def elastic(poisson, type_, **more):
    """A scene with an elastic block."""
    scene = mpm.Scene((0, 0), (4, 2), 0.5, threads=1)
    soil = mpm.LinearElastic(density=2.0, young=1e3, poisson=poisson)
    scene.add("block", box((0, 0), (2, 1)), soil, type_, **more)
    scene.engines[1] = mpm.GridSolver(gravity=(0, -9.81), fixed="bottom")
    return scene


@pytest.mark.parametrize(
    "poisson, type_, more, isTold",
    [
        (0.45, mpm.UGIMP, {}, True),
        (0.499, mpm.BSpline, {}, True),
        (0.44, mpm.UGIMP, {}, False),
        (0.499, mpm.UGIMP, {"fbar": True}, False),
        (0.499, lambda: mpm.APDI(size=0.25), {}, True),
        (0.499, lambda: mpm.APDI(size=0.25), {"fbar": True}, False),
        (0.499, mpm.APDI, {}, False),  # one domain in a cell
    ],
)
def test_particles_that_hardly_change_their_volume_are_warned_of_before_the_first_step(
    poisson, type_, more, isTold
):
    said = warningsOf(elastic(poisson, type_(), **more).prepare)
    told = f"body 'block': its particles have no F-bar and Poisson's ratio {poisson:.4g}, so they lock: "
    assert [text.startswith(told) and text.endswith("give fbar=True in scene.add") for text in said] == (
        [True] if isTold else []
    )


@pytest.mark.parametrize("part, isTold", [("all", False), ("top", True)])
def test_a_body_that_is_driven_as_a_whole_cannot_lock(part, isTold):
    scene = mpm.Scene((0, 0), (4, 2), 0.5, threads=1, gravity=9.81)
    soil = mpm.LinearElastic(density=2.0, young=1e3, poisson=0.499)
    block = scene.add("block", box((0, 0), (2, 1)), soil, mpm.UGIMP())
    scene.dt = 1e-4
    scene.drive(block if part == "all" else block.above(0.5), velocity=(0, -0.1))
    said = [text for text in warningsOf(scene.prepare) if "so they lock" in text]
    assert len(said) == isTold


def flowing(rate, boxes=None, **more):
    """A mesh of clay that shears by rate/100, bonded to a block of boxes where their F-bar is given."""
    scene = mpm.Scene((0, 0), (8, 4), 0.5, threads=1)
    clay = mpm.MohrCoulombDruckerPrager(**CLAY)
    parts = [scene.add("mesh", box((1, 1), (3, 3)), clay, mpm.APDI(size=0.5), **more)]
    if boxes is not None:
        parts.append(scene.add("boxes", box((3, 1), (5, 3)), clay, mpm.UGIMP(perCell=2), fbar=boxes))
    for part in parts:
        part.velocity[:, 0] = rate * part.position[:, 1]
    for until in (0.01, 0.02):
        scene.run(until=until, progress=False)


@pytest.mark.parametrize(
    "boxes, error",
    [
        (True, "beside boxes a strip footing resists up to 8 % too much"),
        (None, "on sand a strip footing resists up to 15 % too much"),
    ],
)
def test_a_mesh_that_flows_is_told_of_once(boxes, error, capsys):
    flowing(4.0, boxes)
    said = [line for line in capsys.readouterr().err.splitlines() if "is a mesh and flows" in line]
    assert len(said) == 1 and "body 'mesh' is a mesh and flows: " in said[0]
    assert error in said[0] and "make boxes (UGIMP) of all that flows" in said[0]


def test_control_a_mesh_that_hardly_yields_or_has_no_fbar_is_not_told_to_flow(capsys):
    flowing(0.3)
    flowing(4.0, fbar=False)
    assert "is a mesh and flows" not in capsys.readouterr().err
