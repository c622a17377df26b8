# SPDX-License-Identifier: GPL-2.0-or-later
"""Water in the pores of soil."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..base.kinds import BODY, NUMBER, NUMBERS, takes
from ..base.wording import shown
from ..geometry.numbers import isNumber
from ..geometry.region import Region
from .engine import generated
from .prescribed import FACES
from .supports import timeRows

UNITS = {"heads": "level, m, or a dict time -> level", "inflows": "flow, m/s"}
OF_BODIES = ("permeability", "porosity")  # which particles take from it when they are made
WAITING = ("waits", "waitsAt", "waited")  # where its tables stand, of the one in the scene


class PoreWater(generated["PoreWater"]):
    __doc__ = (
        generated["PoreWater"].__doc__
        + """

        water = mpm.PoreWater(table=8.0, permeability=1e-7, porosity=0.4)
        clay = scene.add("clay", mpm.box((0, 0), (20, 8)), law, water=water)
        scene.groundStress(K0=0.6)

Soil below the table is full of water and stays so; its density includes the water. Where the table is above
the ground, that is under water, with its pressure on the ground. Water leaves through the surface of the
soil; faces of the grid, bodies without water and what is driven are closed.

table : m, level; or rows (x, level), linear between them; or a dict time (s) -> one of these; default: 0 kPa
    everywhere, and no buoyancy.
rise : dict time (s) -> height, m, that the table rises by, as a boundary of the soil that is full of water.
heads : dict face -> level, m, of the water behind a face of the grid ("left", "right", "bottom" ...), or a
    dict time (s) -> level.
drained : face, or list of faces, with water up to the table behind them; without a table at 0 kPa.
inflows : dict face -> flow through it into the soil, m/s; negative: out of it.
wells : list of (region, what it takes in all, m3/s; 2D: m2/s; negative: what it gives).
drains : list of regions, at the pressure 0, or of (region, head in m): water leaves where its head is higher.
sealed : True: no water passes the surface of the soil.
kozenyCarman : True: the permeability follows the volume, as n^3/(1 - n)^2, n the porosity.

What is given by time is linear between the times, and rows (time, value) do as well as a dict. The time is
that of the scene, less what `scene.settle` took (`waited`, s): tables wait meanwhile.

