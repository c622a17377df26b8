# SPDX-License-Identifier: GPL-2.0-or-later
"""Strength of the ground from the load curve of a sheet pile: made with known values, then found again.

One run of a coarse, fast pile with friction gives a "measured" curve of resistance over depth, with noise;
`study.calibrate` fits the angle of friction to it, starting in the middle of a wide range. calibration.html
shows values, errors, correlation, curves and residuals. With --fit phi cohesion both are sought, and the
report shows that one load curve cannot tell them apart: their correlation is -0.998. Model and "measurement"
are the same program, so this tests the fit and not the pile. Units: Mg, m, s, kPa, degrees.

    scripts/run sheet_pile_calibration
    scripts/run sheet_pile_calibration --fit phi cohesion --noise 0.002
"""

import os
from pathlib import Path

import numpy as np
import yade_mpm as mpm
from yade_mpm import Parameter, app, study
from yade_mpm.study.calibration import METHODS
from yade_mpm.study.study import Study

PILE = Path(__file__).with_name("sheet_pile_study.py")
RANGES = {"phi": (20.0, 40.0), "cohesion": (1.0, 25.0)}  # degrees, kPa
POINTS = np.linspace(0.5, 1.5, 41)  # m of penetration; before, a cell is not filled yet
PARAMETERS = mpm.Parameters(
    "sheet_pile_calibration",
    __doc__,
    Parameter("phi", 33.0, "that made the curve", unit="degrees", least=20, most=40),
    Parameter("cohesion", 12.0, "that made the curve", unit="kPa", least=1, most=25),
    Parameter("fit", ["phi"], "which are sought; the other is known", choices=RANGES, several=True),
    Parameter("noise", 0.01, "of the curve, over its largest value", least=0, most=0.2),
    Parameter("method", METHODS[0], choices=METHODS),
    Parameter("cell", 1.0, "size of the grid's cells", unit="m", partOf=2.0),
    smoke={"cell": 2.0},
)


def main():
    a = PARAMETERS.parse()
    words = ["--cell", str(a.cell), "--rate", "1", "--ramp", "0.2", "--until", "1.7", "--friction", "0.3"]
    truth = {"phi": a.phi, "cohesion": a.cohesion}
    made = Study(PILE, [truth], os.path.join(a.out, "truth"), words=words, threads=1)
    made.run()
    curve = np.loadtxt(Path(made.folders[0], "curve_resistance.csv"), delimiter=",", skiprows=1)
    measured = np.interp(POINTS, *curve.T)
    measured += a.noise * measured.max() * np.random.default_rng(0).standard_normal(len(POINTS))
    points = np.stack([POINTS, measured], axis=1)
    ranges = {name: RANGES[name] for name in a.fit}
    known = {name: value for name, value in truth.items() if name not in a.fit}
    words += [word for name, value in known.items() for word in (f"--{name}", str(value))]
    found = study.calibrate(PILE, ranges, points, "resistance", a.out, method=a.method, words=words)
    for name, value in found.values.items():
        error = "not known" if found.errors[name] is None else f"{found.errors[name]:.2g}"
        print(f"{name:10s} {value:8.3f}, standard error {error}; made with {truth[name]:g}")
    share = found.rms / found.scale
    print(f"{found.runs} runs, residuals {share:.1%} of the curve; see {a.out}/calibration.html")


if __name__ == "__main__":
    app.run(main)
