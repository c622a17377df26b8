# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin for YADE: engines that step without Python, and nothing else changes.

With the plugin in the package all other tests of this folder run with it, too.
"""

import importlib.util
import os
import re
import subprocess
from pathlib import Path

import pytest
from yadeProcess import needsYade, run

ROOT = Path(__file__).resolve().parents[3]
plugin = importlib.util.find_spec("yade_mpm._yade")
pytestmark = [
    needsYade,
    pytest.mark.skipif(
        plugin is None, reason="the plugin is not built (cmake -DYADE_SOURCE=DIR, see doc/howto/yade.md)"
    ),
]

WITHOUT = """
from yade_mpm.yade import native
native.plugin = lambda: None
"""
COUNTED = """
from yade_mpm.yade.coupling import Coupling
asked, began = [], Coupling._beginStep
def counted(self):
    asked.append(O.iter)
    began(self)
Coupling._beginStep = counted
from yade_mpm.yade import grants
grants.SECONDS = 60.0  # no machine is so slow
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
    soil = inYade.attach(scene, **how)
    O.run(400 // soil.mpmSteps, True)
    engine = soil.engines[0]
    say(name, [bits(scene), scene.time == O.time, len(asked), len(scene.engines[-1])])
    say("engine of " + name, [base.__name__ for base in type(engine).__mro__])
    O.dt *= 0.9; O.step(); O.dt *= 0.9; O.run(30, True); O.step()
    say(name + " on", [scene.steps - 32 * soil.mpmSteps, scene.time == O.time])
"""


def test_granted_steps_have_the_bits_of_the_own_loop(tmp_path):
    said, _ = run(COUNTED + SAME, tmp_path)
    for name in "stages", "chain", "many":
        digest, isSameTime, asked, rows = said[name]
        assert digest == said["own"] or name == "many"  # whose steps are others
        assert isSameTime and rows == 8
        assert asked < 40  # of 400 steps: where rows and checks are due
        assert said["engine of " + name][2:4] == ["MpmEngine", "PyRunner"]
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


def test_bodies_get_the_same_bits_with_and_without_the_plugin(tmp_path):
    native, _ = run(COUNTED + TOUCHING, tmp_path)
    python, _ = run(WITHOUT + COUNTED + TOUCHING, tmp_path)
    assert native["touch"][1] < -0.05  # m/s, of soil that they have pushed
    assert native.pop("asked") < 30 and python.pop("asked") == 100
    assert native == python


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
    soil = inYade.attach(build(), stages=how)
    say("yade", fails(RuntimeError, lambda: O.run(400, True)))
    say("where", [len(asked), O.iter, soil.scene.steps, len([f for f in os.listdir() if "failed" in f])])
    say("again", fails(RuntimeError, lambda: O.run(1, True)))
"""


def test_an_error_in_a_granted_step_is_raised_behind_it(tmp_path):
    said, _ = run(COUNTED + STRAYS, tmp_path)
    assert said["own"].startswith("step ")
    assert said["yade"].splitlines()[0][:30] == said["own"].splitlines()[0][:30]
    asked, iteration, steps, files = said["where"]
    assert asked < iteration and iteration - steps in (0, 1) and files > 0
    assert "was stopped by an error" in said["again"]


SAVED = """
empty()
soil = inYade.attach(hybrid())
O.run(30, True); O.save("state.xml"); O.save("state.yade.gz")
O.run(30, True); on = bits(soil.scene)
say("class", "MpmEngine" in open("state.xml").read())
for file in "state.xml", "state.yade.gz":
    O.load(file)
    say("plain", [type(O.engines[1]).__name__, O.engines[1].label, O.engines[2].stage])
    say("not attached", fails(RuntimeError, lambda: O.run(1, True)))
    O.load(file); soil = inYade.attach(); O.run(30, True)
    say(file, bits(soil.scene) == on)
"""


def test_its_engines_are_saved_as_what_they_are(tmp_path):
    said, _ = run(SAVED, tmp_path)
    assert said["class"] and said["plain"] == ["MpmEngine", "mpm_ParticleToGrid", 1]
    assert "no scene is attached as 'mpm'" in said["not attached"]
    assert said["state.xml"] and said["state.yade.gz"]


OTHER = """
def load():
    from yade_mpm import _yade
    _yade.registerEngines()
say("refused", fails(ImportError, load))
empty(); soil = inYade.attach(hybrid()); O.run(5, True)
say("goes on", [soil.scene.steps, "MpmEngine" in dir(yade.wrapper)])
"""
REFUSED = {
    "yade.config.version = '2024.02a'": "it is version 2024.02a, the plugin is for",
    "yade.config.features.remove('MPI')": "it was built without MPI, the plugin was not",
    "yade.config.features.append('SPH')": "it was built with SPH, the plugin was not",
    "yade.config.highPrecisionBits = 80": "its Real has 80 bits",
}


@pytest.mark.parametrize("change", REFUSED)
def test_it_refuses_a_yade_of_another_version_or_flags(tmp_path, change):
    said, err = run(OTHER, tmp_path, first=f"import yade.config\n{change}\n")
    assert "was built for another YADE than the one that runs: " + REFUSED[change] in said["refused"]
    assert said["goes on"] == [5, False]
    assert "warning: yade_mpm's plugin was built for another YADE" in err


@pytest.mark.slow
def test_it_refuses_a_yade_whose_states_are_of_another_size(tmp_path):
    """Built with SPH, which adds three numbers to each State, and told that YADE had it, too."""
    cache = Path(plugin.origin).resolve().parents[2] / "CMakeCache.txt"
    known = dict(re.findall(r"^(YADE_\w+):\w+=(.*)$", cache.read_text(), re.MULTILINE))
    given = [f"-D{name}={value}" for name, value in known.items()]
    build = tmp_path / "build"
    flags = ["-DMPM_TESTS=OFF", "-DMPM_BENCHMARK=OFF", "-DCMAKE_CXX_FLAGS=-DYADE_SPH"]
    subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", *given, *flags], check=True)
    subprocess.run(["cmake", "--build", build, "--target", "_yade"], check=True)
    [other] = (build / "python" / "yade_mpm").glob("_yade*.so")
    script = f"""
import importlib.util, yade.config
yade.config.features.append("SPH")
def load():
    spec = importlib.util.spec_from_file_location("_yade", {os.fspath(other)!r})
    importlib.util.module_from_spec(spec).registerEngines()
say("refused", fails(ImportError, load))
"""
    said, _ = run(script, tmp_path)
    assert re.search(r"a State takes \d+ bytes there and \d+ here", said["refused"])
