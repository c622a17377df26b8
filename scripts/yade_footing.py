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
from yade import ForceResetter, NewtonIntegrator, O, PyRunner, utils
from yade.minieigenHP import Vector3
from yade_footing_pictures import draw
from yade_mpm import Parameter, app, box, plot
from yade_mpm.io import files

WIDTH, DEPTH, HALF_WIDTH, HEIGHT = 15.0, 7.5, 3.0, 0.6  # m
THICKNESS = 0.5  # m, of the slice that YADE sees
SHEAR, BULK, COHESION, DENSITY = 1e5, 2e5, 100.0, 2.0  # kPa, kPa, kPa, Mg/m3 (inertia only)
PRANDTL = (2 + pi) * COHESION


PARAMETERS = mpm.Parameters(
    "yade_footing",
    __doc__,
    Parameter("types", ["hybrid"], "particle types", several=True, choices=("ugimp", "apdi", "hybrid")),
    Parameter("cell", [0.3, 0.15], "cell sizes", several=True, unit="m", partOf=1.5),
    Parameter("friction", 0.5, "coefficient between box and ground", least=0),
    Parameter("rate", 0.04, "of the settlement", unit="m/s", above=0),
    Parameter("settlement", 0.06, "at the end", unit="m", above=0),
    Parameter("no_fbar", False, "without F-bar: the ground locks"),
    smoke={"cell": [0.5]},
    threads=False,
)
arguments = PARAMETERS.parse


def addGround(scene, types, cell, fbar):
    lame = BULK - 2 / 3 * SHEAR, SHEAR
    clay = mpm.MohrCoulombDruckerPrager(density=DENSITY, lame=lame, cohesion=COHESION, frictionAngle=0.0)
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
    scene = mpm.Scene((0, 0), (WIDTH, DEPTH + 4 * cell), cell, damping=0.7)
    scene.roller("left", "right")
    scene.fix("bottom")
    addGround(scene, types, cell, fbar)
    footing = O.bodies.append(utils.box((0, DEPTH + HEIGHT, 0), (HALF_WIDTH, HEIGHT, THICKNESS / 2)))
    state = O.bodies[footing].state
    state.blockedDOFs, state.vel = "xyzXYZ", Vector3(0, -rate, 0)
    O.engines = [ForceResetter(), NewtonIntegrator()]
    scene.contact(footing, friction=friction, thickness=THICKNESS)
    scene.dt = 0.65 * scene.criticalTimeStep()  # constant: the stiffness of the contact follows the step
    return mpm.inYade(scene, stages=False), footing


def run(types="hybrid", cell=0.3, friction=0.5, rate=0.04, settlement=0.06, fbar=True):
    """Pushes the box down; returns (summary, scene, settlement (m), load over thickness and B (kPa))."""
    began = time.monotonic()
    coupling, footing = build(types, cell, friction, rate, fbar)
    curve = []  # settlement, m, and force of the ground on the box, kN, in every twentieth step
    state = O.bodies[footing].state

    def look():
        curve.append((DEPTH + HEIGHT - state.pos[1], O.forces.f(footing)[1]))

    mpm.yade.setCommand("look()", look)
    O.engines = [*O.engines, PyRunner(command="look()", iterPeriod=20)]
    O.run(int(settlement / rate / O.dt) + 1, True)
    depth, force = np.array(curve).T
    pressure = force / THICKNESS / HALF_WIDTH
    late = depth > 0.75 * settlement
    reached = pressure[late].mean()
    start = pressure < 0.4 * PRANDTL
    slope, stiffness = (np.polyfit(depth[w], pressure[w], 1)[0] for w in (late, start))
    summary = dict(types=types, cell=cell, friction=friction, rate=rate, settlement=settlement, fbar=fbar)
    summary |= dict(particles=coupling.scene.particleCount, steps=coupling.scene.steps)
    summary |= dict(wallSeconds=time.monotonic() - began, reference=PRANDTL, pressure=reached)
    summary |= dict(error=reached / PRANDTL - 1, slopeOverElastic=slope / stiffness)
    summary["effectiveError"] = reached / PRANDTL * HALF_WIDTH / (HALF_WIDTH + 0.5 * cell) - 1
    return summary, coupling.scene, depth, pressure


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
    draw(results, os.path.join(a.out, "load_settlement.png"), (HALF_WIDTH, HEIGHT, DEPTH), PRANDTL)
    files.saveJson(os.path.join(a.out, "summary.json"), [r[0] for r in results])
    print(f"results in {a.out}/")


if __name__ == "__main__":
    app.run(main)
