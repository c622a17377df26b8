#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A strutted diaphragm wall, 30 m deep, dug to 20 m in elastic clay on sand, dry, beside PLAXIS.

PLAXIS' results for its tutorial "Submerged construction of an excavation" stand with the tests of Kratos
Multiphysics (GeoMechanicsApplication, comparison_data_dry). There the wall is a plate without thickness, here
it is drawn 1 m thick, and bonded to the soil. Units: Mg, m, s, kPa."""

import os

import yade_mpm as mpm
from yade_mpm import Parameter, app, box, plot

G, TOP, THICKNESS = 9.81, 50, 1.0  # m/s2, m
CLAY = mpm.LinearElastic(density=16 / G, young=12e3, poisson=0.15)
SAND = mpm.LinearElastic(density=17 / G, young=120e3, poisson=0.2)
CELL = Parameter("cell", 0.5, "size of the grid's cells", unit="m", partOf=THICKNESS)
REST = Parameter("rest", 1.0, "factor on the time of each stage", above=0)
PARAMETERS = mpm.Parameters("diaphragm_wall", __doc__, CELL, REST, smoke={"cell": 1.0, "rest": 0.01})


def dug(depths, cell=0.5, stiffness=1e6, rest=1.0, threads=1):
    """The scene, and of each depth the force of the strut and the forces of the wall."""
    scene = mpm.Scene((0, 0), (65, 54), cell, gravity=G, damping=0.5, threads=threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    weight = (10 + 16.5 * THICKNESS) / G  # the plate's 10 kN/m2, and the soil's that it stands for
    section = dict(EI=stiffness, EA=7.5e6, GA=3.1e6, weight=weight, thickness=THICKNESS)
    sheet = mpm.Beam([(50, 20), (50, TOP)], **section)
    clay = scene.add("clay", box((0, 30), (65, TOP)) - sheet.region, CLAY, mpm.APDI(size=cell))
    sand = scene.add("sand", box((0, 0), (65, 30)) - sheet.region, SAND, mpm.APDI(size=cell))
    wall = scene.add("wall", sheet)
    scene.groundStress(K0={clay: 0.5774, sand: 0.4701}, bodies=[clay, sand])
    scene.attach(mpm.SurfaceLoad(clay, (43, 48), pressure=5))
    scene.history(every=0.05 * rest)
    scene.run(until=1.5 * rest)
    strut, found = None, {}
    for depth in depths:
        with scene.stage(f"dig to {depth} m") as stage:
            scene.remove(clay, region=box((50 + THICKNESS / 2, TOP - depth), (65, 54)))
            scene.run(until=scene.time + (3.0 if strut else 1.5) * rest)
            found[depth] = -strut.force if strut else 0, mpm.sectionForces(wall, "y")
            stage.note(moment=abs(found[depth][1].M).max())
        prop = mpm.Spring(wall, at=(50, 49), to=(65, 49), stiffness=4e5 / 15, label="strut")
        strut = strut or scene.attach(prop)
    return scene, found


def main():
    a = PARAMETERS.parse()
    scene, found = dug((2, 10, 20), a.cell, rest=a.rest, threads=a.threads)
    for depth, (strut, forces) in found.items():
        print(f"{depth} m: strut {strut:.0f} kN/m, M {-forces.M.min():.0f}, {forces.M.max():.0f} kN m/m")
    os.makedirs(a.out, exist_ok=True)
    plot.save(plot.structure({f"{d} m": one for d, (_, one) in found.items()}), f"{a.out}/diaphragm_wall.png")
    scene.report(f"{a.out}/diaphragm_wall.html", title="Diaphragm wall")


if __name__ == "__main__":
    app.run(main)
