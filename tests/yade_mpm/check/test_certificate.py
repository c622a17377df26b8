# SPDX-License-Identifier: GPL-2.0-or-later
"""The verdict on whether a run is quasi-static, by hand-made histories and by runs.

Hand-made: an elastic bar of stiffness k and mass m, pressed at the rate v: E_kin = m v^2/6, W = k (v t)^2/2;
the other ratios are given numbers. Runs: a block pressed slowly and suddenly; the sheet pile at 2 m/s.
Controls: each ratio just within and just beyond its limit; the same block, fast.
"""

import json

import numpy as np
import pytest
import yade_mpm as mpm
from historiesOfBars import MASS, STIFFNESS, bar
from yade_mpm.diagnostics import certificate


def verdict(found):
    """The first line of a printed check."""
    return str(found).splitlines()[0]


def test_ratios_of_the_pressed_bar_are_those_of_the_closed_form():
    found = mpm.quasiStatic(bar(0.1))
    assert found.after == pytest.approx(1.0)  # a tenth of 10 s: pressed by 0.1 m
    assert found.kineticRatio == pytest.approx(MASS * 0.01 / 6 / (STIFFNESS * 0.01 / 2), rel=1e-12)
    assert found.energyError == pytest.approx(0.002, rel=1e-12)
    assert found.dampedRatio == pytest.approx(0.01, rel=1e-12)
    assert found.unbalancedRatio == pytest.approx(0.02, abs=2e-4)  # 46 of 91 rows have 0.03
    assert found.isQuasiStatic and found.reasons == [] and found.rateSensitivity is None


def test_the_kinetic_energy_decides_by_the_square_of_the_rate():
    critical = np.sqrt(0.05 * STIFFNESS * 0.01 / 2 * 6 / MASS)  # 5 % at 0.1 m
    assert mpm.quasiStatic(bar(0.999 * critical)).isQuasiStatic
    refused = mpm.quasiStatic(bar(np.sqrt(2.4) * critical))
    assert not refused.isQuasiStatic and refused.kineticRatio == pytest.approx(0.12)
    assert verdict(refused) == "NOT quasi-static: kinetic energy is 12 % of the work done (limit 5 %)"
    assert mpm.quasiStatic(bar(0.999 * critical), after=0).reasons  # nothing is done at the start
    assert mpm.quasiStatic(bar(np.sqrt(2.4) * critical), limits={"kineticRatio": 0.13}).isQuasiStatic


@pytest.mark.parametrize(
    "name, column, words",
    [
        ("kineticRatio", "kineticEnergy", "kinetic energy is"),
        ("energyError", "energyError", "the energy balance is open by"),
        ("dampedRatio", "dampedEnergy", "damping took"),
        ("unbalancedRatio", "unbalancedRatio", "the mean out-of-balance force"),
    ],
)
def test_each_ratio_is_judged_by_its_limit(name, column, words):
    limit = certificate.LIMITS[name]
    for factor, sign in ((0.999, 1), (1.001, 1), (1.001, -1) if name == "energyError" else (1.001, 1)):
        scale = 1.0 if name == "unbalancedRatio" else bar(0.01)["workDone"]
        found = mpm.quasiStatic(bar(0.01, **{column: sign * factor * limit * scale * np.ones(101)}))
        assert getattr(found, name) == pytest.approx(factor * limit, rel=1e-12)
        assert found.isQuasiStatic == (factor < 1)
        assert [words in reason for reason in found.reasons] == [True] * (factor > 1)
        if name in ("energyError", "dampedRatio") and factor > 1:
            assert ": " in found.reasons[0], "what to do"


