# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints while YADE runs, and what PyRunners before the engines of a scene may do."""

import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade

CHECKPOINTS = """
from yade import utils
from yade_mpm.yade import checkpoints
import glob, os
checkpoints.SHARE = 1.0
def build(stages=True, **given):
    O.reset()
    rock = O.materials.append(FrictMat(young=1e5, poisson=0.3, density=2.6, frictionAngle=0.5))
    O.bodies.append([utils.sphere((10, 10, 0), 0.5, fixed=True, material=rock),
        utils.sphere((10.3, 10, 0.94), 0.5, material=rock)])
    O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()],
            [Law2_ScGeom_FrictPhys_CundallStrack()]), NewtonIntegrator(gravity=(0, 0, -9.81))]
    scene = hybrid()
    scene.threads = 1
    return scene, mpm.yade.attach(scene, stages=stages, **given)
def state(scene): return [bits(scene), O.iter, O.time, repr([list(O.bodies[1].state.pos),
    list(O.bodies[1].state.vel), [list(i.phys.shearForce) for i in O.interactions]])]

for name, given in dict(stages={}, chain=dict(stages=False), ahead=dict(demSteps=3)).items():
    scene, soil = build(checkpointPeriod=0.03, **given)
    # slow enough that some are written
    O.engines = O.engines + [PyRunner(command="time.sleep(2e-4)", iterPeriod=1, initRun=True)]
    O.run(400, True); on = state(scene)
    files = sorted(glob.glob("*.checkpoint-?.yade.gz"), key=os.path.getmtime)
    O.load(files[-1]); at = O.iter
    soil = mpm.yade.attach()
    kept = [soil.checkpointPeriod, [e.label for e in O.engines].count("mpm_Checkpoint")]
    O.run(400 - at, True)
    say(name, [state(soil.scene) == on, at, [f[-8 - 2:-8] for f in files], kept, scene is not soil.scene])
    for file in files: os.remove(file)
soil.detach(); say("detached", [e.label for e in O.engines])

# a file that cannot be written
scene, soil = build(checkpointPeriod=1e-3)
from yade_mpm.yade import coupling as module
def broken(*a): raise OSError("no space left")
saved, module.save = module.save, broken
O.run(50, True); say("goes on", O.iter); module.save = saved

# PyRunners of users, in the first step of a run
scene, soil = build()
O.engines = [PyRunner(command="O.save('own.yade.gz')", iterPeriod=1, initRun=True, nDo=1)] + O.engines
O.run(100, True); on = state(scene)
O.load("own.yade.gz"); soil = mpm.yade.attach(); say("own at", O.iter)
O.engines[0].dead = True
O.run(100, True); say("own", state(soil.scene) == on)
scene, soil = build()
O.engines = [PyRunner(command="O.pause()", iterPeriod=1, initRun=True)] + O.engines
O.run(100, True); say("paused", [O.iter, scene.steps])
O.run(); O.wait(); say("paused behind", [O.iter, scene.steps])
scene, soil = build()
place = [e.label for e in O.engines].index("mpm_GridSolver")
O.engines = O.engines[:place] + [PyRunner(command="O.save('no.yade.gz')", iterPeriod=1, initRun=True)] \\
    + O.engines[place:]
say("in the middle", fails(RuntimeError, lambda: O.run(5, True)))
for bad in (0, -1, "600", True): say(f"bad {bad}", fails(ValueError, lambda: build(checkpointPeriod=bad)))
"""


@pytest.fixture(scope="module")
def checkpoints(tmp_path_factory):
    said, err = run(CHECKPOINTS, tmp_path_factory.mktemp("checkpoints"), patience=120)
    return {**said, "err": err}


@pytest.mark.parametrize("kind", ["stages", "chain", "ahead"])
def test_a_run_goes_on_from_a_checkpoint_with_the_same_bits(checkpoints, kind):
    isSame, at, letters, kept, isAnother = checkpoints[kind]
    assert isSame and 0 < at < 400 and set(letters) == {"-a", "-b"}
    assert kept == [0.03, 1] and isAnother
    assert "mpm_Checkpoint" not in checkpoints["detached"]


def test_a_checkpoint_that_cannot_be_written_ends_no_run(checkpoints):
    assert checkpoints["goes on"] == 50
    assert "warning: mpm_Checkpoint: no space left; the run goes on" in checkpoints["err"]


def test_pyrunners_before_the_engines_may_save_and_pause(checkpoints):
    assert checkpoints["own at"] == 0 and checkpoints["own"]
    assert checkpoints["paused"] == [1, 1] and checkpoints["paused behind"] == [2, 2]
    assert "in the middle of a step" in checkpoints["in the middle"]


@pytest.mark.parametrize("bad", [0, -1, "600", True])
def test_a_wrong_period_is_told(checkpoints, bad):
    assert "checkpointPeriod" in checkpoints[f"bad {bad}"]
