# SPDX-License-Identifier: GPL-2.0-or-later
"""A drained triaxial test of sand at a point, as a program that mpm.study runs."""

import os

import numpy as np
import yade_mpm as mpm
from yade_mpm import app
from yade_mpm.io import files

PARAMETERS = mpm.Parameters(
    "triaxial",
    __doc__,
    mpm.Parameter("hardening", 7.05, "h_0 of Sanisand", unit="-", above=0),
    mpm.Parameter("bounding", 1.1, "n_b of Sanisand", unit="-", above=0),
)
VOID_RATIO, PRESSURE, END = 0.831, 100.0, 0.23  # -, kPa, logarithmic strain


def main():
    a = PARAMETERS.parse()
    os.makedirs(a.out, exist_ok=True)
    sand = mpm.Sanisand(
        density=1.5,
        frictionAngle=np.arcsin(3 * 1.25 / 7.25),
        criticalVoidRatio=0.934,
        compression=0.019,
        initialVoidRatio=VOID_RATIO,
        hardening=a.hardening,
        bounding=a.bounding,
    )
    curve = mpm.elementTest.triaxial(sand, PRESSURE, END, steps=92)
    app.saveCurve(a.out, "q", {"strain (-)": 1 - np.exp(-curve.strain), "q (kPa)": curve.q})
    files.saveJson(f"{a.out}/summary.json", {"strength": float(curve.q.max())})


if __name__ == "__main__":
    main()
