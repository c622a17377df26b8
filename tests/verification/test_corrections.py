# SPDX-License-Identifier: GPL-2.0-or-later
"""What slip and the limit of dilatancy change in the sheet pile (scripts/studies/corrections.py), on a coarse
grid.

With friction the soil beside the embedded metre stays where it is (no collar) and closes behind the tip;
without dilatancy the
surface hardly heaves; both lower the resistance. Control: the published model, which shows all of it.
"""

import argparse

import corrections
import numpy as np
import pytest
import sheet_pile
import sheet_pile_model
import sheet_pile_study
from yade_mpm import geotech


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    a = argparse.Namespace(
        cell=0.5, rate=1.0, penetration=1.0, threads=1, out=str(tmp_path_factory.mktemp("corrections"))
    )
    runs = {name: corrections.run(a, name) for name in ("published", "friction", "all, psi = 0")}
    corrections.draw(a, {name: scene for name, (_, scene) in runs.items()}, a.out + "/corrections.png")
    return {name: summary for name, (summary, _) in runs.items()}


def test_soil_that_slips_makes_no_collar(results):
    """One box of 0.25 m at most; without F-bar, and with F-bar before it kept volumes, 0.1 m."""
    assert results["friction"]["collarThickness"] < 0.1
    assert results["all, psi = 0"]["collarThickness"] <= 0.25
    assert results["published"]["collarThickness"] > 0.4  # control


def test_it_closes_behind_the_tip(results):
    assert results["friction"]["openCavityArea"] < 0.1
    assert results["published"]["openCavityArea"] > 0.6  # control


def test_the_surface_then_reaches_the_pile(results):
    for name in ("friction", "all, psi = 0"):
        assert results[name]["surfaceContinuous"] and max(results[name]["openBesidePile"]) < 0.15, results[
            name
        ]["openBesidePile"]
    assert not results["published"]["surfaceContinuous"]
    assert min(results["published"]["openBesidePile"]) > 0.5  # control


def test_without_dilatancy_the_surface_hardly_heaves(results):
    assert results["all, psi = 0"]["heaveArea"] < 0.2
    assert results["published"]["heaveArea"] > 1.5  # control


def test_each_correction_lowers_the_resistance(results):
    published, slips, both = (
        results[name]["resistance"]["1.0"] for name in ("published", "friction", "all, psi = 0")
    )
    assert both < 0.8 * slips < 0.8 * 0.8 * published


def test_the_mesh_stays_whole_and_the_run_symmetric(results):
    for summary in results.values():
        assert summary["invertedDomains"] == 0 and summary["minJacobian"] > 0.8
        assert summary["tipDrift"] < 0.02


def test_the_remedied_run_keeps_its_energy(results):
    """With a wedge, splitting and an undamped pile; at this rate neither is quasi-static."""

    def ratios(name):
        return [results[name]["quasiStatic"][what] for what in ("energyError", "dampedRatio")]

    assert max(ratios("all, psi = 0")) < 0.01
    assert ratios("friction")[1] > 0.02  # control: a damped pile


def test_the_table_names_every_run(results):
    lines = corrections.table(results).splitlines()
    assert [line.split("|")[1].strip() for line in lines[2:]] == list(results)


# --- the tip --------------------------------------------------------------------------------------------
def words(*more):
    return sheet_pile_study.arguments(["--cell", "0.5", *more])


def test_the_published_run_needs_no_option():
    a = words()
    assert (a.friction, a.dilatancyLimit, a.split, a.fbar, a.tip, a.undamped, a.ramp) == (
        None,
        None,
        None,
        False,
        180,
        False,
        0,
    )
    b = words("--corrections", "--friction", "0.5", "--rate", "0.2")
    assert (b.friction, b.dilatancyLimit, b.split, b.fbar, b.tip, b.undamped, b.ramp) == (
        0.5,
        0.05,
        1.3,
        True,
        90,
        True,
        0.5,
    )


@pytest.mark.parametrize("angle", [60, 90, 120])
def test_a_wedge_has_its_angle_and_stands_where_the_flat_tip_does(angle):
    a = words("--friction", "0.3", "--tip", str(angle))
    pile = sheet_pile_model.build(a)["pile"]
    x, y = pile.vertices.T
    half, bottom = a.thickness / 2, sheet_pile.DEPTH - sheet_pile.EMBEDDED
    depth = half / np.tan(np.radians(angle / 2))
    assert y.min() == bottom and x[np.argmin(y)] == a.width / 2
    assert y[np.isclose(x, a.width / 2 + half)].min() == pytest.approx(bottom + depth)
    assert pile.volume.sum() == pytest.approx(a.thickness * (sheet_pile.PILE_LENGTH - depth / 2), rel=1e-12)
    flat = sheet_pile_model.build(words("--friction", "0.3"))["pile"]
    assert flat.vertices[:, 1].min() == bottom
    assert flat.volume.sum() == pytest.approx(a.thickness * sheet_pile.PILE_LENGTH)


@pytest.mark.parametrize(
    "given, message",
    [
        (["--tip", "90"], "--tip needs a pile that is a mesh"),
        (["--friction", "0.3", "--tip", "20"], "--tip: 20 is not allowed; give a number from 30 to 180"),
    ],
)
def test_a_tip_that_cannot_be_is_refused(given, message, capsys):
    with pytest.raises(SystemExit):
        words(*given)
    assert message in capsys.readouterr().err


def test_scatter_is_zero_of_a_straight_line_and_that_of_a_wave_elsewhere():
    x = np.linspace(0, 4, 4001)
    assert geotech.scatter(x, 100 + 50 * x, 100 + 50 * x) == 0
    assert geotech.scatter(x, 100 + 10 * np.sin(2 * np.pi * x), np.full_like(x, 100.0)) == pytest.approx(
        0.1 / 2**0.5, rel=1e-3
    )
    assert geotech.scatter(x[:500], x[:500], x[:500]) is None
