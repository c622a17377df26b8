# SPDX-License-Identifier: GPL-2.0-or-later
"""D25, drives: the step suits a stiff driven body wherever its base is in a cell
(doc/explanation/time-step.md).

Set-up: a concrete footing of uGIMP boxes, ten times as inert, bonded to soft clay and driven into it at
0.1 m/s. Its base starts on a line of the grid and goes through 0.4 of a cell.
Reference: at the automatic step the footing and the clay go on slowly (kinetic energy below 0.2 kJ).
Control: the step of the clay alone, which holds on the line, makes more than 10 kJ, or turns boxes
inside out.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

TOP = 1.5


def footing(gap=0.0, group="main", dt=None):
    """Half of a footing above clay; `gap` m apart."""
    scene = mpm.Scene((0, 0), (3, 3), 0.25, threads=1)
    soft = dict(density=1.7, young=5e3, poisson=0.35, cohesion=20, frictionAngle=0, dilatancyAngle=0)
    concrete = mpm.LinearElastic(density=2.4, young=1e6, poisson=0.2)
    clay = mpm.MohrCoulombDruckerPrager(**soft)
    scene.add("clay", box((0, 0), (3, TOP)), clay, mpm.UGIMP(perCell=2))
    place = box((0, TOP + gap), (1, TOP + gap + 0.5))
    block = scene.add("footing", place, concrete, mpm.UGIMP(perCell=2), inertiaScale=10, group=group)
    scene.initialStress(surface=TOP, K0=0.8)
    push = mpm.Drive(block, velocity=(0, -0.1), ramp=0.2, name="push")
    walls = dict(roller=("left", "right"), fixed="bottom")
    solver = mpm.GridSolver(gravity=(0, -9.81), damping=0.05, drive=push, **walls)
    contact = [mpm.Contact(friction=0.0)] if group != "main" else []
    scene.engines = [mpm.ParticleToGrid(), solver, *contact, mpm.GridToParticle(), mpm.DomainUpdater()]
    scene.dt, scene.allowUnstable = dt, dt is not None
    return scene


def told(scene):
    scene.prepare()
    return scene.dtStable


def ownStep(scene):
    scene.prepare()
    return scene.dt


def kineticEnergy(scene):
    """At 1.1 s, kJ; infinite where the run fails. The work of the drive is some 5 kJ."""
    try:
        scene.run(until=1.1, progress=False)
    except RuntimeError:
        return np.inf
    return mpm.diagnostics.kineticEnergy(scene)


def test_the_automatic_step_holds_where_a_driven_base_is_within_a_cell():
    assert kineticEnergy(footing()) < 0.2


def test_the_step_of_the_clay_alone_does_not():
    assert kineticEnergy(footing(dt=ownStep(footing(group="apart")))) > 10


def test_a_body_that_is_driven_towards_others_counts_as_if_it_had_landed():
    landed = told(footing())
    assert 0.65 * landed < told(footing(gap=0.5)) < 1.05 * landed


def test_groups_of_their_own_are_held_wherever_they_are():
    """A drive holds every node of a group that it moves whole."""
    assert told(footing(group="apart")) > 2 * told(footing())


def test_a_step_of_your_own_is_refused_on_the_line_too():
    scene = footing()
    scene.dt = ownStep(footing(group="apart"))
    with pytest.raises(ValueError, match="exceeds the longest stable step"):
        scene.prepare()


@pytest.mark.parametrize("loop", ["steps", "restart"])
def test_steps_and_a_restart_give_the_same_bits(loop, tmp_path):
    whole, other = footing(), footing()
    whole.run(steps=40, progress=False)
    if loop == "steps":
        for _ in range(40):
            other.step()
    else:
        other.run(steps=17, progress=False)
        other.save(tmp_path / "state.h5")
        other = mpm.load(tmp_path / "state.h5")
        other.run(steps=23, progress=False)
    assert other.time == whole.time
    assert np.array_equal(other["footing"].position, whole["footing"].position)
    assert np.array_equal(other["clay"].stress, whole["clay"].stress)
