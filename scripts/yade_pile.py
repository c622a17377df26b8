# SPDX-License-Identifier: GPL-2.0-or-later
"""A rigid sheet pile of YADE slides into the soil of the sheet pile scene: one loop of O.engines.

The pile is one clump of YADE, driven at a constant rate or by a hammer (a sphere that falls on its head);
ground, material constants and mesh are those of sheet_pile.py, where the pile is elastic and bonded to the
soil. Plane strain. Beside --smoke the time step is larger, too, and the balance of forces is checked in every
step. Without --threads the soil has as many as YADE, one without -j.

Units: Mg, m, s, kPa, per metre of thickness.
"""

import argparse
import csv
import glob
import json
import os
import sys
import time

import numpy as np
import yade_mpm as mpm
from matplotlib.patches import Circle, Rectangle
from yade import (
    Bo1_Box_Aabb,
    Bo1_Sphere_Aabb,
    Box,
    ForceResetter,
    Ig2_Box_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    PyRunner,
    Quaternion,
    ViscElMat,
    VTKRecorder,
    utils,
)
from yade_mpm import commandLine, files, inYade, plot, study
from yade_mpm.commandLine import below, count, notNegative, positive

sys.path.insert(0, os.path.dirname(os.path.abspath(sys.argv[0])))
import sheet_pile  # noqa: E402
from sheet_pile import DEPTH, EMBEDDED, GRAVITY, K0, PILE_LENGTH, WIDTH  # noqa: E402

RESULTS = os.path.join("results", "yade_pile")
BATCH, MERGED = os.path.join(RESULTS, "batch"), os.path.join(RESULTS, "batch.csv")
FRICTIONS = (0.0, 0.3, 0.6)
IGNORED = {"velocity": ("hammer", "drop", "blows", "damping"), "hammer": ("rate", "ramp")}
HAMMER_RADIUS = 0.5  # m
HAMMER_PERIOD = 2.0  # s
CUSHION = {
    "kn": 2e5,
    "cn": 1200.0,
    "ks": 1e5,
    "cs": 0.0,
}  # kN/m, kN s/m of each side; two in series: 1e5, 600, restitution 0.4


def options():
    p = commandLine.Parser("yade_pile", __doc__, smoke={"penetration": 0.6, "blows": 1})
    p.add_argument(
        "--friction", type=notNegative, default=0.3, help="between pile and soil (default %(default)s)"
    )
    p.add_argument("--drive", choices=("velocity", "hammer"), default="velocity", help="what moves the pile")
    tip = "a tilted box, a sphere or a box below the shaft"
    p.add_argument("--tip", choices=("wedge", "round", "flat"), default="wedge", help=tip)
    p.add_argument("--cell", type=positive, default=0.25, help="cell size, m (default %(default)s)")
    p.add_argument("--thickness", type=positive, default=0.5, help="of the pile, m (default %(default)s)")
    p.add_argument("--rate", type=positive, default=0.5, help="penetration rate, m/s (default %(default)s)")
    p.add_argument(
        "--ramp", type=notNegative, default=0.5, help="while the rate grows, s (default %(default)s)"
    )
    p.add_argument("--penetration", type=positive, default=4.0, help="how far, m (default %(default)s)")
    p.add_argument(
        "--hammer", type=positive, default=10.0, help="mass of the hammer, Mg (default %(default)s)"
    )
    p.add_argument("--drop", type=positive, default=2.0, help="height of its fall, m (default %(default)s)")
    p.add_argument(
        "--blows", type=count, default=5, help="number of blows, one every 2 s (default %(default)s)"
    )
    damping = "YADE's local damping of the hammered pile (default %(default)s)"
    p.add_argument("--damping", type=below(1), default=0.2, help=damping)
    p.add_argument(
        "--dt", type=positive, help="time step, s (default 1e-3 times the cell in m: stiff contact)"
    )
    p.add_argument("--compare", action="store_true", help="friction 0, 0.3, 0.6 and the bonded elastic pile")
    merge = "only collect what yade-batch has run into results/yade_pile/batch.csv"
    p.add_argument("--merge", action="store_true", help=merge)
    return p


