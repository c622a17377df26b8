# SPDX-License-Identifier: GPL-2.0-or-later
"""The scene that test_in_yade.py runs by its own loop and inside YADE: an APDI block driven into uGIMP
soil."""

import hashlib

import numpy as np
import yade_mpm as mpm
from yade_mpm import box


def hybrid(*callbacks, dt=None):
    scene = mpm.Scene((0, 0), (4, 3), 0.25, threads=2)
    soil = mpm.MohrCoulombDruckerPrager(density=2.0, young=1e4, poisson=0.3, cohesion=5.0, frictionAngle=0.5)
    scene.add("soil", box((0, 0), (4, 1)), soil, mpm.UGIMP(perCell=2))
    block = scene.add(
        "block",
        box((1.5, 1), (2.5, 2)),
        mpm.LinearElastic(density=2.5, young=1e5, poisson=0.2),
        mpm.APDI(size=0.25),
    )
    head = mpm.Drive(block.above(1.8), (0, -0.3), ramp=0.05, name="head")
    solver = mpm.GridSolver(
        gravity=(0, -9.81), damping=0.05, roller=("left", "right"), fixed="bottom", drive=head
    )
    scene.engines = [mpm.ParticleToGrid(), solver, mpm.GridToParticle(), mpm.DomainUpdater(), *callbacks]
    scene.dt = dt
    return scene


def bits(scene):
    """Digest of every field of every body, the clock, and what the drive has measured."""
    digest = hashlib.sha256(
        repr((scene.time, scene.steps, [(c.name, c.work) for c in scene.constraints])).encode()
    )
    for body in scene.bodies:
        for ofDomains in (False, True):
            for field in body._core.fields(ofDomains):
                if field["name"] != "bodyForce":
                    digest.update(np.ascontiguousarray(body._core.view(field["name"], ofDomains)).tobytes())
    return digest.hexdigest()
