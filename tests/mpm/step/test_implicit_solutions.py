# SPDX-License-Identifier: GPL-2.0-or-later
"""Implicit bodies against theory, and their energy."""

import numpy as np
import pytest
import yade_mpm as mpm
from implicitScenes import CELL, CRITICAL, KINDS, LAME, LENGTH, THICKNESS, column, names, soilWithPile
from setups import bits, chain, restarted, withAnyThreads
from yade_mpm import box, diagnostics


@pytest.mark.parametrize("kind", KINDS)
def test_an_axially_loaded_column_is_as_short_as_theory_says_at_any_step(kind):
    ends = []
    for ratio, steps in ((10, 400), (1000, 8)):
        scene = column(kind, along=-1.0)
        scene.dt = ratio * CRITICAL
        scene.run(steps=steps, progress=False)
        body = scene["column"]
        ends.append(body.displacement[body.position[:, 1].argmax(), 1])
    top = LENGTH - CELL / 4
    expected = -7.85 * 1.0 * (LENGTH * top - top**2 / 2) / (LAME[0] + 2 * LAME[1])
    free = expected * (LAME[0] + 2 * LAME[1]) / (4 * LAME[1] * (LAME[0] + LAME[1]) / (LAME[0] + 2 * LAME[1]))
    assert ends[0] == pytest.approx(ends[1], rel=1e-3)
    assert ends[1] == pytest.approx(free, rel=0.01)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_pressure_shortens_a_column_as_theory_says(dim):
    """Loads of BoundaryLoad stay explicit forces."""
    scene = column("APDI", dim)
    body, pressure = scene["column"], 1e3
    height = LENGTH if dim == 2 else 1.5
    top = box((0.0,) * (dim - 1) + (height - 0.01,), (1.0,) * (dim - 1) + (height + 0.01,))
    load = mpm.BoundaryLoad(body, top, pressure=pressure)
    scene.engines = [scene.engines[0], load, *scene.engines[1:]]
    scene.dt = 1e5 * CRITICAL
    scene.run(steps=4, progress=False)
    young = LAME[1] * (3 * LAME[0] + 2 * LAME[1]) / (LAME[0] + LAME[1])
    poisson = LAME[0] / 2 / (LAME[0] + LAME[1])
    modulus = young / (1 - poisson**2) if dim == 2 else young
    middle = np.abs(body.reference[:, -1] - height / 2) < CELL / 2  # the ends are held, or hold less
    above, below = (
        (body.reference[:, -1] > height / 2) & middle,
        (body.reference[:, -1] < height / 2) & middle,
    )
    strain = (body.displacement[above, -1].mean() - body.displacement[below, -1].mean()) / (CELL / 2)
    assert strain == pytest.approx(-pressure / modulus, rel=0.01)


@pytest.mark.parametrize("kind, share", [("uGIMP", 0.98), ("APDI", 0.965)])
def test_a_cantilever_bends_like_a_beam(kind, share):
    """A Timoshenko beam of its plane-strain modulus. Two particles across make uGIMP 2 % and APDI 3.5 %
    stiff."""
    g = 1.0
    scene = column(kind, across=g)
    scene.dt = 1e5 * CRITICAL
    scene.run(steps=6, progress=False)
    body = scene["column"]
    modulus = 4 * LAME[1] * (LAME[0] + LAME[1]) / (LAME[0] + 2 * LAME[1])
    q, L, I = 7.85 * g * THICKNESS, LENGTH, THICKNESS**3 / 12
    x = body.position[:, 1].max()
    bent = q / (24 * modulus * I) * (x**4 - 4 * L * x**3 + 6 * L**2 * x**2)
    sheared = q * (L * x - x**2 / 2) / (5 / 6 * LAME[1] * THICKNESS)
    top = body.displacement[body.position[:, 1] > LENGTH - CELL / 2, 0].mean()
    assert top / (bent + sheared) == pytest.approx(share, abs=0.01)


def test_reactions_balance_momentum():
    """Sum of m dv/dt = weight + reactions, to round-off, with rollers, a fixed face, and a drive with a
    ramp."""
    scene = soilWithPile(damping=0.0)
    scene.dt = 5e-4
    scene.run(steps=10, progress=False)
    weight = np.array([0, -9.81]) * diagnostics.mass(scene)
    for _ in range(20):
        before = diagnostics.momentum(scene)
        scene.run(steps=1, progress=False)
        change = (diagnostics.momentum(scene) - before) / scene.dt
        reactions = sum(np.array(c._core.reaction[:2]) for c in scene.constraints)
        scale = sum(np.abs(c._core.reaction[:2]).sum() for c in scene.constraints)
        assert np.abs(change - weight - reactions).max() < 1e-10 * scale


def test_energy_that_the_solution_takes_is_counted():
    scene = soilWithPile(damping=0.0)
    scene.dt = 5e-4
    scene.run(until=0.1, progress=False)
    taken, external = diagnostics.implicitEnergy(scene), diagnostics.externalWork(scene)
    assert 0 < taken < 0.01 * abs(external)
    assert abs(diagnostics.energyError(scene)) < 0.02 * abs(external)


