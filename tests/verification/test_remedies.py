# SPDX-License-Identifier: GPL-2.0-or-later
"""What slip and the limit of dilatancy change in the sheet pile (scripts/remedies.py), on a coarse grid.

With friction the soil beside the embedded metre stays where it is (no collar) and closes behind the tip; without dilatancy the
surface hardly heaves; both lower the resistance. Control: the published model, which shows all of it.
"""
import argparse
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import remedies  # noqa: E402


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    a = argparse.Namespace(cell=0.5, rate=1.0, penetration=1.0, threads=1, out=str(tmp_path_factory.mktemp("remedies")))
    runs = {name: remedies.run(a, name) for name in ("published", "friction", "all, psi = 0")}
    remedies.draw(a, {name: scene for name, (_, scene) in runs.items()}, a.out + "/remedies.png")
    return {name: summary for name, (summary, _) in runs.items()}


def test_soil_that_slips_makes_no_collar(results):
    for name in ("friction", "all, psi = 0"):
        assert results[name]["collarThickness"] < 0.1  # at most one box to each side, of eight
    assert results["published"]["collarThickness"] > 0.4  # control


def test_it_closes_behind_the_tip(results):
    assert results["friction"]["openCavityArea"] < 0.1
    assert results["published"]["openCavityArea"] > 0.6  # control


def test_without_dilatancy_the_surface_hardly_heaves(results):
    assert results["all, psi = 0"]["heaveArea"] < 0.2
    assert results["published"]["heaveArea"] > 1.5  # control


def test_each_remedy_lowers_the_resistance(results):
    published, slips, both = (results[name]["resistance"]["1.0"] for name in ("published", "friction", "all, psi = 0"))
    assert both < 0.8 * slips < 0.8 * 0.8 * published


def test_the_mesh_stays_whole_and_the_run_symmetric(results):
    for summary in results.values():
        assert summary["invertedDomains"] == 0 and summary["minJacobian"] > 0.8
        assert summary["tipDrift"] < 0.02


def test_the_table_names_every_run(results):
    lines = remedies.table(results).splitlines()
    assert [line.split("|")[1].strip() for line in lines[2:]] == list(results)
