# SPDX-License-Identifier: GPL-2.0-or-later
"""Graded grids against exact solutions: a manufactured solution, the half-plane under a strip load with its
faces far away, waves that come back from growing cells, sliding contact, F-bar.

Cells of 0.25 m that grow to 1 m, pulses cos^2 of half length 2 and 4 m: a bar of two-node elements sends back
4.1 and 1.0 % (growth 1.2), 0.9 and 0.25 % (1.1)."""

from math import cos, radians, sin

import numpy as np
import pytest
import yade_mpm as mpm
from asModules import TESTS, moduleOf, script
from setups import afterTurn, chain, elastic
from yade_mpm import box, geotech


# --- manufactured solution ------------------------------------------------------------------------------
def smooth(count):
    """Lines of the unit square whose cells differ by up to a factor of 3."""
    even = np.linspace(0, 1, count + 1)
    return even + 0.5 * np.sin(2 * np.pi * even) / (2 * np.pi)


def alternating(count):
    """Lines whose neighbouring cells differ by a factor of 1.3 however fine they are."""
    edges = np.where(np.arange(count) % 2, 1.3, 1.0)
    return np.concatenate([[0], np.cumsum(edges)]) / edges.sum()


@pytest.mark.parametrize("lines, within", [(smooth, 1.4), (alternating, 1.25)])
def test_a_manufactured_solution_converges_with_second_order(lines, within):
    """The error is at most so many times that of as many equal cells (D9)."""
    D9 = moduleOf(TESTS / "verification" / "test_D09_manufactured_solution.py")
    errors = [D9.Solution("APDI", 0.05, N, lines=lines(N)).error for N in (16, 32)]
    assert D9.order(*errors) > 1.9
    assert errors[1] < within * D9.REFERENCE["APDI", 0.05][2]


# --- half-plane -----------------------------------------------------------------------------------------
STRIP = [  # options, most domains, error at the depths of the scene
    (("--smoke", "--growth", "1.3", "--extent", "100"), 3200, (0.07, 0.03, 0.015, 0.013, 0.013)),
    pytest.param(
        ("--smoke", "--growth", "1.3", "--extent", "400"),
        3200,
        (0.07, 0.03, 0.015, 0.013, 0.013),
        marks=pytest.mark.slow,
    ),
    pytest.param(
        ("--growth", "1.2", "--extent", "800"),
        51200,
        (0.02, 0.013, 0.013, 0.013, 0.013),
        marks=pytest.mark.slow,
    ),
]


@pytest.mark.parametrize("options, most, errors", STRIP)
@pytest.mark.verifies(
    "Strip load on a graded grid: stress below the axis", reference="half-plane", tolerance=0.07
)
def test_a_half_plane_whose_faces_are_far_takes_no_more_domains(options, most, errors, verified):
    """20 times as far as those of the scene on equal cells, with at most its domains."""
    strip = script("strip_load")
    summary = strip.run(strip.arguments([*options, "--threads", "1"]))[0]
    assert summary["domains"] <= most
    verified(summary["error"], 0, scale=1, within=errors)


# --- waves ----------------------------------------------------------------------------------------------
CELL, LARGEST, EVEN = 0.25, 1.0, 24.0  # m: cells in [0, EVEN], and far away


def barLines(growth):
    """Lines along a bar of which the cells grow from EVEN on; a growth of None is a jump, 1 none."""
    edges = [CELL]
    while growth not in (None, 1) and edges[-1] < LARGEST:
        edges.append(min(growth * edges[-1], LARGEST))
    far = [CELL] * 240 if growth == 1 else [LARGEST] * 60
    return np.concatenate([np.arange(0, EVEN + 1e-9, CELL), EVEN + np.cumsum([*edges[1:], *far])])


def bar(lines, half, scheme):
    """Velocity over that of the pulse in the cells before EVEN, once it has passed and its echo is there, and
    once short waves have come, which are slow. Waves travel at 1 m/s."""
    start, height = EVEN - half - 2.0, 1e-6
    bar = mpm.Scene((0, 0), (lines[-1], 2 * CELL), grading=(lines, [0, CELL, 2 * CELL]), threads=1)
    bar.scheme = scheme
    rock = mpm.LinearElastic(density=1.0, lame=(0.5, 0.25))
    body = bar.add("bar", box((0, 0), (lines[-1], 2 * CELL)), rock, mpm.APDI(size=CELL / 2))
    bar.engines = chain(roller=("left", "right", "bottom", "top"))
    away = body.position[:, 0] - start
    pulse = np.where(np.abs(away) < half, np.cos(np.pi * away / (2 * half)) ** 2, 0) * height
    body.velocity[:, 0] = pulse
    body.setStress(-pulse[:, None, None] * np.diag([1.0, 0.0, 0.0]))
    bar.dt, found = 0.25 * CELL, []
    for later in (14.0, 32.0):
        bar.run(until=half + later, progress=False)
        order = np.lexsort((body.position[:, 1], np.round(body.position[:, 0], 3)))
        found.append(body.velocity[order[body.position[order, 0] < EVEN - 1], 0] / height)
    return np.array(found)


