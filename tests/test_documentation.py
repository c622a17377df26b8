# SPDX-License-Identifier: GPL-2.0-or-later
"""The manual: its links lead somewhere, and what it shows of code runs or compiles as it stands."""

import math
import re
import subprocess
from pathlib import Path

import pytest
import yade_mpm

ROOT = Path(__file__).parents[1]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "doc").rglob("*.md"))]


def anchors(page):
    """Names that GitHub gives to the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        name, _, anchor = link.partition("#")
        if not name.startswith("http"):
            target = page.parent / name if name else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_that_a_page_names_are_there(page):
    """Pages on adding a class may name a file to be written."""
    named = re.findall(r"`((?:tests|pkg|py|scripts|doc)/[\w./-]+)`", page.read_text())
    toBeWritten = "pkg/" if page.stem.startswith("adding") else None
    missing = [name for name in named if not (ROOT / name).exists()]
    assert [name for name in missing if not (toBeWritten and name.startswith(toBeWritten))] == []


# Abbreviations of the method, which no reader needs to know.
ABBREVIATIONS = "APDI uGIMP MCDP MUSL USF USL FLIP F-bar CPDI hourglass"
ABBREVIATION = re.compile(rf"(?<![\w-])({ABBREVIATIONS.replace(' ', '|')})(?![\w-])")
READ_BY_USERS = [
    page
    for folder in ("tutorial", "howto", "explanation")
    for page in sorted((ROOT / "doc" / folder).glob("*.md"))
] + [ROOT / "README.md"]


def firstWord(text):
    """Place of the first abbreviation of a page outside of code, formulas, pictures and headings; or None."""
    hidden = r"^---\n.*?^---$|^```.*?^```|`[^`]*`|\$[^$]*\$|!\[[^]]*\]\([^)]*\)|^#.*?$|^    .*?$"
    bare = re.sub(hidden, lambda found: " " * len(found[0]), text, flags=re.M | re.S)
    found = ABBREVIATION.search(bare)
    return found and found.start()


@pytest.mark.parametrize("page", READ_BY_USERS, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_first_abbreviation_of_a_page_leads_to_the_glossary(page):
    text = page.read_text()
    place = firstWord(text)
    if place is not None:
        end = text.find("\n\n", place)  # of the paragraph
        assert "notation.md#glossary)" in text[:end], text[place : place + 80]


def test_every_abbreviation_is_in_the_glossary():
    glossary = (ROOT / "doc" / "reference" / "notation.md").read_text().split("## Glossary")[1]
    explained = " ".join(re.findall(r"^\| ([^|]+) \|", glossary, re.M))
    assert [word for word in ABBREVIATIONS.split() if word not in explained] == []


EXPLAINED = [
    page
    for page in sorted((ROOT / "doc" / "explanation").glob("*.md"))
    if page.stem not in ("index", "verification")
]


def numbersPer100Words(text):
    """Of the sentences of a page: without tables, code, formulas, places of links and references."""
    hidden = r"^```.*?^```|\$\$.*?\$\$|\$[^$]*\$|`[^`]*`|^\|.*?$|\]\([^)]*\)|^## References.*"
    words = re.sub(hidden, " x ", text, flags=re.M | re.S).split()
    return 100 * sum(word.strip("-−+(*,.;:")[:1].isdigit() for word in words) / len(words)


@pytest.mark.parametrize("page", EXPLAINED, ids=lambda page: page.stem)
def test_sentences_of_explanation_have_few_numbers(page):
    """At most five in a hundred words; more belong into a table."""
    assert numbersPer100Words(page.read_text()) <= 5


def test_control_many_numbers_are_found():
    assert numbersPer100Words("It is 3 % off at 0.25 m and 5 % at 0.5 m. | 1 | 2 |\n| 7 | 8 | 9 |\n") > 5


def test_equations_have_one_number_and_references_lead_to_one():
    tags = []
    for page in sorted((ROOT / "doc" / "theory").glob("*.md")):
        chapter, here = (
            re.match(r"# (\d*)", page.read_text())[1],
            re.findall(r"\\tag\{(.*?)\}", page.read_text()),
        )
        assert here == [f"{chapter}.{n}" for n in range(1, len(here) + 1)], page.stem
        tags += here
        tagged = [f for f in re.findall(r"\$\$(.*?)\$\$", page.read_text(), re.S) if "\\tag" in f]
        assert [f for f in tagged if "\\\\" in f] == [], (
            "Sphinx puts lines of a formula into split, which has no tag"
        )
    named = [
        number
        for page in PAGES
        for cited in re.findall(r"equations?((?:\s+(?:to|and)?\s*\(\d+\.\d+\))+)", page.read_text())
        for number in re.findall(r"\d+\.\d+", cited)
    ]
    assert len(tags) > 50 and len(named) > 10
    assert set(named) - set(tags) == set()


def test_every_picture_is_shown():
    shown = {
        (page.parent / name).resolve()
        for page in PAGES
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text())
    }
    assert set((ROOT / "doc" / "images").iterdir()) == shown


def test_the_scene_of_the_readme_runs(tmp_path, capsys):
    scene = re.search(r"## A scene to read\n\n```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)[1]
    short = scene.replace("scene.run(until=40)", "scene.run(steps=3)")
    assert short != scene
    names = {}
    exec(short, names)
    assert names["scene"].steps == 3 and (tmp_path / "pile.vtkhdf").exists()
    assert len(capsys.readouterr().out.split()) >= 3
    assert names["press"].reaction[1] != 0


def test_the_recipes_run_one_after_the_other(tmp_path):
    """What each recipe is about, besides that it runs."""
    names, seen = {}, []
    for text in re.findall(r"```python\n(.*?)```", (ROOT / "doc" / "howto" / "recipes.md").read_text(), re.S):
        exec(text, names)
        seen.append({k: names.get(k) for k in ("scene", "error")})
    assert len(seen) == 3
    blast, column, going = seen
    assert {f.name for f in tmp_path.iterdir()} >= {"column.vtk", "half.h5"}
    assert blast["scene"]["block"].stress[:, 1, 1].mean() < -40  # half of the time: 50 kPa
    assert abs(column["error"]).max() < 0.01 * 2.0 * 9.81 * 2.5
    assert going["scene"].steps == column["scene"].steps + 100  # the first hundred went into both


def test_the_engine_in_python_slows_the_block_down(capsys):
    page = (ROOT / "doc" / "development" / "adding-an-engine.md").read_text()
    names = {}
    exec(re.search(r"```python\n(.*?)```", page, re.S)[1], names)
    exact = 2 * math.exp(-names["RATE"] * names["scene"].time)
    assert abs(names["block"].velocity[:, 0] - exact).max() < 1e-9 * exact
    assert f"velocity {exact:.6g}"[:14] == capsys.readouterr().out[:14]


CPP_FILES = [
    (page, (page.parent / name).read_text())
    for page in PAGES
    for name in re.findall(r"^```\{literalinclude\} (\S+\.cpp)", page.read_text(), re.M)
]


@pytest.mark.parametrize("page, text", CPP_FILES, ids=[page.stem for page, _ in CPP_FILES])
def test_whole_files_of_cpp_compile(page, text, tmp_path):
    """As the build would: its compiler, its Eigen. Warnings are errors."""
    cache = Path(yade_mpm.__file__).parents[2] / "CMakeCache.txt"
    if not cache.exists():
        pytest.skip("yade_mpm is not imported from a build folder, which would tell the compiler")
    told = dict(re.findall(r"^(\w+):\w+=(.*)$", cache.read_text(), re.M))
    eigen = Path(told["Eigen3_DIR"]).parents[2] / "include" / "eigen3"
    file = tmp_path / "Example.cpp"
    file.write_text(text)
    flags = ["-std=c++17", "-fopenmp", "-march=native", "-Wall", "-Wextra", "-Wno-psabi", "-Werror"]
    flags.append(f'-DMPM_VERSION="{yade_mpm.__version__}"')
    include = [f"-I{ROOT / 'pkg'}", "-isystem", eigen]
    command = [told["CMAKE_CXX_COMPILER"], "-fsyntax-only", *flags, *include, file]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:4000]


def test_pages_on_a_new_class_show_a_whole_file():
    assert [page.stem for page, text in CPP_FILES if text.startswith("// SPDX")] == [
        "adding-a-material",
        "adding-a-particle-type",
        "adding-an-engine",
    ]
