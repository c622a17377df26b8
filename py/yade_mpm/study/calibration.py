# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters of a scene fitted to a measured curve, through the runner of studies: each evaluation is a case,
and one that is finished is not run again."""

import os
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import differential_evolution, least_squares

from ..app.record import CURVE
from ..base.kinds import DICT, FILE, NUMBERS, TEXT, TEXTS, Kind, takes
from ..base.wording import shortened, shown
from ..io.files import saveJson
from . import execution, pictures, report, state
from .study import Study

METHODS = ("least_squares", "differential_evolution")
STEP = 0.02  # of the range: below it, the scatter of an explicit run would be taken for a slope
DIGITS = 8  # of a parameter, so that equal points are the same case
ENDS = 0.01  # of the range of the computed curve that a measured one may go beyond it
TOLERANCE = 1e-3  # of the fit: parameters in parts of their range, cost in parts of itself

MEASURED = Kind("(n, 2) numbers, or the name of a CSV file", lambda v: FILE.isOne(v) or NUMBERS.isOne(v))
RANGES = Kind(
    "{name: (low, high), ...}",
    lambda v: DICT.isOne(v) and all(NUMBERS.isOne(ends) and len(ends) == 2 for ends in v.values()),
)


@dataclass
class Calibration:
    """What a fit has found.

    values, errors : dict name -> value, and its standard error from the slopes at the end (None: there is no
    slope). correlation : (n, n) of the parameters, or None. rms : root mean square of the residuals in the
    unit of the curve; scale : the same of the measured curve. runs : cases that were needed. message : why
    the search ended. x, measured, fitted : curves at the measured points.
    """

    values: dict
    errors: dict
    correlation: list
    rms: float
    scale: float
    runs: int
    message: str
    x: np.ndarray = field(repr=False)
    measured: np.ndarray = field(repr=False)
    fitted: np.ndarray = field(repr=False)
    names: tuple = ("x", "y")

    def asDict(self):
        """Plain numbers, for JSON."""
        return {n: v.tolist() if isinstance(v, np.ndarray) else v for n, v in vars(self).items()}


@takes(scene=FILE, ranges=RANGES, measured=MEASURED, curve=TEXT, out=FILE, start=DICT, words=TEXTS)
def calibrate(
    scene,
    ranges,
    measured,
    curve,
    out,
    method="least_squares",
    start=None,
    words=(),
    threads=1,
    jobs=None,
    timeout=None,
    scheduler=None,
    generations=10,
    seed=0,
    quiet=False,
):
    """Fits parameters of a scene to a measured curve; returns a `Calibration` and leaves calibration.json and
    calibration.html in the folder `out`.

    Parameters
    ----------
    scene : file or name of a scene that leaves curve_NAME.csv (`study.saveCurve`).
    ranges : dict name -> (low, high), what is sought and where.
    measured : (n, 2) numbers x and y, or the name of a CSV file of two columns with one line of names.
    curve : NAME of the curve; its y at the measured x is compared.
    method : "least_squares" (SciPy; from `start`, slopes by differences, all of them at once) or
        "differential_evolution" (global, `generations` of 8 cases per parameter).
    start : dict name -> value, default the middle of the ranges. words : options of all runs.
    seed : of the evolution. threads, jobs, timeout, scheduler, quiet : as of `Study.run`.

    Raises ValueError for what does not fit together, RuntimeError where a case of a least squares fit fails.
    """
    points, names = _measured(measured)
    search = _Search(scene, ranges, points, curve, out, words, threads)
    if method not in METHODS:
        raise ValueError(
            f"calibrate: method = {shown(method)} is not allowed; give one of {', '.join(METHODS)}"
        )
    count = len(ranges) + 1 if method == METHODS[0] else 8 * len(ranges)
    jobs, _ = execution.jobsAndThreads(count, jobs, threads)
    with execution.workers(scheduler, jobs) as pool:
        search.how = dict(pool=pool, jobs=jobs, timeout=timeout, quiet=quiet)
        if method == METHODS[0]:
            found = _leastSquares(search, start)
        else:
            found = _evolution(search, generations, seed)
        result = search.result(found.x, found.message, names)
    saveJson(os.path.join(search.out, "calibration.json"), result.asDict())
    with pictures.plainText():
        _writeReport(search, result)
    return result


def _measured(measured):
    """Points, in the order of x, and names of the axes."""
    names = ("x", "y")
    if isinstance(measured, (str, os.PathLike)):
        try:
            with open(measured, encoding="utf-8-sig") as text:
                names = tuple(text.readline().strip().split(","))
                measured = np.loadtxt(text, delimiter=",", ndmin=2)
        except ValueError as error:  # UnicodeDecodeError, too
            raise ValueError(
                f"calibrate: the measured curve '{measured}' is no CSV of two columns: "
                f"{shortened(str(error), 300)}; give a line of names, then x and y"
            ) from None
    points = np.asarray(measured, float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
        raise ValueError(
            f"calibrate: a measured curve of shape {points.shape} is not allowed; give (n, 2) finite numbers"
        )
    return _rising(points, "the measured curve"), names


def _rising(points, what):
    """Points of a curve, whose x rises; one that falls is turned round. ValueError for one that turns back:
    it has two y for one x."""
    steps = np.diff(points[:, 0])
    if (steps >= 0).all():
        return points
    if (steps <= 0).all():
        return points[::-1]
    back = points[np.flatnonzero(steps * steps[steps != 0][0] < 0)[0], 0]
    raise ValueError(
        f"calibrate: {what} turns back at x = {back:g}, and has two values of y beside it; give a part in "
        "which x rises or falls"
    )


class _Search:
    """Cases of a search, in units of the ranges: 0 is the lower end, 1 the upper one."""

    def __init__(self, scene, ranges, points, curve, out, words, threads):
        self.scene, self.ranges, self.curve, self.out = scene, dict(ranges), curve, os.path.abspath(out)
        self.x, self.measured = points.T
        self.words, self.threads, self.folders = list(words), threads, {}
        if not self.ranges or not all(low < high for low, high in self.ranges.values()):
            raise ValueError("calibrate: ranges are not allowed; give {name: (low, high), ...}")

    def case(self, unit):
        """Parameters at a point."""
        ends = zip(self.ranges.items(), unit)
        return {name: float(f"{low + u * (high - low):.{DIGITS}g}") for (name, (low, high)), u in ends}

    def curves(self, units):
        """The curve at each of the points; nan where the case failed."""
        listed = {repr(self.case(u)): self.case(u) for u in units}
        study = Study(self.scene, list(listed.values()), self.out, words=self.words, threads=self.threads)
        study.run(**self.how)
        self.folders.update(zip(listed, study.folders))
        return [self._read(self.folders[repr(self.case(u))]) for u in units]

    def _read(self, folder):
        file = os.path.join(folder, CURVE.format(self.curve))
        if state.read(folder)["state"] != state.DONE:
            return np.full_like(self.measured, np.nan)
        if not os.path.exists(file):
            raise ValueError(
                f"calibrate: the scene has left no curve '{self.curve}' in {folder}; let it call saveCurve"
            )
        points = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
            raise ValueError(
                f"calibrate: the curve in {file} is not (n, 2) finite numbers; correct the scene"
            )
        x, y = _rising(points, f"the curve in {file}").T
        room = ENDS * np.ptp(x)  # where the end of the curve stands for what is just beyond
        if x.min() > self.x[0] + room or x.max() < self.x[-1] - room:
            raise ValueError(
                f"calibrate: the curve of {folder} goes from {x.min():g} to {x.max():g}, the measured one "
                f"from {self.x[0]:g} to {self.x[-1]:g}; run the scene farther, or give fewer points"
            )
        return np.interp(self.x, x, y)

    def residuals(self, units):
        """Curve less the measured one at each of the points; RuntimeError where a case failed."""
        found = self.curves(units)
        for u, curve in zip(units, found):
            if np.isnan(curve).any():
                at = state.read(self.folders[repr(self.case(u))])
                raise RuntimeError(f"calibrate: the case {self.case(u)} {at['state']}: {at['message']}")
        return [curve - self.measured for curve in found]

    def slopes(self, unit):
        """Residuals at a point, and their slopes (n, parameters) by differences towards the inside."""
        steps = [STEP if u + STEP <= 1 else -STEP for u in unit]
        moved = [np.where(np.arange(len(unit)) == k, unit + h, unit) for k, h in enumerate(steps)]
        here, *there = self.residuals([unit, *moved])
        return here, np.stack([(other - here) / h for other, h in zip(there, steps)], axis=1)

    def result(self, unit, message, names):
        """The fit, with errors and correlation from the slopes at its end."""
        here, J = self.slopes(unit)
        widths = np.array([high - low for low, high in self.ranges.values()])
        freedom = max(1, len(here) - len(unit))
        errors, correlation = dict.fromkeys(self.ranges), None
        if np.linalg.matrix_rank(J, 1e-6 * np.linalg.norm(J)) == len(unit):
            covariance = np.linalg.inv(J.T @ J) * (here @ here) / freedom
            deviation = np.sqrt(np.diag(covariance))
            errors = {name: float(v) for name, v in zip(self.ranges, deviation * widths)}
            inverse = np.linalg.inv(J.T @ J)
            correlation = (inverse / np.sqrt(np.outer(np.diag(inverse), np.diag(inverse)))).tolist()
        rms, scale = (float(np.sqrt(np.mean(v**2))) for v in (here, self.measured))
        curves = self.x, self.measured, self.measured + here
        about = (rms, scale, len(self.folders), message)
        return Calibration(self.case(unit), errors, correlation, *about, *curves, names)


def _leastSquares(search, start):
    """From a start, with all slopes of a step at once."""
    known = {}

    def both(unit):
        if unit.tobytes() not in known:
            known[unit.tobytes()] = search.slopes(unit)
        return known[unit.tobytes()]

    begin = np.full(len(search.ranges), 0.5)
    for k, (name, (low, high)) in enumerate(search.ranges.items()):
        if start and name in start:
            begin[k] = (start[name] - low) / (high - low)
    if not ((begin >= 0) & (begin <= 1)).all():
        raise ValueError(f"calibrate: start = {start} is not allowed; give values inside of the ranges")
    scale = np.abs(search.measured).max() or 1.0
    return least_squares(
        lambda u: both(u)[0] / scale,
        begin,
        jac=lambda u: both(u)[1] / scale,
        bounds=(0, 1),
        method="dogbox",  # fewer steps than the default where ends are not reached
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=1e-12,
    )


def _evolution(search, generations, seed):
    """Over all of the ranges; a case that fails is one that does not fit."""

    def costs(units):
        found = search.curves(list(units.T))
        sums = [np.sum((curve - search.measured) ** 2) for curve in found]
        return np.where(np.isfinite(sums), sums, np.finfo(float).max)

    return differential_evolution(
        costs,
        [(0, 1)] * len(search.ranges),
        vectorized=True,
        updating="deferred",
        polish=False,
        popsize=8,
        maxiter=generations,
        tol=TOLERANCE,
        seed=seed,
        init="sobol",
    )


REPORT = """{% extends "page" %}{% block body %}
<p>{{ r.runs }} runs; residuals {{ "%.3g" % r.rms }} (rms), of a curve of {{ "%.3g" % r.scale }} (rms).
{{ r.message }}</p>
<div class="wide"><table>
<tr><th>parameter</th><th>value</th><th>standard error</th><th>range</th></tr>
{% for name, value in r.values.items() %}<tr><td class="t">{{ name }}</td><td>{{ "%.5g" % value }}</td>
<td>{% if r.errors[name] is not none %}{{ "%.2g" % r.errors[name] }}{% endif %}</td>
<td>{{ "%g to %g" % ranges[name] }}</td></tr>
{% endfor %}</table></div>
<h2>Correlation of the parameters</h2>
{% if r.correlation %}<div class="wide"><table>
<tr><th></th>{% for name in r.values %}<th>{{ name }}</th>{% endfor %}</tr>
{% for name in r.values %}<tr><td class="t">{{ name }}</td>
{%- for c in r.correlation[loop.index0] %}<td>{{ "%.2f" % c }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% else %}<p>The curve does not tell these parameters apart: there are no errors to give.</p>{% endif %}
<h2>Curves</h2>{{ curves | safe }}<h2>Residuals</h2>{{ residuals | safe }}
{% endblock %}"""


def _writeReport(search, result):
    """calibration.html: the values, their correlation, both curves and the residuals."""
    both = {"measured": result.measured, "fitted": result.fitted}
    own = {name: (result.names, np.stack([result.x, y], axis=1)) for name, y in both.items()}
    residuals = np.stack([result.x, result.fitted - result.measured], axis=1)
    of = {"residual": ((result.names[0], "fitted - measured"), residuals)}
    report.writePage(
        os.path.join(search.out, "calibration.html"),
        REPORT,
        title=f"Calibration of {search.curve}",
        r=result,
        ranges={name: tuple(ends) for name, ends in search.ranges.items()},
        curves=pictures.curves(own),
        residuals=pictures.curves(of),
    )
