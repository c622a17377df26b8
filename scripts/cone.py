#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A cone (CPT) is pressed into undrained clay, axisymmetric: N_kt beside Lu et al. 2004.

A cone of 60 degrees and the radius R in Tresca soil of the strength su and the rigidity index Ir = G/su,
under its own weight, horizontal stress by Delta = (sigma_v - sigma_h)/(2 su), interface strength alpha su.
Starts deep, in a hole of its shape, and goes on until its resistance is level:
N_kt = (q - sigma_v)/su = 3.4 + 1.6 ln Ir - 1.9 Delta + 1.3 alpha (finite elements with remeshing).

Units: Mg, m, s, kPa; forces are of the whole circumference, kN.

    scripts/run cone                            # smooth, Ir = 100
    scripts/run cone --rigidity 300 --alpha 1
"""

from math import ceil, log, pi, radians, tan

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import DENSITY, POISSON, STRENGTH

RADIUS, GRAVITY = 0.4, 10.0  # m, R; m/s2
WIDE, BELOW = 40, 24  # of the ground, and below the tip at the end, R: with 8 it resists 2 % more
EVEN = 6  # R, from the axis: cells are equal up to there
START = 6  # R, depth of the tip at the start
RAMP = 0.02  # m, over which the rate grows from zero
BLUNT = 0.15  # R, radius that the tip is cut at: domains have four corners
SLOPE = tan(radians(30))  # of the face to the axis

PARAMETERS = mpm.Parameters(
    "cone",
    __doc__,
    Parameter("rigidity", 100.0, "shear modulus over strength of the clay", above=1),
    Parameter("alpha", 0.0, "strength of the cone's interface over that of the clay", least=0, most=1),
    Parameter("delta", 0.0, "(sigma_v - sigma_h)/(2 su) at rest", least=-0.9, most=0.9),
    Parameter("cells", 4, "per radius", least=3, whole=True),
    Parameter("way", 4.0, "of the cone", unit="R", above=0.5),
    Parameter("rate", 0.4, "of the cone", unit="m/s", above=0),
    reference.FBAR,
    Parameter("constraints", "auto", "as of Contact", choices=("auto", "nodes", "facets")),
    smoke={"cells": 3, "way": 1.0},
)
arguments = PARAMETERS.parse


def exact(a):
    """N_kt of Lu et al. 2004, Geotechnique 54, 4."""
    return 3.4 + 1.6 * log(a.rigidity) - 1.9 * a.delta + 1.3 * a.alpha


def shape(a, cell, top):
    """Mesh of the cone with its shaft up to a height, and the hole that it stands in."""
    blunt, tip = BLUNT * RADIUS, -START * RADIUS
    shoulder = tip + (RADIUS - blunt) / SLOPE
    face, shaft = max(2, round(2 * (shoulder - tip) / cell)), ceil(2 * (top - cell - shoulder) / cell)
    heights = np.r_[np.linspace(tip, shoulder, face + 1), np.linspace(shoulder, top - cell, shaft + 1)[1:]]
    radii = np.where(heights < shoulder, blunt + (heights - tip) * SLOPE, RADIUS)
    x = np.linspace(0, 1, a.cells + 1) * radii[:, None]
    gap = 0.2 * cell  # boxes are cut to the hole by their quarters
    edge = (RADIUS, shoulder - gap / SLOPE)
    hole = [(-cell, tip), (blunt + gap, tip), edge, (RADIUS, top), (-cell, top)]
    return geotech.quadrilaterals(x, np.repeat(heights[:, None], a.cells + 1, axis=1)), mpm.polygon(hole)


def emptyScene(a, wide):
    """The scene without bodies, the cell at the cone, depth and height, m. wide : of the ground, R."""
    cell = RADIUS / a.cells
    deep, top = ceil((START + a.way + BELOW) * a.cells) * cell, ceil((a.way + 2) * a.cells) * cell
    even = mpm.Grading(((0, -deep), (EVEN * RADIUS, top)), largest=2 * RADIUS)
    size = (0, -deep), (wide * RADIUS, top)
    return mpm.Scene(*size, cell, grading=even, axisymmetric=True, threads=a.threads), cell, deep, top


def build(a):
    """The scene: the cone in its hole, stress at rest (without output)."""
    scene, cell, deep, top = emptyScene(a, WIDE)
    shear = a.rigidity * STRENGTH
    lame = 2 * shear * POISSON / (1 - 2 * POISSON), shear
    clay = mpm.Tresca(density=DENSITY, lame=lame, undrainedStrength=STRENGTH)
    mesh, hole = shape(a, cell, top)
    ground = box((0, -deep), (WIDE * RADIUS, 0))
    zone = box((0, -ceil((START + a.way + 3) * a.cells) * cell), (3 * RADIUS, 0))
    near = scene.add(
        "soil", zone - hole, clay, mpm.UGIMP(perCell=2, splitAt=1.3), group="soil", fbar=not a.noFbar
    )
    scene.add("far soil", ground - zone, clay, mpm.APDI(matched=near), group="soil", fbar=not a.noFbar)
    soils, depth = list(scene.bodies), (START + 0.5 * a.way) * RADIUS
    K0 = 1 - 2 * a.delta * STRENGTH / (DENSITY * GRAVITY * depth)
    walls = dict(gravity=(0, -GRAVITY), damping=0.05, roller=("left", "right"), fixed="bottom")
    reference.drive(scene, "cone", mesh, a, RAMP, adhesion=a.alpha * STRENGTH, **walls)
    scene.initialStress(surface=0.0, K0=K0, gravity=GRAVITY, bodies=soils)
    return scene


def shaftForce(scene):
    """On the shaft upwards, from a cell above the shoulder on, in the last step, kN."""
    contact = next(e for e in scene.engines if isinstance(e, mpm.Contact)).contactTable()
    height = contact["node"][:, 1] - scene["cone"].vertices[:, 1].min()
    sign = np.where(contact["second"] == "cone", 1, -1)
    return float((sign * contact["force"][:, 1])[height > RADIUS / SLOPE + RADIUS / 3].sum())


def run(a, scene=None):
    """Presses the cone in; returns (summary, scene, way over R, N)."""
    scene = scene or build(a)
    columns = {"shaft": shaftForce}
    summary, way, force, history = reference.press(a, scene, a.way * RADIUS, RAMP, columns)
    weight = GRAVITY * scene["cone"].mass.sum()
    depth = START * RADIUS + way - 2 / 3 * RADIUS / SLOPE  # mean one of the face
    shaft = 2 * pi * RADIUS * STRENGTH * (START * RADIUS + way - RADIUS / SLOPE)  # where alpha is 1
    factor = ((force + weight - a.alpha * shaft) / (pi * RADIUS**2) - DENSITY * GRAVITY * depth) / STRENGTH
    late = way > 0.75 * way[-1]
    earlier = (way > 0.5 * way[-1]) & ~late
    summary |= {
        "factor": float(factor[late].mean()),
        "exact": exact(a),
        "error": float(factor[late].mean() / exact(a) - 1),
        "rise": float(factor[late].mean() / factor[earlier].mean() - 1),
        "onShaft": float((history["shaft"] / shaft)[late].mean()),
        "scatter": float(factor[late].std() / factor[late].mean()),
    }
    return summary, scene, way / RADIUS, factor


def draw(a, scene, way, factor, file):
    """Plastic strain round the cone, and N_kt over its penetration."""

    def field(axes):
        plot.domains(axes, scene.bodies, reference.strain, (0, 2), "plastic shear strain", scale=RADIUS)

    bottom = -START - a.way - 4
    window = dict(xlim=(0, 6), ylim=(bottom, bottom + 9), xlabel="r / R", ylabel="z / R")
    lines = {"Lu et al. 2004": (way, np.full(len(way), exact(a)))}
    labels = "penetration of the cone / R", "N_kt"
    reference.compare(file, field, (way[1:], factor[1:]), lines, labels, window, mean=1 / a.cells)


def tell(a, s):
    return (
        f"N_kt = {s['factor']:.2f} over the last quarter of the way ({s['error']:+.1%} of {s['exact']:.2f}), "
        f"{s['rise']:+.1%} against the quarter before, scatter {s['scatter']:.1%}"
    )


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
