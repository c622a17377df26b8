# SPDX-License-Identifier: GPL-2.0-or-later
"""Plates of given sections in 3D against closed forms, and against beams in plane strain."""

import numpy as np
import pytest
import yade_mpm as mpm
from scipy.optimize import brentq
from setups import chain
from yade_mpm import box

CELL, LENGTH, EI, EA, WEIGHT = 0.25, 4.0, 2000.0, 4e5, 1.0
STATIC = 10.0  # s, a step so long that each is a solution of statics
ACROSS = 0.01  # m/s2: small deflections
WIDE = 1.0  # m, of strips
LOAD = ACROSS * WEIGHT * WIDE  # kN/m


def strip(thickness=0.5, at=1.5, cell=CELL, gravity=(ACROSS, 0, 0), dt=STATIC, **section):
    """A strip on a fixed base, 4 m high."""
    scene = mpm.Scene((0, 0, 0), (3, 2, 5), cell, threads=1)
    section = {"EI": EI, "EA": EA, "weight": WEIGHT, "thickness": thickness, **section}
    wall = scene.add("wall", mpm.Beam([(at, 0.5, 0), (at, 0.5, LENGTH)], width=(0, WIDE, 0), **section))
    scene.engines = chain(gravity=gravity, fixed="bottom")
    scene.dt = dt
    return scene, wall


def moved(body, where):
    """Mean displacement of the vertices for which where(x, y, z) holds at the start, m."""
    start = np.asarray(body._core.view("vertexReference", True))
    return (body.vertices - start)[where(*start.T)].mean(axis=0)


def tip(body):
    return moved(body, lambda x, y, z: z > LENGTH - 0.01)


@pytest.mark.parametrize(
    "thickness, at, cell",
    [(0.5, 1.5, 0.25), (0.25, 1.5, 0.25), (0.1, 1.4, 0.25), (1.0, 1.45, 0.5), (0, 1.5, 0.25)],
)
@pytest.mark.verifies("Plate: deflection of a strip", reference="beam", tolerance=0.01)
def test_a_strip_bends_as_a_beam_however_thick_its_mesh(thickness, at, cell, verified):
    scene, wall = strip(thickness, at, cell)
    scene.run(steps=12, progress=False)
    verified(tip(wall)[0], LOAD / WIDE * LENGTH**4 / (8 * EI))
    forces = mpm.sectionForces(wall, "z")
    left = LENGTH - forces.s
    assert np.abs(np.abs(forces.M[:, 0]) - LOAD * left**2 / 2).max() < 0.01 * LOAD * LENGTH**2 / 2
    assert np.abs(forces.Q[1:-1, 0] - LOAD * left[1:-1]).max() < 0.01 * LOAD * LENGTH
    inside = np.abs(wall.position[:, 2] - LENGTH / 2) < cell
    assert wall.bendingMoment[inside] == pytest.approx(
        LOAD / WIDE * (LENGTH - wall.position[inside, 2]) ** 2 / 2, rel=0.1
    )
    assert np.abs(wall.hoopMoment).max() < 1e-6 * LOAD * LENGTH**2


def test_a_strip_is_the_beam_of_plane_strain():
    scene, wall = strip(0.75, gravity=(ACROSS, 0, -3 * ACROSS), dt=0.05)
    plane = mpm.Scene((0, 0), (3, 5), CELL, threads=1)
    section = dict(EI=EI, EA=EA, weight=WEIGHT, thickness=0.75)
    beam = plane.add("wall", mpm.Beam([(1.5, 0), (1.5, LENGTH)], **section))
    plane.engines, plane.dt = chain(gravity=(ACROSS, -3 * ACROSS), fixed="bottom"), 0.05
    for made in (scene, plane):
        made.run(steps=40, progress=False)
    swung = moved(beam, lambda x, y: y > LENGTH - 0.01)
    assert abs(swung[0]) > 1e-5
    assert np.abs(tip(wall)[[0, 2]] - swung).max() < 1e-4 * np.abs(swung).max()


