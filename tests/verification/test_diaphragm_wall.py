# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/diaphragm_wall.py beside PLAXIS. Tolerance: 10 %, for the lever of the shear on the faces of a wall
that is drawn 1 m thick. Control: a wall of a tenth of the stiffness has half of the moment."""

import diaphragm_wall
import numpy as np
import pytest

PLAXIS = {10: (154,), 20: (320, 1390, 1710)}  # dug to, m: strut, moments above and below the floor of the pit


@pytest.mark.verifies("Strutted diaphragm wall: strut and moments", reference="PLAXIS", tolerance=0.1)
def testTheWallHasTheForcesOfPlaxis(verified):
    _, found = diaphragm_wall.dug((2, 10, 20))
    for depth, known in PLAXIS.items():
        force, forces = found[depth]
        for computed, its in zip((force, -forces.M.min(), forces.M.max()), known):
            verified(computed, its)


@pytest.mark.slow
def testControlASoftWallHasHalfTheMoment():
    _, found = diaphragm_wall.dug((2, 20), stiffness=1e5)
    assert np.abs(found[20][1].M).max() < 0.6 * 1710
