# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact at tips, edges and thin plates."""

import re

import numpy as np
import pytest
import yade_mpm as mpm
from contactScenes import SCHEMES, G, Incline, drawn, run, typeOf
from setups import bits, chain, elastic, restarted
from yade_mpm import box, geotech


def caughtInAPile(isDriven, pressure=0.0, dt=1e-4):
    """Contact and pile after one step: soil that rises beside a pile and, caught, within it."""
    scene = mpm.Scene((0, 0), (4.5, 4), 0.5, threads=1)
    pile = scene.add("pile", box((2, 1.5), (2.5, 3)), elastic(1e5), typeOf("a", 0.5), group="pile")
    soil = scene.add("soil", box((1, 3), (3.5, 4)), elastic(1e5), typeOf("u", 0.5), group="soil")
    soil.position[:, 1] -= 1.5
    soil.velocity = (0, 1.0)
    soil.setStress(-pressure * (soil.position[:, 0] < 2)[:, None, None] * np.diag([3, 1, 1]))
    contact = mpm.Contact(impactLoss=1.0)
    drive = mpm.Drive(pile, velocity=(0, 0)) if isDriven else ()
    scene.engines, scene.dt = chain(contact=contact, drive=drive), dt
    return run(scene, steps=1), contact


@pytest.mark.parametrize("isDriven", [False, True])
def test_boxes_caught_inside_a_mesh_do_not_hide_its_tip(isDriven):
    """At the tip the boxes look down, away from the pile, as flat as can be. The nodes there take the
    normal of the mesh all the same, and hold what is caught; also where the pile is driven whole, and all its
    nodes are held."""
    _, contact = caughtInAPile(isDriven)
    table = contact.contactTable()
    for x in (2.0, 2.5):
        tip = (table["node"][:, 0] == x) & (table["node"][:, 1] == 1.5)
        assert tip.any() and (table["force"][tip, 1] < 0).all()  # on the soil
        assert (np.abs(table["normal"][tip, 1]) > 0.5).all()


def test_normals_at_edges_do_not_depend_on_the_time_step():
    """Facets count by how they move, not by how the forces of this step, which balance those of contact in
    the step before, would move them."""
    normals = []
    for dt in (1e-4, 8e-4):
        table = caughtInAPile(False, 20.0, dt)[1].contactTable()
        tip = table["node"][:, 1] == 1.5
        normals.append({x: tuple(n[:2]) for x, n in zip(table["node"][tip, 0], table["normal"][tip])})
    both = normals[0].keys() & normals[1].keys()
    assert len(both) > 1
    for x in both:
        assert normals[0][x] == pytest.approx(normals[1][x], abs=1e-3)


def normalsUnderATip(step):
    """Normals at the two nodes under the tip of a pile in soil that lies lower on the right by `step`, m."""
    scene = mpm.Scene((0, 0), (4.5, 4), 0.5, threads=1)
    tip = mpm.Mesh(*geotech.wedgedColumn(2.25, 1.35, 0.5, 1.5, 90.0, 0.25))
    pile = scene.add("pile", tip, elastic(1e3), mpm.APDI(), group="pile")
    soil = scene.add("soil", box((0.5, 0.5), (4.0, 1.5)), elastic(1e3), mpm.UGIMP(perCell=2), group="soil")
    soil.position[soil.position[:, 0] > 2.25, 1] -= step
    pile.velocity = (0, -60.0)  # closes every gap in a step, so that the table has all nodes
    contact = mpm.Contact(impactLoss=1.0)
    scene.engines, scene.dt = chain(contact=contact), 5e-3
    run(scene, steps=1)
    table = contact.contactTable()
    nodes = [(table["node"][:, 0] == x) & (table["node"][:, 1] == 1.5) for x in (2.0, 2.5)]
    return np.array([table["normal"][node][0, :2] for node in nodes])


def test_the_normal_at_a_tip_follows_the_soil_without_a_jump():
    """Flat soil gives the normal, soil that is no plane leaves it to the tip, and between the two it turns:
    it jumped by 0.58 where the soil moved by a fiftieth of a cell."""
    normals = np.array([normalsUnderATip(step) for step in np.arange(0, 0.22, 0.01)])
    assert np.abs(np.diff(normals, axis=0)).max() < 0.1
    assert np.abs(normals[0] - [0, -1]).max() < 1e-3
    assert normals[-1][:, 0] == pytest.approx([-0.471, 0.471], abs=1e-3)  # the faces of the tip


