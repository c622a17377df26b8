# SPDX-License-Identifier: GPL-2.0-or-later
"""A pressure that is the same everywhere in a closed box is an equilibrium of soil and structure, however the
structure lies in the cells that both share (doc/theory/volumes.md)."""

from math import cos, sin

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box, geotech, polygon

CELL, PRESSURE = 0.25, 10.0  # m, kPa
ANGLE = 0.4  # of the square that is not parallel to the grid


def turned(x, y, centre=(1, 0.75)):
    return centre[0] + cos(ANGLE) * x - sin(ANGLE) * y, centre[1] + sin(ANGLE) * x + cos(ANGLE) * y


def square(half):
    """Mesh of 6 x 6 domains."""
    return geotech.quadrilaterals(*turned(*np.meshgrid(*2 * [np.linspace(-half, half, 7)])))


def outline(half):
    return polygon([turned(half * x, half * y) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def coarse():
    """Domains as large as a cell, with vertices in the middle of cells."""
    return geotech.quadrilaterals(*np.meshgrid(*2 * [np.array([0.625, 0.875, 1.125])]))


def at(*corners):
    return dict(body=box(*corners))


CASES = {
    "beside a wall": at((0, 0), (0.5, 1.5)),
    "along the bottom": at((0, 0), (2, 0.5)),
    "in a corner": at((0, 0), (0.5, 0.5)),
    "in the middle": at((0.5, 0.5), (1, 1)),
    "between nodes": at((0.625, 0.625), (1.125, 1.125)),
    "graded": dict(body=box((0.5, 0.5), (1, 1)), graded=True),
    "large domains": dict(body=coarse(), hole=box((0.625, 0.625), (1.125, 1.125))),
    "inclined": dict(body=square(0.3), hole=outline(0.32)),
    "inclined and cut": dict(body=square(0.3), hole=outline(0.3), particles=mpm.UGIMP(perCell=2, cut=True)),
    "stiff": dict(body=box((0.625, 0.625), (1.125, 1.125)), young=1e6),
    "with F-bar": dict(body=box((0.5, 0.5), (1, 1)), fbar=True),
    "soil of boxes and mesh": dict(body=box((0.5, 0.375), (1, 0.875)), mesh=box((0, 0), (2, 0.5))),
    "3D": at((0.5, 0.25, 0.25), (1, 0.75, 0.75)),
    "3D, in a corner": at((0, 0, 0), (0.5, 0.5, 0.5)),
    "3D, between nodes": at((0.5, 0.375, 0.375), (1, 0.875, 0.875)),
}


def closedBox(body, hole=None, particles=None, young=1e4, fbar=None, mesh=None, graded=False, **contact):
    """Scene and its bodies, without stress. hole : what is not soil. mesh : what of the soil is a mesh."""
    hole = hole if hole is not None else body
    dim = len(hole.bounds()[0])
    upper = (2, 1.5, 1)[:dim] if dim == 2 else (1.5, 1, 1)
    whole = box((0,) * dim, upper)
    grading = mpm.Grading(((0.5,) * dim, tuple(u - CELL for u in upper)), 1.3, 0.5) if graded else None
    scene = mpm.Scene((0,) * dim, upper, CELL, threads=1, damping=0.7, grading=grading)
    scene.roller(*("bottom", "top", "right", "left", "front", "back")[: 2 * dim])
    clay = mpm.Tresca(density=2, young=1e4, poisson=0.3, undrainedStrength=1e3)
    ground = whole - hole - mesh if mesh is not None else whole - hole
    soils = [scene.add("soil", ground, clay, particles or mpm.UGIMP(perCell=2), group="soil")]
    if mesh is not None:
        soils.append(scene.add("mesh", mesh - hole, clay, mpm.APDI(size=CELL / 2), group="soil"))
    domains = mpm.APDI() if isinstance(body, tuple) else mpm.APDI(size=CELL / 2)
    structure = mpm.LinearElastic(density=2, young=young, poisson=0.3)
    pile = scene.add("pile", body, structure, domains, group="pile")
    if fbar is not None:
        pile.fbar = fbar
    for soil in soils:
        engine = scene.contact(pile, soil, friction=0.0)
    for name, value in contact.items():
        setattr(engine, name, value)
    return scene, [*soils, pile]


def restOf(case, **contact):
    """Largest change of a stress, kPa, and displacement, m, in 40 steps under a uniform pressure."""
    scene, bodies = closedBox(**CASES[case], **contact)
    for body in bodies:
        body.stress = np.broadcast_to(-PRESSURE * np.eye(3), (body.count, 3, 3))
    scene.run(steps=40, progress=False)
    changed = max(np.abs(body.stress + PRESSURE * np.eye(3)).max() for body in bodies)
    return changed, max(np.abs(body.displacement).max() for body in bodies), scene


@pytest.mark.parametrize("case", CASES)
def test_a_uniform_pressure_stays(case):
    changed, moved, scene = restOf(case)
    contact = next(engine for engine in scene.engines if isinstance(engine, mpm.Contact))
    assert len(contact.gaps) > 0 and not np.any(contact.gaps)  # all cells are closed
    assert changed < 1e-11 * PRESSURE and moved < 1e-14


def test_without_shared_cells_an_inclined_structure_loses_the_pressure():
    """The control: boxes beside an inclined face do not tile the space."""
    changed, moved, _ = restOf("inclined", sharedCells=False)
    assert changed > 0.01 * PRESSURE and moved > 1e-7


def settledUnderGravity(case, **contact):
    """Largest displacement, m, in 0.3 s under a pressure of 10 kPa at the top and 20 kPa more per metre."""
    scene, bodies = closedBox(**CASES[case], **contact)
    scene.gravity = 10.0
    for body in bodies:
        pressure = PRESSURE + 20 * (1.5 - body.position[:, 1])
        body.stress = -pressure[:, None, None] * np.eye(3)
    scene.run(until=0.3, progress=False)
    return max(np.abs(body.displacement).max() for body in bodies)


@pytest.mark.parametrize(
    "case", ["beside a wall", "along the bottom", "in the middle", "between nodes", "inclined and cut"]
)
def test_a_hydrostatic_pressure_moves_hardly_anything(case):
    """Cells see it as steps, and soil and structure move by 0.04 mm; without shared cells up to
    0.9 mm."""
    assert settledUnderGravity(case) < 6e-5


def test_without_shared_cells_it_moves_soil_and_structure():
    assert settledUnderGravity("between nodes", sharedCells=False) > 3e-4
