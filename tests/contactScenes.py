# SPDX-License-Identifier: GPL-2.0-or-later
"""Blocks and plates in contact, for tests of Contact."""

from math import cos, radians, sin

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, elastic
from yade_mpm import box

PAIRS = ["uu", "ua", "au", "aa"]  # u: uGIMP, a: APDI,
CUT = ["uc", "ac", "cc"]  # c: uGIMP that carries its outline
SCHEMES = ["MUSL", "USL", "USF"]
G = 10.0  # m/s2


pytestmark = pytest.mark.filterwarnings(
    "ignore:Scene. the groups .* stick together"
)  # as a reference: bonded bodies


def typeOf(letter, cell):
    return mpm.APDI(size=cell / 2) if letter == "a" else mpm.UGIMP(perCell=2, cut=letter == "c")


def run(scene, **until):
    scene.run(progress=False, **until)
    return scene


def pressed(contact, pair, scheme):
    """A column in two parts between rollers, at rest under its weight, then pulled aside."""
    scene = mpm.Scene((0, 0), (2, 2.5), 0.25, scheme=scheme, threads=1)
    scene.add("lower", box((0, 0), (2, 1)), elastic(1e4), typeOf(pair[0], 0.25), group="a")
    scene.add("upper", box((0, 1), (2, 1.75)), elastic(1e4), typeOf(pair[1], 0.25), group="b")
    scene.initialStress(surface=1.75, K0=0.43, gravity=G)
    scene.engines = chain(
        contact=contact, gravity=(0.5, -G), damping=0.1, fixed="bottom", roller=("left", "right")
    )
    scene.dt = 2e-4
    return run(scene, steps=300)


# --- a block on an incline ------------------------------------------------------------------------------
class Incline:
    """A block on a flat base; gravity is turned by `slope` degrees once the block has come to rest."""

    def __init__(
        self,
        pair,
        friction,
        dim=2,
        scheme="MUSL",
        slope=30,
        damping=0.0,
        threads=1,
        time=0.15,
        cell=0.1,
        start=0.5,
        **law,
    ):
        self.cell, self.slope, self.damping, self.dim = cell, radians(slope), damping, dim
        self.along = np.array([1.0, 0.0] if dim == 2 else [0.8, 0.6])
        self.scene = mpm.Scene(
            (0,) * dim, (2.4, 1.0) if dim == 2 else (1.6, 1.6, 0.7), cell, scheme=scheme, threads=threads
        )
        base, block = (
            ((2.4, 0.2), ((start, 0.2), (start + 0.6, 0.5)))
            if dim == 2
            else ((1.6, 1.6, 0.2), ((0.4, 0.4, 0.2), (0.8, 0.8, 0.4)))
        )
        self.base = self.scene.add(
            "base", box((0,) * dim, base), elastic(1e5), typeOf(pair[0], cell), group="base"
        )
        self.block = self.scene.add("block", box(*block), elastic(1e5), typeOf(pair[1], cell), group="block")
        self.contact = mpm.Contact(friction=friction, **law)
        self.scene.engines = chain(
            contact=self.contact, gravity=self.gravity(0), damping=0.7, fixed=["bottom"]
        )
        self.solver = next(e for e in self.scene.engines if isinstance(e, mpm.GridSolver))
        run(self.scene, until=0.08)
        for body in self.scene.bodies:
            body.velocity[...] = 0
        self.solver.gravity, self.solver.damping = self.gravity(self.slope), damping
        self.time, self.speed, self.forces, self.penetration = [], [], [], 0
        self.follow(time)

    def gravity(self, slope):
        return (*(G * sin(slope) * self.along[: self.dim - 1]), -G * cos(slope))

    def follow(self, time):
        until = self.scene.time + time
        while self.scene.time < until:
            run(self.scene, steps=10)
            self.time.append(self.scene.time), self.speed.append(self.velocity() @ self.along[: self.dim - 1])
            self.forces.append(self.contact.forceOn("block"))
            self.penetration = max(self.penetration, self.contact.largestPenetration / self.cell)

    def velocity(self):
        return self.block.mass @ self.block.velocity[:, : self.dim - 1] / self.block.mass.sum()

    def acceleration(self):
        late = np.array(self.time) > self.time[0] + 0.2 * (self.time[-1] - self.time[0])
        return np.polyfit(np.array(self.time)[late], np.array(self.speed)[late], 1)[0]

    def expected(self, friction, adhesion=0.0):
        """Of a sliding block, m/s2."""
        area = 0.6 if self.dim == 2 else 0.4**2
        return G * (sin(self.slope) - friction * cos(self.slope)) - adhesion * area / self.block.mass.sum()


# --- laws -----------------------------------------------------------------------------------------------
def drawn(contact, pairs=("ua",), length=0.6):
    """Blocks on one base, drawn along it at 0.5 m/s: for each the drive, and its weight."""
    scene = mpm.Scene((0, 0), (1 + 1.2 * len(pairs), 1), 0.1, threads=1)
    scene.add(
        "base", box((0, 0), (1 + 1.2 * len(pairs), 0.2)), elastic(1e5), typeOf(pairs[0][0], 0.1), group="base"
    )
    drives, weights = [], []
    for k, pair in enumerate(pairs):
        block = scene.add(
            f"block {k}",
            box((0.3 + 1.2 * k, 0.2), (0.3 + length + 1.2 * k, 0.5)),
            elastic(1e5),
            typeOf(pair[1], 0.1),
            group=f"block {k}",
        )
        drives.append(mpm.Drive(block, velocity=(0.5, None), ramp=0.05, name=f"drive {k}"))
        weights.append(G * block.mass.sum())
    scene.engines = chain(contact=contact, gravity=(0, -G), damping=0.3, fixed="bottom", drive=drives)
    return scene, drives, weights
