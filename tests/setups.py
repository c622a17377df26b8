# SPDX-License-Identifier: GPL-2.0-or-later
"""Set-ups that many tests share: from setups import chain"""

from math import radians, tan

import numpy as np
import yade_mpm as mpm


def chain(*before, contact=None, flip=1.0, **solver):
    """The engines of a step. Loads and rigid contacts come `before` the solver, `contact` behind it."""
    behind = () if contact is None else (contact,)
    first, last = (mpm.ParticleToGrid(), *before), (mpm.GridToParticle(flip=flip), mpm.DomainUpdater())
    return [*first, mpm.GridSolver(**solver), *behind, *last]


def elastic(young):
    """A linear elastic material of 2 Mg/m3 and Poisson's ratio 0.3; `young`: Young's modulus, kPa."""
    return mpm.LinearElastic(density=2.0, young=young, poisson=0.3)


def soft(density=1.0):
    """A linear elastic material with Lame constants of 1 MPa; `density` in Mg/m3."""
    return mpm.LinearElastic(density=density, lame=(1e3, 1e3))


def softSoil(cohesion, **attributes):
    """Soil with friction of 25 degrees, soft unless `young` and `poisson` are given; `cohesion` in kPa."""
    moduli = {} if "young" in attributes else dict(lame=(2e3, 1.5e3))
    given = dict(density=1.5, frictionAngle=radians(25), cohesion=cohesion, **moduli)
    return mpm.MohrCoulombDruckerPrager(**given | attributes)


def afterTurn(scene, slope, rest, until, **every):
    """Rest until the time `rest` under what a slope (rad) leaves of gravity across it; then its part along x
    acts, too, without damping. An iterator over the times between runs of `every`, e.g. steps=10."""
    scene.run(until=rest, progress=False)
    for body in scene.bodies:
        body.velocity[...] = 0
    solver = next(e for e in scene.engines if isinstance(e, mpm.GridSolver))
    across = solver.gravity
    solver.gravity, solver.damping = (-across[-1] * tan(slope), *across[1:]), 0
    while scene.time < until:
        scene.run(progress=False, **every)
        yield scene.time


# Of Cam-Clay, but for density and preconsolidation.
CAM_CLAY = dict(compression=0.2, swelling=0.04, frictionAngle=0.4, initialVoidRatio=1.0)
# The same, soft; with preconsolidation.
SOFT_CLAY = dict(compression=0.1, swelling=0.02, frictionAngle=0.5, initialVoidRatio=0.8)
SOFT_CLAY |= dict(preconsolidation=40.0, smallestPressure=5.0)


def freeBlock(kind=None, dim=2, **options):
    """A scene of 4 m with an elastic block of 2 m in its middle, and the block."""
    scene = mpm.Scene((0,) * dim, (4,) * dim, 0.5, threads=1)
    kind = mpm.UGIMP(perCell=2) if kind is None else kind
    return scene, scene.add("block", mpm.box((1,) * dim, (3,) * dim), elastic(1e4), kind, **options)


def shearedSoil(mesh, dim, size, pressure=None):
    """A mesh of soil under gravity, sheared at the start, after 60 steps; pressure on all of it, kPa."""
    strength = dict(cohesion=1.0, frictionAngle=radians(25), dilatancyAngle=radians(5))
    soil = mpm.MohrCoulombDruckerPrager(density=2.0, young=1e3, poisson=0.3, **strength)
    scene = mpm.Scene((0,) * dim, (size,) * dim, 0.1, threads=1)
    body = scene.add("soil", mesh, soil, mpm.APDI(hourglass=0.1))
    body.velocity[:, 0] = 2 * (body.position[:, -1] - 0.5)
    loads = () if pressure is None else (mpm.BoundaryLoad(body, pressure=pressure),)
    scene.engines = chain(*loads, gravity=(0,) * (dim - 1) + (-9.81,))
    scene.dt = 2e-4
    scene.run(steps=60, progress=False)
    return body


def elasticEnergy(body):
    """Strain energy of compressible neo-Hookean elasticity, lambda/2 ln(J)^2 - mu ln J + mu/2 (tr F^T F -
    3)."""
    a, mu = body.material.lame
    F = body.deformationGradient
    J = np.linalg.det(F)
    density = 0.5 * a * np.log(J) ** 2 - mu * np.log(J) + 0.5 * mu * ((F**2).sum(axis=(1, 2)) - 3)
    return body.initialVolume @ density


def bits(scene):
    """What all particles are, to the last bit, in the order of their ids."""
    fields = ("position", "velocity", "stress", "volume")
    return [body.byId(field).tobytes() for body in scene.bodies for field in fields]


def withAnyThreads(make, steps):
    """A scene of make(threads) after some steps: the same bits with one thread and with two."""
    one, two = make(1), make(2)
    for scene in (one, two):
        scene.run(steps=steps, progress=False)
    assert bits(one) == bits(two)
    return one


def restarted(scene, steps):
    """A scene and what its checkpoint brings back go on with the same bits; returns what it brings back."""
    scene.save("state.h5")
    other = mpm.load("state.h5")
    for one in (scene, other):
        one.run(steps=steps, progress=False)
    assert bits(other) == bits(scene)
    return other


def workOf(point, increment, steps=200, power=1):
    """Work of the stress of a material point along a strain, by the initial volume, kJ/m3; power=0: by the
    present one, as of a law that does not know its volume."""
    work = 0.0
    for _ in range(steps):
        before, J = point.stress, np.linalg.det(point.deformationGradient) ** power
        after, K = point.strain(increment / steps), np.linalg.det(point.deformationGradient) ** power
        work += 0.5 * np.sum((J * before + K * after) * increment) / steps
    return work


def strainUnderPressure(stress, bulk, shear, m, smallest=1.0, reference=100.0):
    """Elastic strain of a stress whose moduli follow the pressure (equation 6.9), and the factor on the
    moduli and on the shear modulus there."""
    core = max(1 - m, 0.1)

    def tangent(P):
        return (P / reference) ** m

    def linear(P):
        more = np.log(P / smallest) if m == 1 else ((P / smallest) ** (1 - m) - 1) / (1 - m)
        return smallest / tangent(smallest) * (1 / core + more)

    scale = tangent(reference) * linear(reference) / reference
    mean = np.trace(stress) / 3
    deviator = stress - mean * np.eye(3)
    P = np.sqrt(mean**2 + bulk / (scale * shear) * 0.5 * (deviator**2).sum())
    k = P / linear(P) if smallest < P else core * tangent(smallest)
    return deviator / (2 * k * scale * shear) + mean / (3 * k * bulk) * np.eye(3), k, scale
