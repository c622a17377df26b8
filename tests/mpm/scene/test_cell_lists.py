# SPDX-License-Identifier: GPL-2.0-or-later
"""The particles in each cell (ParticleCells) are listed again only where one has entered or left the row of
cells. A scene that goes on has the bits of one that was loaded, whose lists are new."""

import yade_mpm as mpm
from setups import restarted


def test_a_block_that_leaves_its_rows_of_cells_goes_on_after_a_restart():
    """All of its boxes enter the next row at once, and none is left where they were."""
    scene = mpm.Scene((0, 0), (2, 6), cell=0.5, gravity=9.81, threads=1)
    clay = mpm.Tresca(density=1.8, young=500.0, poisson=0.3, undrainedStrength=1.0)
    block = scene.add("block", mpm.box((0.5, 4.5), (1.5, 5.0)), clay, mpm.UGIMP(perCell=2))
    block.velocity[:, 0] = 0.5 * (block.position[:, 0] - 1)
    block.velocity[:, 1] = -2.0
    scene.dt = 2e-3
    scene.run(until=0.5, progress=False)
    assert block.position[:, 1].max() < 4.0
    restarted(scene, 50)
