# SPDX-License-Identifier: GPL-2.0-or-later
"""Water in axisymmetric scenes against closed forms: a well, cylinders that drain, a footing."""

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


@pytest.mark.parametrize("kind, within", [("boxes", 1e-5), ("mesh", 2e-5)])
def test_undrained_rings_keep_their_volume(kind, within):
    """Pressed by a tenth in 50 steps. By the change of its section alone a ring gained 8e-5 of its volume."""
    h, by, rate = 0.125, 0.1, 0.5
    scene = mpm.Scene((0, 0), (2, 1 + 2 * h), h, axisymmetric=True, threads=1, damping=0.2)
    scene.roller("left", "bottom")
    elastic = mpm.LinearElastic(density=2.0, young=1e3, poisson=0.2)
    soil = scene.add("soil", box((0, 0), (1, 1)), elastic, KINDS[kind](h), fbar=True, undrained=True)
    scene.drive(box((-h, 1 - 1e-6), (2, 2)), velocity=(None, -rate), ramp=0.02)
    scene.run(until=0.01 + by / rate, progress=False)
    assert scene.steps < 100 and soil.displacement[:, 0].max() > 0.03
    inside = soil.position[:, 0] < 0.8
    assert (soil.volume / soil.initialVolume)[inside].mean() == pytest.approx(1, abs=within)


@pytest.mark.parametrize("isRough, exact", [(True, 6.05), (False, 5.69)])
@pytest.mark.parametrize("kind, cells", [("boxes", 11), ("mesh", 7)])
@pytest.mark.filterwarnings("ignore:.*is a mesh and flows")
@pytest.mark.verifies(
    "circular footing on undrained clay, by effective stress", reference="Cox et al. 1961", tolerance=0.05
)
def test_a_circular_footing_resists_with_the_undrained_strength(kind, cells, isRough, exact, verified):
    """Of the radius of 1 m; what holds nodes presses half a cell beyond the last one. The skeleton alone
    would lose volume (Poisson's ratio of 0.2): water takes the mean stress, and the effective one stays."""
    h, su, shear, nu, rate, end = 1 / (cells + 0.5), 10.0, 1e4, 0.2, 0.05, 0.3
    wide, deep = np.ceil(4 / h) * h, np.ceil(3 / h) * h
    scene = mpm.Scene((0, 0), (wide, deep + 4 * h), h, axisymmetric=True, threads=1, damping=0.5)
    clay = mpm.Tresca(density=2.0, lame=(2 * shear * nu / (1 - 2 * nu), shear), undrainedStrength=su)
    particles = mpm.UGIMP() if kind == "boxes" else mpm.APDI(size=h)
    soil = scene.add("soil", box((0, 0), (wide, deep)), clay, particles, undrained=True)
    scene.roller("right")
    scene.fix("bottom")
    nodes = box((-3 * h, deep - 0.1 * h), ((cells + 0.1) * h, deep + 3 * h))
    press = scene.drive(nodes, velocity=(0.0 if isRough else None, -rate), ramp=0.1, name="footing")
    scene.run(until=end - 0.1, progress=False)
    before = press.impulse[1]
    scene.run(until=end, progress=False)
    verified((before - press.impulse[1]) / 0.1 / np.pi / su, exact)
    assert abs(soil.volume / soil.initialVolume - 1).max() < 5e-4
    below = (soil.position[:, 0] < 0.5) & (soil.position[:, 1] > deep - 0.5)
    effective = np.trace(soil.stress, axis1=1, axis2=2).mean(where=below) / 3
    assert soil.porePressure[below].mean() > 3 * su and abs(effective) < 0.05 * su
