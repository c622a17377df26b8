#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A plate with a circular hole under tension: curved APDI domains from a mesh of one's own.

A plate of 5 x 8 m with a hole of radius a = 0.5 m is pulled at its short ends with sigma0 = 100 Pa. A quarter
is meshed with quadrilaterals that follow the hole; the traction acts on the edges of the domains. Reference:
stress concentration in a strip of finite width, a / W = 0.2 (Howland 1930, Phil. Trans. R. Soc. A 229,
49-86): hoop stress 3.14 sigma0 where the hole meets the section across the load, -1.11 sigma0 where it meets
the axis of the load. Stresses in the plane are those of plane stress, because the hole carries no force.

Units: kg, m, s, Pa, per metre of thickness.

    scripts/run plate_with_hole                  # 8 cells per radius
    scripts/run plate_with_hole --smoke          # 4 cells per radius
"""

import os
import time

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, box, geotech, plot
from yade_mpm.io import files

HALF_WIDTH, HALF_LENGTH, RADIUS = 2.5, 4.0, 0.5  # m; the load is along y
SIGMA0, YOUNG, POISSON, DENSITY = 100.0, 1e6, 0.3, 1000.0  # Pa, Pa, -, kg/m3: strains of 1e-4
REFERENCE = {"side": 3.14, "crown": -1.11}  # hoop stress over sigma0 at (a, 0) and (0, a)


PARAMETERS = mpm.Parameters(
    "plate_with_hole",
    __doc__,
    Parameter("cells", 8, "cells per radius of the hole", least=1, whole=True),
    smoke={"cells": 4},
)
arguments = PARAMETERS.parse


def quarterMesh(cell):
    """Quadrilaterals of the quarter plate, (points (Nv, 2), cells (Nc, 4)): rays from the hole to the outer
    edge.

    No edge is longer than a cell, so that every grid node inside the plate belongs to some vertex. Rings are
    closest at the hole.
    """
    across = int(np.ceil(HALF_WIDTH / cell))  # rays that end on the top, y = HALF_LENGTH
    along = int(np.ceil(HALF_LENGTH / cell))  # rays that end on the right, x = HALF_WIDTH
    outer = np.concatenate(
        [
            np.stack([np.full(along, HALF_WIDTH), np.linspace(0, HALF_LENGTH, along + 1)[:-1]], axis=1),
            np.stack([np.linspace(HALF_WIDTH, 0, across + 1), np.full(across + 1, HALF_LENGTH)], axis=1),
        ]
    )
    angle = np.linspace(0, np.pi / 2, len(outer))
    inner = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner[-1, 0] = 0.0
    longest = np.linalg.norm(outer - inner, axis=1).max()
    rings = int(np.ceil(1.3 * longest / cell))
    s = np.linspace(0, 1, rings + 1)[:, None, None]
    s = 0.6 * s + 0.4 * s**2  # steps from 0.6 to 1.4 of the mean
    points = (1 - s) * inner + s * outer
    return geotech.quadrilaterals(points[..., 0], points[..., 1])


def build(a):
    """The scene: upper right quarter of the plate, the hole's centre at the origin, pulled at the top."""
    cell = RADIUS / a.cells
    scene = mpm.Scene(
        lower=(0, 0), upper=(HALF_WIDTH + 2 * cell, HALF_LENGTH + 2 * cell), cell=cell, threads=a.threads
    )
    scene.damping = 0.7
    scene.roller("left", "bottom")
    metal = mpm.LinearElastic(density=DENSITY, young=YOUNG, poisson=POISSON)
    plate = scene.add("plate", quarterMesh(cell), metal, mpm.APDI())
    end = box((-cell, HALF_LENGTH - 1e-6), (HALF_WIDTH + cell, HALF_LENGTH + 1e-6))
    ramp = 4 * 4 * HALF_LENGTH / metal.waveSpeed
    scene.load(plate, end, traction=(0.0, SIGMA0), ramp=ramp)
    return scene


