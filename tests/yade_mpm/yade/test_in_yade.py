# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes inside the real YADE. Each script below is run in a process of its own and reports through
`say(name, value)`."""

import json
import os
import re
import signal
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from yadeProcess import YADE, end, needsYade, run, start, untilSaid

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


@pytest.mark.parametrize("kind", ["stages", "chain"])
def test_the_same_bits_as_by_its_own_loop(same, kind):
    digest, time, yadeTime, labels, counts = same[kind]
    assert [digest, time] == same["own"] and yadeTime == time
    stages = [
        f"mpm_{name}"
        for name in ("ParticleToGrid", "GridSolver", "GridToParticle", "VelocityRemap", "DomainUpdater")
    ]
    assert labels == ["", *(stages if kind == "stages" else ["mpm"]), ""]  # before the NewtonIntegrator
    assert counts == [400] * len(counts)  # timed by YADE


def test_control_another_time_step_makes_other_bits(same):
    assert same["other dt"][0] != same["other dt"][1]


@pytest.mark.parametrize("kind, steps, ratio", [("mpm", 1200, 3), ("dem", 100, 1 / 4)])
def test_subcycling_keeps_the_clocks_together(same, kind, steps, ratio):
    taken, time, yadeTime, dt, maxDt, critical, own, applied, inTime = same[kind]
    assert taken == steps and time == yadeTime
    assert dt == maxDt == pytest.approx(0.8 * critical * ratio, rel=1e-12) and own == pytest.approx(
        dt / ratio, rel=1e-15
    )
    assert applied == 400 and len(inTime) == (400 if kind == "mpm" else 100) and all(inTime)


@pytest.mark.parametrize("kind, steps", [("mpm", 1200 + 24), ("dem", 102)])
def test_a_change_of_dt_waits_for_the_end_of_a_cycle(same, kind, steps):
    taken, difference, factor, ratio = same[kind + " changed"]
    assert taken == steps and abs(difference) < 1e-15 and factor == 0.5
    assert ratio == pytest.approx(
        1.0 if kind == "mpm" else 4.5 / 6, rel=1e-9
    )  # the first cycle of four keeps its step


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
O.dt = 1e-5; O.run(1, True); say("mended", [O.iter, scene.steps, soil.error])

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


def test_a_time_stepper_respects_the_critical_step_of_the_scene(steps):
    dt, maxDt, limit, own, together = steps["with mpm"]
    assert steps["dem alone"] > 5 * limit  # control: alone the stepper takes far more
    assert dt == maxDt == limit == own and together
    assert steps["by hand"][0] == steps["by hand"][1]
    assert steps["without"][0] > 2 * limit and steps["without"][1:] == [True, 5]
    assert steps["smaller maxDt"] == [1e-4, 1e-4, 1e-4]
    assert "put it before the NewtonIntegrator" in steps["behind"]


def test_the_smaller_step_wins(steps):
    dt, dem, limit = steps["stiff sphere"]
    assert dt == dem < limit
    assert steps["given"] == [1e-5, 1e-5]
    assert steps["largest"] == [1.0, True]
    message, iteration, taken = steps["too large"]
    assert "exceeds" not in message and "is not allowed: the critical step of 'mpm'" in message
    assert (iteration, taken) == (6, 6)  # before the first step
    assert steps["mended"] == [7, 7, None]  # without attaching again


def test_dead_engines_and_a_clock_that_was_moved(steps):
    assert steps["dead"] == [10, True] and steps["alive"] == [20, True]
    assert steps["no updater"] == [25, True, True]
    assert "has taken steps outside of YADE" in steps["stepped"] and "the clocks differ" in steps["set back"]
    factor, difference = steps["dt by a PyRunner"]
    assert factor == pytest.approx(0.9**5) and abs(difference) < 1e-15
    assert steps["offset"] == [True, None, True]


def test_bad_input(steps):
    assert "YADE is running" in steps["running"][0] and "going on in the background" in steps["running"][1]
    assert "YADE is running" in steps["running"][2]
    assert "one of the two has to be 1" in steps["ratio"] and "demSteps = 0 is not allowed" in steps["zero"]
    assert (
        "mpmSteps = 1.5 is not allowed" in steps["half"] and "label = 'a b' is not allowed" in steps["label"]
    )
    assert "give stages=False" in steps["several"] and "attached as 'mpm' already" in steps["twice"]
    assert "give a yade_mpm.Scene" in steps["kind"] and "no scene was given" in steps["unsaved"]


def test_without_yade_attach_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "yade", None)
    with pytest.raises(ImportError, match="apt install yade"):
        mpm.yade.attach(None)


CHOSEN = """
from yade import plot
def rows(plot_):
    O.reset(); plot.reset()
    scene = hybrid(mpm.History(iterPeriod=5), mpm.History(iterPeriod=5, label="second"))
    empty()
    mpm.yade.attach(scene, plot=plot_)
    O.run(20, True)
    return sorted(plot.data)
