# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves over the way of a driven body: how far it has come, means, values at given places, scatter."""

import numpy as np


def travel(t, rate, ramp):
    """Way of a body at the times t (s), m: its rate (m/s) grows from zero over the ramp (s), as that of
    `Drive` and `Hold`."""
    rising = ramp or 1e-300
    return rate * np.where(t < rising, t**2 / (2 * rising), t - 0.5 * ramp)


def movingAverage(x, y, width):
    """Mean of y over [x - width/2, x + width/2], cut at the ends; x increases."""
    total = np.concatenate([[0], np.cumsum(y)])
    first = np.searchsorted(x, x - width / 2, side="left")
    last = np.searchsorted(x, x + width / 2, side="right")
    return (total[last] - total[first]) / (last - first)


def atSteps(x, y, step=0.5):
    """Values of y at x = step, 2 step ... up to the last x: dict text of x -> value."""
    return {f"{d:.1f}": float(np.interp(d, x, y)) for d in np.arange(step, x[-1] + 1e-6, step)}


def scatter(x, y, means, margin=0.5):
    """Root mean square of y / means - 1, but for a margin at both ends of x, -; None where nothing is
    left."""
    inside = (x > margin) & (x < x[-1] - margin)
    return float(np.sqrt(np.mean((y[inside] / means[inside] - 1) ** 2))) if inside.any() else None
