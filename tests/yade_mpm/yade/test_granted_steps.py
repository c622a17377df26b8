# SPDX-License-Identifier: GPL-2.0-or-later
"""Steps that are granted to the engines in YADE, by the plugin and without it: nothing else changes."""

import pytest
from yadeProcess import COUNTED, WITHOUT, needsPlugin, needsYade, run

pytestmark = needsYade
ways = pytest.mark.parametrize(
    "first", [pytest.param("", marks=needsPlugin, id="plugin"), pytest.param(WITHOUT, id="python")]
)
NONE = """
from yade_mpm.yade import grants
grants.MOST = 0
"""

SAME = """
def build():
    scene = hybrid(mpm.History(iterPeriod=50))
    scene.threads = 1
    return scene
own = build(); own.run(steps=400)
say("own", bits(own))
for name, how in (("stages", {}), ("chain", dict(stages=False)), ("many", dict(mpmSteps=4))):
    O.reset(); empty(); asked.clear()
    scene = build()
    soil = mpm.yade.attach(scene, **how)
    O.run(400 // soil.mpmSteps, True)
    say(name, [bits(scene), scene.time == O.time, len(asked), len(scene.engines[-1])])
    O.dt *= 0.9; O.step(); O.dt *= 0.9; O.run(30, True); O.step()
    say(name + " on", [scene.steps - 32 * soil.mpmSteps, scene.time == O.time])
"""


@ways
def test_granted_steps_have_the_bits_of_the_own_loop(tmp_path, first):
    said, _ = run(first + COUNTED + SAME, tmp_path)
    for name in "stages", "chain", "many":
        digest, isSameTime, asked, rows = said[name]
        assert digest == said["own"] or name == "many"  # whose steps are others
        assert isSameTime and rows == 8
        assert asked < 40  # of 400 steps: where rows and checks are due
        assert said[name + " on"] == [400, True]


TOUCHING = """
import bodies
soil, contact, coupling = bodies.build(True)
ball = O.bodies[0].state
ball.blockedDOFs, ball.vel = "xyzXYZ", (0, 0, -1)  # pressed into the soil
O.run(30, True)
say("touch", [bodies.bits(soil), float(soil.velocity[:, 2].min())])
O.engines = [PyRunner(command="O.bodies.erase(1)", iterPeriod=20, nDo=1)] + O.engines
O.run(70, True)
say("erased", [bodies.digest(soil, [0]), coupling.exchanges[0].forces[1].tolist()])
say("asked", len(asked))
"""


@ways
def test_bodies_get_the_same_bits_in_granted_steps(tmp_path, first):
    granted, _ = run(first + COUNTED + TOUCHING, tmp_path)
    none, _ = run(NONE + COUNTED + TOUCHING, tmp_path)
    assert granted["touch"][1] < -0.05  # m/s, of soil that they have pushed
    assert granted.pop("asked") < 30 and none.pop("asked") == 100
    assert granted == none


CHANGING = """
empty(PyRunner(command="stiffen()", iterPeriod=7)); seen = []
scene = hybrid(); scene.threads = 1
soil = mpm.yade.attach(scene)
def stiffen():
    soil.materials["soil"].young *= 1.02  # the critical step follows
    seen.append(O.iter)
O.run(60, True)
say("asked", [k for k in seen if k not in asked])
say("bits", [bits(scene), scene.dt])
"""


@ways
def test_a_material_that_changes_counts_at_once(tmp_path, first):
    """The steps in which it changes are taken as a whole, not when the next look is due."""
    said, _ = run(first + COUNTED + CHANGING, tmp_path)
    none, _ = run(NONE + COUNTED + CHANGING, tmp_path)
    assert said["asked"] == [] and said["bits"] == none["bits"]


FOLDED = """
from yade.wrapper import PyRunner as Runner
def build():
    scene = hybrid(); scene.threads = 1
    return scene
own = build(); own.run(steps=100); say("own", bits(own))
calls = []
def note(): calls.append([Runner.dict(e)["iterPeriod"] for e in soil.engines])
empty(PyRunner(command="note()", iterPeriod=1))
scene = build(); soil = mpm.yade.attach(scene)
O.run(20, True)
say("folded", calls[-1]); say("at rest", [Runner.dict(e)["iterPeriod"] for e in soil.engines])
O.run(1000); O.pause(); O.save("state.xml")
say("saved", open("state.xml").read().count("<iterPeriod>50</iterPeriod>"))
O.reset(); empty(PyRunner(command="note()", iterPeriod=1)); scene = build(); soil = mpm.yade.attach(scene)
O.run(20, True); calls.clear()
O.timingEnabled = True; O.run(20, True); say("timed", [calls[-1], [e.execCount for e in soil.engines]])
O.timingEnabled = False
between = []
O.engines = [*O.engines[:3], PyRunner(command="between.append(scene.engines[1]._core.seconds)", iterPeriod=1),
    *O.engines[3:]]
O.run(20, True); say("between", [len(between), calls[-1]])
O.engines = [e for e in O.engines if "between" not in getattr(e, "command", "")]
O.run(30, True); say("folded again", calls[-1])
O.run(10, True); say("bits", bits(scene))
def kill():
    if O.iter in (105, 112): soil.engines[-1].dead = O.iter == 105
    if O.iter in (113, 115):  # the scene rests
        for e in soil.engines: e.dead = O.iter == 113
O.engines = [PyRunner(command="kill()", iterPeriod=1), *O.engines]
O.run(20, True); say("dead", [bits(scene), scene.steps])
def fail():
    if O.iter == 130: raise ValueError("mine")
O.engines = [*O.engines, PyRunner(command="fail()", iterPeriod=1)]
say("failed", [fails(RuntimeError, lambda: O.run(20, True))[-4:], O.iter, scene.steps, calls[-1]])
O.engines = O.engines[:-1]; O.run(5, True)
say("on", [O.iter, scene.steps, scene.time == O.time, bits(scene)])
"""


