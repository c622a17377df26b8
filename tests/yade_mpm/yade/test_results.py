# SPDX-License-Identifier: GPL-2.0-or-later
"""Results where a user of YADE looks: O.energy, O.forces, interactions, materials, unbalanced force."""

import math

import numpy as np
import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

RESULTS = """
import numpy as np
import bodies
from yade import utils
soil, contact, coupling = bodies.build(True)
O.trackEnergy = True
O.bodies[1].state.pos = (0.75, 0.6, 0.55)
O.run(10, True)
list_ = coupling.interactions
say("count", [len(list_), contact.contacts, sorted({i.id1 for i in list_}), list_[0].soil])
total = sum(i.phys.normalForce + i.phys.shearForce for i in list_)
ours = coupling.exchanges[0]
say("forces", [(-total).tolist(), ours.forces.sum(axis=0).tolist(), [list(O.forces.f(k)) for k in (0, 1)],
    ours.forces.tolist()])
along = [float(i.geom.normal @ i.phys.shearForce) for i in list_]
say("geometry", [*along, list_[0].geom.penetrationDepth])
say("unbalanced", [coupling.unbalancedForce(), coupling.unbalancedForce(useMaxForce=True),
    str(utils.unbalancedForce())])
say("energy", dict(O.energy.items()))
say("kinetic", mpm.diagnostics.kineticEnergy(coupling.scene))
say("materials", [coupling.materials["soil"] is soil.material, coupling.materials[0] is soil.material,
    len(coupling.materials), repr(coupling.materials), fails(KeyError, lambda: coupling.materials["sand"])])
before = [ours.forces.tolist(), ours.torques.tolist()]
O.save("state.yade.gz"); O.load("state.yade.gz"); again = mpm.yade.attach()
ours = again.exchanges[0]
say("loaded", [ours.forces.tolist(), ours.torques.tolist()] == before)
O.run(5, True); say("moved on", ours.forces.tolist() == before[0])
"""


def test_results_stand_where_a_user_of_yade_looks(tmp_path):
    said, _ = run(RESULTS, tmp_path)
    count, contacts, ids, soil = said["count"]
    assert count == contacts > 4 and ids == [0, 1] and soil == "soil"
    total, summed, ofYade, ours = map(np.array, said["forces"])
    assert total == pytest.approx(summed, rel=1e-9, abs=1e-15) and summed[2] > 0
    assert ofYade == pytest.approx(ours, rel=1e-9, abs=1e-15), "O.forces after a step, without gravity"
    *along, depth = said["geometry"]
    assert np.abs(along).max() < 1e-12 and depth > 0
    mean, largest, own = said["unbalanced"]
    assert 0 < mean <= largest and own == "nan"
    energy = said["energy"]
    assert energy["mpm_kinetic"] == said["kinetic"] > 0
    assert {"mpm_internalWork", "mpm_damped", "mpm_contact", "mpm_externalWork"} < set(energy)
    byName, byNumber, number, text, missing = said["materials"]
    assert byName and byNumber and number == 1 and text.startswith("soil: NeoHookean(")
    assert "materials: there is no body 'sand'; bodies: soil" in missing
    assert said["loaded"] and not said["moved on"]


FRICTION = """
import numpy as np
from math import tan
from yade import utils
def slide(angle, soilAngle, **given):
    O.reset()
    scene = mpm.Scene((0, 0, 0), (1.2, 0.6, 0.6), 0.1)
    law = dict(density=1.0, young=2e3, poisson=0.3)
    soil = mpm.LinearElastic(**law) if soilAngle is None else mpm.MohrCoulombDruckerPrager(
        cohesion=50.0, frictionAngle=soilAngle, **law)
    scene.add("soil", mpm.box((0, 0, 0), (1.2, 0.6, 0.3)), soil, mpm.UGIMP(perCell=2))
    contact = mpm.RigidContact()
    scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(fixed="bottom"), mpm.GridToParticle(),
        mpm.DomainUpdater()]
    rock = O.materials.append(FrictMat(density=2.6, frictionAngle=angle))
    box = utils.box((0.5, 0.3, 0.398), (0.15, 0.15, 0.1), material=rock)
    box.state.blockedDOFs, box.state.vel = "xyzXYZ", (2.0, 0, 0)
    number = O.bodies.append(box)
    empty()
    coupling = mpm.yade.attach(scene, bodies=mpm.yade.Bodies(contact, [number], **given))
    O.run(30, True)
    force = np.array([i.phys.shearForce for i in coupling.interactions]), \\
        np.array([i.phys.normalForce for i in coupling.interactions])
    share = np.linalg.norm(force[0], axis=1) / np.linalg.norm(force[1], axis=1)
    return [float(np.median(share)), contact.sliding]
say("soil", slide(0.6, 0.4)); say("rock", slide(0.3, 0.4)); say("elastic", slide(0.3, None))
say("given", slide(0.6, 0.4, friction=0.1))
"""


def test_friction_goes_by_the_materials_of_a_pair_the_smaller_angle_counts(tmp_path):
    said, _ = run(FRICTION, tmp_path)
    for name, expected in {
        "soil": math.tan(0.4),
        "rock": math.tan(0.3),
        "elastic": math.tan(0.3),
        "given": 0.1,
    }.items():
        ratio, sliding = said[name]
        assert sliding > 4 and ratio == pytest.approx(expected, rel=1e-6), name


ENERGY = """
from yade import utils
steel = O.materials.append(FrictMat(density=7.8, young=1e5, poisson=0.3, frictionAngle=0.5))
number = O.bodies.append(utils.box((0.5, 0.5, 0.4), (0.2, 0.2, 0.1), material=steel))
state = O.bodies[number].state
state.blockedDOFs, state.vel = "XYZ", (1, 0, 0)
O.engines = [ForceResetter(), NewtonIntegrator(gravity=(0, 0, -9.81), damping=0)]
scene = mpm.Scene((0, 0, 0), (1.5, 1, 0.6), 0.1)
scene.add("soil", mpm.box((0, 0, 0), (1.5, 1, 0.3)), mpm.LinearElastic(density=1.8, young=2e4, poisson=0.3),
    mpm.UGIMP(perCell=2))
contact = mpm.RigidContact()
sides = dict(roller=("left", "right", "front", "back"))
scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(fixed="bottom", damping=0.05, **sides),
    mpm.GridToParticle(), mpm.DomainUpdater()]
mpm.yade.attach(scene, bodies=mpm.yade.Bodies(contact, [number], friction=0.4))
O.trackEnergy = True
before = 0.5 * state.mass
O.run(int(0.12 / O.dt), True)
say("energy", dict(O.energy.items()))
say("lost", before - 0.5 * state.mass * state.vel.norm() ** 2 + state.mass * 9.81 * (0.4 - state.pos[2]))
say("friction", contact.frictionWork)
"""


def test_the_heat_of_friction_at_bodies_is_a_row_and_all_rows_add_up(tmp_path):
    said, _ = run(ENERGY, tmp_path, patience=200)
    rows = {k[4:]: v for k, v in said["energy"].items() if k.startswith("mpm_")}
    assert rows["friction"] == said["friction"] > 0.05
    assert -rows["bodyWork"] == pytest.approx(said["lost"], rel=0.01), "what the body lost it has given"
    assert sum(rows.values()) == pytest.approx(0, abs=1e-9 * said["lost"])
    assert abs(rows["error"]) < 0.01 * said["lost"]
    assert abs(rows["error"] + rows["friction"]) > 0.5 * said["lost"], "control: without the row of friction"
