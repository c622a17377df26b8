# SPDX-License-Identifier: GPL-2.0-or-later
"""Frictional contact between groups of bodies (doc/explanation/contact.md). Pairs are named by their types:
base and what lies on it."""

from math import cos, radians, sin, tan

import numpy as np
import pytest
import yade_mpm as mpm
from contactScenes import CUT, PAIRS, SCHEMES, G, Incline, pressed, run, typeOf
from setups import chain, elastic
from yade_mpm import box


def inPlane(x, y, dim):
    """A vector (along, up) in two or three dimensions."""
    return (x, y) if dim == 2 else (x, 0.0, y)


# --- groups that neither slip nor separate are one body -------------------------------------------------
def stacked(contact, pair, dim, scheme):
    """A block on a slab under gravity that is oblique."""
    scene = mpm.Scene((0,) * dim, (4, 3) if dim == 2 else (2.5, 1, 2.5), 0.25, scheme=scheme, threads=1)
    wide = 3 if dim == 2 else 2
    at = (lambda a, b: box(a, b)) if dim == 2 else (lambda a, b: box((a[0], 0.25, a[1]), (b[0], 0.75, b[1])))
    scene.add("lower", at((0.25, 0), (wide, 1)), elastic(1e4), typeOf(pair[0], 0.25), group="a")
    scene.add("upper", at((0.75, 1), (wide - 0.5, 1.75)), elastic(1e4), typeOf(pair[1], 0.25), group="b")
    scene.engines = chain(contact=contact, gravity=inPlane(0.5, -G, dim), damping=0.1, fixed="bottom")
    scene.dt = 2e-4
    return run(scene, steps=300 if dim == 2 else 60)


def difference(one, other):
    most = max(np.abs(b.stress).max() for b in one.bodies)
    return max(np.abs(a.stress - b.stress).max() for a, b in zip(one.bodies, other.bodies)) / most


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("dim, pair", [(2, "uu"), (2, "ua"), (2, "aa"), (3, "ua"), (3, "aa")])
def test_groups_that_neither_slip_nor_separate_are_one_body(dim, pair, scheme):
    bonded = stacked(None, pair, dim, scheme)
    tied = stacked(mpm.Contact(slip=False, separation=False), pair, dim, scheme)
    assert difference(bonded, tied) < 1e-13
    assert (
        difference(bonded, stacked(mpm.Contact(), pair, dim, scheme)) > 5e-3
    )  # control: they could have slipped


def threeBlocks(groups):
    """Kinetic energy over its start, at ten times, of two blocks side by side that fall on a third."""
    scene = mpm.Scene((0, 0), (4, 3), 0.25, threads=1)
    soft = mpm.LinearElastic(density=2.0, lame=(4e3, 4e3))
    shapes = ((0.5, 0.5), (3.5, 1.25)), ((1, 1.375), (1.75, 2.375)), ((1.875, 1.375), (2.625, 2.625))
    bodies = [
        scene.add(f"block {group} {i}", box(*shape), soft, mpm.APDI(size=0.125), group=group)
        for i, (shape, group) in enumerate(zip(shapes, groups))
    ]
    bodies[1].velocity, bodies[2].velocity = (0.5, -1.5), (-1.0, -1.0)
    scene.engines = chain(contact=mpm.Contact(slip=False, separation=False))
    scene.dt = 2e-4
    start, energies = mpm.diagnostics.kineticEnergy(scene), []
    for _ in range(10):
        scene.run(steps=30, progress=False)
        energies.append(mpm.diagnostics.kineticEnergy(scene) / start)
    return np.array(energies)


def test_three_groups_that_neither_slip_nor_separate_are_as_two():
    """Each pair took the velocities of the start as they were before the others had made them agree: energy
    grew without bound, and a domain was inverted after 91 steps."""
    assert threeBlocks("abc") == pytest.approx(threeBlocks("abb"), abs=0.005)


@pytest.mark.parametrize(
    "scheme", ["MUSL", "USL"]
)  # USF strains with velocities that agree without friction (doc/explanation/contact.md)
@pytest.mark.parametrize("pair", ["uu", "ua", "aa"])
def test_much_friction_without_separation_bonds_what_presses(pair, scheme):
    """The law itself sticks here, not slip=False. With impactLoss=1 the particles take the whole exchange:
    0.1 %."""
    bonded = pressed(None, pair, scheme)

    def bySticking(impactLoss):
        contact = mpm.Contact(friction=100, separation=False, impactLoss=impactLoss)
        return difference(bonded, pressed(contact, pair, scheme))

    assert bySticking(0.0) < 1e-13
    assert 1e-4 < bySticking(1.0) < 2e-3
    assert (
        difference(bonded, pressed(mpm.Contact(friction=0.01, separation=False), pair, scheme)) > 2e-3
    )  # control: it slips


def test_a_dead_contact_bonds():
    dead = mpm.Contact()
    dead.dead = True
    assert difference(stacked(None, "ua", 2, "MUSL"), stacked(dead, "ua", 2, "MUSL")) == 0


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("pair", PAIRS + CUT)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_block_slides_down_an_incline(dim, pair, friction):
    incline = Incline(pair, friction, dim, time=0.15 if dim == 2 else 0.06)
    assert incline.acceleration() == pytest.approx(incline.expected(friction), rel=0.02)
    assert incline.penetration < 0.02
    if dim == 3:
        assert incline.velocity()[1] == pytest.approx(0.75 * incline.velocity()[0], rel=0.02)
    incline.solver.gravity = incline.gravity(0)  # control: a level block is only braked
    incline.time.clear(), incline.speed.clear()
    incline.follow(0.03)
    assert incline.acceleration() < 0.1


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("dim, friction", [(2, 0.6), (2, 0.8), (3, 0.6)])
def test_a_block_sticks_to_an_incline(dim, friction, pair):
    """tan 30 degrees = 0.577. Damping takes the jerk of the release; without friction it would let a block
    gain 0.5 m/s."""
    incline = Incline(pair, friction, dim, damping=0.5, time=0.2 if dim == 2 else 0.08)
    assert abs(incline.speed[-1]) < 1e-3
    friction, normal = (
        (incline.forces[-1][0] ** 2 + (dim == 3) * incline.forces[-1][1] ** 2) ** 0.5,
        incline.forces[-1][dim - 1],
    )
    assert friction / normal == pytest.approx(tan(radians(30)), rel=0.01)
    assert incline.penetration < 0.02


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_scheme_slides_and_sticks(scheme):
    assert Incline("ua", 0.3, scheme=scheme).acceleration() == pytest.approx(
        G * (sin(radians(30)) - 0.3 * cos(radians(30))), rel=0.02
    )
    assert abs(Incline("ua", 0.8, scheme=scheme, damping=0.2, time=0.2).speed[-1]) < 0.005


def test_without_slip_friction_does_not_matter():
    assert abs(Incline("ua", 0.0, damping=0.2, time=0.2, slip=False).speed[-1]) < 0.005
