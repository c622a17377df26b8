# SPDX-License-Identifier: GPL-2.0-or-later
"""A rigid sheet pile of YADE slides into the soil of the sheet pile scene: one loop of O.engines.

The pile is one clump of YADE, driven at a constant rate or by a hammer (a sphere that falls on its head);
ground, material constants and mesh are those of sheet_pile.py, where the pile is elastic and bonded to the
soil. Plane strain. Beside --smoke the time step is larger, too, and the balance of forces is checked in every
step. Without --threads the soil has as many as YADE, one without -j.

Units: Mg, m, s, kPa, per metre of thickness.
"""

import os
import sys
import time

import numpy as np
import yade_mpm as mpm
from yade import (
    Bo1_Box_Aabb,
    Bo1_Sphere_Aabb,
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
from yade_mpm import app

here = os.path.dirname(os.path.abspath(sys.argv[0]))
sys.path[:0] = [here, os.path.join(here, "studies")]  # yade-batch does not know them
import sheet_pile_model  # noqa: E402
import yade_pile_options as options  # noqa: E402
from sheet_pile import DEPTH, EMBEDDED, GRAVITY, K0, PILE_LENGTH, WIDTH  # noqa: E402
from yade_pile_compare import compare  # noqa: E402
from yade_pile_pictures import draw  # noqa: E402
from yade_pile_results import HAMMER_PERIOD, Gauge, merge, print_, report  # noqa: E402

HAMMER_RADIUS = 0.5  # m
# kN/m, kN s/m of each side; two in series: 1e5, 600, restitution 0.4
CUSHION = dict(kn=2e5, cn=1200.0, ks=1e5, cs=0.0)


def arguments():
    return options.arguments(__doc__)


# --- the scene ----------------------------------------------------------------------------------------------
def soil(a):
    """The ground of the sheet pile scene with the shaft left empty."""
    scene, _ = sheet_pile_model.ground(options.bonded(a))
    scene.gravity, scene.damping = GRAVITY, 0.05
    scene.roller("left", "right")
    scene.fix("bottom")
    scene.initialStress(surface=DEPTH, K0=K0)
    scene.dt = a.dt
    return scene


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

    scene = soil(a)
    contact = scene.contact(number, friction=a.friction).contact
    contact.checkBalance = a.smoke
    gauge = Gauge(contact, number)
    scene.engines.append(mpm.PyRunner(gauge.sample, iterPeriod=1))
    file = os.path.join(out, "history.csv")
    history = scene.history(every=drive.until / 800, file=file, columns=gauge.columns)
    scene.record(os.path.join(out, "vtk", "soil.vtkhdf"), every=drive.until / 40)
    O.dt = a.dt
    coupling = mpm.inYade(scene, stages=False)

    steps = round(drive.until / O.dt)
    print(
        f"friction {a.friction}, {a.drive}: {scene.particleCount} soil particles, threads: {scene.threads}; "
        f"{steps} steps of {O.dt:.3g} s (critical {scene.dtCritical:.3g} s)",
        flush=True,
    )
    began = time.monotonic()
    O.run(steps, True)
    wall = time.monotonic() - began
    coupling.flush()
    return report(a, out, number, scene, history, gauge, wall)


def main():
    a = arguments()
    if a.merge:
        merge()
        return
    if a.compare:
        results = compare(a, run)
    else:
        results = {f"friction {a.friction}": run(a, a.out)}
        print_(results[f"friction {a.friction}"]["summary"])
    draw(a, results, os.path.join(a.out, "yade_pile.png"))
    print(f"results in {a.out}/")


if __name__ == "__main__":
    app.run(main)
