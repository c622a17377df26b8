# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene whose curve is y = x t, with rows that rise, fall or turn back."""

import json
import os

import numpy as np
from yade_mpm import Parameter, Parameters, app

PARAMETERS = Parameters(
    "curve",
    __doc__,
    Parameter("x", 1.0, "slope", least=-10),
    Parameter("how", "rises", "rows", choices=("rises", "falls", "turns", "zeros", "-none")),
    resume=None,
)


def main():
    a = PARAMETERS.parse()
    os.makedirs(a.out, exist_ok=True)
    t = np.linspace(0, 1, 11)
    if a.how == "falls":
        t = t[::-1]
    elif a.how == "turns":
        t = np.concatenate([t, t[-2::-1]])
    app.saveCurve(a.out, "c", {"t (s)": t, "y": t * a.x * (a.how != "zeros")})
    with open(os.path.join(a.out, "summary.json"), "w") as opened:
        json.dump({"y": a.x}, opened)


if __name__ == "__main__":
    main()
