#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What the laws of flows do at a point, and a dam break: the picture of doc/theory/flows.md.

PYTHONPATH=build/python /usr/bin/python3 scripts/studies/flow_laws.py doc/images/flow_laws.png
"""

import sys

import numpy as np
import yade_mpm as mpm
from yade_mpm import app, plot

SIZE, GRAINS = 0.001, 2.5  # m, Mg/m3


def sheared(law, rate, pressure):
    """Stress after steady shear at a constant volume, kPa."""
    point = mpm.MaterialPoint(law, -pressure * np.eye(3))
    for _ in range(3000):
        stress = point.gradient(np.array([[0, rate, 0], [0, 0, 0], [0, 0, 0]]), 0.02 / max(rate, 0.1))
    return stress


def grains(axes):
    for still, fast in ((0.38, 0.64), (0.52, 0.78)):
        law = mpm.MuI(
            density=1.5,
            young=2e4,
            poisson=0.3,
            staticFriction=still,
            fastFriction=fast,
            grainSize=SIZE,
            grainDensity=GRAINS,
        )
        inertia = np.geomspace(1e-3, 10, 15)
        stress = [sheared(law, i / SIZE * np.sqrt(5.0 / GRAINS), 5.0) for i in inertia]
        axes.semilogx(inertia, [-3 * s[0, 1] / np.trace(s) for s in stress], "o", ms=4)
        axes.semilogx(inertia, still + (fast - still) / (1 + 0.279 / inertia), "k-", lw=0.8)
    axes.set(
        title="MuI, steady shear", xlabel="inertial number I (-)", ylabel="shear stress over pressure (-)"
    )


def mud(axes):
    rates = np.linspace(0, 20, 15)[1:]
    for n in (0.5, 1):
        law = mpm.HerschelBulkley(
            density=1.5, bulk=1e4, yieldStress=0.5, consistency=0.1, flowIndex=n, shearModulus=1e3
        )
        axes.plot(rates, [sheared(law, rate, 10.0)[0, 1] for rate in rates], "o", ms=4, label=f"n = {n}")
        axes.plot(rates, 0.5 + 0.1 * rates**n, "k-", lw=0.8)
    axes.set(title="HerschelBulkley, steady shear", xlabel="rate of shear (1/s)", ylabel="shear stress (kPa)")
    axes.set_ylim(0, None)
    axes.legend(fontsize=8)


def dam(axes, width=0.057, g=9.81):
    water = mpm.NewtonianLiquid(density=1.0, bulk=200 * g * width)
    scene = mpm.Scene((0, 0), (6 * width, 2.5 * width), cell=width / 20, gravity=g, threads=1)
    scene.roller("left", "right", "bottom")
    body = scene.add("water", mpm.box((0, 0), (width, 2 * width)), water, mpm.UGIMP(perCell=2))
    scene.initialStress(surface=2 * width, K0=1.0)
    scene.run(until=2.0 * np.sqrt(width / (2 * g)), progress=False)
    speed = np.linalg.norm(body.velocity, axis=1)
    points = axes.scatter(*(body.position.T / width), s=1.5, c=speed)
    axes.figure.colorbar(points, label="speed (m/s)")
    axes.set(title="NewtonianLiquid, dam break at T = 2", xlabel="x/a (-)", ylabel="y/a (-)")
    axes.set_aspect("equal")


def main():
    figure, axes = plot.plt.subplots(1, 3, figsize=(11, 3), layout="constrained")
    for draw, its in zip((grains, mud, dam), axes):
        draw(its)
    plot.save(figure, sys.argv[1])


if __name__ == "__main__":
    app.run(main)