@pytest.mark.parametrize("part", [0.3, 0.6])
@pytest.mark.verifies("Plate: buckling load of a strip", reference="Euler", tolerance=0.02)
def test_a_strip_buckles_under_the_load_of_euler(part, verified):
    """Under a part of it the deflection by a force across the top grows by 3 (tan u - u)/u^3."""
    euler = np.pi**2 * EI / (2 * LENGTH) ** 2
    found = []
    for down in (0.0, part * euler):
        scene, wall = strip(cell=0.5, gravity=(0, 0, 0), EA=1e8)
        push = np.array([0.01, 0, -down]) / 0.5
        top = mpm.BoundaryLoad(wall, box((0, 0, LENGTH - 0.01), (3, 2, LENGTH + 0.01)), traction=push)
        scene.engines = [scene.engines[0], top, *scene.engines[1:]]
        scene.run(steps=60, progress=False)
        found.append(tip(wall)[0])
    grown = found[1] / found[0]
    u = brentq(lambda u: 3 * (np.tan(u) - u) / u**3 - grown, 1e-3, np.pi / 2 - 1e-6)  # sqrt(P/EI) L
    verified(part * euler * (np.pi / 2 / u) ** 2, euler)


@pytest.mark.verifies("Plate: strip on elastic ground", reference="Hetenyi 1946", tolerance=0.03)
def test_a_strip_on_springs_bends_as_hetenyi_says(verified):
    k, q, EI = 50.0, 1.0, 50.0  # kPa per m of deflection, kN/m, kN m2/m
    beta = (k / (4 * EI)) ** 0.25
    scene = mpm.Scene((0, 0, 0), (12, 1.5, 3), 0.5, threads=1)
    line = [(0.5, 0.5, 2), (11.5, 0.5, 2)]
    section = dict(EI=EI, EA=1e5, weight=WEIGHT, thickness=0.5)
    plate = scene.add("plate", mpm.Beam(line, width=(0, 0.5, 0), **section))
    springs = [
        mpm.Spring(plate, at=(x, 0.75, 2), to=(x, 0.75, 0.5), stiffness=k * 0.5 * 0.25, width=0.5)
        for x in np.unique(plate.position[:, 0].round(9))
    ]
    grown = 20.0  # s, of many periods, so that it does not swing
    push = mpm.Force(
        plate,
        (6, 0.75, 2),
        lambda t: (0, 0, -0.5 * q * np.sin(np.pi / 2 * t / grown) ** 2),
        np.linspace(0, grown, 50),
    )
    scene.engines = chain(*springs, push)
    scene.dt = 0.05
    scene.run(steps=400, progress=False)
    verified(-moved(plate, lambda x, y, z: np.abs(x - 6) < 0.1)[2], q * beta / (2 * k))


@pytest.mark.verifies("Plate: load at a plastic hinge", reference="beam", tolerance=0.02)
def test_a_strip_turns_under_the_limit_of_its_moment(verified):
    """Curvature is plastic a fifth of an element away from the base, so that the arm is 1.3 % too short."""
    limit = 2.0
    for strength, isPlastic in ((limit, True), (None, False)):
        scene, wall = strip(0.25, limitMoment=strength, dt=0.05)
        top = box((0, 0, LENGTH - 0.01), (3, 2, LENGTH + 0.01))
        push = mpm.Hold(top, velocity=(0.01, None, None), name="top")
        scene.engines = chain(fixed="bottom", hold=[push])
        scene.run(until=2.0, progress=False)
        push.velocity = (0.0, None, None)  # a hinge that turns is viscous
        scene.run(steps=40, progress=False)
        elastic = 3 * EI / LENGTH**3 * 0.02 * WIDE
        if isPlastic:
            verified(push.reaction[0], limit * WIDE / LENGTH)
            assert np.abs(wall.bendingMoment).max() == pytest.approx(limit, rel=1e-9)
            assert elastic > 3 * limit * WIDE / LENGTH
        else:
            assert push.reaction[0] == pytest.approx(elastic, rel=0.02)  # control


# ---- squares ----------------------------------------------------------------------------------
SIDE, PRESSURE, STIFF = 2.0, 1e-3, 100.0


