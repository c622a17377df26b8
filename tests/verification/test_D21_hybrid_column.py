# SPDX-License-Identifier: GPL-2.0-or-later
"""D21: a column of uGIMP and APDI settles under gravity as one of uGIMP alone.

Set-up: the 10 m elastic column of D20 (E = 16408.4 kPa, nu = 0.3002, rho = 1.53 Mg/m3), two cells of 0.5 m
wide,
particles and domains of h/2: uGIMP below APDI, APDI below uGIMP, APDI to the left of uGIMP. Settled with
local damping.
Reference: the all-uGIMP column; independent codes differed by 0.7 % of rho g H at most (rms 0.53 %).
Tolerances: vertical stress within 0.7 % of rho g H at every particle, rms 0.53 %; grid mass equals particle
mass to
1e-14; momentum changes by the applied impulse to 1e-12.
Control: APDI edges of 2h at the interface, which a scene refuses and which are smuggled in here, are off by
more than a
tenth of rho g H (measured elsewhere: 89 %).
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm.scene import policy, stepper

CELL, HEIGHT, WIDTH, DENSITY, GRAVITY = 0.5, 10.0, 1.0, 1.53, 9.81
UGIMP, APDI = (lambda: mpm.UGIMP(perCell=2)), (lambda: mpm.APDI(size=CELL / 2))
ARRANGEMENTS = {
    "uGIMP below": [(UGIMP, (0, 0), (WIDTH, 5)), (APDI, (0, 5), (WIDTH, HEIGHT))],
    "APDI below": [(APDI, (0, 0), (WIDTH, 5)), (UGIMP, (0, 5), (WIDTH, HEIGHT))],
    "side by side": [(APDI, (0, 0), (WIDTH / 2, HEIGHT)), (UGIMP, (WIDTH / 2, 0), (WIDTH, HEIGHT))],
}


def column(parts, damping=0.7):
    """A column made of parts (type, lower, upper) between rollers, on a fixed base."""
    scene = mpm.Scene(lower=(0, 0), upper=(WIDTH, HEIGHT + CELL), cell=CELL)
    soil = mpm.LinearElastic(density=DENSITY, young=16408.4, poisson=0.3002)
    for i, (kind, lower, upper) in enumerate(parts):
        scene.add(f"part {i}", mpm.box(lower, upper), soil, kind())
    scene.engines = chain(gravity=(0, -GRAVITY), damping=damping, roller=("left", "right"), fixed=("bottom",))
    return scene


def verticalStress(scene):
    """Height and vertical stress over rho g H of the particles of a settled column."""
    return (
        np.concatenate([b.position[:, 1] for b in scene.bodies]),
        np.concatenate([b.stress[:, 1, 1] for b in scene.bodies]) / (DENSITY * GRAVITY * HEIGHT),
    )


def settled(parts):
    scene = column(parts)
    scene.settle(tolerance=1e-4)
    return verticalStress(scene)


@pytest.fixture(scope="module")
def reference():
    """Profile of the all-uGIMP column: height -> vertical stress over rho g H."""
    y, stress = settled([(UGIMP, (0, 0), (WIDTH, HEIGHT))])
    order = np.argsort(y, kind="stable")
    assert stress[order[0]] == pytest.approx(-1, abs=0.03)
    return lambda at: np.interp(at, y[order], stress[order])


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
@pytest.mark.verifies(
    "Column of uGIMP and APDI at rest: stress over that of the base",
    reference="column of uGIMP",
    tolerance=0.007,
)
def test_stress_is_that_of_ugimp(arrangement, reference, verified):
    y, stress = settled(ARRANGEMENTS[arrangement])
    difference = stress - reference(y)
    verified(difference, 0, scale=1)
    assert np.sqrt((difference**2).mean()) < 0.0053


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_mass_and_momentum_balance(arrangement):
    """While the column swings: in every step the momentum changes by dt (weight + reactions)."""
    scene = column(ARRANGEMENTS[arrangement], damping=0.0)
    mass = sum(b.mass.sum() for b in scene.bodies)
    scene.dt = 0.5 * scene.criticalTimeStep()
    momentum = np.zeros(2)
    for _ in range(300):
        scene.step()
        before, momentum = momentum, sum((b.mass[:, None] * b.velocity).sum(axis=0) for b in scene.bodies)
        force = np.array([0, -mass * GRAVITY]) + sum(c.reaction for c in scene.constraints)
        assert abs(momentum - before - scene.dt * force).max() < 1e-12 * mass * GRAVITY
        assert scene._core.nodalTotals()["mass"] == pytest.approx(mass, rel=1e-14)
    assert abs(sum(c.reaction for c in scene.constraints)[1]) > 0.1 * mass * GRAVITY


def test_control_an_interface_that_is_too_coarse_falsifies_the_stress(reference, monkeypatch):
    coarse = [(lambda: mpm.APDI(size=2 * CELL), (0, 0), (WIDTH, 5)), (UGIMP, (0, 5), (WIDTH, HEIGHT))]
    with pytest.raises(ValueError, match="interface"):
        column(coarse).run(steps=1, progress=False)
    monkeypatch.setattr(stepper, "checkInterface", lambda scene, longest: None)
    monkeypatch.setattr(policy, "checkInterface", lambda scene, longest: None)
    scene = column(coarse)
    scene.run(steps=2000, progress=False)
    y, stress = verticalStress(scene)
    assert abs(stress - reference(y)).max() > 0.1
