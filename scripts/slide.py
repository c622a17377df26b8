#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A slide of 1,300 m3 runs down a gully: maps of its deposit, greatest depth and velocity, and arrival.
Units: Mg, m, s, kPa."""

import os
from math import atan

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, plot

FRICTION = Parameter("friction", 0.35, "of the ground", unit="-", least=0)
CELL = Parameter("cell", 1.0, "size of the grid's cells", unit="m", partOf=2)
UNTIL = Parameter("until", 10.0, "end", unit="s", above=0)
PARAMETERS = mpm.Parameters("slide", __doc__, FRICTION, CELL, UNTIL, smoke={"cell": 2.0, "until": 1.0})


def main():
    a = PARAMETERS.parse()
    x, y = np.meshgrid(np.arange(0, 141, 2.0), np.arange(0, 41, 2.0), indexing="ij")
    hill = 40 * np.exp(-x / 30)
    ground = mpm.heightField(hill + 0.02 * (y - 20) ** 2, spacing=2.0)  # or mpm.readTerrain("valley.tif")
    depth = np.where((abs(x - 14) < 9) & (abs(y - 20) < 11), 5.0 * (1 - ((y - 20) / 11) ** 2), 0)
    soil = mpm.MohrCoulomb(density=1.8, young=1e4, poisson=0.3, cohesion=0, frictionAngle=atan(0.6))
    scene = mpm.Scene((0, 0, 0), (140, 40, 52), a.cell, gravity=9.81, threads=a.threads)
    scene.add("slide", ground.layer(depth), soil)
    scene.terrain(ground, friction=a.friction)
    maps = scene.maps(ground, every=0.1)
    scene.run(until=a.until)
    print(f"deposit {maps.depth.max():.1f} m, greatest velocity {maps.greatestVelocity.max():.1f} m/s")
    os.makedirs(a.out, exist_ok=True)
    maps.write(f"{a.out}/slide.asc")  # slide-depth.asc and so on, for a GIS; .tif with rasterio
    plot.save(plot.terrainMaps(maps), f"{a.out}/slide.png")


if __name__ == "__main__":
    app.run(main)
