# SPDX-License-Identifier: GPL-2.0-or-later
"""D28: a block is driven through a closed box of weightless clay. Clay and block fill the box whatever
flows, so the mean pressure stays, also in cells that the surface of the block cuts
(doc/explanation/volumes.md)."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import bits, chain, restarted, withAnyThreads
from yade_mpm import box, disc, geotech

PRESSURE, STRENGTH, SHEAR, POISSON = 200.0, 10.0, 1000.0, 0.49  # kPa, kPa, kPa, -
CELL, HALF = 0.2, 0.4  # m, of the grid, and half the edge of the block
SIZE = {2: 4.8, 3: 2.4}  # m, of the box
LAME = 2 * SHEAR * POISSON / (1 - 2 * POISSON), SHEAR


def blockMesh(lower, upper, size):
    """Points and cells of a mesh of quadrilaterals or bricks."""
    counts = np.rint((np.array(upper) - lower) / size).astype(int)
    axes = [np.linspace(*ends, n + 1) for *ends, n in zip(lower, upper, counts)]
    points = np.stack([x.ravel() for x in np.meshgrid(*axes, indexing="ij")], 1)
    number = np.arange(len(points)).reshape(counts + 1)
    ring = (0, 0), (1, 0), (1, 1), (0, 1)
    corners = ring if len(lower) == 2 else [(*a, k) for k in (0, 1) for a in ring]
    inner = [number[tuple(slice(s, s + n) for s, n in zip(c, counts))].ravel() for c in corners]
    return points, np.stack(inner, 1)


def driven(
    dim=2,
    scheme="MUSL",
    threads=1,
    shift=0.0,
    density=1.5,
    velocity=None,
    at=None,
    graded=False,
    isDriven=True,
    size=None,
    half=HALF,
    perCell=2,
    mesh=None,
    pressure=PRESSURE,
    elastic=None,
    **contact,
):
    """Scene, soil, block, contact.

    at : centre of the block, m; None: the middle, moved by `shift` along all axes. size : of the box, m.
    half : of the edges of the block, m. mesh : what of the soil is a mesh; None: nothing.
    elastic : kPa, Lame constants of soil and block; None: clay.
    """
    size = size or SIZE[dim]
    lower, upper = (0.0,) * dim, (size,) * dim
    fine = ((1.0, 1.0), (3.4, 3.4))
    scene = mpm.Scene(
        lower, upper, CELL, threads=threads, grading=mpm.Grading(fine, 1.2, 0.4) if graded else None
    )
    scene.scheme = scheme
    centre = np.full(dim, size / 2) + shift if at is None else np.array(at)
    clay = mpm.MohrCoulombDruckerPrager(density=1.5, lame=LAME, cohesion=STRENGTH, frictionAngle=0)
    hole = box(centre - half, centre + half)
    stiff = mpm.LinearElastic(density=density, lame=elastic or LAME)
    material = stiff if elastic else clay
    whole = box(lower, upper)
    meshed = {
        "below": lambda: box(lower, (size, centre[1] - half)),
        "beside": lambda: box((centre[0], 0), upper),
        "round": lambda: whole - box(centre - half - 2 * CELL, centre + half + 2 * CELL),
    }
    ground = whole - meshed[mesh]() if mesh else whole
    boxes = mpm.UGIMP(perCell=perCell)
    soil = scene.add("soil", ground - hole, material, boxes, group="soil", fbar=True)
    soils = [soil]
    if mesh:
        domains = mpm.APDI(size=CELL / 2)
        soils.append(scene.add("mesh", meshed[mesh]() - hole, material, domains, group="soil"))
    for part in soils:
        part.setStress(-pressure * np.eye(3))
    cells = blockMesh(centre - half, centre + half, CELL / 2)
    block = scene.add("block", cells, stiff, mpm.APDI(), group="block")
    velocity = velocity or (0,) * (dim - 1) + (-0.4,)
    drive = [mpm.Drive(block, velocity=velocity, ramp=0.05, name="drive")] if isDriven else []
    walls = ("left", "right", "bottom", "top", "front", "back")[: 2 * dim]
    contact = mpm.Contact(**{"impactLoss": 1, **contact})
    scene.engines = chain(contact=contact, drive=drive, roller=walls)
    return scene, soil, block, contact


def pressureOf(soil):
    """Mean pressure over that of the start."""
    return np.average(-np.trace(soil.stress, axis1=1, axis2=2) / 3, weights=soil.volume) / PRESSURE


CASES = {
    "2D": {},
    "faces between nodes": dict(shift=0.1),
    "friction": dict(friction=0.3),
    "adhesion": dict(adhesion=5.0),
    "light, but driven": dict(density=0.05),
    "beside a wall": dict(at=(0.7, 2.4), velocity=(0.4, 0.1)),
    "graded grid": dict(graded=True),
    "USL": dict(scheme="USL"),
    "elastic impacts": dict(impactLoss=0),
    "3D": dict(dim=3),
}


THIN = dict(half=np.array([0.1, 0.6]), size=3.2)  # a plate of one cell
PLATES = [
    pytest.param(dict(at=(1.2, 1.6), velocity=(0.4, 0), impactLoss=0), 0.015, id="on lines"),
    pytest.param(dict(at=(1.25, 1.55), velocity=(0.4, 0), perCell=4), 0.02, id="between lines"),
    pytest.param(dict(at=(1.25, 1.55), perCell=4, isDriven=False), 0.02, id="at rest"),
    pytest.param(dict(at=(1.65, 1.25), velocity=(0, 0.4), perCell=4), 0.01, id="along itself"),
]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.verifies(
    "Block driven through a closed box of clay: mean pressure", reference="kept", tolerance=0.02
)
def test_pressure_and_volumes_stay(case, verified):
    scene, soil, block, contact = driven(**CASES[case])
    scene.run(until=0.3 if "dim" in CASES[case] else 0.5, progress=False)
    verified(pressureOf(soil), 1)
    within = np.quantile(soil.volume / soil.initialVolume, [0.005, 0.995])
    assert np.abs(within - 1).max() < 0.005
    lost = mpm.diagnostics.energyError(scene) / mpm.diagnostics.externalWork(scene)
    assert abs(lost) < (0.025 if case == "beside a wall" else 0.02)  # 0.021 found, of the others 0.005


@pytest.mark.parametrize("case, within", PLATES)
@pytest.mark.verifies(
    "Thin plate driven through a closed box of clay: mean pressure", reference="kept", tolerance=0.02
)
def test_pressure_stays_round_a_thin_plate(case, within, verified):
    """At the corners of the plates that lie between lines surfaces never press: while cells there waited for
    it, 40 % of the pressure was lost, also at rest. Behind the other one cells open and close: 0.5 % are
    lost (31 to 34 %, 61 % after 1 s, by shared cells without sides). The plates part the soil, and each side
    shares cells on its own."""
    scene, soil, block, contact = driven(**case, **THIN)
    if not case.get("isDriven", True):  # a block without stress gives way by its part of the volume, 2.3 %
        block.setStress(-PRESSURE * np.eye(3))
    scene.run(until=1.0 if within < 0.02 else 0.6, progress=False)
    assert scene._core.partedWalls
    verified(pressureOf(soil), 1, within=within)


def shake(scene, amplitude, frequency):
    drive, rate = scene.engines[1].drives[0], 2 * np.pi * frequency
    speed = lambda: amplitude * rate * np.cos(rate * scene.time)  # noqa: E731
    move = mpm.PyRunner(lambda: setattr(drive, "velocity", (speed(), 0.0)), iterPeriod=1)
    scene.engines = [move, *scene.engines]


@pytest.mark.parametrize("case", ["plate at rest", "shaken block"])
def test_no_energy_comes_from_nothing_in_elastic_soil(case):
    """Where the soil parts though its pressure holds it, MUSL's second velocities parted by less: their own
    hold knew nothing of what the first had used. Nothing was strained, and pressure drove the soil on: 20
    and 4 kJ came from nothing in 3 s."""
    elastic = dict(elastic=(3000, 1000), size=3.2, perCell=4, velocity=(0.0, 0.0), friction=0)
    if case == "plate at rest":
        scene, soil, block, contact = driven(at=(1.25, 1.6), half=THIN["half"], **elastic)
    else:
        scene, soil, block, contact = driven(pressure=5, **elastic)
        shake(scene, 0.01, 4)
    scene.run(until=1.2, progress=False)
    assert mpm.diagnostics.energyError(scene) > -0.1  # kJ
    assert np.abs(soil.velocity).max() < (0.5 if case == "plate at rest" else 1.5)


@pytest.mark.parametrize("size, speed, within", [(4.0, 0.4, 0.03), (2.4, 0.4, 0.08), (2.4, 0.2, 0.03)])
def test_pressure_stays_where_soil_parts_from_a_block_and_comes_back(size, speed, within):
    """A block is torn out of a corner: rho c v is 100 kPa for each face, and as much again where
    waves meet walls. Single cells open; their gaps are used up before the soil is pressed again.
    In the small box 1e-4 of the volume are 5 kPa. It had 222 of 200 kPa after 0.6 s when what the
    last step of a gap had pressed too much was lost, and a cell that had been touched could open
    again in the same step."""
    start = 1.6 if size == 4 else 0.8
    scene, soil, block, contact = driven(size=size, at=(start, start), velocity=(speed, speed))
    scene.run(until=1.0 if size == 4 else 0.6, progress=False)
    assert pressureOf(soil) == pytest.approx(1, abs=within)


@pytest.mark.parametrize("what", ["below", "beside", "round"])
def test_meshes_of_the_soil_share_cells_like_its_boxes(what):
    """A block in soil that is a mesh below it, on one side of it, or two cells away all round. (Left of
    200 kPa while only the cells with boxes were shared: 191, 142, 193.)"""
    scene, soil, *_ = driven(shift=0.0, mesh=what)
    scene.run(until=0.3, progress=False)
    bodies = [soil, *(body for body in scene.bodies if body.name == "mesh")]
    pressure = np.concatenate([-np.trace(body.stress, axis1=1, axis2=2) / 3 for body in bodies])
    volume = np.concatenate([body.volume for body in bodies])
    assert np.average(pressure, weights=volume) == pytest.approx(PRESSURE, rel=0.01)


@pytest.mark.parametrize("dim", [2, 3])
def test_soil_under_pressure_rests_beside_a_block_that_is_held_still(dim):
    """The pressure of the cells is in equilibrium with itself. Without shared cells 18 %
    are gone after 0.12 s, and soil moves at 0.9 m/s."""
    scene, soil, block, contact = driven(dim, velocity=(0.0,) * dim)
    scene.run(until=0.03, progress=False)
    assert pressureOf(soil) == pytest.approx(1, abs=1e-10)
    assert np.abs(soil.velocity).max() < 1e-7


@pytest.mark.parametrize("dim", [2, 3])
def test_without_shared_cells_the_pressure_goes(dim):
    scene, soil, block, contact = driven(dim, sharedCells=False)
    scene.run(until=0.2, progress=False)
    assert pressureOf(soil) < 0.6
    assert len(contact.cells) == 0


@pytest.mark.parametrize(
    "scheme", ["MUSL", "USL", pytest.param("USF", marks=pytest.mark.filterwarnings("ignore"))]
)
def test_forces_are_those_of_the_drive(scheme):
    """What the soil does to the block, through shared cells and by contact, the drive resists."""
    scene, soil, block, contact = driven(scheme=scheme, friction=0.2)
    scene.run(until=0.2, progress=False)
    force = contact.forceOn("block")
    assert force[1] > 50
    drive = next(c for c in scene.constraints if c.name == "drive")
    assert force[:2] == pytest.approx(-np.array(drive._core.reaction[:2]), abs=1e-9 * force[1])
    assert contact.contactTable()["force"].sum(axis=0) == pytest.approx(force, abs=1e-9 * force[1])


def test_the_same_bits_with_threads_in_steps_and_after_a_restart():
    scene = withAnyThreads(lambda threads: driven(threads=threads)[0], 70)
    inSteps = driven()[0]
    for _ in range(70):
        inSteps.step()
    assert bits(inSteps) == bits(scene)
    restarted(scene, 50)


def test_an_estimate_of_the_step_changes_nothing():
    plain, asked = driven()[0], driven()[0]
    for scene in (plain, asked):
        scene.dt = 5e-4
        scene.run(steps=40, progress=False)
    asked.criticalTimeStep()
    for scene in (plain, asked):
        scene.run(steps=40, progress=False)
    assert bits(asked) == bits(plain)


TOP = 1.6  # m, of the soil below a free surface


def onBed(gap, velocity, soil="clay", width=2.4, at=0.8, gravity=0.0, friction=0.0):
    """Scene, block, contact, drive: a block that is moved on a bed or down on it.

    gap : in cells, between the free surface and the block. at : left edge of the block, m.
    """
    scene = mpm.Scene((0, 0), (width, 2.8), CELL)
    elastic = mpm.LinearElastic(density=1.8, lame=(1500, 1000))
    clay = mpm.MohrCoulombDruckerPrager(density=1.8, lame=LAME, cohesion=STRENGTH, frictionAngle=0)
    material = clay if soil == "clay" else elastic
    bed = box((0, 0), (width, TOP))
    soil = scene.add("soil", bed, material, mpm.UGIMP(perCell=2), group="soil", fbar=True)
    soil.setStress(1.8 * gravity * (soil.position[:, 1] - TOP)[:, None, None] * np.eye(3))
    bottom = TOP + gap * CELL
    mesh = geotech.quadrilaterals(
        *np.meshgrid(np.linspace(at, at + 0.8, 9), np.linspace(bottom, bottom + 0.6, 7))
    )
    block = scene.add("block", mesh, elastic, mpm.APDI(), group="block")
    contact = mpm.Contact(friction=friction, impactLoss=1)
    drive = mpm.Drive(block, velocity=velocity)
    walls = ("left", "right", "bottom")
    scene.engines = chain(contact=contact, drive=drive, roller=walls, gravity=(0, -gravity))
    return scene, block, contact, drive


@pytest.mark.parametrize("gap", [0.05, 0.15, 0.3, 1.0])
def test_no_force_before_surfaces_meet(gap):
    """gap : in cells, between a free surface and a block that comes down on it."""
    scene, block, contact, drive = onBed(gap, velocity=(0, -0.4))
    least = 0.0
    while (left := block.vertices[:, 1].min() - TOP) > -0.5 * CELL:
        scene.run(steps=2, progress=False)
        force = contact.forceOn("block")[1]
        least = min(least, force)
        assert left < 0.05 * CELL or force == 0
    assert force > 20 and least > -1e-4 * force
    assert np.any(np.array(contact.gaps) == 0)  # and now cells are shared


def test_friction_counts_all_that_presses_and_no_more():
    """A block under its weight is dragged over an elastic bed: cells resist most of it. Counted as
    pressure times area it was 7 % more than the cells resist."""
    scene, block, contact, drive = onBed(0, (0.4, None), "elastic", width=4, gravity=10, friction=0.3)
    scene.run(until=0.4, progress=False)
    before, up, closed = contact.frictionWork, [], 0
    while scene.time < 1.2:
        scene.run(steps=4, progress=False)
        up.append(contact.forceOn("block")[1])
        closed += np.count_nonzero(np.array(contact.gaps) == 0)
    assert closed > 4 * len(up)
    assert np.mean(up) == pytest.approx(1.8 * 0.8 * 0.6 * 10, rel=0.03)
    way = 0.4 * (scene.time - 0.4)
    assert contact.frictionWork - before == pytest.approx(0.3 * np.mean(up) * way, rel=0.02)


@pytest.mark.parametrize("offset", [0.05, 0.15])
def test_a_block_on_a_free_surface_is_not_pushed_along_it(offset):
    """offset : of its edges from the nodes, m. What the cells at its ends put on its sides was 1.4 %
    of its weight, by where its edges lay in the grid, and moved it by 6 cm in a second."""
    scene, block, contact, drive = onBed(0, (0, None), "elastic", width=3.2, at=1.2 + offset, gravity=10)
    scene.run(until=0.3, progress=False)
    start = np.array(contact.impulses)
    scene.run(until=0.8, progress=False)
    along, up = (np.array(contact.impulses) - start)[:2]
    assert up == pytest.approx(0.5 * 1.8 * 0.8 * 0.6 * 10, rel=0.05)
    assert abs(along) < 0.005 * up


def test_a_block_that_is_lifted_from_clay_is_not_held():
    """The surfaces part as soon as what the cells press them together with is used up. One that
    counted it as pressure times area was held by 4 % of what had pressed it."""
    scene, block, contact, drive = onBed(0, (0, -0.4), gravity=10)
    scene.run(until=0.15, progress=False)
    before = contact.impulses[1]
    scene.run(until=0.25, progress=False)
    pressed = (contact.impulses[1] - before) / 0.1  # a single step swings by 15 kN
    depth = 0.08  # m, on the mean
    assert pressed > (2 + np.pi) * STRENGTH * 0.8 + 18 * depth * 0.8  # limit load, kN: a lower bound
    drive.velocity = (0, 0.4)
    start, least = block.position[:, 1].min(), 0.0
    while block.position[:, 1].min() < start + CELL:
        scene.run(steps=4, progress=False)
        least = min(least, contact.forceOn("block")[1])
    assert least > -1e-4 * pressed


@pytest.mark.parametrize("density", [0.9, 0.3, 0.03])
def test_the_step_falls_with_the_density_of_bodies_that_nothing_drives(density):
    """The pressure of the soil, with its stiffness, acts on their nodes. At the step of soil and body
    by themselves a block of 0.3 flew off after 40 steps. Below 0.04 of the soil's density cells are
    not shared. A body that is driven whole answers to nothing."""
    mayShare = density > 0.04 * 1.5
    for isDriven in (True, False):
        step = {}
        for sharedCells in (True, False):
            scene, soil, block, contact = driven(density=density, isDriven=isDriven, sharedCells=sharedCells)
            block.setStress(-PRESSURE * np.eye(3))
            step[sharedCells] = scene.criticalTimeStep()
            scene.run(steps=300, progress=False)
            assert bool(len(contact.cells)) == (sharedCells and (isDriven or mayShare))
            if sharedCells and mayShare:
                assert pressureOf(soil) == pytest.approx(1, abs=0.03)
                assert np.abs(block.velocity).max() < 1
        factor = 1 if isDriven or not mayShare else np.sqrt(density / 1.5)
        assert step[True] / step[False] == pytest.approx(factor, rel=1e-6)


@pytest.mark.parametrize("what", [dict(separation=False), dict(constraints="nodes")])
def test_cells_are_shared_only_where_facets_own_points(what):
    scene, soil, block, contact = driven(**what)
    scene.run(steps=20, progress=False)
    assert len(contact.cells) == 0


def test_cells_are_told_only_while_they_are_shared():
    scene, soil, block, contact = driven()
    scene.run(steps=20, progress=False)
    assert len(contact.cells) == len(contact.gaps) > 0
    contact.sharedCells = False
    scene.run(steps=20, progress=False)
    assert len(contact.cells) == len(contact.gaps) == 0


@pytest.mark.parametrize("constraints", ["auto", "facets"])
def test_soil_that_is_cut_to_an_outline_keeps_its_pressure(constraints):
    """A disc in soil that is cut round it: its boxes carry the outline. A fifth was lost in 0.22 m."""
    scene = mpm.Scene((0, 0), (3.2, 3.2), CELL, threads=1)
    clay = mpm.MohrCoulombDruckerPrager(density=1.5, lame=LAME, cohesion=STRENGTH, frictionAngle=0)
    centre = np.array((1.6, 1.8))
    cut = box((0, 0), (3.2, 3.2)) - disc(tuple(centre), HALF)
    soil = scene.add("soil", cut, clay, mpm.UGIMP(perCell=2, cut=True), group="soil")
    x, y = np.meshgrid(*2 * [np.linspace(-1, 1, 17)])
    x, y = HALF * x * np.sqrt(1 - y**2 / 2), HALF * y * np.sqrt(1 - x**2 / 2)
    stiff = mpm.LinearElastic(density=1.5, young=2e4, poisson=0.3)
    mesh = geotech.quadrilaterals(centre[0] + x, centre[1] + y)
    bar = scene.add("bar", mesh, stiff, mpm.APDI(), group="bar")
    for body in (soil, bar):
        body.setStress(-PRESSURE * np.eye(3))
    contact = mpm.Contact(friction=0.0, constraints=constraints)
    scene.engines = chain(
        contact=contact,
        roller=("left", "right", "bottom", "top"),
        drive=mpm.Drive(bar, velocity=(0, -0.4), ramp=0.1),
    )
    scene.run(until=0.6, progress=False)
    assert soil.outline() is not None and len(contact.cells) > 0
    # By nodes a gap of 1e-4 of the soil opens behind the disc after 0.2 m.
    assert pressureOf(soil) == pytest.approx(1, abs=0.02 if constraints == "facets" else 0.025)
