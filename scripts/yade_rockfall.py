#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Rocks of YADE fall on a slope of soil that yields, and a dam stops them.

Plane strain in the xz plane of YADE, per metre of thickness: a slope of c-phi soil at 35 degrees, 14 m high,
with a flat at its foot, on which a rigid dam stands 8 m from the toe. Rocks (discs of YADE) are let go over
the crest, hit the slope, roll, and touch each other, the dam and the soil. Friction goes by the materials.

The same rocks fall on ground that stays elastic (--elastic): there all of them reach the dam. What the first
rock keeps of its velocity against and along the slope at its first impact is printed: codes of rockfall want
it as an input, here it comes out. Units: Mg, m, s, kPa.

    scripts/run yade_rockfall
    scripts/run yade_rockfall --elastic
"""

import os
from math import pi, radians, tan

import numpy as np
import yade_mpm as mpm
from yade import (
    Bo1_Box_Aabb,
    Bo1_Sphere_Aabb,
    ForceResetter,
    Ig2_Box_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    PyRunner,
    ViscElMat,
    utils,
)
from yade_mpm import Parameter, app, plot
from yade_mpm.io import files

SLOPE, HEIGHT, FOOT, TOE, END = radians(35), 14.0, 4.0, 26.0, 38.0  # rad, m
CREST = TOE - HEIGHT / tan(SLOPE)  # m
DAM, DROP, GRAVITY = 34.0, 3.0, 9.81  # m, m, m/s2
SOIL = dict(density=1.8, young=2e4, poisson=0.3)
STRENGTH = dict(cohesion=8.0, frictionAngle=radians(32), dilatancyAngle=0.0)
ROCK = dict(density=2.6, young=1e6, poisson=0.3, frictionAngle=radians(35), en=0.3, et=0.3)
IMPACT = 0.5  # m/s in 0.01 s, five times what gravity does
PARAMETERS = mpm.Parameters(
    "yade_rockfall",
    __doc__,
    Parameter("rocks", 8, "number of rocks", least=1, whole=True),
    Parameter("cell", 0.5, "size of the grid's cells", unit="m", partOf=2.0),
    Parameter("until", 6.0, "end", unit="s", above=0),
    Parameter("elastic", False, "ground that does not yield"),
    smoke={"rocks": 2, "cell": 1.0, "until": 1.5},
)
arguments = PARAMETERS.parse


def ground(a):
    """The slope at rest under its weight."""
    scene = mpm.Scene((0, 0), (END, 24.0), a.cell, threads=a.threads, gravity=GRAVITY, damping=0.05)
    scene.roller("left", "right")
    scene.fix("bottom")
    outline = [(0, 0), (END, 0), (END, FOOT), (TOE, FOOT), (CREST, FOOT + HEIGHT), (0, FOOT + HEIGHT)]
    law = mpm.LinearElastic(**SOIL) if a.elastic else mpm.MohrCoulombDruckerPrager(**SOIL, **STRENGTH)
    scene.add("slope", mpm.polygon(outline), law, mpm.UGIMP(perCell=2))
    return scene


def rocks(a):
    """Discs over the crest, one after the other, and the dam; returns their numbers."""
    stone = O.materials.append(ViscElMat(**ROCK))
    radii = np.random.default_rng(3).uniform(0.4, 0.8, a.rocks)
    numbers = []
    for k, radius in enumerate(radii):
        at = (CREST + 1.0 + 0.3 * (k % 2), 0, FOOT + HEIGHT + DROP + 1.7 * k)
        number = O.bodies.append(utils.sphere(at, float(radius), material=stone))
        state = O.bodies[number].state
        state.mass = ROCK["density"] * pi * radius**2
        state.inertia = (state.mass * radius**2 / 2,) * 3
        state.blockedDOFs = "yXZ"
        numbers.append(number)
    dam = utils.box((DAM, 0, FOOT + 1.5), (0.4, 0.5, 1.5), fixed=True, material=stone)
    return numbers, O.bodies.append(dam)


def run(a):
    """Lets the rocks fall; returns the coupling, the track of each rock, and the picture's axes."""
    O.reset()
    scene = ground(a)
    numbers, dam = rocks(a)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),
        InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
            [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
            [Law2_ScGeom_ViscElPhys_Basic()],
        ),
        NewtonIntegrator(gravity=(0, 0, -GRAVITY), damping=0),
    ]
    scene.contact([*numbers, dam], plane="xz").contact.normalDamping = 0.3
    scene.settle()
    coupling = mpm.inYade(scene, stages=False)
    states, track = [O.bodies[n].state for n in numbers], []
    mpm.yade.setCommand("look()", lambda: track.append([O.time, *([*s.pos, *s.vel] for s in states)]))
    O.engines = [*O.engines, PyRunner(command="look()", virtPeriod=0.01, initRun=True)]
    figure, axes = plot.plt.subplots(3, 1, figsize=(7.2, 9.6), layout="constrained")
    begun = O.time
    for ax, share in zip(axes, (0.35, 0.6, 1.0)):
        O.run(max(1, int((begun + share * a.until - O.time) / O.dt)), True)
        field = "deviatoricStress" if a.elastic else "plasticShearStrain"
        coupling.picture(field, limits=None if a.elastic else (0, 0.3), axes=ax, colours="inferno_r")
        ax.set_title(f"{O.time - begun:.1f} s")
    plot.save(figure, os.path.join(a.out, "yade_rockfall.png"))
    return coupling, [(row[0] - begun, np.array(row[1:])) for row in track]


def restitution(track):
    """What the first rock keeps of its velocity against the slope at its first impact, -, and along it."""
    normal, along = np.array((np.sin(SLOPE), 0, np.cos(SLOPE))), np.array((np.cos(SLOPE), 0, -np.sin(SLOPE)))
    velocity = np.array([state[0, 3:] for _, state in track])
    hits = np.flatnonzero(np.diff(velocity @ normal) > IMPACT)
    if len(hits) == 0:
        return None
    before, after = velocity[hits[0]], velocity[hits[0] : hits[0] + 20]
    leaving = after[np.argmax(after @ normal)]
    return float(-(leaving @ normal) / (before @ normal)), float((leaving @ along) / (before @ along))


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    coupling, track = run(a)
    runOut = track[-1][1][:, 0]
    summary = dict(runOut=runOut.tolist(), restitution=restitution(track), steps=coupling.scene.steps)
    summary["fastest"] = float(max(np.linalg.norm(state[:, 3:], axis=1).max() for _, state in track))
    files.saveJson(os.path.join(a.out, "summary.json"), summary)
    print(summary, f"results in {a.out}/", sep="\n")


if __name__ == "__main__":
    app.run(main)
