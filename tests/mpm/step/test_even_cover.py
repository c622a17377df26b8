# SPDX-License-Identifier: GPL-2.0-or-later
"""Boxes with F-bar go from full cells to emptier ones; their velocities stay, and so does the momentum."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

CLAY = dict(density=2.0, young=2e3, poisson=0.45, cohesion=2.0, frictionAngle=0.0)


def test_momentum_stays_in_clay_that_flows_in_empty_space():
    """An L, so that nothing cancels by symmetry; velocities that followed the field lost 1e-4 of it."""
    scene = mpm.Scene((0, 0), (8, 8), 0.25, threads=1)
    clay = mpm.MohrCoulombDruckerPrager(**CLAY)
    body = scene.add("clay", box((3, 3), (5, 5)) - box((4, 4), (5, 5)), clay, mpm.UGIMP(perCell=2))
    x = body.position - (4, 4)
    body.velocity[:, 0] = 3 * x[:, 1] * np.abs(x[:, 1])
    body.velocity[:, 1] = 0.3
    scene.engines = chain()
    momentum, scale = body.mass @ body.velocity, np.abs(body.mass @ np.abs(body.velocity)).max()
    reference = body.byId("reference")
    scene.run(steps=200, progress=False)
    assert np.abs(body.mass @ body.velocity - momentum).max() < 1e-13 * scene.steps * scale
    assert np.abs(body.byId("reference") - reference).max() > 1e-3  # control: boxes were moved


def test_the_centre_of_mass_of_a_free_body_goes_straight_on():
    """Shifts of boxes between cells move the mass by a small part of a cell, and back."""
    scene = mpm.Scene((0, 0), (8, 8), 0.25, threads=1)
    body = scene.add("clay", box((3, 3), (5, 5)), mpm.MohrCoulombDruckerPrager(**CLAY), mpm.UGIMP(perCell=2))
    body.velocity[:, 0] = 3 * (body.position[:, 1] - 4) * np.abs(body.position[:, 1] - 4)
    body.velocity[:, 1] = 0.3
    scene.engines = chain()
    scene.run(steps=200, progress=False)
    way = np.average(body.position, axis=0, weights=body.mass) - (4, 4)
    assert way == pytest.approx(np.array([0, 0.3]) * scene.time, abs=1e-3 * 0.25)
