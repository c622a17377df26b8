# SPDX-License-Identifier: GPL-2.0-or-later
"""Rigid bodies on ground, for tests of RigidContact."""

import numpy as np
import yade_mpm as mpm
from setups import chain, elastic
from yade_mpm import box, rigid

KINDS = ["UGIMP", "APDI"]


def typeOf(kind, cell):
    return mpm.UGIMP(perCell=2) if kind == "UGIMP" else mpm.APDI(size=cell / 2)


class Free:
    """Integrates one rigid body by the leap-frog rule; `load` kN, `drag` 1/s against the vertical motion."""

    def __init__(self, contact, mass, inertia=np.inf, load=(0, 0, 0), drag=0.0):
        self.contact, self.mass, self.inertia, self.load, self.drag = (
            contact,
            mass,
            inertia,
            np.array(load, float),
            drag,
        )
        self.x, self.q = contact.positions.copy(), contact.orientations.copy()
        self.v, self.w = contact.velocities.copy(), contact.angularVelocities.copy()
        self.isHeldBack, self.isDeaf, self.log = False, False, []

    def __call__(self, scene):
        force = (0 if self.isDeaf else self.contact.forces[0]) + self.load
        self.v[0] += force / self.mass * scene.dt
        self.v[0, 1] /= 1 + self.drag * scene.dt
        if self.isHeldBack:
            self.v[0, 0] = 0
        else:
            self.w[0] += self.contact.torques[0] / self.inertia * scene.dt
        self.x += self.v * scene.dt
        self.contact.setStates(self.x, self.q, self.v, self.w)
        self.log.append((scene.time, *self.v[0], *self.w[0], *self.contact.forces[0]))

    def acceleration(self, first, column=1):
        """Slope of the velocity along x, or of the spin (column 6), since entry `first`, the first fifth
        left out."""
        rows = np.array(self.log[first:])
        rows = rows[len(rows) // 5 :]
        return np.polyfit(rows[:, 0], rows[:, column], 1)[0]


def thrown(kind, dim, threads=1, friction=0.4, **attributes):
    """A sphere thrown at an angle onto a free block: scene, contact, block, and what moves the sphere."""
    cell = 0.1 if dim == 2 else 0.2
    scene = mpm.Scene((0,) * dim, (2,) * dim, cell, threads=threads)
    block = scene.add(
        "block", box((0.4,) * dim, (1.6,) * (dim - 1) + (1.0,)), elastic(1e4), typeOf(kind, cell)
    )
    contact = mpm.RigidContact(**attributes)
    at, velocity = np.full(3, 1.03), np.zeros(3)
    at[dim - 1], velocity[dim - 1], velocity[0] = 1.2, -3, 1
    contact.addBody(rigid.Sphere(0.2), friction=friction, position=at[:dim], velocity=velocity)
    sphere = Free(contact, 0.5, 0.4 * 0.5 * 0.2**2)
    scene.engines = [*chain(contact), mpm.PyRunner(sphere, iterPeriod=1)]
    return scene, contact, block, sphere


def momentum(block, sphere):
    own = sphere.mass * sphere.v[0, : block.position.shape[1]]
    return own + (block.mass[:, None] * block.velocity).sum(axis=0)
