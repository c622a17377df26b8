# SPDX-License-Identifier: GPL-2.0-or-later
"""A sheet of finite width in 3D (scripts/sheet_pile_3d.py) against the same section in plane strain."""

import pytest
from asModules import script


@pytest.fixture(scope="module")
def scene():
    return script("sheet_pile_3d")


def test_a_coarse_sheet_feels_more_per_width_than_in_plane_strain(scene, tmp_path, recwarn):
    """Half of a symmetric sheet that is thinner than a cell cannot bend: no warning."""
    summary = scene.run(scene.arguments(["--smoke", "--threads", "1", "--out", str(tmp_path)]))[0]
    # 1.76e-3 s: a bonded implicit body leaves 0.55 of the soil's 3.2e-3 s; steel by itself has 1e-4 s.
    assert summary["bodies"]["sheet"]["type"] == "UGIMP" and summary["dt"] > 1.5e-3
    assert summary["resistance"]["0.5"] == pytest.approx(2270, rel=0.05)
    assert summary["ratio"]["0.5"] == pytest.approx(1.48, abs=0.1)
    assert {f.name for f in tmp_path.iterdir()} == {"sheet_pile_3d.png", "summary.json"}
    assert [str(w.message) for w in recwarn] == []


@pytest.mark.slow
def test_a_wider_sheet_comes_closer_to_plane_strain(scene, tmp_path):
    """What its ends add is a force of their own: the difference to plane strain falls with the width."""
    words = ["--cell", "0.5", "--penetration", "0.5", "--rate", "0.2", "--out", str(tmp_path)]
    ratios = [scene.run(scene.arguments([*words, "--width", w]))[0]["ratio"]["0.5"] for w in "248"]
    more = [ratio - 1 for ratio in ratios]
    assert more[0] > 1.4 * more[1] > 1.4 * 1.4 * more[2] > 0


def test_a_width_of_an_odd_number_of_cells_is_refused(scene, capsys):
    with pytest.raises(SystemExit):
        scene.arguments(["--width", "1.25"])
    assert "--width 1.25 with --cell 0.25 is not allowed; give an even number" in capsys.readouterr().err
