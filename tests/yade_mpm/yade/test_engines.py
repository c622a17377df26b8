# SPDX-License-Identifier: GPL-2.0-or-later
"""Engines of a scene among those of YADE: what they are, and in which order they may stand."""

import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

FACES = """
empty()
history = mpm.History(iterPeriod=20, label="rows")
scene = hybrid(history)
soil = mpm.yade.attach(scene)
solver = O.engines[2]
say("classes", [type(e).__name__ for e in O.engines])
say("same", [solver is soil.engines[1], solver is mpm_GridSolver, isinstance(solver, PyRunner),
    solver.engine is scene.engines[1]])
say("read", [solver.gravity, solver.damping, solver.label, solver.dead])
solver.gravity = (0, -1.62); solver.damping = 0.1
say("written", [scene.engines[1].gravity, scene.engines[1].damping])
say("dict", {k: v for k, v in solver.dict().items() if k in ("gravity", "damping", "label", "dead")})
say("no command", "command" in solver.dict())
say("repr", repr(solver)); say("print", str(O.engines[1]))
say("not allowed", fails(ValueError, lambda: setattr(solver, "damping", -1)))
say("unknown", fails(AttributeError, lambda: setattr(solver, "dampning", 1)))
say("no such", fails(AttributeError, lambda: solver.dampning))
say("pace", fails(AttributeError, lambda: setattr(solver, "iterPeriod", 10)))
say("own pace", O.engines[6].iterPeriod); O.engines[6].iterPeriod = 5
O.run(10, True)
say("rows", [len(history), history.iterPeriod])
say("doc", "gravity" in type(solver).__doc__)
PyRunner.iterPeriod.__set__(solver, 2)
say("every second", fails(ValueError, lambda: O.run(1, True)))
soil = mpm.yade.attach(scene, stages=False)
chain = O.engines[1]
say("chain", [type(chain).__name__, chain.GridSolver.damping, list(chain.dict()), repr(chain)])
say("chain unknown", fails(AttributeError, lambda: chain.Contact))
O.timingEnabled = True; O.run(2, True)
from yade import timing; timing.stats()
"""


@pytest.fixture(scope="module")
def faces(tmp_path_factory):
    return run(FACES, tmp_path_factory.mktemp("faces"))[0]


def test_engines_of_a_scene_are_engines_of_yade_with_their_own_attributes(faces):
    assert faces["classes"] == [
        "ForceResetter",
        "ParticleToGrid",
        "GridSolver",
        "GridToParticle",
        "VelocityRemap",
        "DomainUpdater",
        "History",
        "NewtonIntegrator",
    ]
    assert faces["same"] == [True] * 4
    assert faces["read"] == [[0, -9.81], 0.05, "mpm_GridSolver", False]
    assert faces["written"] == [[0, -1.62], 0.1]
    assert faces["dict"] == {"gravity": [0, -1.62], "damping": 0.1, "label": "mpm_GridSolver", "dead": False}
    assert not faces["no command"] and faces["doc"]
    assert faces["repr"].startswith("<mpm_GridSolver: GridSolver(gravity=(0.0, -1.62), damping=0.1")
    assert faces["print"].startswith("<mpm_ParticleToGrid: ParticleToGrid(")


def test_mistakes_with_attributes_are_told(faces):
    assert "damping = -1" in faces["not allowed"]
    assert "did you mean 'damping'" in faces["unknown"] and "dampning" in faces["no such"]
    assert "iterPeriod cannot be set; the engines of a scene act in every step" in faces["pace"]
    assert "mpm_GridSolver: iterPeriod = 2 is not allowed" in faces["every second"]


def test_the_period_of_a_callback_is_its_own(faces):
    assert faces["own pace"] == 20 and faces["rows"] == [2, 5]


def test_the_scene_as_one_engine_shows_its_engines(faces):
    name, damping, entries, text = faces["chain"]
    assert name == "Chain" and damping == 0.1
    assert entries[-1] == "rows" and "GridSolver" in entries
    assert "Scene 2D" in text and "ParticleToGrid -> GridSolver" in text
    assert "there is no engine 'Contact'" in faces["chain unknown"]


