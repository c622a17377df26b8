# SPDX-License-Identifier: GPL-2.0-or-later
"""Water in the pores of soil against closed forms: consolidation, seepage, undrained strength."""

from math import cos, exp, pi, radians, sin, sqrt

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

GAMMA = 9.81  # kN/m3, water
KINDS = {"boxes": lambda h: mpm.UGIMP(), "mesh": lambda h: mpm.APDI(size=h / 2)}


def waterOf(scene):
    return next(engine for engine in scene.engines if isinstance(engine, mpm.PoreWater))


def column(kind, cells=10, permeability=None, height=1.0, modulus=1e4, layers=1, **water):
    """An elastic column of 1 m without weight, 1 kPa on top, that drains to the top with c_v = 1/6 m2/s."""
    h, nu = height / cells, 0.3
    scene = mpm.Scene((0, 0), (2 * h, height + 2 * h), h)
    scene.roller("left", "right", "bottom")
    young = modulus * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    soil = mpm.LinearElastic(density=2.0, young=young, poisson=nu)
    k = GAMMA / modulus / 6 if permeability is None else permeability
    body = scene.add(
        "soil",
        box((0, 0), (2 * h, height)),
        soil,
        KINDS[kind](h),
        water=mpm.PoreWater(permeability=k, **{"tolerance": 1e-4, **water}),
    )
    scene.attach(mpm.SurfaceLoad(body, (0, 2 * h), pressure=1.0))
    scene.dt = 0.3 * h / sqrt(modulus / 2)
    return scene, body


@pytest.mark.verifies(
    "pressure at the base in one-dimensional consolidation", reference="Terzaghi", tolerance=0.01
)
@pytest.mark.parametrize("kind", KINDS)
def test_a_column_consolidates_as_terzaghi_says(kind, verified):
    scene, body = column(kind)
    lowest = np.argmin(body.position[:, 1])
    for T, exact in ((0.05, 0.9969), (0.1, 0.9493), (0.2, 0.7723), (0.5, 0.3708), (1.0, 0.1080)):
        scene.run(until=6 * T, progress=False)
        verified(body.porePressure[lowest], exact)


@pytest.mark.verifies("settlement over its end in consolidation", reference="Terzaghi", tolerance=0.01)
def test_a_column_settles_as_terzaghi_says(verified):
    """The load acts on the middles of the highest boxes, so the end is that of the same column."""
    found, (scene, body) = [], column("boxes", cells=20)
    for T in (0.1, 0.2, 0.5, 1.0, 4.0):
        scene.run(until=6 * T, progress=False)
        found.append(1 - body.volume.sum() / body.initialVolume.sum())
    verified(np.array(found[:-1]) / found[-1], [0.3568, 0.5041, 0.7640, 0.9313], scale=1.0)


@pytest.mark.verifies(
    "pressure of the water under an undrained load",
    reference="Skempton: B of one-dimensional strain",
    tolerance=0.002,
)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("softer", [1.0, 1e-2, 2e-3])
def test_undrained_soil_shares_the_load_with_its_water(softer, kind, verified):
    """p/q = K_w/n / (K_w/n + M), with stiff water and with water as soft as the soil."""
    scene, body = column(kind, permeability=0.0, porosity=0.4, bulkModulus=2.2e6 * softer, tolerance=1e-4)
    scene.damping = 0.7
    scene.run(until=1.0, progress=False)
    low = body.position[:, 1] < 0.5
    stiffness = 2.2e6 * softer / 0.4
    verified(body.porePressure[low].mean(), stiffness / (stiffness + 1e4))


@pytest.mark.verifies("head before a face with a flow into the soil", reference="Darcy", tolerance=1e-3)
def test_a_flow_through_a_face_raises_the_head_before_it(verified):
    """1 m of soil from a drained face: the head grows by q/k in a metre."""
    h, k, q = 0.125, 1e-3, 2e-4
    scene = mpm.Scene((0, 0), (1.0, 0.5), h, gravity=GAMMA, damping=0.5)
    scene.roller("left", "right", "bottom", "top")
    elastic = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.2)
    water = mpm.PoreWater(table=2.0, permeability=k, drained="right", inflows={"left": q}, tolerance=1e-6)
    body = scene.add("soil", box((0, 0), (1, 0.5)), elastic, mpm.UGIMP(), fbar=True, water=water)
    scene.groundStress(K0=0.5, bodies=[body])
    scene.dt = 1e-4
    scene.run(until=0.2, progress=False)
    middle = abs(body.position[:, 0] - 0.5) < h / 2
    verified(water.head(body)[middle].mean() - 2.0, q / k * 0.5)
    assert water.inflow == pytest.approx(0.5 * q) and water.outflow == pytest.approx(0.5 * q, rel=1e-3)


