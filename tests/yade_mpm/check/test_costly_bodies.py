# SPDX-License-Identifier: GPL-2.0-or-later
"""Implicit bodies that take most of a step are warned of."""

from types import SimpleNamespace

import pytest
import yade_mpm as mpm
from yade_mpm.check import limits
from yade_mpm.check.domains import costlyBodies


def scene(share, seconds, stage="ImplicitBodies", material=None):
    """A scene whose engines have taken some time, of which one a share."""
    engines = [
        type(name, (), {"seconds": taken, "calls": 100})()
        for name, taken in ((stage, share * seconds), ("GridSolver", (1 - share) * seconds))
    ]
    bodies = [
        SimpleNamespace(name=name, implicit=name == "wall", count=9, material=material)
        for name in ("wall", "soil")
    ]
    return SimpleNamespace(engines=engines, bodies=bodies)


@pytest.mark.parametrize("share, factor", [(0.5, 2), (0.99, 0.5), (1.01, 2), (1.9, 2)])
def test_half_and_twice_the_limits(share, factor):
    told = costlyBodies(scene(share * limits.IMPLICIT_SHARE, factor * limits.IMPLICIT_SECONDS))
    assert (told is not None) == (share > 1 and factor > 1)
    if told:
        assert "'wall' take" in told and "'soil'" not in told and f"{50 * share:.0f} % of the time" in told


def test_other_engines_are_left_alone():
    assert costlyBodies(scene(0.9, 100, "Contact")) is None


def test_a_beam_is_implicit_anyway():
    beam = mpm.Beam([(1, 0), (1, 2)], EI=1e4, EA=1e6, weight=0.2, thickness=0.5)
    wall = mpm.Scene((0, 0), (2, 2), 0.25, threads=1).add("wall", beam)
    told = costlyBodies(scene(0.9, 100, material=wall.material))
    assert "draw a Beam thinner" in told and "implicit=True" not in told
    assert "implicit=True" in costlyBodies(scene(0.9, 100))
