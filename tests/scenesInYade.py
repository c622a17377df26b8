# SPDX-License-Identifier: GPL-2.0-or-later
"""Scripts that run inside YADE, and what they say."""

import pytest
from yadeProcess import needsYade, run

pytestmark = needsYade


# --- the same bits, clocks, time steps --------------------------------------------------------------------
SAME = """
own = hybrid(); own.run(steps=400)
say("own", [bits(own), own.time])
for name, stages in (("stages", True), ("chain", False)):
    O.reset(); empty()
    scene = hybrid()
    soil = mpm.yade.attach(scene, stages=stages)
    O.timingEnabled = True
    O.run(400, True)
    say(name, [bits(scene), scene.time, O.time, [e.label for e in O.engines],
        [e.execCount for e in soil.engines]])
O.dt *= 0.999
own.run(steps=1); O.run(1, True)
say("other dt", [bits(own), bits(scene)])

for name, ratio in (("mpm", dict(mpmSteps=3)), ("dem", dict(demSteps=4))):
    O.reset(); empty()
    scene = hybrid()
    seen = []
    soil = mpm.yade.attach(scene, **ratio)
    class Exchange:
        def read(self, c): seen.append(("read", O.time == scene.time))
        def apply(self, c): seen.append(("apply", O.iter))
    soil.exchanges.append(Exchange())
    O.run(400, True)
    say(name, [scene.steps, scene.time, O.time, O.dt, soil.maxDt, scene.dtCritical, scene._core.dt,
               sum(s[0] == "apply" for s in seen), [s[1] for s in seen if s[0] == "read"]])
    dt, before = O.dt, O.time
    O.run(1, True); O.dt = dt / 2
    O.run(7, True)
    say(name + " changed", [scene.steps, scene.time - O.time, O.dt / dt,
        (dt + 7 * dt / 2) / (O.time - before)])
"""


@pytest.fixture(scope="module")
def same(tmp_path_factory):
    return run(SAME, tmp_path_factory.mktemp("same"), command=("yade", "-n", "-x", "-j2"))[0]


STEPS = """
from yade.utils import sphere, PWaveTimeStep
O.materials.append(FrictMat(young=1e5, density=2600, poisson=.3, frictionAngle=.5))
O.bodies.append([sphere((10, 10, 0), .5, fixed=True), sphere((10, 10, .99), .5)])
def engines(stiff=1.0):
    return [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]),
            InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()],
                [Law2_ScGeom_FrictPhys_CundallStrack()])]
stepper = GlobalStiffnessTimeStepper(timeStepUpdateInterval=1)
O.engines = engines() + [stepper, NewtonIntegrator(gravity=(0, 0, -9.81))]
O.run(20, True); say("dem alone", O.dt)
scene = hybrid()
soil = mpm.yade.attach(scene)
O.run(20, True)
say("with mpm", [O.dt, stepper.maxDt, soil.maxDt, scene._core.dt, O.time + soil.timeOffset == scene.time])
stepper.timeStepUpdateInterval = 1000; O.dt = 0.1
O.run(1, True); say("by hand", [O.dt, soil.maxDt])
stepper.timeStepUpdateInterval = 1
soil.detach()
O.run(20, True); say("without", [O.dt, stepper.maxDt > 1, len(O.engines)])
stepper.maxDt = 1e-4
soil = mpm.yade.attach(scene)
O.run(20, True); say("smaller maxDt", [O.dt, stepper.maxDt, scene._core.dt]); soil.detach()
say("behind", fails(ValueError, lambda: (setattr(O, "engines", engines() + [NewtonIntegrator(), stepper]),
    mpm.yade.attach(scene))))

O.reset()
O.materials.append(FrictMat(young=1e9, density=2600, poisson=.3, frictionAngle=.5))
O.bodies.append(sphere((10, 10, 0), .05)); empty()
scene = hybrid(); soil = mpm.yade.attach(scene)
say("stiff sphere", [O.dt, 0.8 * PWaveTimeStep(), soil.maxDt])
O.reset(); empty(); O.dt = 1e-5
scene = hybrid(); soil = mpm.yade.attach(scene); O.run(5, True); say("given", [O.dt, scene._core.dt])
O.dt = 0.99 * soil.criticalDt; O.run(1, True); say("largest", [scene._core.dt / O.dt, scene.time == O.time])
O.dt = 1.01 * soil.criticalDt
say("too large", [fails(ValueError, lambda: O.run(5, True)), O.iter, scene.steps])
O.dt = 1e-5; O.run(1, True); say("corrected", [O.iter, scene.steps, soil.error])

O.reset(); empty(); scene = hybrid(); soil = mpm.yade.attach(scene)
O.run(10, True)
for e in soil.engines: e.dead = True
O.run(10, True); say("dead", [scene.steps, scene.time < O.time])
for e in soil.engines: e.dead = False
O.run(10, True); say("alive", [scene.steps, scene.time == O.time])
stress = scene["soil"].stress.copy()
soil.engines[4].dead = True; O.run(5, True)
say("no updater", [scene.steps, scene.time == O.time, bool((stress == scene["soil"].stress).all())])
scene.step(); say("stepped", fails(RuntimeError, lambda: O.run(5, True)))
soil = mpm.yade.attach(scene); O.run(5, True); O.resetTime()
say("set back", fails(RuntimeError, lambda: O.run(5, True)))
soil = mpm.yade.attach(scene)
say("offset", [soil.timeOffset > 0, O.run(5, True), O.time + soil.timeOffset == scene.time])
for engines in ([*O.engines, (late := PyRunner(command="O.dt *= 0.9", iterPeriod=1, initRun=True))],
        [late, *O.engines]):
    O.engines = engines; first = O.dt
    O.run(5, True); say("dt by a PyRunner", [O.dt / first, O.time + soil.timeOffset - scene.time])
    O.engines = [e for e in O.engines if e is not late]
O.run()
say("running", [fails(RuntimeError, lambda: mpm.yade.attach(scene)), fails(RuntimeError, scene.step),
    fails(RuntimeError, soil.detach)])
O.pause()
for name, arguments in dict(ratio=dict(mpmSteps=2, demSteps=2), zero=dict(demSteps=0),
    half=dict(mpmSteps=1.5), label=dict(label="a b"),
                            several=dict(mpmSteps=2, stages=True), twice=dict(label="other")).items():
    say(name, fails(ValueError, lambda: mpm.yade.attach(scene, **arguments)))
say("kind", fails(TypeError, lambda: mpm.yade.attach("scene")))
say("unsaved", fails(ValueError, mpm.yade.attach))
"""


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    return run(STEPS, tmp_path_factory.mktemp("steps"))[0]