def test_engines_called_by_hand_or_lost_in_a_run_are_told(tmp_path):
    said, _ = run(
        """
empty()
scene = hybrid(); soil = mpm.yade.attach(scene)
O.run(5, True)
say("by hand", [fails(RuntimeError, O.engines[2]), O.iter, scene.steps, soil.error])
O.run(5, True); say("goes on", [O.iter, scene.steps])
O.run()
while scene.steps < 20: time.sleep(0.001)
O.engines = [e for e in O.engines if e not in soil.engines]
while O.iter < scene.steps + 5 and O.running: time.sleep(0.001)
say("lost", fails(RuntimeError, O.pause))
mpm.yade.attach(scene); O.run(5, True)
say("attached again", scene.time == O.time + mpm.yade.attach(scene).timeOffset)
""",
        tmp_path,
    )
    message, *state = said["by hand"]
    assert "acts in the loop of YADE only; call O.step()" in message and state == [5, 5, None]
    assert said["goes on"] == [10, 10]
    assert "O.engines has lost" in said["lost"] and said["attached again"]


ORDER = """
import bodies
soil, contact, coupling = bodies.build(True)
scene = coupling.scene
ours, resetter, newton = coupling.engines, ForceResetter(), NewtonIntegrator()
def tried(*engines):
    O.engines = list(engines)
    return [fails(ValueError, lambda: O.run(1, True)), scene.steps]
say("behind", tried(resetter, newton, *ours))
say("split", tried(resetter, *ours[:2], newton, *ours[2:]))
say("forgotten", tried(resetter, *ours, ForceResetter(), newton))
say("between", tried(*ours[:2], resetter, *ours[2:], newton))
say("no resetter", tried(*ours, newton))
say("swapped", tried(resetter, ours[1], ours[0], *ours[2:], newton))
say("right", tried(resetter, *ours, newton))
say("others between", tried(resetter, *ours[:2], PyRunner(command="pass", iterPeriod=1), *ours[2:], newton))
O.periodic = True
attach = lambda: mpm.yade.attach(scene)
say("periodic", [fails(ValueError, lambda: O.run(1, True)), fails(ValueError, attach)])
O.periodic = False
scene.engines[2].gravity, newton.gravity = (0, 0, -9.81), (0, 0, -1.62)
O.engines = [resetter, *ours, newton]
mpm.yade.attach(scene); O.run(1, True); O.run(1, True)
newton.gravity = (0, 0, -3.3); O.run(1, True)
newton.gravity = (0, 0, -9.81); O.run(1, True)
mpm.yade.attach(scene); O.run(1, True)
"""


def test_an_order_in_which_bodies_feel_nothing_is_refused(tmp_path):
    said, err = run(ORDER, tmp_path)
    for name, text in {
        "behind": "the NewtonIntegrator stands before 'mpm_DomainUpdater'",
        "split": "the NewtonIntegrator stands before",
        "forgotten": "a ForceResetter stands between",
        "between": "a ForceResetter stands between",
        "no resetter": "there is no ForceResetter",
        "swapped": "in the order mpm_RigidContact, mpm_ParticleToGrid",
    }.items():
        assert text in said[name][0] and said[name][1] == 0, name
    assert said["right"] == ["no error", 1] and said["others between"] == ["no error", 2]
    assert all("YADE's cell is periodic" in text for text in said["periodic"])
    assert err.count("warning: 'mpm': gravity differs: the NewtonIntegrator has (0, 0, -1.62)") == 1
    assert err.count("gravity differs") == 2, "told again where it was changed"


def test_another_scene_of_yade_is_not_run_without_its_soil(tmp_path):
    said, _ = run(
        """
empty()
scene = hybrid(); mpm.yade.attach(scene)
O.run(5, True)
O.switchScene(); say("other", [fails(RuntimeError, lambda: O.run(2, True)), O.iter])
O.switchScene(); O.run(2, True); say("back", [O.iter, scene.steps])
""",
        tmp_path,
    )
    message, iteration = said["other"]
    assert "after O.switchScene(), switch back" in message and iteration == 0
    assert said["back"] == [7, 7]
