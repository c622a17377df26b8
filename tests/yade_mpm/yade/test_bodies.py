# SPDX-License-Identifier: GPL-2.0-or-later
"""The exchange between bodies of YADE and a RigidContact: nothing is missed, nothing is lost between O.save
and O.load."""

import json

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import _core, rigid
from yadeProcess import needsYade, run


# --- bodies that are far are left out ---------------------------------------------------------------------
@needsYade
@pytest.mark.parametrize(
    "how, options",
    [("far", {}), ("late", {}), ("hand", {}), ("far", {"mpmSteps": 3}), ("late", {"demSteps": 3})],
)
def test_a_body_that_comes_from_afar_is_not_missed(tmp_path, how, options):
    script = "import bodies\nsay('hit', bodies.shoot({!r}, {}, **{}))"
    said = {}
    for isEvery in (False, True):
        folder = tmp_path / str(isEvery)
        folder.mkdir()
        said[isEvery] = run(script.format(how, isEvery, options), folder)[0]["hit"]
    assert said[True]["contacts"] > 0
    assert said[False]["bits"] == said[True]["bits"]
    assert said[False]["seen"] < 0.2 * said[True]["seen"]


# --- without YADE -----------------------------------------------------------------------------------------
class State:
    """As a host has it that knows no vectors of Eigen."""

    pos, ori, vel, angVel = (0.1, 0.2, 0.3), (0.0, 0.0, 0.6, 0.8), (1, 2, 3), (4, 5, 6)


class Forces:
    def __init__(self):
        self.given = []

    def addF(self, number, force, isPermanent):
        self.given.append(("F", number, tuple(force), isPermanent))

    def addT(self, number, torque, isPermanent):
        self.given.append(("T", number, tuple(torque), isPermanent))


ALONG_AXES = np.eye(3)


def exchange(shape, frame=ALONG_AXES, turn=(1.0, 0, 0, 0)):
    contact, forces = mpm.RigidContact(), Forces()
    contact.addBody(shape)
    return contact, forces, _core.BodyExchange(contact._core, [State()], [7], forces, frame.tolist(), [turn])


def test_states_and_forces_of_a_host_without_vectors():
    contact, forces, between = exchange(rigid.Box((1, 1, 1)))
    between.read(0, 1e-3, 1e-3, 1, False)
    assert contact.positions[0].tolist() == [0.1, 0.2, 0.3] and contact.velocities[0].tolist() == [1, 2, 3]
    assert contact.orientations[0] == pytest.approx([0.8, 0, 0, 0.6]) and contact.angularVelocities[
        0
    ].tolist() == [4, 5, 6]
    contact._core.set("impulses", {"force": [[2.0, 0, 0]], "torque": [[0, 0, 4.0]]})
    between.apply(0, 1e-3, 0.5)
    between.apply(1, 1e-3, 0.5)  # in the next step of the same cycle: the same again
    assert forces.given == 2 * [("F", 7, (4.0, 0, 0), False), ("T", 7, (0, 0, 8.0), False)]


def test_the_scene_may_lie_in_another_plane():
    frame = np.array([(1.0, 0, 0), (0, 0, 1), (0, -1, 0)])  # its y is the host's z
    contact, forces, between = exchange(rigid.Box((1, 1, 1)), frame)
    between.read(0, 1e-3, 1e-3, 1, False)
    assert contact.positions[0] == pytest.approx([0.1, 0.3, -0.2]) and contact.velocities[0] == pytest.approx(
        [1, 3, -2]
    )
    assert contact.orientations[0] == pytest.approx([0.8, 0, 0.6, 0]) and contact.angularVelocities[
        0
    ] == pytest.approx([4, 6, -5])
    contact._core.set("impulses", {"force": [[0, 2.0, 0]], "torque": [[0, 0, 4.0]]})
    between.apply(0, 1e-3, 1.0)
    assert forces.given == [("F", 7, (0, 0, 2.0), False), ("T", 7, (0, -4.0, 0), False)]


def test_shapes_may_be_turned_against_the_state():
    contact, _, between = exchange(
        rigid.Box((1, 1, 1)), turn=(0.6, 0, 0, -0.8)
    )  # by -106.26 degrees after 73.74
    between.read(0, 1e-3, 1e-3, 1, False)
    assert contact.orientations[0] == pytest.approx([0.96, 0, 0, -0.28])


