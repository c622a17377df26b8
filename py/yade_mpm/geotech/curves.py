# SPDX-License-Identifier: GPL-2.0-or-later
"""Curves over the way of a driven body: how far it has come, means, values at given places, scatter."""

import numpy as np

from ..base.kinds import NUMBER, NUMBERS, POSITIVE, Kind, columns, takes

TIMES = Kind("a time, or an array of times", lambda value: NUMBER.isOne(value) or NUMBERS.isOne(value))


@takes(t=TIMES, rate=NUMBER, ramp=NUMBER)
def travel(t, rate, ramp):
    """Way of a body at the times t (s), m: its rate (m/s) grows from zero over the ramp (s), as that of
    `Drive` and `Hold`."""
    t, rising = np.asarray(t, float), ramp or 1e-300
    return rate * np.where(t < rising, t**2 / (2 * rising), t - 0.5 * ramp)


@takes(width=POSITIVE)
def movingAverage(x, y, width):
    """Mean of y over [x - width/2, x + width/2], cut at the ends; x increases."""
    x, y = columns("movingAverage", x=x, y=y)
    total = np.concatenate([[0], np.cumsum(y)])
    first = np.searchsorted(x, x - width / 2, side="left")
    last = np.searchsorted(x, x + width / 2, side="right")
    return (total[last] - total[first]) / (last - first)


@takes(step=POSITIVE)
def atSteps(x, y, step=0.5):
    """Values of y at x = step, 2 step ... up to the last x: dict text of x -> value."""
    x, y = columns("atSteps", x=x, y=y)
    return {f"{d:.1f}": float(np.interp(d, x, y)) for d in np.arange(step, max(x, default=0) + 1e-6, step)}


@takes(margin=NUMBER)
def scatter(x, y, means, margin=0.5):
    """Root mean square of y / means - 1, but for a margin at both ends of x, -; None where nothing is
    left."""
    x, y, means = columns("scatter", x=x, y=y, means=means)
    inside = (x > margin) & (x < max(x, default=0) - margin)
    return float(np.sqrt(np.mean((y[inside] / means[inside] - 1) ** 2))) if inside.any() else None
