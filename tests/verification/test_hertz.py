# SPDX-License-Identifier: GPL-2.0-or-later
"""Hertz contact of an elastic cylinder and an elastic half-plane, and of two cylinders, plane strain
(scripts/hertz.py).

Set-up and closed form are in the docstring of the script; radius 20 half-widths, a half-width of 5.3 cells
(--slow: 8.6).
Tolerance: half-width and peak pressure, by the second moment of the nodal forces, 5 %; pressure at the axis
8 %, rms of the whole curve 4 % of the
peak (12 and 5 % where boxes meet an explicit surface along a grid line); overlap 0.02 h. uGIMP boxes of the
cylinder stand in columns that follow the
curve; cut ones carry their outline.
Control: a cylinder cut from the lattice, whose underside is a staircase with treads wider than the contact,
gives another half-width.
"""

import pytest
from asModules import runScript, script


def press(*options, **changed):
    return runScript("hertz", *options, **changed)


def isHertz(verified, summary, axis=0.08, rms=0.04, overlap=0.02):
    assert summary["pressOverLoad"] == pytest.approx(1, rel=2e-3)  # at rest
    verified(summary["halfWidth"], summary["hertzHalfWidth"])
    verified(summary["peakPressure"], summary["hertzPeakPressure"])
    assert summary["axisPressure"] == pytest.approx(summary["hertzAxisPressure"], rel=axis)
    assert summary["rmsError"] < rms
    assert summary["largestPenetrationOverCell"] < overlap


@pytest.mark.parametrize("shift", ["0", "0.5"])
@pytest.mark.parametrize("ground, cylinder", [("apdi", "apdi"), ("ugimp", "apdi"), ("ugimp", "ugimp")])
@pytest.mark.verifies(
    "Cylinder on a half-plane: half-width and peak pressure", reference="Hertz", tolerance=0.05
)
def test_pressure_of_a_cylinder_is_that_of_hertz(ground, cylinder, shift, verified):
    isBoxes = ground == cylinder == "ugimp"  # columns of boxes on boxes: 0.025 h
    summary = press("--smoke", "--ground", ground, "--cylinder", cylinder, "--shift", shift)
    isHertz(verified, summary, overlap=0.03 if isBoxes else 0.02)


@pytest.mark.parametrize(
    "ground, cylinder, axis", [("apdi", "apdi", 0.08), ("ugimp", "apdi", 0.12), ("ugimp", "ugimp", 0.08)]
)
@pytest.mark.verifies("Two cylinders: half-width and peak pressure", reference="Hertz", tolerance=0.05)
def test_two_cylinders_touch_as_hertz_says(ground, cylinder, axis, verified):
    isHertz(verified, press("--smoke", "--two", "--ground", ground, "--cylinder", cylinder), axis)


@pytest.mark.slow
@pytest.mark.parametrize("shift", ["0", "0.5"])
@pytest.mark.parametrize(
    "ground, cylinder",
    [
        ("apdi", "apdi"),
        ("ugimp", "apdi"),
        ("apdi", "ugimp"),
        ("ugimp", "ugimp"),
        ("apdi", "cut"),
        ("ugimp", "cut"),
        ("cut", "cut"),
    ],
)
@pytest.mark.verifies(
    "Cylinder on a half-plane, fine grid: half-width and peak pressure", reference="Hertz", tolerance=0.05
)
def test_pressure_of_a_cylinder_is_that_of_hertz_on_a_finer_grid(ground, cylinder, shift, verified):
    isHertz(verified, press("--cells", "8", "--ground", ground, "--cylinder", cylinder, "--shift", shift))


@pytest.mark.parametrize(
    "ground, shift", [("apdi", "0"), ("ugimp", "0"), ("cut", "0"), ("apdi", "0.5"), ("ugimp", "0.5")]
)
@pytest.mark.verifies(
    "Cylinder of cut boxes on a half-plane: half-width and peak pressure", reference="Hertz", tolerance=0.05
)
def test_pressure_of_a_cylinder_of_cut_boxes_is_that_of_hertz(ground, shift, verified):
    onLine = ground == "ugimp" and shift == "0"
    isHertz(
        verified,
        press("--smoke", "--ground", ground, "--cylinder", "cut", "--shift", shift),
        *((0.12, 0.05) if onLine else ()),
    )


@pytest.mark.parametrize("ground", ["apdi", "cut"])
@pytest.mark.verifies(
    "Two cylinders of cut boxes: half-width and peak pressure", reference="Hertz", tolerance=0.05
)
def test_cylinders_of_cut_boxes_touch_as_hertz_says(ground, verified):
    isHertz(verified, press("--smoke", "--two", "--ground", ground, "--cylinder", "cut"))


def test_control_whole_boxes_are_no_cylinder():
    """41 % too wide; and with the faces of cut boxes as surface it is 7 % too narrow."""
    boxes = press("--smoke", "--ground", "ugimp", "--cylinder", "cut", OUTLINE=False)
    assert boxes["halfWidth"] < 0.95 * boxes["hertzHalfWidth"]
    whole = press("--smoke", "--ground", "ugimp", "--cylinder", "cut", CUT=False)
    assert whole["halfWidth"] > 1.3 * whole["hertzHalfWidth"]


def test_control_a_staircase_is_no_cylinder():
    """A polygon filled with boxes: they lie level over 0.7 a and more."""
    module = script("hertz")
    level = module.rise
    module.rise = lambda x, radius: (level(x, radius) * 10).round() / 10
    summary = module.run(module.arguments(["--smoke", "--ground", "ugimp", "--cylinder", "ugimp"]))[0]
    assert summary["halfWidth"] > 1.1 * summary["hertzHalfWidth"]


def test_the_scene_draws(tmp_path, monkeypatch):
    module = script("hertz")
    monkeypatch.setattr("sys.argv", ["hertz", "--smoke", "--out", str(tmp_path)])
    module.main()
    assert (tmp_path / "hertz.png").stat().st_size > 20_000 and (tmp_path / "summary.json").exists()