def test_a_state_that_is_not_finite_is_refused(monkeypatch):
    _, _, between = exchange(rigid.Sphere(1))
    monkeypatch.setattr(State, "vel", (1, float("nan"), 0))
    with pytest.raises(ValueError, match="the velocity of rigid body 0 is not finite"):
        between.read(0, 1e-3, 1e-3, 1, False)


# --- O.save and O.load ------------------------------------------------------------------------------------
SAVE = """
import bodies
soil, contact, coupling = bodies.build(False, mpmSteps={mpmSteps}, demSteps={demSteps})
O.run(2, True)  # while they touch; with 3 DEM steps in a cycle: in the middle of one
say("at", contact.contacts)
O.save("state.yade.gz")
O.run(200, True)
say("on", [bodies.bits(soil), contact.contacts])
"""
LOAD = """
import bodies
O.load("state.yade.gz")
coupling = mpm.yade.attach()
soil, contact = coupling.scene["soil"], coupling.scene.engines[1]
say("bodies", [type(e).__name__ for e in coupling.exchanges])
if {isCut}: coupling.exchanges[:] = [bodies.Deaf(coupling.exchanges[0])]
O.run(200, True)
say("on", [bodies.bits(soil), contact.contacts])
"""


@needsYade
@pytest.mark.parametrize("mpmSteps, demSteps", [(1, 1), (3, 1), (1, 3)])
def test_save_and_load_bring_the_bodies_back_with_the_same_bits(tmp_path, mpmSteps, demSteps):
    said, _ = run(SAVE.format(mpmSteps=mpmSteps, demSteps=demSteps), tmp_path)
    assert said["at"] > 0
    loaded, _ = run(LOAD.format(isCut=False), tmp_path)
    assert loaded["bodies"] == ["Bodies"] and loaded["on"] == said["on"]
    if demSteps == 1 and mpmSteps == 1:
        twice, _ = run(
            """
import bodies
O.load("state.yade.gz")
coupling = mpm.yade.attach()
coupling.exchanges.append(mpm.yade.Bodies(coupling.scene.engines[1], bodies.IDS))
say("twice", fails(RuntimeError, lambda: O.run(1, True)))
""",
            tmp_path,
        )
        assert "two of them serve one RigidContact" in twice["twice"]
        assert run(LOAD.format(isCut=True), tmp_path)[0]["on"] != said["on"], "control: without the bodies"


@needsYade
def test_a_contact_takes_the_bodies_of_one_exchange(tmp_path):
    said, _ = run(
        """
from yade import utils
contact = mpm.RigidContact()
O.bodies.append([utils.sphere((0, 0, 0), 1), utils.sphere((3, 0, 0), 2)])
mpm.yade.Bodies(contact, [0])
say("other", fails(ValueError, lambda: mpm.yade.Bodies(contact, [1])))
""",
        tmp_path,
    )
    assert "has other rigid bodies already" in said["other"]


@needsYade
def test_a_contact_with_nobody_to_exchange_with_is_refused_before_the_first_step(tmp_path):
    said, _ = run(
        """
import bodies
soil, contact, coupling = bodies.build(True)
coupling.exchanges.clear()
ours = mpm.yade.Bodies(contact, bodies.IDS)
say("nobody", [fails(RuntimeError, lambda: O.run(1, True)), O.iter])
class Other:
    def read(self, coupling): pass
    def apply(self, coupling): pass
coupling.exchanges.append(Other())
say("others", [fails(RuntimeError, lambda: O.run(1, True)), coupling.scene.steps])
mpm.yade.attach(coupling.scene, bodies=ours)
O.run(2, True); say("coupled", coupling.scene.steps)
say("no exchange", fails(TypeError, lambda: mpm.yade.attach(coupling.scene, bodies=[0])))
coupling.scene.engines = [e for e in coupling.scene.engines if e is not contact]
coupling = mpm.yade.attach(coupling.scene)
coupling.exchanges.append(ours)
say("left out", fails(RuntimeError, lambda: O.run(1, True)))
""",
        tmp_path,
    )
    assert "nobody exchanges with the RigidContact of 'mpm'" in said["nobody"][0] and said["nobody"][1] == 0
    assert "nobody exchanges with the RigidContact" in said["others"][0] and said["others"][1] == 0
    assert said["coupled"] == 2
    assert "bodies = 0; give mpm.yade.Bodies(contact, ids)" in said["no exchange"]
    assert (
        "the RigidContact of bodies [0, 1] is not among the engines of the scene 'mpm'; put it behind "
        "ParticleToGrid" in said["left out"]
    )


