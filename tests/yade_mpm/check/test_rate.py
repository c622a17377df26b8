# SPDX-License-Identifier: GPL-2.0-or-later
"""The quasi-static check: what the rate does, and scenes that pass or fail."""

import json
import sys

import numpy as np
import pytest
import yade_mpm as mpm
from asModules import script
from historiesOfBars import bar
from setups import chain, soft
from yade_mpm import box, diagnostics


# --- another rate ----------------------------------------------------------------------------------------
def test_twice_the_rate_shows_what_the_rate_itself_does():
    """R = R0(x) (1 + c v^n): n = 1 gives the share of the rate itself over R, n = 2 three times as much."""
    x, other = np.linspace(0, 2, 201), np.linspace(0, 1.5, 77)
    static, slow = lambda x: 5 + 3 * x, 0.04
    for n, factor in ((1, 1), (2, 3)):
        twice = static(other) * (1 + slow * 2**n)
        found = mpm.rateSensitivity(x, static(x) * (1 + slow), other, twice)
        assert found == pytest.approx(factor * slow / (1 + slow), rel=1e-12)
    assert mpm.rateSensitivity(x, static(x), other, static(other)) < 1e-14
    with pytest.raises(ValueError, match="share no range of displacement; run the other one as far"):
        mpm.rateSensitivity(x, static(x), other + 5, static(other))


# --- runs ------------------------------------------------------------------------------------------------
def pressed(rate, ramp=0.0):
    """An elastic block of 1 m, pressed by 0.05 m."""
    scene = mpm.Scene((0, 0), (2, 2), 0.25, threads=1)
    block = scene.add("block", box((0.5, 0), (1.5, 1)), soft(2), mpm.APDI(size=0.25))
    drive = mpm.Drive(block.above(0.8), (None, -rate), ramp=ramp)
    end = 0.05 / rate + ramp / 2
    history = mpm.History(period=end / 100)
    scene.engines = [*chain(damping=0.05, gravity=(0, 0), fixed=("bottom",), drive=drive), history]
    scene.dt = min(1e-3, end / 400)
    scene.run(until=end, progress=False)
    return scene, history


def test_a_block_pressed_slowly_passes_and_pressed_fast_is_refused():
    _, history = pressed(0.02, ramp=0.5)
    slow = mpm.quasiStatic(history)
    assert slow.isQuasiStatic, str(slow)
    _, history = pressed(5.0)
    fast = mpm.quasiStatic(history)
    assert not fast.isQuasiStatic and fast.kineticRatio > 0.1 and fast.unbalancedRatio > 0.1
    assert str(fast).startswith("NOT quasi-static: kinetic energy is")


def test_the_history_measures_what_is_judged():
    scene, history = pressed(0.5)
    assert history["workDone"][-1] == diagnostics.workDone(scene) == abs(diagnostics.externalWork(scene)) > 0
    assert history["unbalancedRatio"][-1] == diagnostics.unbalancedRatio(scene) > 0
    found = mpm.quasiStatic(history)
    assert found.kineticRatio == pytest.approx(
        np.max(history["kineticRatio"][history["time"] >= found.after]), rel=1e-12
    )


def test_energy_that_a_drive_prescribes_is_not_kinetic():
    carried = 2.0  # kJ, 4 % of the work at the end, all of it at the start
    plain, heavy = bar(0.1), bar(0.1)
    heavy["freeKineticEnergy"] = heavy["kineticEnergy"]
    heavy["kineticEnergy"] = heavy["kineticEnergy"] + carried
    heavy["workDone"] = heavy["workDone"] + carried
    found, alone = mpm.quasiStatic(heavy), mpm.quasiStatic(plain)
    assert found.kineticRatio == pytest.approx(alone.kineticRatio, rel=1e-12)
    for name in ("energyError", "dampedRatio"):  # parts of all work
        assert 0.5 * getattr(alone, name) < getattr(found, name) < getattr(alone, name), name
    del heavy["freeKineticEnergy"]
    assert not mpm.quasiStatic(heavy).isQuasiStatic  # control


def pushedBy(inertia):
    """An elastic column of 2 m under a plate of that inertial scale, driven whole by 0.05 m at 0.05 m/s."""
    scene = mpm.Scene((0, 0), (1, 4), 0.25, threads=1)
    elastic = soft(2)
    scene.add("column", box((0, 0), (1, 2)), elastic, mpm.UGIMP(perCell=2))
    plate = scene.add("plate", box((0, 2), (1, 3)), elastic, mpm.UGIMP(perCell=2), inertiaScale=inertia)
    drive = mpm.Drive(plate, (0, -0.05), ramp=0.4)
    history = mpm.History(period=0.01)
    roller = ("left", "right")
    scene.engines = [
        *chain(damping=0.05, gravity=(0, 0), fixed="bottom", roller=roller, drive=drive),
        history,
    ]
    scene.dt = 1e-3
    scene.run(until=1.2, progress=False)
    return mpm.quasiStatic(history, after=0.6), history