def test_a_small_step_gives_what_the_explicit_body_gives():
    """The force of the drive while its ramp sends waves through the pile. What differs is the velocity that
    strains the body: MUSL's for the explicit one."""
    results = []
    for implicit in (False, True):
        scene = soilWithPile(implicit, damping=0.0)
        scene.dt = 1e-5
        history = mpm.History(period=0.01)
        scene.engines = [*scene.engines, history]
        scene.run(until=0.05, progress=False)
        results.append(history["drive.fy"][1:])
    assert results[1] == pytest.approx(results[0], abs=0.015 * np.abs(results[0]).max())


def test_local_damping_leaves_the_body_alone():
    scene, free = column(along=-1.0, damping=0.5), column(along=-1.0)
    for s in (scene, free):
        s.dt = 20 * CRITICAL
        s.run(steps=20, progress=False)
    assert bits(scene) == bits(free) and diagnostics.dampedEnergy(scene) == 0


def test_gradient_and_vertices_follow_the_solved_velocity():
    """F of an APDI domain is what its vertices say: both follow one velocity."""
    scene = column("APDI", across=50.0)
    scene.dt = 50 * CRITICAL
    scene.run(steps=40, progress=False)
    body = scene["column"]
    areas = diagnostics.cornerJacobians(body.corners()).mean(axis=1)
    J = np.linalg.det(body.deformationGradient)
    assert areas == pytest.approx(J * body.initialVolume, rel=1e-6)
    assert np.abs(body.displacement).max() > 0.01


def test_usl_and_musl_move_an_implicit_body_alike():
    states = []
    for scheme in ("MUSL", "USL"):
        scene = mpm.Scene((0, 0), (1, 3), CELL, scheme=scheme, threads=1)
        steel = mpm.LinearElastic(density=7.85, lame=LAME)
        scene.add("column", box((0.375, 0), (0.625, 2)), steel, mpm.APDI(size=CELL / 2), implicit=True)
        scene.engines = chain(gravity=(1.0, -9.81), fixed="bottom")
        scene.dt = 20 * CRITICAL
        scene.run(steps=50, progress=False)
        states.append(bits(scene))
    assert states[0] == states[1]


# --- several bodies ---------------------------------------------------------------------------------------
def test_two_bodies_that_touch_are_one_system_and_others_are_systems_of_their_own():
    """A column of two bodies moves like that of one, and a far one beside it does not change a bit."""
    tops = []
    for parts in (1, 2):
        scene = mpm.Scene((0, 0), (4, 3), CELL, threads=1)
        steel = mpm.LinearElastic(density=7.85, lame=LAME)
        heights = np.linspace(0, 2, parts + 1)
        for lower, upper in zip(heights, heights[1:]):
            region = box((0.375, lower), (0.625, upper))
            scene.add(f"to {upper}", region, steel, mpm.UGIMP(), implicit=True)
        far = scene.add("far", box((3.375, 0), (3.625, 2)), steel, mpm.UGIMP(), implicit=True)
        scene.engines = chain(gravity=(1.0, -1.0), fixed="bottom")
        scene.dt = 50 * CRITICAL
        scene.run(steps=30, progress=False)
        tops.append((scene["to 2.0"].displacement[-1], far.displacement[-1]))
    assert tops[1][0] == pytest.approx(tops[0][0], rel=1e-9)
    assert tops[0][1] == pytest.approx(tops[0][0], rel=1e-9)


# --- bits -------------------------------------------------------------------------------------------------
def test_threads_and_a_restart_do_not_change_a_bit():
    def make(threads):
        scene = soilWithPile(threads=threads)
        scene.dt = 5e-4
        return scene

    scene = withAnyThreads(make, 15)
    other = restarted(scene, 15)
    assert other["pile"].implicit and names(other) == names(scene)
    assert diagnostics.implicitEnergy(other) == diagnostics.implicitEnergy(scene) > 0


@pytest.mark.parametrize("hasBase", [False, True])
def test_what_is_driven_and_not_strained_loses_nothing(hasBase):
    """A ramp of ten steps; with a fixed base elsewhere other rows are held at rest."""
    scene = mpm.Scene((0, 0), (3, 6), 0.25)
    steel = mpm.LinearElastic(density=7.85, lame=(4.2e7, 2.8e7))
    pile = scene.add("pile", mpm.box((1.25, 1), (1.75, 5)), steel, mpm.UGIMP(), implicit=True)
    if hasBase:
        scene.add("far", mpm.box((0, 0), (0.25, 0.25)), steel, mpm.UGIMP(), implicit=True)
    drive = mpm.Drive(pile.above(2.0), velocity=(0, 0.5), ramp=0.02)
    scene.engines = chain(drive=drive, **({"fixed": "bottom"} if hasBase else {}))
    scene.dt = 2e-3
    scene.run(steps=30, progress=False)
    work = mpm.diagnostics.externalWork(scene)
    assert work == pytest.approx(mpm.diagnostics.kineticEnergy(scene), rel=1e-3)
    assert abs(mpm.diagnostics.implicitEnergy(scene)) < 1e-3 * work
    assert abs(mpm.diagnostics.energyError(scene)) < 1e-5 * work