def arguments():
    """Arguments of the line of the table that yade-batch runs, then those of the command line."""
    parser = options()
    defaults = vars(parser.parse_args([]))
    utils.readParamsFromTable(**defaults)
    from yade.params import table

    given = {name: getattr(table, name) for name in defaults if getattr(table, name) != defaults[name]}
    words = [f"--{name}" if value is True else f"--{name}={value}" for name, value in given.items()]
    words += sys.argv[1:]
    a = parser.parse(words)
    parser.refuseBeside(words, f"--drive {a.drive}", IGNORED[a.drive], "it belongs to the other drive")
    if a.compare:
        parser.refuseBeside(words, "--compare", ("friction",), "it runs " + ", ".join(map(str, FRICTIONS)))
    if EMBEDDED + a.penetration > PILE_LENGTH - a.cell:
        parser.error(f"the pile of {PILE_LENGTH} m would vanish in the ground; lower --penetration")
    a.dt = a.dt or (min(4e-4, 1.6e-3 * a.cell) if a.smoke else 1e-3 * a.cell)
    if "YADE_BATCH" in os.environ:  # a folder of its own
        parser.fill(a, words, out=os.path.join(BATCH, O.tags["id"]))
    bonded(a)  # refuses what does not fit its ground
    return a


# --- the scene ----------------------------------------------------------------------------------------------
def soil(a, contact):
    """The ground of the sheet pile scene with the shaft left empty, and the contact in its step."""
    scene, _ = sheet_pile.ground(bonded(a))
    scene.initialStress(surface=DEPTH, K0=K0, gravity=GRAVITY)
    scene.engines = [
        mpm.ParticleToGrid(),
        contact,
        mpm.GridSolver(**sheet_pile.SOLVER),
        mpm.GridToParticle(),
        mpm.DomainUpdater(),
    ]
    scene.dt = a.dt
    return scene


def bonded(a):
    """Arguments of the sheet pile scene with the same soil, cell and rate."""
    fixed = dict(thickness=a.thickness, ramp=a.ramp)
    parameters = sheet_pile.PARAMETERS.extended("yade_pile", __doc__, fixed=fixed)
    until = a.penetration / a.rate + 0.5 * a.ramp
    words = ["--cell", a.cell, "--rate", a.rate, "--until", until, "--out", os.path.join(a.out, "bonded")]
    words += ["--threads", a.threads] if a.threads else []
    return parameters.parse([str(word) for word in words])


def pile(a):
    """The pile, one clump of two bodies one metre thick; returns its number."""
    half, x, bottom = a.thickness / 2, WIDTH / 2, DEPTH - EMBEDDED
    steel = O.materials.append(ViscElMat(density=7.85, frictionAngle=0, **CUSHION))
    joint = bottom + half
    if a.tip == "wedge":
        side = half / np.sqrt(2)
        tip = utils.box(
            (x, joint, 0), (side, side, 0.5), orientation=Quaternion((0, 0, 1), np.pi / 4), material=steel
        )
    elif a.tip == "round":
        tip = utils.sphere((x, joint, 0), half, material=steel)
    else:
        tip = utils.box((x, joint, 0), (half, half, 0.5), material=steel)
        joint += half
    top = bottom + PILE_LENGTH
    shaft = utils.box((x, (joint + top) / 2, 0), (half, (top - joint) / 2, 0.5), material=steel)
    number, _ = O.bodies.appendClumped([tip, shaft])
    O.bodies[number].state.blockedDOFs = "xyzXYZ" if a.drive == "velocity" else "xzXYZ"
    return number


class Ramp(PyRunner):
    """The rate of the pile grows from zero to its value; velocities of the middles of the steps make the
    depth exact."""

    def __init__(self, a, number):
        super().__init__(command="driver.act()", label="driver", iterPeriod=1, initRun=True)
        self.rate, self.ramp, self.pile = a.rate, a.ramp, O.bodies[number].state
        self.until = a.penetration / a.rate + 0.5 * a.ramp

    def act(self):
        share = min(1.0, (O.time + 0.5 * O.dt) / self.ramp) if self.ramp else 1.0
        self.pile.vel = (0, -self.rate * share, 0)


