#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A vertical cut fails: its factor of safety by strength reduction beside limit analysis.

Plane strain, the soil of the sheet pile: c = 8.5 kPa, phi = 30 degrees, psi = 0, gamma = 15 kN/m3. A cut of
the height H stands up to

    gamma H / c = N tan(45 + phi/2),   N = 3.77 to 3.83

(lower bound: Pastor, Thai & Francescato 2000; upper bound: a log-spiral, Chen 1975, taken at phi = 0): 3.70
to 3.76 m here. With the strength divided by a factor the critical height falls; the factor at which it is H
is the reference. The theorems are for psi = phi; soil of psi = 0 may be a little weaker. Gravity grows from
zero in every trial. Without F-bar soil locks and stands too high (`--noFbar`).

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run cut                         # hybrid, H = 3 m, cells of 0.25 m
    scripts/run cut --types ugimp --noFbar
    scripts/run cut --height 4 --factor 1   # does a cut of 4 m stand?
"""

from math import atan, pi, radians, tan

import yade_mpm as mpm
from scipy.optimize import brentq
from yade_mpm import Parameter, app, box, geotech
from yade_mpm.geotech import reference, stability

COHESION, PHI, DENSITY, LAME = 8.5, 30.0, 1.53, (9.48e3, 6.31e3)  # kPa, degrees, Mg/m3, kPa
NUMBERS = 3.77, 3.83  # of stability: lower and upper bound
BASE, BEHIND, BEFORE = 1.0, 1.5, 1.0  # m; heights: of ground below the toe, behind and before the face
ENOUGH = 12  # cells in the height, from which on the factor is at most 7 % too high
BETWEEN = 0.6, 1.6  # of the reference

PARAMETERS = mpm.Parameters(
    "cut",
    __doc__,
    Parameter("height", 3.0, "of the cut", unit="m", least=1, most=8),
    Parameter("cell", 0.25, "size of the grid's cells", unit="m", partOf=1.0),
    *stability.PARAMETERS,
    smoke={"cell": 0.5, "within": 0.05},
    check=lambda a, given: (
        None
        if app.isWhole(a.height / a.cell)
        else f"--height {a.height:g} with --cell {a.cell:g} is not allowed; give a whole number of cells"
    ),
)
arguments = PARAMETERS.parse


def criticalHeight(factor, number):
    """Height at which soil of a strength divided by a factor fails, m, by a number of stability."""
    angle = atan(tan(radians(PHI)) / factor)
    return number * COHESION / factor * tan(pi / 4 + angle / 2) / (DENSITY * stability.GRAVITY)


def bounds(height):
    """Factors of safety of a cut between which limit analysis has it."""
    surplus = lambda factor, number: criticalHeight(factor, number) - height  # noqa: E731
    return [brentq(surplus, 0.1, 10.0, args=(number,)) for number in NUMBERS]


def build(a):
    """The cut before gravity."""
    face, end = (round(length * a.height) for length in (BEHIND, BEHIND + BEFORE))
    top = BASE + a.height
    scene = mpm.Scene((0, 0), (end, top + 1), a.cell, gravity=stability.GRAVITY, threads=a.threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    outline = box((0, 0), (end, BASE)) + box((0, BASE), (face, top))
    zone = box((1, 0), (end, BASE)) + box((1, BASE), (face, top))
    geotech.addGround(scene, "soil", outline, zone, soil(), a.types, fbar=not a.noFbar)
    return scene


def soil():
    return mpm.MohrCoulombDruckerPrager(
        density=DENSITY, lame=LAME, cohesion=COHESION, frictionAngle=radians(PHI)
    )


def run(a):
    """Finds the factor of safety; returns (summary, what was found)."""
    limits = bounds(a.height)
    between = [share * limits[0] for share in BETWEEN]
    summary, found = stability.find(a, lambda: build(a), between)
    return summary | {"reference": limits}, found


def draw(a, found, file):
    if found:
        found.plot(file, {"limit analysis": bounds(a.height)})


def tell(a, s):
    reference = "limit analysis: {:.2f} to {:.2f}".format(*s["reference"])
    if a.height < (ENOUGH - 0.5) * a.cell:
        reference += f"; fewer than {ENOUGH} cells in the height stand up to 13 % too long: lower --cell"
    return stability.tell(a, s, reference)


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