def test_only_soil_with_water_takes_a_flow_through_a_face():
    """Half of the last row of cells is soil, or half of the first one a structure."""
    h, q = 0.25, 1e-6
    for low, top, level in ((0, 1.125, 2.0), (0, 1.0, 0.875), (0.125, 1.0, 2.0)):
        scene = mpm.Scene((0, 0), (1.0, 2.0), h, gravity=GAMMA)
        scene.roller("left", "right", "bottom")
        elastic = mpm.LinearElastic(density=2.0, young=2e4, poisson=0.2)
        water = mpm.PoreWater(table=level, permeability=1e-4, inflows={"left": q})
        body = scene.add("soil", box((0, low), (1, top)), elastic, mpm.UGIMP(), fbar=True, water=water)
        if low:
            slab = scene.add("slab", box((0, 0), (1, low)), elastic, mpm.APDI(size=h / 2))
            scene.contact(slab, body)
            scene.drive(slab, velocity=(0.0, 0.0), name="hold")
        scene.groundStress(K0=0.5, bodies=[body])
        scene.run(steps=1, progress=False)
        assert water.inflow == pytest.approx((min(top, level) - low) * q, rel=2e-3)


@pytest.mark.verifies("flow through a block between two heads", reference="Darcy", tolerance=1e-3)
@pytest.mark.parametrize("dim, drop", [(2, 1.0), (3, 1.0), (2, 5e-3), (2, 5.0)])
def test_water_flows_through_a_block_between_two_heads(dim, drop, verified):
    """Control: with an error of the tolerance at any drop of the head, 5 mm lose a part of their flow."""
    h, k = 0.25, 1e-3
    scene = mpm.Scene((0,) * dim, (2.0,) + (1.0,) * (dim - 1), h, gravity=GAMMA)
    scene.roller("left", "right", "bottom", "top", *(("front", "back") if dim == 3 else ()))
    elastic = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.2)
    water = mpm.PoreWater(table=2.0, permeability=k, heads={"left": 2.0 + drop, "right": 2.0})
    body = scene.add("soil", box((0,) * dim, scene.upper), elastic, mpm.UGIMP(), fbar=True, water=water)
    scene.groundStress(K0=0.5, bodies=[body])
    scene.dt, scene.damping = 1e-4, 0.5
    scene.run(until=0.3, progress=False)
    x, head = body.position[:, 0], body.porePressure / GAMMA + body.position[:, -1]
    slope = np.polyfit(x[(x > 0.5) & (x < 1.5)], head[(x > 0.5) & (x < 1.5)], 1)[0]
    verified(-slope, 0.5 * drop)
    assert waterOf(scene).outflow == pytest.approx(0.5 * drop * k, rel=2e-3)
    assert waterOf(scene).inflow == pytest.approx(0.5 * drop * k, rel=2e-3)


@pytest.mark.verifies("flow below a sheet pile to half the depth", reference="q/(k h) = 0.5", tolerance=0.04)
def test_water_flows_below_a_sheet_pile(verified):
    """With a wall of one cell, extrapolated from 10 and 20 cells in the depth."""
    found = [seepage(cells) for cells in (10, 20)]
    assert 0.4 < found[0] < found[1] < 0.5
    verified(2 * found[1] - found[0], 0.5)


def seepage(cells, depth=4.0, width=16.0, k=5e-2, drop=1.0):
    h = depth / cells
    scene = mpm.Scene((0, 0), (width, depth + 2 * h), h, gravity=GAMMA, damping=0.3)
    scene.fix("bottom")
    scene.roller("left", "right")
    elastic = mpm.LinearElastic(density=2.0, young=2e4, poisson=0.2)
    wall, middle = box((width / 2, depth / 2), (width / 2 + h, depth)), (width + h) / 2
    table = [(0, depth + drop), (middle - 1e-6, depth + drop), (middle + 1e-6, depth), (width, depth)]
    water = mpm.PoreWater(table=table, permeability=k)
    ground = box((0, 0), (width, depth)) - wall
    soil = scene.add("soil", ground, elastic, mpm.UGIMP(), fbar=True, water=water)
    pile = scene.add("pile", wall, elastic, mpm.UGIMP(), fbar=True)
    scene.groundStress(K0=0.5, bodies=[soil, pile])
    scene.dt = 0.4 * h / sqrt(2.3e4 / 2)
    scene.run(until=2.0, progress=False)
    x, y = soil.position.T
    top = (y > depth - h) & (x > width / 2 + h)
    excess = soil.porePressure[top] - GAMMA * np.maximum(depth - y[top], 0)
    return (excess / GAMMA / (h / 2) * h / 4).sum() / drop  # two rows of boxes, each half a cell wide


def footing(water=None, cells=10, drop=0.02, rate=0.05):
    """Half of a smooth strip of 1 m on soil without weight: c = 10 kPa, phi = 20 degrees, psi = 0; q/su."""
    h, height, c, phi = 1 / cells, 1.5, 10.0, radians(20)
    scene = mpm.Scene((0, 0), (2.5, height + 2 * h), h, damping=0.05)
    scene.fix("bottom")
    scene.roller("left", "right")
    soil = mpm.MohrCoulomb(
        density=2.0, young=2.6e4, poisson=0.3, cohesion=c, frictionAngle=phi, dilatancyAngle=0
    )
    body = scene.add("soil", box((0, 0), (2.5, height)), soil, mpm.UGIMP(), water=water)
    scene.drive(
        box((-1, height - 1e-6), (0.5 + 1e-6, height + 2 * h)),
        velocity=(None, -rate),
        ramp=0.1 * drop / rate,
        name="plate",
    )
    scene.dt = 0.6 * h / sqrt(3.5e4 / 2)
    history = scene.history(every=drop / rate / 40)
    scene.run(until=drop / rate, progress=False)
    load = -np.asarray(history["plate.fy"])[-5:].mean()
    return load / (0.5 + h / 2) / (c * cos(phi)), body


