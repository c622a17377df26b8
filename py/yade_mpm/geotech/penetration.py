# SPDX-License-Identifier: GPL-2.0-or-later
"""What a body that is pressed into the ground feels: its resistance over the depth, and a picture of it.

To import by name, `from yade_mpm.geotech import penetration`: it draws with matplotlib.
"""

import numpy as np

from ..plot import figures as plot
from .curves import movingAverage, travel


def resistance(history, body, rate, ramp, gravity, width):
    """What the soil exerts on a driven body, from the force of its drive and its weight and inertia.

    history : with the columns time and drive.fy (3D: drive.fz). rate, ramp : of the drive, m/s and s.
    gravity : m/s2.
    width : of the mean, m. Returns depth of further penetration (m), resistance (kN/m) as the mean over the
    history's period, and over the width.
    """
    t = history["time"]
    depth, acceleration = travel(t, rate, ramp), np.where(t < ramp, rate / (ramp or 1.0), 0.0)
    inertia = body.inertiaScale * body.mass.sum() * acceleration
    raw = body.mass.sum() * gravity - history[f"drive.f{'xyz'[body.scene.dim - 1]}"] - inertia
    return depth, raw, movingAverage(depth, raw, width)


def draw(file, a, curve, snapshots, window):
    """Plastic shear strain at the moments of the snapshots in a window (left, right, bottom, top), and the
    resistance. a : arguments with `rate` and `ramp`; curve : as `resistance` returns it."""
    depth, raw, smooth = curve
    titles = [f"{travel(s.time, a.rate, a.ramp):.2g} m" for s in snapshots]
    figure, axes = plot.panels(snapshots, titles, 0.5, "plastic shear strain (-)", window, curves=1.2)
    axes.plot(raw, depth, "0.8", lw=0.6)
    axes.plot(smooth, depth, "C3", lw=1.6, label="mean over one cell")
    axes.set(
        xlabel="resistance (kN/m)",
        ylabel="penetration (m)",
        xlim=(0, 1.25 * smooth.max()),
        ylim=(depth[-1], 0),
    )
    axes.legend()
    plot.save(figure, file)