# --- a plate drawn from the ground ----------------------------------------------------------------------
def pullOut(pair, wide, shift, friction=0.2, adhesion=0.0, squeeze=0.0, constraints="nodes"):
    """Pull over its reference, and overlap in cells: a plate of `wide` cells through soil under K0 = 0.5;
    shift in cells.

    squeeze : horizontal stress besides, kPa, so that the soil at the surface stays in contact.
    """
    h, D, K0, bottom = 0.25, 2.0, 0.5, 0.5
    left = 2 + (shift - wide // 2) * h
    scene = mpm.Scene((0, 0), (4, 4.5), h, threads=1)
    plate = box((left, 0.25), (left + wide * h, 3))
    soil = scene.add(
        "soil", box((0, bottom), (4, bottom + D)) - plate, elastic(1e5), typeOf(pair[0], h), group="soil"
    )
    pile = scene.add("plate", plate, elastic(1e5), typeOf(pair[1], h), group="plate")
    vertical = -2 * G * (bottom + D - soil.position[:, 1])
    soil.setStress(vertical[:, None, None] * np.diag([K0, 1, K0]) - np.diag([squeeze, 0, 0]))
    contact = mpm.Contact(friction=friction, adhesion=adhesion, constraints=constraints)
    drive = mpm.Drive(pile, velocity=(0, 0.02), ramp=0.03)
    base = mpm.Drive(soil.below(bottom + 0.5 * h), velocity=(None, 0), name="base")
    scene.engines = chain(
        contact=contact, gravity=(0, -G), damping=0.5, roller=("left", "right"), drive=[drive, base]
    )
    run(scene, until=0.1)
    pulls = []
    for _ in range(40):
        run(scene, steps=5)
        pulls.append(drive.reaction[1])
    shaft = friction * (K0 * 2 * G * D**2 + 2 * squeeze * D) + 2 * adhesion * D
    return (np.mean(pulls) - G * pile.mass.sum()) / shaft, contact.largestPenetration / h


@pytest.mark.parametrize(
    "pair, wide, shift",
    [
        ("uu", 2, 0),
        ("ua", 2, 0),
        ("aa", 2, 0),
        ("aa", 1, 0),
        ("ua", 1, 0),
        ("ua", 2, 0.5),
        ("aa", 2, 0.5),
        ("uu", 2, 0.5),
    ],
)
def test_a_plate_is_held_by_friction_along_its_shaft(pair, wide, shift):
    pull, penetration = pullOut(pair, wide, shift)
    assert pull == pytest.approx(1, rel=0.1)
    assert penetration < 0.02


def test_a_plate_is_held_by_adhesion_along_its_shaft():
    for pair in ("uu", "ua", "aa"):
        assert pullOut(pair, 2, 0, friction=0.0, adhesion=2.0, squeeze=10.0)[0] == pytest.approx(1, rel=0.02)


def test_a_plate_of_one_cell_between_grid_lines_misses_half_of_its_friction():
    """A limit (doc/explanation/contact.md): its middle nodes see soil on both sides, whose normals cancel."""
    assert 0.3 < pullOut("aa", 1, 0.5)[0] < 0.7
    assert 0.2 < pullOut("ua", 1, 0.5)[0] < 0.6  # 0.30


def test_a_plate_of_one_cell_between_grid_lines_in_a_mesh_has_its_friction_by_facets():
    """Each of its faces has facets, with normals and gaps of their own. In soil of boxes, whose surface only
    nodes see, half of it is missing still."""
    assert pullOut("aa", 1, 0.5, constraints="facets")[0] == pytest.approx(1, abs=0.1)
    assert 0.3 < pullOut("ua", 1, 0.5, constraints="facets")[0] < 0.7


# --- nodes or facets ------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "pair, chosen",
    [("ua", "facets"), ("au", "facets"), ("uu", "nodes"), ("aa", "facets"), ("uc", "nodes"), ("ac", "nodes")],
)
def test_facets_hold_meshes_and_nodes_all_others(pair, chosen):
    """A user who chooses nothing gets a T-bar of the right size, and the load of a mesh on a mesh."""

    def pushed(**law):
        return run(drawn(mpm.Contact(friction=0.3, **law), [pair])[0], steps=60)

    assert bits(pushed()) == bits(pushed(constraints=chosen))
    other = pushed(constraints={"facets": "nodes", "nodes": "facets"}[chosen])
    assert bits(pushed()) != bits(other)  # control


