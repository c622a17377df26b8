# SPDX-License-Identifier: GPL-2.0-or-later
"""The manual: its links lead somewhere, and the scene of the README runs as it stands."""
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "doc").rglob("*.md"))]


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


def test_every_picture_is_shown():
    shown = {(page.parent / name).resolve() for page in PAGES for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text())}
    assert set((ROOT / "doc" / "images").iterdir()) == shown


def test_the_scene_of_the_readme_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = re.search(r"## A scene to read\n\n```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)[1]
    short = re.sub(r"scene\.run\(until=40\).*", "scene.run(steps=3)", scene)
    assert short != scene
    names = {}
    exec(short, names)
    assert names["scene"].steps == 3 and (tmp_path / "sheet_pile.h5").exists()
    assert len(capsys.readouterr().out.split()) >= 3
    assert names["drive"].reaction[1] < 0
