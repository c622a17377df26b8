# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures of scripts/yade_pile.py."""

from sheet_pile import DEPTH, EMBEDDED, WIDTH
from yade_mpm import plot


def panel(a, ax, result, title):
    """Deformed soil, coloured by plastic shear strain, and the pile."""
    window = (WIDTH / 2 - 3.5, WIDTH / 2 + 3.5, DEPTH - EMBEDDED - a.penetration - 2.0, DEPTH + 2.0)
    coloured = result["soil"].draw(ax, 1.0, window=window)
    for patch in result["pile"]:
        ax.add_patch(patch)
    ax.set(title=title, xlabel="x (m)")
    return coloured


def draw(a, results, file):
    """Deformed soil of every run and, in the last panel, the curves. results : dict title -> result."""
    figure, axes = plot.plt.subplots(
        1,
        len(results) + 1,
        figsize=(2.9 * len(results) + 3.4, 4.0),
        layout="constrained",
        width_ratios=[1] * len(results) + [1.15],
    )
    for ax, (title, result) in zip(axes, results.items()):
        coloured = panel(a, ax, result, title)
    axes[0].set_ylabel("y (m)")
    plot.colourBar(list(axes[:-1]), coloured, "plastic shear strain (-)", extend="max", shrink=0.7)
    (curvesOfBlows if a.drive == "hammer" else curvesOfResistance)(axes[-1], results)
    plot.save(figure, file)


def curvesOfResistance(ax, results):
    for title, result in results.items():
        style = dict(color="k", ls="--") if "bonded" in title else {}
        ax.plot(result["smooth"], result["depth"], label=title, **style)
    ax.set(xlabel="resistance, mean over one cell (kN/m)", ylabel="further penetration (m)", xlim=(0, None))
    ax.invert_yaxis()
    ax.legend()


def curvesOfBlows(ax, results):
    for title, result in results.items():
        ax.plot(result["time"], result["depth"], label=title)
    ax.set(xlabel="time (s)", ylabel="further penetration (m)")
    ax.invert_yaxis()
    ax.legend()
