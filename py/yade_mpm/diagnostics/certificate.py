# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether a run can be called quasi-static: a few ratios of its history against limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

import numpy as np

from ..base.kinds import COLUMNS, DICT, NOT_NEGATIVE, NUMBER, POSITIVE, columns, takes

START_UP = (
    0.1  # share of the time at the beginning that does not count: little work is done, and the load sets in
)

MOVING = 0.05  # of the mean work of a tenth of the time: where less is done no load is moved

LIMITS = {
    "kineticRatio": 0.05,  # Getting Started with Abaqus, 13.4: 0.05 to 0.1 of the internal energy mostly
    "unbalancedRatio": 0.05,  # measured: doc/explanation/quasi-static.md; YADE asks 0.01 of its own at rest
    "unseenRatio": 0.01,  # measured: doc/explanation/quasi-static.md
    "energyError": 0.02,  # Abaqus: total energy within 1 percent; Radioss: 1 or 2 percent are acceptable
    "dampedRatio": 0.05,  # our choice; artificial energies in Abaqus: 0.02 no problem, 0.15 substantial
    "dampedShare": 0.1,  # our choice: twice that of the whole run, for a tenth of it
    "inertialShare": 0.05,  # measured: the load is too high by as much to twice of it, see the page
    "hourglassRatio": 0.05,  # Abaqus: artificial energy below 5 to 10 % of the internal one
    "volumeError": 0.1,  # our choice: few cells of a small body scatter by half of it
    "loadJump": 0.1,  # our choice: half of it to either side of a smooth curve, which would not be seen
    "rateSensitivity": 0.05,  # what an engineer would not see in a resistance
}
# In cells of the path from where the front of a driven body crosses a row of nodes: in the middle of the cell
# before, and before and behind the jump, which lasts from -1/16 to 1/8. And how far the path has to reach.
WINDOWS = (-0.5, -0.375), (-0.1875, -0.0625), (0.125, 0.25)
LEAST_BEFORE, LEAST_BEHIND = 0.5, 0.15
NEEDED = ("time", "kineticEnergy", "dampedEnergy", "energyError", "workDone", "unbalancedRatio")

_meaning = {
    "kineticRatio": "kinetic energy is {} of the work done",
    "unbalancedRatio": "the mean out-of-balance force of the nodes is {} of the mean force on a node",
    "unseenRatio": "particles swing, unseen by the grid, with {} of the work done, which weakens soil",
    "energyError": "the energy balance is open by {} of the work done",
    "dampedRatio": "damping took {} of the work done",
    "dampedShare": "damping carried up to {} of the load",
    "inertialShare": "up to {} of the load accelerated what it moves, or let it slow down",
    "hourglassRatio": "hourglass control stores {} of the work done",
    "volumeError": "the volumes of the particles are off by {} of the cells that they fill",
    "loadJump": "the load jumps by {} when the moving body crosses a row of cells",
    "rateSensitivity": "another rate changes the result by {}",
}
_remedy = {
    "energyError": ": half the rate, or half the cells where the rate makes no difference",
    "dampedRatio": ": damp less and load more slowly (not of soil that comes to rest, as after a dig)",
    "inertialShare": ": load more slowly, or with a ramp",
    "loadJump": ": take smaller cells, or the mean load over a cell of the path",
}


