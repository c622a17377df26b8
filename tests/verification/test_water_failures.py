# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground that water makes fail: piping, heave of a pit, drawdown; each beside one that stands."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

GAMMA = 9.81  # kN/m3, water; soil has twice the density
KINDS = {"boxes": lambda h: mpm.UGIMP(), "mesh": lambda h: mpm.APDI(size=h / 2)}
SOIL = dict(density=2.0, young=1e4, poisson=0.3, cohesion=0.0, frictionAngle=radians(30), dilatancyAngle=0)


def waterOf(scene):
    return next(engine for engine in scene.engines if isinstance(engine, mpm.PoreWater))


def flowUp(kind, gradient, cells=10):
    """Sand of 1 m below a level table, through which water flows up."""
    h, sand = 1 / cells, mpm.MohrCoulomb(**SOIL)
    scene = mpm.Scene((0, 0), (2 * h, 1.5), h, gravity=GAMMA)
    scene.roller("left", "right", "bottom")
    water = mpm.PoreWater(table=1.0, permeability=1e-3, heads={"bottom": 1.0 + gradient})
    body = scene.add("sand", box((0, 0), (2 * h, 1)), sand, KINDS[kind](h), water=water)
    scene.groundStress(K0=0.5)
    scene.run(until=1.0, progress=False)
    return scene, body


@pytest.mark.verifies(
    "vertical effective stress above a flow upwards", reference="gamma' - i gamma_w", tolerance=0.015
)
@pytest.mark.parametrize("kind", KINDS)
def test_sand_boils_at_the_critical_gradient(kind, verified):
    """Of 1, with twice the density of water (Terzaghi 1922)."""
    for gradient in (0.5, 0.9):
        _, body = flowUp(kind, gradient)
        row = (body.position[:, 1] * 10).astype(int)
        found = np.array([-body.stress[row == j, 1, 1].mean() for j in range(10)])
        exact = GAMMA * (1 - gradient) * (0.95 - np.arange(10) / 10)
        verified(found[1:9], exact[1:9], scale=GAMMA)
        assert np.abs(body.displacement).max() < 1e-3
    scene, body = flowUp(kind, 1.1)
    assert body.stress[:, 1, 1].mean() > -0.1  # next to nothing is left; -0.49 at 0.9
    before = body.position[:, 1].mean()
    scene.run(until=1.5, progress=False)
    assert body.position[:, 1].mean() - before > 4e-4  # and it rises at a tenth of the permeability and more


@pytest.mark.parametrize("left, heaves", [(1.75, False), (1.25, True)])
def test_the_bottom_of_a_pit_heaves_where_it_is_lighter_than_the_water_below(left, heaves):
    """Clay on sand under 3 m of pressure: its weight is that of the water where 1.5 m of it are left."""
    h = 0.25
    scene = mpm.Scene((0, 0), (2 * h, 4.5), h, gravity=GAMMA, damping=0.3)
    scene.roller("left", "right", "bottom")
    law, given = mpm.MohrCoulomb(**SOIL), dict(table=4.0, heads={"bottom": 4.0})
    sand = mpm.PoreWater(permeability=0.1, **given)
    scene.add("sand", box((0, 0), (2 * h, 1)), law, mpm.UGIMP(), water=sand)
    clay = mpm.PoreWater(permeability=1e-3, **given)
    body = scene.add("clay", box((0, 1), (2 * h, 4)), law, mpm.UGIMP(), water=clay)
    scene.groundStress(K0=0.5)
    scene.remove(region=box((-1, 1 + left), (1, 5)))
    waterOf(scene).table = 1 + left  # pumped dry
    scene.run(until=4.0, progress=False)
    rise = body.displacement[:, 1].min()
    scene.run(until=5.0, progress=False)
    assert (body.displacement[:, 1].min() - rise > 1e-4) == heaves
    bottom = body.position[:, 1] < 1 + h
    assert (body.stress[bottom, 1, 1].max() > -0.5) == heaves


@pytest.mark.verifies(
    "pore pressure after the water above undrained ground is gone",
    reference="Skempton: it falls with the load",
    tolerance=0.002,
)
def test_pressure_in_level_ground_falls_with_the_water_above_it(verified):
    """And effective stress stays."""
    h = 0.25
    scene = mpm.Scene((0, 0), (2 * h, 2.5), h, gravity=GAMMA, damping=0.3)
    scene.roller("left", "right", "bottom")
    water = mpm.PoreWater(table=6.0, permeability=0.0)
    clay = mpm.MohrCoulomb(**SOIL | {"cohesion": 5.0})
    body = scene.add("clay", box((0, 0), (2 * h, 2)), clay, mpm.UGIMP(), water=water)
    scene.groundStress(K0=0.5)
    before, stress = body.porePressure.copy(), body.stress.mean(axis=0)
    water.table = 2.0
    scene.run(until=1.0, progress=False)
    part = 5.5e6 / (5.5e6 + 1e4 * 0.7 / (1.3 * 0.4))
    verified(before - body.porePressure, np.full(body.count, 4 * GAMMA * part))
    assert body.stress.mean(axis=0) == pytest.approx(stress, abs=0.2)


def slope(drop, permeability=1e-7, h=0.5):
    """Displacement, m, of a slope of 4 m at 1 : 2 under water that falls by `drop` m in a second."""
    scene = mpm.Scene((0, 0), (16, 7), h, gravity=GAMMA, damping=0.2)
    scene.fix("bottom")
    scene.roller("left", "right")
    region = mpm.polygon([(0, 0), (16, 0), (16, 2), (11, 2), (3, 6), (0, 6)])
    law = mpm.MohrCoulomb(**SOIL | {"cohesion": 3.0, "frictionAngle": radians(25), "young": 2e4})
    water = mpm.PoreWater(table=6.5, permeability=permeability)
    body = scene.add("soil", region, law, mpm.UGIMP(), water=water)
    scene.groundStress(K0=0.6)
    scene.run(until=0.5, progress=False)
    before = body.displacement.copy()
    for part in np.linspace(0.05, 1, 20):
        water.table = 6.5 - part * drop
        scene.run(until=0.5 + part, progress=False)
    scene.run(until=3.5, progress=False)
    return np.linalg.norm(body.displacement - before, axis=1).max()


@pytest.mark.filterwarnings("ignore:groundStress")
def test_a_slope_fails_when_the_water_before_it_is_drawn_down():
    """It stands under water, and without most of it slides: what is in its pores has no time to leave."""
    assert slope(0.0) < 0.02 < 0.3 < slope(4.5)
