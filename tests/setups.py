# SPDX-License-Identifier: GPL-2.0-or-later
"""Set-ups that many tests share: from setups import chain"""

import yade_mpm as mpm


def chain(*before, contact=None, **solver):
    """The engines of a step. Loads and rigid contacts come `before` the solver, `contact` behind it."""
    behind = () if contact is None else (contact,)
    first, last = (mpm.ParticleToGrid(), *before), (mpm.GridToParticle(), mpm.DomainUpdater())
    return [*first, mpm.GridSolver(**solver), *behind, *last]


def elastic(young):
    """A linear elastic material of 2 Mg/m3 and Poisson's ratio 0.3; `young`: Young's modulus, kPa."""
    return mpm.LinearElastic(density=2.0, young=young, poisson=0.3)


def soft(density=1.0):
    """A linear elastic material with Lame constants of 1 MPa; `density` in Mg/m3."""
    return mpm.LinearElastic(density=density, lame=(1e3, 1e3))


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
