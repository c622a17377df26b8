# SPDX-License-Identifier: GPL-2.0-or-later
"""The history of a pressed elastic bar, made by hand."""

import numpy as np

STIFFNESS, MASS = 100.0, 3.0


def bar(rate, **changed):
    """History of the pressed bar until it is shorter by 1 m, with 101 rows; the last is where columns may be
    changed."""
    t = np.linspace(0, 1 / rate, 101)
    work = STIFFNESS * (rate * t) ** 2 / 2
    history = {
        "time": t,
        "workDone": work,
        "kineticEnergy": np.full(101, MASS * rate**2 / 6),
        "dampedEnergy": 0.01 * work,
        "energyError": -0.002 * work,
        "unbalancedRatio": np.where(np.arange(101) % 2, 0.01, 0.03),
    }
    return {**history, **changed}
