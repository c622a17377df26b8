#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A smooth wedge pressed into undrained clay: Hill's exact solution, heave included.

Plane strain, weightless, rigid-plastic: a wedge of the half angle psi is pressed into Tresca soil of the
strength su. The field grows with the depth c of the tip below the first surface and keeps its shape, so every
depth is another resolution. With the fan angle theta (Hill, Lee & Tupper 1947)

    2 psi = theta + acos tan(pi/4 - theta/2),   p = 2 su (1 + theta),
    l = c / (cos psi - sin(psi - theta)),       F = 2 p l sin psi

p is the pressure on the faces, l the length of each in contact with the soil, up to the lip, which stands
l cos psi - c above the first surface. F/(su c) = 4.028, 8.943 and 19.186, lip height/c = 0.339, 0.420 and
0.467 for psi = 30, 45 and 60 degrees.

The run fits F = slope c + slope offset: the offset is how much deeper than it is the wedge is to the grid.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run wedge                       # psi = 45 degrees, cells of 0.1 m
    scripts/run wedge --psi 30 --cell 0.2
"""

import os
import time
from math import acos, cos, degrees, pi, radians, sin, tan

import numpy as np
import yade_mpm as mpm
from scipy.optimize import brentq
from yade_mpm import Parameter, box, commandLine, files, plot, study
from yade_mpm.study.meshes import wedgedColumn

STRENGTH, SHEAR, POISSON, DENSITY = 10.0, 1000.0, 0.49, 1.5  # kPa, kPa, -, Mg/m3
RAMP = 0.02  # m, over which the rate grows from zero

PARAMETERS = mpm.Parameters(
    "wedge",
    __doc__,
    Parameter("psi", 45.0, "half angle of the wedge", unit="degrees", least=20, most=70),
    Parameter("cell", 0.1, "size of the grid's cells", unit="m", partOf=1.0),
    Parameter("depth", lambda a: 8 * a.cell, "of the tip at the end (default: 8 cells)", unit="m", above=0),
    Parameter("rate", 0.1, "of the wedge", unit="m/s", above=0),
    Parameter("noFbar", False, "without F-bar: the soil locks"),
    Parameter("constraints", "nodes", "as of Contact", choices=("nodes", "facets")),
    smoke={"cell": 0.2, "depth": 1.2, "rate": 0.3},
)
arguments = PARAMETERS.parse


def exact(psi):
    """Hill's solution for a half angle in degrees: dict of fan angle (rad), F/(su c), and lip height/c."""
    psi = radians(psi)
    theta = brentq(lambda t: t + acos(tan(pi / 4 - t / 2)) - 2 * psi, 1e-9, pi / 2)
    length = 1 / (cos(psi) - sin(psi - theta))
    return {"fan": theta, "slope": 4 * (1 + theta) * length * sin(psi), "lip": length * cos(psi) - 1}


def sizes(a):
    """Half width and height of the soil and half width of the wedge, m: whole cells. The field of slip
    reaches one length of the face beyond the lip, and less below the tip."""
    reference, psi = exact(a.psi), radians(a.psi)
    face = (1 + reference["lip"]) * a.depth * tan(psi)
    length = face / sin(psi)

    def whole(x):
        return np.ceil(x / a.cell) * a.cell

    return whole(face + 2 * length), whole(a.depth + 1.5 * length), whole(face + 3 * a.cell)


