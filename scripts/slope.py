#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A slope fails: its factor of safety by strength reduction beside the published one.

Plane strain, the first example of Griffiths & Lane 1999 (Geotechnique 49, 387-403): a homogeneous slope of
2:1 and the height H on a firm base, phi = 20 degrees, c = 0.05 gamma H, psi = 0, E = 100 MPa, nu = 0.3. They
find 1.4, where the slope does not come to rest any more; Bishop & Morgenstern's charts have 1.38. Cohesion
and tan(phi) are divided by a factor that is bisected; gravity grows from zero once, and each trial is a
run of seconds from there. Without F-bar soil locks and the slope stands far too long (`--noFbar`).

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run slope                       # hybrid, cells of 0.5 m
    scripts/run slope --types ugimp --noFbar
    scripts/run slope --factor 1.5          # this factor alone
"""

from math import radians

import yade_mpm as mpm
from yade_mpm import Parameter, app, geotech, polygon
from yade_mpm.geotech import reference, stability

HEIGHT, UNIT_WEIGHT, COHESION, PHI = 10.0, 20.0, 10.0, 20.0  # m, kN/m3, kPa (0.05 gamma H), degrees
YOUNG, POISSON = 1e5, 0.3  # kPa, -
CREST, TOE = 12.0, 32.0  # m: where the face begins and ends
PUBLISHED, BETWEEN = 1.4, (1.0, 2.0)

PARAMETERS = mpm.Parameters(
    "slope",
    __doc__,
    Parameter("cell", 0.5, "size of the grid's cells", unit="m", partOf=2.0),
    *stability.PARAMETERS,
    smoke={"cell": 1.0, "within": 0.05},
)
arguments = PARAMETERS.parse


def build(a):
    """The slope before gravity."""
    scene = mpm.Scene((0, 0), (TOE + 4.0, HEIGHT + 2.0), a.cell, gravity=stability.GRAVITY, threads=a.threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    soil = mpm.MohrCoulombDruckerPrager(
        density=UNIT_WEIGHT / stability.GRAVITY,
        young=YOUNG,
        poisson=POISSON,
        cohesion=COHESION,
        frictionAngle=radians(PHI),
    )
    outline = polygon([(0, 0), (TOE, 0), (CREST, HEIGHT), (0, HEIGHT)])
    zone = polygon([(4, 0), (TOE, 0), (CREST, HEIGHT), (4, HEIGHT)])  # what slides
    geotech.addGround(scene, "soil", outline, zone, soil, a.types, fbar=not a.noFbar)
    return scene


def run(a):
    """Finds the factor of safety; returns (summary, what was found)."""
    summary, found = stability.find(a, lambda: build(a), BETWEEN)
    return summary | {"reference": PUBLISHED}, found


def draw(a, found, file):
    if found:
        found.plot(file, {f"Griffiths & Lane 1999: {PUBLISHED}": (PUBLISHED - 0.005, PUBLISHED + 0.005)})


def tell(a, s):
    return stability.tell(a, s, f"Griffiths & Lane: {PUBLISHED}")


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