def test_of_engines_of_python_the_first_takes_a_granted_step(tmp_path):
    """YADE leaves out the others where nobody can tell: PyRunners cost more than small scenes."""
    said, _ = run(WITHOUT + COUNTED + FOLDED, tmp_path)
    none, _ = run(NONE + WITHOUT + COUNTED + FOLDED, tmp_path)
    active, folded = [1] * 5, [1, 50, 50, 50, 50]  # with VelocityRemap
    assert none["folded"] == active, "control"
    assert said["folded"] == said["folded again"] == folded
    assert said["at rest"] == active and said["saved"] == 0
    assert said["timed"] == [active, [20] * 5]
    assert said["between"] == [20, active], "an engine of the user between two stages"
    assert said["bits"] == said["own"]
    assert said["failed"][3] == folded, "the step that failed was taken as a whole"
    for name in "dead", "on":
        assert said[name] == none[name]


STRAYS = """
def build():
    scene = mpm.Scene((0, 0), (4, 3), 0.25)
    soil = mpm.LinearElastic(density=2.0, young=1e3, poisson=0.3)
    scene.add("soil", mpm.box((1, 1), (2, 2)), soil, mpm.UGIMP(perCell=2)).velocity[:] = (0, -20)
    scene.dt = 1e-3
    return scene
say("own", fails(RuntimeError, lambda: build().run(steps=400)))
for how in True, False:
    O.reset(); empty(); asked.clear()
    soil = mpm.yade.attach(build(), stages=how)
    say("yade", fails(RuntimeError, lambda: O.run(400, True)))
    say("where", [len(asked), O.iter, soil.scene.steps, len([f for f in os.listdir() if "failed" in f])])
    say("again", fails(RuntimeError, lambda: O.run(1, True)))
"""


@ways
def test_an_error_in_a_granted_step_is_raised_behind_it(tmp_path, first):
    said, _ = run(first + COUNTED + STRAYS, tmp_path)
    assert said["own"].startswith("step ")
    assert said["yade"].splitlines()[0][:30] == said["own"].splitlines()[0][:30]
    asked, iteration, steps, files = said["where"]
    assert asked < iteration and iteration - steps in (0, 1) and files > 0
    assert "was stopped by an error" in said["again"]


ROWS = """
def build():
    scene = hybrid(mpm.History(iterPeriod=1), mpm.History(iterPeriod=7, label="seventh")); scene.threads = 1
    return scene
def rows(scene): return [len(e) for e in scene.engines if isinstance(e, mpm.History)]
def rare():
    scene = hybrid(mpm.History(iterPeriod=7)); scene.threads = 1
    return scene
for name, make in (("all", build), ("seventh", rare)):
    own = make(); own.run(steps=70); found = [rows(own)]
    for how in ("run", "steps", "runs"):
        O.reset(); empty(); scene = make(); soil = mpm.yade.attach(scene)
        if how == "run": O.run(70, True)
        for _ in range({"run": 0, "steps": 70, "runs": 35}[how]): O.run({"steps": 1, "runs": 2}[how], True)
        found.append(rows(scene))
    say(name, found)
"""


@ways
def test_no_row_of_a_history_is_lost(tmp_path, first):
    """The engines behind the last stage were left out in the step in which the next ones were granted."""
    said, _ = run(first + COUNTED + ROWS, tmp_path)
    assert said["all"] == [[70, 10]] * 4 and said["seventh"] == [[10]] * 4


