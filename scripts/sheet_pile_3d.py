#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A sheet of finite width is pressed into c-phi soil, in 3D: how far is it from plane strain?

A quarter of the problem, with planes of symmetry through the middle of the sheet. uGIMP particles round the
sheet, which split, APDI domains elsewhere on cells that grow, the sheet implicit with its true inertia, soil
bonded to it. Materials and rate are those of `sheet_pile`, with a limit of dilatancy. The same section in
plane strain is run beside it: a wide sheet feels as much per metre of its width, a narrow one more, for its
ends add to it. Units: Mg, m, s, kPa.

    scripts/run sheet_pile_3d                        # about five minutes on two cores
    scripts/run sheet_pile_3d --cell 0.5             # coarse: a minute
    scripts/run study sheet_pile_3d width=1,2,4,8    # approaches plane strain
    scripts/run sheet_pile_3d --smoke
"""

import os
import time
from math import radians

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.geotech import penetration
from yade_mpm.io import files

EMBEDDED, LENGTH, DEPTH, BESIDE = 1.0, 5.0, 8.0, 9.0  # m: sheet; ground, and how far it reaches beside
ZONE, ZONE_BELOW = 1.0, 1.5  # m: uGIMP zone beside the sheet and below its last tip
GRAVITY, K0 = 9.81, 0.43  # m/s2, -


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if not app.isWhole(0.5 * a.width / a.cell):
        refused = f"--width {a.width:g} with --cell {a.cell:g} is not allowed"
        return f"{refused}; give an even number of cells, e.g. --width {4 * a.cell:g}"
    return None


PARAMETERS = mpm.Parameters(
    "sheet_pile_3d",
    __doc__,
    Parameter("width", 2.0, "of the sheet", unit="m", above=0),
    Parameter("cell", 0.25, "smallest cells, and thickness of the sheet", unit="m", partOf=ZONE),
    Parameter("penetration", 2.0, "beyond the first metre", unit="m", above=0, most=LENGTH - EMBEDDED - 1),
    Parameter("rate", 0.1, "of the sheet", unit="m/s", above=0),
    smoke={"cell": 0.5, "penetration": 0.5, "rate": 0.5},
    derived={"ramp": lambda a: 0.1 / a.rate},  # s: 0.05 m
    check=refusal,
)
arguments = PARAMETERS.parse


def build(a, dim=3):
    """The quarter x, y >= 0 in 3D, or the half of its section y = 0 in plane strain; scene and history."""

    def block(x, y, bottom, top):  # from the planes of symmetry
        return box((0, 0, bottom), (x, y, top)) if dim == 3 else box((0, bottom), (x, top))

    wide, tip, h = a.width / 2, DEPTH - EMBEDDED, a.cell
    zoneBottom = np.floor((tip - a.penetration - ZONE_BELOW) / h) * h
    even = block(ZONE + 2 * h, wide + ZONE + 2 * h, zoneBottom - 2 * h, DEPTH + LENGTH)
    corners = block(ZONE + BESIDE, wide + BESIDE, 0, DEPTH + LENGTH).bounds()
    grading = mpm.Grading(even)
    scene = mpm.Scene(*corners, h, threads=a.threads, grading=grading, gravity=GRAVITY, damping=0.05)
    angles = dict(frictionAngle=radians(30), dilatancyAngle=radians(10), dilatancyLimit=0.05)
    sand = mpm.MohrCoulombDruckerPrager(density=1.53, lame=(9.48e3, 6.31e3), cohesion=8.5, **angles)
    sheet = block(h / 2, wide, tip, tip + LENGTH)
    soil = block(ZONE + BESIDE, wide + BESIDE, 0, DEPTH) - sheet
    zone = block(ZONE, wide + ZONE, zoneBottom, DEPTH) - sheet
    geotech.addGround(scene, "soil", soil, zone, sand, "hybrid", splitAt=1.3, fbar=False)
    steel = mpm.LinearElastic(density=7.85, lame=(4.20e7, 2.80e7))
    pile = scene.add("sheet", sheet, steel, mpm.UGIMP(perCell=(4, 2, 2)[:dim]), implicit=True)
    scene.initialStress(surface=DEPTH, K0=K0)
    down = np.array((0, 0, -1))[-dim:]
    scene.drive(pile.above(DEPTH), a.rate * down, a.ramp, name="drive", byHeight=True)
    scene.roller(*("left", "right", "front", "back")[: 2 * (dim - 1)])
    scene.fix("bottom")
    return scene, scene.history(every=a.penetration / a.rate / 400)


def press(a, dim=3):
    """Runs a scene; returns it with the depth, m, and the resistance per metre of the sheet's width, kN/m."""
    scene, history = build(a, dim)
    scene.run(until=a.penetration / a.rate + 0.5 * a.ramp)
    depth, _, force = penetration.resistance(history, scene["sheet"], a.rate, a.ramp, GRAVITY, a.cell)
    return scene, depth, force * (4 / a.width if dim == 3 else 2)


