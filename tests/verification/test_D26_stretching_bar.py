# SPDX-License-Identifier: GPL-2.0-or-later
"""D26: numerical fracture of a bar that stretches under its own weight (scripts/stretching_bar.py).

Set-up: block of 1 x 1 m hung from its top, plane strain, neo-Hookean, E = 1000 kPa, nu = 0.3, rho = 1.05
Mg/m3, g = 1000 m/s2
switched on suddenly; h = 1/8 m (1/16 in the slow tests), up to 0.09 s, when the bar is longest (2.6 m).
Reference: centre of mass against time of total-Lagrangian finite elements (stretching_bar_reference.py, 64
x 64 elements).
Source: our finite element solution; the case is after Sadeghirad, Brannon & Burghardt 2011, Int. J. Numer.
Meth. Eng. 86(12).
Tolerance: 3 % of the largest fall of the centre of mass (1.07 m). Boxes farther apart than 2 + 1/perCell
cells share no node.
"""

import numpy as np
import pytest
from asModules import TESTS, moduleOf, script

FINER = pytest.param(1 / 16, marks=pytest.mark.slow)


@pytest.fixture(scope="module")
def bar():
    return script("stretching_bar")


def test_the_stored_reference_is_what_its_script_computes():
    reference = moduleOf(TESTS / "verification" / "stretching_bar_reference.py")
    stored = np.loadtxt(reference.TABLE, delimiter=",")
    coarse = reference.run(8, 0.1, 0.005)
    assert np.abs(coarse[:, 1] - stored[: len(coarse), 1]).max() < 0.01 * 1.07
    assert np.abs(stored[1:, 3]).max() < 1e-3, "its energy is kept"


@pytest.mark.parametrize("until", [0.09, 0.3])
@pytest.mark.parametrize("cell", [1 / 8, FINER])
@pytest.mark.verifies(
    "Bar stretched 2.6 times, APDI: centre of mass over its fall", reference="finite elements", tolerance=0.03
)
def test_apdi_stays_whole_down_and_up_again(bar, cell, until, verified):
    _, watch = bar.run(until, kind="APDI", cell=cell)
    verified(watch.miss, 0, scale=1)


@pytest.mark.parametrize("cell", [1 / 8, FINER])
@pytest.mark.verifies(
    "Bar stretched 2.6 times, uGIMP(splitAt=1.3): the same", reference="finite elements", tolerance=0.03
)
def test_ugimp_stays_whole_where_long_particles_are_split(bar, cell, verified):
    scene, watch = bar.run(kind="split", cell=cell)
    verified(watch.miss, 0, scale=1)
    assert watch.widestGap < 1
    assert scene["bar"].mass.sum() == pytest.approx(1.05, rel=1e-13)


@pytest.mark.parametrize("cell", [1 / 8, FINER])
def test_control_ugimp_alone_falls_apart(bar, cell):
    _, watch = bar.run(kind="UGIMP", cell=cell)
    assert watch.widestGap > 2 + 1 / 3
    assert watch.miss > 0.3


def test_control_split_at_two_comes_too_late(bar):
    _, watch = bar.run(kind="split", splitAt=2.0)
    assert watch.miss > 0.05
