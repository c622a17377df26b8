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
