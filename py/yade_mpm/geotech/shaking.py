# SPDX-License-Identifier: GPL-2.0-or-later
"""Records of earthquakes, and the response spectra of motions."""

import re

import numpy as np

from ..base.kinds import FILE, NUMBER, NUMBERS, POSITIVE, columns, requireFile, takes
from ..base.wording import shown

G = 9.81  # m/s2


class Record:
    """A motion over time: acceleration linear between its points, velocity its integral from rest.

    `record(t)` is the velocity at a time, m/s; after the record it keeps its last value. `time` s,
    `acceleration` m/s2 and `velocity` m/s are arrays (N,).
    """

    def __init__(self, time, acceleration):
        self.time, self.acceleration = time, acceleration
        steps = 0.5 * np.diff(time) * (acceleration[1:] + acceleration[:-1])
        self.velocity = np.concatenate(([0.0], np.cumsum(steps)))

    def __call__(self, time: float) -> float:
        k = int(np.clip(np.searchsorted(self.time, time, "right") - 1, 0, len(self.time) - 2))
        since = min(max(time - self.time[k], 0.0), self.time[k + 1] - self.time[k])
        slope = (self.acceleration[k + 1] - self.acceleration[k]) / (self.time[k + 1] - self.time[k])
        return float(self.velocity[k] + since * (self.acceleration[k] + 0.5 * since * slope))

    def __repr__(self):
        peak = np.abs(self.acceleration).max()
        return f"<Record of {len(self.time)} points to {self.time[-1]:g} s: at most {peak:.4g} m/s2>"


@takes(file=FILE, factor=NUMBER)
def readRecord(file, factor=1.0):
    """Reads the acceleration of an earthquake.

        quake = mpm.geotech.readRecord("quake.csv")
        scene.drive("bottom", velocity=lambda t: (quake(t), 0))

    Parameters
    ----------
    file : a name that ends in .AT2 (PEER: acceleration in g, NPTS and DT in the fourth line), or any other:
        two columns, time (s) and acceleration (m/s2), with commas or blanks between, below
        lines of words.
    factor : that all accelerations are multiplied with; default 1.

    Returns a `Record`. Raises ValueError for a file that holds something else.
    """
    with open(requireFile("readRecord", file)) as opened:
        lines = opened.read().splitlines()
    time, acceleration = (_at2 if str(file).lower().endswith(".at2") else _table)(file, lines)
    if len(time) < 2 or not (np.isfinite(time).all() and np.isfinite(acceleration).all()):
        raise ValueError(f"readRecord: {shown(str(file))} has no two points of finite numbers; give more")
    if (np.diff(time) <= 0).any():
        raise ValueError(f"readRecord: times in {shown(str(file))} do not grow; give rows in order of time")
    return Record(time, factor * acceleration)


def _at2(file, lines):
    head = lines[3] if len(lines) > 3 else ""
    count, step = re.search(r"NPTS\s*=\s*(\d+)", head, re.I), re.search(r"DT\s*=\s*([\d.eE+-]+)", head, re.I)
    try:
        values = np.array([float(word) for line in lines[4:] for word in line.split()])
        points, dt = int(count[1]), float(step[1])
    except (TypeError, ValueError):
        raise ValueError(
            f"readRecord: {shown(str(file))} is no AT2 file; give NPTS= and DT= in its fourth line"
        ) from None
    if len(values) != points:
        raise ValueError(
            f"readRecord: {shown(str(file))} has {len(values)} values, NPTS = {points}; give all"
        )
    return dt * np.arange(points), G * values


def _table(file, lines):
    rows = [line.replace(",", " ").replace(";", " ").split() for line in lines]
    rows = [row for row in rows if row and not re.match(r"[A-Za-z#\"]", row[0])]
    try:
        table = np.array(rows, float).reshape(len(rows), 2)
    except ValueError:
        raise ValueError(
            f"readRecord: {shown(str(file))} is not two columns of numbers; give time and acceleration"
        ) from None
    return table.T.copy()


@takes(time=NUMBERS, acceleration=NUMBERS, periods=NUMBERS, damping=POSITIVE)
def responseSpectrum(time, acceleration, periods, damping=0.05):
    """Largest pseudo-acceleration of oscillators on a ground that moves, m/s2: (2 pi/T)^2 max |u|.

    The motion is exact for accelerations that are linear between the points.

    Parameters
    ----------
    time, acceleration : s and m/s2, columns of one length, at equal steps.
    periods : T, s, of the oscillators.
    damping : part of the critical damping, below 1; default 0.05.

    Returns an array, one value for each period, of the time of the record.
    Source: N. C. Nigam, P. C. Jennings, Bull. Seism. Soc. Am. 59 (1969) 909.
    """
    time, acceleration = columns("responseSpectrum", time=time, acceleration=acceleration)
    periods = np.atleast_1d(np.asarray(periods, float))
    steps = np.diff(time)
    if len(time) < 2 or not (steps > 0).all() or np.ptp(steps) > 1e-6 * steps.mean():
        raise ValueError(
            "responseSpectrum: times are not at equal steps; give those of np.interp on equal ones"
        )
    if not (periods > 0).all() or damping >= 1:
        raise ValueError(
            f"responseSpectrum: periods = {shown(periods)}, damping = {damping:g} are not allowed; give "
            "positive periods, and damping below 1"
        )
    w, dt = 2 * np.pi / periods, steps.mean()
    wd, decay = w * np.sqrt(1 - damping**2), np.exp(-damping * w * dt)
    cos, sin = decay * np.cos(wd * dt), decay * np.sin(wd * dt)
    u, v, largest = np.zeros((3, len(w)))
    for a, b in zip(acceleration[:-1], acceleration[1:]):
        slope = -(b - a) / dt / w**2  # u = offset + slope t + free motion
        offset = -a / w**2 - 2 * damping * slope / w
        free, speed = u - offset, v - slope
        part = (speed + damping * w * free) / wd
        u = offset + slope * dt + free * cos + part * sin
        v = slope + (part * wd - damping * w * free) * cos - (free * wd + damping * w * part) * sin
        largest = np.maximum(largest, np.abs(u))
    return w**2 * largest
