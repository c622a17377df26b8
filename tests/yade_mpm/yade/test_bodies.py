# SPDX-License-Identifier: GPL-2.0-or-later
"""The exchange between bodies of YADE and a RigidContact: nothing is missed, nothing is lost between O.save
and O.load."""

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
    assert contact.orientations[0] == pytest.approx([0.8, 0, 0, 0.6])
    assert contact.angularVelocities[0].tolist() == [4, 5, 6]
    contact._core.set("impulses", {"force": [[2.0, 0, 0]], "torque": [[0, 0, 4.0]]})
    between.apply(0, 1e-3, 0.5)
    between.apply(1, 1e-3, 0.5)  # in the next step of the same cycle: the same again
    assert forces.given == 2 * [("F", 7, (4.0, 0, 0), False), ("T", 7, (0, 0, 8.0), False)]


def test_the_scene_may_lie_in_another_plane():
    frame = np.array([(1.0, 0, 0), (0, 0, 1), (0, -1, 0)])  # its y is the host's z
    contact, forces, between = exchange(rigid.Box((1, 1, 1)), frame)
    between.read(0, 1e-3, 1e-3, 1, False)
    assert contact.positions[0] == pytest.approx([0.1, 0.3, -0.2])
    assert contact.velocities[0] == pytest.approx([1, 3, -2])
    assert contact.orientations[0] == pytest.approx([0.8, 0, 0.6, 0])
    assert contact.angularVelocities[0] == pytest.approx([4, 6, -5])
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
    """With the same bits as without; also behind detach(), and where a script appends them again."""
    said, _ = run(
        """
import bodies
for how in ("once", "again", "detached", "appended", "made again"):
    O.reset()
    soil, contact, coupling = bodies.build(True)
    O.run(20, True)
    if how == "detached": coupling.detach()
    if how != "once": coupling = mpm.yade.attach(coupling.scene)
    if how == "appended": coupling.exchanges.append(coupling.exchanges[0])
    if how == "made again": coupling.exchanges.append(mpm.yade.Bodies(contact, bodies.IDS))
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
    for how in ("again", "detached", "appended", "made again"):
        assert said[how] == said["once"], how
    assert said["once"][1] == 1 and "nobody exchanges" in said["cleared"]
    assert said["repr"] == "<Bodies: 2 bodies of YADE (0, 1), 0 contacts with the soil>"
