#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A rough rigid footing on cohesive or c-phi ground: Prandtl's bearing capacity, and volumetric locking.

Plane strain, weightless, half of the problem: 20 x 10 m of ground, footing of half width a = 3 m at its upper left, with
rollers at the sides and a fixed base. G = 0.1 GPa, K = 0.2 GPa, c = 0.1 MPa. Exact limit q = c Nc with Nc = (Nq - 1) cot(phi),
Nq = exp(pi tan(phi)) tan2(45 + phi/2); q = (2 + pi) c = 514.16 kPa for phi = 0 (Prandtl 1920). Isochoric plastic flow locks the
particles of one cell: the load is 5 to 20 % too high. `--fbar` averages the volumetric strain over a cell, which mends that.

With `--phi` the ground dilates by psi = phi: only for associated flow is the limit load a theorem.

The footing is held grid nodes of the surface. The velocity falls to zero over the cell beside the last one; the edge of the
footing is taken as the middle of that cell; cells of 6 m / (an odd number) put it at a = 3 m. Where in that cell the edge
really is differs between particle types, and half a cell is 3.7 % of the width. `--widths` asks for no edge: the load of a
second footing of 0.6 a tells by how much the load grows with the width, and how far the footing reaches beyond its last node.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run footing --fbar                   # hybrid, cells of 2/9 m
    scripts/run footing --fbar --types ugimp --cell 0.4
    scripts/run footing --fbar --phi 20
    scripts/run footing --fbar --types ugimp --widths
    scripts/run footing --compare                # without and with F-bar in one picture
    scripts/run footing --smoke
"""

import argparse
import os
import time
from math import exp, pi, radians, tan

import numpy as np
import yade_mpm as mpm
from yade_mpm import box, commandLine, files, plot
from yade_mpm.commandLine import below, partOf, positive

WIDTH, DEPTH = 20.0, 10.0  # m
SHEAR, BULK, COHESION, DENSITY = 1e5, 2e5, 100.0, 2.0  # kPa, kPa, kPa, Mg/m3 (inertia only)


def arguments(given=None):
    p = commandLine.Parser("footing", __doc__, smoke={"cell": 2 / 3, "rate": 0.04, "settlement": 0.12})
    p.add_argument(
        "--types",
        choices=("ugimp", "apdi", "hybrid"),
        default="hybrid",
        help="particle types (default %(default)s)",
    )
    p.add_argument(
        "--phi",
        type=below(60),
        default=0.0,
        help="angles of friction and of dilatancy, degrees (default %(default)s)",
    )
    p.add_argument(
        "--fbar",
        action="store_true",
        help="against locking: cell-mean volumetric strain, mean stress linear in a cell",
    )
    p.add_argument(
        "--cell",
        type=partOf(DEPTH),
        default=2 / 9,
        help="cell size, m: 10 m over a whole number (default 2/9)",
    )
    p.add_argument("--rate", type=positive, default=0.02, help="settlement rate, m/s (default %(default)s)")
    p.add_argument(
        "--settlement", type=positive, help="final settlement, m (default 0.08, with friction 0.11)"
    )
    p.add_argument(
        "--halfWidth", type=positive, default=3.0, help="half width of the footing, m (default %(default)s)"
    )
    p.add_argument("--widths", action="store_true", help="also run 0.6 of the width, and compare the loads")
    p.add_argument("--damping", type=below(1), default=0.7, help="local damping (default %(default)s)")
    p.add_argument("--compare", action="store_true", help="run without and with F-bar and draw both curves")
    a = p.parse(given)
    if a.compare:
        p.refuseBeside(given, "--compare", ("fbar",), "it runs without and with F-bar")
    least = (0.5 / 0.6 if a.widths else 0.5) * a.cell
    if not least <= a.halfWidth < WIDTH - a.cell:
        p.error(f"--halfWidth {a.halfWidth:g} is not allowed; give {least:g} to below {WIDTH - a.cell:g}")
    # The limit load belongs to small settlements: at half a cell (0.11 m) boxes under the edge pass to nodes that are not held.
    a.settlement = a.settlement or (0.11 if a.phi else 0.08)
    return a


def limitPressure(phi):
    """Prandtl's limit for ground of an angle of friction (degrees), kPa."""
    t = tan(radians(phi))
    return COHESION * ((exp(pi * t) * tan(radians(45 + phi / 2)) ** 2 - 1) / t if phi else 2 + pi)


