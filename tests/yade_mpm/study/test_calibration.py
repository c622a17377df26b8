# SPDX-License-Identifier: GPL-2.0-or-later
"""Fits that find the parameters that a curve was made with."""

import json
from pathlib import Path

import numpy as np
import pytest
from yade_mpm import study
from yade_mpm.study.calibration import _measured

SCENE = Path(__file__).with_name("demo_scene.py")
MASS, GRAVITY, SPEED = 0.125, 8.0, 0.4  # Mg per m, m/s2, m/s
T = np.linspace(0.01, 0.05, 9)
POINTS = np.stack([T, 0.5 * MASS * (SPEED + GRAVITY * T) ** 2], axis=1)
RANGES = {"gravity": (2.0, 12.0), "speed": (0.0, 1.0)}
NEAR = {"gravity": 7.0, "speed": 0.5}
HOW = dict(curve="energy", start=NEAR, words=["--until", "0.06"], quiet=True)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    out = tmp_path_factory.mktemp("fit")
    return study.calibrate(SCENE, RANGES, POINTS, out=out, **HOW), out


def test_least_squares_recover_the_parameters_of_a_curve(fitted):
    """Against the closed form: the step's time integration is all that is between them."""
    found, _ = fitted
    assert found.values == pytest.approx({"gravity": GRAVITY, "speed": SPEED}, rel=0.02)
    assert found.rms < 0.005 * found.scale and 3 <= found.runs < 30
    assert found.fitted == pytest.approx(POINTS[:, 1], rel=0.02)


def test_it_tells_errors_and_correlation(fitted):
    found, out = fitted
    assert 0 < found.errors["gravity"] < 0.5 and 0 < found.errors["speed"] < 0.05
    correlation = np.array(found.correlation)
    assert np.diag(correlation) == pytest.approx(1)
    assert -1 < correlation[0, 1] < -0.5  # more of one, less of both
    assert json.loads((out / "calibration.json").read_text())["values"] == found.values
    page = (out / "calibration.html").read_text()
    for head in ("Correlation", "Curves", "Residuals"):
        assert f"<h2>{head}" in page


def test_finished_evaluations_are_not_run_again(fitted):
    found, out = fitted
    before = (out / "started").read_text()
    again = study.calibrate(SCENE, RANGES, POINTS, out=out, **HOW)
    assert again.values == found.values and (out / "started").read_text() == before


@pytest.mark.slow
def test_differential_evolution_finds_them_without_a_start(tmp_path):
    how = {**HOW, "start": None, "method": "differential_evolution", "generations": 4}
    found = study.calibrate(SCENE, RANGES, POINTS, out=tmp_path, **how)
    assert found.values == pytest.approx({"gravity": GRAVITY, "speed": SPEED}, rel=0.2)


@pytest.mark.parametrize(
    "changed, message",
    [
        (dict(method="newton"), "method = 'newton' is not allowed"),
        (dict(ranges={}), "ranges are not allowed"),
        (dict(ranges={"gravity": (3, 2)}), "ranges are not allowed"),
        (dict(ranges={"g": (1, 2)}), "there is no parameter 'g'"),
        (dict(start={"gravity": 99}), "start = .* is not allowed"),
        (dict(measured=[1, 2, 3]), "a measured curve of shape"),
    ],
)
def test_what_cannot_be_fitted_is_refused(changed, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        study.calibrate(SCENE, **{**HOW, "ranges": RANGES, "measured": POINTS, "out": tmp_path, **changed})


def test_a_measured_curve_may_be_a_file(tmp_path):
    (tmp_path / "m.csv").write_text("depth (m),load (kN)\n2,20\n1,10\n")
    points, names = _measured(tmp_path / "m.csv")
    assert points.tolist() == [[1, 10], [2, 20]] and names == ("depth (m)", "load (kN)")


LINE = Path(__file__).with_name("curve_scene.py")
X = np.linspace(0, 1, 6)


def fitLine(out, how, slope=0.7):
    points = np.stack([X, slope * X], axis=1)
    how = dict(words=["--how", how], quiet=True, jobs=1)
    return study.calibrate(LINE, {"x": (0.1, 2.0)}, points, "c", out, **how)


@pytest.mark.parametrize("how", ["rises", "falls"])
def test_the_order_of_the_rows_of_a_curve_does_not_matter(how, tmp_path):
    assert fitLine(tmp_path, how).values == pytest.approx({"x": 0.7}, rel=1e-6)


def test_a_curve_that_turns_back_is_refused(tmp_path):
    with pytest.raises(ValueError, match="turns back at x = 1, and has two values of y beside it"):
        fitLine(tmp_path, "turns")
    back = np.array([[0, 0], [1, 1], [0.5, 0.2]])
    with pytest.raises(ValueError, match="the measured curve turns back at x = 1"):
        study.calibrate(LINE, {"x": (0.1, 2.0)}, back, "c", tmp_path / "none")
    assert not (tmp_path / "none").exists(), "before the first run"
    assert _measured(back[[0, 1, 1]])[0].tolist() == back[[0, 1, 1]].tolist()  # a step is none


def test_a_measured_curve_of_zeros_has_an_end(tmp_path):
    found = fitLine(tmp_path, "zeros", slope=0.0)
    assert found.rms == found.scale == 0 and (tmp_path / "calibration.html").exists()


def test_a_law_is_calibrated_by_a_laboratory_curve(tmp_path):
    """Toyoura sand, drained, e = 0.831, 100 kPa (Verdugo & Ishihara 1996): q over the strain. Dafalias &
    Manzari 2004 have 7.05 and 1.1, of more tests and by eye."""
    strain = np.array([0.5, 1, 1.5, 2, 3, 5, 7.5, 10, 12.5, 15, 17.5, 20]) / 100
    ratio = [2.434, 2.899, 3.035, 3.171, 3.267, 3.364, 3.396, 3.406, 3.364, 3.333, 3.319, 3.305]
    measured = np.column_stack([strain, 100 * (np.array(ratio) - 1)])
    ranges = {"hardening": (2.0, 20.0), "bounding": (0.2, 3.0)}
    scene = Path(__file__).with_name("triaxial_scene.py")
    start = {"hardening": 6.0, "bounding": 1.3}
    found = study.calibrate(scene, ranges, measured, "q", out=tmp_path, start=start, quiet=True)
    assert found.rms < 0.05 * found.scale
    assert found.values["hardening"] == pytest.approx(7.05, rel=0.35)
    assert found.values["bounding"] == pytest.approx(1.1, rel=0.3)
