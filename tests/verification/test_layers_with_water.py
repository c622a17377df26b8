# SPDX-License-Identifier: GPL-2.0-or-later
"""Consolidation of a hybrid column and of two layers."""

from math import sqrt

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

GAMMA = 9.81  # kN/m3, water
MODULUS = 1e4  # kPa, oedometer
HEIGHT, CELLS = 1.0, 20
KINDS = {"mesh": mpm.APDI(size=HEIGHT / CELLS / 2), "boxes": mpm.UGIMP()}


def column(*parts):
    """An elastic column without weight that carries 1 kPa and drains to the top.

    parts : (bottom, top, permeability in m/s, particles or None for a hybrid).
    """
    h, nu = HEIGHT / CELLS, 0.3
    scene = mpm.Scene((0, 0), (2 * h, HEIGHT + 2 * h), h)
    scene.roller("left", "right", "bottom")
    young = MODULUS * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    soil = mpm.LinearElastic(density=2.0, young=young, poisson=nu)
    for number, (bottom, top, k, particles) in enumerate(parts):
        water = mpm.PoreWater(permeability=k, tolerance=1e-4)
        body = scene.add(
            f"soil {number}", box((0, bottom), (2 * h, top)), soil, particles, fbar=True, water=water
        )
    scene.attach(mpm.SurfaceLoad(body, (0, 2 * h), pressure=1.0))
    scene.dt = 0.3 * h / sqrt(MODULUS / 2)
    return scene


def basePressure(scene):
    """Pressure of the lowest particles, kPa."""
    body = scene.bodies[0]
    return body.porePressure[np.argmin(body.position[:, 1])]


@pytest.mark.verifies(
    "pressure at the base of a column of a mesh and boxes", reference="Terzaghi", tolerance=0.012
)
@pytest.mark.parametrize("lower, upper", [("mesh", "boxes"), ("boxes", "mesh")])
def test_water_passes_between_a_mesh_and_boxes(lower, upper, verified):
    """The interface is no barrier: what lies below it drains through it."""
    k = GAMMA / MODULUS / 6
    scene = column((0, 0.5, k, KINDS[lower]), (0.5, 1, k, KINDS[upper]))
    for T, exact in ((0.1, 0.9493), (0.5, 0.3708)):
        scene.run(until=6 * T, progress=False)
        verified(basePressure(scene), exact)


def layered(lower, upper, time, cells=400):
    """Pressure at the base of two layers of half the height each after a time, kPa: by finite differences.

    lower, upper : coefficients of consolidation, m2/s.
    """
    d = HEIGHT / cells
    c = np.where((np.arange(cells) + 0.5) * d < 0.5, lower, upper)
    between = 2 * c[1:] * c[:-1] / (c[1:] + c[:-1]) / d**2
    flow = np.diag(np.r_[between, 2 * c[-1] / d**2] + np.r_[0, between])
    flow -= np.diag(between, 1) + np.diag(between, -1)
    rates, modes = np.linalg.eigh(flow)
    return (modes @ (np.exp(-rates * time) * (modes.T @ np.ones(cells))))[0]


def test_the_reference_of_two_layers_is_terzaghis_for_one():
    assert layered(1 / 6, 1 / 6, 3.0) == pytest.approx(0.3708, abs=5e-4)


@pytest.mark.verifies(
    "pressure at the base of two layers", reference="finite differences in one dimension", tolerance=0.012
)
@pytest.mark.parametrize("kinds", [("boxes", "boxes"), ("mesh", "mesh"), ("mesh", "boxes")], ids="-".join)
@pytest.mark.parametrize("lower, upper", [(10.0, 1.0), (1.0, 10.0)])
def test_two_layers_consolidate(lower, upper, kinds, verified):
    """One layer lets ten times as much water through; as if both were alike the result is far off."""
    k = GAMMA / MODULUS / 6
    below, above = (KINDS[kind] for kind in kinds)
    scene = column((0, 0.5, lower * k, below), (0.5, 1, upper * k, above))
    for time in (0.6, 1.5):
        scene.run(until=time, progress=False)
        exact = layered(lower / 6, upper / 6, time)
        verified(basePressure(scene), exact, scale=1.0)
        assert abs(exact - layered(1 / 6, 1 / 6, time)) > 0.03
