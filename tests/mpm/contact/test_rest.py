# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies that press on each other: no impulse along axes that are held."""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

def engines(contact, **solver):
    stages = mpm.ParticleToGrid(), mpm.GridSolver(**solver), contact, mpm.GridToParticle()
    return [*stages, mpm.DomainUpdater()]


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_what_both_sides_hold_takes_no_impulse(friction):
    """A block is driven into one layer of cells on a roller: its drive and the roller hold the vertical at
    the same nodes. A normal that tilts from it by 4e-5 made a force of 2.4e9 kN in the second step."""
    h = 0.1
    scene = mpm.Scene((0, 0), (1.2, 0.8), h, threads=1)
    soft = mpm.LinearElastic(density=2.5, young=2e4, poisson=0.0)
    ground = scene.add("ground", box((0, 0), (0.9, h)), soft, mpm.UGIMP(perCell=2))
    light = mpm.LinearElastic(density=1.8, young=450.0, poisson=0.3)
    block = scene.add("block", box((h, h), (0.3, 0.4)), light, mpm.UGIMP(perCell=2), group="block")
    drive = mpm.Drive(block, velocity=(0, -0.33))
    contact = mpm.Contact(friction=friction)
    scene.engines = engines(contact, roller=("bottom", "left"), drive=drive)
    pressed = h * 2e4  # kN/m that would press the ground flat under the block, in plane strain
    for _ in range(50):
        scene.step()
        assert -pressed < drive.reaction[1] < 0
        assert np.abs(ground.velocity).max() < 2
        table = contact.contactTable()
        isOnRoller = table["node"][:, 1] == 0
        assert not table["normal"][isOnRoller, 1].any()
