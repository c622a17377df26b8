# SPDX-License-Identifier: GPL-2.0-or-later
"""Beams of given sections against closed forms; they do not know how thick their mesh is."""

import numpy as np
import pytest
import yade_mpm as mpm
from scipy.optimize import brentq
from setups import chain
from yade_mpm import box

CELL, LENGTH, EI, EA, WEIGHT = 0.25, 4.0, 2000.0, 4e5, 1.0
STATIC = 10.0  # s, a step so long that each is a solution of statics
ACROSS = 0.01  # m/s2: small deflections
LOAD = ACROSS * WEIGHT  # kN/m per metre


def upright(thickness=0.5, at=1.5, cell=CELL, gravity=(ACROSS, 0.0), threads=1, dt=STATIC, **section):
    """A beam on a fixed base, 4 m high."""
    scene = mpm.Scene((0, 0), (3, 5), cell, threads=threads)
    section = {"EI": EI, "EA": EA, "weight": WEIGHT, "thickness": thickness, **section}
    wall = scene.add("wall", mpm.Beam([(at, 0), (at, LENGTH)], **section))
    scene.engines = chain(gravity=gravity, fixed="bottom")
    scene.dt = dt
    return scene, wall


def solved(scene, steps=12):
    scene.run(steps=steps, progress=False)
    return mpm.sectionForces(scene.bodies[0])