def test_the_inertia_of_what_is_driven_does_not_decide():
    light, _ = pushedBy(1)
    heavy, history = pushedBy(1000)
    late = history["time"] >= 0.6
    assert (history["kineticEnergy"][late] / history["workDone"][late]).max() > 0.1  # control
    assert light.kineticRatio < 0.02 and heavy.kineticRatio < 0.02


@pytest.mark.parametrize("dim", [2, 3])
def test_the_unbalanced_ratio_is_the_sum_of_its_definition(dim):
    scene = mpm.Scene((0,) * dim, (2,) * dim, (0.5, 0.25, 0.5)[:dim], threads=1)
    body = scene.add("block", box((0.5,) * dim, (1.5,) * dim), soft(2), mpm.UGIMP(perCell=2))
    assert np.isnan(diagnostics.unbalancedRatio(scene))
    body.velocity = np.random.default_rng(1).normal(size=body.velocity.shape)
    scene.engines = chain(gravity=(0,) * (dim - 1) + (-9.81,))
    scene.dt = 1e-3
    scene.run(steps=1, progress=False)
    start = body.stress[:, :dim, :dim].copy()
    assert np.abs(start).max() > 0.1
    values = scene._core.nodalValues()
    inertia = (np.array(values["mass"]) * np.linalg.norm(values["acceleration"], axis=1)).sum()
    scale = (body.volume * np.sqrt((start**2).sum(axis=(1, 2)))).sum() / 0.25
    assert diagnostics.unbalancedRatio(scene) == pytest.approx(inertia / scale, rel=1e-12)
    body.stress[...] = 0
    assert diagnostics.unbalancedRatio(scene) == np.inf


def test_the_sheet_pile_states_that_it_is_not_quasi_static_at_2_metres_per_second(
    tmp_path, monkeypatch, capsys
):
    words = "sheet_pile_study --cell 1 --rate 2 --until 1.6 --threads 1 --rateCheck --dilatancyLimit 0.02"
    monkeypatch.setattr(sys, "argv", [*words.split(), "--out", str(tmp_path)])
    script("sheet_pile_study").main()
    assert "NOT quasi-static: kinetic energy is" in capsys.readouterr().out
    written = json.loads((tmp_path / "summary.json").read_text())["quasiStatic"]
    assert written["isQuasiStatic"] is False
    assert written["rateSensitivity"] > 0
    assert written["kineticRatio"] > 0.05


def test_a_footing_whose_load_jumps_with_the_grid_is_refused():
    """Half of a bonded footing of 2 m on 1.5 m of weak clay, pressed by 1.2 cells."""
    scene = mpm.Scene((0, 0), (4, 2.5), 0.25, threads=1)
    weak = dict(density=1.7, young=5e3, poisson=0.35, cohesion=20, frictionAngle=0, dilatancyAngle=0)
    clay = mpm.MohrCoulombDruckerPrager(**weak)
    concrete = mpm.LinearElastic(density=2.4, young=1e6, poisson=0.2)
    scene.add("clay", box((0, 0), (4, 1.5)), clay, mpm.UGIMP(perCell=2))
    footing = scene.add("footing", box((0, 1.5), (1, 2)), concrete, mpm.UGIMP(perCell=2), inertiaScale=10)
    scene.initialStress(surface=1.5, K0=0.8)
    push = mpm.Drive(footing, velocity=(0, -0.1), ramp=0.2, name="push")
    walls = dict(roller=("left", "right"), fixed="bottom")
    history = mpm.History(period=0.02)
    scene.engines = [*chain(gravity=(0, -9.81), damping=0.05, drive=push, **walls), history]
    scene.dt = 1.4e-3
    scene.run(until=3.0, progress=False)
    found = mpm.quasiStatic(history)
    assert history["push.rowsCrossed"][[0, -1]] == pytest.approx([4, 5.18], abs=0.05)
    assert 0.1 < found.loadJump < 0.25 and not found.isQuasiStatic
    assert mpm.quasiStatic(history, limits={"loadJump": 0.25}).isQuasiStatic, str(
        found
    )  # all else is in order


@pytest.mark.parametrize("kind", [mpm.UGIMP(), mpm.APDI(size=0.25)], ids=repr)
def test_rows_crossed_count_from_the_edge_behind_the_body(kind):
    scene = mpm.Scene((0, 0), (4, 4), 0.5, threads=1)
    elastic = soft(2)
    body = scene.add("block", box((1, 1.25), (2, 3)), elastic, kind)
    for velocity, rows in (((1, 0), 4), ((-1, 0), 6), ((0.1, 2), 6), ((None, -1), 5.5)):
        assert mpm.Drive(body, velocity).rowsCrossed == pytest.approx(rows)
    assert np.isnan(mpm.Drive(body, (0, None)).rowsCrossed)
