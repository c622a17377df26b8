# SPDX-License-Identifier: GPL-2.0-or-later
"""Axial symmetry against closed forms: cylinders, spheres, footings and shafts.

Lame's thick cylinder, the rotating cylinder, the lowest period of a sphere (Love 1944, art. 196), the limit
load of a circular footing. Controls are in plane strain.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from ringScenes import DENSITY, POISSON, TYPES, YOUNG, both, elastic
from scipy.optimize import brentq


# --- elastic cylinders and spheres -----------------------------------------------------------------------
def settled(scene, time):
    scene.damping = 0.5
    scene.run(until=time, progress=False)


def ofCells(r, values, isIn, cell=0.1):
    """Means of the cells: within one, stress swings as in plane strain."""
    number = np.floor(r / cell).astype(int)
    return np.array([values[isIn & (number == k)].mean() for k in np.unique(number[isIn])])


@both
@pytest.mark.verifies("Axial symmetry: rotating cylinder, stress", reference="closed form", tolerance=0.01)
def test_a_rotating_cylinder_has_its_stress(kind, verified):
    """Plane strain along the axis; omega^2 = 1/s2, R = 1 m: sigma_r = (3 - 2 nu)/(8 (1 - nu)) rho (1 - r^2),
    sigma_theta the same less 2 (1 - 2 nu)/(8 (1 - nu)) rho r^2 ... with the factor (1 + 2 nu) for r^2."""
    scene = mpm.Scene((0, 0), (1.5, 0.2), cell=0.1, axisymmetric=True, threads=1)
    scene.roller("bottom", "top")
    body = scene.add("disc", mpm.box((0, 0), (1.0, 0.2)), elastic(), TYPES[kind](0.1))
    body.bodyForce[:, 0] = body.position[:, 0]
    settled(scene, 1.0)
    r = body.position[:, 0]
    factor = DENSITY / (8 * (1 - POISSON))
    radial = factor * (3 - 2 * POISSON) * (1 - r**2)
    hoop = factor * ((3 - 2 * POISSON) - (1 + 2 * POISSON) * r**2)
    inner = r < 0.8
    scale = factor * (3 - 2 * POISSON)
    verified(ofCells(r, body.stress[:, 0, 0] - radial, inner), 0, scale=scale)
    verified(ofCells(r, body.stress[:, 2, 2] - hoop, inner), 0, scale=scale)


@pytest.mark.parametrize("kind", ["UGIMP", "BSpline"])
@pytest.mark.verifies(
    "Axial symmetry: rotating thick cylinder, stress", reference="closed form", tolerance=0.005
)
def test_a_thick_cylinder_rotates(kind, verified):
    """As above with a hole of the radius a: 1 - r^2 becomes 1 + a^2 - (a/r)^2 - r^2, for sigma_theta 1 gains
    a^2 + (a/r)^2. Control: without a hole the stress round the axis is less."""
    a, h, factor = 0.5, 0.05, DENSITY / (8 * (1 - POISSON))
    scene = mpm.Scene((0, 0), (1.5, 2 * h), cell=h, axisymmetric=True, threads=1)
    scene.roller("bottom", "top")
    body = scene.add("ring", mpm.box((a, 0), (1.0, 2 * h)), elastic(), TYPES[kind](h))
    body.bodyForce[:, 0] = body.position[:, 0]
    settled(scene, 1.0)
    r = body.position[:, 0]
    radial = factor * (3 - 2 * POISSON) * (1 + a**2 - (a / r) ** 2 - r**2)
    whole = factor * ((3 - 2 * POISSON) - (1 + 2 * POISSON) * r**2)
    hoop = whole + factor * (3 - 2 * POISSON) * (a**2 + (a / r) ** 2)
    inner = (r > a + 0.1) & (r < 0.9)
    scale = factor * (3 - 2 * POISSON)
    verified(ofCells(r, body.stress[:, 0, 0] - radial, inner, h), 0, scale=scale)
    verified(ofCells(r, body.stress[:, 2, 2] - hoop, inner, h), 0, scale=scale)
    assert (body.stress[:, 2, 2] - whole)[inner].min() > 0.5 * scale


@pytest.mark.verifies(
    "Axial symmetry: thick cylinder under pressure, stress", reference="Lame", tolerance=0.005
)
def test_a_thick_cylinder_is_lames(verified):
    a, b, p = 0.5, 1.5, 1.0
    scene = mpm.Scene((0, 0), (2.0, 0.1), cell=0.05, axisymmetric=True, threads=1)
    scene.roller("bottom", "top")
    body = scene.add("ring", mpm.box((a, 0), (b, 0.1)), elastic(), mpm.APDI(size=0.025))
    scene.load(body, mpm.box((a - 0.01, -1), (a + 0.01, 1)), pressure=p)
    settled(scene, 1.0)
    r = body.position[:, 0]
    c = p * a**2 / (b**2 - a**2)
    inner = (r > a + 0.1) & (r < b - 0.1)
    verified(ofCells(r, body.stress[:, 0, 0] - c * (1 - b**2 / r**2), inner, 0.05), 0, scale=p)
    verified(ofCells(r, body.stress[:, 2, 2] - c * (1 + b**2 / r**2), inner, 0.05), 0, scale=p)


def test_control_plane_strain_has_another_stress():
    """The rotating cylinder in plane strain between a wall and a free side: sigma = rho (1 - x^2)/2."""
    scene = mpm.Scene((0, 0), (1.5, 0.2), cell=0.1, threads=1)
    scene.roller("bottom", "top", "left")
    body = scene.add("disc", mpm.box((0, 0), (1.0, 0.2)), elastic(), mpm.UGIMP(perCell=2))
    body.bodyForce[:, 0] = body.position[:, 0]
    settled(scene, 1.0)
    x = body.position[:, 0]
    inner = x < 0.8
    assert body.stress[inner, 0, 0] == pytest.approx(DENSITY * (1 - x[inner] ** 2) / 2, abs=0.02 * DENSITY)


def breathing(implicit, isRound=True):
    """Mean displacement of a ring, m, at ten times of nearly a period, from a velocity of 0.01/r."""
    scene = mpm.Scene((0, 0), (2.0, 0.1), cell=0.05, axisymmetric=isRound, threads=1)
    scene.roller("bottom", "top")
    body = scene.add("ring", mpm.box((0.5, 0), (1.5, 0.1)), elastic(), mpm.APDI(size=0.05), implicit=implicit)
    scene.dt = 5e-5
    body.velocity[:, 0] = 0.01 / body.position[:, 0]
    found = []
    for time in 0.02 * np.arange(1, 11):
        scene.run(until=time, progress=False)
        found.append(body.mass @ body.displacement[:, 0] / body.mass.sum())
    return np.array(found)


@pytest.mark.verifies("Axial symmetry: implicit ring that breathes", reference="explicit", tolerance=0.01)
def test_an_implicit_ring_breathes_as_an_explicit_one(verified):
    """Only the stress round the axis holds it: in plane strain it drifts away."""
    explicit = breathing(False)
    assert explicit.min() < -0.9 * explicit.max()
    verified(breathing(True), explicit, scale=explicit.max())
    drifting = breathing(True, isRound=False)
    assert drifting == pytest.approx(drifting[0] * np.arange(1, 11), rel=1e-6)


def breathingSphere(kind, poisson=POISSON):
    """Period of a sphere of one metre in its lowest radial mode, over that of Love at POISSON."""
    lame, shear = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON), YOUNG / 2 / (1 + POISSON)
    fast = (lame + 2 * shear) / (4 * shear)
    k = brentq(lambda x: x / np.tan(x) - 1 + fast * x * x, 1.5, 3.1)
    period = 2 * np.pi / k / np.sqrt((lame + 2 * shear) / DENSITY)
    h = 0.025 if kind == "APDI" else 0.05
    scene = mpm.Scene((0, 0), (1.2, 1.2), cell=h, axisymmetric=True, threads=1)
    scene.roller("bottom")
    half = mpm.disc((0, 0), 1.0) & mpm.box((0, 0), (1.2, 1.2))
    material = mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=poisson)
    body = scene.add("sphere", half, material, TYPES[kind](h))

    def mode():
        r = np.linalg.norm(body.position, axis=1)[:, None]
        return (np.sin(k * r) / (k * r) - np.cos(k * r)) / (k * r) * body.position / r

    body.velocity = 1e-3 * mode()
    times, swings = [], []
    for time in period / 40 * np.arange(1, 121):
        scene.run(until=time, progress=False)
        times.append(scene.time)
        swings.append((body.mass[:, None] * mode() * body.velocity).sum())
    t, q = np.array(times), np.array(swings)
    turns = np.flatnonzero(q[1:] * q[:-1] < 0)
    zeros = t[turns] - q[turns] * (t[turns + 1] - t[turns]) / (q[turns + 1] - q[turns])
    return 2 * np.polyfit(np.arange(len(zeros)), zeros, 1)[0] / period


@both
@pytest.mark.verifies("Axial symmetry: period of a breathing sphere", reference="Love", tolerance=0.005)
def test_a_sphere_breathes_with_its_period(kind, verified):
    verified(breathingSphere(kind), 1)
    assert breathingSphere(kind, poisson=0.2) > 1.01  # control: another material


# --- soil ------------------------------------------------------------------------------------------------
@pytest.mark.filterwarnings("ignore:.*they lock")
@pytest.mark.parametrize(
    "kind, fbar, tolerance", [("UGIMP", False, 1e-5), ("UGIMP", True, 0.03), ("APDI", True, 5e-4)]
)
def test_far_from_the_axis_it_is_plane_strain(kind, fbar, tolerance):
    """Soil that yields and flows, 1e5 m away. F-bar gives a change of volume to three axes, not to two: boxes
    at the foot move otherwise by 2 %, in the mean by 0.2 %, meshes by 0.02 %."""
    moved = []
    for isRound in (True, False):
        left = 1e5 if isRound else 0.0
        scene = mpm.Scene((left, 0), (left + 3, 2), cell=0.125, gravity=10.0, axisymmetric=isRound, threads=1)
        scene.fix("bottom")
        scene.roller("left")
        clay = mpm.Tresca(density=1.8, young=400.0, poisson=0.45, undrainedStrength=3.0)
        soil = scene.add("soil", mpm.box((left, 0), (left + 1, 1)), clay, TYPES[kind](0.125), fbar=fbar)
        scene.dt = 1e-3
        scene.run(until=0.3, progress=False)
        moved.append(soil.byId("displacement"))
    assert np.abs(moved[1]).max() > 0.1
    assert moved[0] == pytest.approx(moved[1], abs=tolerance * np.abs(moved[1]).max())


def footing(isRough, cells=7, su=10.0, shear=1e4, poisson=0.49, depth=0, end=1.05, speed=0.02):
    """Load of a circular footing of one metre over its area and the strength, in the last 0.2 s. It stands
    on the ground of an open hole of that depth, m."""
    h = 1 / (cells + 0.5)  # what holds nodes presses half a cell beyond the last one
    depth = round(depth / h) * h
    wide, deep = np.ceil((4 + depth) / h) * h, np.ceil((3 + depth) / h) * h
    scene = mpm.Scene((0, 0), (wide, deep + 4 * h), h, axisymmetric=True, threads=1, damping=0.5)
    clay = mpm.Tresca(
        density=2.0, lame=(2 * shear * poisson / (1 - 2 * poisson), shear), undrainedStrength=su
    )
    hole = mpm.box((-h, deep - depth), ((cells + 1) * h, deep + h))
    scene.add("soil", mpm.box((0, 0), (wide, deep)) - hole, clay, mpm.APDI(size=h))
    scene.roller("right")
    scene.fix("bottom")
    base = deep - depth
    nodes = mpm.box((-3 * h, base - 0.1 * h), ((cells + 0.1) * h, base + (0.1 if depth else 3) * h))
    across = 0.0 if isRough else None
    press = scene.drive(nodes, velocity=(across, -speed), ramp=0.1, name="footing")
    scene.run(until=end - 0.2, progress=False)
    before = press.impulse[1]
    scene.run(until=end, progress=False)
    return (before - press.impulse[1]) / 0.2 / np.pi / su


@pytest.mark.parametrize("isRough, exact", [(True, 6.05), (False, 5.69)])
@pytest.mark.filterwarnings("ignore:.*is a mesh and flows")
@pytest.mark.verifies("Circular footing on clay, 7 cells: load", reference="Cox et al. 1961", tolerance=0.03)
def test_a_circular_footing_has_its_limit_load(isRough, exact, verified):
    verified(footing(isRough), exact)


@pytest.mark.parametrize("depth, exact, end", [(0.4, 7.14, 0.4), (1, 8.05, 0.6), (2, 9.11, 1.2)])
@pytest.mark.filterwarnings("ignore:.*is a mesh and flows")
@pytest.mark.verifies(
    "Circular footing in a hole in clay, 7 cells: load", reference="limit analysis", tolerance=0.05
)
def test_depth_adds_to_the_load_of_a_circular_footing(depth, exact, end, verified):
    """Rough base, free walls, the depth over the diameter of 0.2, 0.5 and 1, G/su = 10,000.

    Reference: limit analysis by second-order cones, eight-node elements of a/400 beside the edge, which is
    0.4 % too high on the surface. Salgado et al. 2004 fit 7.24, 8.03 and 8.96; Skempton's chart, from tests,
    has 7.1 and 7.7 for 0.5 and 1. Control: in soft clay the hole closes, and the load is lower.
    """
    found = footing(True, depth=depth, shear=1e5, end=end, speed=0.01)
    verified(found, exact)
    if depth == 1:
        assert footing(True, depth=1, end=1.5) < 0.98 * found


@pytest.mark.verifies("Axial symmetry: adhesion on a shaft", reference="2 pi R L a", tolerance=0.05)
def test_adhesion_acts_on_the_whole_shaft(verified):
    scene = mpm.Scene((0, 0), (1.5, 2), cell=0.1, axisymmetric=True, threads=1, damping=0.3)
    scene.fix("bottom", "right")
    soil = scene.add("soil", mpm.box((0.5, 0), (1.5, 1)), elastic(), mpm.APDI(size=0.1))
    soil.stress = np.broadcast_to(np.diag([-5.0, 0, 0]), (soil.count, 3, 3))  # it stays in contact
    pile = scene.add("pile", mpm.box((0, 0.2), (0.5, 1.8)), elastic(), mpm.APDI(size=0.1), implicit=False)
    scene.contact(pile, soil, friction=0.0, adhesion=1.0)
    press = scene.drive(pile, velocity=(0, 0.05), ramp=0.2)
    scene.run(until=0.3, progress=False)
    before = press.impulse[1]
    scene.run(until=0.6, progress=False)
    length = 0.8 - 0.05 * (0.45 - 0.1)  # m, in the middle of that time
    verified((press.impulse[1] - before) / 0.3, 1.0 * np.pi * length)


@pytest.mark.verifies("Axial symmetry: contact force under a weight", reference="weight", tolerance=0.01)
def test_contact_resists_with_the_weight(verified):
    scene = mpm.Scene((0, 0), (1.5, 2), cell=0.1, axisymmetric=True, threads=1, damping=0.5, gravity=10.0)
    scene.fix("bottom")
    scene.roller("right")
    soil = scene.add("soil", mpm.box((0, 0), (1.5, 0.5)), elastic(), mpm.UGIMP(perCell=2))
    disc = scene.add("disc", mpm.box((0, 0.5), (0.6, 0.8)), elastic(), mpm.APDI(size=0.1), implicit=False)
    scene.contact(disc, soil, friction=0.3)
    scene.run(until=2.0, progress=False)
    contact = next(e for e in scene.engines if isinstance(e, mpm.Contact))
    (force,) = contact.forces().values()
    verified(abs(force[1]), 10 * disc.mass.sum())


# --- beside a quarter in space ----------------------------------------------------------------------------
def squeezed(law, speed, isRound, width=1.0):
    """Mean pressure on a cylinder of the height 1 m between rough plates, kPa: a ring, or
    a quarter in space."""
    if isRound:
        scene = mpm.Scene((0, 0), (1.25, 1.5), 0.125, axisymmetric=True, damping=0.3, threads=1)
        shape, top = mpm.box((0, 0), (width, 1)), mpm.box((-1, 0.99), (2, 1.01))
    else:
        scene = mpm.Scene((0, 0, 0), (1.25, 1.25, 1.5), 0.125, damping=0.3, threads=1)
        scene.roller("left", "front")
        shape = mpm.cylinder((0, 0, 0), (0, 0, 1), width) & mpm.box((0, 0, 0), (1, 1, 1))
        top = mpm.box((-1, -1, 0.99), (2, 2, 1.01))
    scene.fix("bottom")
    body = scene.add("body", shape, law, mpm.UGIMP(perCell=2))
    press = scene.drive(top, velocity=(*(0,) * (scene.dim - 1), -speed), ramp=0.1)
    scene.run(until=0.4, progress=False)
    before = press.impulse[scene.dim - 1]
    scene.run(until=0.5, progress=False)
    return (before - press.impulse[scene.dim - 1]) / 0.1 / (body.mass.sum() / DENSITY)


@pytest.mark.parametrize(
    "law, speed",
    [(elastic(), 0.02), (mpm.Tresca(density=DENSITY, young=1e4, poisson=0.49, undrainedStrength=10.0), 0.1)],
)
@pytest.mark.verifies("Axial symmetry: a quarter in space", reference="3D, same cells", tolerance=0.01)
def test_a_ring_resists_as_a_quarter_in_space(law, speed, verified):
    """An elastic cylinder, and one that yields. Control: a slender one resists less."""
    ring = squeezed(law, speed, True)
    verified(squeezed(law, speed, False), ring)
    assert squeezed(law, speed, True, width=0.5) < 0.98 * ring


def quarterFooting(cells, strength=10.0, speed=0.02):
    """Load of a rough circular footing of one metre on a quarter of the ground in space, over the strength
    and the area of the held nodes: each of them holds half a cell round it."""
    h = 1 / cells
    width, depth = 3.0, np.ceil(2 / h) * h
    scene = mpm.Scene((0, 0, 0), (width, width, depth + 3 * h), h, damping=0.5, threads=1)
    clay = mpm.Tresca(density=2.0, lame=(2 * 1e4 * 0.49 / 0.02, 1e4), undrainedStrength=strength)
    scene.add("soil", mpm.box((0, 0, 0), (width, width, depth)), clay, mpm.APDI(size=h))
    scene.roller("left", "right", "front", "back")
    scene.fix("bottom")
    reach = 1 - 0.499 * h
    nodes = mpm.cylinder((0, 0, depth - 0.1 * h), (0, 0, depth + 2 * h), reach)
    press = scene.drive(nodes, velocity=(0, 0, -speed), ramp=0.1)
    at = np.arange(cells + 1) * h
    wide = np.where(at == 0, 0.5, 1.0) * h
    area = (np.outer(wide, wide) * (np.hypot(at[:, None], at) <= reach)).sum()
    scene.run(until=0.85, progress=False)
    before = press.impulse[2]
    scene.run(until=1.05, progress=False)
    return (before - press.impulse[2]) / 0.2 / strength / area


@pytest.mark.filterwarnings("ignore:.*is a mesh and flows")
@pytest.mark.verifies(
    "Circular footing on clay, a quarter in space, 6 cells: load", reference="Cox et al. 1961", tolerance=0.05
)
def test_a_quarter_in_space_resists_as_a_circle(verified):
    """3 to 8 cells per radius: 5.74, 5.67, 5.83, 5.85, 5.92, 5.94. Control: coarse cells carry less."""
    found = quarterFooting(6)
    verified(found, 6.05)
    assert quarterFooting(3) < found