def effectiveHalfWidth(a):
    """Half width of the footing as held nodes make it, m: to the middle of the cell beside the last one."""
    return (np.floor(a.halfWidth / a.cell - 0.5 + 1e-6) + 0.5) * a.cell


def build(a):
    """The scene: ground and footing (without output)."""
    scene = mpm.Scene(lower=(0, 0), upper=(WIDTH, DEPTH + 4 * a.cell), cell=a.cell, threads=a.threads)
    clay = mpm.MohrCoulombDruckerPrager(
        density=DENSITY,
        lame=(BULK - 2 / 3 * SHEAR, SHEAR),
        cohesion=COHESION,
        frictionAngle=radians(a.phi),
        dilatancyAngle=radians(a.phi),
    )
    ground = box((0, 0), (WIDTH, DEPTH))
    if a.types == "ugimp":
        scene.add("ground", ground, clay, mpm.UGIMP(perCell=2), fbar=a.fbar)
    elif a.types == "apdi":
        scene.add("ground", ground, clay, mpm.APDI(size=a.cell / 2), fbar=a.fbar)
    else:  # uGIMP where the edge of the footing shears the ground most
        edge = round(a.halfWidth / a.cell) * a.cell
        zone = box((0, DEPTH - 5 * a.cell), (edge + 3 * a.cell, DEPTH))
        near = scene.add("near ground", zone, clay, mpm.UGIMP(perCell=2), fbar=a.fbar)
        scene.add("far ground", ground - zone, clay, mpm.APDI(size=a.cell, matched=near), fbar=a.fbar)
    last = effectiveHalfWidth(a) - 0.5 * a.cell
    nodes = box((-3 * a.cell, DEPTH - 0.1 * a.cell), (last + 0.1 * a.cell, DEPTH + 3 * a.cell))
    footing = mpm.Hold(nodes, velocity=(0.0, -a.rate), ramp=0.1 * a.settlement / a.rate, name="footing")
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(damping=a.damping, roller=("left", "right"), fixed=("bottom",), hold=footing),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    return scene


def run(a, out=None):
    """Pushes the footing down; returns (summary, scene, settlement (m), pressure (kPa))."""
    began = time.monotonic()
    scene = build(a)
    ramp = next(c for e in scene.engines if isinstance(e, mpm.GridSolver) for c in e.hold).ramp
    until = a.settlement / a.rate + 0.5 * ramp
    name = "history_fbar.csv" if a.fbar else "history.csv"
    history = mpm.History(period=until / 200, file=None if out is None else os.path.join(out, name))
    scene.engines = scene.engines + [history]
    scene.run(until=until)
    t = history["time"]
    settlement = a.rate * np.where(t < ramp, t**2 / (2 * ramp), t - 0.5 * ramp)
    pressure = -history["footing.fy"] / effectiveHalfWidth(a)
    return summarise(a, scene, settlement, pressure, time.monotonic() - began), scene, settlement, pressure


def summarise(a, scene, settlement, pressure, wall):
    limit = limitPressure(a.phi)
    late = settlement > 0.75 * settlement[-1]
    slope = np.polyfit(settlement[late], pressure[late], 1)[0]
    start = (settlement > 0) & (pressure < 0.4 * limit)
    stiffness = np.polyfit(settlement[start], pressure[start], 1)[0]
    return {
        "arguments": vars(a),
        "particles": scene.particleCount,
        "steps": scene.steps,
        "dt": scene.dt,
        "wallSeconds": wall,
        "effectiveHalfWidth": effectiveHalfWidth(a),
        "reference": limit,
        "pressure": float(pressure[late].mean()),
        "error": float(pressure[late].mean() / limit - 1),
        "finalError": float(pressure[-1] / limit - 1),
        "slopeOverElastic": float(slope / stiffness),
        "plateau": bool(abs(slope) < 0.01 * stiffness),
    }


