# SPDX-License-Identifier: GPL-2.0-or-later
"""The manual as a site: Sphinx builds it without a warning, and it has every page and every public name."""

import inspect
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yade_mpm

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "doc"))
import docstrings  # noqa: E402
import verificationPictures  # noqa: E402

PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "doc").rglob("*.md"))]


def sphinx(out, notebooks, *options):
    """Runs Sphinx as scripts/docs does; returns the finished process."""
    pytest.importorskip("sphinx", reason="no Sphinx here; scripts/test installs it")
    pytest.importorskip("myst_nb", reason="no MyST-NB here; scripts/test installs it")
    path = [str(Path(yade_mpm.__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "MPM_NOTEBOOKS": notebooks, "PYTHONPATH": os.pathsep.join(path)}
    command = [sys.executable, "-m", "sphinx", "-c", "doc", "-b", "html", "-W", "--keep-going", "-q"]
    return subprocess.run(
        [*command, *options, ".", str(out)], cwd=ROOT, env=environment, capture_output=True, text=True
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    out = tmp_path_factory.mktemp("site")
    done = sphinx(out, "off")
    assert done.returncode == 0, done.stderr[-6000:]
    return out


def test_the_site_builds_without_a_warning(site):
    assert "url=doc/index.html" in (site / "index.html").read_text()
    assert (site / "doc" / "index.html").exists()


def test_every_page_of_the_manual_is_in_the_site(site):
    built = {str(page.relative_to(site).with_suffix(".md")) for page in site.rglob("*.html")}
    assert {str(page.relative_to(ROOT)) for page in PAGES} - built == set()


MODULES = ("yade_mpm", *(f"yade_mpm.{name}" for name in ("diagnostics", "plot", "rigid", "geotech.surface")))
PUBLIC = {name: thing for module in MODULES for name, thing in docstrings.publicNames(module)}

IN_YADE = [name for name, _ in docstrings.publicNames("yade_mpm.yade")]


def test_the_reference_has_every_public_name(site):
    text = "".join(page.read_text() for page in (site / "doc" / "reference" / "api").glob("*.html"))
    missing = [name for name in (*PUBLIC, *IN_YADE) if f'id="{name}"' not in text]
    assert missing == [], "give them a directive on a page of doc/reference/api"


LOADED = re.compile(r"""<(?:script|link|img)\b[^>]*?\b(?:src|href)=["']([^"']+)""")


def test_pages_load_nothing_from_elsewhere(site):
    """No network: scripts, styles and pictures lie in the site, MathJax for the formulas, too."""
    isWithFormulas = []
    for page in site.rglob("*.html"):
        text = page.read_text()
        files = [name.split("?")[0] for name in LOADED.findall(text) if not name.startswith(("data:", "#"))]
        assert [name for name in files if not (page.parent / name).exists()] == [], page
        if 'class="math' in text:
            isWithFormulas.append(page.stem)
            assert "tex-svg.js" in {Path(name).name for name in files}, page
    assert {"method", "water"} <= set(isWithFormulas)


PICTURES = {  # that the cells of a page draw
    "calibration": 1,
    "column": 1,
    "first-scene": 3,
    "footing": 2,
    "particle-types": 3,
    "pipe": 2,
    "sheet-pile": 3,
    "slope": 2,
    "study": 1,
    "tbar": 2,
    "verification": len(verificationPictures.PICTURES),
    "wall": 2,
}
OF_A_CELL = re.compile(r'src="([./]*_images/[0-9a-f]{64}\.png)"')


@pytest.mark.slow
def test_the_notebooks_are_executed_and_show_every_picture(tmp_path):
    done = sphinx(tmp_path, "force")
    assert done.returncode == 0, done.stderr[-6000:]
    notebooks = {page for page in PAGES if "```{code-cell}" in page.read_text()}
    assert {page.stem for page in notebooks} == set(PICTURES)
    shown = {}
    for page in notebooks:
        built = tmp_path / page.relative_to(ROOT).with_suffix(".html")
        pictures = OF_A_CELL.findall(built.read_text())
        shown[page.stem] = sum((built.parent / name).exists() for name in pictures)
    assert shown == PICTURES
    shipped = {file.stem: json.loads(file.read_text()) for file in tmp_path.rglob("_downloads/**/*.ipynb")}
    assert set(shipped) == {page.stem for page in notebooks if page.parent.name == "tutorial"}
    for name, notebook in shipped.items():
        outputs = [o for cell in notebook["cells"] for o in cell.get("outputs", ())]
        assert sum("image/png" in o.get("data", ()) for o in outputs) == PICTURES[name], name


MADE_BY_THE_CODE = (yade_mpm.Body, yade_mpm.Region, yade_mpm.ResultFrame)
# What callers never give: the scene that a method belongs to, and what only the project's own code gives.
GIVEN_BY_THE_CODE = {"self", "scene", "attributes", "bar", "how", "state", "run"}


def unexplained(thing):
    """Parameters in the signature of a function, class or method that its docstring does not explain."""
    explained = docstrings.items(inspect.cleandoc(thing.__doc__ or ""))
    named = inspect.signature(thing).parameters
    return [name for name in named if name not in GIVEN_BY_THE_CODE and name not in explained]


@pytest.mark.parametrize("name", PUBLIC)
def test_docstrings_explain_every_parameter(name):
    thing = PUBLIC[name]
    assert thing.__doc__, f"{name} has no docstring"
    assert thing in MADE_BY_THE_CODE or unexplained(thing) == []
    for method in vars(thing).values() if inspect.isclass(thing) else ():
        if inspect.isfunction(method) and not method.__name__.startswith("_") and method.__doc__:
            isShort = docstrings.items(inspect.cleandoc(method.__doc__)) == []  # a sentence may name them
            assert isShort or unexplained(method) == [], f"{name}.{method.__name__}"


def test_control_a_parameter_that_is_not_explained_is_found():
    def push(force, direction):
        """Pushes.

        Parameters
        ----------
        force : kN.
        """

    assert unexplained(push) == ["direction"]


def test_pages_are_links():
    lines = docstrings.asNumpydoc(["A.", "", "Attributes", "----------", "low : m, see doc/howto/yade.md."])
    assert lines[-2:] == ["low", "    m, see :doc:`/doc/howto/yade`."]


@pytest.mark.parametrize("name", [n for n, thing in PUBLIC.items() if inspect.isclass(thing)])
def test_every_attribute_has_a_text_of_its_own(name):
    _, _, attributes = inspect.getdoc(PUBLIC[name]).partition("Attributes\n----------\n")
    assert not re.findall(r"^\w+, .* : .*$", attributes.partition("\n\n")[0], re.M)


SCENE = """
attach detach groundStress load report stage stages
add bodies cellSizeAt changes close constraints contact criticalTimeStep damping describe drive drives dt
dtSpeed engines faceNodes fix freeField gravity history initialStress lines maps nodePositions
nodesInside
particleCount pause plot prepare quasiStatic record remove roller run running save settle step steps
terrain threads tie time timing unbalancedForce viscous wait
"""


def test_the_reference_of_a_scene_has_what_scripts_use_and_no_internals(site):
    page = (site / "doc" / "reference" / "api" / "scene.html").read_text()
    assert set(re.findall(r'id="yade_mpm\.Scene\.(\w+)"', page)) == set(SCENE.split())
