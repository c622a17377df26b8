# SPDX-License-Identifier: GPL-2.0-or-later
"""Axisymmetric bodies pressed deep into clay: a cone, a spudcan and tubes (scripts/cone.py and others).

References and their sources are in the docstrings of the scripts.
"""

import numpy as np
import pytest
from asModules import runScript, script

slow = pytest.mark.slow


def run(name, *options):
    return runScript(name, "--threads", "1", *options)


# --- cone -------------------------------------------------------------------------------------------------
@pytest.mark.verifies("Cone in clay: force on its shaft", reference="adhesion times area", tolerance=0.1)
def test_a_shaft_resists_by_its_adhesion_and_no_more(verified):
    """After one radius; the tip has not come to its limit. Control: a smooth shaft resists nothing."""
    rough, smooth = (run("cone", "--smoke", "--alpha", alpha) for alpha in ("1", "0"))
    verified(rough["onShaft"], 1)
    verified(smooth["onShaft"], 0, scale=1, within=0.02)
    assert smooth["factor"] < rough["factor"] < smooth["exact"] + 1.3


@slow
@pytest.mark.verifies("Cone in clay after 6 R, 4 cells: N", reference="Lu et al. 2004", tolerance=0.1)
def test_a_cone_resists_as_published(verified):
    summary = run("cone", "--way", "6")
    verified(summary["error"], 0, scale=1)
    assert 0 < summary["rise"] < 0.06


# --- spudcan ----------------------------------------------------------------------------------------------
def test_the_published_cavity_is_that_of_the_formula():
    exact = script("spudcan").exact
    assert [exact(s) for s in (0.25, 0.5, 1.0)] == pytest.approx([0.404, 0.558, 0.75], abs=1e-3)


def test_clay_does_not_flow_back_at_first():
    """The foot is in the ground; the load is between that of a circular footing and a deep one."""
    summary = run("spudcan", "--smoke")
    assert summary["cavity"] is None and 6 < summary["factor"] < 12


@slow
@pytest.mark.verifies(
    "Spudcan in clay: depth of the cavity", reference="Hossain & Randolph 2009", tolerance=0.2
)
def test_clay_flows_back_below_the_published_depth(verified):
    """Control: stronger clay stays open deeper."""
    weak, strong = (run("spudcan", "--strength", strength) for strength in ("0.25", "0.5"))
    for summary in (weak, strong):
        verified(summary["cavity"], summary["exact"])
    assert strong["cavity"] > 1.3 * weak["cavity"]


# --- tubes ------------------------------------------------------------------------------------------------
def test_a_closed_pile_is_closed_when_it_is_coarse_too():
    walls = [
        script("tube").arguments(["--kind", kind, "--smoke"]).wall for kind in ("caisson", "open", "closed")
    ]
    assert walls == [0.5, 0.5, 1.0]


@pytest.mark.parametrize("alpha", [0.0, 0.5, 1.0])
def test_the_formula_has_the_shafts_and_the_tip(alpha):
    """R = 1 m, a wall of half of it, 2 m deep, filled to the surface: 9 su + gamma z = 120 kPa on the tip."""
    tube = script("tube")
    wall, plugged = tube.formula(tube.arguments(["--wall", "0.5", "--alpha", str(alpha)]), 2.0, 2.0)
    assert wall == pytest.approx(np.pi * (120 * 0.75 + 60 * alpha))
    assert plugged == pytest.approx(np.pi * (120 + 40 * alpha))


def test_friction_inside_takes_the_plug_down():
    """From 2.25 R on, by equilibrium of the plug. Control: in a smooth tube the soil of the wall goes up."""
    pile = "--kind", "open", "--wall", "0.5", "--cells", "4", "--depth", "3"
    rough, smooth = (run("tube", *pile, "--alpha", alpha) for alpha in ("1", "0"))
    assert rough["filling"] < 0.75 and rough["inside"] < 0.9
    assert smooth["filling"] > 1.2 and 1.2 < smooth["inside"] < 2


@slow
@pytest.mark.parametrize("kind", ["caisson", "open", "closed"])
@pytest.mark.verifies(
    "Caisson, open and closed pile in clay: resistance", reference="Houlsby & Byrne 2005", tolerance=0.2
)
def test_tubes_resist_as_by_the_formula(kind, verified):
    summary = run("tube", "--kind", kind)
    verified(summary["error"], 0, scale=1)
    assert {"caisson": 1.05 < summary["filling"] < 1.44, "open": summary["filling"] < 0.7}.get(kind, True)
