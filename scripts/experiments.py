#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Beside experiments: a dam break (Martin & Moyce 1952), columns of sand of friction sin(31 degrees) (Lube et
al. 2005) and of aluminium rods of 19.8 degrees (Nguyen, Bui & Fukagawa 2015). Units: Mg, m, s, kPa."""

import os
from math import radians

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, plot

G = 9.81
WIDTH = 0.05715  # m, of the water
# Phil. Trans. R. Soc. A 244, 312-324, table 2: T = t sqrt(2 g/width) and the front over the width.
FRONT = (1.19, 1.43, 1.63, 1.83, 1.98, 2.20, 2.32, 2.51, 2.65, 2.83, 2.98, 3.11), np.linspace(1.44, 3.89, 12)
LENGTH, RODS = 0.1, 0.2  # m, of the columns of sand and of rods
FLIP = 0.99  # share of their own velocity that grains keep

CELLS = Parameter("cells", 10, "cells in the width of the water and of a column", whole=True, least=4)
ASPECTS = Parameter("aspects", [0.5, 1.0, 2.0, 4.0], "heights of columns over lengths", several=True, above=0)
RATIOS = Parameter(
    "ratios", [0.7, 1.0, 2.0, 3.0], "heights of columns of rods over lengths", several=True, above=0
)
SMOKE = {"ratios": [1.0], "cells": 4, "aspects": [0.5]}
PARAMETERS = mpm.Parameters("experiments", __doc__, CELLS, ASPECTS, RATIOS, smoke=SMOKE)


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


def main():
    a = PARAMETERS.parse()
    for several in (a.aspects, a.ratios):  # rows of boxes are half a cell high
        several[:] = [max(1, round(2 * a.cells * one)) / (2 * a.cells) for one in several]
    times, front = damBreak(a)
    shift = np.median(np.array(FRONT[0]) - np.interp(FRONT[1], front, times))  # the gate
    found = [column(a, aspect) for aspect in a.aspects]
    heights, ratios = [rods(a, ratio) for ratio in a.ratios], np.linspace(0.65, 3, 20)
    low, high = np.linspace(0.4, 1.8, 9), np.linspace(2.8, 5, 9)  # where Lube et al. give a law
    figure, axes = plot.plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
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
    os.makedirs(a.out, exist_ok=True)
    plot.save(figure, f"{a.out}/experiments.png")


if __name__ == "__main__":
    app.run(main)
