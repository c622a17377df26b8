# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures and tables of the studies of the sheet pile."""

import os

import numpy as np
from sheet_pile import DEPTH, EMBEDDED
from sheet_pile_measures import baseCurve, surfaceOf
from sheet_pile_model import resistanceCurve
from yade_mpm import geotech, plot
from yade_mpm.io import files

LIMIT, LABEL = 0.5, "plastic shear strain (-)"  # end of the colour scale, and its name


def windowOf(a):
    """Part of the plane that the pictures show."""
    return a.width / 2 - 5, a.width / 2 + 5, DEPTH - EMBEDDED - a.penetration - 2.5, DEPTH + 2.0


def draw(a, scene, history, snapshots, summary):
    """CSV files and pictures; returns their names."""
    depth, raw, smooth = resistanceCurve(a, scene, history)
    files.saveTable(
        os.path.join(a.out, "resistance.csv"),
        {"penetration_m": depth, "resistance_kN_per_m": raw, "resistance_over_one_cell_kN_per_m": smooth},
    )
    surface = surfaceOf(scene)
    files.saveTable(
        os.path.join(a.out, "surface.csv"),
        {"x_m": surface.x, "y_m": surface.y, "is_mesh_vertex": surface.explicit},
    )
    titles = [f"{geotech.travel(s.time, a.rate, a.ramp):.2g} m" for s in snapshots]
    figure, _ = plot.panels(snapshots, titles, LIMIT, LABEL, windowOf(a))
    plot.save(figure, os.path.join(a.out, "domains.png"))

    drawResistance(a, scene, history)
    drawSurface(a, surface, summary)
    written = [
        "sheet_pile.vtkhdf",
        "history.csv",
        "resistance.csv",
        "surface.csv",
        "domains.png",
        "resistance.png",
        "surface.png",
    ]
    if summary["convertedDomains"]:
        drawConversion(a, plot.Snapshot(scene, "plasticShearStrain"), os.path.join(a.out, "conversion.png"))
        written.append("conversion.png")
    return written


def drawResistance(a, scene, history):
    """Resistance at drive and base."""
    depth, raw, smooth = resistanceCurve(a, scene, history)
    figure, ax = plot.plt.subplots(figsize=(4.2, 4.6), layout="constrained")
    ax.plot(raw, depth, color="0.8", lw=0.6, label="drive, each sample")
    ax.plot(smooth, depth, color="C3", lw=1.6, label="drive, mean over one cell")
    ax.plot(baseCurve(a, scene, history), depth, color="k", lw=0.9, ls="--", label="base, mean over one cell")
    ax.set(
        xlabel="penetration resistance (kN/m)",
        ylabel="further penetration (m)",
        xlim=(0, 1.1 * smooth.max()),
        ylim=(depth[-1], 0),
    )
    ax.legend(loc="upper right", fontsize=8)
    plot.save(figure, os.path.join(a.out, "resistance.png"))


def drawSurface(a, surface, summary):
    """Ground surface, and the areas above and below its first level."""
    figure, ax = plot.plt.subplots(figsize=(6.4, 2.8), layout="constrained")
    ax.axhline(DEPTH, color="0.7", lw=0.8, ls="--", label="initial")
    beside = np.where((surface.x > surface.hole[0]) & (surface.x < surface.hole[1]), np.nan, surface.y)
    ax.plot(surface.x, beside, "-", lw=1.4, color="C3", label="tops of boxes (uGIMP)")
    ax.plot(
        surface.x, np.where(surface.explicit, surface.y, np.nan), "k-", lw=1.4, label="mesh vertices (APDI)"
    )
    ax.axvspan(*surface.hole, ymin=0.03, ymax=0.97, color="0.75", lw=0, label="pile")
    ax.set(
        xlabel="x (m)",
        ylabel="ground surface y (m)",
        title=f"heave {summary['heaveArea']:.2f} m², trough {summary['troughArea']:.2f} m², open cavity "
        f"{summary['openCavityArea']:.2f} m², pile {summary['displacedArea']:.2f} m²",
    )
    ax.legend(fontsize=8, loc="lower left")
    plot.save(figure, os.path.join(a.out, "surface.png"))


def drawConversion(a, snapshot, file):
    """Picture of where domains were converted, beside the plastic shear strain."""
    figure, axes = plot.plt.subplots(1, 2, figsize=(9.2, 4.4), sharey=True, layout="constrained")
    window = windowOf(a)
    coloured = snapshot.draw(axes[1], LIMIT, window=window)
    snapshot.draw(axes[0], LIMIT, window=window)
    for (name, _, _, values), collection in zip(snapshot.parts, axes[0].collections):
        if values is not None:
            collection.set(array=None, facecolor="C3" if name.endswith("(converted)") else "0.92")
    for colour, label in (("0.92", "APDI"), ("C3", "converted to uGIMP"), ("0.55", "pile")):
        axes[0].fill([], [], color=colour, label=label)
    axes[0].legend(loc="lower left", frameon=True, fontsize=8)
    axes[0].set(xlabel="x (m)", ylabel="y (m)")
    axes[1].set(xlabel="x (m)")
    plot.colourBar(axes[1], coloured, LABEL, extend="max", shrink=0.8)
    plot.save(figure, file)
