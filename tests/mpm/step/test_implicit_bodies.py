# SPDX-License-Identifier: GPL-2.0-or-later
"""Implicit bodies: their elastic forces at the end of the step enter the solution, so that their stiffness
does not limit the step; everything else stays as it was."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain, elastic
from yade_mpm import box, diagnostics

CELL, LENGTH, THICKNESS = 0.25, 5.0, 0.25
LAME = (4.2e7, 2.8e7)
CRITICAL = 6.1e-5  # s, of the column
KINDS = {"uGIMP": lambda: mpm.UGIMP(perCell=2), "APDI": lambda: mpm.APDI(size=CELL / 2)}


def column(kind="uGIMP", dim=2, across=0.0, along=0.0, implicit=True, **solver):
    """A steel column on a fixed base under a body force along and across it, m/s2; critical step 6.1e-5 s."""
    height, left = LENGTH if dim == 2 else 1.5, 2 * CELL - THICKNESS / 2
    lower, upper = (left,) * (dim - 1), (left + THICKNESS,) * (dim - 1)
    scene = mpm.Scene((0,) * dim, (4 * CELL,) * (dim - 1) + (height + 4 * CELL,), CELL, threads=1)
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    kind = KINDS[kind]()
    scene.add("column", box((*lower, 0), (*upper, height)), steel, kind, implicit=implicit)
    gravity = (across, *(0.0,) * (dim - 2), along)
    scene.engines = chain(gravity=gravity, fixed="bottom", **solver)
    return scene


def soilWithPile(implicit=True, damping=0.05, scheme="MUSL", threads=1, **options):
    """A short pile, bonded, driven into soft soil."""
    scene = mpm.Scene((0, 0), (3, 3), CELL, scheme=scheme, threads=threads)
    shaft = box((1.375, 1.0), (1.625, 2.5))
    soft = mpm.LinearElastic(density=1.5, lame=(1e4, 6e3))
    scene.add("soil", box((0, 0), (3, 2)) - shaft, soft, mpm.UGIMP())
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    pile = scene.add("pile", shaft, steel, mpm.UGIMP(), implicit=implicit, **options)
    drive = mpm.Drive(pile.above(2.25), velocity=(0, -0.1), ramp=0.01, name="drive")
    scene.engines = chain(
        gravity=(0, -9.81), damping=damping, fixed="bottom", roller=("left", "right"), drive=drive
    )
    return scene


def names(scene):
    return [type(e).__name__ for e in scene.engines]


def state(scene):
    return b"".join(b.position.tobytes() + b.velocity.tobytes() + b.stress.tobytes() for b in scene.bodies)


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
def test_a_block_that_swings_on_soil_books_no_loss(kind):
    """It moves as a whole, and the soil is explicit: the swing keeps its energy. Booked was half of dt^2
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


@pytest.mark.parametrize("kind", KINDS)
def test_an_axially_loaded_column_is_as_short_as_theory_says_at_any_step(kind):
    ends = []
    for ratio, steps in ((10, 400), (1000, 8)):
        scene = column(kind, along=-1.0)
        scene.dt = ratio * CRITICAL
        scene.run(steps=steps, progress=False)
        body = scene["column"]
        ends.append(body.displacement[body.position[:, 1].argmax(), 1])
    top = LENGTH - CELL / 4
    expected = -7.85 * 1.0 * (LENGTH * top - top**2 / 2) / (LAME[0] + 2 * LAME[1])
    free = expected * (LAME[0] + 2 * LAME[1]) / (4 * LAME[1] * (LAME[0] + LAME[1]) / (LAME[0] + 2 * LAME[1]))
    assert ends[0] == pytest.approx(ends[1], rel=1e-3)
    assert ends[1] == pytest.approx(free, rel=0.01)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_pressure_shortens_a_column_as_theory_says(dim):
    """Loads of BoundaryLoad stay explicit forces."""
    scene = column("APDI", dim)
    body, pressure = scene["column"], 1e3
    height = LENGTH if dim == 2 else 1.5
    top = box((0.0,) * (dim - 1) + (height - 0.01,), (1.0,) * (dim - 1) + (height + 0.01,))
    load = mpm.BoundaryLoad(body, top, pressure=pressure)
    scene.engines = [scene.engines[0], load, *scene.engines[1:]]
    scene.dt = 1e5 * CRITICAL
    scene.run(steps=4, progress=False)
    young = LAME[1] * (3 * LAME[0] + 2 * LAME[1]) / (LAME[0] + LAME[1])
    poisson = LAME[0] / 2 / (LAME[0] + LAME[1])
    modulus = young / (1 - poisson**2) if dim == 2 else young
    middle = np.abs(body.reference[:, -1] - height / 2) < CELL / 2  # the ends are held, or hold less
    above, below = (
        (body.reference[:, -1] > height / 2) & middle,
        (body.reference[:, -1] < height / 2) & middle,
    )
    strain = (body.displacement[above, -1].mean() - body.displacement[below, -1].mean()) / (CELL / 2)
    assert strain == pytest.approx(-pressure / modulus, rel=0.01)