def build(a):
    """The scene: the tip of the wedge on the surface (without output)."""
    half, height, wide = sizes(a)
    rise = np.ceil((wide / tan(radians(a.psi)) + 2 * a.depth) / a.cell) * a.cell
    upper = np.ceil((1.1 * rise + 2 * a.cell) / a.cell) * a.cell
    scene = mpm.Scene((-half, -height), (half, upper), a.cell, threads=a.threads)
    lame = 2 * SHEAR * POISSON / (1 - 2 * POISSON), SHEAR
    clay = mpm.MohrCoulombDruckerPrager(density=DENSITY, lame=lame, cohesion=STRENGTH, frictionAngle=0.0)
    boxes = mpm.UGIMP(perCell=2, splitAt=1.3)
    region = box((-half, -height), (half, 0))
    scene.add("soil", region, clay, boxes, fbar=not a.noFbar, group="soil")
    mesh = mpm.Mesh(*wedgedColumn(0.0, 0.0, 2 * wide, rise, 2 * a.psi, 0.5 * a.cell))
    rigid = mpm.LinearElastic(density=DENSITY, lame=lame)  # driven whole
    wedge = scene.add("wedge", mesh, rigid, mpm.APDI(), group="wedge")
    drive = mpm.Drive(wedge, velocity=(0, -a.rate), ramp=RAMP / a.rate)
    scene.engines = [
        mpm.ParticleToGrid(),
        mpm.GridSolver(damping=0.05, roller=("left", "right"), fixed="bottom", drive=drive),
        mpm.Contact(impactLoss=1.0, constraints=a.constraints),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    return scene


def lipOf(scene):
    """Height of the soil beside the wedge above the first surface, m."""
    soil = scene["soil"]
    return float(soil.position[:, 1].max() + 0.25 * min(scene.cell))


def run(a, scene=None):
    """Presses the wedge in; returns (summary, scene, depth (m), force (kN/m))."""
    began, scene = time.monotonic(), scene or build(a)
    until = a.depth / a.rate + 0.5 * RAMP / a.rate
    history = mpm.History(period=until / 400)
    scene.engines = [*scene.engines, history]
    scene.run(until=until)
    depth, force = study.travel(history["time"], a.rate, RAMP / a.rate), -history["drive.fy"]
    late = depth > min(3 * a.cell, 0.5 * a.depth)
    slope, constant = np.polyfit(depth[late], force[late] / STRENGTH, 1)
    reference = exact(a.psi)
    lip = lipOf(scene) / depth[-1]
    summary = {
        **study.record(a, scene, time.monotonic() - began),
        "slope": float(slope),
        "exactSlope": reference["slope"],
        "error": float(slope / reference["slope"] - 1),
        "offsetInCells": float(constant / slope / a.cell),
        "lip": lip,
        "exactLip": reference["lip"],
        "dampedShare": mpm.quasiStatic(history).dampedShare,
    }
    return summary, scene, depth, force


def fieldEdge(psi, depth):
    """Edge of Hill's field on the right (n, 2), m: tip, along the slip lines round the lip, surface, lip."""
    reference, psi = exact(psi), radians(psi)
    length = depth * (1 + reference["lip"]) / cos(psi)  # of the face in contact, and of the raised surface
    lip = np.array([length * sin(psi), reference["lip"] * depth])
    turn = 1.75 * pi - psi + np.linspace(0, reference["fan"], 30)  # slip lines meet both at 45 degrees
    fan = lip + length / np.sqrt(2) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    slope = psi - reference["fan"]
    foot = lip + length * np.array([cos(slope), -sin(slope)])
    return np.vstack([[0, -depth], fan, foot, lip])


def draw(a, scene, depth, force, file):
    """Plastic strain with Hill's field, and force over depth."""
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.6, 4.2), layout="constrained")
    bodies = [scene["soil"]]
    plot.domains(left, bodies, lambda body: body.plasticShearStrain, (0, 1), "plastic shear strain")
    edge, c = fieldEdge(a.psi, depth[-1]), depth[-1]
    for side in (-1, 1):
        left.plot(side * edge[:, 0], edge[:, 1], "C0-", lw=1)
    far = 1.2 * edge[:, 0].max()
    left.set(xlim=(-far, far), ylim=(-2.5 * c, 1.5 * c), xlabel="x (m)", ylabel="y (m)")
    right.plot(depth, force, "C3", lw=1)
    line = exact(a.psi)["slope"] * STRENGTH * depth
    right.plot(depth, line, "k--", lw=0.9, label="Hill, Lee & Tupper")
    right.set(xlabel="depth of the tip (m)", ylabel="force (kN/m)", xlim=(0, None), ylim=(0, None))
    right.legend(loc="lower right")
    plot.save(figure, file)


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summary, scene, *curve = run(a)
    draw(a, scene, *curve, os.path.join(a.out, "wedge.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), summary)
    print(
        f"psi = {a.psi:g}, fan {degrees(exact(a.psi)['fan']):.1f} degrees: F/(su c) = {summary['slope']:.2f} "
        f"({summary['error']:+.1%} of {summary['exactSlope']:.3f}), offset "
        f"{summary['offsetInCells']:.2f} cells, lip {summary['lip']:.3f} c (exact "
        f"{summary['exactLip']:.3f}); results in {a.out}/"
    )


if __name__ == "__main__":
    commandLine.run(main)
