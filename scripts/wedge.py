#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A smooth wedge pressed into weightless soil: Hill's exact solution for clay, heave included.

Plane strain, rigid-plastic: a wedge of the half angle psi is pressed into Tresca soil of the strength su. The
field grows with the depth c of the tip below the first surface and keeps its shape, so every depth is another
resolution. With the fan angle theta (Hill, Lee & Tupper 1947)

    2 psi = theta + acos tan(pi/4 - theta/2),   p = 2 su (1 + theta),
    l = c / (cos psi - sin(psi - theta)),       F = 2 p l sin psi

p is the pressure on the faces, l the length of each in contact with the soil, up to the lip, which stands
l cos psi - c above the first surface. F/(su c) = 4.028, 8.943 and 19.186, lip height/c = 0.339, 0.420 and
0.467 for psi = 30, 45 and 60 degrees.

With friction and as much dilatancy the soil does not keep its volume: the lip is taken as measured, and gives
theta. The pressure on the faces is c cot phi ((1 + sin phi)/(1 - sin phi) exp(2 theta tan phi) - 1).

The run fits F = slope c + slope offset: the offset is how much deeper than it is the wedge is to the grid.

Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run wedge                       # psi = 45 degrees, cells of 0.1 m
    scripts/run wedge --psi 30 --cell 0.2
    scripts/run wedge --phi 20
    scripts/run wedge --types hybrid        # APDI where nothing flows

All of APDI there is no soil here: the wedge crosses its mesh, which is inverted after one and a half cells
with F-bar, and without resists 52 % too much.
"""

from math import acos, cos, degrees, exp, pi, radians, sin, tan

import numpy as np
import yade_mpm as mpm
from scipy.optimize import brentq
from yade_mpm import Parameter, app, box, plot
from yade_mpm.geotech import reference
from yade_mpm.geotech.meshes import wedgedColumn
from yade_mpm.geotech.reference import SHEAR, STRENGTH

RAMP = 0.02  # m, over which the rate grows from zero

PARAMETERS = mpm.Parameters(
    "wedge",
    __doc__,
    Parameter("psi", 45.0, "half angle of the wedge", unit="degrees", least=20, most=70),
    Parameter("phi", 0.0, "friction and dilatancy of the soil", unit="degrees", least=0, most=40),
    Parameter("cell", 0.1, "size of the grid's cells", unit="m", partOf=1.0),
    Parameter("depth", lambda a: 8 * a.cell, "of the tip at the end (default: 8 cells)", unit="m", above=0),
    Parameter("rate", 0.1, "of the wedge", unit="m/s", above=0),
    Parameter("types", "ugimp", "particle types of the soil", choices=("ugimp", "hybrid")),
    reference.FBAR,
    reference.CONSTRAINTS,
    smoke={"cell": 0.2, "depth": 1.2, "rate": 0.3},
)
arguments = PARAMETERS.parse


def exact(psi):
    """Hill's solution for a half angle in degrees: dict of fan angle (rad), F/(su c), and lip height/c."""
    psi = radians(psi)
    theta = brentq(lambda t: t + acos(tan(pi / 4 - t / 2)) - 2 * psi, 1e-9, pi / 2)
    length = 1 / (cos(psi) - sin(psi - theta))
    return {"fan": theta, "slope": 4 * (1 + theta) * length * sin(psi), "lip": length * cos(psi) - 1}


def withLip(psi, phi, lip):
    """Solution for a half angle and an angle of friction in degrees and a lip height/c: as `exact`.

    From the face, l, to the raised surface, s, slip lines grow from l/(2 cos(45 + phi/2)) by exp(theta tan
    phi) to s/(2 cos(45 - phi/2)).
    """
    psi, phi = radians(psi), radians(phi)
    face, legs = (1 + lip) / cos(psi), tan(pi / 4 + phi / 2)
    surface = lambda t: face * legs * exp(t * tan(phi))  # noqa: E731
    theta = brentq(lambda t: lip - surface(t) * sin(psi - t), 0, psi)
    pressure = (legs**2 * exp(2 * theta * tan(phi)) - 1) / tan(phi) if phi else 2 * (1 + theta)
    return {"fan": theta, "slope": 2 * pressure * face * sin(psi), "lip": lip}


