# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of YADE: mistakes, facets, the benchmark."""

import json

import numpy as np
import pytest
from yadeProcess import needsYade, run

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
        "O.engines has lost 6 of the 6 engines of 'mpm': it was assigned after mpm.inYade(); attach the "
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
    assert 0 < figures["far"] < figures["mpm"]
    assert 0 < figures["exchange"] < figures["mpm"]
    assert figures["bridge"] > 0


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
    assert said["on"] == said["loaded"] and said["on"]["contacts"] >= 2


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