def drawCurves(curves, limit, file):
    """Load-settlement curves and the limit pressure (kPa); curves is a list of (label, settlement, pressure)."""
    figure, ax = plot.plt.subplots(figsize=(5.2, 3.8), layout="constrained")
    for label, settlement, pressure in curves:
        ax.plot(1e3 * settlement, pressure, label=label)
    ax.axhline(limit, color="k", lw=0.9, ls="--")
    ax.text(0, 1.01 * limit, " Prandtl", va="bottom", ha="left")
    ax.set(
        xlabel="settlement (mm)",
        ylabel="mean pressure under the footing (kPa)",
        xlim=(0, None),
        ylim=(0, None),
    )
    ax.legend(loc="lower right")
    plot.save(figure, file)


def compareWidths(a, pressure):
    """Limit pressure by the growth of the load with the width (kPa), and overhang: what the load of the footing needs beyond its
    last held node, over the cell. pressure: that of the footing itself.

    In weightless ground the load is pressure times width; what one edge adds is the same for two widths on one grid.
    """
    narrow = argparse.Namespace(**{**vars(a), "halfWidth": 0.6 * a.halfWidth})
    wide, less = effectiveHalfWidth(a), effectiveHalfWidth(narrow)
    limit = (pressure * wide - run(narrow)[0]["pressure"] * less) / (wide - less)
    return limit, (pressure / limit - 1) * wide / a.cell + 0.5


def drawGround(a, scene, file):
    figure, ax = plot.plt.subplots(figsize=(7.6, 4.0), layout="constrained")
    strain = np.concatenate([b.plasticShearStrain for b in scene.bodies if b.count])
    limit = np.quantile(strain, 0.98)
    coloured = plot.Snapshot(scene, "plasticShearStrain").draw(ax, limit)
    ax.plot([0, a.halfWidth], [DEPTH, DEPTH], "C0-", lw=3)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(coloured, ax=ax, label="plastic shear strain (-)", extend="max", shrink=0.7)
    plot.save(figure, file)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    curves, summaries = [], []
    for fbar in [False, True] if a.compare else [a.fbar]:
        one = argparse.Namespace(**{**vars(a), "fbar": fbar})
        summary, scene, settlement, pressure = run(one, a.out)
        name = "with F-bar" if fbar else "without F-bar"
        curves.append((f"{a.types}, {name}", settlement, pressure))
        summaries.append(summary)
        drawGround(one, scene, os.path.join(a.out, "ground_fbar.png" if fbar else "ground.png"))
        print(
            f"{a.types}, {name}: {summary['pressure']:.1f} kPa ({summary['error']:+.1%} of {summary['reference']:.1f} kPa, at the end "
            f"{summary['finalError']:+.1%}), {'a plateau' if summary['plateau'] else 'no plateau'} (slope "
            f"{summary['slopeOverElastic']:.2%} of the elastic one); {summary['particles']} particles, "
            f"{summary['steps']} steps in {summary['wallSeconds']:.1f} s",
            flush=True,
        )
        if a.widths:
            limit, overhang = compareWidths(one, summary["pressure"])
            summary.update(
                limitByWidths=limit, errorByWidths=limit / summary["reference"] - 1, overhangOverCell=overhang
            )
            print(
                f"by the growth of the load with the width: {limit:.1f} kPa ({summary['errorByWidths']:+.1%}); the footing reaches "
                f"{overhang:.2f} of a cell beyond its last node"
            )
    drawCurves(curves, summaries[0]["reference"], os.path.join(a.out, "load_settlement.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summaries if a.compare else summaries[0])
    print(f"results in {a.out}/")


if __name__ == "__main__":
    commandLine.run(main)
