# SPDX-License-Identifier: GPL-2.0-or-later
"""Springs of rigid bodies under soil at rest: what they start with, and what makes them softer later."""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import soft
from yade_mpm import box, rigid

FLOORS = {
    "terrain": rigid.HeightField(np.full(17, 0.5), 0.5),
    "box": rigid.Box((9, 0.5)),
    "wall": rigid.Wall(normal=(0, 1), point=(0, 0.5)),
}


def onFloor(kind="terrain", **options):
    """A layer of sand on rigid ground with the stress of its weight: scene, body, contact."""
    sand = mpm.MohrCoulombDruckerPrager(
        density=1.8, young=5e3, poisson=0.3, cohesion=0, frictionAngle=0.5, dilatancyAngle=0
    )
    scene = mpm.Scene((0, 0), (8, 5), 0.25, gravity=9.81, **options)
    scene.roller("left", "right")
    body = scene.add("sand", box((0, 0.5), (8, 1.5)), sand, mpm.UGIMP())
    contact = mpm.RigidContact()
    contact.addBody(FLOORS[kind], friction=0.5, position=(0, 0) if kind != "box" else (4, 0))
    scene.engines.insert(1, contact)
    scene.groundStress(K0=0.5)
    return scene, body, contact


@pytest.mark.parametrize("kind", FLOORS)
def test_soil_with_its_stress_rests_on_any_ground(kind):
    """Without damping. Control: soil that has no stress."""
    speeds = {}
    for isStressed in (True, False):
        scene, body, _ = onFloor(kind)
        if not isStressed:
            body.stress = 0 * body.stress
        scene.run(steps=60, progress=False)
        speeds[isStressed] = np.abs(body.velocity).max()
    assert speeds[True] < 1e-3 and speeds[False] > 0.1, "m/s"


def test_a_first_step_that_is_shortened_makes_no_contact_softer_later():
    """The layer rests as if all steps were whole. Control: a short step that is given."""
    speeds = {}
    for how in ("shortened", "given"):
        scene, body, _ = onFloor()
        scene.prepare()
        dt = scene.dt
        if how == "given":
            scene.dt = 0.3 * dt
        scene.run(until=0.3 * dt, progress=False)
        scene.dt = dt
        scene.run(steps=5, progress=False)
        speeds[how] = np.abs(body.velocity).max()
    assert speeds["shortened"] < 0.03 and speeds["given"] > 0.1, "m/s"


def test_a_lighter_body_that_comes_later_lets_no_layer_drop(tmp_path):
    """Contact becomes a fifth as stiff, and its forces stay. Control: a stiffness that is given so small. A
    restart between the two changes no bit."""
    scene, body, contact = onFloor(damping=0.1)
    scene.run(steps=300, progress=False)
    kappa = contact.stiffnessUsed
    scene.save(tmp_path / "rest.h5")
    for one in (scene, again := mpm.load(tmp_path / "rest.h5")):
        one.add("light", box((3, 4), (4, 4.5)), soft(density=0.3), mpm.UGIMP())
        one.run(steps=10, progress=False)
    assert contact.stiffnessUsed < 0.2 * kappa
    assert np.abs(body.velocity).max() < 0.02, "m/s"
    assert np.array_equal(again["sand"].velocity, body.velocity)
    contact.stiffness = 0.2 * contact.stiffnessUsed
    scene.run(steps=10, progress=False)
    assert np.abs(body.velocity).max() > 0.05, "m/s"
