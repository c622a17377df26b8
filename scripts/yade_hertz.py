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
from math import pi

import numpy as np
import yade_mpm as mpm
from yade import ForceResetter, NewtonIntegrator, O, utils
from yade.minieigenHP import Vector3
from yade_mpm import box, commandLine, files, inYade, plot
from yade_mpm.commandLine import count

CELL, YOUNG, POISSON, DENSITY = 0.1, 1e4, 0.3, 2.0  # m, kPa, -, Mg/m3
THICKNESS, LENGTH, RATIO = 3, 9, 0.02  # T/a, L/a, a/R
CASES = {"apdi": [3, 4, 6], "ugimp": [3, 4]}  # a in cells


def arguments(given=None):
    p = commandLine.Parser("yade_hertz", __doc__, smoke={"types": ["apdi"], "radius": [3]}, threads=False)
    p.add_argument(
        "--types", choices=tuple(CASES), nargs="+", default=list(CASES), help="particle types (default both)"
    )
    p.add_argument(
        "--radius", type=count, nargs="+", help="contact radius in cells (default 3 4 6, uGIMP 3 4)"
    )
    return p.parse(given)


# --- reference --------------------------------------------------------------------------------------------
def hertz(depth, radius):
    """Force on a rigid sphere on an elastic half-space, kN."""
    return 4 / 3 * YOUNG / (1 - POISSON**2) * np.sqrt(radius) * np.clip(depth, 0, None) ** 1.5


def layerFactor(chi, points=40):
    """Force on a frictionless sphere on an elastic layer that slips on a rigid base, over Hertz's; chi =
    sqrt(R d)/T.

    A surface pressure of the wave number k lowers a layer by 1 - M(k T) of what it lowers a half-space, M(u)
    = 1 - (cosh 2u - 1) / (sinh 2u + 2u). Hence for the function f with F = E/(1 - nu^2) int f dt over the
    contact -a < t < a, a = T = 1 say,

        f(t) - 1/pi int f(s) int_0^inf M(u) cos(u (t - s)/T) du/T ds = d - t^2/R,    f(a) = 0

    (Fredholm, by Gauss quadrature). No Poisson's ratio in it. The series of Dimitriadis et al. 2002 (Biophys.
    J. 82, 2798) for a layer that is not bonded agrees within 0.6 % for nu = 0.3 and chi < 0.32.
    """
    thickness = 1 / chi
    for _ in range(6):
        found, factor = _layer(thickness)
        thickness *= found / chi
    return factor


def _layer(thickness, points=16):
    """chi and factor for a contact radius of 1 on a layer of this thickness."""
    x, weights = np.polynomial.legendre.leggauss(points)
    t = np.append(x, 1.0)
    u = np.linspace(1e-6, 20, 500)
    e = np.exp(-2 * u)
    lost = 1 - (1 - e) ** 2 / (1 - e**2 + 4 * u * e)
    kernel = (
        np.trapz(lost * np.cos(np.multiply.outer(t[:, None] - x, u / thickness)), u, axis=-1)
        / thickness
        / pi
        * weights
    )
    matrix = np.eye(len(t))
    matrix[:, :-1] -= kernel
    ofDepth, ofShape = np.linalg.solve(matrix, np.transpose([np.ones_like(t), t**2])).T
    depth = ofShape[-1] / ofDepth[-1]
    force = weights @ (depth * ofDepth - ofShape)[:-1]
    return np.sqrt(depth) / thickness, force / (4 / 3 * depth**1.5)


# --- the scene --------------------------------------------------------------------------------------------
def build(types, radius):
    """Layer, and sphere in O, for a contact radius (m); returns (coupling, contact, number of the sphere)."""
    O.reset()
    length, thickness = LENGTH * radius, THICKNESS * radius
    scene = mpm.Scene((0, 0, 0), (length, length, thickness + 4 * CELL), CELL)
    kind = mpm.APDI(size=CELL) if types == "apdi" else mpm.UGIMP(perCell=2)
    scene.add(
        "layer",
        box((0, 0, 0), (length, length, thickness)),
        mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON),
        kind,
    )
    contact = mpm.RigidContact(stiffnessFactor=0.8)
    scene.engines = [
        mpm.ParticleToGrid(),
        contact,
        mpm.GridSolver(damping=0.6, roller=("left", "front", "bottom")),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    sphere = O.bodies.append(utils.sphere((0, 0, thickness + radius / RATIO), radius / RATIO))
    O.bodies[sphere].state.blockedDOFs = "xyzXYZ"
    O.engines = [ForceResetter(), NewtonIntegrator()]
    bodies = inYade.Bodies(contact, [sphere], friction=0)
    scene.dt = 0.3 * scene.criticalTimeStep()  # small, for a stiff contact
    coupling = inYade.attach(scene, stages=False)
    coupling.exchanges.append(bodies)
    return coupling, contact, sphere


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
    return (
        {
            "types": types,
            "cellsPerRadius": cells,
            "force": force,
            "reference": reference,
            "error": force / reference - 1,
            "withOverlap": force / factor / hertz(approach, radius) - 1,
            "layerFactor": factor,
            "depth": depth,
            "overlapOverDepth": overlap / depth,
            "swing": float(np.ptp(last[:, 2]) / force),
            "contacts": contact.contacts,
            "particles": coupling.scene.particleCount,
            "steps": coupling.scene.steps,
            "wallSeconds": time.monotonic() - began,
        },
        np.transpose([rows[:moving, 0] - rows[:moving, 1], rows[:moving, 2]]),
        radius,
    )


def draw(results, file):
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.4, 3.3), layout="constrained")
    chi = np.linspace(0.02, 1 / THICKNESS, 30)
    factors = [layerFactor(c) for c in chi]
    left.plot((chi * THICKNESS) ** 2, np.array(factors) * (chi * THICKNESS) ** 3, "k-", lw=1, label="layer")
    left.plot((chi * THICKNESS) ** 2, (chi * THICKNESS) ** 3, "k--", lw=0.8, label="half-space (Hertz)")
    for k, (s, rows, radius) in enumerate(results):
        a = s["cellsPerRadius"] * CELL
        left.plot(
            rows[:, 0] / (RATIO * a),
            rows[:, 1] / hertz(RATIO * a, radius),
            color=f"C{k}",
            lw=0.6,
            label=f"{s['types']}, {s['cellsPerRadius']} cells",
        )
        left.plot(
            s["depth"] / (RATIO * a),
            s["force"] / hertz(RATIO * a, radius),
            "o" if s["types"] == "apdi" else "x",
            color=f"C{k}",
            ms=5,
        )
        right.plot(s["cellsPerRadius"], 100 * s["error"], "o" if s["types"] == "apdi" else "x", color=f"C{k}")
    left.set(xlabel="depth d R / a²", ylabel="force over Hertz's at d = a²/R", xlim=(0, None), ylim=(0, None))
    left.legend(fontsize=8, title="lines: moving, points: at rest", title_fontsize=8)
    right.axhspan(-3, 3, color="0.9")
    right.axhline(0, color="k", lw=0.8)
    right.set(xlabel="cells per contact radius", ylabel="error of the force at rest (%)", xticks=(3, 4, 5, 6))
    right.text(0.98, 0.97, "o APDI   x uGIMP\ngrey: 3 %", ha="right", va="top", transform=right.transAxes)
    plot.save(figure, file)


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
    draw(results, os.path.join(a.out, "hertz.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), [r[0] for r in results])
    print(f"results in {a.out}/")


if __name__ == "__main__":
    commandLine.run(main)
