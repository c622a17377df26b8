# SPDX-License-Identifier: GPL-2.0-or-later
"""Wide implicit bodies are solved for by iteration where nothing asks for a factor of their matrix."""

import numpy as np
import pytest
import yade_mpm as mpm
from implicitScenes import CELL, LAME
from setups import chain, restarted, withAnyThreads
from yade_mpm import box, diagnostics

WAVE = np.sqrt((LAME[0] + 2 * LAME[1]) / 7.85)  # m/s
KINDS = {"uGIMP": lambda: mpm.UGIMP(perCell=1), "APDI": lambda: mpm.APDI(size=CELL)}


def block(kind, cells=(6, 6, 6), besideAnother=False, threads=1, crossed=3.0):
    """A block of steel that flies and strains; a wave crosses some cells in a step. Beside a grain of another
    group, which flies along, Contact may ask for the factor."""
    upper = 0.5 + CELL * np.array(cells)
    scene = mpm.Scene((0,) * 3, upper + 1.0, CELL, threads=threads)
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    body = scene.add("block", box((0.5,) * 3, upper), steel, KINDS[kind](), implicit=True)
    x = body.position - body.position.mean(axis=0)
    body.velocity = np.array((2.0, 1.0, -1.0)) + 0.3 * np.sin(3 * x[:, [1, 2, 0]])
    corner = upper + CELL / 2
    small = box(corner, corner + CELL / 2)
    grain = scene.add("grain", small, steel, mpm.UGIMP(), group="grain")
    if not besideAnother:
        scene.remove(grain)
    else:
        grain.velocity = (2.0, 1.0, -1.0)
    scene.engines = chain(contact=mpm.Contact(friction=0))
    scene.dt = crossed * CELL / WAVE
    return scene


@pytest.mark.parametrize("kind", KINDS)
def test_iteration_and_factor_move_a_wide_body_alike(kind):
    found = []
    for besideAnother in (False, True):
        scene = block(kind, besideAnother=besideAnother)
        scene.run(steps=5, progress=False)
        body = scene["block"]
        found.append((body.byId("velocity"), body.byId("stress")))
    for one, other in zip(*found):
        assert np.abs(one - other).max() < 1e-9 * np.abs(other).max()
    assert (found[0][0] != found[1][0]).any()  # control: they are two ways
    assert np.ptp(found[0][0], axis=0).max() > 0.01  # control: it strains


@pytest.mark.parametrize("kind", KINDS)
def test_a_slender_body_has_a_factor_anyway(kind):
    found = []
    for besideAnother in (False, True):
        scene = block(kind, cells=(1, 1, 6), besideAnother=besideAnother)
        scene.run(steps=5, progress=False)
        found.append(scene["block"].byId("velocity"))
    assert (found[0] == found[1]).all()


@pytest.mark.parametrize("kind", KINDS)
def test_iteration_keeps_momentum_to_round_off(kind):
    scene = block(kind)
    before = diagnostics.momentum(scene)
    scene.run(steps=30, progress=False)
    assert np.abs(diagnostics.momentum(scene) - before).max() < 1e-12 * np.abs(before).max()


@pytest.mark.parametrize("kind", KINDS)
def test_threads_and_a_restart_do_not_change_a_bit_of_iteration(kind):
    restarted(withAnyThreads(lambda threads: block(kind, threads=threads), 6), 4)
