# SPDX-License-Identifier: GPL-2.0-or-later
"""Random scenes (layouts.py) keep momentum and make no energy, and go on after a restart with the same bits.

- Momentum: nothing acts from outside, so the sum of m v stays, within 1e-11 of the sum of |m v|.
- Energy: kinetic and elastic energy never exceed what was there at the start and what the walls and gravity
  have put in, within 1 % of that. Yield, friction and impacts take energy; the bound leaves room for the
  error of the time step, which falls with its square.
- Restart: every bit.

Twenty scenes of each in every run of the tests, 1000 with --slow.
"""

from dataclasses import replace

import numpy as np
import pytest
import yade_mpm as mpm
from layouts import freeLayout, randomLayout
from setups import restarted

STEPS = 150
MOMENTUM, ENERGY = 1e-11, 0.01
pytestmark = pytest.mark.filterwarnings("ignore:Scene. scheme = 'USF' is first order")
seeds = pytest.mark.parametrize(
    "seeds", [range(20), pytest.param(range(20, 1000), marks=pytest.mark.slow)], ids=["20", "1000"]
)


def momentum(bodies):
    return sum(b.mass @ b.velocity for b in bodies)


@seeds
def test_no_momentum_comes_from_nowhere(seeds):
    for seed in seeds:
        scene, bodies = freeLayout(seed).build()
        start, scale = momentum(bodies), sum(b.mass @ np.abs(b.velocity) for b in bodies).max()
        scene.run(steps=STEPS, progress=False)
        assert np.abs(momentum(bodies) - start).max() <= MOMENTUM * scale, f"seed {seed}"


def gained(layout):
    """Largest energy that neither the start nor the surroundings account for, over the sum of those (0 where
    nothing moves)."""
    scene, _ = layout.build()
    history = mpm.History(iterPeriod=1)
    scene.engines = [*scene.engines, history]
    scene.run(steps=STEPS, progress=False)
    inside = history["kineticEnergy"] + history["internalWork"]
    work = history["externalWork"] - history["externalWork"][0]
    scale = history["kineticEnergy"][0] + np.abs(work).max()
    return (inside - inside[0] - work).max() / max(scale, np.finfo(float).tiny)


@seeds
@pytest.mark.parametrize("make", [freeLayout, randomLayout], ids=["free", "on the floor"])
def test_no_energy_comes_from_nowhere(make, seeds):
    for seed in seeds:
        assert gained(make(seed)) <= ENERGY, f"seed {seed}"


def test_control_too_long_a_step_makes_energy():
    layout = freeLayout(17)
    scene, _ = layout.build()
    scene.allowUnstable = True
    scene.dt = 1.3 * scene.criticalTimeStep()
    history = mpm.History(iterPeriod=1)
    scene.engines = [*scene.engines, history]
    scene.run(steps=STEPS, progress=False)
    inside = history["kineticEnergy"] + history["internalWork"]
    assert inside.max() > (1 + ENERGY) * inside[0]


@seeds
def test_a_restart_changes_no_bit(seeds):
    for seed in seeds:
        scene, _ = randomLayout(seed).build()
        scene.run(steps=20, progress=False)
        restarted(scene, 20)


def test_a_scene_at_rest_without_loads_stays_at_rest():
    for seed in range(20):
        layout = freeLayout(seed)
        still = replace(layout, blocks=tuple(replace(b, velocity=np.zeros(2)) for b in layout.blocks))
        scene, bodies = still.build()
        scene.run(steps=STEPS, progress=False)
        assert max(np.abs(b.velocity).max() for b in bodies) == 0, f"seed {seed}"