@needsYade
def test_attaching_again_keeps_the_bodies(tmp_path):
    """With the same bits as without; also behind detach(), and where a script appends them anew."""
    said, _ = run(
        """
import bodies
for how in ("once", "again", "detached", "appended", "made anew"):
    O.reset()
    soil, contact, coupling = bodies.build(True)
    O.run(20, True)
    if how == "detached": coupling.detach()
    if how != "once": coupling = mpm.yade.attach(coupling.scene)
    if how == "appended": coupling.exchanges.append(coupling.exchanges[0])
    if how == "made anew": coupling.exchanges.append(mpm.yade.Bodies(contact, bodies.IDS))
    O.run(60, True)
    say(how, [bodies.bits(soil), len(coupling.exchanges)])
O.reset()
soil, contact, coupling = bodies.build(True)
coupling = mpm.yade.attach(coupling.scene, bodies=[])
say("cleared", fails(RuntimeError, lambda: O.run(1, True)))
say("repr", repr(mpm.yade.Bodies(contact, bodies.IDS)))
""",
        tmp_path,
    )
    for how in ("again", "detached", "appended", "made anew"):
        assert said[how] == said["once"], how
    assert said["once"][1] == 1 and "nobody exchanges" in said["cleared"]
    assert said["repr"] == "<Bodies: 2 bodies of YADE (0, 1), 0 contacts with the soil>"


MISTAKES = """
from yade import FrictMat, NewtonIntegrator, ForceResetter, utils
scene = mpm.Scene((0, 0, 0), (1, 1, 2), 0.25)
scene.add("soil", mpm.box((0, 0, 0), (1, 1, 1)), mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3),
    mpm.UGIMP(perCell=2))
contact = mpm.RigidContact()
scene.engines = [mpm.ParticleToGrid(), contact, *scene.engines[1:]]
dense = O.bodies.append(utils.sphere((0.5, 0.5, 1.5), 0.2))  # of YADE's default material
rock = O.materials.append(FrictMat(density=2.6, young=1e5))
light = O.bodies.append(utils.sphere((0.5, 0.5, 1.5), 0.2, material=rock))
say("no bodies", fails(ValueError, lambda: mpm.yade.attach(scene)))
say("no contact", fails(TypeError, lambda: mpm.yade.Bodies([dense], contact)))
for name, ids in (("body", O.bodies[dense]), ("text", "01"), ("share", [0.5])):
    say(name, fails(TypeError, lambda: mpm.yade.Bodies(contact, ids)))
bodies = mpm.yade.Bodies(contact, {body})  # one number is enough
coupling = mpm.yade.attach(scene)
coupling.exchanges.append(bodies)
empty()
say("lost", fails(RuntimeError, lambda: O.run(1, True)))
coupling = mpm.yade.attach(scene)
coupling.exchanges.append(bodies)
O.run(1, True)
O.run(1, True)
say("steps", scene.steps)
"""


@needsYade
@pytest.mark.parametrize("body", ("dense", "light"))
def test_mistakes_with_bodies_and_engines_of_yade_are_told(tmp_path, body):
    said, err = run(MISTAKES.replace("{body}", body), tmp_path)
    assert (
        "a RigidContact of the scene has no rigid bodies; make mpm.yade.Bodies(contact, ids) before"
        in said["no bodies"]
    )
    assert "contact = [0]; give a mpm.RigidContact()" in said["no contact"]
    assert all(
        "give numbers of bodies, as O.bodies.append returns them" in said[name]
        for name in ("body", "text", "share")
    )
    assert (
        "O.engines has lost 6 of the 6 engines of 'mpm': it was assigned after mpm.yade.attach(); attach the "
        "scene again" in said["lost"]
    )
    assert said["steps"] == 2
    assert err.count(
        "warning: yade.Bodies: body 0 has a density of 1e+03 Mg/m3, the densest of the scene 2; "
    ) == (body == "dense")
    assert err.count("warning") == (body == "dense")


