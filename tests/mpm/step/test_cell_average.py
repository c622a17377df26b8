# SPDX-License-Identifier: GPL-2.0-or-later
"""F-bar: after a step the mean stress is linear in each cell of a body. The volume-weighted mean of the
cell and the deviators stay, the
slopes are those towards the neighbouring cells, and no value is beyond theirs."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain

CELL = 0.5
STRONG = dict(density=2.0, lame=(1e3, 1e3), cohesion=1e3, frictionAngle=0.0, dilatancyAngle=0.0)


def stressed(kind, stress, fbar=True, dim=2):
    """A block at rest with stress(positions), (N,) or (N, 3, 3), after one step too short to change it.
    Returns the body and the stress before."""
    scene = mpm.Scene((0,) * dim, (4,) * dim, CELL)
    type_ = mpm.APDI(size=CELL / 2) if kind == "APDI" else mpm.UGIMP(perCell=2)
    body = scene.add(
        "block",
        mpm.box((1, 0.5, 1)[:dim], (3, 2.5, 3)[:dim]),
        mpm.MohrCoulombDruckerPrager(**STRONG),
        type_,
        fbar=fbar,
    )
    given = stress(body.position)
    body.stress[...] = given if given.ndim == 3 else given[:, None, None] * np.eye(3)
    before = body.stress.copy()
    scene.dt = 1e-13
    scene.run(steps=1, progress=False)
    return body, before


def random(position):
    stress = np.random.default_rng(1).normal(size=(len(position), 3, 3))
    stress += stress.transpose(0, 2, 1)
    stress[:, :2, 2] = stress[:, 2, :2] = 0
    return stress


def mean(stress):
    return np.trace(stress, axis1=1, axis2=2) / 3


def cells(body):
    """Cell of each particle, (N, dim)."""
    return np.floor(body.position / CELL + 1e-9).astype(int)


def isInside(body):
    """Whether the cell of a particle has neighbours with particles on all sides."""
    cell = cells(body)
    return ((cell > cell.min(axis=0)) & (cell < cell.max(axis=0))).all(axis=1)


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
def test_cells_keep_their_mean_and_particles_their_deviator(kind):
    body, before = stressed(kind, random)
    p, old, cell = mean(body.stress), mean(before), cells(body)
    assert np.abs(p - old).max() > 1
    for c in np.unique(cell, axis=0):
        inside = (cell == c).all(axis=1)
        assert np.average(p[inside], weights=body.volume[inside]) == pytest.approx(
            np.average(old[inside], weights=body.volume[inside]), abs=1e-8
        )
    assert body.stress - p[:, None, None] * np.eye(3) == pytest.approx(
        before - old[:, None, None] * np.eye(3), abs=1e-8
    )


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_linear_field_stays_and_what_alternates_within_cells_goes(kind, dim):
    slope = np.array([3.0, -5.0, 2.0])[:dim]
    body, before = stressed(
        kind, lambda x: 7 + x @ slope + 4 * (-1) ** np.floor(x[:, 1] / (CELL / 2) + 1e-9), dim=dim
    )
    p, inside = mean(body.stress), isInside(body)
    assert p[inside] == pytest.approx(7 + body.position[inside] @ slope, abs=1e-8)
    assert mean(before)[inside] != pytest.approx(p[inside], abs=1)  # control


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
def test_a_cell_at_the_edge_of_the_body_is_constant_across_it(kind):
    body, _ = stressed(kind, lambda x: 10 * x[:, 1])
    cell, p = cells(body)[:, 1], mean(body.stress)
    assert np.ptp(p[cell == cell.min()]) < 1e-8
    assert np.ptp(p[cell == cell.min() + 1]) == pytest.approx(10 * CELL / 2)  # control


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
def test_no_value_is_beyond_the_means_of_the_neighbours(kind):
    """Along one axis: a field that steepens, falls off and has an extremum."""
    body, _ = stressed(kind, lambda x: np.where(x[:, 1] < 2, np.exp(3 * x[:, 1]), 0.0))
    cell, p = cells(body)[:, 1], mean(body.stress)
    means = {c: p[cell == c].mean() for c in np.unique(cell)}
    for c in list(means)[1:-1]:
        around = [means[c - 1], means[c], means[c + 1]]
        assert min(around) - 1e-8 <= p[cell == c].min() and p[cell == c].max() <= max(around) + 1e-8
    steep = list(means)[1]
    assert np.ptp(p[cell == steep]) > 0.1 * means[steep]  # control: elsewhere it is not constant
    top = max(means, key=means.get)
    assert np.ptp(p[cell == top]) < 1e-8  # at an extremum it is


@pytest.mark.parametrize("kind", ["BSpline", "UGIMP"])
@pytest.mark.parametrize("dim", [2, 3])
def test_the_forces_do_no_more_work_than_the_strains(kind, dim):
    """A bed of cork settles on a held floor, where cells and splines see different changes of volume. With
    tr/3 in the forces, while two axes strain, B-splines gain 4 % of the work of gravity. Found: a loss of 0.2
    to 0.5 %."""
    scene = mpm.Scene((0,) * dim, (7, 1, 6) if dim == 3 else (7, 6), CELL, threads=1)
    cork = mpm.LinearElastic(density=1.6, young=2e3, poisson=0.0)
    upper = (7, 1, 1) if dim == 3 else (7, 1)
    scene.add("bed", mpm.box((0,) * dim, upper), cork, getattr(mpm, kind)(perCell=2), fbar=True)
    sides = ("left", "right", "front", "back")[: 2 * dim - 2]
    history = mpm.History(iterPeriod=1)
    gravity = (0,) * (dim - 1) + (-9.81,)
    scene.engines = [*chain(fixed="bottom", roller=sides, gravity=gravity), history]
    scene.dt = 4e-4
    scene.run(steps=150, progress=False)
    work = history["externalWork"]
    inside = history["kineticEnergy"] + history["internalWork"]
    assert (inside - inside[0] - work + work[0]).max() < 1e-6 * np.abs(work).max()


def test_without_fbar_each_particle_keeps_its_own():
    body, before = stressed("UGIMP", random, fbar=False)
    assert body.stress == pytest.approx(before, abs=1e-8)


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_stress_that_is_no_number_ends_the_run_with_its_error(kind, dim):
    """Positions become nan before F-bar looks which cells they are in."""
    scene = mpm.Scene((0,) * dim, (4,) * dim, CELL)
    type_ = mpm.APDI(size=CELL / 2) if kind == "APDI" else mpm.UGIMP(perCell=2)
    body = scene.add(
        "block", mpm.box((1,) * dim, (3,) * dim), mpm.MohrCoulombDruckerPrager(**STRONG), type_, fbar=True
    )

    def spoil():
        body.stress[3] = np.nan

    scene.engines = [*scene.engines, mpm.PyRunner(spoil, iterPeriod=1)]
    with pytest.raises(RuntimeError, match="no finite position|distorted|inverted|not positive"):
        scene.run(steps=3, progress=False)


def test_all_soil_of_a_cell_stands_open_by_as_much():
    """The solid volume of each box stays, and so does the bulk volume of the cell."""
    scene = mpm.Scene((0, 0), (1, 1), CELL)
    sand = mpm.MohrCoulombDruckerPrager(**(STRONG | dict(cohesion=5.0, frictionAngle=0.5)), closing=True)
    body = scene.add("sand", mpm.box((0, 0), (1, CELL)), sand, mpm.UGIMP(perCell=2))
    isFirst = body.position[:, 0] < CELL
    body.opening[np.flatnonzero(isFirst)[0]] = 0.1
    body.stress[...] = 5.0 / np.tan(0.5) * np.eye(3)
    bulk, solid = body.volume.copy(), body.volume * np.exp(-body.opening)
    scene.dt = 1e-13
    scene.run(steps=1, progress=False)
    assert body.opening[isFirst] == pytest.approx(-np.log((3 + np.exp(-0.1)) / 4), rel=1e-9)
    assert (body.opening[~isFirst] == 0).all()
    assert body.volume == pytest.approx(solid, rel=1e-12)
    assert body.bulkVolume.sum() == pytest.approx(bulk.sum(), rel=1e-12)
