# SPDX-License-Identifier: GPL-2.0-or-later
"""The sheet pile pressed into soil of APDI alone, whose stretched domains become uGIMP particles
(scripts/studies/sheet_pile_study.py).

The coarse, fast scene: cell 0.5 m, pile of 0.5 m, 1 m/s; to 1.25 m, and the whole 4 m at 0.1 m/s (slow).
Reference: the hybrid.
Tolerance 10 % of its resistance down to 2 m. Control: without conversion edges grow beyond the limit.
"""

import numpy as np
import pytest
import sheet_pile_model
import sheet_pile_study
import yade_mpm as mpm


def press(*options):
    """Scene, history and resistance at every 0.5 m down to 2 m of a run with the given options."""
    a = sheet_pile_study.arguments(["--threads", "1", *options])
    scene, history = sheet_pile_model.build(a), mpm.History(period=a.until / 300)
    scene.engines = [*scene.engines, history]
    scene.run(until=a.until, progress=False)
    depth, _, resistance = sheet_pile_model.resistanceCurve(a, scene, history)
    return scene, history, np.interp(np.arange(0.5, min(2.0, depth[-1]) + 1e-6, 0.5), depth, resistance)


def largestGrowth(body):
    """Longest edge of a domain over that at the start, which was 0.25 m."""
    corners = body.corners()
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() / 0.25


def checked(scene, history):
    soil, converted = scene["soil"], scene["soil (converted)"]
    assert soil.converted > 0 and converted.count >= soil.converted
    assert history["invertedCount"].max() == 0 and soil.minJacobian > 0.05
    assert (converted.mass > 0).all() and (converted.volume > 0).all()
    assert soil.mass.sum() + converted.mass.sum() == pytest.approx(1.53 * (30 * 12 - 0.5), rel=1e-12)
    assert largestGrowth(soil) < 1.151


def test_stretched_domains_are_converted_and_the_pile_feels_the_resistance_of_the_hybrid():
    scene, history, resistance = press(
        "--smoke", "--types", "apdi", "--on-distortion", "convert", "--until", "1.75"
    )
    checked(scene, history)
    assert resistance == pytest.approx(press("--smoke", "--until", "1.75")[2], rel=0.1)


def test_control_without_conversion_edges_grow_on():
    assert largestGrowth(press("--smoke", "--types", "apdi", "--until", "1.75")[0]["soil"]) > 1.5


@pytest.mark.slow
def test_the_whole_penetration_runs_without_inversion():
    scene, history, resistance = press("--cell", "0.5", "--types", "apdi", "--on-distortion", "convert")
    checked(scene, history)
    assert resistance == pytest.approx([1545, 2101, 2257, 2308], rel=0.1), "the hybrid of the same grid"