def test_half_a_body_presses_as_the_whole_one_does():
    """Facets on a plane of symmetry are no surface: the last vertex of a mesh on such a plane is none at an
    edge. While it was one, the pressure on the axis of a cylinder was half of Hertz's."""

    def forces(left):
        scene = mpm.Scene((left, 0), (1, 1), 0.1, threads=1)
        scene.add("base", box((left, 0), (1, 0.3)), elastic(1e3), mpm.UGIMP(perCell=2), group="base")
        x, t = np.meshgrid(np.arange(0.4 * left, 0.41, 0.05), np.linspace(0, 1, 5), indexing="ij")
        lens = geotech.quadrilaterals(x, 0.301 + 0.2 * x**2 + 0.2 * t)
        scene.add("lens", lens, elastic(1e3), mpm.APDI(), group="lens").velocity = (0, -1.0)
        contact = mpm.Contact(impactLoss=1.0)
        scene.engines = chain(contact=contact, damping=0.1, fixed="bottom", roller=("left", "right"))
        scene.dt, force = 5e-4, np.zeros(21)
        for _ in range(30):
            run(scene, steps=1)
            table = contact.contactTable()
            np.add.at(force, np.round(10 + 10 * table["node"][:, 0]).astype(int), table["force"][:, 1])
        return force

    whole, half = forces(-1), forces(0)
    half[10] *= 2  # which has half a node on the axis
    assert whole[10] > 0.2 * whole.sum() / 3  # control: it presses there
    assert half[10:13] == pytest.approx(whole[10:13], abs=0.03 * whole.max())


# --- the same bits --------------------------------------------------------------------------------------
@pytest.mark.parametrize("pair", ["uu", "ua", "aa", "uc"])
def test_any_number_of_threads_gives_the_same_bits(pair):
    one = Incline(pair, 0.3, time=0.05, threads=1)
    for threads in (2, 3):
        assert bits(Incline(pair, 0.3, time=0.05, threads=threads).scene) == bits(one.scene)
    assert bits(Incline(pair, 0.3001, time=0.05).scene) != bits(one.scene)  # control


@pytest.mark.parametrize("pair, scheme", [*(("ua", scheme) for scheme in SCHEMES), ("uc", "MUSL")])
def test_a_restart_in_the_middle_of_sliding_gives_the_same_bits(pair, scheme):
    incline = Incline(pair, 0.3, time=0.05, scheme=scheme)
    incline.contact.pair("base", "block", friction=0.2, adhesion=0.1)
    again = restarted(incline.scene, 150)
    restored = next(e for e in again.engines if isinstance(e, mpm.Contact))
    assert restored.frictionWork == incline.contact.frictionWork > 0
    assert [b.group for b in again.bodies] == ["base", "block"]
    assert restored.forceOn("block").any()
    assert np.array_equal(restored.forceOn("block"), incline.contact.forceOn("block"))


def test_a_mesh_that_might_be_converted_is_still_a_mesh():
    """The body that would take its domains is empty: normals and gaps come from the mesh, bit for bit."""

    def pressed(onDistortion):
        scene = mpm.Scene((0, 0), (4, 3), 0.25, threads=1)
        scene.add("base", box((0.25, 0), (3, 1)), elastic(1e4), mpm.UGIMP(perCell=2), group="a")
        block = scene.add(
            "block",
            box((0.75, 1), (2.5, 1.75)),
            elastic(1e4),
            mpm.APDI(size=0.125, onDistortion=onDistortion),
            group="b",
        )
        scene.engines = chain(
            contact=mpm.Contact(friction=0.2), gravity=(1.0, -G), damping=0.1, fixed="bottom"
        )
        scene.dt = 2e-4
        run(scene, steps=200)
        assert block.converted == 0
        return block.stress

    assert (pressed("convert") == pressed("stop")).all()


