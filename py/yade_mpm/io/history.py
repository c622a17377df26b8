# SPDX-License-Identifier: GPL-2.0-or-later
"""Time histories: reactions, energies and diagnostics as columns in memory, in CSV, and in the recorder's
file."""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Iterator, Mapping

import numpy as np

from ..base.html import card, paragraph, table
from ..base.keywords import checked
from ..base.kinds import DICT, FILE, WHOLE, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..engine.callback import Callback, checkPeriod
from ..engine.engine import NO_CALL
from . import owners, quantities
from .columns import RATE, Columns, namesOf
from .files import checkWritable
from .rowFiles import RowFiles

FLUSH = 5.0  # s of wall time at most between writes


class History(Callback):
    """Samples reactions, energies and diagnostics every period; `history["time"]` is a NumPy array.

    Parameters
    ----------
    period : scene time between rows, s; or
    iterPeriod : steps between rows. One of the two is needed.
    file : name of a CSV file with one column each and the units in the header; default: none. Besides, the
        columns go to /history (/history/`label` if the engine has a label) of the file of the first
        Recorder of the scene.
    columns : dict name -> function of the scene that returns a number, or such an expression as text in
        which `scene` and `diagnostics` are known, e.g. {"toe": "scene['pile'].position[:, 1].min()"}; or
        tuple of names -> function that returns a number for each. Text is no Python: it names fields and
        `diagnostics` and calculates with numbers (+ - * / **, abs, min, max), so that a checkpoint can bring
        it without harm; "d/dt " before it makes the mean rate since the row before. Of a field it takes
        min(), max(), mean(), sum() or np.quantile(FIELD, 0.9); a function serves for more. A checkpoint can
        keep only text; give functions again after loading (`history.columns["toe"] = ...`), the column is nan
        until then.
    label : name of the engine; default "".
    dead : leave the engine out; default False.

    Reactions, moments and forces of contact are means over all steps since the row before: explicit dynamics
    makes the value of one step noisy.

    Columns: time, step, dt, dtCritical, particles; for every prescribed motion NAME (drives, holds, faces):
    NAME.fx, NAME.fy (, NAME.fz) and NAME.work, unless its name is that of its face also the moment NAME.mz
    (3D: mx, my, mz), of a `Drive` also NAME.rowsCrossed; with a `Contact` among the engines contact.A-B.fx,
    contact.A-B.fy (, .fz), the force on group B by group A for each pair of groups, contact.frictionWork and,
    of the last step, contact.largestPenetration (see `Contact`); mass, momentum.x ..., kineticEnergy,
    unseenEnergy, internalWork, externalWork, dampedEnergy, contactEnergy, energyError, workDone,
    kineticRatio, unbalancedRatio, minJacobian, hourglassAmplitude, hourglassEnergy, distortedCount,
    invertedCount, convertedCount (see `yade_mpm.diagnostics`); with implicit bodies also implicitEnergy, with
    drives freeKineticEnergy. A value that does not exist is nan.

    energyError = externalWork - dampedEnergy - contactEnergy (- implicitEnergy) - internalWork -
    (kineticEnergy - kinetic energy at the start).

    Rows are written at the end of a run and every 5 s of wall time. Raises ValueError for arguments that
    are not allowed, TypeError for a column that is no function, OSError for a file that cannot be written;
    all before the first step.
    """

    @checked("History", research=("average",))
    @takes(file=FILE, columns=DICT)
    def __init__(
        self,
        period: float = 0.0,
        iterPeriod: int = 0,
        file: str | os.PathLike | None = None,
        columns: Mapping | None = None,
        average: bool = True,
        label: str = "",
        dead: bool = False,
    ) -> None:
        checkPeriod("History", period, iterPeriod)
        super().__init__(iterPeriod, period, label, dead)
        self._average = bool(average)
        self._file = None if file is None else os.fspath(file)
        self._columns = Columns(columns or {})
        self._data, self._units, self._count = {}, {}, 0
        self._before = {}  # name -> time of the last row, time integrals until then
        self._motions = {}  # name -> prescribed motion of that name
        self._files = RowFiles(self._file)
        self._flushed = time.monotonic()
        self._isTold = False  # that rows have no room

    file = property(lambda self: self._file, doc="Name of the CSV file, or None.")
    columns = property(lambda self: self._columns, doc="Dict of the columns that the user added.")
    average = property(lambda self: self._average, doc="Whether reactions are means over the period.")
    names = property(lambda self: list(self._data), doc="Names of the columns.")
    units = property(lambda self: dict(self._units), doc="Dict name -> unit.")

    def __repr__(self):
        known = {k: v for k, v in self.spec().items() if v not in (None, "", 0, False, {})}
        return f"History({', '.join(f'{k}={v!r}' for k, v in known.items())})"

    def __len__(self) -> int:
        return self._count

    def __bool__(self):
        return True  # also without rows

    def __getitem__(self, name: str) -> np.ndarray:
        """Column as an array (rows,)."""
        if not self._data:
            raise KeyError(
                "History: it has no rows yet; give it to scene.engines, and run the scene for a period or "
                "longer"
            )
        if name not in self._data:
            moved = {f"{m.name}." for m in self._motions.values() if not m._core.isWall}
            first = [one for one in self._data if one.startswith(tuple(moved))]
            rest = [one for one in self._data if one not in first]
            raise KeyError(
                f"History: there is no column {shown(name)}; columns: {', '.join([*first, *rest])}"
            )
        return np.array(self._data[name])

    def keys(self) -> list[str]:
        """Names of the columns, so that `dict(history)` has them all."""
        return list(self._data)

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys())

    def __contains__(self, name):
        return name in self._data

    def toPandas(self):
        """The rows as a pandas DataFrame, indexed by time (s); `units` has the units of its columns.

        Raises ImportError without pandas.
        """
        import pandas

        return pandas.DataFrame({name: self[name] for name in self.keys()}).set_index("time")

    def _repr_html_(self):
        """Card for a notebook: every column with its unit, its last value and its range."""
        rows = [
            (name, self._units[name], f"{column[-1]:.6g}", f"{np.min(column):.4g} to {np.max(column):.4g}")
            for name, column in self._data.items()
        ]
        shown = table(("column", "unit", "last", "from, to"), rows) if rows else paragraph("no rows yet")
        return card(f"History of {len(self)} rows", shown)

    @takes(first=WHOLE)
    def rowsFrom(self, first):
        """Rows from a number on, each a dict name -> value.

        Parameters
        ----------
        first : int, number of the first row.
        """
        names = list(self._data)
        return [
            dict(zip(names, values)) for values in zip(*(column[first:] for column in self._data.values()))
        ]

    def spec(self):
        """Dict of constructor arguments, of plain types, with which a checkpoint makes the history."""
        columns = {
            name: c if isinstance(c, str) else None
            for key, c in self._columns.items()
            for name in namesOf(key)
        }
        return dict(
            period=self.period,
            iterPeriod=self.iterPeriod,
            file=self._file,
            columns=columns,
            average=self._average,
            label=self.label,
            dead=self.dead,
        )

    def state(self):
        """See `Callback`: rows so far, and what the next one starts from."""
        return dict(data=self._data, units=self._units, before=self._before)

    def restoreState(self, state):
        """See `Callback`; the files are made to hold just these rows."""
        if not {"data", "units", "before"} <= set(state):
            raise ValueError("History: the state of a checkpoint is not complete; use what `state` has given")
        self._data = {str(name): [_asNumber(v) for v in column] for name, column in state["data"].items()}
        self._count = max((len(column) for column in self._data.values()), default=0)
        if any(len(column) < self._count or "\n" in name for name, column in self._data.items()):
            raise ValueError("History: the rows of a checkpoint are not complete")
        self._units = dict(state["units"])
        self._before = {str(name): [_asNumber(v) for v in row] for name, row in state["before"].items()}

    # --- engine ---
    def bind(self, scene):
        super().bind(scene)
        others = [e for e in scene.engines if isinstance(e, History) and e is not self]
        if any(e.label == self.label or (self._file and e.file == self._file) for e in others):
            raise ValueError("History: two histories have the same label or file; give each its own")
        for c in scene.constraints:
            if self._motions.setdefault(c.name, c) is not c:  # another one of that name
                self._before.pop(c.name, None)
                self._motions[c.name] = c
        for name, integrals in quantities.timeIntegrals(scene).items():
            if len(self._before.setdefault(name, [scene.time, *integrals])) != 1 + len(integrals):
                raise ValueError(f"History: the integrals of '{name}' in a checkpoint are not complete")
        if self._file is not None:
            checkWritable(self._file, "History")
            owners.take(self._file, self)
            owners.lock(self._file, self)
            if not self._files.isOpen:
                self._files.checkIsOwn(
                    next(zip(self._data["time"], self._data["step"]), None) if self._count else None
                )
            if not self._count and os.path.exists(self._file):
                warnUser(
                    f"History: the first row replaces '{self._file}' of an earlier run; rename it to keep it"
                )

    def act(self, scene):
        self._row(scene)
        if time.monotonic() - self._flushed > FLUSH:
            self._flushOrTell(scene)

    def _flushOrTell(self, scene):
        """Writes the rows; those for which there is no room stay in memory, and a warning says so once."""
        try:
            self.flush()
            self._isTold = False
        except OSError as error:
            if not self._isTold:
                told = f"warning: step {scene.steps}: History: {error}; rows are kept until there is room"
                print(f"{told}, the run goes on", file=sys.stderr)
            self._isTold = True

    def stepsToCall(self, scene):
        """No call ever stops the run: it need not look after each."""
        return NO_CALL

    def flush(self) -> None:
        """Writes the rows that are not in the files yet."""
        self._flushed = time.monotonic()
        if self._file is not None:
            owners.check(self._file, self)
            owners.lock(self._file, self)
        if self._count:
            self._files.write(self._data, self._units, self.label, self._scene.engines)
            if self._file is not None:
                owners.lock(self._file, self)  # it may have taken the place of another one

    # --- rows ---
    def _row(self, scene):
        integrals = quantities.timeIntegrals(scene)
        row = quantities.measured(scene, self._means(scene, integrals))
        for key in self._columns:
            row.update((name, ("", value)) for name, value in self._columns.measure(key, scene))
        now = {RATE + name: [row[name][1]] for name in self._columns.rates()}
        for name, (value,) in now.items():
            since, before = self._before.get(name, [scene.time, value])
            rate = (value - before) / (scene.time - since) if scene.time > since else math.nan
            row[name.removeprefix(RATE)] = ("", rate)
        if scene._perMetre:
            row = {name: (quantities.perMetre(unit), value) for name, (unit, value) in row.items()}
        self._append(row)
        self._before = {name: [scene.time, *values] for name, values in (integrals | now).items()}

    def _means(self, scene, integrals):
        """Dict of what is averaged -> mean since the last row; nothing for what has seen no step since."""
        if not self._average:
            return {}
        return {
            name: [(now - before) / (scene.time - since) for now, before in zip(sums, start)]
            for name, sums in integrals.items()
            for since, *start in [self._before[name]]
            if scene.time > since
        }

    def _append(self, row):
        for name, (unit, value) in row.items():
            if name not in self._data:
                self._data[name], self._units[name] = [math.nan] * self._count, unit
            self._data[name].append(value if isinstance(value, int) else float(value))
        self._count += 1
        for column in self._data.values():  # of motions that are gone
            if len(column) < self._count:
                column.append(math.nan)


def _asNumber(value):
    if not isinstance(value, (int, float)):
        raise TypeError(f"History: {shown(value)} in the rows or integrals of a checkpoint is no number")
    return value