GHOST = """
def build(count):
    scene = mpm.Scene((0, 0, 0), (5, 1, 1.5), 0.25, threads=1)
    elastic = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3)
    scene.add("soil", mpm.box((0, 0, 0), (5, 1, 0.5)), elastic, mpm.UGIMP(perCell=2))
    contact = mpm.RigidContact()
    solver = mpm.GridSolver(damping=0.3, fixed="bottom")
    scene.engines = [mpm.ParticleToGrid(), contact, solver, mpm.GridToParticle(), mpm.DomainUpdater()]
    ids = [O.bodies.append(utils.sphere((0.25 + 0.5 * k, 0.5, 0.7), 0.2)) for k in range(count)]
    for i in ids:
        state = O.bodies[i].state
        state.mass, state.blockedDOFs, state.vel = 1, "xyzXYZ", (0, 0, -1)
    return scene, mpm.yade.Bodies(contact, ids, friction=0.5)
def note():
    if O.iter == 100: O.bodies.erase(0)
    pushed.append(abs(float(bodies.forces[0][2])) if O.iter > 102 else 0)
from yade import utils
for count in (1, 3, 10):
    O.reset(); pushed = []; scene, bodies = build(count); O.dt = 2e-4
    empty(PyRunner(command="note()", iterPeriod=1))
    soil = mpm.yade.attach(scene, bodies=bodies)
    O.run(200, True); say(str(count), [sum(pushed), len(pushed)])
"""


@ways
def test_a_body_that_is_erased_in_a_run_leaves_no_ghost(tmp_path, first):
    """Who asks whether bodies have changed got its answer once, and the one who reads them asks again."""
    said, _ = run(first + COUNTED + GHOST, tmp_path)
    assert said["1"] == said["3"] == said["10"] == [0, 199]


SET = """
empty(PyRunner(command="stop()", iterPeriod=1))
scene = hybrid(); scene.threads = 1
soil = mpm.yade.attach(scene); at = []
def stop():
    if O.iter == 60: soil.engines[1].updateAttrs(dict(damping=0.5))
    at.append((O.iter, scene.engines[1].damping))
O.run(70, True); say("damping", [d for k, d in at if k in (60, 61)]); say("asked", 61 in asked or 60 in asked)
"""


@ways
def test_attributes_that_are_set_by_a_dict_count_at_once(tmp_path, first):
    said, _ = run(first + COUNTED + SET, tmp_path)
    assert said["damping"] == [0.5, 0.5] and said["asked"]


GROWS = """
import bodies
soil, contact, coupling = bodies.build(False)
def half(): return [float(x) for x in contact._core.value("shapes")["halfSize"][1]]
def grow():
    if O.iter == 30: O.bodies[1].shape.extents = (0.08, 0.1, 0.09)
    if O.iter in (30, 32): say(str(O.iter), half())
O.engines = [PyRunner(command="grow()", iterPeriod=1)] + O.engines
O.run(60, True)
"""


def test_a_box_that_grows_in_a_run_is_felt(tmp_path):
    """At once without the plugin, whose steps look at what erases bodies and at radii."""
    said, _ = run(WITHOUT + COUNTED + GROWS, tmp_path)
    assert said["30"][:2] == said["32"][:2] and said["32"] == pytest.approx([0.08, 0.1, 0.09])
    assert said["30"] != said["32"]


LOST = """
empty(PyRunner(command="lose()", iterPeriod=1))
scene = hybrid(); scene.threads = 1
soil = mpm.yade.attach(scene)
def lose():
    if O.iter == 20: O.engines = [e for e in O.engines if e is not soil.engines[0]]
    if O.iter == 120: say("late", 1)
say("error", fails(Exception, lambda: O.run(200, True))); say("at", O.iter)
"""


@ways
def test_an_engine_that_is_lost_in_a_run_ends_it(tmp_path, first):
    said, _ = run(first + COUNTED + LOST, tmp_path)
    assert "late" not in said and said["at"] < 120 and "GridSolver" in said["error"]


GROWING = """
from yade_mpm.yade import grants
def build():
    scene = mpm.Scene((0, 0), (8, 8), 0.25, threads=1)
    soft = mpm.LinearElastic(density=2.0, young=1.0, poisson=0.3)
    stiff = mpm.LinearElastic(density=2.0, young=1e5, poisson=0.3)  # it makes the step short
    soil = scene.add("soft", mpm.box((3, 3), (5, 5)), soft, mpm.UGIMP(perCell=2))
    scene.add("stiff", mpm.box((1, 1), (2, 2)), stiff, mpm.UGIMP(perCell=2))
    soil.velocity[:] = 1.5 * (soil.position - 4.0)  # grown enough between steps 100 and 110
    return scene
own = build(); own.run(steps=1); before = own.dt; own.run(steps=399)
say("own", [bits(own), own.dt]); say("shorter", before / own.dt)
for name, how in (("stages", {}), ("chain", dict(stages=False))):
    O.reset(); empty(PyRunner(command="grants.revokeAll()", iterPeriod=30)); asked.clear()
    scene = build(); soil = mpm.yade.attach(scene, **how)
    O.run(400, True)
    say(name, [bits(scene), scene.dt]); say(name + " asked", list(asked))
"""


@ways
def test_a_look_at_growth_asks_python_only_where_much_has_grown(tmp_path, first):
    """The step becomes shorter when it does in the own loop."""
    said, _ = run(first + COUNTED + GROWING, tmp_path)
    assert said["shorter"] > 1.01, "control"
    for name in "stages", "chain":
        assert said[name] == said["own"]
        asked = said[name + " asked"]
        assert 120 in asked, "control"
        assert not {49, 50, 99, 100} & set(asked)