def test_converted_domains_stay_in_their_group():
    """A sliding mesh, one vertex of which is pulled so far that its domains are given up, slides on."""
    scene = mpm.Scene((0, 0), (2.4, 1), 0.1, threads=1)
    scene.add("base", box((0, 0), (2.4, 0.2)), elastic(1e5), mpm.UGIMP(perCell=2), group="base")
    block = scene.add(
        "block",
        box((0.5, 0.2), (1.1, 0.5)),
        elastic(100.0),
        mpm.APDI(size=0.05, onDistortion="convert"),
        group="block",
    )
    block.velocity = (1.0, 0.0)
    contact = mpm.Contact(friction=0.3)
    scene.engines = chain(contact=contact, gravity=(0, -G), fixed="bottom")
    run(scene, steps=20)
    corner = np.argmin(block.vertices[:, 1] + np.abs(block.vertices[:, 0] - block.position[:, 0].mean()))
    block.vertices[corner] += (0.0, 0.06)
    run(scene, steps=20)
    other = scene["block (converted)"]
    assert other.count > 0 and other.group == "block"
    force = contact.forceOn("block")
    assert force[1] > 0
    assert abs(force[0]) == pytest.approx(0.3 * force[1], rel=0.05) and force[0] < 0


# --- errors ---------------------------------------------------------------------------------------------
def two(groups=("a", "b")):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, threads=1)
    for k, group in enumerate(groups):
        scene.add(
            f"body {k}",
            box((0.5, 0.5 + 0.5 * k), (1.5, 1.0 + 0.5 * k)),
            elastic(1e5),
            mpm.UGIMP(perCell=2),
            group=group,
        )
    return scene


def raises(text):
    return pytest.raises(ValueError, match=re.escape(text))


def test_one_group_alone_cannot_be_in_contact():
    scene = two(("main", "main"))
    scene.engines = chain(contact=mpm.Contact())
    with raises("Contact: all bodies belong to one group, 'main'; give scene.add(..., group=...)"):
        run(scene, steps=1)


def test_pairs_must_be_groups_and_laws_not_negative():
    scene, contact = two(), mpm.Contact()
    contact.pair("a", "c", friction=0.1)
    scene.engines = chain(contact=contact)
    with raises("Contact: there is no group 'c'; groups: a, b"):
        run(scene, steps=1)
    for name, value in (
        ("friction", -0.1),
        ("adhesion", -1.0),
        ("friction", float("nan")),
        ("friction", "rough"),
    ):
        with raises(f"Contact: {name} = {value!r} between 'a' and 'b'; give zero or a positive number"):
            mpm.Contact().pair("a", "b", **{"friction": 0.1, name: value})
    for name in ("friction", "adhesion"):
        with raises(name):
            mpm.Contact(**{name: -0.1})
    with raises("constraints"):
        mpm.Contact(constraints="guess")


@pytest.mark.parametrize("place", [0, 1, 4])
def test_contact_stands_between_solver_and_particles(place):
    engines = chain()
    engines.insert(place, mpm.Contact())
    with raises("do not make a step"):
        two().engines = engines


def test_two_contacts_are_refused():
    with raises("do not make a step"):
        two().engines = chain(contact=mpm.Contact())[:3] + chain(contact=mpm.Contact())[2:]


def test_groups_have_names():
    for group in ("", 3):
        with raises(f"group = {group!r}; give a name"):
            two(("a", group))


def test_a_body_added_between_two_runs_touches_too():
    """What a run knows of the surfaces of bodies stays for the next one."""
    scene = mpm.Scene((0, 0), (3, 2), 0.1)
    scene.add("base", box((0, 0), (3, 0.2)), elastic(1e5), mpm.APDI(size=0.05), group="base")
    scene.add("first", box((0.5, 0.2), (1.1, 0.5)), elastic(1e5), mpm.APDI(size=0.05), group="first")
    contact = mpm.Contact(friction=0.3)
    scene.engines = chain(contact=contact, gravity=(0, -9.81), fixed="bottom")
    scene.run(until=0.01)
    scene.add("second", box((1.7, 0.2), (2.3, 0.5)), elastic(1e5), mpm.APDI(size=0.05), group="second")
    scene.run(until=0.2)
    forces = contact.forces()
    assert forces["base", "first"][1] > 0 and forces["base", "second"][1] > 0
