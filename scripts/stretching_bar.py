#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A block that hangs from its top stretches to 2.6 times its length: does it stay whole?

Block of 1 x 1 m, plane strain, neo-Hookean, E = 1000 kPa, nu = 0.3, rho = 1.05 Mg/m3, g = 1000 m/s2, held in
both directions at the top. The mesh of APDI stretches with the body; the boxes of uGIMP do not, and the body
falls apart where its particles drift farther apart than a box and a cell reach (numerical fracture).
`UGIMP(splitAt=1.3)` cuts long particles in two. See doc/explanation/numerical-fracture.md.
Units: Mg, m, s, kPa.

    scripts/run stretching_bar                     # three bars, their centres of mass against finite elements
    scripts/run stretching_bar --cell 0.0625
"""

import os
from pathlib import Path

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, plot
from yade_mpm.io import files

REFERENCE = Path(__file__).resolve().parents[1] / "tests" / "verification" / "stretching_bar_reference.csv"
LOWEST = 0.09  # s, when the bar is longest


PARAMETERS = mpm.Parameters(
    "stretching_bar",
    __doc__,
    Parameter("cell", 0.125, "size of the grid's cells", unit="m", partOf=0.5),
    Parameter("perCell", 3, "boxes per cell and direction", least=1, whole=True),
    Parameter("splitAt", 1.3, "stretch of the cuts", above=1),
    Parameter("until", LOWEST, "end; the default is when the bar is longest", unit="s", least=0.01, most=100),
    smoke={"cell": 0.25, "until": 0.05},
)
arguments = PARAMETERS.parse


def build(
    kind="APDI", cell=0.125, perCell=3, splitAt=1.3, step=0.001, gravity=1000.0, scheme="MUSL", threads=None
):
    """Scene of the bar. kind: 'APDI' (two domains per cell and direction), 'UGIMP' or 'split'; perCell: of
    the latter two; step: time step over the cell size, s/m; with uGIMP the result depends on it far below
    the critical step.
    """
    types = {
        "APDI": lambda: mpm.APDI(size=cell / 2),
        "UGIMP": lambda: mpm.UGIMP(perCell=perCell),
        "split": lambda: mpm.UGIMP(perCell=perCell, splitAt=splitAt),
    }
    scene = mpm.Scene(lower=(-0.5, -4), upper=(1.5, 1), cell=cell, scheme=scheme, threads=threads)
    scene.gravity = gravity
    scene.fix("top")
    rubber = mpm.NeoHookean(density=1.05, young=1000, poisson=0.3)
    scene.add("bar", box((0, 0), (1, 1)), rubber, types[kind]())
    scene.dt = step * cell
    return scene


class Watch:
    """Time (s), height of the centre of mass (m) and widest gap between the heights of particles (cells),
    with time."""

    def __init__(self, scene):
        self.scene, self.bar, self.rows = scene, scene["bar"], []
        self.note()
        scene.engines.append(mpm.PyRunner(self.note, iterPeriod=5))

    def note(self):
        y, mass = self.bar.position[:, 1], self.bar.mass
        self.rows.append(
            (self.scene.time, mass @ y / mass.sum(), np.diff(np.sort(y)).max() / self.scene.cell.min())
        )

    @property
    def widestGap(self):
        """Over the whole run, in cells. Boxes farther apart than 2 + 1/perCell share no node."""
        return max(gap for *_, gap in self.rows)

    @property
    def miss(self):
        """Largest distance of the centre of mass from the reference, in parts of its largest fall (1.07
        m)."""
        t, centre, *_ = np.loadtxt(REFERENCE, delimiter=",").T
        mine = np.array(self.rows)
        asked = (t > 0) & (t <= mine[-1, 0] + 1e-9)
        return np.abs(np.interp(t[asked], mine[:, 0], mine[:, 1]) - centre[asked]).max() / (
            centre[0] - centre.min()
        )


def run(until=LOWEST, progress=None, **arguments):
    """Runs a bar; returns (scene, watch). Arguments as for `build`."""
    scene = build(**arguments)
    watch = Watch(scene)
    scene.run(until=until, progress=progress)
    return scene, watch


def draw(bars, file):
    """The bars side by side, coloured by vertical stress, with the lower end of the reference; the centres
    of mass."""
    t, centre, end, _ = np.loadtxt(REFERENCE, delimiter=",").T
    widths = [1.0] * len(bars) + [1.6]
    size = 2.3 * len(bars) + 4.2, 5.4
    figure, axes = plot.plt.subplots(1, len(widths), figsize=size, width_ratios=widths, layout="constrained")
    *panels, curves = axes
    for ax, (name, (scene, watch)) in zip(panels, bars.items()):
        limits, lower = (0, 4000), np.interp(scene.time, t, end)
        domains = plot.domains(
            ax, scene.bodies, lambda b: b.stress[:, 1, 1], limits, colours="viridis", edge="k"
        )
        ax.axhline(lower, color="C3", ls="--", lw=1)
        ax.set(
            xlim=(-0.3, 1.3),
            ylim=(-3.1, 1.05),
            xlabel="x (m)",
            title=f"{name}\n{scene.particleCount} particles",
        )
        curves.plot(*np.array(watch.rows).T[:2], label=name)
    panels[0].set_ylabel("y (m)")
    panels[0].text(0.5, lower - 0.05, "lower end,\nfinite elements", color="C3", ha="center", va="top")
    figure.colorbar(domains, ax=panels, label="vertical stress (kPa)", extend="both", shrink=0.8)
    curves.plot(t, centre, "k.", ms=5, label="finite elements")
    curves.set(xlabel="time (s)", ylabel="height of the centre of mass (m)")
    curves.set(xlim=(0, 1.05 * scene.time), ylim=(-1.7, 0.6))
    curves.legend(fontsize=9)
    plot.save(figure, file, dpi=110)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    bars, summary = {}, {}
    for name, kind in (("APDI", "APDI"), ("uGIMP", "UGIMP"), (f"uGIMP, splitAt={a.splitAt:g}", "split")):
        shared = dict(cell=a.cell, perCell=a.perCell, splitAt=a.splitAt, threads=a.threads)
        scene, watch = bars[name] = run(a.until, kind=kind, **shared)
        summary[kind] = {"miss": watch.miss, "widestGap": watch.widestGap, "particles": scene.particleCount}
        whole = f"centre of mass within {watch.miss:.1%} of its fall, widest gap {watch.widestGap:.2f} cells"
        print(f"{name:20} {scene.particleCount:6} particles at the end; {whole}", flush=True)
    draw(bars, os.path.join(a.out, "stretching_bar.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summary)


if __name__ == "__main__":
    app.run(main)
