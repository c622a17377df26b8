# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies of YADE that are erased, inserted or change their size while they touch the soil."""

import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

CHANGE = """
import bodies
from yade import utils
def seen(steps):
    touching = set()
    for _ in range(steps):
        O.run(1, True); touching |= set(contact.contactTable()["body"].tolist())
    return sorted(touching)

def build():
    built = bodies.build(True)
    O.bodies[1].state.pos = (0.75, 0.6, 0.55)  # its lower face on the soil
    return built

soil, contact, coupling = build()
O.run(10, True)
say("touch", contact.contacts)
O.bodies.erase(0)
say("erased", [seen(1), contact.forces[0].tolist()])
O.save("erased.yade.gz"); O.run(20, True); say("on", bodies.digest(soil, [1]))
O.load("erased.yade.gz"); coupling = mpm.yade.attach(); soil = coupling.scene["soil"]
O.run(20, True); say("loaded", bodies.digest(soil, [1]))

O.reset()
soil, contact, coupling = build()
O.engines = O.engines[:1] + [PyRunner(command="O.bodies.erase(0)", iterPeriod=5, firstIterRun=10, nDo=1)] \\
    + O.engines[1:]
say("before", seen(10)); say("in the loop", seen(1))

O.reset()
soil, contact, coupling = build()
O.run(10, True)
before = contact.largestPenetration
O.bodies[0].shape.radius *= 1.2
O.run(1, True)
say("grown", [before, contact.largestPenetration, contact._core.value("shapes")["radius"][0]])

O.reset()
soil, contact, coupling = build()
O.run(10, True)
clump = O.bodies.clump([0, 1])
O.bodies[0].shape.radius *= 1.05
say("clumped", seen(3))
O.save("clump.yade.gz"); O.run(5, True); say("clump on", bodies.digest(soil, [0, 1, clump]))
O.load("clump.yade.gz"); coupling = mpm.yade.attach(); soil = coupling.scene["soil"]
O.run(5, True); say("clump loaded", bodies.digest(soil, [0, 1, clump]))

O.reset()
soil, contact, coupling = build()
O.run(20, True)  # both have bounced off
more = O.bodies.append(utils.sphere((0.4, 0.75, 0.5948), 0.1))
state = O.bodies[more].state
state.mass, state.inertia, state.vel = bodies.MASS, (1e-4, 1e-4, 1e-4), (0, 0, -0.2)
ours = coupling.exchanges[0]
say("no body", fails(ValueError, lambda: ours.append(99)))
say("twice", fails(ValueError, lambda: ours.append(0)))
ours.append(more, friction=0.5)
bodies.IDS.append(more)
total = bodies.momentum(soil)
say("inserted", [seen(20), contact.friction[2], float(abs(bodies.momentum(soil) - total).max())])
O.save("more.yade.gz"); O.run(20, True); say("more on", bodies.digest(soil, bodies.IDS))
O.load("more.yade.gz"); coupling = mpm.yade.attach(); soil = coupling.scene["soil"]
O.run(20, True); say("more loaded", bodies.digest(soil, bodies.IDS))
O.bodies.clear(); O.run(1, True); say("cleared", coupling.scene.engines[1].contacts)
"""


@pytest.fixture(scope="module")
def change(tmp_path_factory):
    return run(CHANGE, tmp_path_factory.mktemp("change"), patience=120)[0]


def test_an_erased_body_leaves_no_ghost(change):
    touching, force = change["erased"]
    assert change["touch"] > 4 and force == [0, 0, 0] and touching == [1]
    assert change["on"] == change["loaded"], "bits after O.save and O.load"
    assert change["before"] == [0, 1] and change["in the loop"] == [1]
    assert change["cleared"] == 0


def test_a_body_that_grows_touches_as_it_is(change):
    before, after, radius = change["grown"]
    assert radius == pytest.approx(0.12) and after > before + 0.019


def test_a_body_that_is_inserted_later_touches(change):
    ids, friction, momentum = change["inserted"]
    assert ids == [2] and friction == 0.5 and momentum < 1e-12
    assert change["more on"] == change["more loaded"]
    assert "there is no body 99" in change["no body"] and "body 0 touches the soil already" in change["twice"]


def test_bodies_that_become_members_of_a_clump_touch_as_before(change):
    assert change["clumped"] == [0, 1]
    assert change["clump on"] == change["clump loaded"], "bits after O.save and O.load"
