# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/propped_wall.py beside a hand calculation: free earth and Rankine."""

import importlib
import re
import sys

import pytest


@pytest.mark.slow
def test_the_prop_takes_more_than_by_hand_and_the_moment_is_smaller(tmp_path, monkeypatch, capsys):
    """Soil arches to the prop: 47.3 and 36.2 kN/m, 33.9 and 47.7 kN m/m. With 0.5 m cells 52.9 and 36.1."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["propped_wall", "--out", str(tmp_path)])
    importlib.import_module("propped_wall").main()
    found = re.search(
        r"prop ([\d.]+) kN/m, moment ([\d.]+) kN m/m; by hand \(([\d.]+), ([\d.]+)\)", capsys.readouterr().out
    )
    prop, moment, propByHand, momentByHand = map(float, found.groups())
    assert (propByHand, momentByHand) == (36.2, 47.7)
    assert prop == pytest.approx(47.8, rel=0.05) and moment == pytest.approx(34.2, rel=0.05)
    assert propByHand < prop < 0.5 * 18 / 3 * 6.5**2  # the whole active thrust
    assert (tmp_path / "propped_wall.html").exists()
