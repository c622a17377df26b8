# SPDX-License-Identifier: GPL-2.0-or-later
"""D4: a column compacts under its own weight (large strain).

Set-up: l0 = 50 m, E = 1000 kPa, nu = 0, rho0 = 0.08 Mg/m3, one cell wide between rollers; gravity grows to
g = 10 m/s2
over 20 s (11 natural periods) and stays for 10 s, local damping 0.7. Two particles per cell.
Reference: sigma_yy(Y) = -rho0 g (l0 - Y), Y the initial height; base 40 kPa. Exact for any material,
because the
width does not change. Source: Coombs & Augarde 2020, Adv. Eng. Softw. 139, 102748 (AMPLE).
Tolerances: relative L1 error of the particle stresses 2 % at 64 cells, rate of convergence 0.9 between
every two grids.
Control: with the gravity at once and hardly any damping the error is far above the tolerance; a rate of the
order of
zero, as that of the linear material point method, would fail the bound on the rate.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

LENGTH, DENSITY, GRAVITY = 50.0, 0.08, 10.0
TYPES = {"UGIMP": lambda h: mpm.UGIMP(perCell=2), "APDI": lambda h: mpm.APDI(size=h / 2)}


def compact(cells, kind, rampTime=20.0, restTime=10.0, damping=0.7):
    """Relative L1 error of the stress, and the stress extrapolated to the base, kPa."""
    h = LENGTH / cells
    scene = mpm.Scene(lower=(0, 0), upper=(h, LENGTH), cell=h)
    material = mpm.LinearElastic(density=DENSITY, young=1000.0, poisson=0.0)
    column = scene.add("column", mpm.box((0, 0), (h, LENGTH)), material, TYPES[kind](h))
    engines = chain(roller=("left", "right"), fixed=("bottom",), damping=damping)

    def load():
        engines[1].gravity = (0, -GRAVITY * (min(1.0, scene.time / rampTime) if rampTime else 1.0))

    scene.engines = [mpm.PyRunner(load, iterPeriod=1), *engines]
    scene.run(until=rampTime + restTime, progress=False)
    depth = LENGTH - column.reference[:, 1]
    exact, reached = -DENSITY * GRAVITY * depth, column.stress[:, 1, 1]
    base = np.polyval(np.polyfit(depth, reached, 1), LENGTH)
    return abs(reached - exact).sum() / abs(exact).sum(), base


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.verifies(
    "Column compacts under its weight, 64 cells: stress", reference="weight above, exact", tolerance=0.02
)
def test_stress_converges_to_the_weight_above(kind, verified):
    errors, bases = zip(*[compact(cells, kind) for cells in (16, 32, 64)])
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    verified(errors[-1], 0, scale=1, order=rates.min())
    assert (rates >= 0.9).all(), (errors, rates)
    verified(bases[-1], -40.0)


def test_control_a_sudden_load_is_not_at_rest():
    error, _ = compact(64, "UGIMP", rampTime=0.0, restTime=30.0, damping=0.002)
    assert error > 0.1