@pytest.mark.parametrize("factor", [0.5, 0.999, 1.001, 2.0])
def test_motion_that_the_grid_does_not_see_is_judged_by_its_limit(factor):
    history = bar(0.01)
    assert mpm.quasiStatic(history).unseenRatio is None, "of an older history"
    history["unseenEnergy"] = factor * 0.01 * history["workDone"]
    found = mpm.quasiStatic(history)
    assert found.unseenRatio == pytest.approx(factor * 0.01, rel=1e-12)
    assert found.isQuasiStatic == (factor < 1)
    assert [reason.startswith("particles swing, unseen by the grid, with") for reason in found.reasons] == [
        True
    ] * (factor > 1)


def test_what_damping_carries_for_a_while_is_seen():
    """0.9 % of the work in all, and a fifth of the load while the bar goes from 0.6 to 0.7 m."""
    held = bar(0.1)
    work = held["workDone"]
    held["dampedEnergy"] = 0.2 * (np.clip(work, work[60], work[64]) - work[60])
    found = mpm.quasiStatic(held)
    assert found.dampedRatio == pytest.approx(0.2 * (work[64] - work[60]) / work[-1], rel=1e-12)
    assert found.dampedRatio < 0.05 and 0.08 < found.dampedShare < 0.2
    held["dampedEnergy"] = 0.2 * (np.clip(work, work[60], work[80]) - work[60])
    told = verdict(mpm.quasiStatic(held, limits={"dampedRatio": 0.1}))
    assert told == "NOT quasi-static: damping carried up to 20 % of the load (limit 10 %)"


def test_what_damping_carries_is_a_part_of_what_presses_not_of_the_weight():
    held = bar(0.1)
    held["push.work"] = held["workDone"]
    held["dampedEnergy"] = 0.12 * held["push.work"]
    held["workDone"] = 3 * held["push.work"]  # two thirds by what sinks
    found = mpm.quasiStatic(held)
    assert found.dampedRatio == pytest.approx(0.04, rel=1e-9)
    assert found.dampedShare == pytest.approx(0.12, rel=1e-9)
    assert verdict(found) == "NOT quasi-static: damping carried up to 12 % of the load (limit 10 %)"
    del held["push.work"]
    assert mpm.quasiStatic(held).dampedShare == pytest.approx(0.04, rel=1e-9)  # control


@pytest.mark.parametrize("share", [0.025, 0.0499, 0.0501, 0.1])
def test_what_of_the_load_accelerates_the_soil_for_a_while_is_seen(share):
    """In one of the tenths of the last 9 s, from 6.4 to 7.3 s; in all it is less than 1 % of the work."""
    held = bar(0.1)
    assert mpm.quasiStatic(held).inertialShare is None, "nothing is prescribed"
    held["push.work"] = held["time"] * 5.0
    held["kineticEnergy"] = 0.01 + share * np.clip(held["push.work"] - 32, 0, 4.5)
    held["workDone"] = held["push.work"] + 1e3
    found = mpm.quasiStatic(held, limits={"dampedRatio": 1, "dampedShare": 10, "energyError": 1})
    assert found.kineticRatio < 0.01
    assert found.inertialShare == pytest.approx(share, rel=1e-6)
    assert found.isQuasiStatic == (share < 0.05)
    assert [r.startswith("up to ") and "load more slowly" in r for r in found.reasons] == [True] * (
        share > 0.05
    )
    held["kineticEnergy"] = 1 - held["kineticEnergy"]  # what slows down carries too little
    assert mpm.quasiStatic(held).inertialShare == pytest.approx(share, rel=1e-6)


def test_inertia_of_what_a_drive_carries_along_is_no_load():
    held = bar(0.1)
    held["workDone"] = 100.0 + held["time"]
    held["freeKineticEnergy"] = held["kineticEnergy"].copy()
    carried = 0.5 * held["time"] / 10
    held["kineticEnergy"] = held["freeKineticEnergy"] + carried
    held["push.work"] = held["time"] + carried
    assert mpm.quasiStatic(held).inertialShare == pytest.approx(0, abs=1e-9)
    del held["freeKineticEnergy"]
    assert mpm.quasiStatic(held).inertialShare == pytest.approx(0.05 / 1.05, rel=1e-6)  # control


