# SPDX-License-Identifier: GPL-2.0-or-later
"""Maps of a flow over terrain, on the contour lines of the ground."""

import matplotlib.pyplot as plt
import numpy as np

from ..base.kinds import ofClass, takes
from .figures import colourBar

SHOWN = (
    ("depth", "depth (m)", "viridis"),
    ("greatestDepth", "greatest depth (m)", "viridis"),
    ("greatestVelocity", "greatest velocity (m/s)", "inferno"),
    ("arrival", "arrival (s)", "cividis"),
)
LINES = 12  # of contour
LEAST = {"depth": 0.02}


@takes(maps=ofClass("TerrainMaps", "a TerrainMaps, as scene.maps returns it"))
def terrainMaps(maps):
    """Draws the four maps of a flow in 3D; returns the figure.

    Parameters
    ----------
    maps : TerrainMaps, as `scene.maps` returns it.
    """
    ground = maps.terrain
    if ground.dim != 3:
        raise ValueError("terrainMaps: the terrain is a profile; maps are made of 3D scenes")
    x, y = (ground.origin[k] + np.arange(n) * ground.spacing[k] for k, n in enumerate(ground.heights.shape))
    wide = np.ptp(x) > 1.5 * np.ptp(y)
    figure, axes = plt.subplots(
        *((4, 1) if wide else (2, 2)), figsize=(6.5, 7), layout="constrained", sharex=True, sharey=True
    )
    isReached = np.isfinite(maps.arrival)
    for one, (name, label, colours) in zip(axes.flat, SHOWN):
        one.contour(x, y, ground.heights.T, LINES, colors="0.7", linewidths=0.5)
        values = np.ma.masked_where(
            ~isReached | (getattr(maps, name) < LEAST.get(name, -np.inf)), getattr(maps, name)
        )
        colourBar(one, one.pcolormesh(x, y, values.T, cmap=colours, shading="nearest"), label)
        one.set_aspect("equal")
    for one in axes.flat[-1:] if wide else axes[-1]:
        one.set_xlabel("x (m)")
    for one in axes.flat if wide else axes[:, 0]:
        one.set_ylabel("y (m)")
    return figure
