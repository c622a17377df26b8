#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A propped sheet-pile wall (AZ 18), dug in two stages, beside free earth, Rankine. Units: Mg, m, s, kPa."""

import os
from math import pi

import yade_mpm as mpm
from yade_mpm import Parameter, app, box, plot

TOP, LENGTH, LEFT, RIGHT = 8.0, 6.5, 8.0, 9.0  # m: ground, the wall below it, its faces
EI, EA, WEIGHT, GAMMA, PROP = 71820.0, 3.2e6, 0.118, 18.0, 2e4  # AZ 18: kN m, kN/m, Mg/m2; kN/m3, kN/m2
STAGES = (("gravity", 0, 0.5), ("dig to -2 m", 2, 1.0), ("dig to -4 m", 4, 2.0))  # name, depth (m), time (s)
CELL = Parameter("cell", 0.25, "size of the grid's cells", unit="m", partOf=0.5)
REST = Parameter("rest", 1.0, "factor on the time of each stage", above=0)
DAMPING = Parameter("damping", 0.5, "local damping", least=0)
PARAMETERS = mpm.Parameters("propped_wall", __doc__, CELL, REST, DAMPING, smoke={"rest": 0.02})


def byHand(dig=4.0, Ka=1 / 3, propAt=1.0):  # prop force, kN/m, and largest moment, kN m/m
    active, arm = 0.5 * Ka * GAMMA * LENGTH**2, 2 / 3 * LENGTH - propAt
    prop = active - active * arm / (dig + 2 / 3 * (LENGTH - dig) - propAt)
    z = (2 * prop / (Ka * GAMMA)) ** 0.5  # no shear force there
    return round(prop, 1), round(prop * (z - propAt) - Ka * GAMMA * z**3 / 6, 1)


def main():
    a = PARAMETERS.parse()
    sand = mpm.MohrCoulomb(density=GAMMA / 9.81, young=3e4, poisson=0.3, cohesion=0.5, frictionAngle=pi / 6)
    sheet = mpm.Beam([(8.5, TOP - LENGTH), (8.5, 8.5)], EI=EI, EA=EA, weight=WEIGHT, thickness=RIGHT - LEFT)
    low, high = -a.cell / 2, 17 + a.cell / 2  # faces of the wall in the middle of cells
    scene = mpm.Scene((low, 0), (high, 9), a.cell, gravity=9.81, damping=a.damping, threads=a.threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    soil = scene.add("soil", box((low, 0), (high, TOP)) - sheet.region, sand, mpm.UGIMP())
    wall = scene.add("wall", sheet)
    scene.contact(wall, soil)
    scene.initialStress(surface=TOP, K0=0.5, bodies=[soil])
    scene.history(every=0.02 * a.rest)
    scene.dt, found = 2e-3 * a.cell, {}
    prop = scene.attach(mpm.Spring(wall, (RIGHT, 7), (high, 7), stiffness=PROP, label="prop", dead=True))
    for name, depth, time in STAGES:
        prop.dead = depth < 4
        with scene.stage(name) as stage:
            if depth:
                scene.remove(region=box((RIGHT, TOP - depth), (high, 9)), over=0.5 * a.rest * time)
            scene.run(until=scene.time + 0.75 * a.rest * time)
            before = mpm.facePressure(wall)
            scene.run(until=scene.time + 0.25 * a.rest * time)
            found[name] = mpm.sectionForces(wall, "y"), mpm.facePressure(wall, since=before)
            stage.note(moment=abs(found[name][0].M).max(), settlement=-soil.displacement[:, 1].min())
    print(f"prop {-prop.force:.1f} kN/m, moment {abs(found[name][0].M).max():.1f} kN m/m; by hand", byHand())
    os.makedirs(a.out, exist_ok=True)
    plot.save(plot.structure(found), f"{a.out}/propped_wall.png")
    scene.report(f"{a.out}/propped_wall.html", title="Propped wall")
    return scene, found[name]


if __name__ == "__main__":
    app.run(main)
