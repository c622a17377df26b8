#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A T-bar far below the surface of undrained clay: the bearing capacity factor of Randolph and Houlsby.

Plane strain, weightless: a stiff cylinder of the diameter D is pulled through Tresca soil of the strength su,
which it has displaced from the start. The soil lies in a box with rollers on all sides, with all stresses at
-20 su, so that it closes behind the bar. Where the interface bears alpha su, the solution of plasticity is

    N = F / (su D) = pi + 2 d + 2 cos d + 4 (cos(d/2) + sin(d/2)),   d = asin(alpha)

(Randolph & Houlsby 1984): 9.142 for a smooth bar, 11.940 for a rough one. The lower and the upper bound agree
for the rough bar; for the smooth one the best upper bound is 9.20 (Martin & Randolph 2006). The ratio of both
factors, 1.306, does not depend on how large the bar is on the grid. Soil with F-bar: without it the factor is
a quarter too large.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run tbar                       # smooth, D = 8 cells
    scripts/run tbar --alpha 1 --cells 16
"""

import os
import time
from math import asin, cos, pi, sin

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, box, commandLine, disc, files, plot, study
from yade_mpm.study.meshes import ring

DIAMETER, STRENGTH, SHEAR, POISSON, DENSITY = 0.8, 10.0, 1000.0, 0.49, 1.5  # m, kPa, kPa, -, Mg/m3
CONFINEMENT = 20 * STRENGTH  # kPa
RAMP = 0.05  # m, over which the rate grows from zero

PARAMETERS = mpm.Parameters(
    "tbar",
    __doc__,
    Parameter("alpha", 0.0, "strength of the interface over that of the soil", least=0, most=1),
    Parameter("cells", 8, "per diameter", least=4, whole=True),
    Parameter("extent", 10, "of the box, diameters", least=4, whole=True),
    Parameter("depth", 1.0, "how far the bar is pulled, diameters", above=0.2),
    Parameter("rate", 0.3, "of the bar", unit="m/s", above=0),
    Parameter("noFbar", False, "without F-bar: the soil locks"),
    Parameter("constraints", "nodes", "as of Contact", choices=("nodes", "facets")),
    smoke={"cells": 8, "extent": 6, "depth": 0.5},
)
arguments = PARAMETERS.parse


def exactFactor(alpha):
    """N of Randolph and Houlsby."""
    d = asin(alpha)
    return pi + 2 * d + 2 * cos(d) + 4 * (cos(d / 2) + sin(d / 2))


def build(a):
    """The scene: the bar half of its path above the middle of the box (without output)."""
    cell, size = DIAMETER / a.cells, a.extent * DIAMETER
    centre = (0.5 * size, 0.5 * size + 0.5 * a.depth * DIAMETER)
    scene = mpm.Scene((0, 0), (size, size), cell, threads=a.threads)
    lame = 2 * SHEAR * POISSON / (1 - 2 * POISSON), SHEAR
    clay = mpm.MohrCoulombDruckerPrager(density=DENSITY, lame=lame, cohesion=STRENGTH, frictionAngle=0.0)
    around = disc(
        centre, 0.5 * DIAMETER + 0.1 * cell
    )  # no box in the way of a facet; the stress closes the gap
    region = box((0, 0), (size, size)) - around
    boxes = mpm.UGIMP(perCell=2, splitAt=1.3)
    soil = scene.add("soil", region, clay, boxes, fbar=not a.noFbar, group="soil")
    soil.setStress(-CONFINEMENT * np.eye(3))
    mesh = mpm.Mesh(*ring(centre, 0.5 * DIAMETER - 2 * cell, 0.5 * DIAMETER, 0.5 * cell))
    rigid = mpm.LinearElastic(density=DENSITY, lame=lame)  # driven whole
    bar = scene.add("bar", mesh, rigid, mpm.APDI(), group="bar")
    drive = mpm.Drive(bar, velocity=(0, -a.rate), ramp=RAMP / a.rate)
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(roller=("left", "right", "bottom", "top"), drive=drive),
        mpm.Contact(adhesion=a.alpha * STRENGTH, impactLoss=1.0, constraints=a.constraints),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    return scene


def run(a, scene=None):
    """Pulls the bar; returns (summary, scene, depth over D, factor)."""
    began, scene = time.monotonic(), scene or build(a)
    until = a.depth * DIAMETER / a.rate + 0.5 * RAMP / a.rate
    history = mpm.History(period=until / 400)
    scene.engines = [*scene.engines, history]
    scene.run(until=until)
    depth = study.travel(history["time"], a.rate, RAMP / a.rate) / DIAMETER
    factor = -history["drive.fy"] / (STRENGTH * DIAMETER)
    late = depth > 0.5 * a.depth
    exact, soil = exactFactor(a.alpha), scene["soil"]
    pressure = -np.average(np.trace(soil.stress, axis1=1, axis2=2), weights=soil.volume) / 3
    summary = {
        **study.record(a, scene, time.monotonic() - began),
        "factor": float(factor[late].mean()),
        "exact": exact,
        "error": float(factor[late].mean() / exact - 1),
        "pressureOverConfinement": float(pressure / CONFINEMENT),
        "dampedShare": mpm.quasiStatic(history).dampedShare,
    }
    return summary, scene, depth, factor


def draw(a, scene, depth, factor, file):
    """Velocity of the soil round the bar, and factor over depth."""
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.6, 4.2), layout="constrained")
    speed = lambda body: np.linalg.norm(body.velocity, axis=1) / a.rate  # noqa: E731
    plot.domains(left, scene.bodies, speed, (0, 1.5), "speed over that of the bar", scale=DIAMETER)
    middle = 0.5 * a.extent
    left.set(xlim=(middle - 2, middle + 2), ylim=(middle - 2, middle + 2), xlabel="x / D", ylabel="y / D")
    right.plot(depth, factor, "C3", lw=1)
    right.axhline(exactFactor(a.alpha), color="k", lw=0.9, ls="--", label="Randolph & Houlsby")
    right.set(xlabel="displacement / D", ylabel="F / (su D)", xlim=(0, None), ylim=(0, None))
    right.legend(loc="lower right")
    plot.save(figure, file)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summary, scene, *curve = run(a)
    draw(a, scene, *curve, os.path.join(a.out, "tbar.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summary)
    print(
        f"N = {summary['factor']:.2f} ({summary['error']:+.1%} of {summary['exact']:.3f}); mean pressure "
        f"{summary['pressureOverConfinement']:.3f} of that at the start; results in {a.out}/"
    )


if __name__ == "__main__":
    commandLine.run(main)
