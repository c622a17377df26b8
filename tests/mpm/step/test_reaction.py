# SPDX-License-Identifier: GPL-2.0-or-later
"""What a drive exerts on a body at rest balances its body forces, in force and moment, component by
component."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, soft
from yade_mpm import box


@pytest.mark.parametrize("kind", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.1)], ids=["ugimp", "apdi"])
@pytest.mark.parametrize("dim", [2, 3])
def test_force_and_moment_of_a_drive_balance_body_forces(dim, kind):
    scene = mpm.Scene((0,) * dim, (2,) * dim, 0.2, threads=1)
    body = scene.add("block", box((0.4,) * dim, (0.8, 1.2, 1.0)[:dim]), soft(2), kind)
    drive = mpm.Drive(body, velocity=(0,) * dim)
    scene.engines = chain(gravity=(0,) * dim, drive=drive)
    arm = body.position - (body.mass @ body.position) / body.mass.sum()
    body.bodyForce[:] = 3.0 + arm @ np.random.default_rng(dim).uniform(-5, 5, (dim, dim))
    force = -body.mass[:, None] * body.bodyForce
    padded = [np.pad(v, ((0, 0), (0, 3 - dim))) for v in (arm, force)]
    moment = np.cross(*padded).sum(axis=0)
    scene.dt = 1e-4
    scene.run(steps=1, progress=False)
    assert np.abs(moment[2 if dim == 2 else slice(None)]).min() > 0.01
    assert np.allclose(drive.reaction, force.sum(axis=0), rtol=1e-12)
    assert np.allclose(np.atleast_1d(drive.moment), moment if dim == 3 else moment[2], rtol=1e-10)
