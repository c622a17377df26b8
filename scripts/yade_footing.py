#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A rigid box of YADE pressed into cohesive ground (phi = 0): Prandtl's bearing capacity through the contact.

Plane strain, weightless, half of the problem: 15 x 7.5 m of ground with rollers at the sides and a fixed
base; the box of half width B = 3 m stands over its upper left corner, moves down at 0.04 m/s (all degrees of
freedom blocked), and is 0.5 m thick in YADE's third direction. G = 0.1 GPa, K = 0.2 GPa, c = 0.1 MPa, F-bar
against locking. Exact limit q = (2 + pi) c = 514.16 kPa (Prandtl 1920), rough or smooth.

The points of the soil under the box move with it, and so do the grid nodes of their cells. Beside the edge,
which lies on a grid line, the velocity falls to zero over one cell: the grid sees a footing of the half width
B + h/2. Both are printed: load over B, and over B + h/2.

Units: Mg, m, s, kPa, kN.

    scripts/run yade_footing                    # hybrid, cells of 0.3 and 0.15 m
    scripts/run yade_footing --types ugimp apdi hybrid
    scripts/run yade_footing --smoke
"""

import os
import time
from math import pi

import numpy as np
import yade_mpm as mpm
from yade import ForceResetter, NewtonIntegrator, O, utils
from yade.minieigenHP import Vector3
from yade_mpm import box, commandLine, files, inYade, plot
from yade_mpm.commandLine import notNegative, partOf, positive

WIDTH, DEPTH, HALF_WIDTH, HEIGHT = 15.0, 7.5, 3.0, 0.6  # m
THICKNESS = 0.5  # m, of the slice that YADE sees
SHEAR, BULK, COHESION, DENSITY = 1e5, 2e5, 100.0, 2.0  # kPa, kPa, kPa, Mg/m3 (inertia only)
PRANDTL = (2 + pi) * COHESION


def arguments(given=None):
    p = commandLine.Parser("yade_footing", __doc__, smoke={"cell": [0.5]}, threads=False)
    p.add_argument(
        "--types",
        choices=("ugimp", "apdi", "hybrid"),
        nargs="+",
        default=["hybrid"],
        help="particle types (default hybrid)",
    )
    p.add_argument(
        "--cell",
        type=partOf(1.5),
        nargs="+",
        default=[0.3, 0.15],
        help="cell sizes, m: 1.5 m over a whole number (default 0.3 0.15)",
    )
    p.add_argument(
        "--friction",
        type=notNegative,
        default=0.5,
        help="coefficient between box and ground (default %(default)s)",
    )
    p.add_argument("--rate", type=positive, default=0.04, help="settlement rate, m/s (default %(default)s)")
    p.add_argument(
        "--settlement", type=positive, default=0.06, help="final settlement, m (default %(default)s)"
    )
    p.add_argument("--no-fbar", action="store_true", help="without F-bar: the ground locks")
    return p.parse(given)


def addGround(scene, types, cell, fbar):
    clay = mpm.MohrCoulombDruckerPrager(
        density=DENSITY,
        lame=(BULK - 2 / 3 * SHEAR, SHEAR),
        cohesion=COHESION,
        frictionAngle=0.0,
        dilatancyAngle=0.0,
    )
    ground = box((0, 0), (WIDTH, DEPTH))
    if types == "ugimp":
        scene.add("ground", ground, clay, mpm.UGIMP(perCell=2), fbar=fbar)
    elif types == "apdi":
        scene.add("ground", ground, clay, mpm.APDI(size=cell / 2), fbar=fbar)
    else:  # uGIMP where the edge of the footing shears the ground most
        zone = box((0, DEPTH - 5 * cell), (HALF_WIDTH + 3 * cell, DEPTH))
        near = scene.add("near ground", zone, clay, mpm.UGIMP(perCell=2), fbar=fbar)
        scene.add("far ground", ground - zone, clay, mpm.APDI(size=cell, matched=near), fbar=fbar)


def build(types="hybrid", cell=0.3, friction=0.5, rate=0.04, fbar=True):
    """The ground, and the box in O; returns (coupling, number of the box)."""
    O.reset()
    scene = mpm.Scene((0, 0), (WIDTH, DEPTH + 4 * cell), cell)
    addGround(scene, types, cell, fbar)
    contact = mpm.RigidContact()
    scene.engines = [
        mpm.ParticleToGrid(),
        contact,
        mpm.GridSolver(damping=0.7, roller=("left", "right"), fixed=("bottom",)),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    footing = O.bodies.append(utils.box((0, DEPTH + HEIGHT, 0), (HALF_WIDTH, HEIGHT, THICKNESS / 2)))
    state = O.bodies[footing].state
    state.blockedDOFs, state.vel = "xyzXYZ", Vector3(0, -rate, 0)
    O.engines = [ForceResetter(), NewtonIntegrator()]
    bodies = inYade.Bodies(contact, [footing], friction=friction, thickness=THICKNESS)
    scene.dt = (
        0.65 * scene.criticalTimeStep()
    )  # constant, because the stiffness of the contact follows the step
    coupling = inYade.attach(scene, stages=False)
    coupling.exchanges.append(bodies)
    return coupling, footing


class LoadCurve:
    """Settlement, m, and force that the ground has put on the box, kN, in every twentieth step; goes into
    `Coupling.exchanges` behind the bodies."""

    def __init__(self, footing):
        self.footing, self.steps, self.rows = footing, 0, []

    def read(self, coupling):
        pass

    def apply(self, coupling):
        self.steps += 1
        if self.steps % 20 == 0:
            self.rows.append(
                (DEPTH + HEIGHT - O.bodies[self.footing].state.pos[1], O.forces.f(self.footing)[1])
            )


def run(types="hybrid", cell=0.3, friction=0.5, rate=0.04, settlement=0.06, fbar=True):
    """Pushes the box down; returns (summary, scene, settlement (m), load over thickness and B (kPa))."""
    began = time.monotonic()
    coupling, footing = build(types, cell, friction, rate, fbar)
    curve = LoadCurve(footing)
    coupling.exchanges.append(curve)
    while O.time < settlement / rate:
        O.run(int((settlement / rate - O.time) / O.dt) + 1, True)
    depth, force = np.array(curve.rows).T
    pressure = force / THICKNESS / HALF_WIDTH
    late = depth > 0.75 * settlement
    reached = pressure[late].mean()
    start = pressure < 0.4 * PRANDTL
    slope, stiffness = (np.polyfit(depth[w], pressure[w], 1)[0] for w in (late, start))
    return (
        {
            "types": types,
            "cell": cell,
            "friction": friction,
            "rate": rate,
            "settlement": settlement,
            "fbar": fbar,
            "particles": coupling.scene.particleCount,
            "steps": coupling.scene.steps,
            "wallSeconds": time.monotonic() - began,
            "reference": PRANDTL,
            "pressure": reached,
            "error": reached / PRANDTL - 1,
            "effectiveError": reached / PRANDTL * HALF_WIDTH / (HALF_WIDTH + 0.5 * cell) - 1,
            "slopeOverElastic": slope / stiffness,
        },
        coupling.scene,
        depth,
        pressure,
    )


def draw(results, file):
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(9.6, 3.4), layout="constrained", width_ratios=(1, 1.35)
    )
    for summary, _, depth, pressure in results:
        left.plot(1e3 * depth, pressure, lw=1, label=f"{summary['types']}, cell {summary['cell']:g} m")
    left.axhline(PRANDTL, color="k", lw=0.9, ls="--")
    left.text(0, PRANDTL + 6, " (2 + π) c", va="bottom", ha="left")
    left.set(
        xlabel="settlement (mm)",
        ylabel="load over B and thickness (kPa)",
        xlim=(0, None),
        ylim=(0, 1.25 * PRANDTL),
    )
    left.legend(loc="lower right")
    summary, snapshot = results[-1][:2]
    coloured = snapshot.draw(right, 0.05, window=(0, 12, 2.5, 9))
    bottom = DEPTH - summary["settlement"]
    right.fill(
        [0, HALF_WIDTH, HALF_WIDTH, 0],
        [bottom, bottom, bottom + 2 * HEIGHT, bottom + 2 * HEIGHT],
        fc="0.75",
        ec="k",
        lw=0.8,
    )
    right.text(0.5 * HALF_WIDTH, bottom + HEIGHT, "YADE box", ha="center", va="center")
    drawMechanism(right)
    right.set(xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(coloured, ax=right, label="plastic shear strain (-)", extend="max", shrink=0.8)
    plot.save(figure, file)


def drawMechanism(axes):
    """Outline of Prandtl's mechanism: wedge under the box, fan about its edge, wedge beside it."""
    fan = np.linspace(1.25 * pi, 1.75 * pi, 40)
    radius = np.sqrt(2) * HALF_WIDTH
    x, y = HALF_WIDTH + radius * np.cos(fan), DEPTH + radius * np.sin(fan)
    axes.plot([*x, 3 * HALF_WIDTH], [*y, DEPTH], "k--", lw=0.8)
    axes.plot([x[0], HALF_WIDTH, x[-1]], [y[0], DEPTH, y[-1]], "k--", lw=0.8)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    results = []
    for types in a.types:
        for cell in a.cell:
            s, scene, depth, pressure = run(types, cell, a.friction, a.rate, a.settlement, not a.no_fbar)
            results.append((s, plot.Snapshot(scene, "plasticShearStrain"), depth, pressure))
            found = f"{s['pressure']:.1f} kPa ({s['error']:+.1%} of {PRANDTL:.1f})"
            slope = f"slope {s['slopeOverElastic']:.2%} of the elastic one"
            slope = f"over B + h/2 {s['effectiveError']:+.1%}; {slope}"
            print(f"{types}, cell {cell:g} m: load over B {found}, {slope}", flush=True)
    draw(results, os.path.join(a.out, "load_settlement.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), [r[0] for r in results])
    print(f"results in {a.out}/")


if __name__ == "__main__":
    commandLine.run(main)