say("all", len(rows(True)))
say("chosen", rows(["kineticEnergy", "second.mass"]))
say("none", rows(False))
say("unknown", fails(ValueError, lambda: rows(["cineticEnergy"])))
say("wrong", fails(TypeError, lambda: rows("mass")))
"""


def test_plot_takes_the_columns_that_are_named(tmp_path):
    said, _ = run(CHOSEN, tmp_path)
    assert said["chosen"] == ["i", "kineticEnergy", "second.mass", "t"]
    assert said["all"] > 20 and said["none"] == []
    assert "plot names the column 'cineticEnergy', which no History has; columns: " in said["unknown"]
    assert "plot = 'mass' is not allowed; give True, False, or a list of names of columns" in said["wrong"]


# --- habits -----------------------------------------------------------------------------------------------
HABITS = """
import h5py, numpy as np
from yade import plot, timing
from yade.utils import sphere
O.bodies.append(sphere((10, 10, 10), 1.0))
O.tags["description"] = "a test"
own = hybrid(); own.run(steps=300)
scene = hybrid(mpm.Recorder("out.vtkhdf", iterPeriod=50),
    mpm.History(iterPeriod=20, file="out.csv", columns={"head": "scene['block'].position[:, 1].max()"}))
O.engines = [VTKRecorder(fileName="dem-", iterPeriod=50, recorders=["spheres"], initRun=True),
    ForceResetter(),
             NewtonIntegrator(gravity=(0, 0, -10))]
soil = mpm.yade.attach(scene, plot=True)
O.stopAtIter = 100
O.timingEnabled = True
O.run(); O.wait()
say("stopAtIter", [O.iter, scene.steps])
O.step(); say("step", [O.iter, scene.steps])
O.run()
while scene.steps < 130: time.sleep(0.001)
O.pause(); time.sleep(0.2)  # the step that is going on is done first
at = O.iter, scene.steps; time.sleep(0.05)
say("pause", [at, [O.iter, scene.steps], 130 <= at[0] < 300])
# likewise, or O.iter is still one behind
O.run(); say("save running", fails(RuntimeError, lambda: O.save("no.yade.gz"))); O.pause(); time.sleep(0.2)
say("steps left", 300 - O.iter)
O.run(300 - O.iter, True)
say("same", bits(own) == bits(scene))
timing.stats()
with h5py.File("out.vtkhdf") as f:
    say("frames", [f["VTKHDF/Steps/Values"][:].tolist(), json.loads(f.attrs["O.tags"])["description"],
        json.loads(f.attrs["O.tags"])["id"] == O.tags["id"]])
say("dt", O.dt)
plot.plots = {"t": ("head.fy", "head")}
plot.saveDataTxt("plot.txt")
say("plot", [plot.data["i"], plot.data["t"] == plot.data["time"], plot.data["step"],
    bool(np.isfinite(plot.data["head.fy"]).all())])