def square(n, supports=(None, None, 0), pressed=False, dt=STATIC, pressure=PRESSURE, steps=8, **section):
    """A square plate in cells of an n-th of its side, whose edges are supported, after some steps."""
    cell = SIDE / n
    scene = mpm.Scene((0, 0, 0), (SIDE + 2 * cell, SIDE + 2 * cell, 4 * cell), cell, threads=1)
    line = [(cell, cell, 2 * cell), (cell + SIDE, cell, 2 * cell)]
    section = {"EI": STIFF, "EA": 1e5, "weight": 1.0, "thickness": 0.5 * cell, **section}
    plate = scene.add("plate", mpm.Beam(line, width=(0, SIDE, 0), **section))
    inner, outer, top = np.array([1, 1 + n]) * cell + (1e-6, -1e-6), SIDE + 2 * cell, 4 * cell
    edges = {
        "left": box((0, 0, 0), (inner[0], outer, top)),
        "right": box((inner[1], 0, 0), (outer, outer, top)),
        "front": box((inner[0], 0, 0), (inner[1], inner[0], top)),
        "back": box((inner[0], inner[1], 0), (inner[1], outer, top)),
    }
    holds = [mpm.Hold(region, velocity=supports, name=name) for name, region in edges.items()]
    above = box((0, 0, 2 * cell + 1e-6), (outer, outer, top))
    load = [mpm.BoundaryLoad(plate, above, pressure=pressure)] if pressed else []
    scene.engines = chain(*load, gravity=(0, 0, 0 if pressed else -pressure), hold=holds)
    scene.dt = dt
    scene.run(steps=steps, progress=False)
    middle = cell + SIDE / 2
    sag = -moved(plate, lambda x, y, z: np.hypot(x - middle, y - middle) < 0.01 * cell)[2]
    away = np.linalg.norm(plate.position[:, :2] - middle, axis=1)
    return scene, plate, sag, away < 1.01 * away.min()


def navier(value, across=1.0):
    """At the middle of a supported square of side 1, EI = 1, q = 1; value(m, n): of a term over that of w;
    across: stiffness along the width."""
    terms = [
        value(m, n)
        * np.sin(m * np.pi / 2)
        * np.sin(n * np.pi / 2)
        / (m * n * (m * m + across**0.5 * n * n) ** 2)
        for m in range(1, 99, 2)
        for n in range(1, 99, 2)
    ]
    return 16 / np.pi**6 * sum(terms)


DEFLECTION = navier(lambda m, n: 1)  # 0.00406
MOMENT = navier(lambda m, n: (np.pi * m) ** 2)  # 0.0368, without Poisson's ratio


@pytest.mark.parametrize("pressed", [False, True])
@pytest.mark.verifies("Plate: supported square", reference="Timoshenko & Woinowsky-Krieger", tolerance=0.03)
def test_a_supported_square_bends_as_navier_says(pressed, verified):
    assert pytest.approx(0.00406, abs=5e-6) == DEFLECTION
    errors = []
    for n in (4, 8):
        _, plate, sag, nearMiddle = square(n, pressed=pressed)
        errors.append(abs(sag / (DEFLECTION * PRESSURE * SIDE**4 / STIFF) - 1))
    verified(sag, DEFLECTION * PRESSURE * SIDE**4 / STIFF)
    for moment in (plate.bendingMoment, plate.hoopMoment):
        verified(np.abs(moment[nearMiddle]).mean(), MOMENT * PRESSURE * SIDE**2)
    assert errors[1] < 0.7 * errors[0]


CLAMPED = 0.00126532  # deflection; moments at the middle (1 + nu) 0.01762, at the middle of an edge 0.0513


@pytest.mark.verifies("Plate: clamped square", reference="Timoshenko & Woinowsky-Krieger", tolerance=0.06)
def test_a_clamped_square_sags_less(verified):
    errors = [square(n, supports=(0, 0, 0))[2] for n in (4, 8)]
    exact = CLAMPED * PRESSURE * SIDE**4 / STIFF
    verified(errors[1], exact)
    assert abs(errors[1] / exact - 1) < 0.4 * abs(errors[0] / exact - 1)