class Hammer(PyRunner):
    """A sphere falls on the head of the pile every two seconds; before that the pile sinks under its own
    weight."""

    def __init__(self, a, number):
        # YADE counts the start as the first of nDo.
        super().__init__(command="driver.act()", label="driver", virtPeriod=HAMMER_PERIOD, nDo=a.blows + 1)
        self.pile, self.drop = O.bodies[number].state, a.drop
        self.until = (a.blows + 1) * HAMMER_PERIOD
        self.head = DEPTH - EMBEDDED + PILE_LENGTH - self.pile.pos[1]
        steel = ViscElMat(density=a.hammer / (4 / 3 * np.pi * HAMMER_RADIUS**3), frictionAngle=0, **CUSHION)
        sphere = utils.sphere((WIDTH / 2, 0, 0), HAMMER_RADIUS, material=O.materials.append(steel))
        self.hammer = O.bodies[O.bodies.append(sphere)].state
        self.hammer.isDamped = False
        self.lift()
        self.hammer.blockedDOFs = "xyzXYZ"

    def lift(self):
        self.hammer.pos = (WIDTH / 2, self.pile.pos[1] + self.head + HAMMER_RADIUS + self.drop, 0)
        self.hammer.vel = (0, 0, 0)

    def act(self):
        self.lift()
        self.hammer.blockedDOFs = "xzXYZ"


class Gauge:
    """Force of the soil on the pile, mean since it was last read, and where the pile is."""

    def __init__(self, contact, number):
        self.contact, self.force, self.samples, self.overlap = contact, 0.0, 0, 0.0
        self.start = O.bodies[number].state.pos[1]
        self.columns = {
            "pile.depth": lambda scene: self.start - contact.positions[0, 1],
            "pile.vy": lambda scene: contact.velocities[0, 1],
            "pile.fy": self.mean,
        }

    def sample(self):
        self.force, self.samples = self.force + self.contact.forces[0, 1], self.samples + 1
        self.overlap = max(self.overlap, self.contact.largestPenetration)

    def mean(self, scene):
        mean = self.force / self.samples
        self.force, self.samples = 0.0, 0
        return mean


# --- a run --------------------------------------------------------------------------------------------------
def run(a, out):
    """Runs pile and soil in one loop and leaves the results in a folder; returns what `draw` needs."""
    os.makedirs(os.path.join(out, "vtk"), exist_ok=True)
    if len(O.bodies):
        O.reset()
    number = pile(a)
    drive = Ramp(a, number) if a.drive == "velocity" else Hammer(a, number)
    O.engines = [
        VTKRecorder(
            fileName=os.path.join(out, "vtk", "pile-"),
            recorders=["boxes", "spheres"],
            virtPeriod=drive.until / 40,
        ),
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()], verletDist=0.1),
        InteractionLoop(
            [Ig2_Box_Sphere_ScGeom()],
            [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
            [Law2_ScGeom_ViscElPhys_Basic()],
        ),
        drive,
        NewtonIntegrator(gravity=(0, -GRAVITY, 0), damping=a.damping),
    ]

    contact = mpm.RigidContact(checkBalance=a.smoke)
    gauge = Gauge(contact, number)
    scene = soil(a, contact)
    history = mpm.History(
        period=drive.until / 800, file=os.path.join(out, "history.csv"), columns=gauge.columns
    )
    scene.engines = scene.engines + [
        mpm.PyRunner(gauge.sample, iterPeriod=1),
        history,
        mpm.Recorder(os.path.join(out, "vtk", "soil.vtkhdf"), period=drive.until / 40),
    ]
    bodies = inYade.Bodies(contact, [number], friction=a.friction)
    O.dt = a.dt
    coupling = inYade.attach(scene, stages=False)
    coupling.exchanges.append(bodies)

    steps = round(drive.until / O.dt)
    print(
        f"friction {a.friction}, {a.drive}: {scene.particleCount} soil particles, {scene.threads} threads; "
        f"{steps} steps of {O.dt:.3g} s (critical {scene.dtCritical:.3g} s)",
        flush=True,
    )
    began = time.monotonic()
    O.run(steps, True)
    wall = time.monotonic() - began
    coupling.flush()
    return report(a, out, number, scene, history, gauge, wall)


