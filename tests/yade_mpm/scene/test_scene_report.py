# SPDX-License-Identifier: GPL-2.0-or-later
"""The report of a scene: what it has, and that a browser shows it."""

import re
import shutil
import subprocess

import pytest
import yade_mpm as mpm
from inputs import cases, emptyScene, refused
from yade_mpm import box

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
EVIL = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A wall that a force presses against soil, in two stages."""
    scene = mpm.Scene((0, 0), (3, 2.5), 0.25, threads=1, gravity=10, damping=0.5)
    scene.fix("bottom")
    scene.roller("left", "right")
    soil = mpm.MohrCoulomb(density=2.0, young=2e4, poisson=0.3, cohesion=5.0, frictionAngle=0.5)
    ground = scene.add("ground", box((0, 0), (1, 1.5)), soil, mpm.UGIMP())
    steel = mpm.LinearElastic(density=7.0, young=1e6, poisson=0.0)
    wall = scene.add("wall", box((1, 0), (1.5, 2)), steel, mpm.APDI(size=0.25), implicit=True)
    scene.contact(wall, ground, friction=0.2)
    scene.initialStress(surface=1.5, K0=0.5, gravity=10, bodies=[ground])
    scene.history(every=0.01)
    scene.attach(mpm.Spring(wall, (1.5, 1.75), (3, 1.75), stiffness=1e3, label="prop"))
    with scene.stage("gravity"):
        scene.run(until=0.05, progress=False)
    with scene.stage(EVIL) as stage:
        scene.run(until=0.1, progress=False)
        stage.note(moment=abs(mpm.sectionForces(wall).M).max())
    file = tmp_path_factory.mktemp("report") / "wall.html"
    scene.report(file, title="Wall & prop")
    return file


def test_it_has_scene_materials_stages_pictures_curves_and_a_verdict(page):
    text = page.read_text()
    for head in ("Scene", "Materials", "Stages", "Bodies", "Displacement", "Forces in &#x27;wall&#x27;"):
        assert f"<h2>{head}</h2>" in text
    assert "<h2>prop.force</h2>" in text and "<h2>Verdict</h2>" in text and "Wall &amp; prop" in text
    assert "cohesion = 5" in text and text.count("<img") == 4
    assert "http" not in re.sub(r"base64,[^\"]*", "", text)  # it stands alone
    assert EVIL not in text


@pytest.mark.parametrize("time, isAtRest", [(0.02, False), (3.0, True)])
def test_the_verdict_tells_whether_stages_end_at_rest(tmp_path, time, isAtRest):
    scene = mpm.Scene((0, 0), (1, 1.5), 0.25, threads=1, gravity=10, damping=0.5)
    scene.fix("bottom")
    scene.roller("left", "right")
    elastic = mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3)
    scene.add("ground", box((0, 0), (1, 1)), elastic, mpm.UGIMP())
    with scene.stage("gravity"):
        scene.run(until=time, progress=False)
    assert (scene.stages[0]["values"]["unbalanced"] < 0.05) == isAtRest
    scene.report(tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text()
    assert ("Every stage ends at rest" in text) == isAtRest
    assert ("NOT at rest at the end, unbalanced forces above 5 %: &#x27;gravity&#x27;" in text) != isAtRest


def test_a_stage_without_forces_is_not_called_moving(tmp_path):
    scene = mpm.Scene((0, 0), (1, 1.5), 0.25, threads=1)
    scene.add("ground", box((0, 0), (1, 1)), mpm.LinearElastic(density=2.0, young=1e4, poisson=0.3))
    with scene.stage("nothing"):
        pass
    assert "unbalanced" not in scene.stages[0]["values"]
    scene.report(tmp_path / "a.html")
    assert "at rest" not in (tmp_path / "a.html").read_text()


def test_one_picture_shows_several_stages(tmp_path):
    scene = mpm.Scene((0, 0), (2, 2), 0.25, threads=1)
    steel = mpm.LinearElastic(density=1.0, young=1e4, poisson=0.0)
    wall = scene.add("wall", box((0.5, 0), (1, 2)), steel, mpm.APDI(size=0.25))
    forces = mpm.sectionForces(wall)
    figure = mpm.plot.structure({"one": forces, "two": (forces, None)})
    assert len(figure.axes) == 3 and len(figure.axes[1].lines) == 3
    mpm.plot.save(figure, tmp_path / "wall.png")


@pytest.mark.skipif(BROWSER is None, reason="there is no browser")
@pytest.mark.parametrize("width", [412, 1200])
def test_a_browser_shows_it_without_sideways_scrolling(page, width, tmp_path):
    probe = tmp_path / "probe.html"
    script = "const d=f.contentDocument;document.title=[d.documentElement.scrollWidth,d.images.length,"
    script += "[...d.images].every(i=>i.naturalWidth>0)].join(' ')"
    probe.write_text(
        f'<iframe id="f" src="file://{page}" style="width:{width}px;height:9000px;border:0" '
        f'onload="setTimeout(()=>{{{script}}},300)"></iframe>'
    )
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"]
    command += [f"--user-data-dir={tmp_path}/profile", "--virtual-time-budget=5000", "--dump-dom"]
    done = subprocess.run([*command, f"file://{probe}"], capture_output=True, text=True, timeout=120)
    scroll, images, areDrawn = re.search(r"<title>(.*?)</title>", done.stdout)[1].split()
    assert int(scroll) <= width and int(images) == 4 and areDrawn == "true"


@cases(
    ("report: file = 'wall.pdf' ... .html", lambda: emptyScene().report("wall.pdf")),
    ("report: file", lambda: emptyScene().report(3), TypeError),
    ("structure: stages", lambda: mpm.plot.structure({}), TypeError),
)
def test_what_is_refused(named, make, kind):
    refused(named, make, kind)