@dataclass(frozen=True)
class Certificate:
    """What `quasiStatic` found: numbers, the limits used, and the verdict.

    Parameters
    ----------
    kineticRatio : largest kinetic energy over the work done, -; of bodies that a drive carries along, the
        energy of their motion relative to the drive.
    unbalancedRatio : mean of `diagnostics.unbalancedRatio`, -.
    energyError : largest |energy error| over the work done, -.
    dampedRatio : energy taken by local damping, and by the solution for implicit bodies, over the work done,
        at the end, -.
    dampedShare : largest share that damping took, in any tenth of the rows, of the work of the prescribed
        motions (of all work where nothing is prescribed): of the load that moves something, the part that
        damping carries then, -; nan where no tenth does 5 % of the mean work.
    inertialShare : largest change of the kinetic energy in any tenth of the rows over the work of the
        prescribed motions in it, -: of their load, the part that is inertia then; None: nothing is
        prescribed, or the history does not tell, or no tenth does 5 % of the mean work.
    hourglassRatio : largest energy stored by hourglass control over the work done, -; None: the history
        does not tell.
    rateSensitivity : relative change of the result at another rate, -; None: not looked at.
    volumeError : largest |`diagnostics.volumeRatio` - 1|, -: whether particles have the volume of the space
        that they fill; None: the history has no such column, or there is no cell inside a body.
    loadJump : mean size of the jumps of the load where the front of a driven body crosses a row of nodes, up
        or down, over the load, -; the largest of all drives; None: the history does not tell, or no path is
        long enough (`notJudged`): it needs half a cell before a row and 0.15 behind it.
    unseenRatio : largest `diagnostics.unseenEnergy` over the work done, -: where particles move against each
        other soil that yields becomes too weak; None: the history has no such column.
    drainage : sentence that says whether pore water has time to leave, by `diagnostics.drainage`; None: there
        is none. It is no part of the verdict.
    after : rows of the history from this time on count, s.
    limits : dict name -> largest allowed value.
    notJudged : dict name -> what a ratio needs that this run did not give; it does not refuse the verdict.

    Shown or printed it is the verdict, the reasons against it in words, and a table of the ratios.
    """

    kineticRatio: float
    unbalancedRatio: float
    energyError: float
    dampedRatio: float
    dampedShare: float
    hourglassRatio: float | None
    rateSensitivity: float | None
    after: float
    volumeError: float | None = None
    loadJump: float | None = None
    unseenRatio: float | None = None
    inertialShare: float | None = None
    drainage: str | None = None
    limits: dict = field(default_factory=lambda: dict(LIMITS))
    notJudged: dict = field(default_factory=dict)

    @property
    def reasons(self) -> list[str]:
        """List of sentences that say why the run is not quasi-static; empty if it is."""
        failed = [name for name in self._judged() if not getattr(self, name) <= self.limits[name]]
        return [self._sentence(name) + _remedy.get(name, "") for name in failed]

    @property
    def isQuasiStatic(self) -> bool:
        """Whether every ratio that is judged is known and within its limit."""
        return not self.reasons

    def asDict(self) -> dict:
        """Numbers, limits and verdict as plain types, for JSON; a number that is not known is None."""
        plain = {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in asdict(self).items()
        }
        return {**plain, "isQuasiStatic": self.isQuasiStatic, "reasons": self.reasons}

    def __str__(self):
        reasons = [f"NOT quasi-static: {reason}" for reason in self.reasons]
        rows = [("", "found", "limit", ""), *map(self._row, self._judged())]
        table = ["  {:<16}{:>10}{:>8}  {}".format(*row).rstrip() for row in rows]
        table += [f"  {name:<16}not judged, needs {needs}" for name, needs in self.notJudged.items()]
        every = "every ratio that is judged" if self.notJudged else "every ratio"
        water = [f"pore water: {self.drainage}"] if self.drainage else []
        return "\n".join([*(reasons or [f"quasi-static: {every} is within its limit"]), *table, *water])

    __repr__ = __str__

    def _judged(self):
        return [name for name in self.limits if getattr(self, name) is not None]

    def _row(self, name):
        """Name, value, limit and verdict of a ratio, as texts."""
        value, limit = getattr(self, name), self.limits[name]
        found = "not known" if math.isnan(value) else _percent(value)
        return name, found, _percent(limit), "" if value <= limit else "NOT met"

    def _sentence(self, name):
        value = getattr(self, name)
        if math.isnan(value):
            return f"{name} is not known (no work is done, or the history holds nan)"
        return f"{_meaning[name].format(_percent(value))} (limit {_percent(self.limits[name])})"


