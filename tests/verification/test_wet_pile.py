# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/wet_pile.py: from undrained to drained by V, on the coarse grid of a smoke run."""

import importlib
import sys

import pytest

pytestmark = pytest.mark.filterwarnings("ignore:groundStress")  # the pile stands in the ground


@pytest.fixture(scope="module")
def pressed():
    """Resistance and excess at the tip by V, and the resistance without water; volumes at the end."""
    scene = importlib.import_module("wet_pile")
    a = scene.PARAMETERS.parse(["--smoke"])
    found = {V: scene.run(a, V) for V in (100.0, 0.1, None)}
    soil = found[100.0][0]["soil"]
    return {V: (force[-10:].mean(), excess[-10:].mean()) for V, (_, _, force, excess) in found.items()}, soil


def test_the_slower_the_more_it_resists(pressed):
    ends, _ = pressed
    assert 1.3 * ends[100.0][0] < ends[0.1][0] < ends[None][0]


def test_the_excess_pressure_leaves_where_there_is_time(pressed):
    ends, _ = pressed
    assert ends[100.0][1] > 30 and ends[0.1][1] < 0.7 * ends[100.0][1]


def test_undrained_soil_keeps_its_volume_round_the_pile(pressed):
    _, soil = pressed
    assert abs(soil.volume / soil.initialVolume - 1).max() < 0.03


def test_it_draws_its_picture(pressed, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["wet_pile", "--smoke", "--out", str(tmp_path)])
    importlib.import_module("wet_pile").main()
    assert (tmp_path / "wet_pile.png").exists()
