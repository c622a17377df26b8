#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What the soil laws do in laboratory tests: the picture of doc/explanation/soils.md.

PYTHONPATH=build/python /usr/bin/python3 scripts/studies/soil_laws.py doc/images/soil_laws.png
"""

import sys
from math import radians

import yade_mpm as mpm
from yade_mpm import app, plot

ELASTIC = dict(density=1.8, young=3e4, poisson=0.3)
PHI = dict(cohesion=5, frictionAngle=radians(35), dilatancyAngle=radians(5))


def sand(axes):
    """Drained triaxial tests of sand, perfectly plastic and softening."""
    residual = dict(residualCohesion=0, residualFrictionAngle=radians(30), residualDilatancyAngle=0)
    laws = {
        "perfectly plastic": mpm.MohrCoulomb(**ELASTIC, **PHI),
        "softening": mpm.MohrCoulomb(**ELASTIC, **PHI, **residual, softeningStrain=0.1),
    }
    for name, law in laws.items():
        curve = mpm.elementTest.triaxial(law, pressure=100, strain=0.1)
        axes.plot(curve.strain, curve.q, label=name)
    axes.set(title="MohrCoulomb, drained triaxial", xlabel="axial strain (-)", ylabel="q (kPa)")


def clay(axes):
    """Cycles of shear that remould clay."""
    given = dict(density=1.7, young=5e3, poisson=0.49, undrainedStrength=10)
    law = mpm.Tresca(**given, remouldedRatio=0.3, softeningStrain=2)
    curve = mpm.elementTest.simpleShear(law, 0, [0.1] + [-0.1, 0.1] * 8, drained=False, steps=200)
    axes.plot(curve.strain, curve.q, lw=0.8, label="16 half cycles")
    axes.set(title="Tresca, softening clay", xlabel="shear strain (-)", ylabel="shear stress (kPa)")


def camClay(axes):
    """Undrained triaxial tests of clay, normally consolidated and over-consolidated."""
    given = dict(density=1.7, compression=0.2, swelling=0.04, frictionAngle=radians(25), initialVoidRatio=1.0)
    for ratio in (1, 2, 5):
        law = mpm.ModifiedCamClay(**given, overconsolidationRatio=ratio)
        curve = mpm.elementTest.triaxial(law, pressure=100, strain=0.2, drained=False)
        axes.plot(curve.p, curve.q, label=f"OCR = {ratio}")
    axes.set(
        title="ModifiedCamClay, undrained", xlabel="p (kPa)", ylabel="q (kPa)", xlim=(0, None), ylim=(0, None)
    )


def main():
    figure, axes = plot.plt.subplots(1, 3, figsize=(10, 3), layout="constrained")
    for draw, its in zip((sand, clay, camClay), axes):
        draw(its)
        its.legend(fontsize=8)
    plot.save(figure, sys.argv[1])


if __name__ == "__main__":
    app.run(main)
