#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Cantilever under gravity that is switched on suddenly, plane strain.

A neo-Hookean beam, 4 m long and 1 m deep, is clamped at its left end and swings freely under its own weight;
it bends by a fifth of its length and comes back. Both components are held at the clamp. Units: kg, m, s, Pa.

    scripts/run cantilever
    scripts/run cantilever --cell 0.0625
    scripts/run cantilever --type UGIMP         # boxes that do not turn with the beam
"""

import os

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, plot
from yade_mpm.io import files

LENGTH, DEPTH = 4.0, 1.0  # m
# Tip at mid-height and centre of mass of total-Lagrangian finite elements, 64 x 16 bilinear quadrilaterals.
TIMES = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5])
TIP = np.array([-0.380, -0.766, -0.395, -0.001, -0.366, -0.765])
CENTRE = np.array([-0.158, -0.319, -0.166, -0.001, -0.151, -0.318])


PARAMETERS = mpm.Parameters(
    "cantilever",
    __doc__,
    Parameter("cell", 0.125, "size of the grid's cells", unit="m", partOf=0.5),
    Parameter("until", 1.5, "end", unit="s", above=0),
    Parameter("type", "APDI", "particle type", choices=("APDI", "UGIMP")),
    smoke={"cell": 0.25, "until": 0.5},
)
arguments = PARAMETERS.parse


def build(cell=0.125, type="APDI", scheme="MUSL", gravity=10.0, threads=None):
    """Scene of the beam; two particles per cell and direction. cell, m; gravity, m/s2."""
    upper = LENGTH + 0.5, DEPTH + 0.5
    scene = mpm.Scene(lower=(0, -1.5), upper=upper, cell=cell, scheme=scheme, threads=threads)
    scene.gravity = gravity
    scene.fix("left")
    rubber = mpm.NeoHookean(density=1050, young=1e7, poisson=0.3)
    type_ = mpm.APDI(size=cell / 2) if type == "APDI" else mpm.UGIMP(perCell=2)
    scene.add("beam", box((0, 0), (LENGTH, DEPTH)), rubber, type_)
    return scene


class TipHistory:
    """Displacement of the tip at mid-height and of the centre of mass, with time.

    The tip is a vertex of the mesh, or the mean of the boxes nearest to it.
    """

    def __init__(self, scene):
        self.scene, self.beam = scene, scene["beam"]
        points = self.beam.position if self.beam.cells is None else self.beam.vertices
        distance = np.linalg.norm(points - (LENGTH, DEPTH / 2), axis=1)
        nearest = np.flatnonzero(distance <= distance.min() + 1e-9)
        self.tip = nearest if self.beam.cells is not None else self.beam.id[nearest]
        self.start, self.rows = self.heights(), [[0.0, 0.0, 0.0]]
        scene.engines.append(mpm.PyRunner(self.note, iterPeriod=1))

    def heights(self):
        """Height of the tip and of the centre of mass now, m."""
        beam, isMesh = self.beam, self.beam.cells is not None
        tip = beam.vertices[self.tip] if isMesh else beam.position[np.isin(beam.id, self.tip)]
        return np.array([tip[:, 1].mean(), np.average(beam.position[:, 1], weights=beam.mass)])

    def note(self):
        self.rows.append([self.scene.time, *(self.heights() - self.start)])

    def at(self, times):
        """Tip and centre of mass at given times, (n, 2) m."""
        t, tip, centre = np.array(self.rows).T
        return np.stack([np.interp(times, t, tip), np.interp(times, t, centre)], axis=1)


def run(until=1.5, progress=None, **arguments):
    """Runs the beam and returns (scene, history). Arguments as for `build`."""
    scene = build(**arguments)
    history = TipHistory(scene)
    scene.run(until=until, progress=progress)
    return scene, history


def draw(scene, history, file):
    """Domains as they are now, coloured by horizontal stress, and the path of the tip."""
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
    limit = abs(scene["beam"].stress[:, 0, 0]).max() / 1e3
    bar = dict(edge="k", orientation="horizontal")
    horizontal = lambda beam: beam.stress[:, 0, 0] / 1e3  # noqa: E731
    plot.domains(
        left, scene.bodies, horizontal, (-limit, limit), "horizontal stress (kPa)", "coolwarm", **bar
    )
    left.set(xlim=(-0.1, LENGTH + 0.4), ylim=(-1.5, 1.3), xlabel="x (m)", ylabel="y (m)")
    left.set_title(f"t = {scene.time:.2f} s")
    t, tip, centre = np.array(history.rows).T
    right.plot(t, tip, label="tip")
    right.plot(t, centre, label="centre of mass")
    right.plot(TIMES, TIP, "ko", TIMES, CENTRE, "ko", fillstyle="none")
    right.plot([], [], "ko", fillstyle="none", label="finite elements")
    right.set(xlabel="time (s)", ylabel="displacement (m)", xlim=(0, 1.05 * t[-1]), ylim=(-0.85, 0.2))
    right.legend(loc="upper center", ncol=3)
    plot.save(figure, file, dpi=150)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    scene, history = run(a.until, cell=a.cell, type=a.type, threads=a.threads)
    print(f"{scene.particleCount} particles, {scene.steps} steps of {scene.dt:.3g} s")
    print("   t (s)   tip (m)  reference   centre (m)  reference")
    for t, (tip, centre), tipReference, centreReference in zip(TIMES, history.at(TIMES), TIP, CENTRE):
        if t <= scene.time + 1e-9:
            print(f"{t:8.2f} {tip:9.3f} {tipReference:10.3f} {centre:12.3f} {centreReference:10.3f}")
    draw(scene, history, os.path.join(a.out, "cantilever.png"))
    lowest, centre = (float(column.min()) for column in np.array(history.rows).T[1:])
    summary = {"lowestTip": lowest, "lowestCentre": centre, "particles": scene.particleCount}
    files.saveJson(os.path.join(a.out, "summary.json"), summary)


if __name__ == "__main__":
    app.run(main)
