#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A levee in a flood: its factor of safety as the water table rises and is drawn down, beside Bishop's.

Plane strain, a levee of one soil on a firm base, 6 m high, 4 m wide at its crest, with slopes of 2:1. The
water table is given as rows (x, level) in three stages: the river is low; the river stands at 5 m for long,
and water seeps to the land side; the river is drawn down to 1 m faster than the levee drains. `mpm.safety`
finds the factor of each stage, with the pressures of steady flow below that table. Bishop's simplified
method has the same pressures: its least factor over circles is printed beside.
Units: Mg, m, s, kPa, per metre of thickness.

    scripts/run levee
    scripts/run levee --cell 0.5
"""

import os
from math import radians, tan

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, plot, polygon
from yade_mpm.geotech.safety import trial

HEIGHT, TOE, WIDTH, CREST = 6.0, (2.0, 30.0), 32.0, (14.0, 18.0)  # m
DENSITY, COHESION, PHI, YOUNG = 2.0, 5.0, 25.0, 2e4  # Mg/m3 with water, kPa, degrees, kPa
GRAVITY = 9.81  # m/s2
STAGES = {  # rows (x, level) of the table, m
    "river low": [(0, 0), (WIDTH, 0)],
    "flood": [(0, 5), (12, 5), (28, 1), (30, 0), (WIDTH, 0)],
    "drawn down": [(0, 1), (4, 1), (12, 5), (28, 1), (30, 0), (WIDTH, 0)],
}
PARAMETERS = mpm.Parameters(
    "levee",
    __doc__,
    Parameter("cell", 0.25, "size of the grid's cells", unit="m", partOf=1.0),
    Parameter("within", 0.02, "width of the bisected interval", above=0, most=0.2),
    smoke={"cell": 1.0, "within": 0.2},
)


def build(a, table):
    """The levee with water to a table, before gravity."""
    scene = mpm.Scene((0, 0), (WIDTH, HEIGHT + 2), a.cell, gravity=GRAVITY, threads=a.threads)
    scene.fix("bottom")
    scene.roller("left", "right")
    soil = mpm.MohrCoulomb(
        density=DENSITY,
        young=YOUNG,
        poisson=0.3,
        cohesion=COHESION,
        frictionAngle=radians(PHI),
        dilatancyAngle=0,
    )
    water = mpm.PoreWater(table=table, permeability=1e-6, porosity=0.4)
    outline = polygon([(TOE[0], 0), (TOE[1], 0), (CREST[1], HEIGHT), (CREST[0], HEIGHT)])
    scene.add("levee", outline, soil, mpm.UGIMP(), water=water)
    return scene


def surface(x):
    return np.interp(x, [TOE[0], *CREST, TOE[1]], [0, HEIGHT, HEIGHT, 0])


def bishop(pressure, table, slices=40):
    """Least factor of safety of circles through both slopes: (factor, (x, y) of the centre, radius).

    pressure : function (x, y) -> kPa, of arrays. Circles that cut the base, or ground under water, are left
    out: water in front of a slope holds it.
    """

    def factorOf(circle):
        side, out, back, bend = circle
        toe = TOE[side > 0]
        return _circle(side, (toe - side * (out + back), toe - side * out), bend, pressure, table, slices)[0]

    # How far from the toe a circle leaves the slope, and how far behind that it begins, m; depth over chord.
    metre = HEIGHT / 6
    start = np.array([0.5 * metre, 0.5 * metre, 0.05])
    grid = [
        (side, metre * out, metre * back, bend)
        for side in (1, -1)
        for out in range(9)
        for back in range(4, 19)
        for bend in np.arange(0.1, 0.51, 0.05)
    ]
    best = min(grid, key=factorOf)
    for finer in 0.5 ** np.arange(5):
        steps = finer * start * np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(-1, 3)
        best = min([(best[0], *(np.array(best[1:]) + step)) for step in steps], key=factorOf)
    side, out, back, bend = best
    toe = TOE[side > 0]
    return _circle(side, (toe - side * (out + back), toe - side * out), bend, pressure, table, slices)


def _circle(side, ends, bend, pressure, table, slices):
    """Bishop's factor of the circle through two points of the surface."""
    first, last = (np.array([x, float(surface(x))]) for x in ends)
    chord = last - first
    length = np.linalg.norm(chord)
    radius = length * (0.25 + bend**2) / (2 * bend)
    normal = np.array([chord[1], -chord[0]]) / length * side  # down, into the soil
    centre = 0.5 * (first + last) - normal * (radius - bend * length)
    edges = np.linspace(min(ends), max(ends), slices + 1)
    x, width = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    y = centre[1] - np.sqrt(np.maximum(radius**2 - (x - centre[0]) ** 2, 0))
    high = surface(x) - y
    none = (np.inf, None, None)
    isUnderWater = (np.interp(x, *np.transpose(table)) > surface(x) + 0.1).any()
    if (
        isUnderWater
        or first[1] <= last[1]
        or y.min() < 0
        or high.min() < 0
        or np.abs(x - centre[0]).max() > 0.95 * radius
    ):
        return none
    weight = DENSITY * GRAVITY * high * width
    sine = side * (x - centre[0]) / radius * -1
    drive = (weight * sine).sum()
    if drive <= 0:
        return none
    cosine, friction, factor = np.sqrt(1 - sine**2), tan(radians(PHI)), 1.5
    resist = COHESION * width + np.maximum(weight - pressure(x, y) * width, 0) * friction
    for _ in range(50):
        lean = cosine + sine * friction / factor
        if lean.min() < 0.2:
            return none
        factor, before = (resist / lean).sum() / drive, factor
        if abs(factor - before) < 1e-6:
            break
    return factor, tuple(centre), radius


