#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Collapse of a column of aluminium bars.

Bars of a few millimetres, 0.2 m wide and 0.1 m high between a smooth wall and a gate, run out over a rough
floor when the gate is pulled at once. phi = 19.8 degrees, c = 0, psi = 0, E = 5.84 MPa, nu = 0.3,
rho = 2.04 Mg/m3, 0.8 s. Experiment: Bui, Fukagawa, Sako & Ohno 2008, Int. J. Numer. Anal. Meth. Geomech. 32,
1537-1570. Reported: run-out over the initial width (to where 99 % of the mass lies behind), length of the top
surface that has not moved, slope of the deposit; all uGIMP, hybrid with APDI domains where nothing flows, or
APDI whose distorted domains become boxes.

The published form is the bare one, `--noFbar --noClosing`: bars that part and meet again keep the volume
gained between, since the material is cohesionless and takes no tension. Its deposit is too loose, and the
automatic time step falls with it. With F-bar and closing, the default, the volume stays, and the deposit of
a higher column (`--height`) is as high as measured: H over its final height is 1.42 (H/L)^(2/3) above H/L =
0.65, L the width (bars of aluminium, Nguyen, Bui & Fukagawa 2015, arXiv 1512.05180).

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run column_collapse
    scripts/run column_collapse --types hybrid --smoke
    scripts/run column_collapse --height 0.4 --cell 0.01
    scripts/run column_collapse --noFbar --noClosing   # the published form
    scripts/run column_collapse_compare          # both types and two cell sizes