def sizes(a):
    """Half width and height of the soil, half width of the wedge, half width and height of what flows, m:
    whole cells. The field of slip reaches one length of the face beyond the lip, and less below the tip;
    with friction further."""
    lip, psi, phi = exact(a.psi)["lip"], radians(a.psi), radians(a.phi)
    face = (1 + lip) * a.depth * tan(psi)
    length = face / sin(psi) * tan(pi / 4 + phi / 2) * exp(psi * tan(phi))

    def whole(x):
        return np.ceil(x / a.cell) * a.cell

    flows = whole(face + 1.2 * length), whole(a.depth + 0.9 * length)
    return whole(face + 2 * length), whole(a.depth + 1.5 * length), whole(face + 3 * a.cell), *flows


def build(a):
    """The scene: the tip of the wedge on the surface (without output)."""
    half, height, wide, across, below = sizes(a)
    rise = np.ceil((wide / tan(radians(a.psi)) + 2 * a.depth) / a.cell) * a.cell
    upper = np.ceil((1.1 * rise + 2 * a.cell) / a.cell) * a.cell
    scene = mpm.Scene((-half, -height), (half, upper), a.cell, threads=a.threads)
    angles = dict(frictionAngle=radians(a.phi), dilatancyAngle=radians(a.phi))
    drained = dict(lame=(1.5 * SHEAR, SHEAR), **angles) if a.phi else {}  # Poisson's ratio 0.3
    zone = box((-across, -below), (across, 0))
    reference.addSoil(scene, box((-half, -height), (half, 0)), a, zone, a.types, **drained)
    mesh = wedgedColumn(0.0, 0.0, 2 * wide, rise, 2 * a.psi, 0.5 * a.cell)
    walls = dict(roller=("left", "right"), fixed="bottom")
    reference.drive(scene, "wedge", mesh, a, RAMP, **walls)
    return scene


def lipOf(scene):
    """Height of the soil beside the wedge above the first surface, m."""
    return float(reference.soilOf(scene).position[:, 1].max() + 0.25 * min(scene.cell))


def run(a, scene=None):
    """Presses the wedge in; returns (summary, scene, depth (m), force (kN/m))."""
    scene = scene or build(a)
    summary, depth, force, _ = reference.press(a, scene, a.depth, RAMP)
    late = depth > min(3 * a.cell, 0.5 * a.depth)
    slope, constant = np.polyfit(depth[late], force[late] / STRENGTH, 1)
    lip = lipOf(scene) / depth[-1]
    theory = withLip(a.psi, a.phi, lip) if a.phi else exact(a.psi)
    summary |= {
        "slope": float(slope),
        "exactSlope": theory["slope"],
        "error": float(slope / theory["slope"] - 1),
        "offsetInCells": float(constant / slope / a.cell),
        "lip": lip,
        "exactLip": theory["lip"],
        "fanDegrees": degrees(theory["fan"]),
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
    edge, c = fieldEdge(a.psi, depth[-1]), depth[-1]

    def field(axes):
        plot.domains(axes, [reference.soilOf(scene)], reference.strain, (0, 1), "plastic shear strain")
        for side in (-1, 1) if not a.phi else ():
            axes.plot(side * edge[:, 0], edge[:, 1], "C0-", lw=1)

    far = 1.2 * edge[:, 0].max()
    window = dict(xlim=(-far, far), ylim=(-2.5 * c, 1.5 * c), xlabel="x (m)", ylabel="y (m)")
    theory = withLip(a.psi, a.phi, lipOf(scene) / c) if a.phi else exact(a.psi)
    label = "with the measured lip" if a.phi else "Hill, Lee & Tupper"
    lines = {label: (depth, theory["slope"] * STRENGTH * depth)}
    labels = "depth of the tip (m)", "force (kN/m)"
    reference.compare(file, field, (depth, force), lines, labels, window)


def tell(a, s):
    return (
        f"psi = {a.psi:g}, fan {s['fanDegrees']:.1f} degrees: F/(su c) = {s['slope']:.2f} "
        f"({s['error']:+.1%} of {s['exactSlope']:.3f}), offset {s['offsetInCells']:.2f} cells, "
        f"lip {s['lip']:.3f} c (exact {s['exactLip']:.3f})"
    )


def main():
    reference.main(PARAMETERS, run, draw, tell)


if __name__ == "__main__":
    app.run(main)
