# SPDX-License-Identifier: GPL-2.0-or-later
"""D27: a closed box of weightless clay, stirred. Nothing can leave it, so the sum of the volumes and the mean
pressure stay, whatever flows inside (doc/explanation/volumes.md)."""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

SIZE, PRESSURE = 4.0, 200.0  # m, kPa
STRENGTH, SHEAR, POISSON = 10.0, 1000.0, 0.49  # kPa, kPa, -
STIR, REACH = 200.0, 0.5  # of the body force: 1/s2, m2


def stirred(cell, fbar=True, scheme="MUSL", dt=None, dim=2):
    """The box and its body before the first step; in 3D a slab of one cell, stirred in its plane."""
    size = [SIZE, SIZE, cell][:dim]
    scene = mpm.Scene((0,) * dim, size, cell)
    scene.scheme = scheme
    clay = mpm.MohrCoulombDruckerPrager(
        density=1.5,
        young=2 * SHEAR * (1 + POISSON),
        poisson=POISSON,
        cohesion=STRENGTH,
        frictionAngle=0,
        dilatancyAngle=0,
    )
    body = scene.add("clay", box((0,) * dim, size), clay, mpm.UGIMP(perCell=2), fbar=fbar)
    body.stress = -PRESSURE * np.eye(3)

    def stir():
        x, y = (body.position[:, :2] - SIZE / 2).T
        force = STIR * np.exp(-(x**2 + y**2) / REACH)
        body.bodyForce[:, 0], body.bodyForce[:, 1] = -force * y, force * x

    walls = ("left", "right", "bottom", "top", "front", "back")[: 2 * dim]
    scene.engines = [
        mpm.PyRunner(stir, iterPeriod=5),
        mpm.ParticleToGrid(),
        mpm.GridSolver(roller=walls),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    if dt:
        scene.dt = dt
    return scene, body


def measured(body, dim=2):
    """Mean pressure over its start, sum of volumes over that of the box less one, V/V0 of 99 %, largest
    displacement."""
    volume, pressure = body.volume, -np.trace(body.stress, axis1=1, axis2=2) / 3
    ratio = volume / body.initialVolume
    return (
        np.average(pressure, weights=volume) / PRESSURE,
        volume.sum() / body.initialVolume.sum() - 1,
        np.quantile(ratio, [0.005, 0.995]),
        np.linalg.norm(body.displacement, axis=1).max(),
    )


def stays(scene, body, until, moved, pressure, volume, ratio):
    """Runs and sees that pressure, the sum of the volumes and V/V0 stay within these shares, and particles
    move further than `moved`, m."""
    scene.run(until=until, progress=False)
    found, growth, extremes, displacement = measured(body)
    assert displacement > moved
    assert found == pytest.approx(1, abs=pressure)
    assert abs(growth) < volume
    assert np.abs(extremes - 1).max() < ratio


@pytest.mark.parametrize("scheme", ["MUSL", "USF", "USL"])
def test_volume_and_pressure_stay(scheme):
    scene, body = stirred(0.2, scheme=scheme)
    stays(scene, body, 0.3, moved=1, pressure=0.01, volume=5e-5, ratio=0.01)
    assert mpm.diagnostics.volumeRatio(scene) == pytest.approx(1, abs=0.02)


def test_control_without_fbar_pressure_is_lost():
    scene, body = stirred(0.2, fbar=False)
    scene.run(until=0.3, progress=False)
    pressure, growth, extremes, _ = measured(body)
    assert pressure < 0.97 and growth > 1e-4 and np.abs(extremes - 1).max() > 0.01


def test_volume_and_pressure_stay_in_space():
    stays(*stirred(0.2, dim=3), 0.3, moved=0.8, pressure=0.02, volume=1e-4, ratio=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("cell, dt", [(0.2, None), (0.1, 3e-4), (0.1, None)])
def test_twice_as_far(cell, dt):
    """1.9 m: the core turns at 20 m/s then."""
    stays(*stirred(cell, dt=dt), 0.6, moved=1.8, pressure=0.08, volume=3e-4, ratio=0.03)
