# SPDX-License-Identifier: GPL-2.0-or-later
"""Random scenes (layouts.py) keep momentum and make no energy, and go on after a restart with the same bits.

- Momentum: nothing acts from outside, so the sum of m v stays, within 1e-11 of the sum of |m v|. In rings
  that is so along the axis.
- Energy: kinetic and elastic energy never exceed what was there at the start and what walls, gravity, loads
  and drives have put in, within 1 % of that. Yield, friction and impacts take energy; the bound leaves room
  for the error of the time step, which falls with its square.
- Restart: every bit.

Wide scenes are also by chance planes, rings or space, on equal or growing cells, with a load, with implicit
bodies, and with each choice of F-bar. Twenty scenes of each in every run of the tests, of the wide ones ten;
1000 with --slow.
"""

from dataclasses import replace

import numpy as np
import pytest
import yade_mpm as mpm
from layouts import freeLayout, randomLayout, wideLayout
from setups import elastic, restarted

STEPS = 150
MOMENTUM, ENERGY = 1e-11, 0.01
pytestmark = [
    pytest.mark.filterwarnings("ignore:Scene. scheme = 'USF' is first order"),
    pytest.mark.filterwarnings("ignore:Contact. 'bed' and 'blocks' are boxes on both sides"),
]


def freeWideLayout(seed):
    return wideLayout(seed, free=True)


def every(**makers):
    """Layouts by name: some of each, and with --slow the others of 1000."""
    cases = []
    for name, make in makers.items():
        few = 20 if make in (freeLayout, randomLayout) else 10
        cases.append(pytest.param(make, range(few), id=name))
        cases.append(pytest.param(make, range(few, 1000), id=f"{name}-1000", marks=pytest.mark.slow))
    return pytest.mark.parametrize("make, seeds", cases)


def momentum(bodies):
    return sum(b.mass @ b.velocity for b in bodies)


@every(free=freeLayout, wide=freeWideLayout)
def test_no_momentum_comes_from_nowhere(make, seeds):
    for seed in seeds:
        layout = make(seed)
        scene, bodies = layout.build()
        start, scale = momentum(bodies), sum(b.mass @ np.abs(b.velocity) for b in bodies).max()
        scene.run(steps=STEPS, progress=False)
        change = np.abs(momentum(bodies) - start)[int(layout.rings) :]
        assert change.max() <= MOMENTUM * scale, f"seed {seed}"


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


@every(free=freeLayout, floor=randomLayout, wide=freeWideLayout, wideFloor=wideLayout)
def test_no_energy_comes_from_nowhere(make, seeds):
    for seed in seeds:
        assert gained(make(seed)) <= ENERGY, f"seed {seed}"


def test_work_of_a_load_beside_a_roller_is_known():
    """Particles of a wide kernel reach the images of nodes behind the roller, which have no mass of their
    own: the work was nan."""
    scene = mpm.Scene((0, 0), (4, 4), 0.5, gravity=9.81, threads=1)
    scene.roller("left")
    block = scene.add("block", mpm.box((0, 1), (1, 2)), elastic(2e3), mpm.BSpline(perCell=2))
    scene.attach(mpm.SurfaceLoad(block, (0, 1), pressure=10.0))
    scene.dt = 1e-3
    history = mpm.History(iterPeriod=1)
    scene.engines = [*scene.engines, history]
    scene.run(steps=50, progress=False)
    fallen = 0.5 * (9.81 + 10 / 2) * scene.time**2
    assert history["externalWork"][-1] == pytest.approx((2 * 9.81 + 10) * fallen, rel=0.1)


@pytest.mark.parametrize("scheme", ["MUSL", "USL"])
@pytest.mark.parametrize("law", ["LinearElastic", "NeoHookean"])
def test_fbar_of_a_mesh_that_hits_the_floor_makes_no_energy(law, scheme):
    """A law that takes its stress from F alone sees F-bar, too: it gained 25 %."""
    scene = mpm.Scene((0, 0), (5, 4), 0.5, scheme=scheme, threads=1)
    rubber = getattr(mpm, law)(density=1.6, young=2e3, poisson=0.3)
    block = scene.add("block", mpm.box((1, 0.75), (2.5, 1.75)), rubber, mpm.APDI(size=0.25), fbar=True)
    block.velocity = (1.0, -1.0)
    scene.roller("bottom")
    scene.dt = 4e-4
    history = mpm.History(iterPeriod=1)
    scene.engines = [*scene.engines, history]
    scene.run(steps=1600, progress=False)
    inside = (history["kineticEnergy"] + history["internalWork"]) / history["kineticEnergy"][0]
    assert history["internalWork"].max() > 0.4 * history["kineticEnergy"][0]  # control: it hits
    assert inside.max() <= 1 + ENERGY


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


@every(floor=randomLayout, wide=wideLayout)
def test_a_restart_changes_no_bit(make, seeds):
    for seed in seeds:
        scene, _ = make(seed).build()
        scene.run(steps=20, progress=False)
        restarted(scene, 20)


@every(free=freeLayout, wide=freeWideLayout)
def test_a_scene_at_rest_without_loads_stays_at_rest(make, seeds):
    for seed in seeds:
        layout = make(seed)
        still = replace(layout, blocks=tuple(replace(b, velocity=0 * b.velocity) for b in layout.blocks))
        scene, bodies = still.build()
        scene.run(steps=STEPS, progress=False)
        assert max(np.abs(b.velocity).max() for b in bodies) == 0, f"seed {seed}"
