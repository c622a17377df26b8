# SPDX-License-Identifier: GPL-2.0-or-later
"""Soil that is squeezed between rigid walls loses strength by motion of its particles that the nodes do not
see (doc/explanation/rigid-contact.md, limits): the diagnostics tell it."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm import box, rigid

SIDE = 0.4  # m


def squeezed(dim, material, kind):
    """A block between two walls along each axis that touch it: scene, body, contact."""
    scene = mpm.Scene((0,) * dim, (1,) * dim, 0.1, threads=1)
    body = scene.add("soil", box((0.3,) * dim, (0.7,) * dim), material, kind(perCell=2))
    contact = mpm.RigidContact()
    for axis in range(dim):
        for sign in (-1, 1):
            half, place = np.full(dim, SIDE), np.full(dim, 0.5)
            half[axis], place[axis] = 0.05, place[axis] + sign * (SIDE / 2 + 0.05)
            contact.addBody(rigid.Box(tuple(half)), position=tuple(place))
    return scene, body, contact


def squeeze(dim, until, kind, rate=0.02, lateral=20.0):
    """Presses along the last axis, with a slow servo that keeps the pressure along the others: stress of the
    soil (dim,), kPa, and the part of the work that nodes do not see."""
    soil = mpm.MohrCoulombDruckerPrager(
        density=2.0, young=1e4, poisson=0.3, cohesion=2.0, frictionAngle=radians(30), dilatancyAngle=0.0
    )
    scene, body, contact = squeezed(dim, soil, kind)
    scene.dt = 3e-4
    scene.engines = chain(contact, damping=0.1)
    place, turn = contact.positions.copy(), contact.orientations.copy()
    sign = np.tile([-1.0, 1.0], dim)
    rows, axes = np.arange(2 * dim), np.repeat(np.arange(dim), 2)
    while scene.time < until:
        sides = place[rows, axes].reshape(dim, 2) @ [-1, 1] - 0.1
        pressure = sign * contact.forces[rows, axes] * sides[axes] / sides.prod()
        speed = np.clip(2e-3 * (lateral * min(1, scene.time / 0.1) - pressure), -0.2, 0.2)
        if scene.time >= 0.3:
            speed[-2:] = rate
        velocity = np.zeros_like(place)
        velocity[rows, axes] = -sign * speed
        contact.setStates(place, turn, velocity, np.zeros_like(place))
        scene.step()
        place += scene.dt * velocity
    unseen = mpm.diagnostics.unseenEnergy(scene) / mpm.diagnostics.workDone(scene)
    return -np.diagonal(body.stress.mean(axis=0))[:dim], unseen


@pytest.mark.parametrize("dim, kind", [(3, mpm.UGIMP), (2, mpm.BSpline)])
def test_motion_that_nodes_do_not_see_is_told(dim, kind):
    """Boxes lose a sixth of the strength by Mohr-Coulomb at 6.5 % of strain, B-spline particles more: both
    are beyond the limit of `quasiStatic`, 1 %."""
    stress, unseen = squeeze(dim, 0.95, kind)
    Kp = np.tan(np.pi / 4 + radians(15)) ** 2
    strength = stress[:-1].mean() * Kp + 2 * 2.0 * np.sqrt(Kp)
    assert stress[-1] < 0.95 * strength and unseen > 0.01
