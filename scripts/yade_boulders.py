#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Boulders fall on soil, inside YADE.

Spheres of YADE, with DEM contacts among each other, fall from 2 m and more on a bed of cohesive-frictional
soil (uGIMP, 3D) that they touch through RigidContact. There is no damping of motion as such: energy goes into
the soil, into friction, and into dashpots where two things touch, so that momentum is kept to the last
digits. Reported: craters, rest of the boulders, momentum and energy.

ParaView: results/yade_boulders/boulders-*.vtu (VTKRecorder) and soil.vtkhdf (our Recorder) have the same
times. Units: Mg, m, s, kPa.

    scripts/run yade_boulders
    scripts/run yade_boulders --count 10             # larger ones; 1000: smaller ones
    scripts/run yade_boulders --smoke
"""

import os
import time
from math import radians

import numpy as np
import yade_mpm as mpm
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_ViscElMat_ViscElMat_ViscElPhys,
    Law2_ScGeom_ViscElPhys_Basic,
    NewtonIntegrator,
    O,
    PyRunner,
    ViscElMat,
    VTKRecorder,
    utils,
)
from yade_boulders_balance import GRAVITY, Balance, summary
from yade_boulders_pictures import draw
from yade_mpm import Parameter, app, box
from yade_mpm.io import files

DROP = 2.0  # m from the bed to the lowest boulder
SOIL = dict(
    density=1.7, young=2000.0, poisson=0.3, cohesion=1.0, frictionAngle=radians(28), dilatancyAngle=0.0
)
ROCK = dict(
    density=2.6, young=1e5, poisson=0.3, frictionAngle=radians(35), en=0.3, et=0.3
)  # soft contacts: longer time steps
FRICTION, DAMPING = 0.5, 0.5  # boulder against soil: coefficient, share of critical
FRAME = 0.05  # s


def refusal(a, given):
    """What is wrong with the arguments, or None."""
    for name in ("width", "depth"):
        if not app.isWhole(vars(a)[name] / a.cell):
            refused = f"--{name} {vars(a)[name]:g} with --cell {a.cell:g} is not allowed"
            return f"{refused}; give a whole number of cells"
    return None


PARAMETERS = mpm.Parameters(
    "yade_boulders",
    __doc__,
    Parameter("count", 100, "number of boulders", least=1, whole=True),
    Parameter("radius", lambda a: 0.22 * (100 / a.count) ** 0.25, "mean", unit="m", above=0),
    Parameter("cell", 0.15, "size of the grid's cells", unit="m", above=0),
    Parameter("width", 6.0, "width and length of the bed", unit="m", above=0),
    Parameter("depth", 1.2, "of the bed", unit="m", above=0),
    Parameter("until", 4.0, "end", unit="s", above=0),
    Parameter("seed", 1, "of the places and sizes", whole=True),
    smoke={"count": 3, "radius": 0.3, "cell": 0.2, "width": 3.0, "depth": 0.8, "until": 2.5},
    check=refusal,
)
arguments = PARAMETERS.parse


def places(a):
    """Centres and radii of the boulders: layers of a square lattice over the middle of the bed, shaken."""
    random = np.random.default_rng(a.seed)
    radii = a.radius * random.uniform(0.75, 1.25, a.count)
    space = 2.6 * radii.max()  # 0.6 radii are left to shake
    across = max(1, int(0.75 * a.width / space))
    layer, place = np.divmod(np.arange(a.count), across**2)
    across = np.where(
        layer == layer.max(), np.minimum(across, np.ceil(np.sqrt(np.sum(layer == layer.max())))), across
    )
    x = (
        np.stack([place % across - (across - 1) / 2, place // across - (across - 1) / 2], axis=1) * space
        + a.width / 2
    )
    z = a.depth + DROP + radii.max() + layer * space
    shift = random.uniform(-1, 1, (a.count, 3)) * (space / 2 - radii)[:, None]
    return np.column_stack([x, z]) + shift * (1, 1, 0.5), radii


def build(a):
    """Scene and boulders, ready for YADE."""
    upper = a.width, a.width, a.depth + 6 * a.cell
    scene = mpm.Scene((0, 0, 0), upper, a.cell, threads=a.threads, gravity=GRAVITY)
    scene.roller("left", "right", "front", "back")
    scene.fix("bottom")
    bed = box((0, 0, 0), (a.width, a.width, a.depth))
    scene.add("soil", bed, mpm.MohrCoulombDruckerPrager(**SOIL), mpm.UGIMP(perCell=2), fbar=False)
    scene.initialStress(surface=a.depth, K0=0.5)

    O.materials.append(ViscElMat(label="rock", **ROCK))
    O.materials.append(ViscElMat(label="smooth", **dict(ROCK, frictionAngle=0.0)))
    ids = O.bodies.append(
        [utils.sphere(tuple(map(float, x)), float(r), material="rock") for x, r in zip(*places(a))]
    )
    O.bodies.append(
        [
            utils.wall(at, axis, sense, material="smooth")
            for axis in (0, 1)
            for at, sense in ((0.0, 1), (a.width, -1))
        ]
    )
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
        InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
            [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
            [Law2_ScGeom_ViscElPhys_Basic()],
        ),
        NewtonIntegrator(gravity=(0, 0, -GRAVITY), damping=0),
    ]
    boulders = scene.contact(ids, friction=FRICTION)
    boulders.contact.normalDamping = DAMPING
    mpm.inYade(scene)
    return scene, boulders


def record(a, scene):
    """Recorders of both sides, every FRAME s; the scene goes into YADE again then."""
    period = max(1, round(FRAME / O.dt))
    fields = ["velocity", "displacement", "plasticShearStrain"]
    file = os.path.join(a.out, "soil.vtkhdf")
    scene.engines.append(mpm.Recorder(file, iterPeriod=period, fields=fields))
    O.engines = [
        VTKRecorder(
            fileName=os.path.join(a.out, "boulders-"),
            iterPeriod=period,
            initRun=True,
            recorders=["spheres", "velocity"],
        )
    ] + O.engines


def run(a, isRecorded=True):
    """Lets the boulders fall; returns (summary, scene, centres, radii, rows of the balance)."""
    O.reset()
    os.makedirs(a.out, exist_ok=True)
    scene, boulders = build(a)
    if isRecorded:
        record(a, scene)
        mpm.inYade(scene)
    ids, contact = boulders.ids, boulders.contact
    balance = Balance(scene, contact, ids)
    mpm.yade.setCommand("stepBalance()", balance.step)
    O.engines = O.engines + [
        PyRunner(command="stepBalance()", iterPeriod=1, initRun=True, updateGlobals=False)
    ]
    began = time.monotonic()
    while O.time < a.until:
        O.run(max(1, round(FRAME / O.dt)), True)
        row = balance.row()
        load = f"force of the soil {row['force']:8.1f} kN, {contact.contacts} contacts"
        print(f"{O.time:6.2f} s  kinetic energy {row['bouldersKinetic']:8.2f} kJ, {load}", flush=True)
    centres = np.array([tuple(O.bodies[i].state.pos) for i in ids])
    radii = np.array([O.bodies[i].shape.radius for i in ids])
    return (
        summary(a, scene, balance, boulders, centres, radii, time.monotonic() - began),
        scene,
        centres,
        radii,
        balance.rows,
    )


def main():
    a = arguments()
    s, scene, centres, radii, rows = run(a)
    draw(a, scene, centres, radii, os.path.join(a.out, "yade_boulders.png"))
    files.saveJson(os.path.join(a.out, "summary.json"), {**s, "rows": rows})
    weights = f"boulders of {s['weight']:.1f} kN, the soil carries {s['meanForceAtEnd']:.1f} kN"
    craters = f"craters down to {s['craterDepth']:.3f} m, rims up to {s['rimHeight']:.3f} m"
    missing = f"{s['momentumError']:.1e} of {s['momentumExchanged']:.1f} Mg m/s of momentum are missing"
    print(f"{a.count} {weights}; {s['moving']} move; {craters}", f"{missing}; results in {a.out}/", sep="\n")


if __name__ == "__main__":
    app.run(main)
