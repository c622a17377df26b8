# SPDX-License-Identifier: GPL-2.0-or-later
"""Where a wall parts soil, each side shares cells with it on its own: doc/theory/volumes.md."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

H, HEIGHT = 0.2, 1.6  # m, of the cells and of the box
PRESSURE = 200.0, 100.0  # kPa, left and right


def divided(x, size, thickness=H):
    """Scene, soil, contact, drive: a held plate from the floor to the lid of a closed box of clay, with
    another pressure on each side.

    x : left face of the plate, m. size : edge of the domains of the plate, m.
    """
    scene = mpm.Scene((0, 0), (2, HEIGHT), H)
    clay = mpm.MohrCoulombDruckerPrager(density=1.5, young=3000, poisson=0.49, cohesion=10, frictionAngle=0)
    plate = box((x, 0), (x + thickness, HEIGHT))
    boxes = mpm.UGIMP(perCell=4)
    soil = scene.add("soil", box((0, 0), (2, HEIGHT)) - plate, clay, boxes, group="soil", fbar=True)
    steel = mpm.LinearElastic(density=1.5, young=3000, poisson=0.3)
    wall = scene.add("plate", plate, steel, mpm.APDI(size=size), group="plate")
    isLeft = soil.position[:, 0] < x + thickness / 2
    soil.setStress(-np.where(isLeft, *PRESSURE)[:, None, None] * np.eye(3))
    wall.setStress(-np.mean(PRESSURE) * np.eye(3))
    contact, drive = mpm.Contact(), mpm.Drive(wall, velocity=(0, 0))
    scene.engines = chain(contact=contact, drive=drive, roller=("left", "right", "bottom", "top"))
    return scene, soil, contact, drive


@pytest.mark.parametrize("x", [1.0, 1.05])
def test_two_pressures_are_in_equilibrium_with_what_the_plate_resists(x):
    """To round-off: what acts on the soil of one side is zero, and the plate has the difference."""
    scene, soil, contact, drive = divided(x, H / 4)
    scene.run(steps=50, progress=False)
    assert scene._core.partedWalls
    isLeft = soil.position[:, 0] < 1.1
    pressure = -np.trace(soil.stress, axis1=1, axis2=2) / 3
    assert pressure == pytest.approx(np.where(isLeft, *PRESSURE), rel=1e-10)
    assert abs(soil.velocity).max() < 1e-10
    assert drive.reaction[0] == pytest.approx((PRESSURE[1] - PRESSURE[0]) * HEIGHT, rel=1e-10)
    assert contact.forceOn("plate")[0] == pytest.approx((PRESSURE[0] - PRESSURE[1]) * HEIGHT, rel=1e-10)


def test_cells_have_a_number_for_each_side():
    """Those of the second side begin at the number of nodes of the grid, with two layers of ghosts."""
    scene, soil, contact, drive = divided(1.05, H / 4, thickness=H / 2)
    scene.run(steps=2, progress=False)
    cells, count = np.array(contact.cells), (10 + 5) * (8 + 5)
    both = set(cells[cells < count]) & set(cells[cells >= count] - count)
    assert len(both) == 8 and not np.any(contact.gaps)  # the column that the plate cuts, all closed


def test_a_plate_that_moves_gives_one_side_what_it_takes_from_the_other():
    """The volumes of both sides change by the way of the plate: the bulk modulus tells the pressures."""
    scene, soil, contact, drive = divided(1.05, H / 4)
    drive.velocity = (0.01, 0)
    scene.run(until=0.05, progress=False)
    way, bulk = 0.01 * scene.time, 3000 / (3 * (1 - 2 * 0.49))
    isLeft = soil.reference[:, 0] < 1.1
    pressure = -np.trace(soil.stress, axis1=1, axis2=2) / 3
    volume = soil.volume
    mean = [np.average(pressure[side], weights=volume[side]) for side in (isLeft, ~isLeft)]
    assert mean[0] == pytest.approx(PRESSURE[0] - bulk * way / 1.05, abs=0.02 * bulk * way)
    assert mean[1] == pytest.approx(PRESSURE[1] + bulk * way / 0.75, abs=0.02 * bulk * way)


@pytest.mark.parametrize("x, cells", [(1.1, 1), (1.05, 1.5), (1.1, 1.5)])
def test_a_pressure_on_one_side_does_not_bend_the_plate(x, cells):
    """Of the forces on a row of nodes the vertical ones have no moment about the middle of the plate. With
    half of its solids for each side in all cells they have 0.5, 1.1 and 0.8 kN m at both ends."""
    scene, soil, contact, drive = divided(x, H / 4, thickness=cells * H)
    scene.run(steps=2, progress=False)
    assert scene._core.partedWalls
    table = contact.contactTable()
    (at, height, _), (along, up, _) = table["node"].T, table["force"].T
    middle = x + cells * H / 2
    for row in np.unique(height.round(6)):
        assert (up * (at - middle))[np.isclose(height, row)].sum() == pytest.approx(0, abs=1e-6)
    assert along.sum() == pytest.approx((PRESSURE[0] - PRESSURE[1]) * HEIGHT, rel=1e-6)
