#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A sheet pile is pressed into undrained clay: tip and shaft apart, each against what plasticity says.

Plane strain, the half right of the pile's axis: a stiff pile of the thickness B with a flat tip, in Tresca
soil of the strength su under its own weight. The shaft resists alpha su over the length L in contact, heave
included, on each side. The tip resists N su B besides the overburden. N grows from 2 + pi at the surface to
2 + 2 pi = 8.28 far below it, where the slip lines turn by pi from under the tip to the smooth shaft (Meyerhof
1951); in between limit analysis gave (2 + pi)(1 + 0.27 sqrt(z/B)) (Salgado et al. 2004), beyond it far down.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run clay_pile                    # smooth shaft: the tip alone, 6 B deep
    scripts/run clay_pile --alpha 0.5
"""

from math import ceil, pi

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.reference import DENSITY, STRENGTH

THICKNESS, GRAVITY = 0.8, 10.0  # m, B; m/s2
HALF, BELOW = 5, 4  # width of the half and depth of the soil below the tip at the end, B
START = 1  # B, depth of the tip at the start
RAMP = 0.02  # m, over which the rate grows from zero
WATCHED = 10  # steps between two looks at contact

PARAMETERS = mpm.Parameters(
    "clay_pile",
    __doc__,
    Parameter("alpha", 0.0, "strength of the shaft's interface over that of the soil", least=0, most=1),
    Parameter("cells", 8, "per thickness", least=4, whole=True),
    Parameter("depth", 6.0, "of the tip at the end, thicknesses", above=START, most=12),
    Parameter("rate", 0.2, "of the pile", unit="m/s", above=0),
    reference.FBAR,
    Parameter("constraints", "nodes", "as of Contact", choices=("nodes", "facets")),
    smoke={"cells": 4, "depth": 3.5, "rate": 0.4},
    check=lambda a, given: f"--cells {a.cells} is not allowed; give an even number" if a.cells % 2 else None,
)
arguments = PARAMETERS.parse


def salgado(depth):
    """N of a strip at depths over B."""
    return np.minimum((2 + pi) * (1 + 0.27 * np.sqrt(depth)), 2 + 2 * pi)


def build(a):
    """The scene: the pile in a slot of its size, stresses by the weight (without output)."""
    cell = THICKNESS / a.cells
    half, deep = HALF * THICKNESS, ceil((a.depth + BELOW) * a.cells) * cell
    above = ceil(a.depth * a.cells + 2) * cell  # the pile at the start
    scene = mpm.Scene((0, -deep), (half, above), cell, threads=a.threads)
    right, tip = 0.5 * THICKNESS, -START * THICKNESS
    reference.addSoil(scene, box((0, -deep), (half, 0)) - box((0, tip), (right, 0)), a)
    soils = list(scene.bodies)
    x, y = np.meshgrid(
        np.linspace(0, right, a.cells + 1),
        np.linspace(tip, above - cell, 2 * round((above - cell - tip) / cell) + 1),
    )
    walls = dict(gravity=(0, -GRAVITY), damping=0.05, roller=("left", "right"), fixed="bottom")
    reference.drive(
        scene, "pile", geotech.quadrilaterals(x, y), a, RAMP, adhesion=a.alpha * STRENGTH, **walls
    )
    scene.initialStress(surface=0.0, K0=1.0, gravity=GRAVITY, bodies=soils)
    return scene


class Watch:
    """Forces of contact on the pile, kN/m: along its shaft, where normals do not point down, and the
    rest, at its tip; and how much of the shaft is in contact, m."""

    def __init__(self, scene):
        self.contact = next(e for e in scene.engines if isinstance(e, mpm.Contact))
        self.soil, self.cell = scene["soil"], min(scene.cell)
        self.rows = []

    def __call__(self, scene):
        table = self.contact.contactTable()
        isTip = np.abs(table["normal"][:, 1]) > np.sqrt(0.5)
        force, normal = np.where(table["second"] == "pile", 1, -1)[:, None] * table["force"], table["normal"]
        along = force - (force * normal).sum(axis=1)[:, None] * normal
        shaft = along[~isTip, 1].sum()
        touches = ~isTip & np.any(force != 0, axis=1)
        self.rows.append((force[:, 1].sum() - shaft, shaft, table["area"][touches].sum()))

    def means(self, scene):
        """Tip, shaft and length since the last call."""
        rows, self.rows = self.rows, []
        return np.mean(rows, axis=0) if rows else np.zeros(3)

    def surface(self, scene):
        """Height of the soil at the shaft, m."""
        x, y = self.soil.position.T
        return y[np.abs(x - 0.5 * THICKNESS) < self.cell].max() + 0.25 * self.cell


def run(a, scene=None):
    """Presses the pile in; returns (summary, scene, depth of the tip over B, N)."""
    scene = scene or build(a)
    watch = Watch(scene)
    scene.engines.append(mpm.PyRunner(watch, iterPeriod=WATCHED))
    columns = {("tip", "shaft", "touching"): watch.means, "surface": watch.surface}
    way = (a.depth - START) * THICKNESS
    summary, way, force, history = reference.press(a, scene, way, RAMP, columns)
    depth = START * THICKNESS + way
    factor = (2 * history["tip"] / THICKNESS - DENSITY * GRAVITY * depth) / STRENGTH
    length = depth + history["surface"]
    weight = GRAVITY * scene["pile"].mass.sum()
    late, exact = depth > depth[-1] - THICKNESS, salgado(depth / THICKNESS)
    summary |= {
        "tipFactor": float(factor[late].mean()),
        "exactTip": float(exact[late].mean()),
        "tipError": float(factor[late].mean() / exact[late].mean() - 1),
        "errorOfDeepTip": float(factor[late].mean() / (2 + 2 * pi) - 1),
        "shaft": float(history["shaft"][late].mean()),
        "touchingOverLength": float((history["touching"] / length)[late].mean()),
        "contactOverDrive": float(
            (history["tip"] + history["shaft"])[late].mean() / (force + weight)[late].mean()
        ),
    }
    if a.alpha:
        adhesion = a.alpha * STRENGTH * length[late]
        summary["shaftOverAdhesion"] = float((history["shaft"][late] / adhesion).mean())
    return summary, scene, depth / THICKNESS, factor


def draw(a, scene, depth, factor, file):
    """Plastic strain round the pile, and N of the tip over depth."""

    def field(axes):
        plot.domains(axes, scene.bodies, reference.strain, (0, 2), "plastic shear strain", scale=THICKNESS)

    window = dict(xlim=(0, 4), ylim=(-a.depth - 2, 1), xlabel="x / B", ylabel="y / B")
    lines = {"Salgado et al. 2004": (depth, salgado(depth)), "2 + 2π": ([START, depth[-1]], 2 * [2 + 2 * pi])}
    labels = "depth of the tip / B", "N of the tip"
    reference.compare(file, field, (depth[1:], factor[1:]), lines, labels, window, start=START)


def tell(a, s):
    shaft = f"{s['shaft']:.2f} kN/m" + (f", {s['shaftOverAdhesion']:.3f} of alpha su L" if a.alpha else "")
    return (
        f"tip N = {s['tipFactor']:.2f} ({s['tipError']:+.1%} of {s['exactTip']:.2f}, "
        f"{s['errorOfDeepTip']:+.1%} of 2 + 2 pi); shaft {shaft}, {s['touchingOverLength']:.2f} of L touches"
    )


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
