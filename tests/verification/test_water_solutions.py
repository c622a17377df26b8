# SPDX-License-Identifier: GPL-2.0-or-later
"""Pore water against solutions: Mandel's plate, mud that settles, a wave, sand that liquefies."""

from math import radians, sqrt

import numpy as np
import pytest
import scipy.optimize
import yade_mpm as mpm
from yade_mpm import box

GAMMA = 9.81  # kN/m3, water
KINDS = {"boxes": lambda h: mpm.UGIMP(), "mesh": lambda h: mpm.APDI(size=h / 2)}
everyKind = pytest.mark.parametrize("kind", KINDS)


def elastic(modulus, poisson):
    """Of an oedometer modulus, kPa."""
    young = modulus * (1 + poisson) * (1 - 2 * poisson) / (1 - poisson)
    return mpm.LinearElastic(density=2.0, young=young, poisson=poisson)


def press(scene, region, load, axis, mass, damping, speed=lambda time: 0.0):
    """A smooth rigid plate, Mg/m, that a force load(time), kN/m, presses on. What differs from speed(time),
    m/s, is damped, kN s/m2."""
    state = {"velocity": 0.0}

    def velocity(time):
        if scene.steps:
            force = load(time) - state["plate"].reaction[axis]
            state["velocity"] += scene.dt / mass * (force - damping * (state["velocity"] - speed(time)))
        return [state["velocity"] if k == axis else None for k in range(2)]

    state["plate"] = scene.drive(region, velocity=velocity, name="plate")


# --- Mandel's plate ---------------------------------------------------------------------------------
HALF, HEIGHT, MODULUS, POISSON, COEFFICIENT = 1.0, 0.5, 1e4, 0.2, 1 / 3  # m, m, kPa, -, m2/s


def mandel(T, x, count=40):
    """Pressure over force over width, at x over the half width and T = c t/a2, for water and grains that keep
    their volume: Cheng & Detournay 1988, Int. J. Numer. Anal. Methods Geomech. 12, 551-572."""
    ratio = (1 - POISSON) / (0.5 - POISSON)
    ends = [((i + 1e-3) * np.pi, (i + 0.5) * np.pi) for i in range(count)]
    a = np.array([scipy.optimize.brentq(lambda a: np.sin(a) - ratio * a * np.cos(a), *end) for end in ends])
    modes = np.sin(a) / (a - np.sin(a) * np.cos(a)) * np.exp(-(a**2) * T)
    return (modes * (np.cos(a * x) - np.cos(a))).sum()


def sample(kinds, ramp, cells=10):
    """A quarter of the sample, of parts side by side. A plate presses on it, water leaves at the right."""
    h, width = HALF / cells, HALF / len(kinds)
    scene = mpm.Scene((0, 0), (HALF + 2 * h, HEIGHT + 2 * h), h)
    scene.roller("left", "bottom")
    for n, kind in enumerate(kinds):
        water = mpm.PoreWater(permeability=COEFFICIENT * GAMMA / MODULUS, tolerance=1e-4)
        part, law = box((n * width, 0), ((n + 1) * width, HEIGHT)), elastic(MODULUS, POISSON)
        scene.add(f"soil {n}", part, law, KINDS[kind](h), fbar=True, water=water)
    scene.dt = 0.3 * h / sqrt(MODULUS / 2)
    top = box((-h, HEIGHT - 1e-6), (2 * HALF, 2 * HEIGHT))
    press(scene, top, lambda time: -min(time / ramp, 1.0), 1, mass=2.0, damping=150.0)
    return scene, h


@pytest.mark.verifies(
    "pressure in the middle below a rigid plate",
    reference="Mandel, in Cheng & Detournay 1988",
    tolerance=0.01,
)
@pytest.mark.parametrize("kinds", [("boxes",), ("mesh",), ("mesh", "boxes")], ids="-".join)
def test_pressure_in_the_middle_below_a_plate_rises_as_mandel_says(kinds, verified):
    """By a tenth, while water leaves at the sides: what gives way there presses on the middle."""
    scene, h = sample(kinds, ramp=0.05)
    body, found = scene.bodies[0], []
    for T in (0.05, 0.1, 0.4):
        scene.run(until=T * HALF**2 / COEFFICIENT + 0.025, progress=False)
        found.append(body.porePressure[body.position[:, 0] < h].mean())
        verified(found[-1], np.mean([mandel(T, x * h / HALF) for x in (0.25, 0.75)]))
    assert found[1] > 1.08 * 0.5  # of the pressure at the start, that of a load without consolidation


# --- mud under its own weight -----------------------------------------------------------------------
DEPTH, SOFT = 2.0, 30.0  # m, kPa


