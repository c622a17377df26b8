# SPDX-License-Identifier: GPL-2.0-or-later
"""The collapse of a column with uGIMP and hybrid, with cells of 10 and 5 mm: deposits in one picture.

scripts/run column_collapse_compare
"""

import argparse
import os

import column_collapse
from column_collapse import HEIGHT, WIDTH, surfaceOf
from yade_mpm import commandLine, files, plot
from yade_mpm.commandLine import below, between

CELLS = 0.01, 0.005  # m


def arguments(words=None):
    p = commandLine.Parser("column_collapse_compare", __doc__, smoke={"until": 0.2})
    p.add_argument("--damping", type=below(1), default=0.05, help="local damping (default %(default)s)")
    p.add_argument("--until", type=between(0.05, 100), default=0.8, help="end, s (default %(default)s)")
    return p.parse(words)


def draw(scenes, file):
    """Surfaces of the deposits; dashed: before."""
    figure, axes = plot.plt.subplots(figsize=(7, 2.6), layout="constrained")
    for label, scene in scenes.items():
        axes.plot(*surfaceOf(scene), "--" if "hybrid" in label else "-", label=label, lw=1.4)
    axes.plot([0, WIDTH, WIDTH], [HEIGHT, HEIGHT, 0], "k--", lw=0.6)
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
        column_collapse.draw(snapshots, os.path.join(a.out, f"{types}_{1e3 * cell:g}mm.png"))
    draw(scenes, os.path.join(a.out, "surfaces.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summaries)


if __name__ == "__main__":
    commandLine.run(main)
