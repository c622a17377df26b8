# SPDX-License-Identifier: GPL-2.0-or-later
"""Implicit bodies: their elastic forces at the end of the step enter the solution, so that their stiffness
does not limit the step; everything else stays as it was."""

import numpy as np
import pytest
import yade_mpm as mpm
from implicitScenes import CELL, CRITICAL, KINDS, LAME, column, names, soilWithPile
from setups import chain, elastic
from yade_mpm import box, diagnostics


# --- the chain ------------------------------------------------------------------------------------------
def test_the_scene_puts_the_engine_behind_the_solver_where_a_body_is_implicit():
    scene = soilWithPile()
    stages = [
        "ParticleToGrid",
        "GridSolver",
        "ImplicitBodies",
        "GridToParticle",
        "VelocityRemap",
        "DomainUpdater",
    ]
    assert names(scene) == stages
    assert "ImplicitBodies" not in names(soilWithPile(implicit=False))
    late = soilWithPile(implicit=False)
    late["pile"].implicit = True
    late.dt = 1e-4
    late.run(steps=3, progress=False)
    assert names(late) == stages and late.timing()["ImplicitBodies"][1] == 3


def test_what_it_cannot_do_is_refused():
    scene = soilWithPile(scheme="USF")
    with pytest.raises(ValueError, match="'pile': implicit=True has no meaning under USF"):
        scene.run(steps=1)
    with pytest.raises(ValueError, match="'pile': implicit=True with fbar=True"):
        soilWithPile(fbar=True).run(steps=1)
    late = soilWithPile(implicit=False)
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.5, lame=(1e4, 6e3), cohesion=5.0, frictionAngle=0.5, dilatancyAngle=0.0
    )
    late.add("block", box((0, 2), (1, 3)), sand, mpm.UGIMP()).implicit = True
    with pytest.raises(ValueError, match="'block'.*give fbar=False .True is the default of a material that"):
        late.run(steps=1)
    with pytest.raises(ValueError, match="implicit = 1; give True or False"):
        soilWithPile(implicit=1)


def test_the_automatic_step_leaves_implicit_bodies_out():
    scene, explicit = soilWithPile(), soilWithPile(implicit=False)
    both = scene.criticalTimeStep(), scene.criticalTimeStep(asIfExplicit=True)
    assert both[1] == explicit.criticalTimeStep() < 0.1 * both[0]
    assert scene.stiffest == "soil" and explicit.stiffest == "pile" and scene.dtCritical == both[0]
    scene.run(steps=1, progress=False)
    assert scene.dt == pytest.approx(min(0.8 * both[0], 0.55 * scene.dtStable), rel=1e-12)
    scene.dt = 2 * both[0]
    with pytest.raises(ValueError, match=r"stiffest: 'soil'; implicit and left out: 'pile'"):
        scene.run(steps=1)
    with pytest.raises(ValueError, match="every body is implicit"):
        column().run(steps=1)


# --- what shares nodes with it --------------------------------------------------------------------------
def blockOnSoil(soilKind, blockKind, width, perCell=2, lift=0.0, scheme="MUSL"):
    """A block of steel stands on an elastic one, or over it, bonded; gravity is switched on."""
    scene = mpm.Scene((0, 0), (3, 4), CELL, threads=1, scheme=scheme)
    kinds = {"uGIMP": lambda: mpm.UGIMP(perCell=perCell), "APDI": lambda: mpm.APDI(size=CELL)}
    soft = elastic(2e4)
    base = box((1.5 - width / 2, 0), (1.5 + width / 2, 1))
    scene.add("soil", base, soft, kinds[soilKind]())
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    scene.add("block", box((1, 1 + lift), (2, 2 + lift)), steel, KINDS[blockKind](), implicit=True)
    scene.engines = chain(gravity=(0, -9.81), fixed="bottom", roller=("left", "right"))
    return scene


def longestStable(*which, moved=0.0, **more):
    scene = blockOnSoil(*which, **more)
    for body in scene.bodies:
        body.position[:, 1] -= moved
    scene.criticalTimeStep()
    return scene.dtStable


def test_a_block_that_has_not_landed_counts_as_if_it_had():
    """It may land long before the next estimate, and did so at 1.15 times the longest stable step."""
    over = longestStable("uGIMP", "uGIMP", 3.0, lift=0.75)
    assert over == pytest.approx(longestStable("uGIMP", "uGIMP", 3.0, lift=0.75, scheme="USL"), rel=1e-3)
    assert over < 0.8 * longestStable("uGIMP", "uGIMP", 3.0)


def test_boxes_as_wide_as_a_cell_count_as_if_they_had_moved():
    """Which they do in the first step: on lines of the grid the estimate was 1.57 times as long."""
    where = "uGIMP", "uGIMP", 1.0
    assert longestStable(*where, perCell=1) == pytest.approx(
        longestStable(*where, perCell=1, moved=0.01), rel=0.02
    )


def energyGained(scene):
    """What the bodies have beyond what was done to them, over that."""
    has = diagnostics.internalWork(scene) + diagnostics.kineticEnergy(scene)
    done = diagnostics.externalWork(scene)
    return (has - done) / abs(done)  # of a run that breaks both may be negative


