# SPDX-License-Identifier: GPL-2.0-or-later
"""Time histories: reactions, energies and diagnostics as columns in memory, in CSV, and in the recorder's file."""

import math
import os
import time
from collections.abc import MutableMapping

import numpy as np

from ..check import diagnostics
from ..engine.engines import Callback, Contact, Hold
from .files import checkWritable, replacing
from .recorder import Recorder, checkPeriod, extend

FLUSH = 5.0  # s of wall time at most between writes

_standard = {  # name -> (unit in 3D, function of the scene)
    "time": ("s", lambda scene: scene.time),
    "step": ("-", lambda scene: scene.steps),
    "dt": ("s", lambda scene: scene.dt),
    "dtCritical": ("s", lambda scene: math.nan if scene.dtCritical is None else scene.dtCritical),
    "particles": ("-", lambda scene: scene.particleCount),
    "mass": ("Mg", diagnostics.mass),
    "kineticEnergy": ("kJ", diagnostics.kineticEnergy),
    "internalWork": ("kJ", diagnostics.internalWork),
    "externalWork": ("kJ", diagnostics.externalWork),
    "dampedEnergy": ("kJ", diagnostics.dampedEnergy),
    "contactEnergy": ("kJ", diagnostics.contactEnergy),
    "workDone": ("kJ", diagnostics.workDone),
    "unbalancedRatio": ("-", diagnostics.unbalancedRatio),
    "minJacobian": ("-", diagnostics.minJacobian),
    "hourglassAmplitude": ("-", diagnostics.hourglassAmplitude),
    "distortedCount": ("-", diagnostics.distortedCount),
    "invertedCount": ("-", diagnostics.invertedCount),
    "convertedCount": ("-", diagnostics.convertedCount),
}
_extensive = ("kN", "kN m", "kJ", "Mg", "Mg m/s")  # per metre of thickness in 2D