"""


def test_habits_of_yade(tmp_path):
    said, _ = run(HABITS, tmp_path)
    assert said["stopAtIter"] == [100, 100] and said["step"] == [101, 101]
    assert said["pause"][0] == said["pause"][1] and said["pause"][2]
    assert "O.pause()" in said["save running"]
    assert said["steps left"] > 0 and said["same"]  # however it was stopped and continued
    times, description, sameId = said["frames"]
    assert times == pytest.approx(np.arange(0, 301, 50) * said["dt"], rel=1e-12)
    # YADE's recorder at the head of the engines: its files bear the numbers of our steps.
    numbers = sorted(int(re.search(r"\d+", p.name)[0]) for p in tmp_path.glob("dem-*.vtu"))
    assert numbers == [0, 50, 100, 150, 200, 250]
    assert description == "a test" and sameId
    i, sameTime, rows, finite = said["plot"]
    assert i == rows == list(range(20, 301, 20)) and sameTime and finite
    assert "head.fy" in (tmp_path / "plot.txt").read_text().splitlines()[0]
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 16


IN_MEMORY = """
empty()
soil = mpm.yade.attach(hybrid())
O.run(30, True); O.saveTmp(); O.saveTmp("later")
O.run(30, True); on = bits(soil.scene)
O.loadTmp(); soil = mpm.yade.attach(); at = O.iter
O.run(30, True)
say("on", [at, O.iter, bits(soil.scene) == on])
O.reload(); soil = mpm.yade.attach(); say("reloaded", O.iter)
O.loadTmp("later"); soil = mpm.yade.attach(); say("later", O.iter)
O.run()
say("running", fails(RuntimeError, O.saveTmp))
"""


def test_what_is_saved_in_memory_comes_back_with_the_scene(tmp_path):
    said, _ = run(IN_MEMORY, tmp_path)
    assert said["on"] == [30, 60, True]
    assert said["reloaded"] == said["later"] == 30
    assert "O.saveTmp: YADE is running" in said["running"]
    assert not list(tmp_path.glob("*.h5"))


SAVE = """
O.bodies.append(utils.sphere((10, 10, 10), 1.0)); empty()
scene = hybrid(mpm.History(iterPeriod=10, file="out.csv"))
soil = mpm.yade.attach(scene, demSteps=4)
O.run(102, True)  # in the middle of a cycle
O.save("state.yade.gz")
O.run(200, True)
say("on", [bits(scene), O.iter, O.time, len(scene.engines[-1])])
"""
LOAD = """
O.load("state.yade.gz")
say("not attached", fails(RuntimeError, lambda: O.run(5, True)))
O.load("state.yade.gz")
soil = mpm.yade.attach()
say("loaded", [soil.demSteps, O.iter, [e.label for e in O.engines]])
O.run(200, True)
say("on", [bits(soil.scene), O.iter, O.time, len(soil.scene.engines[-1])])
O.load("state.yade.gz")
soil = mpm.yade.attach(demSteps=2); O.run(200, True); say("other", bits(soil.scene))
O.load("state.yade.gz")
say("late", [fails(RuntimeError, O.step), fails(ValueError, mpm.yade.attach)])
"""


def test_save_and_load_continue_with_the_same_bits(tmp_path):
    said, _ = run(SAVE, tmp_path)
    assert os.path.exists(mpm.yade.checkpointOf(tmp_path / "state.yade.gz"))
    loaded, _ = run(LOAD, tmp_path)
    assert "after O.load call mpm.yade.attach()" in loaded["not attached"]
    stages = [
        "mpm_ParticleToGrid",
        "mpm_GridSolver",
        "mpm_GridToParticle",
        "mpm_VelocityRemap",
        "mpm_DomainUpdater",
        "mpm_History",
    ]
    assert loaded["loaded"] == [4, 102, ["", *stages, ""]]
    assert loaded["on"] == said["on"]
    assert loaded["other"] != said["on"][0]  # control
    assert (
        "no scene is attached" in loaded["late"][0] and "at O.iter = 102, YADE is at 103" in loaded["late"][1]
    )


# --- errors and signals -----------------------------------------------------------------------------------
ERRORS = """
def boom(scene):
    if scene.steps == 30: raise KeyError("boom")
seen = []
scene = hybrid(mpm.PyRunner(boom, iterPeriod=10, label="boom"))
empty(); soil = mpm.yade.attach(scene)
O.engines = O.engines + [PyRunner(command="seen.append(O.iter)", iterPeriod=1, initRun=True)]
O.run()
while O.running: time.sleep(0.001)
say("background", [fails(KeyError, O.wait), O.iter, scene.steps, seen[-1], str(soil.error)])
say("again", fails(RuntimeError, lambda: O.run(5, True)))
scene.engines = scene.engines[:-1]
soil = mpm.yade.attach(scene); O.run(5, True); say("mended", [scene.steps, O.iter])
for name, stages in (("stages", True), ("chain", False)):
    O.reset(); empty(); other = hybrid(); mpm.yade.attach(other, stages=stages)
    O.run(3, True)
    O.engines = O.engines + [PyRunner(command="1 / 0", iterPeriod=1, initRun=True)]
    begun = time.time(); message = fails(RuntimeError, lambda: O.run(5, True))
    at = [O.iter, other.steps]
    O.engines = O.engines[:-1]; O.run(5, True)
    say("of another, " + name, ["division by zero" in message, at, [O.iter, other.steps],
        other.time == O.time, time.time() - begun < 5])
