# SPDX-License-Identifier: GPL-2.0-or-later
"""Friction and adhesion of YADE's bodies by a rule for pairs of materials."""

import numpy as np
import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

PAIRS = """
import numpy as np
from math import tan
from yade import utils
def build(angle=0.6, **given):
    O.reset()
    scene = mpm.Scene((0, 0, 0), (1.2, 0.6, 0.6), 0.1, threads=1)
    for k, soilAngle in enumerate((0.4, 0.2)):
        soil = mpm.MohrCoulombDruckerPrager(density=1.0, young=2e3, poisson=0.3, cohesion=50.0,
            frictionAngle=soilAngle)
        place = mpm.box((0.6 * k, 0, 0), (0.6 * k + 0.6, 0.6, 0.3))
        scene.add(f"soil {k}", place, soil, mpm.UGIMP(perCell=2))
    contact = mpm.RigidContact()
    scene.engines = [mpm.ParticleToGrid(), contact, mpm.GridSolver(fixed="bottom"), mpm.GridToParticle(),
        mpm.DomainUpdater()]
    rock = O.materials.append(FrictMat(density=2.6, frictionAngle=angle, label="rock"))
    for k in range(2):
        box = utils.box((0.3 + 0.6 * k, 0.3, 0.4), (0.15, 0.15, 0.1), material=rock)
        box.state.blockedDOFs, box.state.vel = "xyzXYZ", (2.0, 0, -0.1)
        O.bodies.append(box)
    empty()
    return mpm.yade.attach(scene, bodies=mpm.yade.Bodies(contact, [0, 1], **given))

def strengths(coupling):
    # friction over normal force of sliding contacts, by body: (slope, held at no pressure in kPa)
    found = []
    for body in (0, 1):
        contacts = [i for i in coupling.interactions if i.id1 == body]
        t = np.array([np.linalg.norm(i.phys.shearForce) for i in contacts])
        n = np.array([np.linalg.norm(i.phys.normalForce) for i in contacts])
        (slope, held), misfit = np.polyfit(n, t, 1), 0
        found.append([float(slope), float(held) / 0.05**2, len(contacts), float(np.ptp(n))])
    return found

rule = lambda rock, soil: 0.5 * tan(min(rock.frictionAngle, soil.frictionAngle))
for name, given in dict(default={}, number=dict(friction=0.3, adhesion=5.0), rule=dict(friction=rule),
        both=dict(friction=rule, adhesion=lambda rock, soil: 10.0 if soil.frictionAngle < 0.3 else 0.0),
        cohesive=dict(adhesion=lambda rock, soil: 0.2 * soil.cohesion)).items():
    coupling = build(**given); O.run(12, True)
    before = strengths(coupling)
    def go(c):
        O.run(12, True)
        return [c.exchanges[0].forces.tolist(), np.array(c.scene["soil 0"].velocity).sum()]
    O.save("pairs.yade.gz"); on = go(coupling)
    O.load("pairs.yade.gz"); coupling = mpm.yade.attach()
    say(name, before); say(name + " loaded", go(coupling) == on)
contact = mpm.RigidContact()
say("text", fails(TypeError, lambda: mpm.yade.Bodies(contact, [0], friction="rough")))
say("negative", fails(ValueError, lambda: mpm.yade.Bodies(contact, [0], adhesion=-1.0)))
coupling = build(friction=lambda rock, soil: None)
say("returned", fails(ValueError, lambda: O.run(1, True)))
"""


@pytest.fixture(scope="module")
def pairs(tmp_path_factory):
    return run(PAIRS, tmp_path_factory.mktemp("pairs"), patience=120)[0]


HALF = 0.5 * np.tan([0.4, 0.2])
EXPECTED = {
    "default": [(np.tan(0.4), 0.0), (np.tan(0.2), 0.0)],
    "number": [(0.3, 5.0), (0.3, 5.0)],
    "rule": [(HALF[0], 0.0), (HALF[1], 0.0)],
    "both": [(HALF[0], 0.0), (HALF[1], 10.0)],
    "cohesive": [(np.tan(0.4), 10.0), (np.tan(0.2), 10.0)],
}


@pytest.mark.parametrize("name", EXPECTED)
def test_strength_of_each_pair_goes_by_the_rule(pairs, name):
    for (slope, held, contacts, spread), (friction, adhesion) in zip(pairs[name], EXPECTED[name]):
        assert contacts > 8 and spread > 1e-3
        assert slope == pytest.approx(friction, rel=0.02) and held == pytest.approx(adhesion, abs=0.2)


@pytest.mark.parametrize("name", EXPECTED)
def test_laws_are_the_same_after_o_load(pairs, name):
    assert pairs[name + " loaded"]


def test_what_is_no_law_is_told(pairs):
    assert "friction = 'rough'; give a number (-), or a function" in pairs["text"]
    assert "adhesion = -1.0 is not allowed" in pairs["negative"]
    assert "the rule for friction has returned None" in pairs["returned"]