def hoopStress(plate, side):
    """Distance from the hole over its radius, and hoop stress over sigma0, of the domains nearest to an
    axis."""
    x, y = plate.position.T
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    if side == "crown":
        angle = np.pi / 2 - angle
    near = np.abs(angle) < np.radians(4)
    order = np.argsort(r[near])
    k = 1 if side == "side" else 0
    return r[near][order] / RADIUS - 1, plate.stress[near, k, k][order] / SIGMA0


def atHole(plate, side, reach=0.75):
    """Hoop stress over sigma0 at the hole: the form of the closed solution, c0 + c2 / r^2 + c4 / r^4, fitted
    up to reach radii.

    The domains hold one stress each and the cells at the hole are cut by it; a fit takes the mean of their
    scatter.
    """
    distance, stress = hoopStress(plate, side)
    near = distance < reach
    r = 1 + distance[near]
    terms = np.stack([r**0, r**-2.0, r**-4.0], axis=1)
    return float(np.linalg.lstsq(terms, stress[near], rcond=None)[0].sum())


def run(a, tolerance=1e-2):
    """Pulls the plate and lets it come to rest; returns (summary, scene).

    tolerance : largest out-of-balance force over the mean internal force; the largest sits at light nodes of
    cut cells.
    """
    began, scene = time.monotonic(), build(a)
    load = next(e for e in scene.engines if isinstance(e, mpm.BoundaryLoad))
    scene.run(until=load.ramp)
    scene.settle(damping=0.7, tolerance=tolerance)
    plate = scene["plate"]
    reached = {side: atHole(plate, side) for side in REFERENCE}
    base = next(c for c in scene.constraints if c.name == "bottom")
    return {
        **app.record(a, scene, time.monotonic() - began),
        "domains": scene.particleCount,
        "unbalancedForce": scene.unbalancedForce(),
        "baseReactionOverLoad": -base.reaction[1] / (SIGMA0 * HALF_WIDTH),
        "concentration": reached,
        "reference": REFERENCE,
        "error": {side: reached[side] / REFERENCE[side] - 1 for side in REFERENCE},
    }, scene


def draw(scene, summary, out):
    """Stress round the hole, and hoop stress along both axes against Howland."""
    plate = scene["plate"]
    figure, (left, right) = plot.plt.subplots(1, 2, figsize=(8.6, 4.0), layout="constrained")
    label = "stress along the load / σ0"
    plot.domains(
        left, [plate], lambda b: b.stress[:, 1, 1] / SIGMA0, (-3.2, 3.2), label, "coolwarm", edge="0.3"
    )
    left.set(xlim=(0, 1.6), ylim=(0, 1.6), xlabel="x (m)", ylabel="y (m)")
    for side, colour, axis in (("side", "C3", "across the load"), ("crown", "C0", "along the load")):
        distance, stress = hoopStress(plate, side)
        right.plot(distance, stress, ".", ms=3, color=colour, label=f"domains on the axis {axis}")
        right.plot(0, REFERENCE[side], "k_", ms=14, mew=1.5)
        right.plot(0, summary["concentration"][side], "o", color=colour, fillstyle="none")
    right.plot([], [], "k_", ms=14, mew=1.5, label="Howland 1930")
    right.plot([], [], "ko", fillstyle="none", label="fit at the hole")
    right.set(xlabel="distance from the hole / radius", ylabel="hoop stress / σ0", xlim=(-0.1, 3))
    right.legend()
    plot.save(figure, os.path.join(out, "plate_with_hole.png"))


def main():
    a = arguments()
    os.makedirs(a.out, exist_ok=True)
    summary, scene = run(a)
    files.saveJson(os.path.join(a.out, "summary.json"), summary)
    draw(scene, summary, a.out)
    for side, exact in REFERENCE.items():
        found, error = summary["concentration"][side], summary["error"][side]
        print(f"{side:6s} hoop stress / sigma0 {found:7.3f}, reference {exact:6.2f} ({error:+.1%})")
    print(f"{summary['domains']} domains, {summary['steps']} steps; results in {a.out}/")


if __name__ == "__main__":
    app.run(main)