def stairs(jump, period=1.0, only=None, cells=6.0, turns=False):
    """The pressed bar, driven over rows of cells by a load of 1 that rises by 0.02 a cell, and by `jump`
    within an eighth of a cell where a period ends, or at one place only; every other one down if it turns."""
    held = bar(0.01)
    path = np.linspace(0.0, cells, 1201)
    places = np.arange(period, cells, period) if only is None else [only]
    signs = (-1.0 if turns else 1.0) ** np.arange(len(places))
    steps = (sign * np.clip(8 * (path - at) + 0.5, 0, 1) for sign, at in zip(signs, places))
    load = 1 + 0.02 * path + jump * sum(steps)
    work = np.r_[0, np.cumsum((load[1:] + load[:-1]) / 2 * np.diff(path))]
    at = np.linspace(0, cells, 101)
    pushed = np.interp(at, path, work)
    return {**held, "push.rowsCrossed": 3 + at, "push.work": pushed, "dampedEnergy": 0.01 * pushed}


def test_a_load_that_jumps_at_every_row_of_cells_is_seen():
    assert mpm.quasiStatic(bar(0.01)).loadJump is None
    assert mpm.quasiStatic(stairs(0)).loadJump == pytest.approx(0, abs=1e-3)
    for share in (0.05, 0.2):  # half and twice the limit, of the load before the rows 2 to 5
        found = mpm.quasiStatic(stairs(1.07 * share / (1 - 2.5 * share)))
        assert found.loadJump == pytest.approx(share, rel=0.1)
        assert found.isQuasiStatic == (share < 0.1)
    assert "crosses a row of cells (limit 10 %): take smaller cells" in str(found)
    assert "smaller cells" not in str(mpm.quasiStatic(stairs(0.01)))
    assert mpm.quasiStatic(stairs(0.2, period=0.7)).isQuasiStatic  # control: not the period of the cells
    assert mpm.quasiStatic(stairs(0.3, only=4.0)).isQuasiStatic  # control: a layer


@pytest.mark.parametrize("share", [0.05, 0.2])  # half and twice the limit
def test_jumps_up_and_down_do_not_hide_each_other(share):
    found = mpm.quasiStatic(stairs(1.07 * share / (1 - share / 2), turns=True))
    assert found.loadJump == pytest.approx(share, rel=0.1)
    assert found.isQuasiStatic == (share < 0.1)


@pytest.mark.parametrize("cells", [0.9, 1.1, 1.2])
def test_a_path_too_short_to_judge_jumps_is_told(cells):
    """It has to go on by 0.15 cells behind the row."""
    found = mpm.quasiStatic(stairs(0.05, cells=cells))
    isKnown = cells == 1.2
    assert (found.loadJump is not None) == isKnown and found.isQuasiStatic
    needs = "  loadJump        not judged, needs a path of 0.5 cells before a row of nodes and 0.15 behind it"
    assert (needs in str(found)) == (not isKnown)
    assert verdict(found).startswith(f"quasi-static: every ratio {'' if isKnown else 'that is judged '}is")
    assert ("loadJump" in found.asDict()["notJudged"]) == (not isKnown)
    assert "loadJump" not in str(mpm.quasiStatic(bar(0.01)))  # control: no drive


def test_a_drive_that_stands_or_goes_back_crosses_no_row():
    held = stairs(0.2)
    whole = mpm.quasiStatic(held).loadJump
    held["push.rowsCrossed"][40:50] = np.nan
    assert mpm.quasiStatic(held).loadJump == pytest.approx(whole, rel=0.2)
    held["push.rowsCrossed"] = held["push.rowsCrossed"][::-1].copy()
    assert mpm.quasiStatic(held).loadJump is None