@pytest.mark.verifies("strip footing, undrained", reference="Prandtl: 5.14 c cos phi", tolerance=0.015)
def test_an_undrained_footing_resists_with_the_undrained_strength(verified):
    """c cos phi: the mean effective stress stays where water keeps the volume. Held nodes act half a cell
    wider on each side. Extrapolated from 10 and 20 cells in a metre."""
    found = []
    for cells in (10, 20):
        load, body = footing(mpm.PoreWater(permeability=0.0), cells, drop=0.01)
        found.append(load)
        assert abs(body.volume / body.initialVolume - 1).max() < 5e-4
    assert 4.8 < found[0] < found[1] < 5.14
    verified(2 * found[1] - found[0], 5.14)


@pytest.mark.verifies(
    "strip footing, drained, over its undrained strength",
    reference="Prandtl, with Davis 1968 for no dilatancy",
    tolerance=0.05,
)
def test_a_footing_resists_more_the_slower_it_is(verified):
    """From undrained to drained: the bearing capacity of c* = c cos phi, tan phi* = sin phi."""
    loads = [footing(mpm.PoreWater(permeability=k))[0] for k in (4e-8, 4e-6, 4e-5, 4e-4, 4e-3, 1.0)]
    assert (np.diff(loads) > 0).all()
    tangent = sin(radians(20))
    passive = (sqrt(1 + tangent**2) + tangent) ** 2
    verified(loads[-1], (exp(pi * tangent) * passive - 1) / tangent)
    assert loads[-1] == pytest.approx(footing()[0], rel=0.01)  # soil without water


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("level", [1.0, 1.1, 2.0, 2.6])
def test_ground_with_water_rests(dim, kind, level):
    """A table in the soil, in a cell, at the surface and above it: pressure and soil stay as they are."""
    scene, body = ground(dim, kind, level)
    scene.run(steps=500 if dim == 2 else 50, progress=False)
    exact = GAMMA * np.maximum(level - body.position[:, -1], 0) * (body.saturation > 0)
    assert body.porePressure == pytest.approx(exact, abs=1e-9)
    assert np.abs(body.velocity).max() < 1e-12
    base = np.argmin(body.position[:, -1])
    depth = 2 - body.position[base, -1]
    total = 2 * GAMMA * depth + GAMMA * max(level - 2, 0)
    assert -body.stress[base, -1 if dim == 3 else 1, -1 if dim == 3 else 1] == pytest.approx(
        total - exact[base], rel=0.05
    )


def ground(dim=2, kind="boxes", level=1.1, threads=1, permeability=1e-4):
    h = 0.25
    lower, upper = (0,) * dim, (1.0,) * (dim - 1) + (3.0,)
    scene = mpm.Scene(lower, upper, h, gravity=GAMMA, threads=threads)
    scene.fix("bottom")
    scene.roller("left", "right", *(("front", "back") if dim == 3 else ()))
    sand = mpm.MohrCoulomb(
        density=2.0, young=2e4, poisson=0.3, cohesion=1, frictionAngle=radians(30), dilatancyAngle=0
    )
    water = mpm.PoreWater(table=level, permeability=permeability, tolerance=1e-11)
    soil = box(lower, (1.0,) * (dim - 1) + (2.0,))
    body = scene.add("soil", soil, sand, KINDS[kind](h), water=water)
    scene.groundStress(K0=0.5)
    return scene, body


def test_a_wet_column_that_collapses_keeps_its_volume():
    h = 0.1
    scene = mpm.Scene((0, 0), (4, 1.4), h, gravity=GAMMA)
    scene.fix("bottom")
    scene.roller("left", "right")
    sand = mpm.MohrCoulomb(
        density=2.0, young=2.6e3, poisson=0.3, cohesion=0.5, frictionAngle=radians(30), dilatancyAngle=0
    )
    table = [(0, 1), (0.98, 1), (0.99, 0), (4, 0)]  # no water beside it
    water = mpm.PoreWater(table=table, permeability=1e-6)
    body = scene.add("soil", box((0, 0), (1, 1)), sand, mpm.UGIMP(), water=water)
    scene.groundStress(K0=0.5)
    scene.run(until=0.5, progress=False)
    assert np.quantile(body.position[:, 0], 0.99) > 1.3  # it has run out
    assert body.volume.sum() == pytest.approx(1.0, rel=1e-4)
    change = body.volume / body.initialVolume
    assert change.min() > 0.98 and change.max() < 1.02
