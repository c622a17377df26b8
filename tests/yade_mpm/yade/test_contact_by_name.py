# SPDX-License-Identifier: GPL-2.0-or-later
"""Inside YADE in the words of the problem: `scene.contact` names bodies once, `mpm.inYade` takes them."""

import pytest
import yade_mpm as mpm
from yadeProcess import needsYade, run

SETUP = """
import bodies
from yade import Vector3

def ball():
    O.reset()
    number = O.bodies.append(utils.sphere((0.5, 0.5, 0.62), 0.1, material=FrictMat(density=2.6, young=1e5,
        poisson=.3, frictionAngle=.5)))
    O.engines = [ForceResetter(), NewtonIntegrator(gravity=(0, 0, -9.81), damping=0)]
    return number

def ground():
    scene = mpm.Scene((0, 0, 0), (1, 1, 1), 0.25, gravity=9.81)
    scene.fix("bottom"); scene.roller("left", "right", "front", "back")
    clay = mpm.Tresca(density=1.8, young=2e3, poisson=0.3, undrainedStrength=5)
    return scene, clay, mpm.box((0, 0, 0), (1, 1, 0.5))
"""

# The calls of a user, and the long form that does the same.
SAME = """
number = ball()
scene, clay, bed = ground()
soil = scene.add("soil", bed, clay)
stone = scene.contact(number, soil, friction=0.4, adhesion=1.0)
coupling = mpm.inYade(scene)
O.run(300, True)
height = O.bodies[number].state.pos[2]
say("user", [bodies.digest(soil, [number]), height > 0.5, coupling.exchanges == [stone]])

number = ball()
scene, clay, bed = ground()
soil = scene.add("soil", bed, clay)
contact = mpm.RigidContact()
scene.engines.insert(1, contact)
named = mpm.yade.Bodies(contact, [number], friction=0.4, adhesion=1.0)
mpm.yade.attach(scene, bodies=named)
O.run(300, True)
say("long", bodies.digest(soil, [number]))

number = ball(); O.bodies[number].state.pos = (0.5, 0.5, 0.4)
scene, clay, bed = ground()
stone = scene.contact(number)  # before the soil is there, which leaves its place empty
soil = scene.add("soil", bed, clay, mpm.UGIMP(perCell=4), exclude=stone)
mpm.inYade(scene); O.run(50, True)
O.save("half.yade.gz"); O.run(50, True); say("before", bodies.digest(soil, [number]))
O.load("half.yade.gz"); coupling = mpm.inYade(); O.run(50, True)
say("after", bodies.digest(coupling.scene["soil"], [number]))
say("excluded", [soil.count, float(stone.contact.largestPenetration)])
"""


@needsYade
def test_the_calls_of_a_user_do_what_the_long_form_does_bit_by_bit(tmp_path):
    said, _ = run(SETUP + SAME, tmp_path)
    assert said["user"] == [said["long"], True, True]
    assert said["before"] == said["after"]
    assert 0 < said["excluded"][0] < 2048 and said["excluded"][1] < 0.02


WRONG = """
number = ball()
scene, clay, bed = ground()
soil = scene.add("soil", bed, clay)
far = scene.add("far", mpm.box((0, 0, .5), (1, 1, .75)), clay)
other = mpm.Scene((0, 0, 0), (1, 1, 1), 0.25).add("other", bed, clay)
say("missing", fails(ValueError, lambda: scene.contact(77, soil)))
say("no numbers", fails(TypeError, lambda: scene.contact("stone", soil)))
say("no soil", fails(TypeError, lambda: scene.contact(number, 5)))
say("other", fails(ValueError, lambda: scene.contact(number, other)))
say("chain", len(scene.engines))
stone = scene.contact(number, soil)
say("lost", fails(ValueError, lambda: setattr(scene, "engines", scene.engines[:1] + scene.engines[2:])))
say("unnamed", fails(ValueError, lambda: mpm.inYade(scene)))
stone.named = None
coupling = mpm.inYade(scene)
say("late", fails(RuntimeError, lambda: scene.contact(number, soil)))
"""


@needsYade
def test_wrong_calls_are_told_what_to_do(tmp_path):
    said, _ = run(SETUP + WRONG, tmp_path)
    assert "there is no body 77 in O.bodies" in said["missing"]
    assert "give numbers of bodies" in said["no numbers"] and "give bodies of the scene" in said["no soil"]
    assert "in another scene" in said["other"] and said["chain"] == 5
    assert "RigidContact" in said["lost"] and "scene.contact" in said["lost"]
    assert "'far', too; name it" in said["unnamed"] and "append(ids)" in said["late"]


def testNumbersAreBodiesInsideYadeAlone():
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    soil = scene.add("soil", mpm.box((0, 0), (1, 1)), mpm.LinearElastic(density=2, young=1e4, poisson=0.3))
    with pytest.raises(TypeError, match="first = 3; give a body"):
        scene.contact(3, soil)
    with pytest.raises(TypeError, match="plane is for bodies of YADE alone"):
        scene.contact(soil, soil, plane="xz")
