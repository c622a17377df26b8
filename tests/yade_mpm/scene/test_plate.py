# SPDX-License-Identifier: GPL-2.0-or-later
"""Beams in 3D, which are plates: soil as in plane strain, energy, checkpoints, threads, shapes."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import restarted, withAnyThreads
from yade_mpm import box

SECTION = dict(EI=500.0, EA=1e5, weight=0.2, thickness=0.5)


def wallInSand(dim, wide=0.25, threads=1, **section):
    """A wall in sand, which is dug away on its right side at once; 3D: a slice of it between rollers."""

    def point(x, z, y=0.0):
        return (x, y, z) if dim == 3 else (x, z)

    def block(lower, upper):
        return box(point(*lower), point(*upper, wide))

    made = mpm.Scene(point(0, 0), point(4, 3, wide), 0.25, gravity=9.81, damping=0.3, threads=threads)
    made.fix("bottom")
    made.roller("left", "right", *(("front", "back") if dim == 3 else ()))
    across = {"width": (0, wide, 0)} if dim == 3 else {}
    beam = mpm.Beam([point(2, 0.5), point(2, 2.5)], **across, **{**SECTION, **section})
    sand = mpm.MohrCoulomb(density=1.8, young=2e4, poisson=0.3, cohesion=1.0, frictionAngle=0.55)
    soil = made.add("soil", block((0, 0), (4, 2)) - beam.region, sand, mpm.UGIMP())
    wall = made.add("wall", beam)
    made.contact(wall, soil, friction=0.2).sharedCells = False
    made.initialStress(surface=2, K0=0.5)
    made.remove(region=block((2.25, 1), (4, 2)))
    made.dt = 5e-4
    return made


def test_soil_presses_on_a_slice_of_a_wall_as_in_plane_strain():
    found = []
    for dim, width in ((2, 1), (3, 0.25)):
        made = wallInSand(dim)
        wall = made["wall"]
        made.run(steps=100, progress=False)
        before = mpm.facePressure(wall)
        made.run(steps=100, progress=False)
        pressure = mpm.facePressure(wall, since=before)
        M = mpm.sectionForces(wall, "xyz"[dim - 1]).M
        moment = np.abs(M if dim == 2 else M[:, 0]).max()
        found.append(
            np.array([pressure.side("left").total[0], pressure.side("right").total[0], moment]) / width
        )
    assert found[0][0] > 3 and found[0][1] < -2
    assert found[1] == pytest.approx(found[0], rel=0.03)


def test_threads_and_a_restart_change_no_bit(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = withAnyThreads(lambda threads: wallInSand(3, threads=threads, limitMoment=0.1), 60)
    assert made["wall"].plasticCurvature.any()
    other = restarted(made, 40)
    for name in ("bendingMoment", "hoopMoment", "twistingMoment", "elasticEnergy"):
        assert np.array_equal(getattr(other["wall"], name), getattr(made["wall"], name))


def floating(width=(0, 1, 0)):
    """A plate in an empty scene."""
    made = mpm.Scene((0, 0, 0), (4, 3, 4), 0.25, threads=1)
    return made, made.add("wall", mpm.Beam([(1, 1, 2), (3, 1, 2)], width=width, **SECTION))


def test_a_plate_turns_without_strain():
    made, wall = floating()
    away = wall.position - wall.position.mean(axis=0)
    wall.velocity[:] = np.cross((0.3, 1.0, 0.2), away)
    kinetic = 0.5 * wall.mass @ (wall.velocity**2).sum(axis=1)
    made.dt = 0.01
    made.run(until=1.0, progress=False)
    U, _, V = np.linalg.svd((wall.position - wall.position.mean(axis=0)).T @ away)
    assert np.arccos((np.trace(U @ V) - 1) / 2) > 0.8  # rad
    assert mpm.diagnostics.storedEnergy(made) < 5e-3 * kinetic
    for name in ("bendingMoment", "hoopMoment", "twistingMoment"):
        assert np.abs(getattr(wall, name)).max() < 1e-3 * SECTION["EI"]
    for name in ("normalForce", "hoopForce", "membraneShear"):
        assert np.abs(getattr(wall, name)).max() < 1e-3 * SECTION["EA"]


def test_the_energy_of_a_plate_is_in_the_balance():
    made = mpm.Scene((0, 0, 0), (3, 1.5, 3), 0.25, threads=1, gravity=1.0)
    made.fix("left")
    line = [(0, 0.5, 2), (2, 0.5, 2)]
    wall = made.add("wall", mpm.Beam(line, width=(0, 0.5, 0), **{**SECTION, "limitMoment": 0.2}))
    made.dt = 0.005
    made.run(until=0.6, progress=False)
    assert wall.plasticCurvature.any()
    assert mpm.diagnostics.storedEnergy(made) > 0
    assert mpm.diagnostics.internalWork(made) > 1.2 * mpm.diagnostics.storedEnergy(made)
    assert abs(mpm.diagnostics.energyError(made, relative=True)) < 0.02


@pytest.mark.parametrize("width", [(0, 1, 0), (0, -1, 0)])
def test_tension_on_the_side_of_line_times_width_is_a_positive_moment(width):
    """A strip that hangs down from its held start has tension above."""
    made = mpm.Scene((0, -2, 0), (3, 2, 2), 0.25, threads=1, gravity=1e-3)
    made.fix("left")
    wall = made.add("wall", mpm.Beam([(0, 0, 1), (2, 0, 1)], width=width, **SECTION))
    made.dt = 10.0
    made.run(steps=6, progress=False)
    left = np.cross((1, 0, 0), width)[2]
    assert np.sign(wall.bendingMoment[0]) == np.sign(left)
    assert np.abs(wall.bendingMoment).max() == pytest.approx(0.5 * 0.2 * 1e-3 * 2**2, rel=0.15)


def test_lines_that_turn_and_rings_are_drawn_along_any_axis():
    angle = np.linspace(0, 2 * np.pi, 25)
    ring = 3 + 1.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ring[-1] = ring[0]
    for axis in range(3):
        for points in (ring, np.array([(2, 1), (2, 3), (4, 4)])):
            line = np.insert(points.astype(float), axis, 1.0, axis=1)
            width = np.zeros(3)
            width[axis] = 2.0
            made = mpm.Scene((0, 0, 0), (6, 6, 6), 0.25, threads=1)
            beam = mpm.Beam(line, width=width, **SECTION)
            wall = made.add("wall", beam)
            lower, upper = beam.region.bounds()
            assert (wall.vertices >= lower - 1e-9).all() and (wall.vertices <= upper + 1e-9).all()
            length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
            assert wall.mass.sum() == pytest.approx(2 * length * SECTION["weight"], rel=0.01)
            made.dt = 1e-3
            made.run(steps=1, progress=False)
