# SPDX-License-Identifier: GPL-2.0-or-later
"""A flat tip that is pressed into sand and stops: its load stays, for soil does not creep past its edges."""

import pytest
import yade_mpm as mpm
from setups import chain, restarted, softSoil
from yade_mpm import box

SAND = mpm.MohrCoulombDruckerPrager(
    density=1.53, lame=(9.48e3, 6.31e3), cohesion=8.5, frictionAngle=0.5236, dilatancyAngle=0.1
)


def pressed(constraints="auto", friction=0.3, velocity=(0, -0.1), implicit=True):
    """Scene, its drive and contact: a pile of two cells in sand, before the first step."""
    scene = mpm.Scene((0, 0), (6, 8), 0.25, threads=1)
    shaft = box((2.75, 3.5), (3.25, 7.0))
    soil = scene.add("soil", box((0, 0), (6, 5)) - shaft, SAND, mpm.UGIMP(perCell=2))
    steel = mpm.LinearElastic(density=7.85, lame=(4.2e7, 2.8e7))
    pile = scene.add("pile", shaft, steel, mpm.APDI(size=0.125), implicit=implicit, group="pile")
    scene.initialStress(surface=5, K0=0.43, bodies=[soil])
    drive = mpm.Drive(pile.above(6.5), velocity=velocity, ramp=0.2, name="pile")
    walls = {"fixed": "bottom", "roller": ("left", "right")}
    contact = mpm.Contact(friction=friction, impactLoss=1, constraints=constraints)
    scene.engines = chain(contact=contact, gravity=(0, -9.81), damping=0.05, drive=drive, **walls)
    scene.dt = 8e-4
    return scene, drive, contact


@pytest.mark.parametrize("constraints, friction", [("auto", 0.3), ("auto", 0.0), ("nodes", 0.3)])
def test_a_flat_tip_that_stops_keeps_its_load(constraints, friction):
    """From 0.05 s after the stop on, when the wave is gone. (Without a memory of how the
    edges moved 40, 59 and 78 % are gone in the next second; 1.4, 0.4 and 3.7 % are.)"""
    scene, drive, _ = pressed(constraints, friction)
    scene.run(until=1.5, progress=False)
    drive.velocity = (0, 0)
    scene.run(until=1.6, progress=False)
    load = drive.reaction[1]
    assert load < -200  # kN/m
    scene.run(until=2.6, progress=False)
    assert drive.reaction[1] == pytest.approx(load, rel=0.06)


def test_edges_turn_when_the_tip_goes_back():
    """Half a cell later they move up, and the load is the friction of the shaft."""
    scene, drive, contact = pressed()
    scene.run(until=1.5, progress=False)
    pressing = drive.reaction[1]
    x, y, _, speed = contact.edgeMotions[4:]  # of the pile, the second group
    assert abs(x) < 0.2
    assert y == pytest.approx(-1, abs=0.25)
    assert speed == pytest.approx(0.1, rel=0.2)
    drive.velocity = (0, 0.1)
    scene.run(until=4.0, progress=False)
    assert contact.edgeMotions[5] == pytest.approx(1, abs=0.25)
    assert 0 < drive.reaction[1] < -0.6 * pressing


def test_a_restart_at_rest_goes_on_with_the_same_bits():
    scene, drive, _ = pressed()
    scene.run(until=0.5, progress=False)
    drive.velocity = (0, 0)
    scene.run(steps=100, progress=False)
    restarted(scene, 100)


@pytest.mark.parametrize("numbers", [[1.0], [0.0] * 6])
def test_motions_of_another_length_are_refused(numbers):
    contact = pressed()[2]
    with pytest.raises(ValueError, match="edgeMotions has . numbers; give 8 for each pair of groups"):
        contact.restoreState({"edgeMotions": numbers})


def test_two_piles_that_touch_make_no_energy_out_of_soil():
    """One is pressed, the other drawn, at impactLoss = 0. (While the starts of surfaces that part need not
    agree at nodes of three groups, soil at the joint went up at 8 m/s.)"""
    scene = mpm.Scene((0, 0), (6, 8), 0.25, threads=1)
    left, right = box((2.5, 3.5), (3, 7)), box((3, 3.5), (3.5, 7))
    soil = scene.add("soil", box((0, 0), (6, 5)) - left - right, SAND, mpm.UGIMP(perCell=2))
    steel = mpm.LinearElastic(density=7.85, lame=(4.2e4, 2.8e4))
    drives = []
    for name, shaft, speed in (("a", left, -0.1), ("b", right, 0.05)):
        pile = scene.add(name, shaft, steel, mpm.APDI(size=0.125), group=name)
        drives.append(mpm.Drive(pile.above(6.5), velocity=(0, speed), name=name))
    scene.initialStress(surface=5, K0=0.43, bodies=[soil])
    walls = {"fixed": "bottom", "roller": ("left", "right")}
    scene.engines = chain(
        contact=mpm.Contact(friction=0.3), gravity=(0, -9.81), damping=0.05, drive=drives, **walls
    )
    scene.dt = 8e-4
    scene.run(until=0.5, progress=False)
    assert mpm.diagnostics.energyError(scene) > -0.2  # kJ; -3 then


def test_boxes_beside_an_edge_are_no_overlap():
    """A pile sinks by a tenth of a cell: the boxes beside its tip are behind the plane of its base then."""
    scene = mpm.Scene((0, 0), (4, 6), 0.25, threads=1)
    shaft = box((1.75, 2), (2.25, 5))
    sand = softSoil(cohesion=5, density=1.8, young=1e4, poisson=0.3, frictionAngle=0.5, dilatancyAngle=0)
    ground = scene.add("soil", box((0, 0), (4, 3)) - shaft, sand, mpm.UGIMP())
    steel = mpm.LinearElastic(density=7.8, young=1e6, poisson=0.3)
    pile = scene.add("pile", shaft, steel, mpm.APDI(size=0.125), group="pile")
    contact = mpm.Contact(friction=0.3, impactLoss=1)
    scene.initialStress(surface=3, K0=0.5, bodies=[ground])
    scene.engines[1] = mpm.GridSolver(gravity=(0, -9.81), fixed="bottom", roller=("left", "right"))
    scene.engines.insert(2, contact)
    scene.run(until=0.1, progress=False)
    base = pile.vertices[:, 1].min()
    under = (abs(ground.position[:, 0] - 2) < 0.25) & (ground.position[:, 1] < 2.05)
    overlap = (ground.position[:, 1] + ground.halfSize[1])[under].max() - base
    assert base < 1.98 and 0 < overlap < 0.002
    assert contact.largestPenetration == pytest.approx(overlap, abs=0.002)
    assert -contact.contactTable()["gap"].min() > 0.05  # control: boxes beside the tip
