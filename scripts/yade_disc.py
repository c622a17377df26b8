#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A disc of YADE slides or rolls down an incline of MPM soil: friction against the closed form.

Plane strain. The incline is level in the scene, and gravity is turned by 30 degrees. The disc is a YADE
sphere (R = 0.5 m) with the mass rho pi R^2 t and the inertia m R^2 / 2 of a disc of the thickness t = 0.25 m;
what would leave the plane is blocked. It slides with a = g (sin - mu cos) where mu < tan(30)/3 = 0.192, and
rolls with a = 2/3 g sin otherwise.

The disc is held along the slope until it has settled, then let go. YADE's own damping is off from then on: it
would act on the disc.

Units: Mg, m, s, kPa, kN.

    scripts/run yade_disc                      # mu = 0, 0.1, 0.3 and 0.6 on uGIMP and on APDI
    scripts/run yade_disc --friction 0.6 --types apdi --plane xz
    scripts/run yade_disc --smoke
"""

import os
import time

import numpy as np
import yade_mpm as mpm
from yade import ForceResetter, NewtonIntegrator, O, utils
from yade.minieigenHP import Vector3
from yade_disc_pictures import draw
from yade_mpm import Parameter, app, box
from yade_mpm.io import files
from yade_mpm.yade import Plane

SLOPE, G = np.radians(30), 9.81  # rad, m/s2
RADIUS, DENSITY, THICKNESS = 0.5, 2.0, 0.25  # m, Mg/m3, m
LENGTH, DEPTH, YOUNG = 2.8, 0.4, 1e5  # m, m, kPa
SETTLING, RUNNING = 0.3, 0.5  # s
MASS = DENSITY * np.pi * RADIUS**2 * THICKNESS  # Mg
BLOCKED = {"xy": "zXY", "xz": "yXZ", "yz": "xYZ"}  # degrees of freedom out of the plane


PARAMETERS = mpm.Parameters(
    "yade_disc",
    __doc__,
    Parameter("friction", [0.0, 0.1, 0.3, 0.6], "coefficients", several=True, least=0),
    Parameter("types", ["ugimp", "apdi"], "particle types", several=True, choices=("ugimp", "apdi")),
    Parameter("cell", 0.1, "size of the grid's cells", unit="m", partOf=DEPTH),
    Parameter("plane", "xy", "of YADE", choices=tuple(BLOCKED)),
    smoke={"friction": [0.1, 0.6], "types": ["apdi"]},
    threads=False,
)
arguments = PARAMETERS.parse


def closedForm(friction):
    """Acceleration along the slope, m/s2, and angular acceleration times the radius over it, -."""
    if friction < np.tan(SLOPE) / 3:
        acceleration = G * (np.sin(SLOPE) - friction * np.cos(SLOPE))
        return acceleration, 2 * friction * G * np.cos(SLOPE) / acceleration
    return 2 / 3 * G * np.sin(SLOPE), 1.0


def addDisc(plane):
    """A disc on the ground, 0.6 m from its left end; held along the slope. Returns its number."""
    number = O.bodies.append(utils.sphere(Vector3(*plane.toYade((0.6, DEPTH + RADIUS, 0))), RADIUS))
    state = O.bodies[number].state
    state.mass, state.inertia = MASS, Vector3(1, 1, 1) * MASS * RADIUS**2 / 2
    state.blockedDOFs = "xyzXYZ".replace("xyz"[plane.axes[1]], "")
    return number


def build(types, friction, cell=0.1, planeName="xy"):
    """Scene and disc in O; returns (coupling, number of the disc, its plane)."""
    O.reset()
    plane = Plane(planeName)
    gravity = np.array([np.sin(SLOPE), -np.cos(SLOPE), 0]) * G
    scene = mpm.Scene((0, 0), (LENGTH, 1.0), cell, gravity=gravity[:2], damping=0.3)
    scene.fix("bottom", "left", "right")
    kind = mpm.UGIMP(perCell=2) if types == "ugimp" else mpm.APDI(size=cell / 2)
    stiff = mpm.LinearElastic(density=2.0, young=YOUNG, poisson=0.3)
    scene.add("ground", box((0, 0), (LENGTH, DEPTH)), stiff, kind)
    disc = addDisc(plane)
    O.engines = [ForceResetter(), NewtonIntegrator(gravity=Vector3(*plane.toYade(gravity)), damping=0.3)]
    rolling = scene.contact(disc, friction=friction, thickness=THICKNESS, plane=planeName)
    rolling.contact.normalDamping = 0.2
    return mpm.inYade(scene, stages=False), disc, plane


class Track:
    """Time, place, velocity and spin times radius of the disc in every tenth cycle, along the slope; goes
    into `Coupling.exchanges`."""

    def __init__(self, disc, plane):
        self.state, self.plane, self.cycles, self.rows = O.bodies[disc].state, plane, 0, []

    def read(self, coupling):
        self.cycles += 1
        if self.cycles % 10 == 0:
            place, velocity, spin = (
                self.plane.toScene(list(v)) for v in (self.state.pos, self.state.vel, self.state.angVel)
            )
            self.rows.append((O.time, place[0], velocity[0], -spin[2] * RADIUS))

    def apply(self, coupling):
        pass


def runUntil(end):
    while O.time < end:
        O.run(int((end - O.time) / O.dt) + 1, True)


def run(types="apdi", friction=0.6, cell=0.1, planeName="xy"):
    """Lets the disc settle, then go; returns (summary, rows of time, place, velocity, spin times radius
    since then)."""
    began = time.monotonic()
    coupling, disc, plane = build(types, friction, cell, planeName)
    runUntil(SETTLING)
    state, track, start = O.bodies[disc].state, Track(disc, plane), O.time
    state.vel, state.blockedDOFs, O.engines[-1].damping = Vector3.Zero, BLOCKED[planeName], 0.0
    coupling.exchanges.append(track)
    runUntil(start + RUNNING)
    rows = np.array(track.rows) - (start, 0, 0, 0)
    late = rows[:, 0] > 0.1
    found, spinning = (np.polyfit(rows[late, 0], rows[late, k], 1)[0] for k in (2, 3))
    expected, ratio = closedForm(friction)
    summary = dict(types=types, friction=friction, cell=cell, plane=planeName, steps=coupling.scene.steps)
    summary |= dict(acceleration=found, closedForm=expected, error=found / expected - 1)
    summary |= dict(spinOverAcceleration=spinning / found, closedFormSpin=ratio)
    summary["outOfPlane"] = float(abs(plane.toScene(list(state.pos))[2]))
    return summary | dict(wallSeconds=time.monotonic() - began), rows


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    results = []
    for types in a.types:
        for friction in a.friction:
            results.append(run(types, friction, a.cell, a.plane))
            s = results[-1][0]
            found = f"{s['acceleration']:.4f} m/s2 ({s['error']:+.2%} of {s['closedForm']:.4f})"
            spin = f"{s['spinOverAcceleration']:.3f} ({s['closedFormSpin']:.3f})"
            print(f"{types}, mu = {friction:g}: {found}, spin over acceleration {spin}", flush=True)
    incline = dict(slope=SLOPE, length=LENGTH, depth=DEPTH, radius=RADIUS, running=RUNNING)
    draw(results, os.path.join(a.out, "velocity.png"), incline, closedForm)
    files.saveJson(os.path.join(a.out, "summary.json"), [s for s, _ in results])
    print(f"results in {a.out}/")


if __name__ == "__main__":
    app.run(main)
