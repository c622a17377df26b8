#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Collapse of a column of aluminium bars.

Bars of a few millimetres, 0.2 m wide and 0.1 m high between a smooth wall and a gate, run out over a rough floor when the gate
is pulled at once. phi = 19.8 degrees, c = 0, psi = 0, E = 5.84 MPa, nu = 0.3, rho = 2.04 Mg/m3, 0.8 s. Experiment: Bui, Fukagawa,
Sako & Ohno 2008, Int. J. Numer. Anal. Meth. Geomech. 32, 1537-1570. Reported: run-out over the initial width (to where 99 % of
the mass lies behind), length of the top surface that has not moved, slope of the deposit; all uGIMP, or hybrid with APDI domains
where nothing flows. Bars that part and meet again keep the volume gained between, since the material is cohesionless and takes no
tension: the thin tail of the deposit is too loose, and the automatic time step falls with it.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run column_collapse
    scripts/run column_collapse --compare        # both types and two cell sizes
    scripts/run column_collapse --smoke
"""

import argparse
import os
import time
from math import atan, degrees, radians

import numpy as np
import yade_mpm as mpm
from yade_mpm import box, commandLine, files, plot
from yade_mpm.commandLine import below, between, partOf

WIDTH, HEIGHT, FLOOR, UNTIL = 0.2, 0.1, 0.8, 0.8  # m, m, m, s
YOUNG, POISSON, DENSITY = 5840.0, 0.3, 2.04  # kPa, -, Mg/m3
FRICTION, GRAVITY, K0 = radians(19.8), 9.81, 0.6
STILL = (
    (0, 0.08, 0.06),
    (0.08, 0.12, 0.04),
    (0.12, 0.14, 0.02),
)  # m: from, to, height; stairs meshed in the hybrid
MOVED = 1e-3  # m: less is unmoved


def arguments(given=None):
    p = commandLine.Parser("column_collapse", __doc__, smoke={"cell": 0.01})
    p.add_argument(
        "--types", choices=("ugimp", "hybrid"), default="ugimp", help="particle types (default %(default)s)"
    )
    p.add_argument(
        "--cell",
        type=partOf(0.04),
        default=0.005,
        help="cell size, m: 0.04 m (hybrid: 0.02 m) over a whole number (default %(default)s)",
    )
    p.add_argument("--damping", type=below(1), default=0.05, help="local damping (default %(default)s)")
    p.add_argument(
        "--until",
        type=between(0.05, 100),
        default=UNTIL,
        help="end, s, from 0.05 on, when it flows (default %(default)s)",
    )
    p.add_argument("--compare", action="store_true", help="uGIMP and hybrid, cells of 10 and 5 mm")
    a = p.parse(given)
    if a.compare:
        p.refuseBeside(given, "--compare", ("types", "cell", "smoke"), "it runs both types with both cells")
    if a.types == "hybrid" and not commandLine.isWhole(0.02 / a.cell):
        p.error(f"--cell {a.cell:g} with --types hybrid is not allowed; give 0.02 over a whole number")
    return a


def build(a):
    """The scene: the column at rest, the gate just gone (without output)."""
    scene = mpm.Scene(lower=(0, 0), upper=(FLOOR, 1.2 * HEIGHT), cell=a.cell, threads=a.threads)
    bars = mpm.MohrCoulombDruckerPrager(
        density=DENSITY,
        young=YOUNG,
        poisson=POISSON,
        cohesion=0.0,
        frictionAngle=FRICTION,
        dilatancyAngle=0.0,
    )
    column = box((0, 0), (WIDTH, HEIGHT))
    if a.types == "ugimp":
        scene.add("bars", column, bars, mpm.UGIMP(perCell=2))
    else:
        still = sum(
            (box((left, 0), (right, top)) for left, right, top in STILL[1:]), box((0, 0), STILL[0][1:])
        )
        moving = scene.add("moving bars", column - still, bars, mpm.UGIMP(perCell=2))
        scene.add("still bars", column & still, bars, mpm.APDI(size=a.cell, matched=moving))
    scene.initialStress(surface=HEIGHT, K0=K0, gravity=GRAVITY)
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(gravity=(0, -GRAVITY), damping=a.damping, roller=("left",), fixed=("bottom",)),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    return scene


def run(a):
    """Lets the column fall; returns (summary, scene, snapshots)."""
    began = time.monotonic()
    scene, snapshots = build(a), []
    for moment in (0.1, 0.2, 0.4, a.until):
        if moment > scene.time and moment <= a.until:
            scene.run(until=moment)
            snapshots.append(plot.Snapshot(scene, "plasticShearStrain"))
    front = frontOf(scene)
    x, y = surfaceOf(scene)
    slope = np.polyfit(*[v[(x > unmovedTop(scene) + 0.02) & (y > 0.1 * HEIGHT)] for v in (x, y)], 1)[0]
    return (
        {
            "arguments": vars(a),
            "particles": {b.name: b.count for b in scene.bodies},
            "steps": scene.steps,
            "wallSeconds": time.monotonic() - began,
            "front": front,
            "runout": (front - WIDTH) / WIDTH,
            "unmovedTop": unmovedTop(scene),
            "slopeDegrees": degrees(atan(-slope)),
            "heightAtWall": float(y[x < 0.02].mean()),
            "kineticEnergy": mpm.diagnostics.kineticEnergy(scene),
            "centre": float(
                sum(b.mass @ b.position[:, 0] for b in scene.bodies) / mpm.diagnostics.mass(scene)
            ),
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


def surfaceOf(scene, slice_=0.02):
    """Centres of vertical slices, m, and height of the deposit there as its mass over that of the width, m."""
    edges = np.arange(0, FLOOR + slice_ / 2, slice_)
    area = np.zeros(len(edges) - 1)
    for body in scene.bodies:
        corners = body.corners()
        left, right = corners[:, :, 0].min(axis=1), corners[:, :, 0].max(axis=1)
        for k in range(len(area)):
            overlap = np.clip(np.minimum(right, edges[k + 1]) - np.maximum(left, edges[k]), 0, None) / (
                right - left
            )
            area[k] += (overlap * body.initialVolume).sum()
    return 0.5 * (edges[1:] + edges[:-1]), area / slice_


def unmovedTop(scene):
    """Length of the top surface, from the wall, that moved less than a millimetre, m."""
    x, moved = [], []
    for body in scene.bodies:
        top = body.reference[:, 1] > HEIGHT - min(scene.cell)
        x.append(body.reference[top, 0])
        moved.append(np.linalg.norm(body.displacement[top], axis=1))
    x, moved = np.concatenate(x), np.concatenate(moved)
    return float(x[moved > MOVED].min())


def draw(scene, snapshots, file):
    figure, axes = plot.plt.subplots(
        len(snapshots),
        1,
        figsize=(7, 1.6 * len(snapshots) + 0.6),
        sharex=True,
        squeeze=False,
        layout="constrained",
    )
    for ax, snapshot in zip(axes[:, 0], snapshots):
        coloured = snapshot.draw(ax, 2.0, window=(0, 0.5, 0, 1.1 * HEIGHT))
        ax.plot([0, WIDTH, WIDTH], [HEIGHT, HEIGHT, 0], "k--", lw=0.6)
        ax.set_title(f"{snapshot.time:.2g} s", loc="right", y=0.7)
        ax.set_ylabel("y (m)")
    axes[-1, 0].set_xlabel("x (m)")
    figure.colorbar(coloured, ax=axes, label="plastic shear strain (-)", extend="max", shrink=0.7)
    plot.save(figure, file)


def drawSurfaces(results, file):
    figure, ax = plot.plt.subplots(figsize=(7, 2.6), layout="constrained")
    for label, (_, scene, _) in results.items():
        ax.plot(*surfaceOf(scene), "--" if "hybrid" in label else "-", label=label, lw=1.4)
    ax.plot([0, WIDTH, WIDTH], [HEIGHT, HEIGHT, 0], "k--", lw=0.6)
    ax.set(xlabel="x (m)", ylabel="height of the deposit (m)", xlim=(0, 0.55), ylim=(0, None))
    ax.legend()
    plot.save(figure, file)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    cases = [(a.types, a.cell)]
    if a.compare:
        cases = [(t, h) for h in (0.01, 0.005) for t in ("ugimp", "hybrid")]
    results = {}
    for types, cell in cases:
        label = f"{types}, cell {1e3 * cell:g} mm"
        results[label] = run(argparse.Namespace(**{**vars(a), "types": types, "cell": cell}))
        s, scene, snapshots = results[label]
        draw(scene, snapshots, os.path.join(a.out, f"{types}_{1e3 * cell:g}mm.png"))
        print(
            f"{label}: run-out {s['runout']:.3f} of the width, unmoved top {s['unmovedTop']:.3f} m, slope "
            f"{s['slopeDegrees']:.1f} degrees, height at the wall {s['heightAtWall']:.4f} m; "
            f"{sum(s['particles'].values())} particles, {s['steps']} steps in {s['wallSeconds']:.1f} s",
            flush=True,
        )
    drawSurfaces(results, os.path.join(a.out, "surfaces.png"))
    files.saveJson(
        os.path.join(a.out, "summary.json"),
        {label: r[0] for label, r in results.items()} if a.compare else results[label][0],
    )
    print(f"results in {a.out}/")


if __name__ == "__main__":
    commandLine.run(main)