def drawSection(ax, scene, axis, at):
    """Draws the domains that the plane at a place on an axis cuts; returns those of the soil."""
    for body in reversed(scene.bodies):  # soil last
        lower, upper = body.corners().min(axis=1), body.corners().max(axis=1)
        cut = (lower[:, axis] <= at) & (at < upper[:, axis])
        (left, bottom), (right, top) = (np.delete(x[cut], axis, axis=1).T for x in (lower, upper))
        corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top]]).transpose(2, 0, 1)
        strain = None if body.name == "sheet" else body.plasticShearStrain[cut]
        drawn = plot.drawDomains(ax, corners, strain, True, "inferno_r", (0, 1))
    return drawn


def draw(a, scene, curves):
    """The two sections through the middle of the sheet, and resistance over depth."""
    figure, axes = plot.plt.subplots(1, 3, figsize=(10, 4), layout="constrained")
    for ax, axis, name in zip(axes, (1, 0), "xy"):
        drawn = drawSection(ax, scene, axis, 0.2 * a.cell)
        ax.set(xlabel=f"{name} (m)", xlim=(0, a.width / 2 + 2), ylim=(DEPTH - 5, DEPTH + 1), aspect="equal")
    plot.colourBar(list(axes[:2]), drawn, "plastic shear strain (-)", extend="max")
    for (depth, force), label in zip(curves, (f"sheet {a.width:g} m wide", "plane strain")):
        axes[2].plot(force, depth, label=label)
    axes[0].set(ylabel="z (m)")
    axes[2].set(xlabel="resistance per width (kN/m)", ylabel="penetration (m)")
    axes[2].set(xlim=(0, None), ylim=(a.penetration, 0))
    axes[2].legend()
    plot.save(figure, f"{a.out}/sheet_pile_3d.png")


def run(a):
    """Both runs; returns (summary, scene in 3D)."""
    os.makedirs(a.out, exist_ok=True)
    began, (scene, *wide) = time.monotonic(), press(a)
    summary, (_, *plane) = app.record(a, scene, time.monotonic() - began), press(a, dim=2)
    draw(a, scene, (wide, plane))
    summary["resistance"], summary["planeStrain"] = (geotech.atSteps(*curve) for curve in (wide, plane))
    summary["ratio"] = {d: r / summary["planeStrain"][d] for d, r in summary["resistance"].items()}
    files.saveJson(f"{a.out}/summary.json", summary)
    return summary, scene


def main():
    s = run(arguments())[0]
    print(f"{s['particles']} particles, {s['steps']} steps in {s['wallSeconds']:.0f} s")
    for depth, ratio in s["ratio"].items():
        print(f"{depth} m: {s['resistance'][depth]:.0f} kN/m of width, {ratio:.2f} times plane strain")


if __name__ == "__main__":
    app.run(main)
