# SPDX-License-Identifier: GPL-2.0-or-later
"""What the numbering of a mesh costs: APDI domains as a mesh is numbered, and in rows (`mpm.inRows`).

    scripts/run bench_mesh                       # a block of 140 x 140 domains, numbered in three ways
    scripts/run bench_mesh slope.msh pile.vtk    # files of quadrilaterals or hexahedra

One thread, MCDP soil without load, cells of twice the mean edge; the shortest of many runs of five
steps, stage by stage, and their sum.
"""

import argparse
import time
from math import radians

import numpy as np
import yade_mpm as mpm
from yade_mpm import app


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("files", nargs="*", help="mesh files; default: the block")
    p.add_argument("--seconds", type=app.positive, default=2.0, help="of measuring, each (default 2)")
    return p.parse_args()


def block(n):
    """A block of n x n domains, numbered row by row, column by column, and at random: (name, mesh) each."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0)))
    points = np.stack([x, y], axis=1)
    lowest = np.flatnonzero((x < n) & (y < n))
    cells = lowest[:, None] + [0, 1, n + 2, n + 1]
    rng = np.random.default_rng(1)
    for name, order, rows in (
        ("row by row", np.arange(len(points)), np.arange(len(cells))),
        ("column by column", np.argsort(x, kind="stable"), np.argsort(x[lowest], kind="stable")),
        ("at random", rng.permutation(len(points)), rng.permutation(len(cells))),
    ):
        number = np.argsort(order)
        yield name, mpm.Mesh(points[order], number[cells[rows]])


def stepTime(mesh, seconds):
    """ns per domain and step: the shortest of each stage, and their sum."""
    n, dim = len(mesh.cells), mesh.dim
    extent = np.ptp(mesh.points, axis=0)
    cell = 2 * (np.prod(extent) / n) ** (1 / dim)
    lower = mesh.points.min(axis=0) - cell
    scene = mpm.Scene(tuple(lower), tuple(lower + cell * np.ceil(extent / cell + 2)), cell, threads=1)
    soil = mpm.MohrCoulombDruckerPrager(
        density=2.0, young=1e3, poisson=0.3, cohesion=1.0, frictionAngle=radians(25)
    )
    scene.add("soil", mesh, soil, mpm.APDI(), fbar=False)
    scene.engines = [mpm.ParticleToGrid(), mpm.GridSolver(), mpm.GridToParticle(), mpm.DomainUpdater()]
    scene.dt = 1e-3 * cell / soil._core.waveSpeed
    scene.run(steps=20, progress=False)
    shortest, before, end = np.inf, total(scene), time.perf_counter() + seconds
    while time.perf_counter() < end:
        scene.run(steps=5, progress=False)
        now = total(scene)
        shortest, before = np.minimum(shortest, now - before), now
    return shortest.sum() / (5 * n) * 1e9


def total(scene):
    """Seconds of every engine so far."""
    return np.array([seconds for seconds, _ in scene.timing().values()])


def main():
    a = arguments()
    meshes = [(file, mpm.meshFromFile(file, file)) for file in a.files] if a.files else block(140)
    print(f"{'ns per domain and step':40} {'domains':>8} {'as numbered':>12} {'in rows':>8}")
    for name, mesh in meshes:
        given, rows = stepTime(mesh, a.seconds), stepTime(mpm.inRows(mesh), a.seconds)
        print(f"{name:40} {len(mesh.cells):8} {given:12.1f} {rows:8.1f}", flush=True)


if __name__ == "__main__":
    app.run(main)
