# SPDX-License-Identifier: GPL-2.0-or-later
"""The line of the quasi-static check that says whether pore water has time to leave."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import elastic
from yade_mpm import box, diagnostics

MODULUS = 1e4 * 0.7 / (1.3 * 0.4)  # kPa, oedometer, of Young's modulus 1e4 and Poisson's ratio 0.3
SPEED, WIDTH = 0.1, 0.5


def pressed(permeability, drive="plate", water=True):
    """A plate of half a metre, or a block as wide, pressed into soil."""
    scene = mpm.Scene((0, 0), (2, 2), 0.25)
    scene.fix("bottom")
    scene.roller("left", "right")
    pores = mpm.PoreWater(permeability=permeability) if water else None
    scene.add("soil", box((0, 0), (2, 1)), elastic(1e4), mpm.UGIMP(), water=pores)
    if drive == "plate":
        scene.drive(box((-1, 1 - 1e-6), (WIDTH, 3)), velocity=(None, -SPEED))
    else:
        block = scene.add("block", box((0.5, 1), (0.5 + WIDTH, 1.5)), elastic(1e4), mpm.UGIMP())
        scene.drive(block, velocity=(0, -SPEED))
    return scene


def permeabilityAt(V):
    return SPEED * WIDTH / V * 9.81 / MODULUS


@pytest.mark.parametrize("drive", ["plate", "block"])
def test_the_number_is_speed_times_width_over_the_coefficient_of_consolidation(drive):
    assert diagnostics.drainage(pressed(permeabilityAt(2.0), drive))[0] == pytest.approx(2.0, rel=1e-4)


@pytest.mark.parametrize("limit, below, above", [(0.003, "drained", "partly"), (30, "partly", "undrained")])
def test_its_limits_divide_drained_partly_drained_and_undrained(limit, below, above):
    for factor, word in ((0.99, below), (1.01, above)):
        assert diagnostics.drainage(pressed(permeabilityAt(factor * limit)))[1].startswith(word)


def test_soil_without_permeability_is_undrained_as_was_set():
    number, text = diagnostics.drainage(pressed(0.0))
    assert number == np.inf and "as its permeability of 0 says" in text


def test_nothing_is_said_without_water_or_motion():
    assert diagnostics.drainage(pressed(1e-6, water=False)) is None
    still = mpm.Scene((0, 0), (1, 1), 0.25)
    still.add("soil", box((0, 0), (1, 0.5)), elastic(1e4), mpm.UGIMP(), water=mpm.PoreWater())
    assert diagnostics.drainage(still) is None


@pytest.mark.parametrize("water", [True, False])
def test_the_check_prints_it(water):
    scene = pressed(permeabilityAt(100), water=water)
    scene.history(every=0.01)
    scene.run(until=0.05, progress=False)
    found = scene.quasiStatic()
    assert ("pore water: undrained" in str(found)) == water
    assert found.asDict()["drainage"] == (found.drainage if water else None)