@pytest.mark.parametrize("kind, share", [("uGIMP", 0.98), ("APDI", 0.965)])
def test_a_cantilever_bends_like_a_beam(kind, share):
    """A Timoshenko beam of its plane-strain modulus. Two particles across make uGIMP 2 % and APDI 3.5 %
    stiff."""
    g = 1.0
    scene = column(kind, across=g)
    scene.dt = 1e5 * CRITICAL
    scene.run(steps=6, progress=False)
    body = scene["column"]
    modulus = 4 * LAME[1] * (LAME[0] + LAME[1]) / (LAME[0] + 2 * LAME[1])
    q, L, I = 7.85 * g * THICKNESS, LENGTH, THICKNESS**3 / 12
    x = body.position[:, 1].max()
    bent = q / (24 * modulus * I) * (x**4 - 4 * L * x**3 + 6 * L**2 * x**2)
    sheared = q * (L * x - x**2 / 2) / (5 / 6 * LAME[1] * THICKNESS)
    top = body.displacement[body.position[:, 1] > LENGTH - CELL / 2, 0].mean()
    assert top / (bent + sheared) == pytest.approx(share, abs=0.01)


def test_reactions_balance_momentum():
    """Sum of m dv/dt = weight + reactions, to round-off, with rollers, a fixed face, and a drive with a
    ramp."""
    scene = soilWithPile(damping=0.0)
    scene.dt = 5e-4
    scene.run(steps=10, progress=False)
    weight = np.array([0, -9.81]) * diagnostics.mass(scene)
    for _ in range(20):
        before = diagnostics.momentum(scene)
        scene.run(steps=1, progress=False)
        change = (diagnostics.momentum(scene) - before) / scene.dt
        reactions = sum(np.array(c._core.reaction[:2]) for c in scene.constraints)
        scale = sum(np.abs(c._core.reaction[:2]).sum() for c in scene.constraints)
        assert np.abs(change - weight - reactions).max() < 1e-10 * scale


def test_energy_that_the_solution_takes_is_booked():
    scene = soilWithPile(damping=0.0)
    scene.dt = 5e-4
    scene.run(until=0.1, progress=False)
    taken, external = diagnostics.implicitEnergy(scene), diagnostics.externalWork(scene)
    assert 0 < taken < 0.01 * abs(external)
    assert abs(diagnostics.energyError(scene)) < 0.02 * abs(external)


def test_a_small_step_gives_what_the_explicit_body_gives():
    """The force of the drive while its ramp sends waves through the pile. What differs is the velocity that
    strains the body: MUSL's for the explicit one."""
    results = []
    for implicit in (False, True):
        scene = soilWithPile(implicit, damping=0.0)
        scene.dt = 1e-5
        history = mpm.History(period=0.01)
        scene.engines = [*scene.engines, history]
        scene.run(until=0.05, progress=False)
        results.append(history["drive.fy"][1:])
    assert results[1] == pytest.approx(results[0], abs=0.015 * np.abs(results[0]).max())


def test_local_damping_leaves_the_body_alone():
    scene, free = column(along=-1.0, damping=0.5), column(along=-1.0)
    for s in (scene, free):
        s.dt = 20 * CRITICAL
        s.run(steps=20, progress=False)
    assert state(scene) == state(free) and diagnostics.dampedEnergy(scene) == 0


def test_gradient_and_vertices_follow_the_solved_velocity():
    """F of an APDI domain is what its vertices say: both follow one velocity."""
    scene = column("APDI", across=50.0)
    scene.dt = 50 * CRITICAL
    scene.run(steps=40, progress=False)
    body = scene["column"]
    areas = diagnostics.cornerJacobians(body.corners()).mean(axis=1)
    J = np.linalg.det(body.deformationGradient)
    assert areas == pytest.approx(J * body.initialVolume, rel=1e-6)
    assert np.abs(body.displacement).max() > 0.01


