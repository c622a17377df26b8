# SPDX-License-Identifier: GPL-2.0-or-later
"""The collapse of a column with uGIMP and hybrid, with cells of 10 and 5 mm: deposits in one picture.

scripts/run column_collapse_compare
"""

import argparse
import os

import column_collapse
import yade_mpm as mpm
from column_collapse import WIDTH, surfaceOf
from yade_mpm import Parameter, app, plot
from yade_mpm.io import files

CELLS = 0.01, 0.005  # m


PARAMETERS = mpm.Parameters(
    "column_collapse_compare",
    __doc__,
    Parameter("damping", 0.05, "local damping", least=0, below=1),
    Parameter("until", 0.8, "end", unit="s", least=0.05, most=100),
    smoke={"until": 0.2},
    fixed={"height": 0.1, "floor": 0.8, "fbar": False, "closing": False},
)
arguments = PARAMETERS.parse


def draw(a, scenes, file):
    """Surfaces of the deposits; dashed: before."""
    figure, axes = plot.plt.subplots(figsize=(7, 2.6), layout="constrained")
    for label, scene in scenes.items():
        axes.plot(*surfaceOf(scene, a.floor), "--" if "hybrid" in label else "-", label=label, lw=1.4)
    axes.plot([0, WIDTH, WIDTH], [a.height, a.height, 0], "k--", lw=0.6)
    axes.set(xlabel="x (m)", ylabel="height of the deposit (m)", xlim=(0, 0.55), ylim=(0, None))
    axes.legend()
    plot.save(figure, file)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summaries, scenes = {}, {}
    for types, cell in ((types, cell) for cell in CELLS for types in ("ugimp", "hybrid")):
        label = f"{types}, cell {1e3 * cell:g} mm"
        b = argparse.Namespace(**{**vars(a), "types": types, "cell": cell})
        summaries[label], scenes[label], snapshots = column_collapse.run(b)
        column_collapse.tell(b, summaries[label])
        file = os.path.join(a.out, f"{types}_{1e3 * cell:g}mm.png")
        column_collapse.draw(b, summaries[label]["front"], snapshots, file)
    draw(a, scenes, os.path.join(a.out, "surfaces.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summaries)


if __name__ == "__main__":
    app.run(main)