A soil with another permeability or porosity has another `PoreWater`, equal in the rest; later
`body.permeability` and `body.porosity` count. Results:
`body.porePressure`, kPa, compression positive; `excess(body)` over the hydrostatic one, kPa; `head(body)`, m;
`body.flowVelocity`, m/s, Darcy's flow over area; `outflow` and `inflow`, m3/s, through all boundaries;
`iterations`. A history has the last three as columns, such as water.outflow. Pictures and files have the
fields porePressure, excessPressure, head and flowVelocity. A surface without water
in front of it takes in what the soil sucks, as if it rained."""
    )

    _isGiven = False  # to a body
    _tables = ("table", "rise", "heads", "drained", "inflows", "wells", "drains")

    def __init__(
        self,
        table: float | ArrayLike | dict[float, ArrayLike] | None = None,
        rise: dict[float, float] | ArrayLike | None = None,
        heads: dict[str, float | dict[float, float] | ArrayLike] | Sequence[float] | None = None,
        drained: str | Sequence[str] | Sequence[float] | None = None,
        inflows: dict[str, float] | Sequence[float] | None = None,
        wells: Sequence | None = None,
        drains: Sequence | None = None,
        **attributes,
    ) -> None:
        for name, rows in (("table", table), ("rise", rise)):
            if rows is not None:  # before the levels of a checkpoint, which belong to the table
                attributes = {name: rows, **attributes}
        named = {}
        for name, given in (("heads", heads), ("inflows", inflows), ("drained", drained)):
            if isinstance(given, (list, tuple)) and all(isNumber(one) for one in given):  # from a checkpoint
                attributes[name] = list(given)
            elif given is not None:
                named[name] = _byFace(name, given)
        regions = {}
        for name, rows in (("wells", wells), ("drains", drains)):
            if not (rows is None or isinstance(rows, (list, tuple))):
                raise TypeError(f"PoreWater: {name} = {shown(rows)}; give a list")
            if rows is None or all(isNumber(row) for row in rows):  # from a checkpoint
                attributes[name] = list(rows or ())
            else:
                regions[name] = [_checkedRegion(name, row) for row in rows]
        _refuseTwice(named)
        super().__init__(**attributes)
        self.__dict__.update(_named=named, _regions=regions)

    def _assign(self, name, value):
        """Tables as numbers, rows, or rows one behind the other, as checkpoints have them."""
        if name == "table":
            value, levels = _stages(value) if isinstance(value, dict) else (value, [])
            super()._assign("levels", levels)
        if name in ("table", "rise") and not (isinstance(value, (list, tuple)) and len(value) == 0):
            rows = [(0.0, value)] if isNumber(value) else _timed(value)
            rows = np.reshape(rows, (-1, 2)) if np.ndim(rows) == 1 and len(rows) % 2 == 0 else rows
            value = timeRows("PoreWater", name, rows, 1, None).ravel().tolist()
        scene = self._owner and self._owner()
        isRows = isinstance(value, (list, tuple)) and all(isNumber(one) for one in value)
        if name in ("heads", "inflows", "drained") and scene and not (isRows and len(value)):
            named = {**self._named, name: {} if isRows else _byFace(name, value)}
            _refuseTwice(named)
            value = _faceRows(scene, name, named[name])
            self.__dict__["_named"] = named
        if name in OF_BODIES and (self._isGiven or scene):
            raise ValueError(
                f"PoreWater: {name} = {shown(value)} comes too late, the particles of soil have theirs; set "
                f"body.{name}, or give a new body another PoreWater"
            )
        if name in ("wells", "drains") and scene and not all(isNumber(row) for row in np.ravel(value)):
            rows = value if isinstance(value, (list, tuple)) else [value]
            value = _cellRows(scene, name, [_checkedRegion(name, row) for row in rows])
        super()._assign(name, value)

    def _enter(self, scene):
        """What is known of the faces only with a scene."""
        for name, values in self._named.items():
            self._core.set(name, _faceRows(scene, name, values))
        for name, rows in self._regions.items():
            self._core.set(name, _cellRows(scene, name, rows))

    def _sameAs(self, other):
        """What two of them disagree on, or nothing."""
        mine, its = (one.attributes() for one in (self, other))
        ignored = (*OF_BODIES, *WAITING, "iterations", "outflow", "inflow", "debt", "changes", "label")
        return [name for name in mine if name not in ignored and mine[name] != its.get(name)]

    def _overTime(self):
        """Names of what is given over time, and is not the same at all times."""
        rows = (np.reshape(self.levels, (-1, 1 + len(self.table) // 2)), np.reshape(self.rise, (-1, 2)))
        faces = np.reshape(self.heads, (-1, 3))
        rows += tuple(faces[faces[:, 0] == k, 1:] for k in np.unique(faces[:, 0]))
        names = "table", "rise", *["heads"] * (len(rows) - 2)
        return [name for name, one in zip(names, rows) if len(one) and np.ptp(one[:, 1:], axis=0).any()]

    def _wait(self, time):
        """Its tables stay as they are at a time of the scene."""
        self._core.set("waitsAt", time - self.waited)
        self._core.set("waits", True)

    def _goOn(self, time):
        """From a time of the scene on they go on from where they are."""
        if self.waits:
            self._core.set("waited", time - self.waitsAt)
            self._core.set("waits", False)

    @takes(body=BODY)
    def hydrostatic(self, body):
        """Pressure at rest below the table at the particles of a body, kPa (N,)."""
        depth = self.level(body.position, body.scene.time) - body.position[:, -1]
        return self._unitWeight(body.scene) * np.maximum(depth, 0)

    @takes(body=BODY)
    def excess(self, body):
        """Pore pressure over the hydrostatic one at the particles of a body, kPa (N,); 0 where dry."""
        return np.where(body.saturation > 0, body.porePressure - self.hydrostatic(body), 0.0)

    @takes(body=BODY)
    def head(self, body):
        """Height of the level in a standpipe at the particles of a body, m (N,); nan where dry, or without
        gravity."""
        weight = self._unitWeight(body.scene) or np.nan
        return np.where(body.saturation > 0, body.position[:, -1] + body.porePressure / weight, np.nan)

    def _unitWeight(self, scene):
        return self.density * abs((scene._gridSolver("water").gravity or (0.0,))[-1])

    @takes(positions=NUMBERS, time=NUMBER)
    def level(self, positions, time=0.0):
        """Level of the table over places (N, dim) at a time of the scene, m: -inf where there is none."""
        time = self.waitsAt if self.waits else time - self.waited
        rows = np.reshape(self.table, (-1, 2))
        if not len(rows):
            return np.full(len(positions), -np.inf)
        if len(self.levels):
            levels = np.reshape(self.levels, (-1, 1 + len(rows))).T
            rows[:, 1] = [np.interp(time, levels[0], level) for level in levels[1:]]
        rise = np.reshape(self.rise, (-1, 2))
        return np.interp(positions[:, 0], *rows.T) + (np.interp(time, *rise.T) if len(rise) else 0.0)


def waterOf(scene):
    """The PoreWater of a scene, or None."""
    return next((engine for engine in scene.engines if isinstance(engine, PoreWater)), None)


def _byFace(name, given):
    """Dict face -> rows of what is given for faces."""
    if name == "drained":
        if not isinstance(given, (str, list, tuple)):
            raise TypeError(f"PoreWater: drained = {shown(given)}; give a face, or a list of faces")
        return dict.fromkeys([given] if isinstance(given, str) else given, [()])
    unit = UNITS[name]
    if not isinstance(given, dict):
        raise TypeError(f"PoreWater: {name} = {shown(given)}; give a dict face -> {unit}")
    return _checked(name, given, unit)


def _refuseTwice(named):
    given = [(face, name) for name, values in named.items() for face in values]
    for face, name in given:
        others = [other for its, other in given if its == face and other != name]
        if others:
            raise ValueError(f"PoreWater: '{face}' is in {name} and in {others[0]}; give it one of them")


def _faceRows(scene, name, values):
    """Rows of numbers, each with the number of its face first, one behind the other."""
    faces = list(FACES[scene.dim])  # in the order of their numbers
    if unknown := [face for face in values if face not in faces]:
        raise ValueError(
            f"PoreWater: {name} has {shown(unknown[0])}, which is no face; give {', '.join(faces)}"
        )
    rows = [(k, *row) for k, face in enumerate(faces) if face in values for row in values[face]]
    return np.array(rows, float).ravel().tolist()


def _checkedRegion(name, row):
    """(region, number) of a well, or of a drain, that may have no head."""
    region, value = (row, None) if isinstance(row, Region) else row if np.size(row) == 2 else (None, None)
    if not isinstance(region, Region) or not (isNumber(value) or (value is None and name == "drains")):
        wanted = "(region, flow in m3/s)" if name == "wells" else "region, or (region, head in m)"
        raise TypeError(f"PoreWater: {name} has {shown(row)}; give a list of {wanted}")
    return region, value


def _cellRows(scene, name, regions):
    """Rows of numbers, one for each cell of a well or of a drain, one behind the other."""
    numbers = []
    for k, (region, value) in enumerate(regions):
        cells, middles = _cellsInside(scene, name, region)
        heads = middles[:, -1] if value is None else np.full(len(cells), value)
        rows = (np.full(len(cells), k), cells, heads) if name == "wells" else (cells, heads)
        numbers += np.stack(rows, axis=1).ravel().tolist()
    return [float(number) for number in numbers]


def _cellsInside(scene, name, region):
    """Numbers and middles of the cells that have their middle in a region."""
    nodes = scene.nodePositions()
    middles = nodes + 0.5 * scene.cellSizeAt(nodes)
    isIn = region.contains(middles) & ((middles > scene.lower) & (middles < scene.upper)).all(axis=1)
    if not isIn.any():
        raise ValueError(
            f"PoreWater: {name}: {shown(region)} has the middle of no cell; give a larger region"
        )
    return np.flatnonzero(isIn), middles[isIn]


def _checked(name, given, unit):
    """A dict face -> rows: of one number, or of the time and a number."""
    checked = {}
    for face, value in given.items():
        if name == "heads" and (isinstance(value, dict) or np.ndim(value) == 2):
            checked[face] = timeRows("PoreWater", f"heads of '{face}'", _timed(value), 1, None).tolist()
            continue
        if not isNumber(value):
            wanted = unit.replace("level, m", "level in m").replace("flow, m/s", "flow in m/s")
            raise TypeError(f"PoreWater: {name} has {shown(value)} for '{face}'; give a {wanted}")
        checked[face] = [(0.0, value) if name == "heads" else (value,)]
    return checked


def _timed(given):
    """Rows (time, value) of a dict time -> value; what is no dict stays."""
    return list(given.items()) if isinstance(given, dict) else given


def _stages(given):
    """Rows (x, level) at the first of some times, and rows (time, level at each x) one behind the other."""
    if not given:
        raise ValueError("PoreWater: table is an empty dict; give time -> level in m, or rows (x, level)")
    tables = [
        timeRows("PoreWater", "table", [(0.0, one)] if isNumber(one) else one, 1, None)
        for one in given.values()
    ]
    x = np.unique(np.concatenate([table[:, 0] for table in tables]))
    levels = np.array([np.interp(x, *table.T) for table in tables])
    rows = timeRows("PoreWater", "table", np.column_stack((list(given), levels)), len(x), None)
    return np.column_stack((x, levels[0])), rows.ravel().tolist()
