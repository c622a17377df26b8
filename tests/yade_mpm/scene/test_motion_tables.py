# SPDX-License-Identifier: GPL-2.0-or-later
"""Prescribed velocities that are functions of time or tables: path, restart, description, errors."""

import contextlib
import io

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused

STEEL = dict(density=7.8, young=2.1e6, poisson=0.3)


def block(scene, lower):
    return scene.add("block", mpm.box(lower, (lower[0] + 1, lower[1] + 1)), mpm.LinearElastic(**STEEL))


def testAVelocityMayBeAFunctionOfTime(tmp_path):
    """Half a period of a sine comes back to where it began; a restart goes on with the same bits."""

    def speed(t):
        return None, 0.5 * np.sin(2 * np.pi * t)

    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    body = block(scene, lower=(1, 1))
    press = scene.drive(body, velocity=speed)
    with pytest.raises(ValueError, match="'block' moves by a function of time"):
        scene.settle()
    scene.run(until=0.5, progress=False)
    assert body.displacement[:, 1].mean() == pytest.approx(0.5 / np.pi, rel=0.01)
    assert press.velocity[1] == pytest.approx(0, abs=1e-6) and press.velocity[0] is None
    scene.save(tmp_path / "half.h5")
    again = mpm.load(tmp_path / "half.h5", callbacks={"block.velocity": mpm.engine.Steering("block", speed)})
    for one in (scene, again):
        one.run(until=1.0, progress=False)
    np.testing.assert_array_equal(scene["block"].byId("position"), again["block"].byId("position"))
    assert abs(body.displacement[:, 1].mean()) < 2e-3


TABLE = [(0, None, 0), (0.1, None, 1), (0.25, None, -0.5), (0.4, None, 0)]


@pytest.mark.parametrize("dt", [0.0007, 0.00053])
@pytest.mark.parametrize("isHold", [False, True])
def testAVelocityMayBeATableWhoseIntegralIsThePath(dt, isHold, tmp_path):
    """To round-off whatever the steps; a restart knows the table, and goes on with the same bits."""
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    body = block(scene, lower=(1, 1))
    what = mpm.box((0.5, 0.5), (2.5, 2.5)) if isHold else body
    press = scene.drive(what, velocity=TABLE, name="press")
    with pytest.raises(ValueError, match="'press' moves by a table"):
        scene.settle()
    scene.dt = dt
    scene.run(steps=20, progress=False)
    scene.save(tmp_path / "part.h5")
    again = mpm.load(tmp_path / "part.h5")
    for one in (scene, again):
        one.run(until=0.402, progress=False)
    np.testing.assert_array_equal(body.byId("position"), again["block"].byId("position"))
    time, _, speed = np.array(TABLE, float).T
    assert body.displacement[:, 1] == pytest.approx(np.trapz(speed, time), abs=1e-12)
    assert press.velocity == (None, 0)


def testAVelocityGivenBesideATableIsRefused(tmp_path):
    """It was replaced in silence; without its motion the table ended the run by a bare StopIteration."""
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    body = block(scene, lower=(1, 1))
    scene.drive(body, velocity=TABLE, name="press")
    scene.dt = 5e-4
    scene.run(steps=40, progress=False)
    scene.save(tmp_path / "part.h5")
    again = mpm.load(tmp_path / "part.h5")
    for one in (scene, again):
        one.drives["press"].velocity = (None, 0)
        with pytest.raises(ValueError, match="'press' was given .None, 0.0. m/s, and moves by a table"):
            one.run(steps=1, progress=False)
    before = body.position.copy()
    scene.engines.remove(scene.engines[0])
    scene.run(steps=10, progress=False)
    assert body.position == pytest.approx(before)
    solver = next(e for e in again.engines if type(e).__name__ == "GridSolver")
    solver.drives.clear()
    with pytest.raises(
        ValueError, match="'press' is no drive or hold of the scene any more; take the engine"
    ):
        again.run(steps=1, progress=False)
    with pytest.warns(UserWarning, match="table of 'late' ends at 0.01 s, and the scene's time is 0.025 s"):
        scene.drive(body, velocity=[(0, 0, 1), (0.01, 0, 0)], name="late")


def testDescribeTellsATable():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    scene.drive(block(scene, lower=(1, 1)), velocity=TABLE, name="press")
    said = {False: io.StringIO(), True: io.StringIO()}
    for isLong, text in said.items():
        with contextlib.redirect_stdout(text):
            scene.describe(long=isLong)
    assert "by a table of 4 rows" in said[False].getvalue()
    names = {}
    exec(said[True].getvalue(), names)
    for one in (scene, names["scene"]):
        one.run(steps=20, progress=False)
    np.testing.assert_array_equal(scene["block"].position, names["scene"]["block"].position)


def testAFunctionWithTimesIsATable():
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    body = block(scene, lower=(1, 1))
    scene.drive(body, velocity=lambda t: (0.2 * t, 0), times=[0, 1, 2])
    scene.dt = 2e-3
    scene.run(until=0.5, progress=False)
    assert body.displacement[:, 0] == pytest.approx(0.1 * scene.time**2, rel=1e-9)


def driven(velocity, **options):
    scene = mpm.Scene((0, 0), (3, 3), cell=0.25, threads=1)
    return scene.drive(block(scene, lower=(1, 1)), velocity, **options)


@cases(
    ("drive: velocity = ... give 2 number(s), or rows of the time", lambda: driven([(0, 0), (1, 1)])),
    ("drive: velocity = ... give 2 number(s), or rows of the time", lambda: driven([(0, 0, 0), (1, 1)])),
    ("drive: velocity: times do not grow", lambda: driven([(1, 0, 0), (0, 1, 0)])),
    ("drive: velocity: row 1 = ... is not finite", lambda: driven([(0, 0, 0), (1, None, 0)])),
    ("drive: ramp = 0.1 beside a table of the velocity", lambda: driven(TABLE, ramp=0.1)),
    ("drive: times are given, and velocity is no function", lambda: driven((0, 1), times=[0, 1])),
)
def testWhatIsRefusedOfATable(named, make, kind):
    refused(named, make, kind)
