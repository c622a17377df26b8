# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/levee.py: factors of safety as the water table rises and is drawn down, beside Bishop's."""

import importlib
import sys

import numpy as np
import pytest
import yade_mpm as mpm


@pytest.fixture(scope="module")
def levee():
    return importlib.import_module("levee")


def without(x, y):
    return np.zeros_like(x)


def test_bishops_factor_is_the_published_one(levee, monkeypatch):
    """The slope of Griffiths & Lane 1999 without water: 1.38 by the charts of Bishop & Morgenstern."""
    given = dict(HEIGHT=10.0, TOE=(-20.0, 32.0), CREST=(0.0, 12.0))
    given |= dict(DENSITY=20 / 9.81, COHESION=10.0, PHI=20.0)
    for name, value in given.items():
        monkeypatch.setattr(levee, name, value)
    assert levee.bishop(without, [(-20, 0), (32, 0)])[0] == pytest.approx(1.38, rel=0.02)


@pytest.mark.verifies(
    "factor of safety of a levee with a water table", reference="Bishop 1955, same pressures", tolerance=0.09
)
@pytest.mark.parametrize("stage", ["river low", "flood", "drawn down"])
def test_the_levee_is_as_safe_as_bishop_says(levee, stage, verified):
    a, table = levee.PARAMETERS.parse(["--cell", "0.5", "--within", "0.04"]), levee.STAGES[stage]
    _, stands = levee.trial(lambda: levee.build(a, table), 0.7)
    bishop = levee.bishop(levee.pressureIn(stands), table)[0]
    found = mpm.safety(lambda: levee.build(a, table), (bishop - 0.2, bishop + 0.2), a.within, progress=False)
    verified(found.factor, bishop)
    dry = levee.bishop(without, [(0, 0), (levee.WIDTH, 0)])[0]
    assert found.factor == pytest.approx(dry, rel=0.05) if stage == "river low" else found.factor < 0.85 * dry


def test_it_draws_its_picture(levee, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["levee", "--smoke", "--out", str(tmp_path)])
    levee.main()
    assert (tmp_path / "levee.png").exists()
