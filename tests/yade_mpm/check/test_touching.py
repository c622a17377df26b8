# SPDX-License-Identifier: GPL-2.0-or-later
"""Warnings of what contact is known to do badly, before the first step."""

import pytest
import yade_mpm as mpm
from inputs import warningsOf
from setups import chain
from yade_mpm import box
from yade_mpm.check.touching import squeezed

MESH, BOXES = mpm.APDI(size=0.25), mpm.UGIMP(perCell=2)


def told(
    wall, thickness=0.5, dim=2, back="soil", cell=0.5, tilt=0.0, asOne=True, beside=True, boxes=BOXES, **law
):
    """Messages about contact of a wall between soils; asOne: which are one body, if of one group; beside: and
    a mesh, so that no wall parts them."""

    def block(lower, upper):
        return box(lower, upper) if dim == 2 else box((lower[0], 0, lower[1]), (upper[0], 1, upper[1]))

    upper = (8, 5) if dim == 2 else (8, 1, 5)
    scene = mpm.Scene((0,) * dim, upper, cell, threads=1)
    elastic = mpm.LinearElastic(density=2, young=1e4, poisson=0.2)
    front, behind = block((4 + thickness, 0), (8, 4)), block((0, 0), (4, 4))
    isBoth = asOne and back == "soil"
    scene.add("front", front | behind if isBoth else front, elastic, boxes, group="soil")
    if back and not isBoth:
        scene.add("back", behind, elastic, boxes, group=back)
    if beside and isBoth:
        scene.add("mesh", block((7, 4), (8, 4.5)), elastic, MESH, group="soil")
    made = scene.add("wall", block((4, 0), (4 + thickness, 4)), elastic, wall, group="wall")
    if tilt:
        made.vertices[:, 0] += tilt * made.vertices[:, 1]
    scene.engines = chain(contact=mpm.Contact(**law))
    return warningsOf(lambda: [scene.run(steps=1, progress=False) for _ in "12"], "Contact")


@pytest.mark.parametrize("dim", [2, 3])
def test_a_wall_thinner_than_two_cells_between_soil_is_warned_of_once(dim):
    (text,) = told(MESH, dim=dim)
    assert text.startswith("Contact: 'wall' is 0.5 m thick at (4, ")
    assert "if the wall moves sideways, the soil moves only half as far, and resists up to a quarter" in text
    assert "less than two cells of 0.5 m, with 'soil' on both sides" in text
    assert text.endswith("give cells of 0.25 m at most")
    assert "dry soil of boxes without outline is parted by a straight wall of half a cell or more" in text
    assert told(MESH, dim=dim, beside=False) == []  # the wall parts it
    assert told(MESH, dim=dim, asOne=False) == []
    assert told(MESH, thickness=1.0, dim=dim) == []  # control: two cells
    assert told(MESH, back=None, dim=dim) == []  # control: soil on one side


def test_a_wall_thinner_than_half_a_cell_is_warned_of_though_it_parts_soil():
    fine = mpm.UGIMP(perCell=4)
    (text,) = told(MESH, thickness=0.25, cell=1.0, beside=False, boxes=fine)
    assert "is 0.25 m thick at (4.25, 0.125), less than half a cell of 1 m" in text
    assert text.endswith("give cells of 0.5 m at most")
    assert told(MESH, thickness=0.5, cell=1.0, beside=False, boxes=fine) == []


@pytest.mark.parametrize("thickness, isTold", [(0.25, True), (0.5, False)])
def test_water_flows_through_a_wall_thinner_than_a_cell(thickness, isTold):
    """Two and a half times as much as below a sheet pile, at half a cell."""
    scene = mpm.Scene((0, 0), (8, 5), 0.5, gravity=9.81, threads=1)
    elastic, shape = mpm.LinearElastic(density=2, young=1e4, poisson=0.2), box((4, 1), (4 + thickness, 4))
    soil = scene.add("soil", box((0, 0), (8, 4)) - shape, elastic, BOXES, water=mpm.PoreWater(table=4.0))
    wall = scene.add("wall", shape, elastic, MESH)
    scene.contact(wall, soil)
    texts = warningsOf(lambda: scene.run(steps=1, progress=False), "PoreWater: 'wall'")
    assert [text.endswith("give cells of 0.25 m at most") for text in texts] == [True] * isTold


