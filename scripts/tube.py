#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A tube is pressed into clay: a caisson, an open pile that plugs, and a closed pile.

Axisymmetric: a tube of the outer radius R goes down from the surface of Tresca soil of the strength su under
its own weight. Both sides of the wall resist alpha su, the tip N su and the overburden, with N = 9:

    F = alpha su (As outside + As inside) + (9 su + gamma z) A of the wall

(Houlsby & Byrne 2005, Proc. ICE Geotech. Eng. 158, 2, for caissons). When the friction inside is more than
the whole base resists, 2 alpha h/r > 9 (h: length of the soil inside, r: inner radius), the plug goes down
with the tube, which then resists as a closed pile: N = 9 on the whole base (Skempton 1951). The walls are
thicker than real ones, four cells: with two, a smooth wall of R/4 resists 23 % more. Suction is not in the
scene: the tube is pushed.

Units: Mg, m, s, kPa; forces are of the whole circumference, kN.

    scripts/run tube                            # caisson
    scripts/run tube --kind open                # pile; --kind closed
"""

from math import ceil, pi

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import DENSITY, STRENGTH

RADIUS, GRAVITY = 1.0, 10.0  # m, R; m/s2
RIGIDITY, POISSON = 100.0, 0.45  # G/su; the clay is compressed by half a per cent at most
WIDE, NEAR, BELOW, UNDER = 10, 2.5, 5, 2  # R: the ground, boxes; below the tip at the end, boxes
RAMP = 0.02  # m, over which the rate grows from zero
BEARING = 9.0  # N of a deep tip
KINDS = {"caisson": (1 / 6, 2.0, 24, 0.5), "open": (1 / 3, 5.0, 12, 1.0), "closed": (1.0, 4.0, 6, 0.5)}


def wallOf(a):
    """Thickness over R; coarse cells take a thicker wall, two of them."""
    wall = KINDS[a.kind][0]
    return max(wall, 0.5) if a.smoke else wall


PARAMETERS = mpm.Parameters(
    "tube",
    __doc__,
    Parameter("kind", "caisson", "of the tube", choices=tuple(KINDS)),
    Parameter("wall", wallOf, "its thickness, of the kind", unit="R", above=0, most=1),
    Parameter("depth", lambda a: KINDS[a.kind][1], "of the tip at the end, of the kind", unit="R", above=0.5),
    Parameter("cells", lambda a: KINDS[a.kind][2], "per radius, of the kind", least=4, whole=True),
    Parameter("alpha", lambda a: KINDS[a.kind][3], "strength of the interface, of the kind", least=0, most=1),
    Parameter("rate", 0.5, "of the tube", unit="m/s", above=0),
    reference.FBAR,
    reference.CONSTRAINTS,
    smoke={"cells": 4, "depth": 1.0},
)
arguments = PARAMETERS.parse


def startOf(a):
    """Depth of the tip at the start, m: two cells."""
    return 2 * RADIUS / a.cells


def build(a):
    """The scene: the tube stands in a slot, stress at rest (without output)."""
    cell, inner = RADIUS / a.cells, (1 - a.wall) * RADIUS
    deep, top = ceil((a.depth + BELOW) * a.cells) * cell, ceil(a.depth * a.cells + 2) * cell
    boxes = ceil((a.depth + UNDER) * a.cells) * cell
    even = mpm.Grading(((0, -boxes - RADIUS), (NEAR * RADIUS + RADIUS, top)), largest=RADIUS)
    size = (0, -deep), (WIDE * RADIUS, top)
    scene = mpm.Scene(*size, cell, grading=even, axisymmetric=True, threads=a.threads)
    shear = RIGIDITY * STRENGTH
    lame = 2 * shear * POISSON / (1 - 2 * POISSON), shear
    clay = mpm.Tresca(density=DENSITY, lame=lame, undrainedStrength=STRENGTH)
    ground, zone = box((0, -deep), (WIDE * RADIUS, 0)), box((0, -boxes), (NEAR * RADIUS, 0))
    slot = box((inner if inner else -cell, -startOf(a)), (RADIUS, cell))
    soil = scene.add(
        "soil", zone - slot, clay, mpm.UGIMP(perCell=2, splitAt=1.3), group="soil", fbar=not a.noFbar
    )
    scene.add("far soil", ground - zone, clay, mpm.APDI(matched=soil), group="soil", fbar=not a.noFbar)
    soils = list(scene.bodies)
    r = np.linspace(inner, RADIUS, ceil(a.wall * a.cells) + 2)
    y = np.linspace(-startOf(a), a.depth * RADIUS, ceil(2 * (a.depth * a.cells + 2)) + 1)[:, None]
    mesh = geotech.quadrilaterals(np.broadcast_to(r, (len(y), len(r))), np.broadcast_to(y, (len(y), len(r))))
    walls = dict(gravity=(0, -GRAVITY), damping=0.05, roller=("left", "right"), fixed="bottom")
    reference.drive(scene, "tube", mesh, a, RAMP, adhesion=a.alpha * STRENGTH, **walls)
    scene.initialStress(surface=0.0, K0=1.0, gravity=GRAVITY, bodies=soils)
    return scene


def plugOf(a):
    """Function of a scene: mean height of the ground inside of the tube, m; 0 in a closed one."""

    def height(scene):
        r, y = scene["soil"].position.T
        size, inner = RADIUS / a.cells, (1 - a.wall) * RADIUS
        columns = np.floor(r / size).astype(int)
        tops = [y[columns == k].max() for k in range(max(1, round(inner / size) - 1)) if (columns == k).any()]
        return float(np.mean(tops)) + 0.25 * size if inner else 0.0

    return height


def formula(a, depth, plug):
    """Resistance by the formula, kN, where the soil inside has a length: (the wall alone, with a plug)."""
    inner, resists = (1 - a.wall) * RADIUS, BEARING * STRENGTH + DENSITY * GRAVITY * depth
    shafts = 2 * pi * a.alpha * STRENGTH * np.array([RADIUS * depth, inner * plug])
    wall = shafts.sum(axis=0) + resists * pi * (RADIUS**2 - inner**2)
    return wall, shafts[0] + resists * pi * RADIUS**2


def run(a, scene=None):
    """Presses the tube in; returns (summary, scene, depth over R, forces over su R2: found, of the wall alone
    and with a plug, length of the soil inside over R)."""
    scene = scene or build(a)
    way = a.depth * RADIUS - startOf(a)
    summary, way, force, history = reference.press(a, scene, way, RAMP, {"plug": plugOf(a)})
    depth = startOf(a) + way
    plug = depth + np.asarray(history["plug"])
    found = force + GRAVITY * scene["tube"].mass.sum()
    wall, plugged = formula(a, depth, plug)
    late, exact = depth > 0.85 * depth[-1], np.minimum(wall, plugged)
    summary |= {
        "force": float(found[late].mean()),
        "exact": float(exact[late].mean()),
        "error": float(found[late].mean() / exact[late].mean() - 1),
        "inside": float(plug[-1] / depth[-1]),
        "filling": float(np.polyfit(depth[late], plug[late], 1)[0]),
    }
    scale = STRENGTH * RADIUS**2
    return summary, scene, depth / RADIUS, found / scale, wall / scale, plugged / scale, plug / RADIUS


def draw(a, scene, depth, force, wall, plugged, plug, file):
    """Plastic strain round the tube, and resistance over depth."""

    def field(axes):
        plot.domains(axes, scene.bodies, reference.strain, (0, 2), "plastic shear strain", scale=RADIUS)

    window = dict(xlim=(0, 2.5), ylim=(-a.depth - 1.5, 1), xlabel="r / R", ylabel="z / R")
    lines = {"formula, wall and both shafts": (depth, wall), "formula, plugged": (depth, plugged)}
    labels = "depth / R", "resistance / (su R2)"
    reference.compare(file, field, (depth[1:], force[1:]), lines, labels, window, mean=1 / a.cells)


def tell(a, s):
    inside = f"; soil inside: {s['inside']:.2f} of the depth, {s['filling']:.2f} of the last of the way"
    return f"{s['force']:.0f} kN ({s['error']:+.1%} of {s['exact']:.0f})" + (inside if a.wall < 1 else "")


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