def settled(time, permeability, porosity=None, count=50):
    """Settlement of mud, m, and excess at its base, kPa, for the stress M ln(J)/J of Hencky's law.

    In coordinates X of the material dJ/dt = d/dX (k/(gamma J) du/dX): Gibson, England & Hussey 1967,
    Geotechnique 17, 261-273.
    """
    step, J = DEPTH / count, np.ones(count)
    above, kOverGamma = DEPTH - (np.arange(count) + 0.5) * step, permeability / GAMMA
    steps = int(np.ceil(time / (0.1 * step**2 / (kOverGamma * SOFT))))
    for _ in range(steps):
        u, c = SOFT * np.log(J) / J + GAMMA * above, kOverGamma / J
        if porosity:  # Kozeny & Carman
            n = 1 - (1 - porosity) / J
            c *= n**3 / (1 - n) ** 2 / (porosity**3 / (1 - porosity) ** 2)
        flow = 0.5 * (c[1:] + c[:-1]) * np.diff(u) / step
        J += time / steps * np.diff(np.r_[0.0, flow, -c[-1] * u[-1] / (step / 2)]) / step
    return (1 - J).sum() * step, u[0]


def mud(kind, permeability, cells=20, **options):
    """Mud of twice the density of water, under water, that rests on all of its water at the start."""
    h = DEPTH / cells
    scene = mpm.Scene((0, 0), (2 * h, DEPTH + 2 * h), h, gravity=GAMMA)
    scene.roller("left", "right", "bottom")
    water = mpm.PoreWater(table=DEPTH + 0.5, permeability=permeability, **options)
    body = scene.add(
        "mud", box((0, 0), (2 * h, DEPTH)), elastic(SOFT, 0.3), KINDS[kind](h), fbar=True, water=water
    )
    scene.dt = 0.5 * h / sqrt(SOFT / 2)
    return scene, body, water


@pytest.mark.verifies(
    "settlement of mud by 5 and 13 % of its depth",
    reference="Gibson, England & Hussey 1967, finite differences",
    tolerance=0.015,
)
@pytest.mark.filterwarnings("ignore:body 'mud'. its own weight")
@everyKind
def test_mud_settles_under_its_weight(kind, verified):
    scene, body, water = mud(kind, permeability=1e-2)
    lowest = np.argmin(body.position[:, 1])
    for time in (10, 30):
        scene.run(until=time, progress=False)
        exact, excess = settled(scene.time, 1e-2)
        verified((1 - body.volume / body.initialVolume).mean() * DEPTH, exact)
        verified(water.excess(body)[lowest], excess)
    assert settled(30, 1.2e-2)[0] > 1.1 * exact  # with a fifth more of permeability


@pytest.mark.verifies(
    "settlement of mud whose permeability falls with its pores",
    reference="Gibson, England & Hussey 1967, with Kozeny & Carman",
    tolerance=0.02,
)
@pytest.mark.filterwarnings("ignore:body 'mud'. its own weight")
def test_mud_that_lets_less_water_through_the_denser_it_is_settles_more_slowly(verified):
    scene, body, _ = mud("boxes", permeability=1e-2, porosity=0.6, kozenyCarman=True)
    scene.run(until=30, progress=False)
    exact = settled(scene.time, 1e-2, porosity=0.6)[0]
    verified((1 - body.volume / body.initialVolume).mean() * DEPTH, exact)
    assert exact < 0.95 * settled(scene.time, 1e-2)[0]


# --- a wave -----------------------------------------------------------------------------------------
@pytest.mark.verifies(
    "speed of a wave that water and soil make together",
    reference="Biot 1956: sqrt((K_w/n + M)/rho)",
    tolerance=0.015,
)
@everyKind
def test_a_wave_goes_as_fast_as_water_and_soil_together(kind, verified):
    """Water and grains move as one, Biot's wave of low frequency (1956, J. Acoust. Soc. Am. 28, 168-178). Its
    front passes a cell in five steps, and its pressure doubles at a closed end."""
    height, cells, modulus, load, n = 4.0, 40, 1e5, 100.0, 0.4
    h, stiffness = height / cells, 2.2e6 / n + modulus
    speed = sqrt(stiffness / 2.0)
    scene = mpm.Scene((0, 0), (2 * h, height + 2 * h), h)
    scene.roller("left", "right", "bottom")
    water = mpm.PoreWater(permeability=1e-6, porosity=n, tolerance=1e-4)
    body = scene.add(
        "soil", box((0, 0), (2 * h, height)), elastic(modulus, 0.3), KINDS[kind](h), fbar=True, water=water
    )
    scene.attach(mpm.SurfaceLoad(body, (0, 2 * h), pressure=load))
    scene.dt = 0.2 * h / speed
    y, behind = body.position[:, 1].copy(), load / (2.0 * speed)
    at = [np.argmin(abs(y - height * part)) for part in (0.25, 0.5, 0.75)]
    arrival = np.full(3, np.nan)
    while scene.time < 0.95 * height / speed:
        scene.run(steps=1, progress=False)
        arrival[np.isnan(arrival) & (body.velocity[at, 1] < -behind / 2)] = scene.time
    verified(-np.polyfit(arrival, y[at], 1)[0], speed)
    verified(-body.velocity[at[1], 1], behind)
    scene.run(until=1.6 * height / speed, progress=False)
    verified(body.porePressure[np.argmin(y)], 2 * load * (2.2e6 / n) / stiffness)
    assert sqrt(modulus / 2.0) < 0.2 * speed  # that of the soil without its water


