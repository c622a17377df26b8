# SPDX-License-Identifier: GPL-2.0-or-later
"""What is prescribed is prescribed: particles whose nodes are all held have that velocity, and the impulse is
the change of their momentum."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import restarted
from yade_mpm import box

SOFT = dict(density=2.0, young=1e4, poisson=0.3)
STEEL = mpm.LinearElastic(**SOFT)
CASES = [
    (kind, scheme, flip, implicit)
    for kind in ("boxes", "mesh")
    for scheme in ("MUSL", "USL", "USF")
    for flip in (1.0, 0.5, 0.0)
    for implicit in (False, True)
    if not (implicit and (scheme != "MUSL" or flip < 1))
]


def moved(kind="boxes", scheme="MUSL", flip=1.0, implicit=False, first=0.0, velocity=-0.1, ramp=0.0):
    """Scene, a block of 2 Mg/m without weight, and the drive of all of it, along y alone."""
    scene = mpm.Scene((0, 0), (3, 6), 0.25, threads=1, scheme=scheme)
    type_ = mpm.UGIMP(perCell=2) if kind == "boxes" else mpm.APDI(size=0.25)
    block = scene.add("block", box((1, 3), (2, 4)), STEEL, type_, implicit=implicit)
    block.velocity[:, 1] = first
    drive = mpm.Drive(block, velocity=(None, velocity), ramp=ramp)
    chain = [mpm.ParticleToGrid(), mpm.GridSolver(gravity=(0, 0), drive=drive)]
    chain += [mpm.GridToParticle(flip=flip), mpm.DomainUpdater()]
    if scheme == "USF":
        chain.insert(1, chain.pop())
    scene.engines, scene.dt = chain, 1e-3
    return scene, block, drive


def energy(scene):
    return mpm.diagnostics.kineticEnergy(scene)


@pytest.mark.parametrize("first", [0.0, -0.1, -1.0, 0.3])
@pytest.mark.parametrize("kind, scheme, flip, implicit", CASES)
def test_a_drive_gives_its_velocity_to_what_moves(kind, scheme, flip, implicit, first):
    scene, block, drive = moved(kind, scheme, flip, implicit, first)
    mass, before, high = block.mass.sum(), energy(scene), block.position[:, 1].copy()
    scene.run(steps=1, progress=False)
    assert block.velocity[:, 1] == pytest.approx(-0.1, abs=1e-12)
    scene.run(steps=9, progress=False)
    assert drive.impulse[1] == pytest.approx(mass * (-0.1 - first), abs=1e-12)
    assert drive.work == pytest.approx(energy(scene) - before, abs=1e-12)
    assert np.sort(block.position[:, 1]) == pytest.approx(np.sort(high) - 0.001, abs=1e-12)


@pytest.mark.parametrize("kind, scheme, flip, implicit", CASES)
def test_a_drive_that_changes_takes_its_body_along(kind, scheme, flip, implicit):
    """It moves, moves faster, stops, and ends."""
    scene, block, drive = moved(kind, scheme, flip, implicit)
    mass, speed = block.mass.sum(), 0.0
    for velocity in (-0.1, -0.2, 0.0):
        drive.velocity = (None, velocity)
        impulse, work, before = drive.impulse[1], drive.work, energy(scene)
        scene.run(steps=20, progress=False)
        assert block.velocity[:, 1] == pytest.approx(velocity, abs=1e-12)
        assert drive.impulse[1] - impulse == pytest.approx(mass * (velocity - speed), abs=1e-12)
        assert drive.work - work == pytest.approx(energy(scene) - before, abs=1e-12)
        speed = velocity
    drive.velocity = (None, None)
    rested = block.position[:, 1].copy()
    scene.run(steps=100, progress=False)
    assert np.abs(block.position[:, 1] - rested).max() < 1e-12


def test_a_drive_that_starts_slowly_catches_what_flies():
    scene, block, drive = moved(first=-1.0, ramp=0.02)
    scene.run(steps=1, progress=False)
    assert block.velocity[:, 1] == pytest.approx(-0.1 / 20, abs=1e-12)
    scene.run(steps=50, progress=False)
    assert drive.impulse[1] == pytest.approx(1.8, abs=1e-12)
    assert drive.work == pytest.approx(-0.99, abs=1e-12)


def test_a_hold_that_moves_along_gives_nothing():
    scene, block, _ = moved(first=-0.1)
    hold = mpm.Hold(box((0, 0), (3, 6)), velocity=(0, -0.1))
    scene.engines[1] = mpm.GridSolver(gravity=(0, 0), hold=hold)
    before = energy(scene)
    scene.run(steps=5, progress=False)
    assert energy(scene) == pytest.approx(before, abs=1e-12)
    assert np.abs(hold.impulse).max() < 1e-12
    assert hold.work == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("flip", [1.0, 0.9, 0.5])
def test_impulses_are_the_change_of_momentum(flip):
    """Of a soft block whose top is driven at once: with the share of the nodal velocity that flip leaves."""
    scene, block, _ = moved(flip=flip, first=0.2)
    drive = mpm.Drive(block.above(3.6), velocity=(0.1, -0.3))
    scene.engines[1] = mpm.GridSolver(gravity=(0, 0), drive=drive)
    before = mpm.diagnostics.momentum(scene)
    scene.run(steps=40, progress=False)
    assert drive.impulse == pytest.approx(mpm.diagnostics.momentum(scene) - before, abs=1e-12)


@pytest.mark.parametrize("flip", [1.0, 0.9, 0.5])
def test_a_floor_takes_the_momentum_of_what_falls_on_it(flip):
    scene = mpm.Scene((0, 0), (3, 3), 0.25, threads=1)
    block = scene.add("block", box((1, 0.125), (2, 1.125)), STEEL, mpm.UGIMP(perCell=2))
    block.velocity[...] = (0.1, -0.5)
    scene.engines[1] = mpm.GridSolver(gravity=(0, 0), fixed="bottom")
    scene.engines[2] = mpm.GridToParticle(flip=flip)
    scene.dt, before = 1e-3, mpm.diagnostics.momentum(scene)
    scene.run(steps=60, progress=False)
    floor = scene.constraints[0]
    assert floor.impulse == pytest.approx(mpm.diagnostics.momentum(scene) - before, abs=1e-12)
    assert floor.work == 0


@pytest.mark.parametrize("loss", [1.0, 0.0])
@pytest.mark.parametrize("flip", [1.0, 0.95, 0.5, 0.0])
@pytest.mark.parametrize("scheme", ["MUSL", "USL"])
def test_a_plate_that_is_held_takes_the_momentum_of_what_falls_on_it(scheme, flip, loss):
    """By contact: the share of an impact that flip leaves is a part of the impulse, too."""
    scene = mpm.Scene((0, 0), (4, 4), 0.25, threads=1, scheme=scheme)
    plate = scene.add("plate", box((1, 0), (3, 0.5)), STEEL, mpm.UGIMP(perCell=2), group="plate")
    block = scene.add("block", box((1.5, 0.75), (2.5, 1.5)), STEEL, mpm.APDI(size=0.125))
    block.velocity[:, 1] = -2
    drive = mpm.Drive(plate, velocity=(0, 0))
    chain = [mpm.ParticleToGrid(), mpm.GridSolver(drive=drive), mpm.Contact(impactLoss=loss)]
    scene.engines = [*chain, mpm.GridToParticle(flip=flip), mpm.DomainUpdater()]
    scene.dt, before = 1e-3, mpm.diagnostics.momentum(scene)
    scene.run(steps=200, progress=False)
    assert block.velocity[:, 1].mean() > 0.5  # it did bounce
    assert scene.constraints[-1].impulse == pytest.approx(mpm.diagnostics.momentum(scene) - before, abs=1e-11)


def test_a_run_goes_on_from_a_file_with_the_same_bits():
    """Though the drive has just got another velocity."""
    scene, _, drive = moved(first=-0.3)
    scene.run(steps=20, progress=False)
    drive.velocity = (None, 0.05)
    assert restarted(scene, 20).constraints[-1].work == scene.constraints[-1].work
