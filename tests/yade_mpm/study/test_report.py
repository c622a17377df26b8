# SPDX-License-Identifier: GPL-2.0-or-later
"""The report of a study: what it has, and that a browser shows it, on a phone, too."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yade_mpm as mpm
from setups import chain
from yade_mpm.app.record import saveCurve
from yade_mpm.io.files import saveJson
from yade_mpm.study import collect, pictures, report, state
from yade_mpm.study.program import main
from yade_mpm.study.study import Study

SCENE = Path(__file__).with_name("demo_scene.py")
BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
PHONE = 412  # CSS pixels


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """Folder of a study of twelve cases with made-up results: one failed, one waits."""
    out = tmp_path_factory.mktemp("report")
    axes = {"gravity": [5.0, 10.0, 15.0], "perCell": [1, 2], "end": ["well", "sleeps"]}
    study = Study(SCENE, axes, out)
    for number, (folder, case) in enumerate(zip(study.folders, study.cases)):
        if number == 10:
            Path(folder, state.LOG).write_text("step 1\n<b>diverged</b>\n")
            state.write(folder, state.FAILED, "killed by SIGKILL", seconds=2.0)
        elif number < 10:
            x = np.linspace(0, 1, 20)
            saveCurve(folder, "load", {"depth (m)": x, "load (kN)": case["gravity"] * x})
            saveJson(f"{folder}/summary.json", {"load": case["gravity"] * case["perCell"], "steps": 7})
            shutil.copy(
                Path(__file__).parents[3] / "doc" / "images" / "sheet_pile_slip.png",
                Path(folder, "sheet_pile.png"),
            )
            state.write(folder, state.DONE, seconds=1.0)
    Path(out, report.FINDINGS).write_text("Load grows with gravity.\n\nTwice & more.\n")
    study.write()
    return out


def test_the_report_marks_failures_and_shows_all_that_was_found(out):
    page = (out / "report.html").read_text()
    assert "12 cases: 10 done, 1 failed, 1 waiting" in page
    assert page.count('<tr class="done">') == 10 and page.count('<tr class="failed">') == 1
    assert "&lt;b&gt;diverged&lt;/b&gt;" in page and "<b>diverged" not in page  # a log is text
    for head in (
        "Findings",
        "Cases",
        "Failures",
        "load",
        "Main effects",
        "Sensitivity",
        "Heat maps",
        "Pictures",
    ):
        assert f"<h2>{head}</h2>" in page
    assert "Twice &amp; more." in page


def fall(a):
    """A block that falls, with what a study from Python may leave out: no curve is saved."""
    scene = mpm.Scene((0, 0), (2, 3), a.cell, threads=1)
    rubber = mpm.LinearElastic(density=a.density, young=1e3, poisson=0.3)
    scene.add("block", mpm.box((0.5, 1), (1.5, 2)), rubber, mpm.UGIMP(perCell=2))
    height = "scene['block'].position[:, 1].mean()"
    history = mpm.History(period=0.01, columns={"height": height})
    scene.engines = [*chain(gravity=(0, -9.81)), history]
    return scene


def found(scene):
    return {"particlesInside": scene.particleCount, "weight": 9.81 * float(scene["block"].mass.sum())}


def test_a_study_from_python_has_title_units_and_curves_and_no_effects_of_counts(tmp_path):
    cell = mpm.Parameter("cell", 0.5, "of the grid", unit="m", above=0)
    density = mpm.Parameter("density", 1.0, "of the block", unit="Mg/m3", above=0)
    parameters = mpm.Parameters("falling block", "A block falls.", cell, density)
    axes = {"cell": [0.5, 0.25], "density": [1.0, 2.0]}
    mpm.study.run(fall, axes, found, until=0.05, out=tmp_path, parameters=parameters, quiet=True, jobs=1)
    page = (tmp_path / "report.html").read_text()
    assert "<h1>Study of falling block: A block falls</h1>" in page
    assert "<th>cell (m)</th><th>density (Mg/m3)</th>" in page
    curves = page.split("<h2>height</h2>")[1].split("</svg>")[0]
    assert "<!-- time (s) -->" in curves and "<!-- height -->" in curves  # without a unit, no brackets
    assert "<!-- cell 0.25, density 2 -->" in curves
    effects = page.split("<h2>Main effects</h2>")[1].split("</svg>")[0]
    assert "<!-- weight -->" in effects and "<!-- density (Mg/m3) -->" in effects
    assert "particlesInside" not in effects and "<th>particlesInside</th>" in page


def fallWithForce(a):
    """The same, with a curve that depends on the density, and one that does not."""
    scene = fall(a)
    scene.engines[-1].columns["weight"] = "9.81 * scene['block'].mass.sum()"
    scene.engines[-1].columns["solid"] = "scene['block'].initialVolume.sum()"
    return scene


def test_a_curve_that_is_the_same_in_all_cases_is_left_out_where_others_differ(tmp_path):
    axes = {"density": [1.0, 2.0], "cell": [0.5]}
    mpm.study.run(fallWithForce, axes, found, until=0.05, out=tmp_path, quiet=True, jobs=1)
    page = (tmp_path / "report.html").read_text()
    assert "<h2>weight</h2>" in page and "<h2>solid</h2>" not in page
    assert "<h1>Study of fallWithForce</h1>" in page


def test_many_curves_are_coloured_by_each_parameter(tmp_path):
    axes = {"gravity": [5.0, 10.0, 15.0, 20.0], "perCell": [1, 2], "end": ["well", "sleeps"]}
    study = Study(SCENE, axes, tmp_path)
    for folder, case in zip(study.folders, study.cases):
        saveCurve(
            folder, "load", {"depth (m)": np.arange(3.0), "load (kN)": case["gravity"] * np.arange(3.0)}
        )
        saveJson(f"{folder}/summary.json", {"load": case["gravity"]})
        state.write(folder, state.DONE, seconds=1.0)
    study.write()
    picture = (tmp_path / "report.html").read_text().split("<h2>load</h2>")[1].split("</svg>")[0]
    texts = re.findall(r"<!-- (.*?) -->", picture)
    assert [
        t for t in ("gravity (m/s2)", "perCell", "end", "5", "20", "1", "well", "sleeps") if t not in texts
    ] == []
    values = {"gravity": [case["gravity"] for case in study.cases]}
    curves = {str(k): (("x", "y"), np.zeros((2, 2))) for k in range(16)}
    colours = re.findall(r"stroke: (#\w+); stroke-width: 0.9", pictures.curves(curves, values))
    assert [len(set(colours[k : k + 4])) for k in range(0, 16, 4)] == [1] * 4 and len(set(colours)) == 4


def test_the_report_stands_alone_and_its_links_lead_somewhere(out):
    page = (out / "report.html").read_text()
    assert "<script" not in page and not re.search(r'(src|href)="https?:', page)
    links = set(re.findall(r'(?:src|href)="(?!data:)([^"#]+)"', page))
    assert len(links) > 20 and all((out / link).exists() for link in links)


HEADLINE = Path(__file__).parents[3] / "doc" / "_site" / "headline.html"


def test_the_report_of_the_headline_is_shipped_with_its_findings():
    page, findings = HEADLINE.read_text(), HEADLINE.parents[2] / "scripts" / "studies" / "headline.txt"
    for paragraph in findings.read_text().strip().split("\n\n"):
        assert f"<p>{paragraph}</p>" in page
    assert page.count('<tr class="done">') == 24 and page.count("<svg") == 5
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)  # of files that are not there


def test_findings_of_a_file_are_in_the_report(out, tmp_path, capsys):
    (tmp_path / "f.txt").write_text("It falls.")
    words = ["gravity=5,10,15", "perCell=1,2", "end=well,sleeps", "--report", "--out", str(out)]
    kept = (out / report.FINDINGS).read_text()
    with pytest.raises(SystemExit):  # not all cases have ended well
        main([str(SCENE), *words, "--findings", str(tmp_path / "f.txt")])
    assert "<p>It falls.</p>" in (out / "report.html").read_text()
    (out / report.FINDINGS).write_text(kept)
    with pytest.raises(FileNotFoundError, match="--findings none.txt: there is no such file"):
        main([str(SCENE), *words, "--findings", "none.txt"])


def test_indices_of_the_made_up_results_are_in_it(out):
    """load = gravity * perCell on a grid of which two cases lack: gravity explains most."""
    page = (out / "report.html").read_text()
    row = re.search(r'<td class="t">load</td>(.*?)</tr>', page)[1]
    gravity, perCell, end, _ = (float(v) for v in re.findall(r"<td>([\d.]+)</td>", row))
    assert gravity > 2 * perCell > 0.3 and end < 0.1


def test_a_result_that_is_not_there_is_refused(out):
    axes = {"gravity": [5.0, 10.0, 15.0], "perCell": [1, 2], "end": ["well", "sleeps"]}
    with pytest.raises(ValueError, match="there is no result lode; there are load, steps"):
        Study(SCENE, axes, out, show=["lode"]).write()


def test_the_table_is_written_in_columns_where_that_is_possible(out):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed: scripts/setup --study")
    pytest.importorskip("pyarrow", reason="pyarrow, which writes Parquet, is not installed")
    frame = pandas.read_parquet(out / "results.parquet")
    assert list(frame["state"]).count(state.DONE) == 10 and collect.ABOUT[0] in frame


@pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")
@pytest.mark.parametrize("width", [PHONE, 1280])
def test_a_browser_shows_it_without_sideways_scrolling(out, width, tmp_path):
    """A frame as wide as a phone measures the page: only boxes that scroll by themselves may be wider."""
    probe = tmp_path / "probe.html"
    script = "const d=f.contentDocument;document.title=[d.documentElement.scrollWidth,"
    script += "d.querySelectorAll('svg').length,[...d.images].every(i=>i.naturalWidth>0)].join(' ')"
    probe.write_text(
        f'<iframe id="f" src="file://{out}/report.html" style="width:{width}px;height:90000px;border:0" '
        f'onload="setTimeout(()=>{{{script}}},300)"></iframe>'
    )
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"]
    command += [
        f"--user-data-dir={tmp_path}/profile",
        "--virtual-time-budget=5000",
        "--dump-dom",
        f"file://{probe}",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert "<title>" in done.stdout, done.stderr[-2000:]
    scroll, drawings, images = re.search(r"<title>(.*?)</title>", done.stdout)[1].split()
    assert int(scroll) <= width and int(drawings) >= 3 and images == "true"


def test_names_that_cases_bring_are_text_in_the_report(tmp_path):
    evil = "<img src=x onerror=alert(1)>"

    def build(a):
        return None

    study = Study(build, {evil: [1.0, 2.0]}, tmp_path)
    for number, folder in enumerate(study.folders):
        x = np.linspace(0, 1, 3)
        saveCurve(folder, evil, {f"x {evil}": x, f"y {evil}": x})
        saveJson(f"{folder}/summary.json", {f"y {evil}": number + 0.5, "why": evil})
        Path(folder, f'"{evil}.png').write_bytes(b"")
        state.write(folder, state.DONE, message=evil, seconds=1.0)
    state.write(study.folders[1], state.FAILED, message=evil)
    study.write()
    page = (tmp_path / "report.html").read_text()
    assert "<img src=x" not in page and page.count("&lt;img src=x") > 5
    assert "%22%3Cimg%20src%3Dx" in page and '""' not in re.sub(r'=""', "", page)
