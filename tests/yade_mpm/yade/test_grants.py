# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps that a host takes by itself, through the table that its plugin gets; no YADE is needed."""

import ctypes

import numpy as np
import pytest
from hybrid import bits, hybrid
from yade_mpm import _core

DT = 2.0**-13  # s: sums of it are exact
STAGES = 5  # with VelocityRemap


class Moment(ctypes.Structure):
    _fields_ = ("number", ctypes.c_long), ("time", ctypes.c_double), ("dt", ctypes.c_double)


ACT = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.c_int, ctypes.POINTER(Moment))
HOLD = ctypes.CFUNCTYPE(None, ctypes.c_void_p)


class Table(ctypes.Structure):
    _fields_ = (
        ("version", ctypes.c_int),
        ("self", ctypes.c_void_p),
        ("act", ACT),
        ("hold", HOLD),
        ("free", HOLD),
    )


class Host:
    """A loop as YADE's."""

    def __init__(self, scene):
        scene.prepare()
        scene.stepper.dt = DT
        self.scene, self.number = scene, 0
        self.steps = _core.grantedSteps(scene._core)
        self.table = Table.from_address(self.steps.address)

    def grant(self, steps=10, next=None, dt=DT, lastStage=STAGES - 1, seconds=60.0, revocations=None):
        known = self.steps.revocations if revocations is None else revocations
        next = self.number if next is None else next
        self.steps.grant(steps, next, dt, 0.0, 1, lastStage, seconds, known)

    def act(self, stage, time=None):
        moment = Moment(self.number, self.scene.time if time is None else time, DT)
        return self.table.act(self.table.self, stage, ctypes.byref(moment))

    def step(self):
        """Whether a step was taken, stage by stage."""
        time = self.scene.time
        taken = [self.act(stage, time) for stage in range(STAGES)]
        assert len(set(taken)) == 1
        self.number += taken[0]
        return taken[0]


@pytest.fixture
def host():
    return Host(hybrid(dt=DT))


def test_granted_steps_are_steps(host):
    own = hybrid(dt=DT)
    own.run(steps=5)
    host.grant(steps=5)
    assert [host.step() for _ in range(6)] == [True] * 5 + [False]
    assert bits(host.scene) == bits(own)
    assert host.steps.lastStep == 4 and host.steps.end == host.scene.time == 5 * DT


def test_a_step_as_a_whole(host):
    own = hybrid(dt=DT)
    own.run(steps=3)
    host.grant(lastStage=-1)
    for host.number in range(3):
        assert host.act(-1)
    assert bits(host.scene) == bits(own)


def test_a_step_that_is_not_as_it_was_granted_is_not_taken(host):
    for other in (dict(steps=0), dict(next=3), dict(dt=2 * DT), dict(seconds=0.0), dict(revocations=-1)):
        host.grant(**other)
        assert not host.step(), other
        host.steps.revoke()
    host.grant()
    assert not host.act(0, time=DT)  # the clocks differ
    host.steps.revoke()
    assert not host.step()
    host.grant()
    assert host.step()  # control


def test_a_step_that_has_begun_is_finished(host):
    host.grant()
    assert host.act(0, 0.0) and host.steps.isOpen
    host.steps.revoke()
    assert all(host.act(stage, 0.0) for stage in range(1, STAGES))
    assert host.scene.steps == 1 and not host.steps.isOpen
    host.number = 1
    assert not host.step()


def test_a_step_whose_last_stage_was_switched_off_ends_with_the_next_one(host):
    host.grant()
    for stage in range(STAGES - 1):
        host.act(stage, 0.0)
    host.number = 1
    assert host.act(0, DT) and host.scene.steps == 1


def test_an_error_is_kept_and_ends_the_grant(host):
    host.scene.bodies[0].velocity[:] = np.array((0.0, 1e9))
    host.grant()
    while host.act(0):  # until particles are out of the grid
        assert all(host.act(stage, host.scene.time) for stage in range(1, STAGES - 1)) and host.number < 9
        host.act(STAGES - 1, host.scene.time)
        host.number += 1
    with pytest.raises((RuntimeError, ValueError)):
        host.steps.throwError()
    host.steps.throwError()  # once


def test_whoever_holds_the_table_keeps_the_steps(host):
    host.table.hold(host.table.self)
    table, scene = host.table, host.scene
    host.steps = None
    moment = Moment(0, 0.0, DT)
    assert not table.act(table.self, 0, ctypes.byref(moment)) and scene.steps == 0
    table.free(table.self)


def moduli(body):
    """Bulk and shear modulus, kPa."""
    lame, mu = body.material.lameConstants
    return np.array([lame + 2 / 3 * mu, mu])


def growthTo(factor, scene, count=1e9):
    """Limits at which bodies are stiffer by a factor, or have more particles than a number."""
    return [(*map(float, factor * moduli(body)), count) for body in scene.bodies]


def test_growth_is_looked_at_in_granted_steps(host):
    """Every `period` steps; the one before which a body has passed its limit is not taken."""
    host.grant(steps=100)
    host.steps.lookAtGrowth(2, 3, growthTo(1.25, host.scene))
    assert all(host.step() for _ in range(2)) and host.steps.nextLook == 2
    assert host.step() and host.steps.nextLook == 3
    assert host.step() and host.steps.nextLook == 6
    assert host.step() and host.step()
    soil = host.scene.bodies[0]
    soil.volume[0] = 1.3 * soil.initialVolume[0]
    assert not host.step() and host.steps.nextLook == 6
    host.steps.lookAtGrowth(6, 3, growthTo(1.4, host.scene))
    assert host.step() and host.steps.nextLook == 9
    host.steps.lookAtGrowth(7, 3, growthTo(2.0, host.scene, 1.0))
    assert not host.step()  # more particles than that


def test_limits_of_growth_are_those_of_python():
    scene = hybrid(dt=DT)
    scene.prepare()
    limits = scene.stepper.growthLimits()
    assert len(limits) == len(scene.bodies)
    for body, (*most, count) in zip(scene.bodies, limits):
        assert count == pytest.approx(1.25 * body.count)
        volume = body.volume.copy()
        room = (most / moduli(body)).min() * (body.initialVolume / body.volume).min()
        body.volume[:] = volume * room * (1 - 1e-6)
        assert scene.stepper.stiffening() < 1.25
        body.volume[:] = volume * room * (1 + 1e-6)
        assert scene.stepper.stiffening() >= 1.25
        body.volume[:] = volume
