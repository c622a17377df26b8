# SPDX-License-Identifier: GPL-2.0-or-later
"""Water in axisymmetric scenes against closed forms: a well, and a cylinder that drains at its side."""

from math import log, sqrt

import numpy as np
import pytest
import yade_mpm as mpm
from scipy.optimize import brentq
from scipy.special import j0, j1
from yade_mpm import box

GAMMA = 9.81  # kN/m3, water
KINDS = {"boxes": lambda h: mpm.UGIMP(), "mesh": lambda h: mpm.APDI(size=h / 2)}


@pytest.mark.verifies("heads round a well", reference="Thiem", tolerance=0.01)
@pytest.mark.parametrize("kind", KINDS)
def test_water_flows_to_a_well(kind, verified):
    inner, outer, cells, k = 0.5, 2.5, 16, 1e-3
    h = (outer - inner) / cells
    scene = mpm.Scene((inner, 0), (outer, 2 * h), h, axisymmetric=True, gravity=GAMMA, threads=1)
    scene.roller("left", "right", "bottom", "top")
    water = mpm.PoreWater(permeability=k, heads={"left": 2.0, "right": 3.0}, tolerance=1e-6)
    elastic = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.2)
    soil = scene.add("soil", box((inner, 0), (outer, 2 * h)), elastic, KINDS[kind](h), water=water)
    scene.dt, scene.damping = 1e-4, 0.5
    scene.run(until=0.3, progress=False)
    cell = np.floor((soil.position[:, 0] - inner) / h).astype(int)
    heads = np.array([water.head(soil)[cell == c].mean() for c in range(cells)])
    exact = 2 + np.log((inner + (np.arange(cells) + 0.5) * h) / inner) / log(outer / inner)
    verified(heads, exact, scale=1.0)
    assert abs(heads - np.linspace(2.1, 2.9, cells)).max() > 0.1  # as in plane strain


def cylinder(T, r, poisson=0.0):
    """Pressure over the first one in a long cylinder under a load on its side, which drains, at T = c_v t/R2
    and r over R. The strain diffuses, and its value at the side follows from its mean: modes J0(a r) with
    (1 - nu) a J0(a) = (1 - 2 nu) J1(a), orthogonal with the weight of that mean (De Leeuw 1965)."""
    beta = (1 - 2 * poisson) / (1 - poisson)  # 2 G/M
    x = np.linspace(0.05, 200, 40000)
    f = beta * j1(x) - x * j0(x)
    changes = np.flatnonzero(f[1:] * f[:-1] < 0)
    a = np.array([brentq(lambda y: beta * j1(y) - y * j0(y), x[i], x[i + 1]) for i in changes])
    mean = j1(a) / a
    part = mean * (1 - beta / 2) / (0.5 * (j0(a) ** 2 + j1(a) ** 2) - beta * mean**2)
    return (part * (j0(a * r) - j0(a)) * np.exp(-a * a * T)).sum() / (1 - beta / 2)


@pytest.mark.verifies("pressure in a cylinder that drains at its side", reference="De Leeuw", tolerance=0.01)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("fbar", [False, True])
def test_a_cylinder_drains_at_its_side(fbar, kind, verified):
    """In the middle the pressure rises to 1.26 of what it was before it falls."""
    h, M = 0.1, 1e4
    scene = mpm.Scene((0, 0), (1.2, 2 * h), h, axisymmetric=True, threads=1, damping=0.0)
    scene.roller("left", "bottom", "top")
    elastic = mpm.LinearElastic(density=2.0, young=M, poisson=0.0)
    water = mpm.PoreWater(permeability=GAMMA / M / 6, tolerance=1e-4)  # c_v = 1/6 m2/s
    soil = scene.add("soil", box((0, 0), (1, 2 * h)), elastic, KINDS[kind](h), fbar=fbar, water=water)
    soil.porePressure, stress = 1.0, np.zeros_like(soil.stress)
    stress[:, [0, 1, 2], [0, 1, 2]] = 1.0
    soil.stress = stress
    scene.dt = 0.3 * h / sqrt(M / 2)
    for T in (0.05, 0.1, 0.2, 0.4):
        scene.run(until=6 * T, progress=False)
        verified(soil.porePressure[soil.position[:, 0] < h].mean(), cylinder(T, 0.5 * h), scale=1.0)
