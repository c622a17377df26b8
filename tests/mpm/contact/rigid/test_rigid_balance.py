# SPDX-License-Identifier: GPL-2.0-or-later
"""Rigid bodies that touch, leave and start again: energy, bits, restart."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused
from rigidScenes import KINDS, Free, momentum, thrown, typeOf
from setups import chain, elastic
from yade_mpm import box, rigid


def test_a_body_that_touches_the_ground_is_not_thrown_off_by_small_steps():
    """A disc under its weight, steps of 1/20 of the critical one: the contact is 400 times as stiff. It
    only ever goes down. Control: put
    1 mm deeper it is thrown up."""

    def velocities(deep):
        scene = mpm.Scene((0, 0), (1.2, 1.8), 0.1, threads=1)
        scene.add("soil", box((0, 0), (1.2, 0.5)), elastic(1e4), mpm.UGIMP(perCell=2))
        contact = mpm.RigidContact()
        contact.addBody(rigid.Sphere(0.5), position=(0.62, 1.0 - deep))
        disc = Free(contact, 1.5, 1.5 * 0.5**2 / 2, load=(0, -15, 0))
        scene.engines = [*chain(contact, fixed="bottom"), mpm.PyRunner(disc, iterPeriod=1)]
        scene.dt = 0.05 * scene.criticalTimeStep()
        scene.run(steps=400, progress=False)
        return np.array(disc.log)[:, 2], contact.forces[0, 1]

    velocity, force = velocities(0.0)
    assert velocity.max() < 0 and force > 5
    assert velocities(1e-3)[0].max() > 0.05


# --- the rest ---------------------------------------------------------------------------------------------
@pytest.mark.parametrize("kind", KINDS)
def test_nothing_holds_a_body_that_leaves(kind):
    """Every normal force pushes, with damping, too, also while the sphere leaves (the last forces fall to
    nothing)."""
    scene, contact, block, sphere = thrown(kind, 2, normalDamping=1.0)
    pushes = []

    def look():
        table = contact.contactTable()
        pushes.extend((table["force"] * table["normal"]).sum(axis=1))

    scene.engines = [*scene.engines, mpm.PyRunner(look, iterPeriod=1)]
    scene.run(steps=90, progress=False)
    assert len(pushes) > 10 and min(pushes) >= 0 and min(pushes) < 1e-2 * max(pushes)
    assert contact.contacts == 0 and not contact.forces.any() and sphere.v[0, 1] > block.velocity[:, 1].mean()


def energies(scene, contact):
    """Of the springs, of the soil, and the work of contact on it."""
    table = contact.contactTable()
    force, normal, slip = table["force"], table["normal"], table["slip"]
    springs = -0.5 * ((force * normal).sum(axis=1) * table["gap"]).sum() - 0.5 * (force * slip).sum()
    return (
        springs,
        mpm.diagnostics.kineticEnergy(scene) + mpm.diagnostics.internalWork(scene),
        scene._core.energies["loads"],
    )


@pytest.mark.filterwarnings("ignore:RigidContact. rigid body 0 is .* m deep")
@pytest.mark.parametrize("friction, x", [(0.0, 0.6), (0.9, 0.57)], ids=["slides", "sticks"])
@pytest.mark.parametrize("kind", KINDS)
def test_contact_gives_no_more_energy_than_its_springs_had(kind, friction, x):
    """Soil under a disc that is fixed 5 mm deep, without any damping, 4000 steps at the largest safe
    factor: the energy of soil and springs, and
    the work on the soil with that of the springs. At the places of uGIMP particles, ahead of their strain,
    the springs gave the soil 210 (sticking: 10)
    times what they had.

    Velocities belong to the middle of steps, so the sum swings up to 1.44 and ends near 0.9. With the arm
    of a step's end the work was up to 35 % off.
    """
    scene = mpm.Scene((0, 0), (1.2, 1.6), 0.1, threads=1)
    scene.add("soil", box((0, 0), (1.2, 0.5)), elastic(1e4), typeOf(kind, 0.1))
    contact, rows = mpm.RigidContact(stiffnessFactor=0.7), []
    contact.addBody(rigid.Sphere(0.3), friction=friction, position=(x, 0.795))
    look = mpm.PyRunner(lambda: rows.append(energies(scene, contact)), iterPeriod=1)
    scene.engines = [*chain(contact, fixed=("bottom", "left", "right")), look]
    scene.dt = 0.8 * scene.criticalTimeStep()
    scene.run(steps=4000, progress=False)
    springs, soil, work = np.array(rows).T / rows[0][0]
    assert (springs + soil).max() < 1.6 and (springs + soil)[-1000:].max() < 1.1
    assert (springs + work).max() < 1.02 and (springs + work).min() > 0.95


@pytest.mark.parametrize("kind", KINDS)
def test_a_disc_that_bounces_off_takes_no_more_energy_than_it_brought(kind):
    """Undamped soil, both together within 5 %. With uGIMP the disc left with 1.01 of its energy, and the
    soil had 0.07 more."""
    scene = mpm.Scene((0, 0), (1.2, 1.6), 0.1, threads=1)
    scene.add("soil", box((0, 0), (1.2, 0.5)), elastic(1e4), typeOf(kind, 0.1))
    contact = mpm.RigidContact(stiffnessFactor=0.7)
    contact.addBody(rigid.Sphere(0.3), position=(0.6, 0.81), velocity=(0, -1))
    disc = Free(contact, 0.5)
    scene.engines = [*chain(contact, fixed=("bottom", "left", "right")), mpm.PyRunner(disc, iterPeriod=1)]
    scene.dt = 0.8 * scene.criticalTimeStep()
    scene.run(steps=1000, progress=False)
    own, before = 0.25 * (disc.v**2).sum(), 0.25
    assert contact.contacts == 0 and disc.v[0, 1] > 0 and 0.5 * before < own < before
    assert own + energies(scene, contact)[1] == pytest.approx(before, rel=0.05)


def test_a_stiffness_beyond_the_bound_is_refused():
    scene, contact, *_ = thrown("UGIMP", 2)
    scene.run(steps=1, progress=False)
    most = contact.stiffnessUsed / 0.3
    contact.stiffness = 0.99 * most
    scene.run(steps=1, progress=False)
    assert contact.stiffnessUsed == contact.stiffness
    contact.stiffness = 1.01 * most
    with pytest.raises(ValueError, match="stiffness = .* is unstable; give at most .* or lower dt"):
        scene.run(steps=1, progress=False)


@pytest.mark.parametrize("kind", KINDS)
def test_the_bits_do_not_depend_on_the_threads(kind):
    def result(threads, friction=0.4):
        scene, contact, block, sphere = thrown(kind, 2, threads=threads, friction=friction)
        scene.run(steps=60, progress=False)
        assert contact._core.value("impulses")["force"][0][0] != 0
        return block.velocity[np.argsort(block.id)].tobytes() + sphere.v.tobytes() + sphere.w.tobytes()

    one = result(1)
    assert result(2) == one and result(3) == one
    assert result(1, friction=0.4001) != one  # control


@pytest.mark.parametrize("kind", KINDS)
def test_a_restart_goes_on_with_the_same_bits(kind):
    """The history is in the checkpoint. Control: without it the result is another one."""

    def driven():
        scene = mpm.Scene((0, 0), (2, 1), 0.1, threads=1)
        scene.add("soil", box((0, 0), (2, 0.5)), elastic(1e4), typeOf(kind, 0.1))
        contact = mpm.RigidContact()
        contact.addBody(
            [rigid.Sphere(0.1, (-0.1, 0)), rigid.Sphere(0.1, (0.1, 0))],
            friction=0.5,
            position=(1, 0.6),
            velocity=(0.3, -0.2),
            angularVelocity=(0, 0, 1),
        )
        scene.engines = chain(contact, fixed=("bottom",))
        return scene

    scene = driven()
    scene.run(steps=40, progress=False)
    scene.save("state.h5")
    scene.run(steps=40, progress=False)
    again, forgetful = mpm.load("state.h5"), mpm.load("state.h5")
    forgetful.engines[1]._core.set("history", [])
    states = []
    for one in (again, forgetful):
        one.run(steps=40, progress=False)
        states.append(one["soil"].velocity.tobytes() + one.engines[1].forces.tobytes())
    assert states[0] == scene["soil"].velocity.tobytes() + scene.engines[1].forces.tobytes() != states[1]


@pytest.mark.parametrize(
    "shapes",
    [
        [rigid.Box((0.4, 0.1))],
        [rigid.Box((0.25, 0.1), (-0.15, 0)), rigid.Box((0.25, 0.1), (0.15, 0))],
        [rigid.Facet([(-0.4, -0.1), (0.4, -0.1)])],
        [rigid.Facet([(-0.4, -0.1), (0.1, -0.1)]), rigid.Facet([(0.1, -0.1), (0.4, -0.1)])],
        [rigid.Wall((0, -1), (0, -0.1))],
    ],
    ids=["box", "flush boxes", "facet", "two facets", "wall"],
)
def test_shapes_with_the_same_face_press_alike(shapes):
    """A flat face pressed 1 mm into ground 0.8 m wide: 32 particles with the same force, no matter what the
    face belongs to."""
    scene = mpm.Scene((0, 0), (1.2, 1), 0.1, threads=1)
    scene.add("soil", box((0.2, 0), (1.0, 0.5)), elastic(1e4), mpm.UGIMP(perCell=4))
    contact = mpm.RigidContact()
    contact.addBody(shapes, position=(0.6, 0.599))
    scene.engines = chain(contact)
    scene.run(steps=1, progress=False)
    assert contact.contacts == 32
    assert contact.forces[0] == pytest.approx([0, 0.8 * 1e-3 * contact.stiffnessUsed, 0], rel=1e-9, abs=1e-9)


def test_a_turned_clump_in_3D_is_where_it_should_be():
    """A box in a body that is turned by 90 degrees about x and moved: its upright face meets the ground.
    Control: not turned."""

    def contacts(orientation):
        scene = mpm.Scene((0, 0, 0), (1, 1, 1), 0.1, threads=1)
        scene.add("soil", box((0, 0, 0), (1, 1, 0.5)), elastic(1e4), mpm.UGIMP(perCell=2))
        contact = mpm.RigidContact(checkBalance=True)
        contact.addBody(
            [
                rigid.Box((0.19, 0.05, 0.09), (0, -0.2, 0)),
                rigid.Facet([(0, -0.25, 0), (0.08, -0.25, 0), (0, -0.25, 0.08)]),
            ],
            position=(0.5, 0.5, 0.749),
            orientation=orientation,
        )
        scene.engines = chain(contact)
        scene.run(steps=1, progress=False)
        return contact.contacts

    turn = np.sqrt(0.5)
    assert contacts((turn, turn, 0, 0)) == 8 * 4
    assert contacts((1, 0, 0, 0)) == 0


@pytest.mark.parametrize("scheme", ["USF", "USL"])
@pytest.mark.parametrize("kind", KINDS)
def test_momentum_under_the_other_schemes(kind, scheme):
    scene = mpm.Scene((0, 0), (2, 2), 0.1, scheme=scheme, threads=1)
    block = scene.add("block", box((0.4, 0.4), (1.6, 1.0)), elastic(1e4), typeOf(kind, 0.1))
    contact = mpm.RigidContact(checkBalance=True)
    contact.addBody(rigid.Sphere(0.2), friction=0.4, position=(1, 1.2), velocity=(1, -3, 0))
    sphere = Free(contact, 0.5)
    scene.engines = [*chain(contact), mpm.PyRunner(sphere, iterPeriod=1)]
    before = momentum(block, sphere)
    scene.run(steps=40, progress=False)
    assert momentum(block, sphere) == pytest.approx(before, rel=1e-12)
    assert sphere.v[0, 1] > -2.5


def test_impulses_are_kept_for_a_slower_partner():
    scene, contact, block, sphere = thrown("UGIMP", 2)
    scene.run(steps=30, progress=False)
    force, torque = contact.takeImpulses()
    assert force[0] == pytest.approx(sphere.mass * (sphere.v[0] - (1, -3, 0)), rel=1e-12)
    assert torque[0] == pytest.approx(sphere.inertia * sphere.w[0], rel=1e-12)
    assert not contact.takeImpulses()[0].any()


def test_bodies_move_on_with_their_velocities():
    scene, contact, *_ = thrown("UGIMP", 2)
    scene.engines = [e for e in scene.engines if not isinstance(e, mpm.PyRunner)]
    contact.setStates([[1, 1.5, 0]], [[1, 0, 0, 0]], [[0.5, 0, 0]], [[0, 0, 3]])
    scene.run(steps=100, progress=False)
    assert contact.positions[0] == pytest.approx([1 + 0.5 * scene.time, 1.5, 0], rel=1e-12)
    angle = 3 * scene.time
    assert contact.orientations[0] == pytest.approx([np.cos(angle / 2), 0, 0, np.sin(angle / 2)], rel=1e-9)


# --- what a penalty does not push back --------------------------------------------------------------------
def pushedIn(kind, shape, y, velocity, steps, **attributes):
    scene = mpm.Scene((0, 0), (1.2, 1.2), 0.1, threads=1)
    scene.add("soil", box((0, 0), (1.2, 0.5)), elastic(1e4), typeOf(kind, 0.1))
    contact = mpm.RigidContact(**attributes)
    contact.addBody(shape, position=(0.6, y), velocity=(0, velocity))
    scene.engines, scene.dt = chain(contact, fixed="bottom"), 2e-4
    scene.run(steps=steps, progress=False)
    return contact


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_as_deep_in_the_soil_as_its_particles_are_wide_is_refused(kind):
    """Control: a third as deep it goes on."""
    sphere, given = rigid.Sphere(0.3), dict(stiffness=1e3)
    assert pushedIn(kind, sphere, 0.805, -5, 25, **given).largestPenetration > 0.015
    deep = r"step \d+: RigidContact: rigid body 0 is 0.05\d+ m deep, more than the width of a .* in 'soil' at"
    with pytest.raises(RuntimeError, match=deep):
        pushedIn(kind, sphere, 0.805, -5, 100, **given)


@pytest.mark.parametrize("kind", KINDS)
def test_a_thin_shape_that_the_soil_has_passed_through_is_refused(kind):
    thickness = 0.02 if kind == "APDI" else 0.0
    facet = rigid.Facet([(-0.2, 0), (0.2, 0)], thickness=thickness)
    with pytest.raises(RuntimeError, match="rigid body 0 has been passed through by 'soil' at"):
        pushedIn(kind, facet, 0.52, -10, 100, stiffness=1e3)


# --- input errors -----------------------------------------------------------------------------------------
SPHERE, UPRIGHT, STILL = rigid.Sphere(1), [[1, 0, 0, 0]], [[0, 0, 0]]


def states(positions, orientations=UPRIGHT):
    return lambda contact: contact.setStates(positions, orientations, STILL, STILL)


@cases(
    ("addBody without a shape", lambda c: c.addBody([])),
    ("mass = -1 ... give Mg, or zero", lambda c: c.addBody(SPHERE, mass=-1)),
    ("shape = 'sphere' ... mpm.rigid.Sphere", lambda c: c.addBody(["sphere"]), TypeError),
    ("Sphere: radius = -1", lambda c: c.addBody(rigid.Sphere(-1))),
    ("Box: halfSize ... positive half edges", lambda c: c.addBody(rigid.Box((1, 0, 1)))),
    ("Wall: normal ... has no direction", lambda c: c.addBody(rigid.Wall((0, 0)))),
    ("Facet: vertices ... coincide", lambda c: c.addBody(rigid.Facet([(0, 0), (0, 0)]))),
    ("friction ... -0.1 ... zero or a positive number", lambda c: c.addBody(SPHERE, friction=-0.1)),
    ("orientation ... unit quaternion", lambda c: c.addBody(SPHERE, orientation=(1, 1, 0, 0))),
    ("position ... give 3 numbers", lambda c: c.addBody(SPHERE, position=(0, np.nan))),
    ("friction has 2 entries for 1 rigid bodies", lambda c: setattr(c, "friction", [0.1, 0.2])),
    ("stiffnessFactor = 2", lambda c: setattr(c, "stiffnessFactor", 2)),
    ("did you mean 'stiffness'", lambda c: setattr(c, "stifness", 2), AttributeError),
    ("positions has 6 numbers; give (1, 3), a row for each rigid body", states(np.zeros((2, 3)))),
    ("the position of rigid body 0 is not finite", states([[0, 0, np.inf]])),
    ("rigid body 0 has the norm 0", states([[0, 0, 0]], [[0, 0, 0, 0]])),
)
def test_wrong_input_is_refused_and_changes_nothing(named, make, kind):
    contact = mpm.RigidContact()
    contact.addBody(rigid.Sphere(0.1))
    before = contact.attributes()
    refused(named, lambda: make(contact), kind)
    assert contact.attributes() == before


LINE, TRIANGLE = rigid.Facet([(0, 0), (1, 0)]), rigid.Facet([(0, 0), (1, 0), (0, 1)])


@pytest.mark.parametrize(
    "kind, dim, shape, turn, named",
    [
        ("APDI", 2, LINE, (1, 0, 0, 0), "facet of rigid body 0 has no thickness"),
        ("UGIMP", 2, TRIANGLE, (1, 0, 0, 0), "three vertices in a 2D scene; give two"),
        ("UGIMP", 2, rigid.Sphere(0.1), (0, 1, 0, 0), "rotation about z only"),
        ("UGIMP", 3, None, None, "there is no rigid body; add one with addBody"),
    ],
)
def test_what_does_not_fit_the_scene_is_refused_before_the_run(kind, dim, shape, turn, named):
    scene = mpm.Scene((0,) * dim, (1,) * dim, 0.25)
    scene.add("soil", box((0,) * dim, (1,) * (dim - 1) + (0.5,)), elastic(1e4), typeOf(kind, 0.25))
    contact = mpm.RigidContact()
    if shape is not None:
        contact.addBody(shape, position=(0.5, 0.9, 0.9), orientation=turn)
    scene.engines = chain(contact)
    refused(named, lambda: scene.run(steps=1, progress=False))


def test_the_engine_has_its_place_in_the_chain():
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    contact = mpm.RigidContact()
    with pytest.raises(ValueError, match="do not make a step"):
        scene.engines = chain(contact=contact)
    scene.engines = chain(contact)


def test_bodies_are_added_before_the_run():
    scene, contact, *_ = thrown("UGIMP", 2)
    scene.run(steps=1, progress=False)
    with pytest.raises(RuntimeError, match="add all rigid bodies before it"):
        contact.addBody(rigid.Sphere(0.1))
