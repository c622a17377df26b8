# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes inside the real YADE. Each script below is run in a process of its own and reports through
`say(name, value)`."""

import sys

import pytest
import yade_mpm as mpm
from yadeProcess import needsYade

pytestmark = needsYade


@pytest.mark.parametrize("kind", ["stages", "chain"])
def test_the_same_bits_as_by_its_own_loop(same, kind):
    digest, time, yadeTime, labels, counts = same[kind]
    assert [digest, time] == same["own"] and yadeTime == time
    stages = [
        f"mpm_{name}"
        for name in ("ParticleToGrid", "GridSolver", "GridToParticle", "VelocityRemap", "DomainUpdater")
    ]
    assert labels == ["", *(stages if kind == "stages" else ["mpm"]), ""]  # before the NewtonIntegrator
    assert counts == [400] * len(counts)  # timed by YADE


def test_control_another_time_step_makes_other_bits(same):
    assert same["other dt"][0] != same["other dt"][1]


@pytest.mark.parametrize("kind, steps, ratio", [("mpm", 1200, 3), ("dem", 100, 1 / 4)])
def test_subcycling_keeps_the_clocks_together(same, kind, steps, ratio):
    taken, time, yadeTime, dt, maxDt, critical, own, applied, inTime = same[kind]
    assert taken == steps and time == yadeTime
    assert dt == maxDt == pytest.approx(0.8 * critical * ratio, rel=1e-12)
    assert own == pytest.approx(dt / ratio, rel=1e-15)
    assert applied == 400 and len(inTime) == (400 if kind == "mpm" else 100) and all(inTime)


@pytest.mark.parametrize("kind, steps", [("mpm", 1200 + 24), ("dem", 102)])
def test_a_change_of_dt_waits_for_the_end_of_a_cycle(same, kind, steps):
    taken, difference, factor, ratio = same[kind + " changed"]
    assert taken == steps and abs(difference) < 1e-15 and factor == 0.5
    assert ratio == pytest.approx(
        1.0 if kind == "mpm" else 4.5 / 6, rel=1e-9
    )  # the first cycle of four keeps its step


def test_a_time_stepper_respects_the_critical_step_of_the_scene(steps):
    dt, maxDt, limit, own, together = steps["with mpm"]
    assert steps["dem alone"] > 5 * limit  # control: alone the stepper takes far more
    assert dt == maxDt == limit == own and together
    assert steps["by hand"][0] == steps["by hand"][1]
    assert steps["without"][0] > 2 * limit and steps["without"][1:] == [True, 5]
    assert steps["smaller maxDt"] == [1e-4, 1e-4, 1e-4]
    assert "put it before the NewtonIntegrator" in steps["behind"]


def test_the_smaller_step_wins(steps):
    dt, dem, limit = steps["stiff sphere"]
    assert dt == dem < limit
    assert steps["given"] == [1e-5, 1e-5]
    assert steps["largest"] == [1.0, True]
    message, iteration, taken = steps["too large"]
    assert "exceeds" not in message and "is not allowed: the critical step of 'mpm'" in message
    assert (iteration, taken) == (6, 6)  # before the first step
    assert steps["corrected"] == [7, 7, None]  # without attaching again


def test_dead_engines_and_a_clock_that_was_moved(steps):
    assert steps["dead"] == [10, True] and steps["alive"] == [20, True]
    assert steps["no updater"] == [25, True, True]
    assert "has taken steps outside of YADE" in steps["stepped"] and "the clocks differ" in steps["set back"]
    factor, difference = steps["dt by a PyRunner"]
    assert factor == pytest.approx(0.9**5) and abs(difference) < 1e-15
    assert steps["offset"] == [True, None, True]


def test_bad_input(steps):
    assert "YADE is running" in steps["running"][0] and "going on in the background" in steps["running"][1]
    assert "YADE is running" in steps["running"][2]
    assert "one of the two has to be 1" in steps["ratio"] and "demSteps = 0 is not allowed" in steps["zero"]
    assert "mpmSteps = 1.5 is not allowed" in steps["half"]
    assert "label = 'a b' is not allowed" in steps["label"]
    assert "give stages=False" in steps["several"] and "attached as 'mpm' already" in steps["twice"]
    assert "give a yade_mpm.Scene" in steps["kind"] and "no scene was given" in steps["unsaved"]


def test_without_yade_attach_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "yade", None)
    with pytest.raises(ImportError, match="apt install yade"):
        mpm.yade.attach(None)