def test_walls_that_lean_are_found_too():
    (text,) = told(MESH, thickness=0.75, tilt=0.1)
    assert "'wall' is 0.746 m thick" in text
    assert told(MESH, thickness=0.75, tilt=0.1, beside=False) == []
    assert told(MESH, thickness=1.25, tilt=0.1) == []


def test_boxes_on_boxes_are_warned_of_once():
    (text,) = told(BOXES)
    assert text.startswith("Contact: 'soil' and 'wall' are boxes on both sides")
    assert "give APDI(size=...) to one of the two" in text
    (text,) = told(MESH, back="fill", thickness=1.0)
    assert text.startswith("Contact: 'soil' and 'fill' are boxes")
    assert told(BOXES, slip=False, separation=False) == []  # one body


@pytest.mark.parametrize("thickness, beside, enough", [(0, True, 2), (0.25, False, 0.5)])
def test_a_thin_beam_is_to_be_given_a_thickness(thickness, beside, enough):
    """Its faces may lie anywhere, and those of a line are a cell apart in cells of any size."""
    scene = mpm.Scene((0, 0), (8, 5), 1.0, gravity=9.81, threads=1)
    elastic = mpm.LinearElastic(density=2, young=1e4, poisson=0.2)
    x = 4 + (thickness or 1) / 2
    sheet = mpm.Beam([(x, 1), (x, 4)], EI=1e4, EA=1e6, weight=0.5, thickness=thickness)
    wall = scene.add("wall", sheet)
    soil = scene.add("soil", box((0, 0), (8, 4)) - sheet.region, elastic, mpm.UGIMP(perCell=4))
    if beside:
        scene.add("mesh", box((7, 4), (8, 5)), elastic, MESH, group=soil.group)
    scene.contact(wall, soil)
    (text,) = warningsOf(lambda: scene.run(steps=1, progress=False), "Contact: 'wall'")
    assert text.endswith(f"give its Beam thickness={enough}, which does not change how it bends")


def bars(gap, soil=True, sharedCells=True, dim=2):
    """What a look in a run finds about two bars, `gap` m apart, in soil with cells of 0.5 m."""

    def block(lower, upper):
        return box(lower, upper) if dim == 2 else box((*lower, 0), (*upper, 1))

    upper = (6, 5) if dim == 2 else (6, 5, 1)
    scene = mpm.Scene((0,) * dim, upper, 0.5, threads=1)
    elastic = mpm.LinearElastic(density=2, young=1e4, poisson=0.2)
    left, right = block((1, 1), (2, 3)), block((2 + gap, 1), (5, 3))
    if soil:
        ground = block((0, 0), (6, 4)) - left - right
        scene.add("soil", ground, elastic, BOXES, group="soil", fbar=True)
    for name, shape in (("left", left), ("right", right)):
        scene.add(name, shape, elastic, MESH, group=name)
    scene.engines = chain(contact=mpm.Contact(sharedCells=sharedCells))
    return squeezed(scene)


@pytest.mark.parametrize("dim", [2, 3])
def test_soil_between_two_bodies_less_than_three_cells_apart_is_warned_of(dim):
    text = bars(1.0, dim=dim)
    assert text.startswith("Contact: 'left' and 'right' are 1 m apart at (2.5, ")
    assert "less than three cells of 0.5 m, with soil between them" in text
    assert text.endswith("give cells of 0.333 m at most")
    assert bars(1.5, dim=dim) is None  # control: three cells
    assert bars(1.0, dim=dim, soil=False) is None
    assert bars(1.0, dim=dim, sharedCells=False) is None
    assert bars(0.0, dim=dim) is None  # nothing between them
