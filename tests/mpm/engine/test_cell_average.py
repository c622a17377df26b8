# SPDX-License-Identifier: GPL-2.0-or-later
"""F-bar: after a step the particles of a body in one cell have one mean stress; its volume-weighted sum and the deviator stay."""
import numpy as np
import pytest

import yade_mpm as mpm

CELL = 0.5
STRONG = dict(density=2.0, lame=(1e3, 1e3), cohesion=1e3, frictionAngle=0.0, dilatancyAngle=0.0)


def randomlyStressed(kind, fbar):
    """A block at rest with random stresses, after one step too short to change them; stress before."""
    scene = mpm.Scene((0, 0), (4, 4), CELL)
    type_ = mpm.APDI(size=CELL / 2) if kind == "APDI" else mpm.UGIMP(perCell=2)
    body = scene.add("block", mpm.box((1, 0.5), (3, 2.5)), mpm.MohrCoulombDruckerPrager(**STRONG), type_, fbar=fbar)
    stress = np.random.default_rng(1).normal(size=(body.count, 3, 3))
    body.stress[...] = stress + stress.transpose(0, 2, 1)
    body.stress[:, :2, 2] = body.stress[:, 2, :2] = 0
    before = body.stress.copy()
    scene.dt = 1e-13
    scene.run(steps=1, progress=False)
    return body, before


def means(body, stress):
    """Mean stress of the particles, and number of the cell they are in."""
    cell = np.floor(body.position / CELL + 1e-9).astype(int)
    return np.trace(stress, axis1=1, axis2=2) / 3, cell[:, 0] + 100 * cell[:, 1]


@pytest.mark.parametrize("kind", ["APDI", "UGIMP"])
def test_a_cell_has_one_mean_stress(kind):
    body, before = randomlyStressed(kind, True)
    p, cell = means(body, body.stress)
    old, _ = means(body, before)
    assert np.ptp(old[cell == cell[0]]) > 0.1
    for c in np.unique(cell):
        inside = cell == c
        assert np.ptp(p[inside]) < 1e-8
        assert p[inside].mean() == pytest.approx(np.average(old[inside], weights=body.volume[inside]), abs=1e-8)
    assert body.stress - p[:, None, None] * np.eye(3) == pytest.approx(before - old[:, None, None] * np.eye(3), abs=1e-8)


def test_without_fbar_each_particle_keeps_its_own():
    body, before = randomlyStressed("UGIMP", False)
    assert body.stress == pytest.approx(before, abs=1e-8)
