# SPDX-License-Identifier: GPL-2.0-or-later
"""Returns along principal axes do not depend on the axes, however close two principal values are.

Reference: the return of a stress along the coordinate axes, turned. Tolerance: 1e-12 of the largest stress.
Control: axes that are off by 1e-10.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from tensors import LAMBDA, MU, TOLERANCE, I, rotation

RETURNS = {
    "Tresca": lambda: mpm.Tresca(density=1.5, lame=(LAMBDA, MU), undrainedStrength=20),
    "MohrCoulomb": lambda: mpm.MohrCoulomb(
        density=1.5, lame=(LAMBDA, MU), cohesion=8, frictionAngle=0.5, dilatancyAngle=0.2, tensileStrength=5
    ),
}


def axesError(make, digits, power=0, cases=100):
    """Largest difference of the stress returned along random axes from that along x, y, z, over the stress.

    digits : principal values are apart by 10^-digits of themselves. power : of noise in the axes.
    """
    rng = np.random.default_rng(3)
    worst = 0.0
    for case in range(cases):
        far = [0.0, *-np.sort(rng.uniform(0, 1, 2))]
        far[1] = far[2 * (case % 2)] + (1 - 2 * (case % 2)) * far[1] * 10.0**-digits
        principal = 100 * np.array(far) + 30 * rng.normal()
        q = rotation(rng)
        stresses = []
        for axes in (I, q + power * rng.normal(size=(3, 3))):
            a = axes * principal @ axes.T
            point = mpm.MaterialPoint(make(), (a + a.T) / 2)
            stresses.append(point.gradient(np.zeros((3, 3)), 1.0))
        worst = max(worst, np.abs(q @ stresses[0] @ q.T - stresses[1]).max() / np.abs(principal).max())
    return worst


@pytest.mark.parametrize("digits", [0, 4, 8, 12, 16])
@pytest.mark.parametrize("name", RETURNS)
def test_a_return_does_not_depend_on_the_axes(name, digits):
    assert axesError(RETURNS[name], digits) <= TOLERANCE


def test_control_other_axes_are_noticed():
    assert axesError(RETURNS["Tresca"], 8, power=1e-10) > 10 * TOLERANCE
