# SPDX-License-Identifier: GPL-2.0-or-later
"""Pore pressure at a place."""

from __future__ import annotations

import numpy as np

from ..base.kinds import NUMBER, SCENE, takes


@takes(scene=SCENE, x=NUMBER, y=NUMBER, z=NUMBER)
def piezometer(scene, x: float, y: float, z: float | None = None) -> float:
    """Pore pressure at a fixed place, kPa, compression positive; nan where no wet soil is within a cell.

    Parameters
    ----------
    x, y, z : m, the place; z in 3D alone.

    A linear field is met exactly: it is fitted to the particles within a cell of the place. As a column of a
    history: {"P1": "diagnostics.piezometer(scene, 4.0, 2.5)"}.
    """
    place = np.array([x, y] if z is None else [x, y, z], float)
    if len(place) != scene.dim:
        raise ValueError(f"piezometer: the scene has {scene.dim} axes; give as many coordinates")
    reach = scene.cellSizeAt(place[None])[0]
    found = [_near(body, place, reach) for body in scene.bodies if body._core.hasPores]
    ways = np.concatenate([ways for ways, _ in found] or [np.zeros((0, scene.dim))])
    values = np.concatenate([values for _, values in found] or [np.zeros(0)])
    if not len(values):
        return np.nan
    middle = ways.mean(axis=0)
    slope = np.linalg.lstsq(ways - middle, values - values.mean(), rcond=None)[0]
    return float(values.mean() - slope @ middle)


def _near(body, place, reach):
    """Ways from the place to the wet particles within a cell of it, and their pressures."""
    ways = body.position - place
    isNear = (body.saturation > 0) & (np.abs(ways) <= reach).all(axis=1)
    return ways[isNear], body.porePressure[isNear]
