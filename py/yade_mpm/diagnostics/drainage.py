# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether pore water has time to leave what a motion loads."""

from __future__ import annotations

import numpy as np

from ..base.kinds import SCENE, takes
from ..engine.poreWater import PoreWater
from ..engine.prescribed import Drive

# V = v B / c_v of a strip footing, measured: doc/howto/water.md; Finnie & Randolph (1994) have 30 and 0.01
UNDRAINED, DRAINED = 30.0, 0.003
GRAVITY = 9.81  # m/s2, that belongs to a permeability in m/s


@takes(scene=SCENE)
def drainage(scene) -> tuple[float, str] | None:
    """(V, what it means): speed v of the fastest motion times its width B over the least coefficient of
    consolidation c_v = k M / gamma_w, -; M is the oedometer modulus as it stands. None without pore water or
    without a motion. Half a model has half the width, and half of V."""
    water = next((e for e in scene.engines if isinstance(e, PoreWater) and not e.dead), None)
    solver = scene._gridSolver("drainage")
    moved = max((_moved(scene, motion) for motion in (*solver.holds, *solver.drives)), default=0.0)
    if water is None or not moved:
        return None
    least = min(consolidation(scene), default=None)
    if least is None:
        return None
    if least == 0:
        return np.inf, "undrained, as its permeability of 0 says"
    number = moved / least
    if number > UNDRAINED:
        return number, f"undrained: water has no time to leave, V = v B / c_v = {number:.2g}"
    if number < DRAINED:
        return number, f"drained: water leaves at once, V = v B / c_v = {number:.2g}"
    return number, f"partly drained: the rate changes the result, V = v B / c_v = {number:.2g}"


def _moved(scene, motion):
    """Speed times the least width across it, m2/s."""
    speed = np.array([v or 0.0 for v in motion.velocity])[: scene.dim]
    lower, upper = _extent(scene, motion)
    widths = np.minimum(upper, scene.upper) - np.maximum(lower, scene.lower)
    return float(np.linalg.norm(speed) * np.delete(widths, np.argmax(np.abs(speed))).min())


def _extent(scene, motion):
    if isinstance(motion, Drive):
        corners = motion.part.body.corners()[motion.part.has()].reshape(-1, scene.dim)
        return (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (scene.lower, scene.lower)
    return (scene.lower, scene.upper) if isinstance(motion.where, str) else motion.where.bounds()


def consolidation(scene):
    """Least c_v of each body with water, m2/s."""
    water = next((e for e in scene.engines if isinstance(e, PoreWater)), None)
    stiffness = scene._core.presentStiffness()
    for body, (bulk, shear) in zip(scene.bodies, stiffness):
        if body._core.hasPores and (wet := body.saturation > 0).any():
            yield body.permeability[wet].min() * (bulk + 4 / 3 * shear) / (water.density * GRAVITY)