def report(a, out, number, scene, history, gauge, wall):
    """Files of a run, and what its picture needs."""
    depth, raw = history["pile.depth"], history["pile.fy"]
    curves = {
        "time": history["time"],
        "depth": depth,
        "raw": raw,
        "base": history["bottom.fy"] - weight(scene),
    }
    if a.drive == "velocity":
        curves["smooth"] = study.movingAverage(depth, raw, a.cell)
        curves["base"] = study.movingAverage(depth, curves["base"], a.cell)
    table(os.path.join(out, "resistance.csv"), curves)
    state = O.bodies[number].state
    summary = {
        "id": O.tags["id"],
        "description": O.tags["description"] if "description" in set(O.tags.keys()) else "",
        "arguments": vars(a),
        "steps": scene.steps,
        "dt": scene.dt,
        "dtCritical": scene.dtCritical,
        "wallSeconds": wall,
        "threads": scene.threads,
        "particles": scene.particleCount,
        "largestOverlap": gauge.overlap,
        "kineticRatio": float(np.nanmax(history["kineticRatio"][depth > a.cell], initial=0)),
        "pileMass": state.mass,
        "pileVelocity": state.vel[1],
        "penetration": gauge.start - state.pos[1],
    }
    if a.drive == "velocity":
        summary["resistance"] = study.atSteps(depth, curves["smooth"])
        summary["resistanceAtBase"] = study.atSteps(depth, curves["base"])
    else:
        ends = HAMMER_PERIOD * np.arange(1, a.blows + 2)
        summary["afterBlow"] = {
            f"{n}": float(d) for n, d in enumerate(np.interp(ends, curves["time"], depth))
        }
    files.saveJson(os.path.join(out, "summary.json"), summary)
    return {
        **curves,
        "summary": summary,
        "scene": scene,
        "soil": plot.Snapshot(scene, "plasticShearStrain"),
        "pile": outline(number),
    }


def weight(scene):
    return sum(b.mass.sum() for b in scene.bodies) * GRAVITY


def table(file, columns):
    files.saveTable(file, columns)


# --- pictures -----------------------------------------------------------------------------------------------
def outline(number):
    """The bodies of the clump as matplotlib draws them."""
    style = dict(facecolor="0.55", edgecolor="0.2", linewidth=0.6)
    patches = []
    for member in O.bodies[number].shape.members:
        body = O.bodies[member]
        x, y, _ = body.state.pos
        if isinstance(body.shape, Box):
            half, angle = body.shape.extents, np.degrees(2 * np.arctan2(body.state.ori[2], body.state.ori[3]))
            patches.append(
                Rectangle(
                    (x - half[0], y - half[1]),
                    2 * half[0],
                    2 * half[1],
                    angle=angle,
                    rotation_point="center",
                    **style,
                )
            )
        else:
            patches.append(Circle((x, y), body.shape.radius, **style))
    return patches


def panel(a, ax, result, title):
    """Deformed soil, coloured by plastic shear strain, and the pile."""
    window = (WIDTH / 2 - 3.5, WIDTH / 2 + 3.5, DEPTH - EMBEDDED - a.penetration - 2.0, DEPTH + 2.0)
    coloured = result["soil"].draw(ax, 1.0, window=window)
    for patch in result["pile"]:
        ax.add_patch(patch)
    ax.set(title=title, xlabel="x (m)")
    return coloured