@takes(history=COLUMNS, after=NUMBER, rateSensitivity=NOT_NEGATIVE, limits=DICT)
def quasiStatic(
    history: Mapping,
    after: float | None = None,
    rateSensitivity: float | None = None,
    limits: dict | None = None,
) -> Certificate:
    """Check of a run: whether it can be called quasi-static, by its history.

    Parameters
    ----------
    history : `History` of the run, or a mapping of its columns time (s), kineticEnergy, dampedEnergy,
        energyError, workDone (kJ) and unbalancedRatio (-); implicitEnergy, where there is one, counts as
        damped. Used where they exist: freeKineticEnergy (kJ; see below), hourglassEnergy, unseenEnergy (kJ),
        volumeRatio (-), and for each drive NAME.work (kJ) with NAME.rowsCrossed (-).
    after : rows from this time on count, s; default: the last nine tenths of the time that the rows span.
    rateSensitivity : what `mpm.rateSensitivity` gives for the result that matters and a run at another
        rate, -; default: not judged.
    limits : dict of limits that replace some of the default ones: kineticRatio 0.05, unbalancedRatio 0.05,
        unseenRatio 0.01, energyError 0.02, dampedRatio 0.05, dampedShare 0.1, inertialShare 0.05,
        hourglassRatio 0.05, volumeError 0.1, loadJump 0.1, rateSensitivity 0.05.

    Energies are compared with `diagnostics.workDone`. A body that a drive carries along stores kinetic
    energy that the drive prescribes, the more the larger its inertia; it says nothing about how what it
    meets responds. With the column freeKineticEnergy (`diagnostics.freeKineticEnergy`) this energy counts
    neither as kinetic energy nor as the work that this is compared with. A ratio that is nan counts as not
    known, and refuses the verdict. The sources of the limits are in doc/explanation/quasi-static.md.
    Energies of a whole model say little about a small part of it, and nothing about a history that is too
    coarse to see a peak.

    Raises ValueError for a history without rows after `after`, an unknown or non-positive limit, or a
    negative rateSensitivity.
    """
    (t,) = columns("quasiStatic", time=_column(history, "time"))
    if not len(t):
        raise ValueError(
            "quasiStatic: the history has no rows; put a History with a shorter period among the engines"
        )
    if after is None:
        after = t[0] + START_UP * (t[-1] - t[0])
    rows = t >= after
    if not rows.any():
        raise ValueError(
            f"quasiStatic: the history has no rows from after = {after:g} s on, it ends at {t[-1]:g} s"
        )
    needed = columns("quasiStatic", **{name: _column(history, name) for name in NEEDED})
    kinetic, damped, error, work, unbalanced = (column[rows] for column in needed[1:])
    onLoad = work
    if "freeKineticEnergy" in _names(history):
        free = np.asarray(history["freeKineticEnergy"], dtype=float)[rows]
        kinetic, onLoad = free, work - (kinetic - free)
    if "implicitEnergy" in _names(history):
        damped = damped + np.asarray(history["implicitEnergy"], dtype=float)[rows]
    prescribed = _prescribed(history, rows, onLoad - work)
    loadJump, needs = _loadJump(history, rows)
    return Certificate(
        kineticRatio=_largest(kinetic, onLoad),
        unbalancedRatio=float(unbalanced.mean()),
        energyError=_largest(np.abs(error), work),
        dampedRatio=_largest(damped[-1:], work[-1:]),
        dampedShare=_carried(damped, work if prescribed is None else prescribed),
        inertialShare=_inertial(kinetic, prescribed),
        hourglassRatio=_ratioOf("hourglassEnergy", history, rows, work),
        unseenRatio=_ratioOf("unseenEnergy", history, rows, work),
        rateSensitivity=None if rateSensitivity is None else float(rateSensitivity),
        after=float(after),
        volumeError=_volumeError(history, rows),
        loadJump=loadJump,
        limits=_limits(limits or {}),
        notJudged={"loadJump": needs} if needs else {},
    )


def rateSensitivity(x, result, xOther, resultOther):
    """Relative change of a result at another rate, mean |difference| over mean |result|, where both reach, -.

    Parameters
    ----------
    x, result : (N,), e.g. penetration (m, increasing) and resistance (kN) of the run.
    xOther, resultOther : (M,), of the other one.

    Take twice the rate for the other run. If the result depends on the rate by a power of one or more,
    R(2v) - R(v) is at least R(v) - R(0), what the rate of the run itself does; and that run takes half the
    time.

    Raises ValueError if the two have fewer than two points of the run in common.
    """
    x, result = columns("rateSensitivity", x=x, result=result)
    xOther, resultOther = columns("rateSensitivity", xOther=xOther, resultOther=resultOther)
    common = (x >= np.min(xOther, initial=np.inf)) & (x <= np.max(xOther, initial=-np.inf))
    if common.sum() < 2:
        raise ValueError(
            "rateSensitivity: the two runs share no range of displacement; run the other one as far"
        )
    difference = np.interp(x[common], xOther, resultOther) - result[common]
    return float(np.abs(difference).mean() / np.abs(result[common]).mean())


def _column(history, name):
    if name not in _names(history) and not hasattr(history, "names"):
        raise ValueError(f"quasiStatic: the history has no column '{name}'; give {', '.join(NEEDED)}")
    return history[name]


def _names(history):
    """Names of the columns of a History or a mapping."""
    return history.names if hasattr(history, "names") else history.keys()


def _largest(part, work):
    """Largest part over work; nan where no work is done."""
    if not (work > 0).all():
        return math.nan
    return float((part / work).max())


def _ratioOf(name, history, rows, work):
    """Largest value of a column over the work; None for a history without it, as of an older version."""
    if name not in _names(history):
        return None
    return _largest(np.asarray(history[name], dtype=float)[rows], work)


