# SPDX-License-Identifier: GPL-2.0-or-later
"""D16: collision of two elastic disks.

Set-up: unit square, disks of radius 0.2 at (0.2, 0.2) and (0.8, 0.8), E = 1000, nu = 0.3, rho = 1000,
neo-Hookean,
velocities (0.1, 0.1) and (-0.1, -0.1); 40 x 40 cells, 2 x 2 particles per cell, half the critical time
step, FLIP 1.
The disks are separate bodies that share one velocity field: they meet through the grid, without contact
law. At the end the same with
contact: a group each, staircases of boxes or domains and meshes that follow the circle; surfaces touch at
1.586 s.
Reference: kinetic energy 2.513 at the start, momentum zero, contact at t ~ 1.5 s (the disks themselves
touch at 1.586 s,
their nodes some two cells earlier), total energy kept through the rebound.
Source: Sulsky, Chen & Schreyer 1994, Comput. Methods Appl. Mech. Eng. 118, 179-196.
Tolerance with contact: total energy 3 % (measured -2.2 to +2.6 %; boxes in a staircase 4 %, measured -3.8 %;
USF at a quarter of the critical step, as at
half of it it gains 6 %), first exchange within two steps of the touch (staircases: 0.05 s), overlap of
meshes 0.015 h.
Tolerance: 1 % (initial energy: disks of square particles), momentum 1e-12, contact 0.1 s, total energy 3 %.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import elasticEnergy
from yade_mpm import disc

TYPES = pytest.mark.parametrize("type_", [mpm.UGIMP(perCell=2), mpm.APDI(size=0.0125)], ids=["UGIMP", "APDI"])


class Collision:
    """History rows: time, kinetic, elastic energy, largest component of the momentum."""

    def __init__(self, type_, scheme="MUSL", until=3.2, contact=None, step=0.5, threads=1):
        scene = mpm.Scene(lower=(0, 0), upper=(1, 1), cell=1 / 40, scheme=scheme, threads=threads)
        rubber = mpm.NeoHookean(density=1000, young=1000, poisson=0.3)
        isMesh = type_ == "mesh"
        shapes = [squircle(c) if isMesh else disc((c, c), 0.2) for c in (0.2, 0.8)]
        # The four corners of the mesh are nearly triangles: with the default of 0.05 patterns flatten them.
        type_ = mpm.APDI(hourglass=0.2) if isMesh else type_
        self.disks = [
            scene.add(name, shape, rubber, type_, group=name if contact else "main")
            for name, shape in zip(("lower", "upper"), shapes)
        ]
        self.disks[0].velocity, self.disks[1].velocity = [0.1, 0.1], [-0.1, -0.1]
        if isMesh:
            step *= 2 / 3
        scene.dt = step * scene.criticalTimeStep()
        self.scene, self.contact, self.rows, self.pushes, self.acts = scene, contact, [], [], []
        self.note()
        engines = scene.engines
        if contact:
            engines.insert(
                engines.index(next(e for e in engines if isinstance(e, mpm.GridSolver))) + 1, contact
            )
        scene.engines = engines + [mpm.PyRunner(self.note, iterPeriod=1)]
        scene.run(until=until, progress=False)
        self.time, self.kinetic, self.elastic, self.momentum = np.array(self.rows).T

    def note(self):
        kinetic = sum(0.5 * b.mass @ (b.velocity**2).sum(axis=1) for b in self.disks)
        momentum = sum(b.mass @ b.velocity for b in self.disks)
        self.pushes.append([self.contact.forceOn(b.name)[:2] for b in self.disks] if self.contact else None)
        self.acts.append(self.contact is not None and len(self.contact.contactTable()["gap"]) > 0)
        self.rows.append(
            [self.scene.time, kinetic, sum(map(elasticEnergy, self.disks)), np.abs(momentum).max()]
        )


def squircle(c, n=32):
    """A grid of n x n quadrilaterals bent into a disk about (c, c)."""
    x, y = np.meshgrid(*2 * [np.linspace(-1, 1, n + 1)], indexing="ij")
    x, y = x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)
    first = np.arange(n)[:, None] * (n + 1) + np.arange(n)
    return (
        c + 0.2 * np.sqrt(0.5) * np.stack([x - y, x + y], axis=2).reshape(-1, 2),
        np.stack([first, first + n + 1, first + n + 2, first + 1], axis=2).reshape(-1, 4),
    )


@TYPES
@pytest.mark.parametrize("scheme", ["MUSL", "USF"])
@pytest.mark.verifies("Two discs collide: energy", reference="kept", tolerance=0.03)
def test_energy_and_momentum_are_kept_through_the_rebound(type_, scheme, verified):
    run = Collision(type_, scheme)
    total = run.kinetic + run.elastic
    assert run.kinetic[0] == pytest.approx(2.513, rel=0.01)
    assert run.momentum.max() <= 1e-12
    assert run.time[np.argmax(run.elastic > 1e-3 * total[0])] == pytest.approx(1.5, abs=0.1)
    assert run.kinetic.min() < 0.1 * total[0]  # control: they did stop each other
    verified(total, total[0])


@TYPES
def test_the_rebound_keeps_the_symmetry_of_the_disks(type_):
    run = Collision(type_)
    lower, upper = (b.mass @ b.velocity / b.mass.sum() for b in run.disks)
    assert lower == pytest.approx(-upper, abs=1e-12)
    assert lower[0] == pytest.approx(lower[1], abs=1e-12)
    assert lower[0] < -0.08  # turned round, a part of the energy stays in vibration


def test_control_stress_update_last_loses_energy():
    """USL loses more than 3 % at this step, which the tolerance tells apart."""
    run = Collision(mpm.UGIMP(perCell=2), "USL")
    total = run.kinetic + run.elastic
    assert total.min() < 0.97 * total[0]


# --- with contact ---------------------------------------------------------------------------------------
CUT = mpm.UGIMP(perCell=2, cut=True)
SHAPES = pytest.mark.parametrize(
    "type_", [mpm.UGIMP(perCell=2), CUT, mpm.APDI(size=0.0125), "mesh"], ids=["UGIMP", "cut", "APDI", "mesh"]
)
TOUCH = 1.586  # s


@SHAPES
@pytest.mark.parametrize("scheme, step", [("MUSL", 0.5), ("USF", 0.25)])
@pytest.mark.verifies(
    "Two discs collide with Contact(impactLoss=0): energy", reference="kept", tolerance=0.04
)
def test_disks_in_contact_keep_energy_and_momentum(type_, scheme, step, verified):
    """Where nothing is lost in an impact."""
    run = Collision(type_, scheme, contact=mpm.Contact(impactLoss=0), step=step)
    total = run.kinetic + run.elastic
    assert run.momentum.max() <= 1e-12
    assert run.kinetic.min() < 0.1 * total[0]
    isStaircase = not (isinstance(type_, (str, mpm.APDI)) or type_.cut)
    verified(total, total[0], within=0.04 if isStaircase else 0.03)
    assert mpm.diagnostics.contactEnergy(run.scene) == pytest.approx(0, abs=1e-12)  # no friction


@SHAPES
def test_an_impact_that_stops_a_layer_costs_disks_little(type_):
    """The default: 0.1 to 1.6 % of the speed of rebound, 4 to 8 % of the energy, of which 2 to 3 % count as
    lost in contact."""
    kept, lost = (Collision(type_, contact=mpm.Contact(impactLoss=loss)) for loss in (0, 1))
    speeds = [run.disks[1].mass @ run.disks[1].velocity[:, 0] for run in (kept, lost)]
    assert 0.98 < speeds[1] / speeds[0] < 1.001
    total = lost.kinetic + lost.elastic
    assert 0.92 * total[0] < total.min() < 0.96 * total[0]
    assert total.max() < 1.001 * total[0]
    assert 0.01 < mpm.diagnostics.contactEnergy(lost.scene) / total[0] < 0.04


@SHAPES
def test_disks_act_on_each_other_from_touch_to_parting_and_not_before(type_):
    run = Collision(type_, contact=mpm.Contact())
    lower, upper = np.array(run.pushes).transpose(1, 0, 2)
    pushed = np.flatnonzero(run.acts)
    late = run.time[pushed[0]] - TOUCH
    assert 0 <= late <= (0.05 if isinstance(type_, mpm.APDI) else 2 * run.scene.dt)
    assert (run.elastic[: pushed[0]] <= 1e-12 * run.kinetic[0]).all()
    assert run.elastic.max() > 0.5 * run.kinetic[0]
    assert run.time[pushed[-1]] < 3.0
    assert np.abs(lower + upper).max() <= 1e-12 * np.abs(lower).max()


def outline(body):
    """Ends of the edges of a mesh that belong to one domain only, (n, 2, 2)."""
    edges = np.stack([body.cells, np.roll(body.cells, -1, axis=1)], axis=2).reshape(-1, 2)
    _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return body.vertices[edges[first[count == 1]]]


def overlapOfFacets(one, other):
    """How deep middles of the facets of one lie below the plane of the nearest facet of the other, m."""
    deep = 0.0
    for (points, _), (middles, areas) in ((one.outline(), other.outline()), (other.outline(), one.outline())):
        away = np.linalg.norm(points[:, None] - middles, axis=2)
        nearest = away.argmin(axis=1)
        normals = areas[nearest] / np.linalg.norm(areas[nearest], axis=1)[:, None]
        below = ((middles[nearest] - points) * normals).sum(axis=1)
        deep = max(deep, below[away.min(axis=1) < 0.025].max(initial=0.0))
    return deep


def overlap(one, other):
    """How deep vertices of one outline lie within the other, m."""
    if one.cells is None:
        return overlapOfFacets(one, other)
    deep = 0.0
    for points, (a, b) in (
        (outline(p)[:, 0], outline(q).transpose(1, 0, 2)) for p, q in ((one, other), (other, one))
    ):
        x, y = points.T[:, :, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            crosses = ((a[:, 1] > y) != (b[:, 1] > y)) & (
                x < a[:, 0] + (y - a[:, 1]) * (b - a)[:, 0] / (b - a)[:, 1]
            )
        inside = points[crosses.sum(axis=1) % 2 == 1]
        along = np.clip(((inside[:, None] - a) * (b - a)).sum(axis=2) / ((b - a) ** 2).sum(axis=1), 0, 1)
        away = np.linalg.norm(inside[:, None] - a - along[:, :, None] * (b - a), axis=2).min(axis=1)
        deep = max(deep, away.max(initial=0.0))
    return deep


@pytest.mark.parametrize(
    "type_, scheme, step, constraints, allowed",
    [
        ("mesh", "MUSL", 0.5, "nodes", 0.015),
        ("mesh", "USF", 0.25, "nodes", 0.015),
        ("mesh", "MUSL", 0.5, "auto", 0.022),  # facets, of one disk alone: 0.019
        (CUT, "MUSL", 0.5, "auto", 0.022),
        (CUT, "USF", 0.25, "auto", 0.027),
    ],
)
@pytest.mark.verifies(
    "Two discs collide with Contact: overlap over the cell", reference="none", tolerance=0.027
)
def test_disks_hardly_overlap(type_, scheme, step, constraints, allowed, verified):
    """Strained by 20 %; nodes alone would let meshes by 0.14 of a cell. 2 % are asked, 1 % is let pass.
    Facets of boxes do not quite move
    with the hat functions, as vertices of a mesh do: 0.020 and, under USF, 0.025 of a cell.
    """
    deepest, told, nearest = 0.0, 0.0, np.inf

    class Watched(Collision):
        def note(self):
            nonlocal deepest, told, nearest
            super().note()
            nearest = min(nearest, self.contact.contactTable()["gap"].min(initial=np.inf) * 40)
            told = max(told, self.contact.largestPenetration * 40)
            if self.scene.steps % 10 == 0:
                deepest = max(deepest, overlap(*self.disks) * 40)

    Watched(type_, scheme, contact=mpm.Contact(constraints=constraints), step=step)
    assert nearest < 1e-3  # they met
    verified(deepest, 0, scale=1, within=allowed)
    assert told == pytest.approx(deepest, rel=0.2, abs=1e-4)


def test_disks_in_contact_move_alike_on_any_number_of_threads():
    one, two = (Collision("mesh", contact=mpm.Contact(friction=0.2), until=1.8, threads=t) for t in (1, 2))
    assert all(
        (a.vertices == b.vertices).all() and (a.stress == b.stress).all()
        for a, b in zip(one.disks, two.disks)
    )
    assert one.kinetic[-1] < 0.9 * one.kinetic[0]  # they met


def test_control_without_contact_disks_act_on_each_other_before_they_touch():
    run = Collision("mesh", until=1.6)
    assert run.time[np.argmax(run.elastic > 1e-9 * run.kinetic[0])] < TOUCH - 0.1
