# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes with a History."""

# SPDX-License-Identifier: GPL-2.0-or-later
import csv

import numpy as np
import yade_mpm as mpm
from setups import chain, soft
from yade_mpm import box


def engines(*more, **arguments):
    return [*chain(gravity=(0, -9.81), roller=("left", "right"), fixed=("bottom",), **arguments), *more]


def makeScene():
    """A stiff block pressed into a soft one."""
    scene = mpm.Scene((0, 0), (2, 3), 0.5)
    scene.add("soil", box((0, 0), (2, 1)), soft(2), mpm.APDI(size=0.5))
    scene.add(
        "pile", box((0.5, 1), (1.5, 2)), mpm.LinearElastic(density=2, lame=(1e4, 1e4)), mpm.UGIMP(perCell=2)
    )
    scene.dt = 1e-3
    return scene


def press(scene):
    return mpm.Drive(scene["pile"].above(1.6), (0, -0.1), name="drive")


def runWith(history, steps=100, before=(), scene=None):
    scene = scene or makeScene()
    scene.engines = engines(*before, history, drive=press(scene))
    scene.run(steps=steps, progress=False)
    return scene


def readCSV(file):
    """Header and rows of numbers."""
    with open(file, newline="") as f:
        header, *rows = csv.reader(f)
    return header, [[float(v) for v in row] for row in rows]


def assertSameColumns(one, other):
    assert one.names == other.names and one.units == other.units
    for name in one.names:
        assert np.array_equal(one[name], other[name], equal_nan=True), name
