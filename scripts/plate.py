#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A thin plate far below the surface of undrained clay is pulled across its plane: 3 pi + 2.

Plane strain, weightless, the half right of the plate's axis: a stiff smooth plate of the breadth D goes down
through Tresca soil of the strength su, in a box with rollers on all sides. All stresses are -20 su at the
start, so that the soil closes behind the plate. Wedges of dead soil stand on both faces, and the soil turns
round the edges: a fan of 3 pi/2 between the major stress in front and the minor one behind gives

    N = F / (su D) = 3 pi + 2 = 11.42

for a plate without thickness; a thickness of t adds sqrt(2) t/D where its edges are smooth (upper bound of
O'Neill, Bransby & Randolph 2003). The plate is two cells thick, for thinner ones hold less than they should.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run plate                      # D = 16 cells
    scripts/run plate --cells 24
"""

from math import pi, sqrt

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import STRENGTH

BREADTH = 1.6  # m, D
CONFINEMENT = 20 * STRENGTH  # kPa
RAMP = 0.05  # m, over which the rate grows from zero
THICK = 2  # cells
DAMPING = 0.0

PARAMETERS = mpm.Parameters(
    "plate",
    __doc__,
    Parameter("cells", 16, "per breadth", least=8, whole=True),
    Parameter("extent", 6, "of the box, breadths", least=4, whole=True),
    Parameter("depth", 0.5, "how far the plate is pulled, breadths", above=0.1),
    Parameter("rate", 0.3, "of the plate", unit="m/s", above=0),
    reference.FBAR,
    reference.CONSTRAINTS,
    smoke={"cells": 12, "extent": 4, "depth": 0.3, "rate": 0.5},
    check=lambda a, given: f"--cells {a.cells} is not allowed; give an even number" if a.cells % 2 else None,
)
arguments = PARAMETERS.parse


def exactFactor(a):
    """N of a plate of this thickness."""
    return 3 * pi + 2 + sqrt(2) * THICK / a.cells


def build(a):
    """The scene: the plate half of its path above the middle of the box (without output)."""
    cell, size = BREADTH / a.cells, a.extent * BREADTH
    scene = mpm.Scene((0, 0), (0.5 * size, size), cell, threads=a.threads)
    bottom = round((0.5 * size + 0.5 * a.depth * BREADTH) / cell) * cell
    lower, upper = (0, bottom), (0.5 * BREADTH, bottom + THICK * cell)
    soil = reference.addSoil(scene, box((0, 0), (0.5 * size, size)) - box(lower, upper), a)
    soil.setStress(-CONFINEMENT * np.eye(3))
    x, y = np.meshgrid(
        np.linspace(lower[0], upper[0], a.cells + 1), np.linspace(lower[1], upper[1], 2 * THICK + 1)
    )
    walls = ("left", "right", "bottom", "top")
    reference.drive(scene, "plate", geotech.quadrilaterals(x, y), a, RAMP, roller=walls, damping=DAMPING)
    return scene


def run(a, scene=None):
    """Pulls the plate; returns (summary, scene, depth over D, factor)."""
    scene = scene or build(a)
    summary, way, force, _ = reference.press(a, scene, a.depth * BREADTH, RAMP)
    depth, factor = way / BREADTH, 2 * force / (STRENGTH * BREADTH)
    late, exact, soil = depth > 0.5 * a.depth, exactFactor(a), scene["soil"]
    pressure = -np.average(np.trace(soil.stress, axis1=1, axis2=2), weights=soil.volume) / 3
    summary |= {
        "factor": float(factor[late].mean()),
        "exact": exact,
        "error": float(factor[late].mean() / exact - 1),
        "pressureOverConfinement": float(pressure / CONFINEMENT),
    }
    return summary, scene, depth, factor


def draw(a, scene, depth, factor, file):
    """How far the soil round the plate has moved, and factor over depth."""

    def field(axes):
        plot.domains(axes, scene.bodies, moved, (0, 1), "displacement over that of the plate", scale=BREADTH)

    def moved(body):
        return (
            None if body.name == "plate" else np.linalg.norm(body.displacement, axis=1) / (a.depth * BREADTH)
        )

    middle = 0.5 * a.extent
    window = dict(xlim=(0, 1.5), ylim=(middle - 1.5, middle + 1.5), xlabel="x/D", ylabel="y/D")
    lines = {"$3\\pi + 2 + \\sqrt{2}\\,t/D$, exact": ([0, depth[-1]], 2 * [exactFactor(a)])}
    labels = "displacement of the plate / D", "$F/(s_u D)$"
    reference.compare(file, field, (depth, factor), lines, labels, window, mean=1 / a.cells)


def tell(a, s):
    return (
        f"N = {s['factor']:.2f} ({s['error']:+.1%} of {s['exact']:.2f}); mean pressure "
        f"{s['pressureOverConfinement']:.3f} of that at the start"
    )


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
