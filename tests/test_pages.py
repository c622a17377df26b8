# SPDX-License-Identifier: GPL-2.0-or-later
"""The tutorial and the how-to pages: their code runs from top to bottom, and comes to what they say."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import yade_mpm as mpm

DOC = Path(__file__).parents[1] / "doc"
CELLS = re.compile(r"^```\{code-cell\}[^\n]*\n(.*?)^```", re.S | re.M)
BLOCKS = re.compile(r"^```python\n(.*?)^```", re.S | re.M)
IN_YADE = ("yade", "yade-bodies")  # pages for YADE's Python
inYade = pytest.mark.skipif(
    shutil.which("yade") is None, reason="YADE is not installed (Debian: apt install yade)"
)
TESTED_ELSEWHERE = ("recipes",)
NOTEBOOKS = [page.stem for page in sorted((DOC / "tutorial").glob("*.md")) if CELLS.search(page.read_text())]
HOWTO = [
    page.stem
    for page in sorted((DOC / "howto").glob("*.md"))
    if BLOCKS.search(page.read_text()) and page.stem not in (*IN_YADE, *TESTED_ELSEWHERE)
]


@pytest.fixture
def execute(monkeypatch, capsys):
    """Function that runs the pieces of a page in their order; returns their names and what they print."""
    monkeypatch.setattr(sys, "argv", ["page"])
    before = plt.get_backend()
    plt.switch_backend("Agg")

    def pieces(page, pattern):
        names = {"__name__": "__main__"}
        for number, text in enumerate(pattern.findall((DOC / page).read_text())):
            exec(compile(text, f"{page}, piece {number}", "exec"), names)
        return names, capsys.readouterr().out

    yield pieces
    plt.close("all")
    plt.switch_backend(before)


def percents(text):
    return [float(number) / 100 for number in re.findall(r"([+-]?\d+\.\d+)%", text)]


def columnRuns(names, said):
    assert 1.5 < names["column"].position[:, 0].max() < 3
    assert len(names["results"]) == 11


def footingMeetsPrandtl(names, said):
    without, withFbar = percents(said)[:2]
    assert 0.05 < without < 0.15 and abs(withFbar) < 0.05
    assert "quasi-static: every ratio" in said and "NOT" not in said


def typesAgree(names, said):
    for body in names["scene"].bodies:
        exact = -2.0 * 9.81 * (2 - body.position[:, 1])
        assert abs((body.stress[:, 1, 1] - exact).mean()) < 0.01 * abs(exact).max()


def frictionTakesResistance(names, said):
    bonded, slips = (-names["curves"][n]["drive.fy"][-50:].mean() for n in ("bonded", "friction 0.3"))
    assert 0 < slips < 0.9 * bonded


def studyGoesOn(names, said):
    runOut = names["table"]["runOut"]
    assert list(runOut) == sorted(runOut, reverse=True) and len(list(Path("column/cases").iterdir())) == 4
    assert abs(names["finer"]["runOut"].item() / names["coarse"] - 1) < 0.15


def wallFallsWhereMomentsBalance(names, said):
    moved, depths = np.array(names["moved"]), np.array(names["DEPTHS"])
    assert moved[depths <= 2.5].max() < 0.1 and moved[depths > names["critical"]].min() > 0.5
    assert 3.1 < names["critical"] < 3.13


def slopeFailsAsPublished(names, said):
    stands, fails = (float(f) for f in re.findall(r"(?:stands|fails) at (\d\.\d\d)", said))
    assert stands < fails and 1.3 <= fails <= 1.5


def barMeetsPlasticity(names, said):
    assert 0 < names["found"] / 9.142 - 1 < 0.06


def pipeFollowsTheFit(names, said):
    assert abs(names["error"]) < 0.06


def depositsAreAsHighAsMeasured(names, said):
    assert max(abs(e) for e in percents(said)) < 0.12 and len(percents(said)) == 2


def fitFindsWhatWasGiven(names, said):
    found, known = names["found"], names["known"]
    assert all(found.values[n] == pytest.approx(known[n], rel=0.05) for n in known)
    assert abs(found.correlation[0][1]) < 0.9


CLAIMS = {
    "calibration": fitFindsWhatWasGiven,
    "column": depositsAreAsHighAsMeasured,
    "first-scene": columnRuns,
    "footing": footingMeetsPrandtl,
    "particle-types": typesAgree,
    "pipe": pipeFollowsTheFit,
    "sheet-pile": frictionTakesResistance,
    "slope": slopeFailsAsPublished,
    "study": studyGoesOn,
    "tbar": barMeetsPlasticity,
    "wall": wallFallsWhereMomentsBalance,
}


@pytest.mark.parametrize("page", NOTEBOOKS)
def test_a_notebook_of_the_tutorial_runs(page, execute):
    if page in ("calibration", "study"):
        pytest.importorskip("pandas", reason="no pandas here; scripts/setup --study installs it")
    CLAIMS[page](*execute(f"tutorial/{page}.md", CELLS))


def surchargeSettles(names, said):
    assert 1e-3 < -names["ground"].displacement[:, 1].min() < 0.02 and names["history"]["block.fy"][-1] < 0


def weakSlopeSlides(names, said):
    assert np.isclose(names["base"], -9.81 * (3 * 1.7 + 2.875 * 1.9), rtol=1e-6)
    assert 1.25 < names["found"].factor < 1.45 and Path("slope.png").stat().st_size > 10_000
    assert "\nlimit load 1" in said


def strengthIsMohrCoulomb(names, said):
    phi = np.radians(32)
    exact = (2 * 5 * np.cos(phi) + 2 * 100 * np.sin(phi)) / (1 - np.sin(phi))
    assert abs(names["drained"].q.max() / exact - 1) < 1e-6 and abs(exact - 243.5) < 0.05
    assert abs(names["fit"].fun).max() < 2 and "\nangle, hardening:" in said


def animationIsThere(names, said):
    assert Path("column.gif").stat().st_size > 1000 and names["columns"]["time"][-1] == names["scene"].time
    moved, column = names["moved"], names["column"]
    assert np.array_equal(moved.byId("velocity"), column.byId("velocity")) and moved.count == column.count


def test_results_has_no_block_that_is_not_run():
    heads = re.findall(r"^```(.+)$", (DOC / "howto" / "results.md").read_text(), re.M)
    assert set(heads) == {"python"}


def sceneIsAtItsEnd(names, said):
    assert names["scene"].time == names["END"]


def itRuns(names, said):
    """Of pages whose claims other tests check."""


ANSWERS = {
    "element-tests": strengthIsMohrCoulomb,
    "ground": weakSlopeSlides,
    "jupyter": sceneIsAtItsEnd,
    "loads": surchargeSettles,
    "results": animationIsThere,
}


@pytest.mark.parametrize("page", HOWTO)
def test_the_code_of_a_howto_page_runs(page, execute):
    ANSWERS.get(page, itRuns)(*execute(f"howto/{page}.md", BLOCKS))


def runInYade(page, folder):
    """Runs a script, or the one of a page, in YADE."""
    text = (DOC / page).read_text()
    (script,) = [text] if page.endswith(".py") else BLOCKS.findall(text)
    (folder / "page.py").write_text(script)
    environment = {
        "PYTHONPATH": str(Path(mpm.__file__).parents[1]),
        "MPLBACKEND": "Agg",
        "OMP_NUM_THREADS": "1",
    }
    return subprocess.run(
        ["yade", "-n", "-x", "page.py"],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
    )


@inYade
def test_the_howto_page_on_yade_runs(tmp_path):
    done = runInYade("howto/yade.md", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    columns = (tmp_path / "soil.txt").read_text().split("\n")[0].split()
    assert {"t", "kineticEnergy", "bottom.fy"} <= {name.strip("#") for name in columns}


@inYade
def test_the_howto_page_on_bodies_of_yade_runs(tmp_path):
    done = runInYade("howto/yade-bodies.md", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    height = float(re.search(r"Vector3\(\S+?,\S+?,(\S+?)\)", done.stdout)[1])
    assert 0.5 < height < 0.65  # the soil holds the sphere: it would have fallen by 1.2 m


@inYade
def test_the_tutorial_in_yade_runs(tmp_path):
    done = runInYade("tutorial/yade.md", tmp_path)
    depths = [float(depth) for depth in re.findall(r"is (\d\.\d+) m deep", done.stdout)]
    assert done.returncode == 0 and len(depths) == 3, done.stdout + done.stderr
    assert all(0.01 < depth < 0.1 for depth in depths)


@inYade
def test_the_tutorial_on_rocks_runs(tmp_path):
    done = runInYade("tutorial/rocks.py", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    across, along = (float(share) for share in re.findall(r" (\d\.\d\d) of", done.stdout))
    assert 0.2 < across < 0.6 and 0.5 < along < 0.8
    assert all(float(x) > 14 for x in re.findall(r"is at x = (\S+) m", done.stdout))  # they came down
    assert (tmp_path / "rocks.png").stat().st_size > 10_000