# --- sand that keeps its volume ----------------------------------------------------------------------
SAND = dict(
    density=2.0,
    shearModulus=2e4,
    frictionAngle=radians(31),
    criticalVoidRatio=0.75,
    compression=0.02,
    dilatancy=4.0,
)


def keptVolume(sand, pressure, strain):
    """Stress of a point that is squeezed and keeps its volume, kPa."""
    point, step = mpm.MaterialPoint(sand, -pressure * np.eye(3)), -np.log(1 - strain) / 1000
    for _ in range(1000):
        point.strain(np.diag([step, -step, 0.0]))
    return point.stress


@pytest.mark.verifies(
    "dense sand that nothing but its suction holds, squeezed",
    reference="NorSand at constant volume",
    tolerance=0.02,
)
@pytest.mark.filterwarnings("ignore")
@everyKind
def test_pore_pressure_and_effective_stress_balance_at_a_free_surface(kind, verified):
    """The total stress is zero there: both act on the same nodes. A sample of 50 kPa bulges by 3 %."""
    strain, rate, h = 0.03, 0.02, 0.25
    scene, sand = mpm.Scene((0, 0), (1.5, 1.5), h, damping=0.05), mpm.NorSand(**SAND, stateParameter=-0.1)
    scene.roller("left", "bottom")
    water = mpm.PoreWater(permeability=0.0, tolerance=1e-3)
    body = scene.add("sand", box((0, 0), (1, 1)), sand, KINDS[kind](h), water=water)
    body.setStress(-50 * np.eye(3))
    body.porePressure[:] = -50
    scene.drive(box((-h, 1 - 1e-6), (2, 2)), velocity=(None, -rate), ramp=0.05)
    scene.run(until=0.025 + strain / rate, progress=False)
    exact, found = keptVolume(sand, 50, strain), body.stress.mean(axis=0)
    verified(np.trace(found), np.trace(exact))
    verified(found[0, 0] - found[1, 1], exact[0, 0] - exact[1, 1])
    verified(body.porePressure.mean(), exact[0, 0])
    assert body.volume.sum() == pytest.approx(1.0, rel=1e-4)


def squeezed(kind, state, strain=0.02, pressure=50.0, water=50.0, rate=0.02, cells=4):
    """Undrained sand between plates in plane strain: one goes down, a constant total stress holds the other.

    Returns the ends (effective pressure, excess) of the sample and of a point that keeps its volume, kPa.
    """
    h, sand = 1 / cells, mpm.NorSand(**SAND, stateParameter=state)
    scene = mpm.Scene((0, 0), (1 + 2 * h, 1 + 2 * h), h)
    scene.roller("left", "bottom")
    given = mpm.PoreWater(permeability=0.0, tolerance=1e-3)
    body = scene.add("sand", box((0, 0), (1, 1)), sand, KINDS[kind](h), water=given)
    body.setStress(-pressure * np.eye(3))
    body.porePressure[:] = water
    scene.dt = 1e-3
    for j in range(1, cells + 2):  # every row, for sand that softens would fail in one
        row = box((-h, j * h - 1e-6), (2, j * h + 1e-6))
        scene.drive(row, velocity=(None, -rate * j * h), ramp=0.05, name=f"row {j}")
    side = box((1 - 1e-6, -h), (2, 2))

    def load(time):  # on the height that is left
        return -(pressure + water) * (1 - rate * max(time - 0.025, 0.0))

    press(scene, side, load, 0, mass=20.0, damping=3000.0, speed=lambda time: rate * min(time / 0.05, 1.0))
    scene.run(until=0.025 + strain / rate, progress=False)
    point, mean = keptVolume(sand, pressure, strain), -np.trace(body.stress, axis1=1, axis2=2).mean() / 3
    exact = -np.trace(point) / 3, pressure + point[0, 0]
    return (mean, body.porePressure.mean() - water), exact


@pytest.mark.verifies(
    "pressure of loose sand that liquefies, over that at the start",
    reference="NorSand at constant volume",
    tolerance=0.03,
)
@pytest.mark.filterwarnings("ignore")
@everyKind
def test_loose_sand_liquefies_and_dense_sand_does_not(kind, verified):
    """Its pressure goes over to the water: what a point of the law does that keeps its volume."""
    (loose, excess), exact = squeezed(kind, state=0.08)
    verified([loose / 50, excess / 50], np.divide(exact, 50), scale=1.0)
    assert loose < 0.1 * 50 < 0.9 * 50 < excess
    (dense, excess), exact = squeezed(kind, state=-0.1)
    verified([dense / 50, excess / 50], np.divide(exact, 50), scale=1.0)
    assert dense > 0.8 * 50
