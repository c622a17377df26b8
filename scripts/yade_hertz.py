#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A rigid sphere of YADE pressed on an elastic layer: Hertz, in three dimensions.

A quarter of the problem: a layer of the thickness T = 3 a and the length L = 9 a with rollers at the two
planes of symmetry and at the base, free elsewhere. The sphere of YADE stands over the edge between the planes
of symmetry, and the layer gives it a quarter of the force. It moves down by d = a^2/R with a/R = 0.02, then
rests (all its degrees of freedom are blocked).

The force is compared with Hertz's, F = 4/3 E/(1 - nu^2) sqrt(R) d^1.5, times a factor for the finite
thickness (`layerFactor`: 1.32). The overlap of the penalty contact, averaged with the forces of the contacts,
is taken off d. The grid sees the contact area at a resolution of a cell, so cells per contact radius are what
counts.

Units: Mg, m, s, kPa, kN.

    scripts/run yade_hertz                     # a of 3, 4 and 6 cells, APDI; 3 and 4 cells, uGIMP
    scripts/run yade_hertz --types ugimp --radius 6
    scripts/run yade_hertz --smoke
"""

import os
import time

import hertz_on_layer
import numpy as np
import yade_mpm as mpm
from hertz_on_layer import layerFactor
from yade import ForceResetter, NewtonIntegrator, O, utils
from yade.minieigenHP import Vector3
from yade_hertz_pictures import draw
from yade_mpm import Parameter, app, box
from yade_mpm.io import files

CELL, YOUNG, POISSON, DENSITY = 0.1, 1e4, 0.3, 2.0  # m, kPa, -, Mg/m3
THICKNESS, LENGTH, RATIO = 3, 9, 0.02  # T/a, L/a, a/R
CASES = {"apdi": [3, 4, 6], "ugimp": [3, 4]}  # a in cells


PARAMETERS = mpm.Parameters(
    "yade_hertz",
    __doc__,
    Parameter("types", list(CASES), "particle types", several=True, choices=tuple(CASES)),
    Parameter(
        "radius", None, "contact radii in cells (default 3 4 6, uGIMP 3 4)", several=True, least=1, whole=True
    ),
    smoke={"types": ["apdi"], "radius": [3]},
    threads=False,
)
arguments = PARAMETERS.parse


def hertz(depth, radius):
    return hertz_on_layer.hertz(depth, radius, YOUNG, POISSON)


def build(types, radius):
    """Layer, and sphere in O, for a contact radius (m); returns (coupling, contact, number of the sphere)."""
    O.reset()
    length, thickness = LENGTH * radius, THICKNESS * radius
    scene = mpm.Scene((0, 0, 0), (length, length, thickness + 4 * CELL), CELL, damping=0.6)
    scene.roller("left", "front", "bottom")
    kind = mpm.APDI(size=CELL) if types == "apdi" else mpm.UGIMP(perCell=2)
    rubber = mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON)
    scene.add("layer", box((0, 0, 0), (length, length, thickness)), rubber, kind)
    sphere = O.bodies.append(utils.sphere((0, 0, thickness + radius / RATIO), radius / RATIO))
    O.bodies[sphere].state.blockedDOFs = "xyzXYZ"
    O.engines = [ForceResetter(), NewtonIntegrator()]
    contact = scene.contact(sphere, friction=0).contact
    contact.stiffnessFactor = 0.8
    scene.dt = 0.3 * scene.criticalTimeStep()  # small, for a stiff contact
    return mpm.inYade(scene, stages=False), contact, sphere


class LoadCurve:
    """Approach and mean overlap of the contacts, m, and force on the whole sphere, kN, in every step with
    contact; goes into `Coupling.exchanges` behind the bodies."""

    def __init__(self, sphere, contact):
        self.sphere, self.contact, self.rows = sphere, contact, []
        self.start = O.bodies[sphere].state.pos[2]

    def read(self, coupling):
        pass

    def apply(self, coupling):
        table = self.contact.contactTable()
        force = table["force"][:, 2]
        if abs(force.sum()) > 0:
            overlap = (table["gap"] * force).sum() / -force.sum()
            self.rows.append(
                (self.start - O.bodies[self.sphere].state.pos[2], overlap, 4 * O.forces.f(self.sphere)[2])
            )


def runUntil(end):
    while O.time < end:
        O.run(int((end - O.time) / O.dt) + 1, True)


def run(types="apdi", cells=4):
    """Presses the sphere down and waits; returns (summary, rows of depth (m) and force (kN) while it goes
    down, radius of the sphere (m))."""
    began = time.monotonic()
    a = cells * CELL
    coupling, contact, sphere = build(types, a)
    curve = LoadCurve(sphere, contact)
    coupling.exchanges.append(curve)
    duration = 24 * a / np.sqrt(1.35 * YOUNG / DENSITY)  # eight times of a wave through the layer
    O.bodies[sphere].state.vel = Vector3(0, 0, -a * RATIO / duration)
    runUntil(duration)
    moving = len(curve.rows)
    O.bodies[sphere].state.vel = Vector3.Zero
    runUntil(2 * duration)
    rows = np.array(curve.rows)
    radius, last = a / RATIO, rows[-len(rows) // 10 :]
    approach, overlap, force = last.mean(axis=0)
    depth = approach - overlap
    factor = layerFactor(np.sqrt(radius * depth) / (THICKNESS * a))
    reference = factor * hertz(depth, radius)
    summary = dict(types=types, cellsPerRadius=cells, force=force, reference=reference, layerFactor=factor)
    summary |= dict(error=force / reference - 1, depth=depth, overlapOverDepth=overlap / depth)
    summary |= dict(withOverlap=force / factor / hertz(approach, radius) - 1, contacts=contact.contacts)
    summary |= dict(swing=float(np.ptp(last[:, 2]) / force), steps=coupling.scene.steps)
    summary |= dict(particles=coupling.scene.particleCount, wallSeconds=time.monotonic() - began)
    return summary, np.transpose([rows[:moving, 0] - rows[:moving, 1], rows[:moving, 2]]), radius


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    results = []
    for types in a.types:
        for cells in a.radius or CASES[types]:
            results.append(run(types, cells))
            s = results[-1][0]
            found = f"{s['force']:.4f} kN ({s['error']:+.1%} of {s['reference']:.4f})"
            print(
                f"{types}, a = {cells} cells: {found}, {s['withOverlap']:+.1%} with the overlap in d",
                flush=True,
            )
    draw(results, os.path.join(a.out, "hertz.png"), (THICKNESS, RATIO), CELL, hertz)
    files.saveJson(os.path.join(a.out, "summary.json"), [r[0] for r in results])
    print(f"results in {a.out}/")


if __name__ == "__main__":
    app.run(main)
