#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A spudcan is pressed into clay until the clay flows over it: the depth of the cavity that stays open.

A round foundation of the diameter D, axisymmetric, goes down from the surface of clay of the strength su and
the unit weight gamma. The hole above it stays open to the depth H; below, clay flows back round the edge:

    H/D = S^0.55 - S/4,  S = su/(gamma D)

(Hossain & Randolph 2009, from centrifuge tests and finite elements with remeshing, for strength that does not
grow with depth). The spudcan has a flat cone below and a steeper one above, and no leg.

Units: Mg, m, s, kPa; forces are of the whole circumference, kN.

    scripts/run spudcan                         # S = 0.5
    scripts/run spudcan --strength 0.25
"""

from math import ceil, pi

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import DENSITY, POISSON, STRENGTH

RADIUS, RIGIDITY = 1.0, 167.0  # m; G/su, of E/su = 500
WIDE, BELOW, EVEN = 12, 6, 4  # R: of the ground, below the spudcan at the end; cells are equal up to there
RAMP = 0.02  # m, over which the rate grows from zero
UNDER, EDGE, TOP = 0.23, 0.4, 0.4  # R: heights of the cone below, of the edge and of the cone above

PARAMETERS = mpm.Parameters(
    "spudcan",
    __doc__,
    Parameter("strength", 0.5, "of the clay over gamma D", least=0.05, most=1.5),
    Parameter("alpha", 1.0, "strength of the interface over that of the clay", least=0, most=1),
    Parameter("cells", 5, "per radius", least=4, whole=True),
    Parameter("way", 2.0, "of the spudcan", unit="D", above=0.1),
    Parameter("rate", 0.4, "of the spudcan", unit="m/s", above=0),
    reference.FBAR,
    reference.CONSTRAINTS,
    smoke={"cells": 4, "way": 0.2},
)
arguments = PARAMETERS.parse


def exact(strength):
    """H/D of Hossain & Randolph 2009, J. Geotech. Geoenviron. Eng. 135, 9."""
    return strength**0.55 - strength / 4


def shape(a, cell):
    """Mesh of the spudcan; its edge begins at the surface."""
    r = np.linspace(0, RADIUS, a.cells + 2)  # edges are no longer than cells
    foot, head = UNDER * (r - RADIUS), EDGE * RADIUS + TOP * (RADIUS - r)
    rows = ceil((UNDER + EDGE + TOP) * a.cells)
    y = foot + np.linspace(0, 1, rows + 1)[:, None] * (head - foot)
    return geotech.quadrilaterals(np.broadcast_to(r, y.shape), y)


def build(a):
    """The scene: the cone below the edge is in the ground (without output)."""
    cell, way = RADIUS / a.cells, 2 * RADIUS * a.way
    deep, top = ceil((way / RADIUS + BELOW) * a.cells) * cell, 2 * RADIUS
    near, wide = ceil((way / RADIUS + 2) * a.cells) * cell, WIDE * RADIUS
    even = mpm.Grading(((0, -near - RADIUS), (EVEN * RADIUS, top)), largest=RADIUS)
    scene = mpm.Scene((0, -deep), (wide, top), cell, grading=even, axisymmetric=True, threads=a.threads)
    shear, weight = RIGIDITY * STRENGTH, STRENGTH / (a.strength * 2 * RADIUS)
    lame = 2 * shear * POISSON / (1 - 2 * POISSON), shear
    clay = mpm.Tresca(density=DENSITY, lame=lame, undrainedStrength=STRENGTH)
    under = UNDER * RADIUS + 0.2 * cell
    hole = mpm.polygon([(-cell, -under), (0, -under), (RADIUS, -0.2 * cell), (RADIUS, cell), (-cell, cell)])
    ground, zone = box((0, -deep), (wide, 0)), box((0, -near), (3 * RADIUS, 0))
    soil = scene.add(
        "soil", zone - hole, clay, mpm.UGIMP(perCell=2, splitAt=1.3), group="soil", fbar=not a.noFbar
    )
    scene.add("far soil", ground - zone, clay, mpm.APDI(matched=soil), group="soil", fbar=not a.noFbar)
    gravity = weight / DENSITY
    soils = list(scene.bodies)
    walls = dict(gravity=(0, -gravity), damping=0.05, roller=("left", "right"), fixed="bottom")
    reference.drive(scene, "spudcan", shape(a, cell), a, RAMP, adhesion=a.alpha * STRENGTH, **walls)
    scene.initialStress(surface=0.0, K0=1.0, gravity=gravity, bodies=soils)
    return scene


def cavity(scene):
    """Depth over D of the highest clay that has come within three quarters of the radius above the spudcan;
    None where none has."""
    soil, can = scene["soil"], scene["spudcan"]
    r, z = soil.position.T
    over = (r < 0.75 * RADIUS) & (z > can.vertices[:, 1].mean())
    return -float(z[over].max()) / (2 * RADIUS) if over.any() else None


def run(a, scene=None):
    """Presses the spudcan in; returns (summary, scene, depth over D, N)."""
    scene = scene or build(a)
    summary, way, force, _ = reference.press(a, scene, 2 * RADIUS * a.way, RAMP)
    weight = scene.engines[1].gravity[1] * scene["spudcan"].mass.sum()
    factor = (force - weight) / (pi * RADIUS**2 * STRENGTH)
    found = cavity(scene)
    summary |= {"cavity": found, "exact": exact(a.strength), "factor": float(factor[-20:].mean())}
    return summary, scene, way / (2 * RADIUS), factor


def draw(a, scene, depth, factor, file):
    """Plastic strain round the spudcan, the published depth of the cavity, and load over depth."""

    def field(axes):
        plot.domains(axes, scene.bodies, reference.strain, (0, 3), "plastic shear strain", scale=2 * RADIUS)
        axes.axhline(-exact(a.strength), color="k", ls="--", lw=0.9)

    window = dict(xlim=(0, 1.6), ylim=(-a.way - 0.6, 0.4), xlabel="r / D", ylabel="z / D")
    labels = "depth / D", "load / (su A)"
    reference.compare(file, field, (depth, factor), {}, labels, window)


def tell(a, s):
    found = (
        f"no clay lies over it after {a.way:g} D" if s["cavity"] is None else f"open to {s['cavity']:.2f} D"
    )
    return f"{found} (Hossain & Randolph: {s['exact']:.2f} D); load {s['factor']:.1f} su A at the end"


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