def errors(found, exact):
    """Over the largest of the exact values."""
    return np.abs(found - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize(
    "thickness, at, cell",
    [(0.5, 1.5, 0.25), (0.25, 1.5, 0.25), (0.1, 1.4, 0.25), (1.0, 1.45, 0.5), (0, 1.5, 0.25), (0, 1.4, 0.5)],
)
@pytest.mark.verifies("Beam: deflection of a cantilever", reference="beam", tolerance=0.01)
def test_a_cantilever_bends_as_its_section_however_thick_its_mesh(thickness, at, cell, verified):
    scene, wall = upright(thickness, at, cell, gravity=(ACROSS, -3 * ACROSS))
    forces = solved(scene)
    left = LENGTH - forces.s
    verified(forces.displacement[-1, 0], LOAD * LENGTH**4 / (8 * EI))
    verified(forces.displacement[-1, 1], -3 * LOAD * LENGTH**2 / (2 * EA))
    assert errors(forces.M, LOAD * left**2 / 2) < 0.02 and errors(forces.Q[1:-1], LOAD * left[1:-1]) < 0.01
    assert errors(forces.N[1:-1], -3 * LOAD * left[1:-1]) < 0.01


def test_control_one_domain_across_of_a_solid_of_the_same_stiffness_does_not():
    scene = mpm.Scene((0, 0), (3, 5), CELL, threads=1)
    solid = mpm.LinearElastic(density=WEIGHT / 0.5, young=12 * EI / 0.5**3, poisson=0)
    wall = scene.add("wall", box((1, 0), (1.5, LENGTH)), solid, mpm.APDI(size=0.5), implicit=True)
    scene.engines = chain(gravity=(ACROSS, 0), fixed="bottom")
    scene.dt = STATIC
    forces = solved(scene)
    assert abs(forces.displacement[-1, 0] / (LOAD * LENGTH**4 / (8 * EI)) - 1) > 0.2
    assert len(wall.position) == 8


def heldAtTop(velocity, gravity=(0, 0), **section):
    """A beam whose nodes at the top are held across: it may turn there."""
    scene, wall = upright(**section)
    hold = mpm.Hold(box((0, LENGTH - 0.01), (3, LENGTH + 0.01)), velocity=(velocity, None), name="top")
    scene.engines = chain(gravity=gravity, fixed="bottom", hold=[hold])
    return scene, wall, hold


@pytest.mark.verifies("Beam: force of a prop", reference="beam", tolerance=0.02)
def test_a_propped_beam_has_three_eighths_of_its_load_on_the_prop(verified):
    scene, _, hold = heldAtTop(0.0, gravity=(ACROSS, 0))
    forces = solved(scene)
    verified(hold.reaction[0], -3 / 8 * LOAD * LENGTH)
    verified(forces.M[0], LOAD * LENGTH**2 / 8)
    verified(forces.M.min(), -9 / 128 * LOAD * LENGTH**2)


@pytest.mark.parametrize("isSolid", [False, True])
def test_the_peak_at_a_point_force_is_lower_by_an_eighth_of_force_times_cell(isSolid):
    """The force acts on the nodes of the cells round it; with four cells in the span that is 12.5 %."""
    scene, span, F = mpm.Scene((0, 0), (3, 2), CELL, threads=1), 4 * CELL, 1.0
    solid = mpm.LinearElastic(density=WEIGHT / 0.5, young=12 * EI / 0.5**3, poisson=0)
    beam = mpm.Beam([(1, 1), (1 + span, 1)], EI=EI, EA=EA, weight=WEIGHT, thickness=0.5)
    if isSolid:
        body = scene.add("beam", beam.region, solid, mpm.APDI(size=0.125), implicit=True)
    else:
        body = scene.add("beam", beam)
    ends = [
        mpm.Hold(box((x - 0.01, 0.7), (x + 0.01, 1.3)), velocity=(None, 0), name=f"at {x}")
        for x in (1, 1 + span)
    ]
    scene.engines = chain(mpm.Force(body, (1 + span / 2, 1), (0, -F)), hold=ends)
    scene.dt = 1.0
    forces = solved(scene, 40)
    assert np.abs(forces.M).max() == pytest.approx(F * span / 4 - F * CELL / 8, rel=0.005)


@pytest.mark.parametrize("part", [0.3, 0.6])
@pytest.mark.verifies("Beam: buckling load", reference="Euler", tolerance=0.02)
def test_a_column_buckles_under_the_load_of_euler(part, verified):
    """Under a part of it the deflection by a force across the top grows by 3 (tan u - u)/u^3."""
    euler = np.pi**2 * EI / (2 * LENGTH) ** 2
    moved = []
    for down in (0.0, part * euler):
        scene, wall = upright(gravity=(0, 0), EA=1e9)
        push = np.array([0.01, -down])
        top = mpm.BoundaryLoad(wall, box((0, LENGTH - 0.01), (3, LENGTH + 0.01)), traction=push / 0.5)
        scene.engines = [scene.engines[0], top, *scene.engines[1:]]
        moved.append(solved(scene, 80).displacement[-1, 0])
    grown = moved[1] / moved[0]
    u = brentq(lambda u: 3 * (np.tan(u) - u) / u**3 - grown, 1e-3, np.pi / 2 - 1e-6)  # sqrt(P/EI) L
    verified(part * euler * (np.pi / 2 / u) ** 2, euler)


def ring(n=44, cell=0.25, EI=20.0, EA=2e4, thickness=0.25):
    """A ring of radius 2 m that floats."""
    angle = np.linspace(0, 2 * np.pi, n + 1)
    line = 3 + 2 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    line[-1] = line[0]
    scene = mpm.Scene((0, 0), (6, 6), cell, threads=1)
    lining = scene.add("lining", mpm.Beam(line, EI=EI, EA=EA, weight=WEIGHT, thickness=thickness))
    scene.engines = chain()
    scene.dt = 0.1
    return scene, lining


@pytest.mark.verifies("Beam: ring under pressure", reference="thin ring", tolerance=0.02)
def test_a_ring_under_pressure_gives_way_as_a_boiler(verified):
    scene, lining = ring()
    pressure = 2.0  # it buckles at 3 EI/R^3 = 7.5
    outside = mpm.everywhere(2) - mpm.disc((3, 3), 2.0)
    load = mpm.BoundaryLoad(lining, outside, pressure=pressure)
    scene.engines = [scene.engines[0], load, *scene.engines[1:]]
    forces = solved(scene, 100)
    N = -pressure * 2.125  # on the outer face
    verified(forces.N.mean(), N)
    moved = (np.linalg.norm(forces.centre - 3, axis=1) - 2).mean()
    verified(moved, N * 2 / 2e4)


@pytest.mark.verifies("Beam: ring between two forces", reference="thin ring", tolerance=0.03)
@pytest.mark.parametrize("n, thickness", [(44, 0.25), (36, 0.5), (44, 0)])
def test_a_ring_between_two_forces_becomes_oval(n, thickness, verified):
    """0.149 F R^3/EI across the diameter that they act along, M = F R/pi under them."""
    scene, lining = ring(n, EI=20.0, EA=1e6, thickness=thickness)
    F = 0.01
    for sign in (1, -1):
        at = (3, 3 + sign * 2)
        scene.engines = [scene.engines[0], mpm.Force(lining, at, (0, -sign * F)), *scene.engines[1:]]
    forces = solved(scene, 100)
    top, bottom = forces.centre[:, 1].argmax(), forces.centre[:, 1].argmin()
    closer = forces.displacement[bottom, 1] - forces.displacement[top, 1]
    verified(closer, (np.pi / 4 - 2 / np.pi) * F * 2**3 / 20.0)


@pytest.mark.verifies("Beam: on elastic ground", reference="Hetenyi 1946", tolerance=0.03)
def test_a_beam_on_springs_bends_as_hetenyi_says(verified):
    k, F, EI = 50.0, 1.0, 50.0  # kPa per m of deflection, kN/m, kN m2/m
    beta = (k / (4 * EI)) ** 0.25
    scene = mpm.Scene((0, 0), (12, 3), CELL, threads=1)
    line = [(0.5, 2), (11.5, 2)]
    beam = scene.add("beam", mpm.Beam(line, EI=EI, EA=1e5, weight=WEIGHT, thickness=0.5))
    springs = [
        mpm.Spring(beam, at=(x, 2), to=(x, 0.5), stiffness=k * CELL / 2, width=CELL / 2)
        for x in np.unique(beam.position[:, 0].round(9))
    ]
    grown = 20.0  # s, of many periods, so that it does not swing
    push = mpm.Force(
        beam, (6, 2), lambda t: (0, -F * np.sin(np.pi / 2 * t / grown) ** 2), np.linspace(0, grown, 50)
    )
    scene.engines = chain(*springs, push)
    scene.dt = 0.02
    forces = solved(scene, 1000)
    middle = np.abs(forces.s - 6).argmin()
    verified(-forces.displacement[middle, 1], F * beta / (2 * k))
    exact = (
        -F
        / (4 * beta)
        * np.exp(-beta * abs(forces.s - 6))
        * (np.cos(beta * abs(forces.s - 6)) - np.sin(beta * abs(forces.s - 6)))
    )
    away = np.abs(forces.s - 6) > CELL
    verified(forces.M[away], exact[away], scale=F / (4 * beta))


@pytest.mark.verifies("Beam: load at a plastic hinge", reference="beam", tolerance=0.02)
def test_a_plastic_hinge_lets_a_cantilever_turn_under_its_limit(verified):
    limit = 2.0
    for strength, isPlastic in ((limit, True), (None, False)):
        scene, _, push = heldAtTop(0.01, limitMoment=strength, dt=0.05)
        scene.run(until=2.0, progress=False)
        push.velocity = (0.0, None)  # a hinge that turns is viscous
        forces = solved(scene, 40)
        elastic = 3 * EI / LENGTH**3 * 0.02
        if isPlastic:
            verified(push.reaction[0], limit / LENGTH)
            assert np.abs(forces.M).max() == pytest.approx(limit, rel=1e-3)
            assert elastic > 3 * limit / LENGTH
        else:
            assert push.reaction[0] == pytest.approx(elastic, rel=0.02)  # control


RADIUS, HIGH = 3.0, 16.0


def shell(*before):
    """A cylinder that floats, axisymmetric."""
    scene = mpm.Scene((0, 0), (5, HIGH + 2), CELL, threads=1, axisymmetric=True)
    beam = mpm.Beam([(RADIUS, 1), (RADIUS, 1 + HIGH)], EI=1400.0, EA=1e4, weight=WEIGHT, thickness=0.5)
    scene.add("shell", beam)
    scene.engines = chain()
    scene.dt = 0.1
    return scene, scene["shell"]


@pytest.mark.verifies("Shell: cylinder under pressure", reference="membrane", tolerance=0.01)
def test_a_cylinder_under_pressure_widens_by_its_ring_force(verified):
    scene, body = shell()
    load = mpm.BoundaryLoad(body, box((0, 0), (RADIUS - 0.2, HIGH + 2)), pressure=1.0)
    scene.engines = [scene.engines[0], load, *scene.engines[1:]]
    forces = solved(scene, 100)
    ring = RADIUS - 0.25  # on the inner face, kN/m
    verified(body.hoopForce, ring)
    verified(forces.displacement[:, 0], ring * RADIUS / 1e4)


@pytest.mark.verifies("Shell: cylinder under a ring of load", reference="shell", tolerance=0.03)
def test_a_ring_of_load_bends_a_cylinder_like_a_beam_on_elastic_ground(verified):
    P, k = 1.0, 1e4 / RADIUS**2
    beta = (k / (4 * 1400.0)) ** 0.25
    scene, body = shell()
    near = np.argsort(np.abs(body.position[:, 1] - (1 + HIGH / 2)))[:2]
    body.bodyForce[near, 0] = P * 2 * np.pi * RADIUS / body.mass[near].sum()
    forces = solved(scene, 200)
    middle = np.abs(forces.s - (1 + HIGH / 2)).argmin()
    verified(forces.displacement[middle, 0], P * beta / (2 * k))
    x = beta * np.abs(forces.s - (1 + HIGH / 2))
    exact = -P / (4 * beta) * np.exp(-x) * (np.cos(x) - np.sin(x))
    away = np.abs(x) > 0.3
    verified(forces.M[away], exact[away], scale=P / (4 * beta))
