# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/propped_wall.py beside calculations by hand: free earth, Rankine, settlements behind walls."""

import importlib
import sys

import numpy as np
import propped_wall
import propped_wall_by_hand as byHand
import pytest


def test_the_calculation_by_hand_balances_moments_and_forces():
    prop, moment = propped_wall.byHand()
    assert (prop, moment) == (36.2, 47.7)
    depth = np.linspace(0, propped_wall.LENGTH, 2001)
    found = byHand.moments(depth)
    assert found.max() == pytest.approx(moment, abs=0.1)
    assert found[-1] == pytest.approx(0, abs=0.3)  # by the force of the prop to three digits
    assert byHand.rankine(np.array([3.0, 5.0]))[0] == pytest.approx([18, 30])
    assert byHand.rankine(np.array([3.0, 5.0]))[1] == pytest.approx([0, 54])
    assert byHand.settlement(np.array([0.0, 4.0, 9.0])) == pytest.approx([12, 6, 0])


@pytest.mark.slow
def test_the_prop_takes_more_than_by_hand_and_the_moment_is_smaller(tmp_path, monkeypatch):
    """Soil arches to the prop, which keeps more pressure beside it; the toe is fixed; the soil settles in the
    active wedge. With 0.5 m cells 36.4 kN/m and 26.6 kN m/m."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["propped_wall", "--out", str(tmp_path)])
    scene, (forces, pressure) = importlib.import_module("propped_wall").main()
    found = {name: (computed, hand) for name, computed, hand in byHand.rows(scene, forces, pressure)}
    prop, hand = found["prop (kN/m)"]
    assert prop == pytest.approx(37.2, rel=0.05) and hand == 36.2
    assert hand < prop < 0.5 * 18 / 3 * 6.5**2  # the whole active thrust
    assert found["largest moment (kN m/m)"][0] == pytest.approx(27.9, rel=0.05)
    assert found["its depth (m)"] == pytest.approx((3.0, 3.5), abs=0.3)
    behind = [pair for name, pair in found.items() if name.startswith("pressure behind")]
    assert behind[0][0] > 2 * behind[0][1]  # at the prop
    assert all(computed < hand for computed, hand in behind[1:5])
    assert found["pressure in front, 4.5 m deep (kPa)"][0] == pytest.approx(27, rel=0.15)  # passive
    assert found["settlement 0.0 m behind the wall (mm)"][0] == pytest.approx(8.2, rel=0.1)
    assert found["settlement 4.0 m behind the wall (mm)"][0] < 6
    assert (tmp_path / "propped_wall.html").exists()
