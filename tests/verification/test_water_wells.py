# SPDX-License-Identifier: GPL-2.0-or-later
"""Wells and drains against closed forms, and what is refused."""

from math import pi

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from setups import restarted
from yade_mpm import box

GAMMA, K = 9.81, 4e-3  # kN/m3, water; m/s


def confined(lower, upper, h, seconds, axisymmetric=False, **water):
    """An aquifer that is closed above and below."""
    scene = mpm.Scene(lower, upper, h, axisymmetric=axisymmetric, gravity=GAMMA, damping=0.5)
    scene.roller("left", "right", "bottom", "top")
    elastic = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.2)
    given = mpm.PoreWater(permeability=K, tolerance=1e-6, **water)
    soil = scene.add("soil", box(lower, upper), elastic, mpm.UGIMP(), fbar=True, water=given)
    scene.dt = 1e-4
    scene.run(until=seconds, progress=False)
    return scene, soil, given


@pytest.mark.verifies("drawdown round a well with a discharge", reference="Thiem", tolerance=0.015)
def test_a_well_draws_the_head_down_as_thiem_says(verified):
    h, outer, well, flow = 0.125, 2.5, 0.125, 4e-3
    _, soil, water = confined(
        (0, 0), (outer, 2 * h), h, 0.7, True, heads={"right": 3.0}, wells=[(box((0, 0), (well, 1)), flow)]
    )
    cell = np.floor(soil.position[:, 0] / h).astype(int)
    heads = np.array([water.head(soil)[cell == c].mean() for c in range(2, 20)])
    drawdown = flow / (2 * pi * K * 2 * h) * np.log(outer / (np.arange(2, 20) + 0.5) / h)
    verified(3 - heads, drawdown, scale=drawdown[0])  # ln r is not linear in the two cells at the well
    assert water.outflow == pytest.approx(flow, rel=1e-6)
    assert water.inflow == pytest.approx(flow, rel=0.02)  # rings lose 1.3 %: see the limits


def block(**water):
    return confined((0, 0), (2, 1), 0.25, 0.25, heads={"left": 3.0, "right": 3.0}, **water)


@pytest.mark.verifies("flow to a drain across an aquifer", reference="Dupuit: 2 k b s/L", tolerance=0.005)
def test_a_drain_takes_water_down_to_its_head(verified):
    """A column of cells is held at 2 m between faces at 3 m; the drain is a cell wide."""
    drain = box((1.0, 0), (1.25, 1))
    _, soil, water = block(drains=[(drain, 2.0)])
    verified(water.outflow, K * (1 / 1.125 + 1 / 0.875))
    inside = (soil.position[:, 0] > 1) & (soil.position[:, 0] < 1.25)
    assert water.head(soil)[inside].mean() == pytest.approx(2.0, abs=0.002)


def test_a_drain_above_the_head_does_nothing():
    """And one without a head is at the pressure 0."""
    _, soil, water = block(drains=[(box((1.0, 0), (1.25, 1)), 3.1)])
    assert water.outflow < 1e-4 * K and water.head(soil).mean() == pytest.approx(3.0, abs=1e-3)
    _, soil, water = block(drains=[box((1.0, 0.25), (1.25, 0.5))])
    inside = (abs(soil.position - (1.125, 0.375)) < 0.125).all(axis=1)
    assert soil.porePressure[inside].mean() == pytest.approx(0, abs=0.05) and water.outflow > 0.5 * K


def test_a_checkpoint_keeps_wells_and_drains():
    scene, _, _ = block(drains=[(box((1.0, 0), (1.25, 1)), 2.0)], wells=[(box((0, 0), (0.5, 1)), 4e-4)])
    restarted(scene, 20)


def one(**water):
    def make():
        scene = mpm.Scene((0, 0), (1, 1), 0.25, gravity=GAMMA)
        elastic = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.2)
        return scene.add("soil", box((0, 0), (1, 1)), elastic, mpm.UGIMP(), water=mpm.PoreWater(**water))

    return make


@cases(
    ("wells has 3 ... (region, flow in m3/s)", one(wells=[3, "a"]), TypeError),
    ("drains has 'bottom' ... region, or (region, head in m)", one(drains=["bottom"]), TypeError),
    ("wells has", one(wells=[box((0, 0), (1, 1))]), TypeError),
    ("drains has the cell 1e+06", lambda: one(drains=[1e6, 1.0])().scene.run(steps=1)),
    ("has the middle of no cell", one(drains=[box((0.3, 0.3), (0.35, 0.35))])),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)


def test_drains_and_wells_change_between_two_runs():
    """A pit is dewatered in stages: regions are taken as at the start, and an empty list ends them."""
    scene, _, water = block()
    drain = [(box((1.0, 0), (1.25, 1)), 2.0)]
    _, _, other = block(drains=drain)
    water.drains = drain
    assert water.drains == other.drains
    scene.run(until=scene.time + 0.1, progress=False)
    assert water.outflow == pytest.approx(K * (1 / 1.125 + 1 / 0.875), rel=0.02)
    water.drains, water.wells = [], [(box((1.0, 0), (1.25, 1)), 1e-3)]
    scene.run(until=scene.time + 0.1, progress=False)
    assert water.outflow == pytest.approx(1e-3, rel=1e-6)
    with pytest.raises(TypeError, match="drains has 3"):
        water.drains = [box((1, 0), (1.25, 1)), 3]
