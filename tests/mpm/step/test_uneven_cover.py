# SPDX-License-Identifier: GPL-2.0-or-later
"""F-bar where boxes do not just fill the cells: beside a mesh whose edge lies between lines of the grid."""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box, geotech

CELLS = 8


@pytest.mark.parametrize("edge", [4.0, 4.25, 4.5, 4.75])
def test_boxes_beside_a_mesh_between_lines_are_strained_as_the_rest(edge):
    """Domains are counted by their centres: a full cell seems to be filled by 0.7 to 1.5."""
    scene = mpm.Scene((-2, -2), (CELLS + 2, CELLS + 2), 1.0)
    soft = mpm.LinearElastic(density=2.0, lame=(1e-3, 1e-3))
    boxes = scene.add("boxes", box((0, 0), (edge, CELLS)), soft, mpm.UGIMP(perCell=4), fbar=True)
    x, y = np.linspace(edge, CELLS, int(np.ceil(CELLS - edge)) + 1), np.linspace(0, CELLS, CELLS + 1)
    mesh = geotech.quadrilaterals(*np.meshgrid(x, y))
    for body in boxes, scene.add("mesh", mesh, soft, mpm.APDI(), fbar=True):
        body.velocity[...] = -0.1 * body.position[:, :1] * [1, 0]
    scene.dt = 1e-3
    before = boxes.volume.copy()
    scene.run(steps=1, progress=False)
    rate = (boxes.volume / before - 1) / scene.dt / -0.1
    position = boxes.position
    beside = (np.abs(position[:, 1] - CELLS / 2) < 2) & (position[:, 0] > np.ceil(edge) - 1)
    assert rate[beside].mean() == pytest.approx(1, abs=0.1)
