# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin for YADE: its engines are those of YADE, and another YADE is refused.

With the plugin in the package all other tests of this folder run with it, too.
"""

import os
import re
import subprocess
from pathlib import Path

import pytest
from yadeProcess import needsPlugin, needsYade, plugin, run

ROOT = Path(__file__).resolve().parents[3]
pytestmark = [needsYade, needsPlugin]

SAVED = """
empty()
soil = mpm.yade.attach(hybrid())
O.run(30, True); O.save("state.xml"); O.save("state.yade.gz")
O.run(30, True); on = bits(soil.scene)
say("class", "MpmEngine" in open("state.xml").read())
for file in "state.xml", "state.yade.gz":
    O.load(file)
    say("plain", [type(O.engines[1]).__name__, O.engines[1].label, O.engines[2].stage])
    say("not attached", fails(RuntimeError, lambda: O.run(1, True)))
    O.load(file); soil = mpm.yade.attach(); O.run(30, True)
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
    _yade.registerClasses()
say("refused", fails(ImportError, load))
empty(); soil = mpm.yade.attach(hybrid()); O.run(5, True)
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
    importlib.util.module_from_spec(spec).registerClasses()
say("refused", fails(ImportError, load))
"""
    said, _ = run(script, tmp_path)
    assert re.search(r"a State takes \d+ bytes there and \d+ here", said["refused"])
