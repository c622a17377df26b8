# SPDX-License-Identifier: GPL-2.0-or-later
"""Limit load of what is pressed into ground: the plateau of the load, and what smaller cells would make of
it.

    def build(cell):
        scene = mpm.Scene((0, 0), (20, 12), cell=cell)
        ...
        return scene, scene.drive(footing, velocity=(0, -0.02))

    found = mpm.limitLoad(build, cells=(0.5, 0.25), travel=0.3)
    print(found)  # limit load 1030 ± 25 kN/m (1112 at 0.5 m, 1071 at 0.25 m)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.kinds import FLAG, FUNCTION, POSITIVE, takes
from ..base.wording import shown
from ..engine.prescribed import Prescribed
from ..geometry.numbers import isNumber
from ..scene.scene import Scene
from .curves import travel as travelAt

PIECES, LATE = 40, 10  # of the travel: means of the load, and the last ones, which tell the plateau
FLAT = 0.02  # change of the load over the last pieces, as a share of it, up to which it is a plateau
ORDERS = 0.5, 3.0  # of convergence that three sizes may show; else the order is taken as one


@dataclass(frozen=True)
class LoadRun:
    """A run with one size of cells.

    cell : m.
    load : mean over the last quarter of the travel.
    rise : change of the load over that quarter, as a share of it.
    scatter : standard deviation about this change, as a share.
    travel, loads : the curve, m and as `load`.
    """

    cell: float
    load: float
    rise: float
    scatter: float
    travel: np.ndarray
    loads: np.ndarray

    @property
    def reached(self):
        """Whether the load rises no more."""
        return self.rise <= FLAT


class LimitLoad:
    """What `mpm.limitLoad` has found.

    Attributes
    ----------
    load : the limit load, extrapolated to small cells where there are two sizes or more; kN, with `area` kPa.
    uncertainty : half of what the extrapolation adds to the finest run, its scatter and its rise; as `load`.
    order : of convergence, measured with three sizes; 1.0 where it is assumed.
    reached : whether no load rises any more; if not, `load` is what they had at their end.
    runs : list of LoadRun, coarse cells first.
    """

    def __init__(self, runs, unit):
        self.runs, self._unit = sorted(runs, key=lambda run: -run.cell), unit
        self.reached = all(run.reached for run in self.runs)
        fine = self.runs[-1]
        self.order, self.load = _extrapolated([r.cell for r in self.runs], [r.load for r in self.runs])
        spread = (self.load - fine.load, fine.load * fine.scatter, fine.load * fine.rise)
        self.uncertainty = 0.5 * float(np.linalg.norm(spread))

    def plot(self, file=None):
        """Draws the load over the travel of every run, with the limit load; returns the figure.

        file : str, name of the picture; default: none.
        """
        from ..plot import figures as plot

        figure, axes = plot.plt.subplots(figsize=(5, 3.2), layout="constrained")
        for run in self.runs:
            axes.plot(run.travel, run.loads, label=f"cell {run.cell:g} m")
        ends = self.load - self.uncertainty, self.load + self.uncertainty
        axes.axhspan(*ends, color="0.85", lw=0, label="limit load" if self.reached else "load at the end")
        axes.set(xlabel="travel (m)", ylabel=f"load ({self._unit})", ylim=(0, None))
        axes.legend(loc="lower right")
        if file is not None:
            plot.save(figure, file)
        return figure

    def __repr__(self):
        loads = ", ".join(f"{run.load:.4g} at {run.cell:g} m" for run in self.runs)
        found = f"{self.load:.4g} ± {self.uncertainty:.2g} {self._unit} ({loads})"
        changes = ", ".join(f"{100 * run.rise:+.0f} %" for run in self.runs)
        late = f"the load changes by {changes} over the last quarter of the travel"
        if not self.reached:
            return f"limit load not reached: {late}; now {found}"
        falls = any(run.rise < -FLAT for run in self.runs)
        return f"limit load {found}" + (f"; it is past its peak: {late}" if falls else "")


@takes(build=FUNCTION, travel=POSITIVE, progress=FLAG)
def limitLoad(build, cells, travel, area=None, progress=True):
    """Limit load: a body is pressed until its load has a plateau, with cells of several sizes.

    Parameters
    ----------
    build : function of the size of the cells (m) that returns (scene, drive) before the first step: the
        scene, and what `scene.drive` has returned.
    cells : sizes, m, one or more. Two tell the limit of small cells for an error that falls with the cell,
        three measure the order, too.
    travel : of the drive, m; for nodes that are held a third of the smallest cell at most.
    area : by which the force is divided, m2 (2D: m); a number, or a function of the size of the cells;
        default: none, the load is a force. Nodes that are held press half a cell beyond the last of them.
    progress : bool, tells each run in a line; default True.

    Returns a `LimitLoad`. Raises TypeError where build() does not return a scene and its drive, ValueError
    for sizes or an area that are not positive.

    Source of the extrapolation: Roache 1998, Verification and Validation in Computational Science and
    Engineering (Richardson extrapolation).
    """
    sizes = list(cells) if isinstance(cells, (tuple, list, np.ndarray)) else [cells]
    if not sizes or not all(isNumber(c) and 0 < c < np.inf for c in sizes) or len(set(sizes)) < len(sizes):
        raise ValueError(
            f"limitLoad: cells = {shown(cells)} is not allowed; give different positive sizes, m, e.g. "
            "(0.5, 0.25)"
        )
    runs = []
    for cell in sorted(map(float, sizes), reverse=True):
        run, per = _press(build, cell, travel, area)
        runs.append(run)
        if progress:
            print(
                f"limitLoad: cell {cell:g} m, {run.load:.4g}, {100 * run.rise:+.1f} % over the last quarter"
            )
    return LimitLoad(runs, "kPa" if area is not None else f"kN{per}")


def _press(build, cell, travel, area):
    """A LoadRun with cells of one size, and what stands behind the unit of its force."""
    built = build(cell)
    isPair = isinstance(built, tuple) and len(built) == 2
    if not (isPair and isinstance(built[0], Scene) and isinstance(built[1], Prescribed)):
        raise TypeError(
            f"limitLoad: build({cell:g}) returns {type(built).__name__}; return (scene, drive), with what "
            "scene.drive(...) has returned"
        )
    scene, drive = built
    size = area(cell) if callable(area) else 1.0 if area is None else area
    if not (isNumber(size) and 0 < size < np.inf):
        raise ValueError(
            f"limitLoad: area = {shown(size)} is not allowed; give a positive number, or a function of the "
            "cell"
        )
    velocity = np.nan_to_num(np.array(drive.velocity, float))
    speed = np.linalg.norm(velocity)
    if not speed > 0:
        raise ValueError(f"limitLoad: the drive '{drive.name}' stands still; give it a velocity")
    began, until = scene.time, scene.time + _timeOf(travel / speed, drive.ramp)
    times, impulses = [began], [0.0]
    for time in np.linspace(began, until, PIECES + 1)[1:]:
        scene.run(until=float(time), progress=False)
        times.append(scene.time)
        impulses.append(float(drive.impulse @ velocity) / speed)
    way = travelAt(np.array(times) - began, speed, drive.ramp)
    loads = np.diff(impulses) / np.diff(times) / size
    middle = 0.5 * (way[1:] + way[:-1])
    slope, mean = np.polyfit(middle[-LATE:] - middle[-LATE:].mean(), loads[-LATE:], 1)
    rise = slope * (middle[-1] - middle[-LATE])
    scatter = np.std(loads[-LATE:] - mean - slope * (middle[-LATE:] - middle[-LATE:].mean()))
    share = abs(mean) or 1.0
    return LoadRun(
        cell, float(mean), float(rise / share), float(scatter / share), middle, loads
    ), scene._perMetre


def _timeOf(way, ramp):
    """Time in which a drive of the velocity one, which grows over `ramp`, goes a way."""
    return way + ramp / 2 if way >= ramp / 2 else (2 * ramp * way) ** 0.5


def _extrapolated(cells, loads):
    """(order of convergence, load for small cells), coarse cells first."""
    if len(cells) == 1:
        return 1.0, loads[0]
    order = _order(cells[-3:], loads[-3:]) if len(cells) > 2 else 1.0
    ratio = (cells[-2] / cells[-1]) ** order
    return order, loads[-1] + (loads[-1] - loads[-2]) / (ratio - 1)


def _order(cells, loads):
    """Order of three sizes, coarse first; 1 where they show none."""
    from scipy.optimize import brentq

    one, two = loads[0] - loads[1], loads[1] - loads[2]
    if two == 0 or one / two <= 0:
        return 1.0

    def surplus(p):
        powers = [c**p for c in cells]
        return (powers[0] - powers[1]) / (powers[1] - powers[2]) - one / two

    low, high = ORDERS
    return float(brentq(surplus, low, high)) if surplus(low) * surplus(high) < 0 else 1.0