@needsYade
def test_the_benchmark_runs(tmp_path):
    run(
        """
import bench_yade
sys.argv += ["--bodies", "5", "--repeats", "2", "--out", "figures.json"]
bench_yade.main()
""",
        tmp_path,
    )
    [figures] = json.loads((tmp_path / "figures.json").read_text())
    assert figures["bodies"] == 5 and figures["contacts"] >= 5
    assert (
        0 < figures["far"] < figures["mpm"]
        and 0 < figures["exchange"] < figures["mpm"]
        and figures["bridge"] > 0
    )


# --- clumps and planes ------------------------------------------------------------------------------------
CLUMPS = """
import numpy as np
from types import SimpleNamespace
from yade import Quaternion, Vector3, utils

def difference(turns):
    # Largest distance between the members of a clump in YADE and the shapes of the contact, after turns.
    O.reset()
    tilted = Quaternion((0, 0, 1), 0.5)
    number, members = O.bodies.appendClumped([utils.box((0.5, 2, 0), (0.1, 0.8, 0.5), orientation=tilted),
        utils.box((0.7, 1.2, 0), (0.3, 0.1, 0.5)),
                                              utils.sphere((0.2, 1.1, 0), 0.2)])
    state = O.bodies[number].state
    first = list(state.ori)
    contact = mpm.RigidContact()
    bodies = mpm.yade.Bodies(contact, [number])
    O.engines = [ForceResetter(), NewtonIntegrator(damping=0)]
    O.dt, state.blockedDOFs, state.vel, state.angVel = 0.01, "xyzXYZ", (0.3, 0.2, 0), turns
    O.run(50, True)
    scene = SimpleNamespace(dim=3, lower=np.zeros(3), upper=np.ones(3), dt=0.01, steps=0)
    bodies.read(SimpleNamespace(runs=1, exchanges=[bodies], mpmSteps=1, cycle=scene.dt, scene=scene))
    w, *axis = contact.orientations[0]
    now = Quaternion(w, *axis)
    largest = 0.0
    shapes = contact._core.value("shapes")
    for kind, place, turn, member in zip(shapes["kind"], shapes["centre"], shapes["orientation"], members):
        at = O.bodies[member].state
        centre = Vector3(*contact.positions[0]) + now * Vector3(*place)
        largest = max(largest, (centre - at.pos).norm())
        if kind == "Box":
            w, *axis = turn
            turned = (now * Quaternion(w, *axis)).toRotationMatrix()
            largest = max(largest,
                float(np.abs(np.array(turned) - np.array(at.ori.toRotationMatrix())).max()))
    return largest, first, contact.orientations[0].tolist()

say("plane", difference((0, 0, 0.9)))
say("space", difference((0.4, -0.7, 0.9)))
"""


@needsYade
def test_a_clump_touches_with_its_members_however_its_frame_is_turned(tmp_path):
    said, _ = run(CLUMPS, tmp_path)
    for largest, _, _ in said.values():
        assert largest < 1e-12
    _, first, now = said["plane"]
    assert np.abs(first[:2]).max() > 0.1, "control: YADE has turned the frame out of the plane"
    assert np.abs(now[1:3]).max() < 1e-12


@needsYade
def test_a_clump_in_another_plane_comes_back_with_the_same_bits(tmp_path):
    said, _ = run(
        """
import planes
say("on", planes.fall("xz"))
say("loaded", planes.fall("xz", isSaved=True))
""",
        tmp_path,
    )
    assert said["on"] == said["loaded"] and said["on"]["contacts"] >= 3