O.reset(); empty(); soil = mpm.yade.attach(scene)
scene.engines = [*scene.engines[:2], mpm.PyRunner(lambda: 1 / 0, iterPeriod=1), *scene.engines[2:]]
soil = mpm.yade.attach(scene)
O.run(5, True)
"""


def test_an_error_pauses_yade_after_the_step_and_is_raised(tmp_path):
    said, message = run(ERRORS, tmp_path, code=1)
    assert said["background"] == ["'boom'", 30, 30, 29, "'boom'"]
    assert "attach it again" in said["again"]
    assert said["mended"] == [35, 36]  # in the step of `again` the scene had no part
    for kind in ("stages", "chain"):  # YADE repeats the step, but no PyRunner that acted in it
        assert said["of another, " + kind] == [True, [3, 4], [8, 8], True, True]
    assert "ZeroDivisionError" in message and "the run failed at step 35" in message
    file = tmp_path / re.search(r"failed at step 35.*the state is in (\S+)", message)[1]
    with pytest.warns(UserWarning, match="interrupted step"):
        assert mpm.load(file, callbacks={"<lambda>": None}).steps == 35


SIGNAL = """
O.bodies.append(utils.sphere((10, 10, 10), 1.0)); empty()
scene = hybrid()
soil = mpm.yade.attach(scene)
O.run(20, True)
say("go", 0)
"""
STOPS = {"run": "O.run(10**8, True)", "background": "O.run()\nwhile True: time.sleep(0.01)"}


@pytest.mark.parametrize(
    "how, number, code",
    [("run", signal.SIGINT, 1), ("run", signal.SIGTERM, 143), ("background", signal.SIGTERM, 143)],
)
def test_signals_leave_a_state_to_continue_from(tmp_path, how, number, code):
    process = start(SIGNAL + STOPS[how], tmp_path)
    untilSaid(process, "go")
    process.send_signal(number)
    _, message = end(process, code)
    assert "interrupted at O.iter" in message
    [file] = tmp_path.glob("*.interrupted.yade.gz")
    with h5py.File(mpm.yade.checkpointOf(file)) as f:
        spec = json.loads(bytes(f["scene"][...]))
    assert spec["steps"] >= 20 and not spec["midStep"]
    if (how, number) == ("run", signal.SIGTERM):
        said, _ = run(
            f"""
O.load("{file.name}"); soil = mpm.yade.attach(); scene = soil.scene
say("clocks", [O.time == scene.time, O.iter == scene.steps])
n = scene.steps; O.run(10, True); own = hybrid(); own.run(steps=n + 10); say("same", bits(own) == bits(scene))
""",
            tmp_path,
        )
        assert said == {"clocks": [True, True], "same": True}


def test_plain_python_with_import_yade(tmp_path):
    """YADE as a module of Debian's Python, without the command."""
    text = Path(YADE).read_text()
    folder = re.search(r"sys\.path\.insert\(1,'(.*)'\)", text)[1]
    interpreter = text.split("\n")[0][2:].strip()
    script = f"""
sys.path.insert(1, {folder!r})
import yade
from yade import O, ForceResetter, NewtonIntegrator
empty()
scene = hybrid(); mpm.yade.attach(scene); O.run(100, True)
own = hybrid(); own.run(steps=100)
say("same", bits(own) == bits(scene))
"""
    said, _ = run(script, tmp_path, command=(interpreter,))
    assert said["same"]


def test_groups_slip_on_each_other_as_by_the_own_loop(tmp_path):
    """Stage by stage, and after `detach` by the scene itself. Control: bonded."""
    said, _ = run(
        """
def slide(isBonded=False):
    scene = hybrid()
    scene["block"].group = "block"
    chain = list(scene.engines)
    scene.engines = chain[:2] + [mpm.Contact(friction=0.3, dead=isBonded)] + chain[2:]
    return scene

for name, isBonded in (("own", False), ("bonded", True)):
    own = slide(isBonded); own.run(steps=300); say(name, bits(own))
empty()
scene = slide()
soil = mpm.yade.attach(scene); O.run(200, True); soil.detach()
scene.run(steps=100)
say("staged", bits(scene))
""",
        tmp_path,
    )
    assert said["staged"] == said["own"] != said["bonded"]


# --- bodies of YADE that touch the soil ---------------------------------------------------------------------
@pytest.mark.parametrize("mpmSteps, demSteps", [(1, 1), (3, 1), (1, 3)])
def test_momentum_goes_from_the_bodies_to_the_soil(tmp_path, mpmSteps, demSteps):
    said, _ = run(
        f"import bodies\nsay('fly', bodies.fly(150, mpmSteps={mpmSteps}, demSteps={demSteps}))", tmp_path
    )
    fly = said["fly"]
    assert fly["contacts"] > 2 and fly["given"] < -1e-3
    assert fly["change"] < 1e-12, "momentum, Mg m/s, of 8e-3"