def pressureIn(scene):
    """Function (x, y) -> pore pressure as the scene has it, kPa: of the nearest particle."""
    body = scene["levee"]
    places, values = body.reference, np.maximum(body.porePressure, 0)

    def pressure(x, y):
        ways = (x[:, None] - places[:, 0]) ** 2 + (y[:, None] - places[:, 1]) ** 2
        return values[ways.argmin(axis=1)]

    return pressure


def draw(found, file):
    """Each stage as it fails, coloured by plastic shear strain, with its table and Bishop's circle."""
    figure, axes = plot.plt.subplots(len(found), 1, figsize=(6.5, 6.6), layout="constrained", sharex=True)
    for one, (name, (safe, (factor, centre, radius))) in zip(axes, found.items()):
        strain = safe.scene["levee"].plasticShearStrain
        limit = float(np.quantile(strain, 0.98))
        coloured = plot.Snapshot(safe.scene, "plasticShearStrain").draw(one, limit)
        plot.colourBar(one, coloured, "plastic shear strain (-)", extend="max")
        one.plot(*np.transpose(STAGES[name]), "C0-", lw=1.5, label="water table")
        x = np.linspace(*TOE, 400)
        y = centre[1] - np.sqrt(np.maximum(radius**2 - (x - centre[0]) ** 2, 0))
        inside = (y < surface(x)) & (np.abs(x - centre[0]) < radius)
        one.plot(x[inside], y[inside], "r--", lw=1.2, label="Bishop's circle")
        one.set(ylabel="y (m)", ylim=(0, HEIGHT + 1.5))
        one.set_title(f"{name}: factor of safety {safe.factor:.2f}, Bishop {factor:.2f}", fontsize=10)
    axes[0].legend(loc="upper left", fontsize=8)
    axes[-1].set_xlabel("x (m)")
    plot.save(figure, file)


def main():
    a = PARAMETERS.parse()
    found = {}
    for name, table in STAGES.items():
        _, stands = trial(lambda table=table: build(a, table), 0.7)
        safe = mpm.safety(lambda table=table: build(a, table), (0.8, 1.6), a.within, progress=False)
        circle = bishop(pressureIn(stands), table)
        found[name] = safe, circle
        print(f"{name}: {safe}; Bishop {circle[0]:.2f}", flush=True)
    os.makedirs(a.out, exist_ok=True)
    draw(found, f"{a.out}/levee.png")


if __name__ == "__main__":
    app.run(main)
