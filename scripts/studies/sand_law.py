#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What NorSand and Sanisand do in laboratory tests: the picture of doc/theory/sand.md.

PYTHONPATH=build/python /usr/bin/python3 scripts/studies/sand_law.py doc/images/sand_law.png
"""

import sys
from math import radians

import numpy as np
import yade_mpm as mpm
from yade_mpm import app, plot

SAND = dict(
    density=1.6,
    shearModulus=5e4,
    frictionAngle=radians(31),
    criticalVoidRatio=0.75,
    compression=0.014,
    dilatancy=4,
)


TOYOURA = dict(density=1.5, frictionAngle=radians(31.15), criticalVoidRatio=0.934, compression=0.019)


def cycles(axes):
    """Toyoura sand at constant volume, between stresses of 30 kPa."""
    point = mpm.MaterialPoint(mpm.Sanisand(**TOYOURA, initialVoidRatio=0.802), -98 * np.eye(3))
    way, left, p, q = 1, 24, [98.0], [0.0]
    while left and abs(q[-1]) < 40:
        stress = point.strain(way * 2e-5 * np.diag([0.5, 0.5, -1]))
        p.append(-np.trace(stress) / 3)
        q.append(stress[0, 0] - stress[2, 2])
        if way * q[-1] >= 30:
            way, left = -way, left - 1
    axes.plot(p, q, lw=0.6)
    axes.set(title="Sanisand, cycles", xlabel="p (kPa)", ylabel="q (kPa)", xlim=(0, 105))


def main():
    figure, axes = plot.plt.subplots(1, 4, figsize=(12, 3), layout="constrained")
    for psi in (0.05, 0.02, -0.1, -0.2):
        law = mpm.NorSand(**SAND, stateParameter=psi)
        drained = mpm.elementTest.triaxial(law, pressure=200, strain=0.25)
        axes[0].plot(drained.strain, drained.q, label=f"ψ = {psi}")
        axes[1].plot(drained.strain, drained.volume)
        undrained = mpm.elementTest.triaxial(law, pressure=200, strain=0.15, drained=False)
        axes[2].plot(undrained.p, undrained.q)
    cycles(axes[3])
    axes[0].set(title="NorSand, drained, 200 kPa", xlabel="axial strain (-)", ylabel="q (kPa)")
    axes[1].set(title="the same", xlabel="axial strain (-)", ylabel="volumetric strain (-)")
    axes[2].set(title="at constant volume", xlabel="p (kPa)", ylabel="q (kPa)", xlim=(0, 400), ylim=(0, 400))
    axes[0].legend(fontsize=8)
    plot.save(figure, sys.argv[1])


if __name__ == "__main__":
    app.run(main)