def test_usl_and_musl_move_an_implicit_body_alike():
    states = []
    for scheme in ("MUSL", "USL"):
        scene = mpm.Scene((0, 0), (1, 3), CELL, scheme=scheme, threads=1)
        steel = mpm.LinearElastic(density=7.85, lame=LAME)
        scene.add("column", box((0.375, 0), (0.625, 2)), steel, mpm.APDI(size=CELL / 2), implicit=True)
        scene.engines = chain(gravity=(1.0, -9.81), fixed="bottom")
        scene.dt = 20 * CRITICAL
        scene.run(steps=50, progress=False)
        states.append(state(scene))
    assert states[0] == states[1]


# --- several bodies ---------------------------------------------------------------------------------------
def test_two_bodies_that_touch_are_one_system_and_others_are_systems_of_their_own():
    """A column of two bodies moves like that of one, and a far one beside it does not change a bit."""
    tops = []
    for parts in (1, 2):
        scene = mpm.Scene((0, 0), (4, 3), CELL, threads=1)
        steel = mpm.LinearElastic(density=7.85, lame=LAME)
        heights = np.linspace(0, 2, parts + 1)
        for lower, upper in zip(heights, heights[1:]):
            region = box((0.375, lower), (0.625, upper))
            scene.add(f"to {upper}", region, steel, mpm.UGIMP(), implicit=True)
        far = scene.add("far", box((3.375, 0), (3.625, 2)), steel, mpm.UGIMP(), implicit=True)
        scene.engines = chain(gravity=(1.0, -1.0), fixed="bottom")
        scene.dt = 50 * CRITICAL
        scene.run(steps=30, progress=False)
        tops.append((scene["to 2.0"].displacement[-1], far.displacement[-1]))
    assert tops[1][0] == pytest.approx(tops[0][0], rel=1e-9)
    assert tops[0][1] == pytest.approx(tops[0][0], rel=1e-9)


# --- bits -------------------------------------------------------------------------------------------------
def test_threads_do_not_change_a_bit():
    states = []
    for threads in (1, 2):
        scene = soilWithPile(threads=threads)
        scene.dt = 5e-4
        scene.run(steps=30, progress=False)
        states.append(state(scene))
    assert states[0] == states[1]


def test_restart_continues_bitwise(tmp_path):
    scene = soilWithPile()
    scene.dt = 5e-4
    scene.run(steps=15, progress=False)
    scene.save(tmp_path / "state.h5")
    scene.run(steps=15, progress=False)
    other = mpm.load(tmp_path / "state.h5")
    assert other["pile"].implicit and names(other) == names(scene)
    other.run(steps=15, progress=False)
    assert state(other) == state(scene)
    assert diagnostics.implicitEnergy(other) == diagnostics.implicitEnergy(scene) > 0


@pytest.mark.parametrize("hasBase", [False, True])
def test_what_is_driven_and_not_strained_loses_nothing(hasBase):
    """A ramp of ten steps; with a fixed base elsewhere other rows are held at rest."""
    scene = mpm.Scene((0, 0), (3, 6), 0.25)
    steel = mpm.LinearElastic(density=7.85, lame=(4.2e7, 2.8e7))
    pile = scene.add("pile", mpm.box((1.25, 1), (1.75, 5)), steel, mpm.UGIMP(), implicit=True)
    if hasBase:
        scene.add("far", mpm.box((0, 0), (0.25, 0.25)), steel, mpm.UGIMP(), implicit=True)
    drive = mpm.Drive(pile.above(2.0), velocity=(0, 0.5), ramp=0.02)
    scene.engines = chain(drive=drive, **({"fixed": "bottom"} if hasBase else {}))
    scene.dt = 2e-3
    scene.run(steps=30, progress=False)
    work = mpm.diagnostics.externalWork(scene)
    assert work == pytest.approx(mpm.diagnostics.kineticEnergy(scene), rel=1e-3)
    assert abs(mpm.diagnostics.implicitEnergy(scene)) < 1e-3 * work
    assert abs(mpm.diagnostics.energyError(scene)) < 1e-5 * work