"""

import os
import time
from math import atan, ceil, degrees, radians, sqrt

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, plot
from yade_mpm.io import files

WIDTH, UNTIL = 0.2, 0.8  # m; s, of a column of 0.1 m
YOUNG, POISSON, DENSITY = 5840.0, 0.3, 2.04  # kPa, -, Mg/m3
GRAVITY, K0 = 9.81, 0.6
STILL = ((0, 0.08, 0.06), (0.08, 0.12, 0.04), (0.12, 0.14, 0.02))  # m: from, to, height; meshed in the hybrid
MOVED = 1e-3  # m: less is unmoved


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    if a.types == "hybrid" and not app.isWhole(0.02 / a.cell):
        return f"--cell {a.cell:g} with --types hybrid is not allowed; give 0.02 m divided by a whole number"
    if not app.isWhole(a.height / a.cell):
        return f"--height {a.height:g} with --cell {a.cell:g} is not allowed; give a whole number of cells"
    return None


def floorOf(a):
    """Length of the floor, m: whole cells, far enough for single bars."""
    return a.cell * round(max(0.8, 7 * a.height) / a.cell)


PARAMETERS = mpm.Parameters(
    "column_collapse",
    __doc__,
    Parameter("types", "ugimp", "particle types", choices=("ugimp", "hybrid", "apdi")),
    Parameter("height", 0.1, "of the column", unit="m", least=0.1, most=1),
    Parameter("phi", 19.8, "angle of friction", unit="degrees", above=0, below=90),
    Parameter("noFbar", False, "without F-bar: bars that flow lock"),
    Parameter("noClosing", False, "bars that parted resist pressure again before they have closed up"),
    Parameter("cell", 0.005, "size of the grid's cells; hybrid: 0.02 m over one", unit="m", partOf=0.04),
    Parameter("damping", 0.05, "local damping", least=0, below=1),
    Parameter("until", lambda a: UNTIL * sqrt(a.height / 0.1), "end", unit="s", least=0.05, most=100),
    smoke={"cell": 0.01},
    derived={"floor": floorOf, "fbar": lambda a: not a.noFbar, "closing": lambda a: not a.noClosing},
    check=refusal,
)
arguments = PARAMETERS.parse


def build(a):
    """The scene: the column at rest, the gate just gone (without output)."""
    top = a.cell * ceil(1.2 * a.height / a.cell - 1e-9)
    scene = mpm.Scene(lower=(0, 0), upper=(a.floor, top), cell=a.cell, threads=a.threads)
    scene.gravity, scene.damping = GRAVITY, a.damping
    scene.fix("bottom")
    scene.roller("left")
    bars = mpm.MohrCoulombDruckerPrager(
        density=DENSITY,
        young=YOUNG,
        poisson=POISSON,
        cohesion=0.0,
        frictionAngle=radians(a.phi),
        dilatancyAngle=0.0,
        closing=a.closing,
    )
    column, boxes = box((0, 0), (WIDTH, a.height)), mpm.UGIMP(perCell=2)
    if a.types == "ugimp":
        scene.add("bars", column, bars, boxes, fbar=a.fbar)
    elif a.types == "apdi":
        scene.add("bars", column, bars, mpm.APDI(size=a.cell / 2, onDistortion="convert"), fbar=a.fbar)
    else:
        steps = (box((left, 0), (right, top)) for left, right, top in STILL[1:])
        still = sum(steps, box((0, 0), STILL[0][1:]))
        moving = scene.add("moving bars", column - still, bars, boxes, fbar=a.fbar)
        scene.add("still bars", column & still, bars, mpm.APDI(size=a.cell, matched=moving), fbar=a.fbar)
    scene.initialStress(surface=a.height, K0=K0, gravity=GRAVITY)
    return scene


def run(a):
    """Lets the column fall; returns (summary, scene, snapshots)."""
    began, scene = time.monotonic(), build(a)
    snapshots = plot.Snapshots("plasticShearStrain")
    for moment in (0.1, 0.2, 0.4, a.until):
        if moment > scene.time and moment <= a.until:
            scene.run(until=moment)
            snapshots(scene)
    front, unmoved = frontOf(scene), unmovedTop(scene, a.height)
    x, y = surfaceOf(scene, a.floor)
    slope = (x > unmoved + 0.02) & (y > 0.1 * a.height)
    centre = sum(b.mass @ b.position[:, 0] for b in scene.bodies) / mpm.diagnostics.mass(scene)
    return (
        {
            **app.record(a, scene, time.monotonic() - began),
            "front": front,
            "runout": (front - WIDTH) / WIDTH,
            "unmovedTop": unmoved,
            "slopeDegrees": degrees(atan(-np.polyfit(x[slope], y[slope], 1)[0])),
            "heightAtWall": float(y[x < 0.02].mean()),
            "heightRatio": a.height / topOf(scene),
            "volumeGain": sum(b.bulkVolume.sum() for b in scene.bodies)
            / sum(b.initialVolume.sum() for b in scene.bodies)
            - 1,
            "kineticEnergy": mpm.diagnostics.kineticEnergy(scene),
            "centre": float(centre),
        },
        scene,
        snapshots,
    )


def frontOf(scene, share=0.99):
    """Where 99 % of the mass lies behind, m: single bars that roll on do not count."""
    x = np.concatenate([b.position[:, 0] for b in scene.bodies])
    mass = np.concatenate([b.mass for b in scene.bodies])
    order = np.argsort(x)
    behind = np.cumsum(mass[order])
    return float(np.interp(share * behind[-1], behind, x[order]))


def topOf(scene):
    """The highest point of the deposit, m."""
    return float(max(body.corners()[:, :, 1].max() for body in scene.bodies if body.count))


def surfaceOf(scene, floor, slice_=0.02):
    """Centres of vertical slices, m, and height of the deposit there as its mass over that of the width,
    m."""
    edges = np.arange(0, floor + slice_ / 2, slice_)
    area = np.zeros(len(edges) - 1)
    for body in scene.bodies:
        x = body.corners()[:, :, 0]
        left, right = x.min(axis=1), x.max(axis=1)
        for k in range(len(area)):
            overlap = np.clip(np.minimum(right, edges[k + 1]) - np.maximum(left, edges[k]), 0, None) / (
                right - left
            )
            area[k] += (overlap * body.initialVolume).sum()
    return 0.5 * (edges[1:] + edges[:-1]), area / slice_


def unmovedTop(scene, height):
    """Length of the top surface, from the wall, that moved less than a millimetre, m."""
    x, moved = [], []
    for body in scene.bodies:
        top = body.reference[:, 1] > height - min(scene.cell)
        x.append(body.reference[top, 0])
        moved.append(np.linalg.norm(body.displacement[top], axis=1))
    x, moved = np.concatenate(x), np.concatenate(moved)
    return float(x[moved > MOVED].min())


def draw(a, front, snapshots, file):
    """The column as it runs out; dashed: before."""
    titles, window = [f"{s.time:.2g} s" for s in snapshots], (0, max(0.5, 1.1 * front), 0, 1.1 * a.height)
    figure, _ = plot.panels(snapshots, titles, 2.0, "plastic shear strain (-)", window, vertical=True)
    for axes in figure.axes[: len(snapshots)]:
        axes.plot([0, WIDTH, WIDTH], [a.height, a.height, 0], "k--", lw=0.6)
    plot.save(figure, file)


def tell(a, s):
    """Prints what came out."""
    shape = f"unmoved top {s['unmovedTop']:.3f} m, slope {s['slopeDegrees']:.1f} degrees, "
    shape += f"H over its final height {s['heightRatio']:.2f}, volume {s['volumeGain']:+.1%}"
    print(f"{a.types}, cell {1e3 * a.cell:g} mm: run-out {s['runout']:.3f} of the width, {shape}", flush=True)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summary, _, snapshots = run(a)
    tell(a, summary)
    draw(a, summary["front"], snapshots, os.path.join(a.out, "column_collapse.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summary)


if __name__ == "__main__":
    app.run(main)
