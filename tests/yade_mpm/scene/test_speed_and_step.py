# SPDX-License-Identifier: GPL-2.0-or-later
"""The automatic step follows the speed: nothing moves more than 0.2 of a cell in it."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import SOFT_CLAY, chain
from yade_mpm import box
from yade_mpm.check import limits

CELL = 0.5


def flying(type_=None, young=300.0, speed=20.0):
    """A soft block above a floor, of 0.67 of its wave speed by default."""
    scene = mpm.Scene((0, 0), (6, 24), CELL, threads=1)
    soft = mpm.LinearElastic(density=1.8, young=young, poisson=0.3)
    block = scene.add("block", box((2, 3), (4, 5)), soft, type_ or mpm.UGIMP())
    block.velocity[:, 1] = -speed
    scene.engines[1] = mpm.GridSolver(fixed="bottom", roller=("left", "right"))
    return scene, block


def largestGain(scene, until=0.5):
    """The largest kinetic energy from the impact on over that at the start."""
    first, most = mpm.diagnostics.kineticEnergy(scene), 0.0
    for end in np.arange(0.2, until + 0.01, 0.05):
        scene.run(until=end, progress=False)
        most = max(most, mpm.diagnostics.kineticEnergy(scene) / first)
    return most


@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("type_", [mpm.UGIMP(), mpm.APDI()])
def test_an_impact_makes_no_energy(monkeypatch, type_, share):
    """At half and twice the bound, too."""
    monkeypatch.setattr(limits, "DT_CELLS", share * limits.DT_CELLS)
    assert largestGain(flying(type_)[0]) < 1


def test_without_the_bound_an_impact_makes_energy(monkeypatch):
    """The control."""
    monkeypatch.setattr(limits, "DT_CELLS", 100)
    assert largestGain(flying(mpm.APDI(), young=1000.0, speed=40.0)[0], until=0.3) > 1.05


def test_the_step_is_that_of_the_speed_or_of_the_stiffness():
    scene, block = flying()
    scene.prepare()
    assert scene.dt == pytest.approx(0.2 * CELL / 20)
    assert scene.dt == scene.dtSpeed < 0.8 * scene.dtCritical
    slow, _ = flying(speed=1.0)
    slow.prepare()
    assert slow.dt == pytest.approx(min(0.8 * slow.dtCritical, 0.65 * slow.dtStable))
    assert slow.dt < slow.dtSpeed
    block.velocity[...] = 0
    assert scene.dtSpeed == np.inf
    scene.run(steps=100, progress=False)
    assert scene.dt == pytest.approx(slow.dt, rel=0.05)


def test_a_drive_counts_before_it_moves_anything():
    scene, block = flying(speed=0.0)
    drive = mpm.Drive(block.above(4.5), velocity=(0, -40), ramp=1.0)
    scene.engines[1] = mpm.GridSolver(drive=drive)
    scene.prepare()
    assert scene.dt == pytest.approx(0.2 * CELL / 40)


def test_a_loop_of_steps_and_a_restart_give_the_same_bits(tmp_path, monkeypatch):
    """While the step becomes shorter as the block falls."""

    monkeypatch.setattr(limits, "DT_LOOK", 5)

    def falling():
        scene, _ = flying(speed=5.0)
        scene.engines[1] = mpm.GridSolver(gravity=(0, -50.0), fixed="bottom", roller=("left", "right"))
        return scene

    whole, stepped, saved = falling(), falling(), falling()
    whole.run(steps=1, progress=False)
    first = whole.dt
    whole.run(steps=29, progress=False)
    assert whole.dt < 0.8 * first
    for _ in range(30):
        stepped.step()
    saved.run(steps=17, progress=False)
    saved.save(tmp_path / "state.h5")
    loaded = mpm.load(tmp_path / "state.h5")
    loaded.run(steps=13, progress=False)
    for scene in (stepped, loaded):
        assert scene.time == whole.time
        assert scene["block"].position.tobytes() == whole["block"].position.tobytes()


def test_the_step_follows_an_impact_that_stiffens_the_law():
    """The stiffness of Cam-Clay follows the pressure, and ten steps of an impact make it thirtyfold."""
    clay = mpm.ModifiedCamClay(density=1.6, poisson=0.3, **SOFT_CLAY)
    scene = mpm.Scene((0, 0), (7, 6), 0.5, scheme="USL", threads=1)
    scene.add("bed", mpm.box((0, 0), (7, 1)), clay, mpm.BSpline(perCell=2))
    block = scene.add("block", mpm.box((3, 1), (4.5, 2.5)), clay, mpm.BSpline(perCell=2))
    block.velocity[...] = (-7.5, -8.0)
    walls = dict(roller=("left", "right"), fixed="bottom")
    scene.engines = chain(gravity=(0.5, -9.0), **walls)
    first = scene.criticalTimeStep()
    scene.run(steps=60, progress=False)
    assert scene.dt < 0.25 * first and np.abs(block.velocity).max() < 11
    assert (block.volume / block.initialVolume).min() > 0.5


def test_a_step_that_is_given_and_far_too_long_is_warned_of():
    scene, _ = flying()
    scene.dt = 0.012
    with pytest.warns(UserWarning, match=r"crosses 0.48 of a cell in a step.*give at most 0.005 s"):
        scene.prepare()
