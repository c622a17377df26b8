# SPDX-License-Identifier: GPL-2.0-or-later
"""The elastic operator behind the critical step has memory of its own: an estimate leaves the rates of the
last step."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import soft
from yade_mpm import box


def moving(dim):
    scene = mpm.Scene((0,) * dim, (2,) * dim, 0.25, threads=1)
    elastic = soft(2)
    mesh = scene.add("mesh", box((0.5,) * dim, (1.5,) * (dim - 1) + (1.0,)), elastic, mpm.APDI(size=0.25))
    boxes = scene.add("boxes", box((0.5,) * (dim - 1) + (1.0,), (1.5,) * dim), elastic, mpm.UGIMP())
    mesh.velocity, boxes.velocity = np.arange(dim) - 0.5, 0.5 - np.arange(dim)
    scene.run(steps=20, progress=False)
    return scene


@pytest.mark.parametrize("dim", [2, 3])
def test_an_estimate_leaves_the_rates_of_the_last_step_in_their_memory(dim):
    scene = moving(dim)
    vertices = np.asarray(scene["mesh"]._core.view("vertexVelocity", True))
    fields = [b.velocityGradient for b in scene.bodies] + [vertices]
    before = [field.copy() for field in fields]
    assert all(np.abs(field).max() > 0 for field in before)
    scene.criticalTimeStep()
    assert all(np.array_equal(now, then) for now, then in zip(fields, before))


def test_an_estimate_does_not_change_the_run():
    states = []
    for estimates in (False, True):
        scene = moving(2)
        scene.dt = 0.5 * scene.dt
        for _ in range(10):
            scene.run(steps=1, progress=False)
            if estimates:
                scene.criticalTimeStep()
        states.append(b"".join(b.position.tobytes() + b.stress.tobytes() for b in scene.bodies))
    assert states[0] == states[1]
