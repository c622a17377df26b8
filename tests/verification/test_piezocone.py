# SPDX-License-Identifier: GPL-2.0-or-later
"""A piezocone that stops in saturated clay (scripts/piezocone.py): excess pore pressure and its dissipation.

References: the pressure in a spherical cavity at its limit, 4/3 su ln Ir (Vesic 1972), for the face; Teh &
Houlsby 1991 for the time factor at which half of the pressure behind the shoulder is left. Strain paths and
uncoupled consolidation scatter by as much as the tolerance.
"""

import importlib
from math import log

import numpy as np
import pytest
from asModules import runScript


@pytest.mark.verifies(
    "Piezocone in clay: excess pressure at its face", reference="spherical cavity", tolerance=0.15
)
def test_a_cone_raises_the_pressure_of_a_cavity_and_it_dissipates(verified):
    """After two radii: the clay beside the shaft was not passed by the cone, and half is gone early."""
    summary = runScript("piezocone", "--smoke", "--threads", "1")
    verified(summary["u1"]["overStrength"], 4 / 3 * log(100))
    for name in ("u1", "u2"):
        found = summary[name]["found"]
        assert summary[name]["left"][3] == 0.5 and found == sorted(found)
    assert summary["u2"]["found"][3] < summary["u2"]["published"][3]


def test_undrained_clay_keeps_its_volume_in_the_cells_that_a_cone_cuts():
    """After three radii. With the flux of such a cell shared in two ways V/V0 was 0.89, with a balance for
    the section of rings alone 1.017."""
    piezocone = importlib.import_module("piezocone")
    a = piezocone.arguments(["--cells", "3", "--way", "3", "--threads", "1"])
    scene = piezocone.build(a)
    scene.run(until=3 * piezocone.RADIUS / a.rate, progress=False)
    soil = scene["soil"]
    near = np.abs(soil.position[:, 1] - scene["cone"].vertices[:, 1].min()) < 3 * piezocone.RADIUS
    ratio = (soil.volume / soil.initialVolume)[near]
    assert ratio.min() > 0.99 and ratio.max() < 1.01


@pytest.mark.slow
@pytest.mark.verifies(
    "Piezocone in clay: time factor of half the pressure behind the shoulder",
    reference="Teh & Houlsby 1991",
    tolerance=0.25,
)
def test_half_of_the_pressure_is_gone_as_published(verified):
    """Control: with a cone that went two radii, above, it is gone in half of the time; half a cell from the
    face, in the cells that the cone cuts, half of u1 is gone at 0.157."""
    summary = runScript("piezocone", "--end", "0.5", "--threads", "1")
    verified(summary["u2"]["found"][3], summary["u2"]["published"][3])
    assert summary["u1"]["found"][3] == pytest.approx(summary["u1"]["published"][3], rel=0.1)