class History(Callback):
    """Samples reactions, energies and diagnostics every period; `history["time"]` is a NumPy array.

    Parameters
    ----------
    period : scene time between rows, s; or iterPeriod : steps between rows. One of the two is needed.
    file : name of a CSV file with one column each and the units in the header; default: none. Besides, the columns go
        to /history (/history/`label` if the engine has a label) of the file of the first Recorder of the scene.
    columns : dict name -> function of the scene that returns a number, or such an expression as text in which `scene`
        and `diagnostics` are known, e.g. {"toe": "scene['pile'].position[:, 1].min()"}; or tuple of names -> function that returns a number
        for each. A checkpoint can keep only text; give functions again after loading (`history.columns["toe"] = ...`), the
        column is nan until then.
    average : reactions, moments and forces of contact are means over all steps since the row before instead of values of the last step.
        Default True: explicit dynamics makes the value of one step noisy.
    state : rows of the run that is to be continued; given by checkpoints. The files are made to hold just these.

    Columns: time, step, dt, dtCritical, particles; for every prescribed motion NAME (drives, holds, faces): NAME.fx,
    NAME.fy (, NAME.fz) and NAME.work, unless it bears the name of its face also the moment NAME.mz (3D: mx, my, mz);
    with a `Contact` among the engines contact.A-B.fx, contact.A-B.fy (, .fz), the force on group B by group A for each pair of
    groups, contact.frictionWork and, of the last step, contact.largestPenetration (see `Contact`);
    mass, momentum.x ..., kineticEnergy, internalWork, externalWork, dampedEnergy, contactEnergy, energyError, workDone,
    kineticRatio, unbalancedRatio, minJacobian, hourglassAmplitude, distortedCount, invertedCount, convertedCount (see
    `yade_mpm.diagnostics`). A value that does not exist is nan.

    energyError = externalWork - dampedEnergy - contactEnergy - internalWork - (kineticEnergy - kinetic energy at the start).

    Rows are written at the end of a run and every 5 s of wall time. Raises ValueError for arguments that are not
    allowed, TypeError for a column that is no function, OSError for a file that cannot be written; all before the first
    step.
    """

    def __init__(
        self, period=0.0, iterPeriod=0, file=None, columns=None, average=True, state=None, **attributes
    ):
        checkPeriod("History", period, iterPeriod)
        super().__init__(iterPeriod, period, **attributes)
        self._average = bool(average)
        self._file = None if file is None else os.fspath(file)
        self._columns = Columns(columns or {})
        self._data, self._units, self._count = {}, {}, 0
        self._before = {}  # name -> time of the last row, time integrals until then
        self._motions = {}  # name -> prescribed motion that bears it
        self._initialEnergy = None
        self._header, self._inFile = None, 0  # of the CSV file as it is
        self._recorder, self._inRecorder = None, 0
        self._flushed = time.monotonic()
        if state is not None:
            self._restore(state)

    file = property(lambda self: self._file, doc="Name of the CSV file, or None.")
    columns = property(lambda self: self._columns, doc="Dict of the columns that the user added.")
    average = property(lambda self: self._average, doc="Whether reactions are means over the period.")
    names = property(lambda self: list(self._data), doc="Names of the columns.")
    units = property(lambda self: dict(self._units), doc="Dict name -> unit.")

    def __repr__(self):
        known = {k: v for k, v in self.spec().items() if k != "state" and v not in (None, "", 0, False, {})}
        return f"History({', '.join(f'{k}={v!r}' for k, v in known.items())})"

    def __len__(self):
        return self._count

    def __bool__(self):
        return True  # also without rows

    def __getitem__(self, name):
        """Column as an array (rows,)."""
        if not self._data:
            raise KeyError(
                "History: it has no rows yet; give it to scene.engines, and run the scene for a period or longer"
            )
        if name not in self._data:
            raise KeyError(f"there is no column '{name}'; columns: {', '.join(self._data)}")
        return np.array(self._data[name])

    def spec(self):
        """Dict of constructor arguments, of plain types, with which a checkpoint makes the history anew, rows included."""
        columns = {
            name: c if isinstance(c, str) else None
            for key, c in self._columns.items()
            for name in _names(key)
        }
        return dict(
            period=self.virtPeriod,
            iterPeriod=self.iterPeriod,
            file=self._file,
            columns=columns,
            average=self._average,
            state=self._state(),
            label=self.label,
            dead=self.dead,
        )

    def _state(self):
        """Rows so far and what the next one starts from, as plain types."""
        return dict(
            data=self._data, units=self._units, before=self._before, initialEnergy=self._initialEnergy
        )

    def _restore(self, state):
        self._data = {name: list(column) for name, column in state["data"].items()}
        self._count = max((len(column) for column in self._data.values()), default=0)
        self._units, self._before, self._initialEnergy = (
            dict(state["units"]),
            dict(state["before"]),
            state["initialEnergy"],
        )

    # --- engine ---
    def bind(self, scene):
        super().bind(scene)
        others = [e for e in scene.engines if isinstance(e, History) and e is not self]
        if any(e.label == self.label or (self._file and e.file == self._file) for e in others):
            raise ValueError("History: two histories have the same label or file; give each its own")
        if self._initialEnergy is None:
            self._initialEnergy = diagnostics.kineticEnergy(scene)
        for c in scene.constraints:
            if self._motions.setdefault(c.name, c) is not c:  # another one of that name
                self._before.pop(c.name, None)
                self._motions[c.name] = c
        for name, integrals in _integrals(scene).items():
            self._before.setdefault(name, [scene.time, *integrals])
        if self._file is not None:
            checkWritable(self._file, "History")

    def act(self, scene):
        self._row(scene)
        if time.monotonic() - self._flushed > FLUSH:
            self.flush()

    def stepsToCall(self, scene):
        """No call ever stops the run: it need not look after each."""
        return 1 << 30

    def flush(self):
        """Writes the rows that are not in the files yet."""
        self._flushed = time.monotonic()
        if self._count:
            self._writeCSV()
            self._writeRecorder()

    # --- rows ---
    def _row(self, scene):
        row, means = {}, self._means(scene)
        for name, (unit, function) in _standard.items():
            row[name] = (unit, function(scene))
            if name == "particles":
                row.update(self._reactions(scene, means))
                row.update(self._contacts(scene, means))
            elif name == "mass":
                row.update(
                    (f"momentum.{axis}", ("Mg m/s", p)) for axis, p in zip("xyz", diagnostics.momentum(scene))
                )
            elif name == "contactEnergy":
                row["energyError"] = (
                    "kJ",
                    diagnostics.energyError(scene, self._initialEnergy, kinetic=row["kineticEnergy"][1]),
                )
            elif name == "workDone":
                row["kineticRatio"] = ("-", diagnostics.kineticRatio(scene, row["kineticEnergy"][1]))
        for key in self._columns:
            row.update((name, ("", value)) for name, value in self._columns.measure(key, scene))
        self._append(
            {
                name: (_perMetre(unit) if scene.dim == 2 else unit, value)
                for name, (unit, value) in row.items()
            }
        )
        self._before = {name: [scene.time, *integrals] for name, integrals in _integrals(scene).items()}

    def _means(self, scene):
        """Dict of what is averaged -> mean since the last row; nothing for what has seen no step since."""
        if not self._average:
            return {}
        return {
            name: [(now - before) / (scene.time - since) for now, before in zip(integrals, start)]
            for name, integrals in _integrals(scene).items()
            for since, *start in [self._before[name]]
            if scene.time > since
        }

    def _reactions(self, scene, means):
        """Reaction, moment and work of every prescribed motion."""
        row, dim = {}, scene.dim
        for c in scene.constraints:
            six = means.get(c.name, [*c.core.reaction, *c.core.moment])
            row.update((f"{c.name}.f{axis}", ("kN", f)) for axis, f in zip("xyz"[:dim], six))
            if not (isinstance(c, Hold) and isinstance(c.where, str) and c.name == c.where):  # a face
                row.update(
                    (f"{c.name}.m{'xyz'[k]}", ("kN m", six[3 + k])) for k in ((2,) if dim == 2 else (0, 1, 2))
                )
            row[f"{c.name}.work"] = ("kJ", c.work)
        return row

    def _contacts(self, scene, means):
        """Force between each pair of groups; work of friction and overlap of all."""
        contact = _contactOf(scene)
        if contact is None:
            return {}
        row = {}
        for pair, force in contact.forces().items():
            name = _nameOf(pair)
            row.update(
                (f"{name}.f{axis}", ("kN", f)) for axis, f in zip("xyz"[: scene.dim], means.get(name, force))
            )
        return {
            **row,
            "contact.frictionWork": ("kJ", contact.frictionWork),
            "contact.largestPenetration": ("m", contact.largestPenetration),
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

    # --- files ---
    def _writeCSV(self):
        if self._file is None:
            return
        header = ",".join(f"{name} [{unit}]" if unit else name for name, unit in self._units.items())
        if header == self._header:
            with open(self._file, "a", encoding="utf-8") as f:
                f.write(self._lines(self._inFile))
        else:
            with replacing(self._file) as part, open(part, "w", encoding="utf-8") as f:
                f.write(header + "\n" + self._lines(0))
        self._header, self._inFile = header, self._count

    def _lines(self, first):
        rows = zip(*(column[first:] for column in self._data.values()))
        return "".join(",".join(map(str, row)) + "\n" for row in rows)

    def _writeRecorder(self):
        recorder = next(
            (e for e in self._scene.engines if isinstance(e, Recorder) and e._path is not None), None
        )
        if recorder is None:
            return
        if recorder is not self._recorder:
            self._recorder, self._inRecorder = recorder, 0
        with recorder.appending() as h5:
            group = h5.require_group(f"history/{self.label}" if self.label else "history")
            for name, column in self._data.items():
                known = self._inRecorder if name in group else 0
                extend(group, name, np.array(column[known:]), known, unit=self._units[name])
        self._inRecorder = self._count


class Columns(dict):
    """Columns that the user adds: name, or tuple of names -> function of the scene, expression as text, or None (nan)."""

    def __init__(self, columns):
        super().__init__()
        self._code = {}
        for name, column in dict(columns).items():
            self[name] = column

    update = MutableMapping.update  # one by one, too

    def __setitem__(self, name, column):
        isText = isinstance(column, str) and not isinstance(
            name, tuple
        )  # a checkpoint keeps each text by its name
        if not (column is None or callable(column) or isText):
            orText = "" if isinstance(name, tuple) else ", or an expression as text"
            raise TypeError(f"History: column '{name}' = {column!r}; give a function of the scene{orText}")
        if any(mark in str(one) for one in _names(name) for mark in ',"\n'):
            raise ValueError(f"History: the name of column {name!r} may hold no comma, quote or line end")
        if isText:
            self._code[name] = compile(column, f"<column {name}>", "eval")
        super().__setitem__(name, column)

    def measure(self, name, scene):
        """(name, value) of a column now, or of each of several; ValueError, which ends the run, where one is no number or raises something."""
        column = self[name]
        if column is None:
            return [(one, math.nan) for one in _names(name)]
        try:
            known = {"scene": scene, "diagnostics": diagnostics, "np": np}
            found = eval(self._code[name], known) if isinstance(column, str) else column(scene)
            return [
                (one, float(value))
                for one, value in zip(
                    _names(name), found if isinstance(name, tuple) else [found], strict=True
                )
            ]
        except Exception as error:
            raise ValueError(
                f"History: column '{name}' ({column if isinstance(column, str) else 'a function'}) gives no number: {type(error).__name__}: "
                f"{error}"
            ) from error


def _names(key):
    """Names of the columns that the user gave as one name or a tuple."""
    return key if isinstance(key, tuple) else (key,)


def _contactOf(scene):
    """The Contact among the engines of a scene, or None."""
    return next((e for e in scene.engines if isinstance(e, Contact) and not e.dead), None)


def _nameOf(pair):
    return "contact.{}-{}".format(*pair)


def _integrals(scene):
    """Dict name -> time integrals of what a history averages: reaction and moment of each prescribed motion, force between each pair of groups."""
    all = {c.name: [*c.core.impulse, *c.core.angularImpulse] for c in scene.constraints}
    contact = _contactOf(scene)
    if contact is not None:
        all.update((_nameOf(pair), impulse.tolist()) for pair, impulse in contact.forceImpulses().items())
    return all


def _perMetre(unit):
    return unit + "/m" if unit in _extensive else unit