@pytest.mark.parametrize(
    "scheme, half, growth, back",
    [
        ("USL", 2.0, 1.1, (0.0022, 0.0038)),
        ("USL", 2.0, 1.2, (0.0088, 0.048)),
        ("USL", 4.0, 1.1, (0.0014, 0.0041)),
        ("USL", 4.0, 1.2, (0.0085, 0.0113)),
        ("MUSL", 2.0, 1.1, (0.0098, 0.13)),
        ("MUSL", 2.0, 1.2, (0.053, 0.23)),
        ("MUSL", 4.0, 1.1, (0.0043, 0.0177)),
        ("MUSL", 4.0, 1.2, (0.021, 0.0446)),
        ("MUSL", 2.0, None, (0.4, 0.4)),
    ],
)
def test_what_comes_back_of_a_wave_from_growing_cells(scheme, half, growth, back):
    """The echo, and the short waves that come behind it. Under USL these are damped. Control: a jump to
    cells four times as long."""
    echo = np.abs(bar(barLines(growth), half, scheme) - bar(barLines(1), half, scheme)).max(axis=1)
    assert echo == pytest.approx(back, rel=0.1)


# --- contact --------------------------------------------------------------------------------------------
@pytest.mark.parametrize("alongOnly", [True, False])
@pytest.mark.verifies(
    "Block slides from small cells into large ones: acceleration", reference="Coulomb", tolerance=0.005
)
def test_a_block_slides_as_coulomb_says_from_small_cells_into_large_ones(alongOnly, verified):
    """Two metres down a slope, into cells three times as long; without alongOnly they grow upward, too."""
    slope, friction, g, h = radians(45), 0.3, 10.0, 0.1
    even = ((0, 0), (1, 2)) if alongOnly else ((0, 0.1), (1, 0.4))
    scene = mpm.Scene((0, 0), (6, 2), h, threads=1, grading=mpm.Grading(even, largest=3 * h))
    rubber = elastic(1e5)
    scene.add("base", box((0, 0), (6, 0.4)), rubber, mpm.APDI(size=h / 2), group="base")
    mesh = geotech.quadrilaterals(*np.meshgrid(np.linspace(0.3, 0.8, 11), np.linspace(0.4, 0.9, 11)))
    block = scene.add("block", mesh, rubber, mpm.APDI(), group="block")
    base = mpm.Hold(box((-1, -1), (7, 0.21)), velocity=(0, 0), name="base")
    contact, rows = mpm.Contact(friction=friction), []
    scene.engines = chain(contact=contact, gravity=(0, -g * cos(slope)), damping=0.7, hold=base)
    for time in afterTurn(scene, slope, 0.1, 1.0, steps=100):
        rows.append((time, block.velocity[:, 0].mean(), block.position[:, 1].mean()))
    time, velocity, height = np.array(rows).T
    acceleration = np.polyfit(time, velocity, 1)[0]
    assert block.position[:, 0].mean() > 2.5 and scene.cellSizeAt(block.position)[:, 0].max() > 2.9 * h
    verified(acceleration, g * (sin(slope) - friction * cos(slope)))
    assert np.abs(height - 0.65).max() < 0.01 * h


# --- F-bar ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
def test_fbar_averages_over_the_cells_of_a_graded_grid(kind):
    """Of the mean stress a part that alternates from domain to domain goes, and one that is linear stays."""
    lines = 0.5 * np.concatenate([[0], np.cumsum(1.2 ** np.arange(8))])
    scene = mpm.Scene((0, 0), (lines[-1],) * 2, grading=(lines, lines), threads=1)
    strong = mpm.MohrCoulombDruckerPrager(
        density=2.0, lame=(1e3, 1e3), cohesion=1e3, frictionAngle=0.0, dilatancyAngle=0.0
    )
    upper = float(lines[-2]) if kind == "APDI" else 2.0
    type_ = mpm.APDI(size=0.25) if kind == "APDI" else mpm.UGIMP(perCell=4)
    body = scene.add("block", box((float(lines[1]),) * 2, (upper,) * 2), strong, type_, fbar=True)
    x, linear = body.position, 7 + body.position @ (3.0, -5.0)
    cell = np.stack([np.searchsorted(lines, x[:, k]) for k in range(2)], axis=1)
    odd = np.zeros(body.count)
    for c in np.unique(cell, axis=0):  # a pattern of no mean and no slope in each cell
        members = (cell == c).all(axis=1)
        away = (x[members] - x[members].mean(axis=0)).prod(axis=1)
        odd[members] = 4 * np.sign(away)
    body.stress[...] = (linear + odd)[:, None, None] * np.eye(3)
    scene.dt = 1e-13
    scene.run(steps=1, progress=False)
    inside = ((cell > cell.min(axis=0)) & (cell < cell.max(axis=0))).all(axis=1)
    mean = np.trace(body.stress, axis1=1, axis2=2) / 3
    assert inside.sum() > 30
    assert mean[inside] == pytest.approx(linear[inside], abs=1e-6)
