# SPDX-License-Identifier: GPL-2.0-or-later
"""Which nodes a driven part of a body moves."""

import pytest
import yade_mpm as mpm
from yade_mpm import box

KINDS = {"uGIMP": lambda cell: mpm.UGIMP(perCell=2), "APDI": lambda cell: mpm.APDI(size=cell)}


def heldNodes(kind, cell, end):
    """Number of nodes that a drive of the upper part of a block holds in the first step; end : in cells."""
    scene = mpm.Scene((0, 0), (10 * cell, 10 * cell), cell, threads=1)
    block, soil = box((2 * cell, 2 * cell), (8 * cell, 8 * cell)), dict(density=1.7, young=1e3, poisson=0.3)
    body = scene.add("block", block, mpm.LinearElastic(**soil), KINDS[kind](cell))
    drive = mpm.Drive(body.above(end * cell), velocity=(0.1, None))
    scene.engines[1] = mpm.GridSolver(drive=drive)
    scene.run(steps=1, progress=False)
    return drive.heldNodes


@pytest.mark.parametrize("cell", [0.1, 0.25, 0.3, 0.35])
@pytest.mark.parametrize("kind", KINDS)
def test_a_part_that_ends_on_a_line_drives_all_nodes_of_the_line(kind, cell):
    """Seven in each of four rows, and some that boxes touch by round-off, which chose among the lowest."""
    assert heldNodes(kind, cell, end=5) >= 4 * 7


def test_control_a_part_that_ends_between_lines_drives_those_inside_it():
    assert 3 * 7 <= heldNodes("uGIMP", 0.25, end=5.4) < 4 * 7