@needsYade
def test_the_facets_of_a_polyhedron_enclose_it(tmp_path):
    said, _ = run(
        """
import bodies
import numpy as np
O.bodies.append(bodies.polyhedron((1, 2, 3), (0.1, 0.2, 0.3)))
contact = mpm.RigidContact()
mpm.yade.Bodies(contact, [0], facetThickness=0.01)
shapes = contact._core.value("shapes")
corners = np.reshape(shapes["vertices"], (-1, 3, 3))
area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
say("sum", area.sum(axis=0).tolist())
say("area", np.linalg.norm(area, axis=1).sum())
say("volume", (corners[:, 0] * area).sum() / 3)
say("half thickness", sorted(set(shapes["radius"])))
""",
        tmp_path,
    )
    assert said["sum"] == pytest.approx([0, 0, 0], abs=1e-12) and said["half thickness"] == [0.005]
    assert said["area"] == pytest.approx(8 * (0.02 + 0.06 + 0.03)) and said["volume"] == pytest.approx(0.048)


# --- warnings, and clumps of facets -------------------------------------------------------------------------
LEFT = """
from yade import utils
scene = mpm.Scene((0, 0, 0), (1, 1, 1), 0.25)
scene.add("soil", mpm.box((0, 0, 0), (1, 1, 0.25)), mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3),
    mpm.UGIMP(perCell=2))
rock = O.materials.append(FrictMat(density=2.6, young=1e5))
ids = O.bodies.append([utils.sphere((x, 0.5, 0.8), 0.1, material=rock) for x in (0.5, 0.9)])
for k, speed in zip(ids, ({slow}, {fast})): O.bodies[k].state.vel = (speed, 0, 0)
contact = mpm.RigidContact()
scene.engines = [mpm.ParticleToGrid(), contact, *scene.engines[1:]]
O.engines = [ForceResetter(), NewtonIntegrator()]
scene.dt = O.dt = 1e-3
mpm.yade.attach(scene, bodies=mpm.yade.Bodies(contact, ids))
O.run(310, True)
O.run(310, True)
"""


@needsYade
@pytest.mark.parametrize("slow, fast, number", [(0, 0, None), (0, 1, 1), (2, 2, 0)])
def test_the_first_body_that_leaves_the_box_of_the_scene_is_warned_of_once(tmp_path, slow, fast, number):
    _, err = run(LEFT.format(slow=slow, fast=fast), tmp_path)
    assert err.count("has left the box of the scene") == (number is not None)
    assert number is None or "body " in err and "(0, 0, 0) to (1, 1, 1)" in err


@needsYade
def test_a_clump_of_facets_with_a_hub_sphere_gets_the_moment_of_the_soil(tmp_path):
    """As the page says: YADE needs mass in a clump. One facet stands upright in the soil, and turns."""
    said, _ = run(
        """
from yade import utils
rock = O.materials.append(FrictMat(density=2.6, young=1e5, frictionAngle=0.4))
corners = [Vector3(0, 0, 0.2), Vector3(0.3, 0, 0.2), Vector3(0.3, 0, 0.5)]
hub = utils.sphere((0, 0, 0.9), 0.05, material=rock)
number, _ = O.bodies.appendClumped([utils.facet(corners, material=rock), hub])
state = O.bodies[number].state
state.blockedDOFs, state.angVel = "xyzXYZ", (0, 0, 0.5)
scene = mpm.Scene((-0.5, -0.5, 0), (0.5, 0.5, 1), 0.1)
contact = mpm.RigidContact()
bodies = mpm.yade.Bodies(contact, [number], facetThickness=0.02)
scene.add("soil", mpm.box((-0.5, -0.5, 0), (0.5, 0.5, 0.7)), mpm.LinearElastic(density=2.0, young=1e3,
    poisson=0.3), mpm.UGIMP(perCell=2), exclude=contact)
faces = ("bottom", "left", "right", "front", "back")
scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(fixed=faces), mpm.GridToParticle(),
    mpm.DomainUpdater()]
O.engines = [ForceResetter(), NewtonIntegrator()]
mpm.yade.attach(scene, bodies=bodies)
say("start", scene.particleCount)
O.run(int(0.1 / O.dt), True)
say("moment", [O.forces.t(number)[2], bodies.torques[0, 2]])
""",
        tmp_path,
    )
    ofYade, ours = said["moment"]
    assert ofYade == pytest.approx(ours, rel=1e-9) and ours < -1e-3
    assert 7 * 400 < said["start"] < 14 * 400
