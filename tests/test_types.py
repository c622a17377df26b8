# SPDX-License-Identifier: GPL-2.0-or-later
"""mypy knows the public interface: a right script passes, and mistakes are found in their lines."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yade_mpm as mpm

pytest.importorskip("mypy")

RIGHT = """import yade_mpm as mpm

soil = mpm.LinearElastic(density=1.5, young=1e4, poisson=0.3)
with mpm.Scene(lower=(0, 0), upper=(4, 2), cell=0.25) as scene:
    block = scene.add("block", mpm.box((0, 0), (1, 1)), soil, mpm.UGIMP(perCell=2))
    drive = mpm.Drive(block.above(0.5), velocity=(None, -0.1), ramp=0.1)
    scene.engines[1] = mpm.GridSolver(gravity=(0, -9.81), fixed="bottom", drive=drive)
    scene.engines.append(mpm.History(period=0.1, file="history.csv", label="all"))
    scene.threads = 2
    scene.run(until=1.0)
    print(block.stress.mean(axis=0), drive.reaction[1], 2 * scene["block"].inertiaScale)
frames = mpm.read("a.vtkhdf")
back = mpm.load("a.h5")
"""
TYPES = {
    "block": "yade_mpm.particle.body.Body",
    "scene.criticalTimeStep()": "builtins.float",
    "drive.reaction": "numpy.ndarray",
    "mpm.box((0, 0), (1, 1)) - mpm.disc((0, 0), 1)": "yade_mpm.geometry.region.Region",
    "back": "yade_mpm.scene.scene.Scene",
}
WRONG = [
    "mpm.Scene(lower=(0, 0), upper=(1, 1), cel=1)",
    "scene.runn(until=1)",
    "scene.add('b', mpm.box((0, 0), (1, 1)), soil, mpm.UGIMP(percell=2))",
    "scene.add('b', mpm.box((0, 0), (1, 1)), mpm.UGIMP(), soil)",
    "mpm.Contact(friction='much')",
    "mpm.PyRunner(print, perod=1)",
    "drive.reacton",
]


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """What mypy says about RIGHT, then a line for each of TYPES and of WRONG: (number of line, text)."""
    folder = tmp_path_factory.mktemp("types")
    lines = [*(f"reveal_type({name})" for name in TYPES), *WRONG]
    (folder / "script.py").write_text(RIGHT + "\n".join(lines) + "\n")
    command = [sys.executable, "-m", "mypy", "--follow-imports=silent", "--cache-dir=cache", "script.py"]
    where = {**os.environ, "MYPYPATH": str(Path(mpm.__file__).parents[1])}
    done = subprocess.run(command, cwd=folder, env=where, capture_output=True, text=True)
    found = [line.split(":", 2) for line in done.stdout.splitlines() if line.startswith("script.py:")]
    assert found, done.stdout + done.stderr
    return [(int(number), text.strip()) for _, number, text in found]


def test_a_right_script_has_no_errors(said):
    assert [text for number, text in said if number <= RIGHT.count("\n")] == []


@pytest.mark.parametrize("name", TYPES)
def test_results_have_their_types(name, said):
    line = RIGHT.count("\n") + 1 + list(TYPES).index(name)
    (told,) = [text for number, text in said if number == line]
    assert told.startswith(f'note: Revealed type is "{TYPES[name]}')


@pytest.mark.parametrize("mistake", WRONG)
def test_a_mistake_is_an_error_in_its_line(mistake, said):
    line = RIGHT.count("\n") + 1 + len(TYPES) + WRONG.index(mistake)
    assert any(text.startswith("error:") for number, text in said if number == line)


def test_the_package_says_that_it_has_types():
    assert (Path(mpm.__file__).parent / "py.typed").exists()