@pytest.mark.parametrize("mpmSteps, demSteps", [(1, 1), (3, 1), (1, 3)])
def test_momentum_is_kept_where_yade_steps_by_less_than_the_scene_may(tmp_path, mpmSteps, demSteps):
    """A body gets the impulse of the steps that were taken, not of steps of scene.dt."""
    how = f"mpmSteps={mpmSteps}, demSteps={demSteps}, dt=1e-3, demDt={5e-4 * mpmSteps / demSteps!r}"
    said, _ = run(f"import bodies\nsay('fly', bodies.fly(300, {how}))", tmp_path)
    fly = said["fly"]
    assert fly["contacts"] > 2 and fly["given"] < -1e-3
    assert fly["change"] < 1e-12, "momentum, Mg m/s, of 8e-3"


def test_control_without_the_exchange_momentum_is_not_kept(tmp_path):
    said, _ = run("import bodies\nsay('fly', bodies.fly(150, isCoupled=False))", tmp_path)
    assert said["fly"]["change"] > 1e-4


@pytest.mark.parametrize("isPolyhedron, highest", [(False, 0.55), (True, 0.555)])
def test_the_soil_carries_the_weight(tmp_path, isPolyhedron, highest):
    """Of a box, and of the same as a polyhedron: facets also touch what is beside their edges, which carries
    it 3 mm higher."""
    said, _ = run(f"import bodies\nsay('rest', bodies.rest(isPolyhedron={isPolyhedron}))", tmp_path)
    rest = said["rest"]
    assert rest["force"] == pytest.approx(0.2, rel=0.05)  # MASS * G
    assert abs(rest["velocity"]) < 2e-3 and 0.54 < rest["height"] < highest


def test_a_box_and_a_clump_fall_alike_in_every_plane(tmp_path):
    """Control: `Bodies` that are told another plane."""
    said, _ = run(
        """
import planes
for name in ("xy", "xz", "yz"): say(name, planes.fall(name))
say("thinner", planes.fall("xy", thickness=0.25))
say("told another", fails(ValueError, lambda: planes.fall("xz", as_="xy")))
""",
        tmp_path,
    )
    assert said["xy"]["contacts"] >= 3
    for name in ("states", "forces"):
        for plane in ("xz", "yz"):
            assert np.array(said[plane][name]) == pytest.approx(
                np.array(said["xy"][name]), rel=1e-9, abs=1e-9
            )
        assert np.abs(np.array(said["thinner"][name]) - said["xy"][name]).max() > 0.1
    assert "turned out of the plane" in said["told another"]


def test_what_cannot_touch_the_soil_is_said(tmp_path):
    said, _ = run(
        """
from yade import utils
contact = mpm.RigidContact()
O.bodies.append([utils.wall(0, 2, sense=0), utils.wall(0, 2, sense=1)])
clump, members = O.bodies.appendClumped([utils.sphere((0, 0, 0), 1), utils.sphere((1, 0, 0), 1)])
say("wall", fails(ValueError, lambda: mpm.yade.Bodies(contact, [0])))
say("nobody", fails(ValueError, lambda: mpm.yade.Bodies(contact, [99])))
say("twice", fails(ValueError, lambda: mpm.yade.Bodies(contact, [1, 1])))
say("bool", fails(TypeError, lambda: mpm.yade.Bodies(contact, True)))
say("member", fails(ValueError, lambda: mpm.yade.Bodies(contact, members[:1])))
say("thickness", fails(ValueError, lambda: mpm.yade.Bodies(contact, [1], thickness=0)))
say("plane", fails(ValueError, lambda: mpm.yade.Bodies(contact, [1], plane="zx")))
mpm.yade.Bodies(contact, [1, clump])
say("shapes", len(contact._core.value("shapes")["kind"]))
""",
        tmp_path,
    )
    assert "body 1 is given twice" in said["twice"] and "ids = True; give numbers" in said["bool"]
    assert "sense 0; give 1 or -1" in said["wall"] and "no body 99" in said["nobody"]
    assert "give the number of the clump" in said["member"] and "thickness = 0" in said["thickness"]
    assert "plane = 'zx' is not allowed; give one of 'xy', 'xz', 'yz'" in said["plane"]
    assert said["shapes"] == 3, "the wall and the two spheres of the clump"
