# SPDX-License-Identifier: GPL-2.0-or-later
"""Soil that has opened at the apex, or at the tension cut-off, closes before it bears pressure."""

from math import radians

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm import box

SAND = dict(density=2.0, young=5e3, poisson=0.3, cohesion=0.0, frictionAngle=radians(31))
BULK = SAND["young"] / (3 * (1 - 2 * SAND["poisson"]))


def pressureAfter(*strains, **more):
    """Mean pressure after volumetric strains one after the other."""
    point = mpm.MaterialPoint(mpm.MohrCoulombDruckerPrager(**{**SAND, **more}))
    for strain in strains:
        stress = point.strain(strain / 3 * np.eye(3))
    return -np.trace(stress) / 3


@pytest.mark.parametrize("more", [{}, {"cohesion": 5.0}, {"cohesion": 5.0, "tensionCutOff": 1.0}])
def test_what_opened_closes_before_it_bears_pressure(more):
    limit = more.get("tensionCutOff", more.get("cohesion", 0) / np.tan(SAND["frictionAngle"]))
    opened = 0.01 + limit / BULK
    assert pressureAfter(opened, -0.006, closing=True, **more) == pytest.approx(-limit, abs=1e-9)
    closed = pressureAfter(opened, -0.006, -0.006, closing=True, **more)
    assert closed == pytest.approx(0.002 * BULK - limit, rel=0.01)
    control = pressureAfter(opened, -0.006, **more)
    assert control == pytest.approx(0.006 * BULK - limit, rel=0.01)


def test_opening_is_state_and_counts_as_plastic_volume():
    point = mpm.MaterialPoint(mpm.MohrCoulombDruckerPrager(**SAND, closing=True))
    point.strain(0.01 / 3 * np.eye(3))
    point.strain(-0.004 / 3 * np.eye(3))
    assert point.state["opening"] == pytest.approx(0.006, rel=1e-3)
    assert point.state["plasticVolumetricStrain"] == pytest.approx(0.006, rel=1e-3)


def test_closing_is_fixed_once_a_body_has_its_state():
    soil = mpm.MohrCoulombDruckerPrager(**SAND)
    scene = mpm.Scene((0, 0), (1, 1), 0.25)
    scene.add("sand", box((0, 0), (1, 0.5)), soil, mpm.UGIMP())
    with pytest.raises(Exception, match="closing"):
        soil.closing = True


def test_the_bulk_volume_after_a_collapse(capsys):
    """And what is told of it: soil that keeps what it gained says how it would not."""
    assert collapsed(closing=True) == pytest.approx(1, abs=0.02)
    assert "has gained" not in capsys.readouterr().err
    assert collapsed(closing=False) > 1.035
    told = [line for line in capsys.readouterr().err.splitlines() if "'sand' has gained" in line]
    assert len(told) == 1 and told[0].endswith("give MohrCoulombDruckerPrager(closing=True)")


def collapsed(closing):
    """Sum of the volumes of a column of sand that ran out, over that at the start."""
    scene = mpm.Scene((0, 0), (1, 0.26), 0.02, threads=1)
    soil = mpm.MohrCoulombDruckerPrager(**SAND, closing=closing)
    sand = scene.add("sand", box((0, 0), (0.2, 0.2)), soil, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=0.2, K0=0.5)
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(roller="left", fixed="bottom", gravity=(0, -9.81), damping=0.05),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    scene.run(until=0.8, progress=False)
    return sand.volume.sum() / sand.initialVolume.sum()


def test_open_soil_does_not_shorten_the_critical_step():
    """It is as much lighter as its volume grew, and has no stiffness until it has closed."""
    steps = {}
    for opened in (False, True):
        scene = mpm.Scene((0, 0), (1, 1), 0.25)
        sand = scene.add(
            "sand", box((0, 0), (1, 0.5)), mpm.MohrCoulombDruckerPrager(**SAND, closing=True), mpm.UGIMP()
        )
        if opened:
            sand.opening[:] = np.log(9)
            sand.volume = 9 * sand.initialVolume
            sand.deformationGradient = np.diag([3.0, 3.0, 1.0])
        steps[opened] = scene.criticalTimeStep()
    assert steps[True] == pytest.approx(steps[False], rel=1e-6)


def test_soil_open_at_a_cut_off_keeps_its_shear_stiffness():
    """Below the apex it bears shear, so light soil there asks for shorter steps."""
    steps = {}
    for cutOff in (None, 0.0):
        law = {**SAND, "cohesion": 5.0, "tensionCutOff": cutOff}
        scene = mpm.Scene((0, 0), (1, 1), 0.25)
        sand = scene.add(
            "sand", box((0, 0), (1, 0.5)), mpm.MohrCoulombDruckerPrager(**law, closing=True), mpm.UGIMP()
        )
        sand.opening[:] = np.log(9)
        sand.volume = 9 * sand.initialVolume
        sand.deformationGradient = np.diag([3.0, 3.0, 1.0])
        steps[cutOff] = scene.criticalTimeStep()
    assert steps[0.0] < 0.7 * steps[None]