def test_a_peak_after_the_start_is_seen():
    peak = bar(0.1)
    peak["kineticEnergy"][60] += 0.06 * peak["workDone"][60]
    assert not mpm.quasiStatic(peak).isQuasiStatic
    early = bar(0.1)
    early["kineticEnergy"][5] *= 1000
    assert mpm.quasiStatic(early).isQuasiStatic


def test_the_rate_is_judged_only_if_it_was_looked_at():
    assert mpm.quasiStatic(bar(0.1), rateSensitivity=0.049).isQuasiStatic
    refused = mpm.quasiStatic(bar(0.1), rateSensitivity=0.051)
    assert verdict(refused) == "NOT quasi-static: another rate changes the result by 5.1 % (limit 5 %)"
    assert "rateSensitivity" in str(mpm.quasiStatic(bar(0.1), rateSensitivity=0.01))
    assert "rateSensitivity" not in str(mpm.quasiStatic(bar(0.1)))


def test_a_quasi_static_check_is_a_small_table():
    unknown = np.full(101, np.nan)
    found = mpm.quasiStatic(bar(0.1, kineticEnergy=unknown), rateSensitivity=0.2)
    first, second, heads, *rows = str(found).splitlines()
    assert first.startswith("NOT quasi-static: kineticRatio is not known")
    assert second == "NOT quasi-static: another rate changes the result by 20 % (limit 5 %)"
    assert heads.split() == ["found", "limit"]
    names = [name for name in found.limits if getattr(found, name) is not None]
    assert [row.split()[0] for row in rows] == names
    assert [row.split()[0] for row in rows if "NOT met" in row] == ["kineticRatio", "rateSensitivity"]
    assert "20 %" in rows[-1] and "5 %" in rows[-1] and "not known" in rows[0]
    assert max(map(len, str(mpm.quasiStatic(bar(0.1))).splitlines())) < 80
    assert repr(found) == str(found)


@pytest.mark.parametrize(
    "changed, name",
    [
        ({"unbalancedRatio": np.full(101, np.nan)}, "unbalancedRatio"),
        ({"kineticEnergy": np.full(101, np.nan)}, "kineticRatio"),
        ({"workDone": np.zeros(101)}, "kineticRatio"),
    ],
)
def test_what_is_not_known_is_refused(changed, name):
    found = mpm.quasiStatic(bar(0.1, **changed))
    assert not found.isQuasiStatic and f"{name} is not known" in str(found)
    assert json.loads(json.dumps(found.asDict(), allow_nan=False))[name] is None


def test_the_quasi_static_check_is_written_as_plain_numbers():
    plain = json.loads(json.dumps(mpm.quasiStatic(bar(0.1), rateSensitivity=0.2).asDict(), allow_nan=False))
    assert plain["isQuasiStatic"] is False
    assert plain["limits"] == certificate.LIMITS
    assert len(plain["reasons"]) == 1
    assert plain["rateSensitivity"] == 0.2 and plain["kineticRatio"] == pytest.approx(0.01)


@pytest.mark.parametrize(
    "arguments, text",
    [
        (dict(after=20.0), "the history has no rows from after = 20 s on, it ends at 10 s"),
        (dict(rateSensitivity=-0.1), "rateSensitivity = -0.1 is not allowed; give zero or a positive number"),
        (dict(limits={"kinetic": 0.1}), "there is no limit 'kinetic'; limits: kineticRatio, unbalancedRatio"),
        (
            dict(limits={"kineticRatio": 0}),
            r"limits\['kineticRatio'\] = 0 is not allowed; give a positive number",
        ),
    ],
)
def test_wrong_arguments_are_refused(arguments, text):
    with pytest.raises(ValueError, match=text):
        mpm.quasiStatic(bar(0.1), **arguments)


def test_a_history_without_rows_is_refused():
    with pytest.raises(ValueError, match="the history has no rows; put a History with a shorter period"):
        mpm.quasiStatic({"time": []})
