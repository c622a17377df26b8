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
from yade_mpm import box, commandLine, files, inYade, plot
from yade_mpm.commandLine import notNegative, partOf
from yade_mpm.yadePlane import Plane

SLOPE, G = np.radians(30), 9.81  # rad, m/s2
RADIUS, DENSITY, THICKNESS = 0.5, 2.0, 0.25  # m, Mg/m3, m
LENGTH, DEPTH, YOUNG = 2.8, 0.4, 1e5  # m, m, kPa
SETTLING, RUNNING = 0.3, 0.5  # s
MASS = DENSITY * np.pi * RADIUS**2 * THICKNESS  # Mg
BLOCKED = {"xy": "zXY", "xz": "yXZ", "yz": "xYZ"}  # degrees of freedom out of the plane


def arguments(given=None):
    p = commandLine.Parser(
        "yade_disc", __doc__, smoke={"friction": [0.1, 0.6], "types": ["apdi"]}, threads=False
    )
    p.add_argument(
        "--friction",
        type=notNegative,
        nargs="+",
        default=[0.0, 0.1, 0.3, 0.6],
        help="coefficients, - (default 0 0.1 0.3 0.6)",
    )
    p.add_argument(
        "--types",
        choices=("ugimp", "apdi"),
        nargs="+",
        default=["ugimp", "apdi"],
        help="particle types (default both)",
    )
    p.add_argument(
        "--cell",
        type=partOf(DEPTH),
        default=0.1,
        help="cell size, m: 0.4 m over a whole number (default %(default)s)",
    )
    p.add_argument(
        "--plane", choices=tuple(BLOCKED), default="xy", help="plane of YADE (default %(default)s)"
    )
    return p.parse(given)


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
    scene = mpm.Scene((0, 0), (LENGTH, 1.0), cell)
    kind = mpm.UGIMP(perCell=2) if types == "ugimp" else mpm.APDI(size=cell / 2)
    scene.add(
        "ground", box((0, 0), (LENGTH, DEPTH)), mpm.LinearElastic(density=2.0, young=YOUNG, poisson=0.3), kind
    )
    contact = mpm.RigidContact(normalDamping=0.2)
    scene.engines = [
        mpm.ParticleToGrid(),
        contact,
        mpm.GridSolver(gravity=gravity[:2], damping=0.3, fixed=("bottom", "left", "right")),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    disc = addDisc(plane)
    O.engines = [ForceResetter(), NewtonIntegrator(gravity=Vector3(*plane.toYade(gravity)), damping=0.3)]
    bodies = inYade.Bodies(contact, [disc], friction=friction, thickness=THICKNESS, plane=planeName)
    coupling = inYade.attach(scene, stages=False)
    coupling.exchanges.append(bodies)
    return coupling, disc, plane


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
    return {
        "types": types,
        "friction": friction,
        "cell": cell,
        "plane": planeName,
        "acceleration": found,
        "closedForm": expected,
        "error": found / expected - 1,
        "spinOverAcceleration": spinning / found,
        "closedFormSpin": ratio,
        "outOfPlane": float(abs(plane.toScene(list(state.pos))[2])),
        "steps": coupling.scene.steps,
        "wallSeconds": time.monotonic() - began,
    }, rows


def draw(results, file):
    figure, (left, right) = plot.plt.subplots(
        1, 2, figsize=(8.4, 3.3), layout="constrained", width_ratios=(1.1, 1)
    )
    drawIncline(left, results[-1][1][-1, 1])
    frictions = sorted({s["friction"] for s, _ in results})
    for summary, rows in results:
        colour, isMeshed = f"C{frictions.index(summary['friction'])}", summary["types"] == "apdi"
        right.plot(
            rows[::24, 0],
            rows[::24, 2],
            "o" if isMeshed else "x",
            color=colour,
            ms=4,
            mfc="none",
            label=f"μ = {summary['friction']:g}" if summary["types"] == results[-1][0]["types"] else None,
        )
    for friction in frictions:
        right.plot(
            [0, RUNNING],
            [0, RUNNING * closedForm(friction)[0]],
            "-",
            color=f"C{frictions.index(friction)}",
            lw=0.8,
        )
    right.set(
        xlabel="time since it was let go (s)",
        ylabel="velocity along the slope (m/s)",
        xlim=(0, None),
        ylim=(0, None),
    )
    right.legend(title="x uGIMP, o APDI, lines: closed form", title_fontsize=8, fontsize=8)
    plot.save(figure, file)


def drawIncline(axes, last):
    """The ground and a disc at its first and last place, as they lie under gravity."""
    turn = np.array([[np.cos(SLOPE), np.sin(SLOPE)], [-np.sin(SLOPE), np.cos(SLOPE)]])
    ground = np.array([(0, 0), (LENGTH, 0), (LENGTH, DEPTH), (0, DEPTH)]) @ turn.T
    axes.fill(*ground.T, fc="0.85", ec="0.4")
    circle = RADIUS * np.array([(np.cos(t), np.sin(t)) for t in np.linspace(0, 2 * np.pi, 100)])
    for x, spin, style in ((0.6, 0.0, "--"), (last, (0.6 - last) / RADIUS, "-")):
        axes.plot(*((circle + (x, DEPTH + RADIUS)) @ turn.T).T, "C3" + style, lw=1.2)
        spoke = np.array([(0, 0), RADIUS * np.array((np.cos(spin), np.sin(spin)))]) + (x, DEPTH + RADIUS)
        axes.plot(*(spoke @ turn.T).T, "C3" + style, lw=1.2)
    axes.set(aspect="equal", xlabel="m", ylabel="m")


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
    draw(results, os.path.join(a.out, "velocity.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), [s for s, _ in results])
    print(f"results in {a.out}/")


if __name__ == "__main__":
    commandLine.run(main)
