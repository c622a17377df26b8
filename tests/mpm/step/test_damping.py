# SPDX-License-Identifier: GPL-2.0-or-later
"""Local damping acts on what particles feel (doc/development/decisions/0006).

Two columns of uGIMP boxes beside one line of nodes with shear stress of opposite sign: the nodal forces are
large, but
their accelerations cancel in every particle. The pair moves at a constant velocity; nothing may slow it down.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box

SPEED, SHEAR = -0.1, 25000.0


def lockedPair(shear=SHEAR):
    """Scene with a free pile of two columns, moving down at SPEED under damping 0.5."""
    scene = mpm.Scene(lower=(0, 0), upper=(2, 6), cell=0.25, threads=1)
    steel = mpm.LinearElastic(density=7.85, lame=(4.2e7, 2.8e7))
    pile = scene.add("pile", box((0.875, 2), (1.125, 4)), steel, mpm.UGIMP(perCell=2))
    pile.velocity = (0.0, SPEED)
    stress = np.zeros((pile.count, 3, 3))
    stress[:, 0, 1] = stress[:, 1, 0] = np.where(pile.position[:, 0] < 1, shear, -shear)
    pile.stress = stress
    scene.engines = chain(damping=0.5)
    scene.dt = 1e-6
    return scene, pile


def nodalDrag(scene):
    """What damping of the nodal forces would have been: 0.5 sum |f_y|, kN/m."""
    return 0.5 * np.abs(np.array(scene._core.nodalValues()["force"])[:, 1]).sum()


def test_forces_that_no_particle_feels_do_not_drag():
    """In one step exactly; later the ends, where the stress has no partner, start to swing."""
    scene, pile = lockedPair()
    scene.run(steps=1, progress=False)
    drag = nodalDrag(scene)
    assert drag > 1e4
    assert pile.velocity[:, 1] == pytest.approx(SPEED, rel=1e-9)
    assert drag * scene.dt / pile.mass.sum() > 1e-3 * abs(SPEED)  # what the nodes would have lost


def test_a_body_may_be_left_undamped():
    scene, pile = lockedPair(shear=0.0)
    other = scene.add("other", box((0.25, 2), (0.5, 4)), pile.material, mpm.UGIMP(perCell=2))
    other.velocity, other.isDamped = (0.0, SPEED), False
    scene.engines[1].gravity = (0.0, -9.81)
    scene.run(steps=100, progress=False)
    assert other.velocity[:, 1] - SPEED == pytest.approx(-9.81 * scene.time, rel=1e-9)
    assert pile.velocity[:, 1] - SPEED == pytest.approx(-9.81 * 0.5 * scene.time, rel=1e-9)  # control


def test_control_a_force_that_is_felt_is_damped():
    scene, pile = lockedPair(shear=0.0)
    scene.engines[1].gravity = (0.0, -9.81)
    scene.run(steps=100, progress=False)
    fallen = pile.velocity[:, 1] - SPEED
    assert fallen == pytest.approx(-9.81 * 0.5 * scene.time, rel=1e-9)
    assert scene._core.energies["damping"] > 0