def _carried(taken, work):
    """Largest energy taken over the work of a tenth of the rows; nan where nothing moves in any."""
    ends = np.unique(np.linspace(0, len(work) - 1, 11).round().astype(int))
    took, done = np.diff(taken[ends]), np.diff(work[ends])
    moves = done > MOVING * (work[-1] - work[0]) / max(1, len(done))
    return float((took[moves] / done[moves]).max()) if moves.any() else math.nan


def _prescribed(history, rows, carried):
    """Work of the prescribed motions at the rows, or None where they do none. carried: what they do on the
    bodies that they carry along, of which no load speaks."""
    names = [n for n in _names(history) if n.endswith(".work")]
    if not names:
        return None
    each = [np.abs(np.diff(np.asarray(history[n], dtype=float)[rows])) for n in names]
    work = np.r_[0.0, np.cumsum(np.sum(each, axis=0))] + carried - carried[0]
    return work if np.isfinite(work).all() and work[-1] > 0 else None


def _inertial(kinetic, prescribed):
    """Largest change of the kinetic energy over the work of the prescribed motions in a tenth of the rows, or
    None."""
    if prescribed is None:
        return None
    ends = np.unique(np.linspace(0, len(kinetic) - 1, 11).round().astype(int))
    changed = np.r_[0.0, np.cumsum(np.abs(np.diff(kinetic[ends])))]
    share = _carried(np.interp(np.arange(len(kinetic)), ends, changed), prescribed)
    return None if math.isnan(share) else share


def _volumeError(history, rows):
    """Largest deviation of volumeRatio from one; None where it is not known."""
    try:
        ratio = np.asarray(history["volumeRatio"], dtype=float)[rows]
    except KeyError:
        return None
    return None if np.isnan(ratio).all() else float(np.nanmax(np.abs(ratio - 1)))


def _loadJump(history, rows):
    """Largest mean jump of the load of a drive where its body crosses a row of nodes, or None, and what the
    longest path lacks to tell."""
    names = [n[: -len(".rowsCrossed")] for n in _names(history) if n.endswith(".rowsCrossed")]
    columns = ((history[f"{n}.rowsCrossed"], history[f"{n}.work"]) for n in names)
    paths = [_ahead(*(np.asarray(c, dtype=float)[rows] for c in pair)) for pair in columns]
    paths = [(path, work) for path, work in paths if len(path) > 1]
    jumps = [_meanJump(path, work) for path, work in paths]
    known = [jump for jump in jumps if jump is not None]
    if known or not paths:
        return max(known, default=None), None
    longest = max(path[-1] - path[0] for path, _ in paths)
    return None, (
        f"a path of {LEAST_BEFORE:g} cells before a row of nodes and {LEAST_BEHIND:g} behind it "
        f"(it is {longest:.2g} cells in all)"
    )


def _ahead(path, work):
    """Path and work of the rows of a history where a body goes further, not where it stands or goes back."""
    isAhead = path > np.maximum.accumulate(np.r_[-np.inf, np.fmax(path, -np.inf)[:-1]])
    return path[isAhead], work[isAhead]


def _meanJump(path, work):
    """Mean size of the jumps of the load, d work / d path, at whole numbers of the path, over the mean load;
    None without.

    Means over an eighth of a cell on either side of a row are compared, less what the load changes over that
    distance in the second half of the cell before. A jump that is not the grid's, as at a layer, is one among
    many.
    """

    def load(row, start, end):
        ends = np.minimum(row + np.array([start, end]), path[-1])
        return np.diff(np.interp(ends, path, work))[0] / np.diff(ends)[0], ends.mean()

    jumps, loads = [], []
    for row in np.arange(np.ceil(path[0] + LEAST_BEFORE), np.floor(path[-1] - LEAST_BEHIND) + 1):
        (early, at), (before, middle), (behind, end) = (load(row, *window) for window in WINDOWS)
        jumps.append(behind - before - (before - early) / (middle - at) * (end - middle))
        loads.append(before)
    return float(np.mean(np.abs(jumps)) / np.mean(np.abs(loads))) if np.any(loads) else None


def _limits(given):
    for name, value in given.items():
        if name not in LIMITS:
            raise ValueError(f"quasiStatic: there is no limit '{name}'; limits: {', '.join(LIMITS)}")
        POSITIVE.require("quasiStatic", f"limits['{name}']", value)
    return {**LIMITS, **given}


def _percent(ratio):
    return f"{100 * ratio:.2g} %" if ratio < 1 else f"{100 * ratio:.0f} %"
