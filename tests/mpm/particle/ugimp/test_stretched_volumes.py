# SPDX-License-Identifier: GPL-2.0-or-later
"""A box that is stretched without end keeps its volume: round-off leaves nothing of the determinant of F."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import elastic
from yade_mpm import box
from yade_mpm import diagnostics as d

SAND = dict(density=2.0, young=2e4, poisson=0.3, cohesion=1.0, frictionAngle=0.5)


def stretched(dim, stretch):
    """F of a box that was turned, stretched and turned again; its determinant is 1."""
    a, b = (np.array([[np.cos(x), -np.sin(x)], [np.sin(x), np.cos(x)]]) for x in (0.3, 0.7))
    F = np.eye(3)
    F[:2, :2] = a @ np.diag((stretch, 1 / stretch)) @ b
    if dim == 3:  # none of the planes has all of it
        c = np.array([[1, 0, 0], [0, np.cos(0.5), -np.sin(0.5)], [0, np.sin(0.5), np.cos(0.5)]])
        F = c @ F @ c
    return F


def grown(dim, isRound, stretch, law=None, fbar=False, opening=0.0, rate=0.5, dt=1e-3):
    """V/V0 inside of a block that grows at a rate along all axes, after a step."""
    scene = mpm.Scene((0,) * dim, (4,) * dim, 1.0, axisymmetric=isRound, threads=1)
    body = scene.add(
        "body", box((0,) * dim, (4,) * dim), law or elastic(1e3), mpm.UGIMP(perCell=2), fbar=fbar
    )
    body.velocity = rate * body.position
    body.deformationGradient = stretched(dim, stretch)
    if opening:
        body.opening[:] = opening
        body.volume *= np.exp(-opening)
    scene.dt = dt
    scene.run(steps=1, progress=False)
    inside = (np.abs(body.position - 2) < 0.9).all(axis=1)
    volume = getattr(body, "bulkVolume", body.volume)
    assert d.invertedCount(scene) == 0
    return volume[inside] / body.initialVolume[inside]


@pytest.mark.parametrize("fbar", [False, True])
@pytest.mark.parametrize("dim, isRound", [(2, False), (2, True), (3, False)])
def test_volume_follows_the_rate_of_volume_change(dim, isRound, fbar):
    expected = grown(dim, isRound, 1.0, fbar=fbar)
    assert expected == pytest.approx(1 + (3 if isRound else dim) * 0.5e-3, rel=1e-4)
    assert grown(dim, isRound, 1e9, fbar=fbar) == pytest.approx(expected, rel=1e-9)


@pytest.mark.filterwarnings("ignore:.*outside the yield surface")
def test_what_soil_stands_open_by_is_in_its_bulk_volume():
    law = mpm.MohrCoulombDruckerPrager(**SAND)
    expected = grown(2, False, 1.0, law, True, opening=0.2)
    assert grown(2, False, 1e9, law, True, opening=0.2) == pytest.approx(expected, rel=1e-9)


def test_both_volumes_agree_where_one_gives_way_to_the_other():
    """Terms of the determinant that are 3e5 and 3e6 times as large as what is left of them."""
    below, above = (grown(2, False, stretch) for stretch in (1e3, 3e3))
    assert below == pytest.approx(above, rel=1e-8)