def draw(a, results, file):
    """Deformed soil of every run and, in the last panel, the curves. results : dict title -> result."""
    figure, axes = plot.plt.subplots(
        1,
        len(results) + 1,
        figsize=(2.9 * len(results) + 3.4, 4.0),
        layout="constrained",
        width_ratios=[1] * len(results) + [1.15],
    )
    for ax, (title, result) in zip(axes, results.items()):
        coloured = panel(a, ax, result, title)
    axes[0].set_ylabel("y (m)")
    figure.colorbar(coloured, ax=axes[:-1], label="plastic shear strain (-)", extend="max", shrink=0.7)
    (curvesOfBlows if a.drive == "hammer" else curvesOfResistance)(axes[-1], results)
    plot.save(figure, file)


def curvesOfResistance(ax, results):
    for title, result in results.items():
        style = dict(color="k", ls="--") if "bonded" in title else {}
        ax.plot(result["smooth"], result["depth"], label=title, **style)
    ax.set(xlabel="resistance, mean over one cell (kN/m)", ylabel="further penetration (m)", xlim=(0, None))
    ax.invert_yaxis()
    ax.legend()


def curvesOfBlows(ax, results):
    for title, result in results.items():
        ax.plot(result["time"], result["depth"], label=title)
    ax.set(xlabel="time (s)", ylabel="further penetration (m)")
    ax.invert_yaxis()
    ax.legend()


# --- several runs -------------------------------------------------------------------------------------------
def compare(a):
    """All friction coefficients and, unless a hammer drives it, the bonded pile."""
    results = {}
    for friction in FRICTIONS:
        b = argparse.Namespace(**{**vars(a), "friction": friction})
        results[f"friction {friction}"] = run(b, os.path.join(a.out, f"friction-{friction}"))
        print_(results[f"friction {friction}"]["summary"])
    if a.drive == "velocity":
        results["bonded, elastic"] = runBonded(a)
        print_(results["bonded, elastic"]["summary"])
    return results


def runBonded(a):
    """The sheet pile scene in its own loop, as a result like the others."""
    b = bonded(a)
    summary, scene, history = sheet_pile.run(b)
    depth, raw, smooth = sheet_pile.resistanceCurve(b, scene, history)
    return {
        "depth": depth,
        "raw": raw,
        "smooth": smooth,
        "summary": summary,
        "pile": [],
        "soil": plot.Snapshot(scene, "plasticShearStrain"),
    }


def print_(summary):
    given = summary.get("resistance") or summary["afterBlow"]
    what = "resistance in kN/m at depth in m" if "resistance" in summary else "penetration in m after blow"
    print(
        f"{summary['steps']} steps in {summary['wallSeconds']:.1f} s; {what}: "
        + ", ".join(f"{k}: {v:.4g}" for k, v in given.items())
    )


def merge(folder=BATCH, file=MERGED):
    """One CSV of all runs of yade-batch: a row each, with what was given and what came out."""
    rows = []
    for name in sorted(glob.glob(os.path.join(folder, "*", "summary.json"))):
        with open(name) as summary:
            s = json.load(summary)
        given = {k: v for k, v in s["arguments"].items() if k not in ("out", "compare", "merge", "smoke")}
        found = {f"resistance at {k} m": v for k, v in s.get("resistance", {}).items()}
        found.update({f"depth after blow {k}": v for k, v in s.get("afterBlow", {}).items()})
        rows.append(
            {
                "id": s["id"],
                "description": s["description"],
                **given,
                "steps": s["steps"],
                "wallSeconds": s["wallSeconds"],
                **found,
            }
        )
    if not rows:
        raise SystemExit(f"yade_pile: there is no run in {folder}; run yade-batch first")
    columns = list(dict.fromkeys(name for row in rows for name in row))
    with files.replacing(file) as part, open(part, "w", newline="") as out:
        writer = csv.DictWriter(out, columns)
        writer.writeheader()
        writer.writerows(rows)
    print(f"{len(rows)} runs in {file}")


def main():
    a = arguments()
    if a.merge:
        merge()
        return
    if a.compare:
        results = compare(a)
    else:
        results = {f"friction {a.friction}": run(a, a.out)}
        print_(results[f"friction {a.friction}"]["summary"])
    draw(a, results, os.path.join(a.out, "yade_pile.png"))
    print(f"results in {a.out}/")


if __name__ == "__main__":
    commandLine.run(main)