@pytest.mark.verifies(
    "Plate: Poisson's ratio, 16 x 16", reference="Timoshenko & Woinowsky-Krieger", tolerance=0.02
)
@pytest.mark.parametrize("supports", [(None, None, 0), (0, 0, 0)])
def test_squares_with_poissons_ratio_bend_as_by_timoshenko(supports, verified):
    """EI is that of a strip whose sides are free; D = EI/(1 - nu^2)."""
    nu = 0.3
    sag, moment = (DEFLECTION, MOMENT) if supports[0] is None else (CLAMPED, 0.0231 / (1 + nu))
    _, plate, found, nearMiddle = square(16, supports=supports, poisson=nu)
    verified(found, sag * PRESSURE * SIDE**4 / STIFF * (1 - nu**2))
    for its in (plate.bendingMoment, plate.hoopMoment):
        verified(np.abs(its[nearMiddle]).mean(), (1 + nu) * moment * PRESSURE * SIDE**2)


@pytest.mark.verifies("Plate: EI of two directions", reference="Navier, Huber", tolerance=0.02)
@pytest.mark.parametrize("part", [0.25, 0.04])
def test_a_square_of_two_stiffnesses_bends_as_by_navier_and_huber(part, verified):
    _, plate, sag, nearMiddle = square(12, EIWidth=part * STIFF)
    verified(sag, navier(lambda m, n: 1, part) * PRESSURE * SIDE**4 / STIFF)
    moment = navier(lambda m, n: (np.pi * m) ** 2, part) * PRESSURE * SIDE**2
    verified(np.abs(plate.bendingMoment[nearMiddle]).mean(), moment)


@pytest.mark.parametrize("isHeld, softer", [(False, 0.0), (True, 0.3**2)])
def test_a_strip_feels_poissons_ratio_where_its_sides_cannot_turn(isHeld, softer):
    """With rollers on its sides EI/(1 - nu^2) counts; else EI does, but for the clamped base."""
    found = []
    for nu in (0.0, 0.3):
        scene = mpm.Scene((0, 0, 0), (3, 1, 5), CELL, threads=1)
        section = dict(EI=EI, EA=EA, weight=WEIGHT, thickness=0.5, poisson=nu)
        wall = scene.add("wall", mpm.Beam([(1.5, 0, 0), (1.5, 0, LENGTH)], width=(0, WIDE, 0), **section))
        sides = {"roller": ("front", "back")} if isHeld else {}
        scene.engines, scene.dt = chain(gravity=(ACROSS, 0, 0), fixed="bottom", **sides), STATIC
        scene.run(steps=12, progress=False)
        found.append(tip(wall)[0])
    assert found[1] / found[0] == pytest.approx(1 - softer, abs=1e-4 if isHeld else 0.03)


def principalMoment(plate):
    """The largest one of each domain, kN m/m."""
    mean, half = ((plate.bendingMoment + sign * plate.hoopMoment) / 2 for sign in (1, -1))
    return np.abs(mean) + np.hypot(half, plate.twistingMoment)


@pytest.mark.parametrize("n, above", [(4, 0.21), (8, 0.1)])
def test_a_square_gives_way_along_yield_lines(n, above):
    """Under 24 m/a2 (Johansen): it stands below, and moves above, the nearer the finer."""
    limit = 1.0
    collapse = 24 * limit / SIDE**2
    rate = {}
    for part in (0.99, 1 + above):
        scene, plate, sag, _ = square(n, dt=0.02, pressure=part * collapse, steps=60, limitMoment=limit)
        assert principalMoment(plate).max() < limit * (1 + 1e-9)
        start = plate.vertices[:, 2].min()
        scene.run(steps=4, progress=False)
        rate[part] = (start - plate.vertices[:, 2].min()) / (4 * scene.dt) / sag  # 1/s
    assert abs(rate[0.99]) < 1e-3 < 0.05 < rate[1 + above]
