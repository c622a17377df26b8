# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of scripts/yade_footing.py."""

from math import pi

import numpy as np
from yade_mpm import plot


def draw(results, file, box, prandtl):
    """Load over settlement of all runs, and the ground of the last.

    box : (half width, half height, level of the ground), m. prandtl : kPa.
    """
    half, height, level = box
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(9.6, 3.4), layout="constrained", width_ratios=(1, 1.35)
    )
    for summary, _, depth, pressure in results:
        left.plot(1e3 * depth, pressure, lw=1, label=f"{summary['types']}, cell {summary['cell']:g} m")
    left.axhline(prandtl, color="k", lw=0.9, ls="--")
    left.text(0, prandtl + 6, " (2 + π) c", va="bottom", ha="left")
    left.set(
        xlabel="settlement (mm)",
        ylabel="load over B and thickness (kPa)",
        xlim=(0, None),
        ylim=(0, 1.25 * prandtl),
    )
    left.legend(loc="lower right")
    summary, snapshot = results[-1][:2]
    coloured = snapshot.draw(right, 0.05, window=(0, 12, 2.5, 9))
    bottom = level - summary["settlement"]
    right.fill(
        [0, half, half, 0],
        [bottom, bottom, bottom + 2 * height, bottom + 2 * height],
        fc="0.75",
        ec="k",
        lw=0.8,
    )
    right.text(0.5 * half, bottom + height, "YADE box", ha="center", va="center")
    drawMechanism(right, half, level)
    right.set(xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(coloured, ax=right, label="plastic shear strain (-)", extend="max", shrink=0.8)
    plot.save(figure, file)


def drawMechanism(axes, half, level):
    """Outline of Prandtl's mechanism: wedge under the box, fan about its edge, wedge beside it."""
    fan = np.linspace(1.25 * pi, 1.75 * pi, 40)
    radius = np.sqrt(2) * half
    x, y = half + radius * np.cos(fan), level + radius * np.sin(fan)
    axes.plot([*x, 3 * half], [*y, level], "k--", lw=0.8)
    axes.plot([x[0], half, x[-1]], [y[0], level, y[-1]], "k--", lw=0.8)
