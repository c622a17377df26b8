# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene inside YADE: output, habits, errors. Each script runs in a process of its own."""

import json
import os
import re
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest
import yade_mpm as mpm
from yadeProcess import YADE, end, needsYade, run, start, untilSaid

pytestmark = needsYade

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
    # YADE's recorder at the head of the engines: its files have the numbers of our steps.
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
    assert "after O.load call mpm.inYade()" in loaded["not attached"]
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
    assert "no scene is attached" in loaded["late"][0]
    assert "at O.iter = 102, YADE is at 103" in loaded["late"][1]


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
soil = mpm.yade.attach(scene); O.run(5, True); say("corrected", [scene.steps, O.iter])
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
    assert said["corrected"] == [35, 36]  # in the step of `again` the scene had no part
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
    assert said["xy"]["contacts"] >= 2
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
