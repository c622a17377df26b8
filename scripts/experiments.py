#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Beside experiments: a dam break (Martin & Moyce 1952), columns of sand of friction sin(31 degrees) (Lube et
al. 2005) and of aluminium rods of 19.8 degrees (Nguyen, Bui & Fukagawa 2015), glass beads on a chute
(Pouliquen 1999), a strip footing on sand, a cone in a calibration chamber (Baldi et al. 1986). Units: Mg, m,
s, kPa."""

import os
from math import asin, ceil, pi, radians, sin, tan
from types import SimpleNamespace

import cone
import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, plot
from yade_mpm.geotech import quadrilaterals, reference

G = 9.81
WIDTH = 0.05715  # m, of the water
# Phil. Trans. R. Soc. A 244, 312-324, table 2: T = t sqrt(2 g/width) and the front over the width.
FRONT = (1.19, 1.43, 1.63, 1.83, 1.98, 2.20, 2.32, 2.51, 2.65, 2.83, 2.98, 3.11), np.linspace(1.44, 3.89, 12)
LENGTH, RODS = 0.1, 0.2  # m, of the columns of sand and of rods
FLIP = 0.99  # share of their own velocity that grains keep
GRAIN, DEEP = 0.53e-3, 20  # m, size of the glass beads; their number in the depth of the layer on the chute
# Glass beads on rough planes (Forterre & Pouliquen 2003): friction of slow and of fast flow, factor of the
# depth at which a layer stops, and of the velocity over sqrt(g h) by the depth over that one.
SLOW, FAST, STOP, FROUDE = tan(radians(20.9)), tan(radians(32.76)), 1.65, 0.136
# Strip footings on dry sand, length over width 5.95; degrees, kN/m3, kPa: of the load tests collected in
# github.com/ayman-abdalhamid/Ultimate-Bearing-Capacity-Prediction those with B = 0.152 m and D = 0.075 m.
FOOTING, SUNK = 0.152, 0.075  # m, its width and its depth in the sand
SANDS = np.array([34, 37, 39.5, 41.5, 42.5]), np.array([15.7, 16.1, 16.5, 16.8, 17.1])
LIMITS = np.array([98.2, 143.3, 211.2, 285.3, 335.3])
# Ticino sand: void ratios of the loosest and the densest, and e_c = 0.923 - 0.046 sqrt(p/100 kPa) (Fioravante
# & Giretti 2015), here a line in ln p through its values at 0.1 and 1 MPa; slope of the critical states, q/p.
LOOSEST, DENSEST, CRITICAL, COMPRESSION, SLOPE = 0.923, 0.574, 0.877, 0.0432, 1.14
VERTICAL, AT_REST = 100.0, 0.45  # kPa, of the chamber, and horizontal stress over vertical

CELLS = Parameter("cells", 10, "cells in the width of the water and of a column", whole=True, least=4)
ASPECTS = Parameter("aspects", [0.5, 1.0, 2.0, 4.0], "heights of columns over lengths", several=True, above=0)
RATIOS = Parameter(
    "ratios", [0.7, 1.0, 2.0, 3.0], "heights of columns of rods over lengths", several=True, above=0
)
SLOPES = Parameter(
    "slopes", [23.0, 24.0, 25.0, 26.0], "of the chute", unit="degrees", several=True, least=22, most=28
)
ANGLES = Parameter(
    "angles", [34.0, 39.5, 42.5], "of friction below the footing", unit="degrees", several=True, above=0
)
DENSITIES = Parameter("densities", [0.6], "relative, in the chamber", several=True, above=0, most=1)
SMOKE = {"ratios": [1.0], "cells": 4, "aspects": [0.5], "slopes": [24.0], "angles": [34.0], "densities": []}
PARAMETERS = mpm.Parameters(
    "experiments", __doc__, CELLS, ASPECTS, RATIOS, SLOPES, ANGLES, DENSITIES, smoke=SMOKE
)


def damBreak(a):
    """Times and places of the front."""
    bulk = 200 * G * WIDTH
    water = mpm.NewtonianLiquid(density=1.0, bulk=bulk, viscosity=1e-6, shearModulus=bulk / 2)
    h = WIDTH / a.cells
    scene = mpm.Scene((0, 0), (6 * WIDTH, 2.5 * WIDTH), cell=h, gravity=G, threads=a.threads)
    scene.roller("left", "right", "bottom")
    body = scene.add("water", mpm.box((0, 0), (WIDTH, 2 * WIDTH)), water, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=2 * WIDTH, K0=1.0)
    rows = [(0.0, 1.0)]
    while rows[-1][0] < 3.3:
        scene.run(until=(rows[-1][0] + 0.1) * np.sqrt(WIDTH / (2 * G)), progress=False)
        front = np.sort(body.position[:, 0])[-2] + h / 4
        rows.append((scene.time / np.sqrt(WIDTH / (2 * G)), front / WIDTH))
    return np.array(rows).T


def column(a, aspect):
    """Length of the heap (99.5 % of its mass) over that of the column."""
    h, height = LENGTH / a.cells, aspect * LENGTH
    size = h * np.ceil((1 + 5 * aspect**0.8) * a.cells), h * np.ceil(1.1 * height / h + 1)
    sand = mpm.MuI(
        density=1.5,
        young=500,
        poisson=0.3,
        staticFriction=0.52,
        fastFriction=0.78,
        inertialNumber=0.279,
        grainSize=0.001,
    )
    scene = mpm.Scene((0, 0), size, cell=h, gravity=G, threads=a.threads)
    scene.roller("left")
    scene.drive("bottom", velocity=(0, 0))
    heap = scene.add("heap", mpm.box((0, 0), (LENGTH, height)), sand, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=height, K0=0.7)
    next(e for e in scene.engines if isinstance(e, mpm.GridToParticle)).flip = FLIP
    scene.run(until=4.5 * np.sqrt(height / G), progress=False)
    return np.quantile(heap.position[:, 0], 0.995) / LENGTH


def rods(a, ratio):
    """Height of a column over the final one."""
    height, cell = ratio * RODS, RODS / a.cells
    size = np.ceil(np.array([7 * height, 1.2 * height]) / cell) * cell
    law = mpm.MohrCoulombDruckerPrager(
        density=2.04, young=5840, poisson=0.3, cohesion=0, frictionAngle=radians(19.8), dilatancyAngle=0
    )
    scene = mpm.Scene((0, 0), size, cell=cell, gravity=G, damping=0.05, threads=a.threads)
    scene.fix("bottom")
    scene.roller("left")
    body = scene.add("rods", mpm.box((0, 0), (RODS, height)), law, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=height, K0=0.6)
    scene.run(until=8 * np.sqrt(height / G), progress=False)
    return height / body.corners()[..., 1].max()


def chuteLaw(slope):
    """Depth of the layer over that at which it stops, and mean velocity over sqrt(g h), as measured."""
    steep = tan(radians(slope))
    over = DEEP * (steep - SLOW) / (STOP * (FAST - steep))
    return over, FROUDE * over


def chute(a, slope):
    """Mean velocity over sqrt(g h) of a layer that is alike along a rough chute, and that measured."""
    deep, steep = DEEP * GRAIN, radians(slope)
    cell = deep / a.cells
    beads = mpm.MuI(
        density=1.5,
        young=300 * G * deep,
        poisson=0.2,
        staticFriction=SLOW,
        fastFriction=FAST,
        inertialNumber=0.279,
        grainSize=GRAIN,
    )
    gravity = (G * np.sin(steep), -G * np.cos(steep))
    scene = mpm.Scene((0, 0), (8 * cell, deep + 2 * cell), cell=cell, gravity=gravity, threads=a.threads)
    scene.fix("bottom")
    layer = scene.add(
        "layer", mpm.box((2 * cell, 0), (6 * cell, deep)), beads, mpm.UGIMP(perCell=2), fbar=False
    )
    layer.stress = 1.5 * gravity[1] * (deep - layer.position[:, 1])[:, None, None] * np.eye(3)
    along = layer.position[:, 0].copy()

    def putBack():
        layer.position[:, 0] = along
        layer.deformationGradient[:, 0, 1] = 0

    scene.engines.insert(1, mpm.UniformAlong(axis="x"))
    scene.engines.append(mpm.PyRunner(putBack, iterPeriod=1))
    scene.run(until=120 * np.sqrt(deep / G), progress=False)
    return layer.velocity[:, 0].mean() / np.sqrt(G * deep), chuteLaw(slope)[1]


def footing(a, angle):
    """Pressure on a strip footing that has sunk by a tenth of its width, and that measured, kPa."""
    half, cell, phi = FOOTING / 2, FOOTING / a.cells, radians(angle)
    sunk, weight = round(SUNK / cell) * cell, np.interp(angle, *SANDS)
    law = mpm.MohrCoulomb(
        density=weight / G,
        young=1e4,
        poisson=0.3,
        cohesion=0,
        frictionAngle=phi,
        dilatancyAngle=phi - radians(30),
    )
    size = (0, -2.5 * FOOTING), (5 * FOOTING, sunk)
    scene = mpm.Scene(size[0], (size[1][0], sunk + 2 * cell), cell, threads=a.threads)
    x, y = np.meshgrid(np.linspace(0, half, a.cells + 1), np.arange(0, sunk + 1.1 * cell, cell / 2))
    pressed = SimpleNamespace(**vars(a) | {"rate": 0.02, "constraints": "auto"})
    walls = dict(gravity=(0, -G), damping=0.3, roller=("left", "right"), fixed="bottom")
    block = reference.drive(
        scene, "footing", quadrilaterals(x, y), pressed, 0.01 * FOOTING, friction=tan(phi), **walls
    )
    ground = mpm.box(*size) - mpm.box((-1, 0), (half, 1))
    sand = scene.add("sand", ground, law, mpm.UGIMP(perCell=2), group="soil")
    pressure = weight * (sand.position[:, 1] - sunk)
    sand.setStress(pressure[:, None, None] * np.diag([1 - sin(phi), 1, 1 - sin(phi)]))
    _, way, force, _ = reference.press(pressed, scene, 0.1 * FOOTING, 0.01 * FOOTING)
    late = (force + G * block.mass.sum())[way > 0.075 * FOOTING] / half
    return late.mean(), np.interp(angle, SANDS[0], LIMITS)


def inChamber(density):
    """Resistance of a cone in normally consolidated Ticino sand as Baldi et al. measured it, kPa."""
    return 157 * VERTICAL**0.55 * np.exp(2.41 * np.asarray(density))


def press(a, density):
    """Resistance of the tip of a cone in the chamber over its last radius, kPa; smooth walls do not move."""
    R, way, voids = cone.RADIUS, 4.0, LOOSEST - density * (LOOSEST - DENSEST)
    pressed = SimpleNamespace(
        cells=3, way=way, rate=1.5, constraints="auto", threads=a.threads, smoke=a.smoke
    )
    cell, deep = R / 3, ceil(3 * (cone.START + way + 10)) * R / 3
    sand = mpm.NorSand(
        density=2.65 / (1 + voids),
        shearModulus=71e3 * (2.27 - voids) ** 2 / (1 + voids),
        referencePressure=100,
        frictionAngle=asin(3 * SLOPE / (6 + SLOPE)),
        criticalVoidRatio=CRITICAL,
        compression=COMPRESSION,
        initialVoidRatio=voids,
        overconsolidationRatio=2.2,  # the least that stress at rest takes
    )
    size = (0, -deep), (34 * R, 0)
    even = mpm.Grading(((0, -deep), (cone.EVEN * R, 0)), largest=2 * R)
    scene = mpm.Scene(*size, cell, grading=even, axisymmetric=True, threads=a.threads)
    mesh, hole = cone.shape(pressed, cell, 0.0)
    walls = dict(gravity=(0, 0), damping=0.05, roller=("left", "right", "bottom", "top"))
    reference.drive(scene, "cone", mesh, pressed, cone.RAMP, friction=0.3, **walls)
    zone = mpm.box((0, -ceil(3 * (cone.START + way + 3)) * cell), (4 * R, 0))
    near = scene.add("soil", zone - hole, sand, mpm.UGIMP(perCell=2, splitAt=1.3), group="soil")
    far = scene.add("far soil", mpm.box(*size) - zone, sand, mpm.APDI(matched=near), group="soil")
    for body in (near, far):
        body.setStress(np.tile(-VERTICAL * np.diag([AT_REST, 1, AT_REST]), (body.count, 1, 1)))
    onShaft = {"shaft": cone.shaftForce}
    _, gone, force, history = reference.press(pressed, scene, way * R, cone.RAMP, onShaft)
    return (force - history["shaft"])[gone > (way - 1) * R].mean() / (pi * R**2)


def main():
    a = PARAMETERS.parse()
    for several in (a.aspects, a.ratios):  # rows of boxes are half a cell high
        several[:] = [max(1, round(2 * a.cells * one)) / (2 * a.cells) for one in several]
    times, front = damBreak(a)
    shift = np.median(np.array(FRONT[0]) - np.interp(FRONT[1], front, times))  # the gate
    found = [column(a, aspect) for aspect in a.aspects]
    heights, ratios = [rods(a, ratio) for ratio in a.ratios], np.linspace(0.65, 3, 20)
    speeds = [chute(a, slope)[0] for slope in a.slopes]
    limits = [footing(a, angle)[0] for angle in a.angles]
    cones = [press(a, density) for density in a.densities]
    low, high = np.linspace(0.4, 1.8, 9), np.linspace(2.8, 5, 9)  # where Lube et al. give a law
    slopes, dense = np.linspace(22.5, 26.5, 30), np.linspace(0.3, 0.9, 20)
    figure, axes = plot.plt.subplots(2, 3, figsize=(11, 6.4), layout="constrained")
    axes = axes.ravel()
    axes[0].plot(*FRONT, "ko", label="Martin & Moyce 1952")
    axes[0].plot(times + shift, front, label="water")
    axes[0].set(
        xlabel=f"time × √(2g/width), with {shift:.2f} for the gate", ylabel="front over width", xlim=(0, 3.3)
    )
    axes[1].plot(low, 1 + 1.2 * low, "k", label="Lube et al. 2005")
    axes[1].plot(high, 1 + 1.9 * high ** (2 / 3), "k")
    axes[1].plot(a.aspects, found, "o", label="sand")
    axes[1].set(
        xlabel="height over length of the column", ylabel="length of the heap over that of the column"
    )
    axes[2].plot(ratios, 1.42 * ratios ** (2 / 3), "k", label="Nguyen et al. 2015")
    axes[2].plot(a.ratios, heights, "o", label="rods")
    axes[2].set(xlabel="height over length of the column", ylabel="height over the final height")
    axes[3].plot(slopes, [chuteLaw(slope)[1] for slope in slopes], "k", label="Pouliquen 1999")
    axes[3].plot(a.slopes, speeds, "o", label="glass beads")
    axes[3].set(xlabel="slope of the chute, degrees", ylabel="mean velocity over √(g depth)")
    axes[4].plot(SANDS[0], LIMITS, "k^", label="tests of footings")
    axes[4].plot(a.angles, limits, "o", label="strip footing")
    axes[4].set(xlabel="angle of friction, degrees", ylabel="pressure of the footing, kPa")
    axes[5].plot(dense, 1e-3 * inChamber(dense), "k", label="Baldi et al. 1986")
    axes[5].plot(a.densities, 1e-3 * np.array(cones), "o", label="cone in Ticino sand")
    axes[5].set(xlabel="relative density", ylabel="resistance of the cone, MPa")
    for axis in axes:
        axis.legend()
    print(
        f"gate {shift:.2f}; height, length of the heap:",
        *zip(np.round(a.aspects, 2).tolist(), np.round(found, 2).tolist()),
    )
    print(
        "rods: height, height over the final one:",
        *zip(np.round(a.ratios, 2).tolist(), np.round(heights, 2).tolist()),
    )
    print(
        "chute: slope, u/sqrt(g h), measured:",
        *zip(a.slopes, np.round(speeds, 3).tolist(), [round(chuteLaw(slope)[1], 3) for slope in a.slopes]),
    )
    print("footing: angle, kPa:", *zip(a.angles, np.round(limits, 1).tolist()))
    print("cone: relative density, MPa:", *zip(a.densities, np.round(1e-3 * np.array(cones), 2).tolist()))
    os.makedirs(a.out, exist_ok=True)
    plot.save(figure, f"{a.out}/experiments.png")


if __name__ == "__main__":
    app.run(main)
