#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A T-bar far below the surface of undrained clay: the bearing capacity factor of Randolph and Houlsby.

Plane strain, weightless: a stiff cylinder of the diameter D is pulled through Tresca soil of the strength su,
which it has displaced from the start. The soil lies in a box with rollers on all sides, with all stresses at
-20 su, so that it closes behind the bar. Where the interface resists alpha su, the solution of plasticity is

    N = F / (su D) = pi + 2 d + 2 cos d + 4 (cos(d/2) + sin(d/2)),   d = asin(alpha)

(Randolph & Houlsby 1984): 9.142 for a smooth bar, 11.940 for a rough one. The lower and the upper bound agree
for the rough bar; for the smooth one the best upper bound is 9.20 (Martin & Randolph 2006). The ratio of both
factors, 1.306, does not depend on how large the bar is on the grid. Soil with F-bar: without it the factor is
a quarter too large.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run tbar                       # smooth, D = 8 cells
    scripts/run tbar --alpha 1 --cells 16
"""

from math import asin, cos, pi, sin

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, disc, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.meshes import ring
from yade_mpm.geotech.reference import STRENGTH

DIAMETER = 0.8  # m
CONFINEMENT = 20 * STRENGTH  # kPa
RAMP = 0.05  # m, over which the rate grows from zero

PARAMETERS = mpm.Parameters(
    "tbar",
    __doc__,
    Parameter("alpha", 0.0, "strength of the interface over that of the soil", least=0, most=1),
    Parameter("cells", 8, "per diameter", least=5, whole=True),
    Parameter("extent", 10, "of the box, diameters", least=4, whole=True),
    Parameter("depth", 1.0, "how far the bar is pulled, diameters", above=0.2),
    Parameter("rate", 0.3, "of the bar", unit="m/s", above=0),
    reference.FBAR,
    reference.CONSTRAINTS,
    smoke={"cells": 8, "extent": 6, "depth": 0.5},
)
arguments = PARAMETERS.parse


def exactFactor(alpha):
    """N of Randolph and Houlsby."""
    d = asin(alpha)
    return pi + 2 * d + 2 * cos(d) + 4 * (cos(d / 2) + sin(d / 2))


def build(a):
    """The scene: the bar half of its path above the middle of the box, to a cell (without output)."""
    cell, size = DIAMETER / a.cells, a.extent * DIAMETER
    # By whole cells, so that boxes lie round the bar alike at any depth.
    centre = (0.5 * size, 0.5 * size + cell * round(0.5 * a.depth * a.cells))
    scene = mpm.Scene((0, 0), (size, size), cell, threads=a.threads)
    # No box in the way of a facet; the stress closes the gap.
    around = disc(centre, 0.5 * DIAMETER + 0.1 * cell)
    soil = reference.addSoil(scene, box((0, 0), (size, size)) - around, a)
    soil.setStress(-CONFINEMENT * np.eye(3))
    mesh = ring(centre, 0.5 * DIAMETER - 2 * cell, 0.5 * DIAMETER, 0.5 * cell)
    walls = ("left", "right", "bottom", "top")
    reference.drive(scene, "bar", mesh, a, RAMP, adhesion=a.alpha * STRENGTH, roller=walls)
    return scene


def run(a, scene=None):
    """Pulls the bar; returns (summary, scene, depth over D, factor)."""
    scene = scene or build(a)
    summary, way, force, _ = reference.press(a, scene, a.depth * DIAMETER, RAMP)
    depth, factor = way / DIAMETER, force / (STRENGTH * DIAMETER)
    late = depth > 0.5 * a.depth
    exact, soil = exactFactor(a.alpha), scene["soil"]
    pressure = -np.average(np.trace(soil.stress, axis1=1, axis2=2), weights=soil.volume) / 3
    summary |= {
        "factor": float(factor[late].mean()),
        "exact": exact,
        "error": float(factor[late].mean() / exact - 1),
        "pressureOverConfinement": float(pressure / CONFINEMENT),
    }
    return summary, scene, depth, factor


def draw(a, scene, depth, factor, file):
    """Velocity of the soil round the bar, and factor over depth."""

    def field(axes):
        speed = lambda body: np.linalg.norm(body.velocity, axis=1) / a.rate  # noqa: E731
        plot.domains(axes, scene.bodies, speed, (0, 1.5), "speed over that of the bar", scale=DIAMETER)

    view = 0.5 * a.extent - 2, 0.5 * a.extent + 2
    window = dict(xlim=view, ylim=view, xlabel="x / D", ylabel="y / D")
    lines = {"Randolph & Houlsby": ([0, depth[-1]], 2 * [exactFactor(a.alpha)])}
    labels = "displacement / D", "F / (su D)"
    reference.compare(file, field, (depth, factor), lines, labels, window)


def tell(a, s):
    return (
        f"N = {s['factor']:.2f} ({s['error']:+.1%} of {s['exact']:.3f}); mean pressure "
        f"{s['pressureOverConfinement']:.3f} of that at the start"
    )


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
