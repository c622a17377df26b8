# SPDX-License-Identifier: GPL-2.0-or-later
"""What is called while YADE runs waits for the end of the step, however the threads are scheduled."""

import subprocess

import pytest
from yadeProcess import end, needsYade, start

pytestmark = needsYade

QUICK, MANY = 12, 500  # tries
BUSY = ["sh", "-c", "while :; do :; done"]

SCRIPT = """
from random import Random
chance = Random(7)
def build(isChain):
    empty()
    scene = hybrid()
    scene.threads = 1
    return scene, mpm.yade.attach(scene, stages=not isChain)
def together(): return O.iter == scene.steps and O.time == scene.time
def wait(): time.sleep(chance.choice((0, 0, 1e-4, 1e-3, 5e-3)))
scene, soil = build(False)
wrong = []
"""
TRIES = {
    "pause and step": """
for k in range({tries}):
    O.run(); wait(); O.pause()
    at = O.iter
    O.step()
    if O.iter != at + 1 or not together(): wrong.append([k, at, O.iter, scene.steps])
""",
    "pause and save": """
for k in range({tries}):
    O.run(); wait(); O.pause()
    at, digest = O.iter, bits(scene)
    O.save("state.yade.gz")
    O.load("state.yade.gz")
    soil = mpm.yade.attach(); scene = soil.scene
    if O.iter != at or not together() or bits(scene) != digest: wrong.append([k, at, O.iter, scene.steps])
""",
    "reset in a run": """
for k in range({tries}):
    O.run(); wait(); O.reset()
    before = scene.steps
    scene, soil = build(k % 2 == 0)
    O.run(2, True)
    if O.iter != 2 or not together(): wrong.append([k, before, O.iter, scene.steps])
""",
    "dt at the prompt": """
O.run()
for k in range({tries}):
    wait()
    O.dt = soil.maxDt / (1 + k % 3)
    if not O.running: wrong.append([k, O.iter])
say("too large", fails(ValueError, lambda: setattr(O, "dt", 1)))
say("runs on", O.running)
O.pause()
if not together(): wrong.append(["clocks", O.time, scene.time])
""",
}


def wrongs(folder, tries, *names):
    """What went wrong in so many tries of each."""
    script = SCRIPT + "".join(TRIES[name].format(tries=tries) for name in names) + 'say("wrong", wrong)\n'
    said, err = end(start(script, folder), patience=60 + tries)
    if "dt at the prompt" in names:
        assert "O.dt = 1 s is not allowed: the critical step of 'mpm'" in said["too large"]
        assert said["runs on"]
    return said["wrong"]


def test_who_leaves_while_yade_runs_leaves_behind_a_step(tmp_path):
    end(start("empty(); mpm.yade.attach(hybrid()); O.run(); time.sleep(0.1)", tmp_path))  # exit code 0


def test_the_step_under_way_is_waited_for(tmp_path):
    assert wrongs(tmp_path, QUICK, *TRIES) == []


@pytest.mark.slow
@pytest.mark.parametrize("what", TRIES)
def test_the_step_under_way_is_waited_for_on_a_busy_machine(tmp_path, what):
    others = [subprocess.Popen(BUSY) for _ in range(3)]
    try:
        assert wrongs(tmp_path, MANY, what) == []
    finally:
        for other in others:
            other.kill()
            other.wait()
