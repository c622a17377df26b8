# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes with implicit bodies."""

import yade_mpm as mpm
from setups import chain
from yade_mpm import box

CELL, LENGTH, THICKNESS = 0.25, 5.0, 0.25
LAME = (4.2e7, 2.8e7)
CRITICAL = 6.1e-5  # s, of the column
KINDS = {"uGIMP": lambda: mpm.UGIMP(perCell=2), "APDI": lambda: mpm.APDI(size=CELL / 2)}


def column(kind="uGIMP", dim=2, across=0.0, along=0.0, implicit=True, **solver):
    """A steel column on a fixed base under a body force along and across it, m/s2; critical step 6.1e-5 s."""
    height, left = LENGTH if dim == 2 else 1.5, 2 * CELL - THICKNESS / 2
    lower, upper = (left,) * (dim - 1), (left + THICKNESS,) * (dim - 1)
    scene = mpm.Scene((0,) * dim, (4 * CELL,) * (dim - 1) + (height + 4 * CELL,), CELL, threads=1)
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    kind = KINDS[kind]()
    scene.add("column", box((*lower, 0), (*upper, height)), steel, kind, implicit=implicit)
    gravity = (across, *(0.0,) * (dim - 2), along)
    scene.engines = chain(gravity=gravity, fixed="bottom", **solver)
    return scene


def soilWithPile(implicit=True, damping=0.05, scheme="MUSL", threads=1, **options):
    """A short pile, bonded, driven into soft soil."""
    scene = mpm.Scene((0, 0), (3, 3), CELL, scheme=scheme, threads=threads)
    shaft = box((1.375, 1.0), (1.625, 2.5))
    soft = mpm.LinearElastic(density=1.5, lame=(1e4, 6e3))
    scene.add("soil", box((0, 0), (3, 2)) - shaft, soft, mpm.UGIMP())
    steel = mpm.LinearElastic(density=7.85, lame=LAME)
    pile = scene.add("pile", shaft, steel, mpm.UGIMP(), implicit=implicit, **options)
    drive = mpm.Drive(pile.above(2.25), velocity=(0, -0.1), ramp=0.01, name="drive")
    scene.engines = chain(
        gravity=(0, -9.81), damping=damping, fixed="bottom", roller=("left", "right"), drive=drive
    )
    return scene


def names(scene):
    return [type(e).__name__ for e in scene.engines]