@pytest.mark.parametrize("share", [0.95, 0.3])
@pytest.mark.parametrize("width", [1.0, 3.0])
@pytest.mark.parametrize("blockKind", KINDS)
@pytest.mark.parametrize("soilKind", KINDS)
def test_a_bonded_block_gets_no_energy_from_its_soil(soilKind, blockKind, width, share):
    """While soil was strained by another velocity than the block, where they share nodes, motions grew by
    1e-3 in a step: at the automatic one soil of APDI had 170 times the energy after 1 s, and a pile in sand
    bore a sixth. By the law of MUSL alone the longest stable step would be 1.4 times as long, and boxes
    break that just reach over the edge of the block."""
    scene = blockOnSoil(soilKind, blockKind, width)
    scene.criticalTimeStep()
    scene.dt = share * scene.dtStable
    scene.run(until=1.0, progress=False)
    assert energyGained(scene) < 0.01


@pytest.mark.parametrize("perCell, up", [(1, 0.002), (2, 0.02), (4, 0.002), (6, 0.006)])
def test_the_automatic_step_knows_of_the_line_below(perCell, up):
    """Soil and block begin just over a line of the grid, and sink below it: the step was 0.55 of what held
    before, 1.06 of what held then."""
    scene = blockOnSoil("uGIMP", "uGIMP", 1.0, perCell=perCell)
    for body in scene.bodies:
        body.position[:, 1] += up
    scene.run(until=0.5, progress=False)
    assert energyGained(scene) < 0.01


@pytest.mark.parametrize("more", [{}, {"scheme": "USL"}])
def test_an_estimate_moves_nothing(more):
    """Boxes as wide as a cell are moved for it, and came back by an alias of their own positions."""
    scene = blockOnSoil("uGIMP", "uGIMP", 1.0, perCell=1, **more)
    before = [(b.byId("position").tobytes(), b.byId("velocity").tobytes()) for b in scene.bodies]
    scene.criticalTimeStep()
    assert [(b.byId("position").tobytes(), b.byId("velocity").tobytes()) for b in scene.bodies] == before


def test_a_body_in_contact_with_both_gets_no_energy_either():
    """Contact gave what shares nodes another velocity than the block's: 0.06 kJ in 3 s came from nowhere,
    where gravity does 0.2."""
    scene = mpm.Scene((0, 0), (3, 4), CELL, threads=1)
    soft, within = elastic(2e4), box((1, 0), (2, 1))
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    scene.add("soil", box((0, 0), (3, 1)) - within, soft, mpm.UGIMP())
    scene.add("block", within, steel, mpm.UGIMP(), implicit=True)
    scene.add("other", box((0.5, 1), (2.5, 2)), soft, mpm.UGIMP(), group="other")
    scene.engines = chain(
        contact=mpm.Contact(friction=0), gravity=(0.3, -9.81), fixed="bottom", roller=("left", "right")
    )
    scene.run(until=3.0, progress=False)
    assert energyGained(scene) < 0.01


def test_a_step_that_may_be_too_long_beside_a_bonded_block_is_warned_of(capsys):
    scene = blockOnSoil("uGIMP", "uGIMP", 3.0)
    scene.criticalTimeStep()
    scene.dt = 0.9 * scene.dtStable
    with pytest.warns(UserWarning, match="0.9 of the longest stable step; beside an implicit body"):
        scene.run(steps=1, progress=False)


@pytest.mark.parametrize("kind", ["uGIMP", "APDI"])
def test_a_block_that_swings_on_soil_counts_no_loss(kind):
    """It moves as a whole, and the soil is explicit: the swing keeps its energy. Half of dt^2
    times mass times square of the acceleration, as if the forces of the soil were implicit, too: 64 % of what
    gravity does."""
    scene = mpm.Scene((0, 0), (1, 5), CELL, threads=1, scheme="USL")
    soft = elastic(2e4)
    kinds = {"uGIMP": mpm.UGIMP, "APDI": lambda: mpm.APDI(size=CELL)}
    scene.add("soil", box((0, 0), (1, 2)), soft, kinds[kind]())
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    scene.add("block", box((0, 2), (1, 3)), steel, kinds[kind](), implicit=True)
    scene.engines = chain(gravity=(0, -9.81), fixed="bottom", roller=("left", "right"))
    scene.dt = 8e-4
    scene.run(until=2.0, progress=False)
    done = diagnostics.externalWork(scene)
    assert abs(diagnostics.implicitEnergy(scene)) < 0.01 * done
    assert abs(diagnostics.energyError(scene)) < 0.04 * done


# --- what comes out -------------------------------------------------------------------------------------
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_a_long_step_finds_equilibrium_like_newton(kind, dim):
    """With dt beyond all periods the first step makes the static displacement, by the tangent stiffness: what
    were left out of it, hourglass control of APDI for one, would have to be made good by the next ones."""
    scene = column(kind, dim, across=1e-3, along=-1e-3)
    scene.dt = 1e5 * CRITICAL
    moved = []
    for _ in range(4):
        before = scene["column"].position.copy()
        scene.run(steps=1, progress=False)
        moved.append(np.abs(scene["column"].position - before).max())
    assert moved[1] < 1e-3 * moved[0] and moved[3] < 1e-6 * moved[0]
