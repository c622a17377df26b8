#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A pipe is laid on undrained clay and sinks in: resistance over depth, heave included.

Plane strain, weightless, the half right of the axis: a stiff cylinder of the diameter D is pressed to the
depth w of its lowest point into Tresca soil of the strength su, which heaves beside it. Merifield, White &
Randolph (2009) fitted finite elements with large displacements and limit analysis by

    V / (su D) = 5.3 (w/D)^0.25  smooth,     7.4 (w/D)^0.40  rough,     0.1 <= w/D <= 0.5

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run pipe                       # smooth, D = 16 cells
    scripts/run pipe --alpha 1
"""

from math import ceil, pi

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import STRENGTH

DIAMETER = 0.8  # m
HALF, DEEP = 3, 2  # width of the half and depth of the soil, diameters
RAMP = 0.02  # m, over which the rate grows from zero
ASKED = 0.2, 0.3, 0.4, 0.5  # w/D

PARAMETERS = mpm.Parameters(
    "pipe",
    __doc__,
    Parameter("alpha", 0.0, "strength of the interface over that of the soil", choices=(0.0, 1.0)),
    Parameter("cells", 16, "per diameter", least=8, whole=True),
    Parameter("rate", 0.1, "of the pipe", unit="m/s", above=0),
    reference.FBAR,
    reference.CONSTRAINTS,
    smoke={"cells": 8, "rate": 0.2},
)
arguments = PARAMETERS.parse


def fitted(depth, alpha):
    """V/(su D) at depths over D."""
    return 7.4 * depth**0.40 if alpha else 5.3 * depth**0.25


def halfRing(cell):
    """Mesh of the right half of the pipe, its lowest point at (0, 0): points, cells."""
    outer, size = 0.5 * DIAMETER, 0.5 * cell
    rings, rays = 4, ceil(pi * outer / size)
    radius, turn = np.meshgrid(
        np.linspace(outer - rings * size, outer, rings + 1), np.linspace(-0.5 * pi, 0.5 * pi, rays + 1)
    )
    x = radius * np.cos(turn)
    x[[0, -1]] = 0
    return geotech.quadrilaterals(x, outer + radius * np.sin(turn))


def build(a):
    """The scene: the pipe on the surface (without output)."""
    cell = DIAMETER / a.cells
    half, deep = HALF * DIAMETER, DEEP * DIAMETER
    scene = mpm.Scene((0, -deep), (half, DIAMETER + 2 * cell), cell, threads=a.threads)
    reference.addSoil(scene, box((0, -deep), (half, 0)), a)
    walls = dict(damping=0.05, roller=("left", "right"), fixed="bottom")
    reference.drive(scene, "pipe", halfRing(cell), a, RAMP, adhesion=a.alpha * STRENGTH, **walls)
    return scene


def run(a, scene=None):
    """Presses the pipe in; returns (summary, scene, depth over D, factor)."""
    scene = scene or build(a)
    summary, way, force, _ = reference.press(a, scene, (ASKED[-1] + 0.02) * DIAMETER, RAMP)
    depth, factor = way / DIAMETER, 2 * force / (STRENGTH * DIAMETER)
    found = [float(factor[np.abs(depth - w) < 0.02].mean()) for w in ASKED]
    exact = [fitted(w, a.alpha) for w in ASKED]
    summary |= {
        "depth": list(ASKED),
        "factor": found,
        "exact": exact,
        "error": [n / e - 1 for n, e in zip(found, exact)],
        "meanError": float(np.mean(found) / np.mean(exact) - 1),
    }
    return summary, scene, depth, factor


def draw(a, scene, depth, factor, file):
    """Plastic strain under the pipe, and resistance over depth."""

    def field(axes):
        plot.domains(
            axes,
            scene.bodies,
            reference.strain,
            (0, 1),
            "plastic shear strain (-)",
            extend="max",
            scale=DIAMETER,
        )

    window = dict(xlim=(0, 1.5), ylim=(-1.2, 0.6), xlabel="x/D", ylabel="y/D")
    way = np.linspace(0.02, depth[-1], 100)
    lines = {"Merifield et al. 2009": (way, fitted(way, a.alpha))}
    reference.compare(file, field, (depth, factor), lines, ("w/D", "$V/(s_u D)$"), window)


def tell(a, s):
    rows = zip(s["depth"], s["factor"], s["error"])
    return f"mean {s['meanError']:+.1%}; " + ", ".join(f"w/D = {w:g}: {n:.2f} ({d:+.1%})" for w, n, d in rows)


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
