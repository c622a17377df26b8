# SPDX-License-Identifier: GPL-2.0-or-later
"""Pressures and tractions on the boundary of a body."""

import numpy as np

from ..base.kinds import FLAG
from ..base.warn import warnUser
from ..base.wording import shown
from ..geometry.contained import insideBoxes, insideCells
from ..geometry.mesh import FACETS, boundaryFacets, facetAreas
from ..geometry.numbers import floats
from ..geometry.region import Region
from ..particle.body import Body
from .contact import Contact
from .engine import generated

PROBE = 0.05  # edges of a facet in front of which material of another body is looked for
_TABLES = ("facets", "pressureTable", "tractionTable")


class BoundaryLoad(generated["BoundaryLoad"]):
    __doc__ = (
        generated["BoundaryLoad"].__doc__
        + """
body : the loaded APDI body.
where : region; facets whose centre is inside are loaded (default: all boundary facets).
loadsBonded : load facets that stand on another body, too, which they are bonded to (a body of the same group,
    or of any where there is no `Contact`); default False: a warning says how many were left out when the
    scene is first prepared, and `leftOut` which.

A load that changes with time is a table, which checkpoints keep: for a function f of the time, give
pressureTable=np.column_stack((t, f(t))); `pressure` is then the value of the last step. `ramp` multiplies it.
`facets` is an array (N, 2) of int, particle id and number of the facet; tables are arrays, too."""
    )

    _fixed = ("body", "facets")
    _looksForBonds = False
    loadsBonded = property(lambda self: self._loadsBonded, doc="Whether facets on another body are loaded.")
    leftOut = property(
        lambda self: self._leftOut,
        doc="Facets that stand on another body and are not loaded (N, 2), as `facets`.",
    )

    def __init__(self, body, where=None, loadsBonded=False, **attributes):
        self._usedBy = body if isinstance(body, str) else getattr(body, "name", None)
        self._loadsBonded, self._leftOut, self._columns = loadsBonded, np.zeros((0, 2), int), {}
        if isinstance(body, str):  # from a checkpoint: the facets are given
            super().__init__(body=body, **attributes)
            return
        _checkArguments(body, where, loadsBonded, attributes)
        facets, owners = boundaryFacets(body.mesh)
        if where is not None:
            inside = where.contains(body.mesh.points[facets].mean(axis=1))
            facets, owners = facets[inside], owners[inside]
        if len(facets) == 0:
            raise ValueError(
                f"BoundaryLoad: no boundary facet of '{body.name}' is inside {shown(where)}; widen the region"
            )
        pairs = [(owner, _facetNumber(body.mesh.cells[owner], facet)) for facet, owner in zip(facets, owners)]
        super().__init__(body=body.name, facets=pairs, **attributes)
        self._looksForBonds = not loadsBonded
        body.scene._loadsAndDrives.append(self)

    def bind(self, scene):
        """Called before a run: looks whether the facets are there, and which stand on another body."""
        body = scene[self.body]
        most = np.array((body.id.max(initial=-1), 2 * scene.dim - 1))
        pairs = self.facets
        if ((pairs < 0) | (body.converted == 0) & (pairs > most)).any():
            raise ValueError(
                f"BoundaryLoad: facets name domains that '{self.body}' does not have; make the load from the "
                f"body"
            )
        if self._looksForBonds and not body.converted:
            self._leaveOutBonded(scene, body)

    def _leaveOutBonded(self, scene, body):
        """Takes off the facets in front of which there is another body of the same velocity field."""
        probes = _probes(body.vertices[_vertices(body.cells, self.facets)])
        isBonded, names = np.zeros(len(probes), bool), []
        for other in scene.bodies:
            if other is body or not other.count or not _shareVelocity(scene, body, other):
                continue
            onOther = _isInside(probes, other).mean(axis=1) > 0.5
            isBonded |= onOther
            names += [f"'{other.name}'"] if onOther.any() else []
        self._looksForBonds = False
        if not isBonded.any():
            return
        told = f"facets of '{self.body}' stand on {', '.join(names)}, which it is bonded to"
        if isBonded.all():
            self._looksForBonds = True
            raise ValueError(
                f"BoundaryLoad: all {len(probes)} {told}; give loadsBonded=True to load them, or another "
                f"region"
            )
        warnUser(
            f"BoundaryLoad: {isBonded.sum()} of {len(probes)} {told}, and are not loaded; "
            f"loadsBonded=True loads them"
        )
        self._leftOut = self.facets[isBonded]
        self._assign("facets", self.facets[~isBonded])

    def unitForces(self, body):
        """Centres of the facets, m (N, dim), and the forces on them, kN, under a pressure of 1 kPa and under
        tractions of 1 kPa along each axis (1 + dim, N, dim). For bodies without converted domains."""
        corners = body.vertices[_vertices(body.cells, self.facets)]
        areas = facetAreas(corners)
        along = np.linalg.norm(areas, axis=1)[:, None] * np.eye(body.scene.dim)[:, None]
        return corners.mean(axis=1), np.concatenate((-areas[None], along))

    def valuesAt(self, times, dim):
        """Pressure and tractions at times (s), kPa (len(times), 1 + dim)."""
        values = np.zeros((len(times), 1 + dim))
        values[:, 0] = self.pressure or 0.0
        values[:, 1:] = self.traction if len(self.traction) else 0.0
        for first, table in ((0, self.pressureTable), (1, self.tractionTable)):
            for k, column in enumerate(table[:, 1:].T if len(table) else ()):
                values[:, first + k] = np.interp(times, table[:, 0], column)
        return values * np.minimum(1.0, times / self.ramp)[:, None] if self.ramp else values

    @property
    def times(self):
        """Times between which the load is linear, with a ramp and a table quadratic, s."""
        return [
            0.0,
            self.ramp,
            *(t for table in (self.pressureTable, self.tractionTable) for t in table[:, 0]),
        ]

    # --- facets and tables as arrays ------------------------------------------------------------------
    def _assign(self, name, value):
        if name in _TABLES:
            rows = _rows(name, value)
            self._columns[name] = rows.shape[1]
            value = rows.ravel().tolist()
        super()._assign(name, value)

    def __getattr__(self, name):
        value = super().__getattr__(name)
        return self._asRows(name, value) if name in _TABLES else value

    def _asRows(self, name, value):
        rows = np.reshape(value, (-1, self._columns.get(name, 2)))
        return rows.astype(int) if name == "facets" else rows

    def _refuseFixed(self, name, before):
        if name == "facets" and not np.array_equal(self.facets, before):
            raise ValueError(
                f"BoundaryLoad: facets of '{self._usedBy}' cannot change any more; make another load"
            )
        if name not in _TABLES:
            super()._refuseFixed(name, before)

    def __repr__(self):
        told = {k: v for k, v in self.attributes().items() if v and k not in (*_TABLES, "body")}
        told |= {
            table: f"{len(getattr(self, table))} rows" for table in _TABLES[1:] if len(getattr(self, table))
        }
        options = "".join(f", {name}={value}" for name, value in told.items())
        return f"<BoundaryLoad of {len(self.facets)} facets of '{self.body}'{options}>"

    def attributes(self):
        """Dict of all attributes that have a value; facets and tables as lists of rows."""
        return {
            name: self._asRows(name, value).tolist() if name in _TABLES else value
            for name, value in super().attributes().items()
        }


def _checkArguments(body, where, loadsBonded, attributes):
    if not isinstance(body, Body):
        raise TypeError(f"BoundaryLoad: body = {shown(body)}; give a body, as scene.add returns it")
    if not (where is None or isinstance(where, Region)):
        raise TypeError(f"BoundaryLoad: where = {shown(where)}; give a region, e.g. box((0, 2), (1, 3))")
    FLAG.check("BoundaryLoad", loadsBonded=loadsBonded)
    for name in ("pressure", "traction"):
        if callable(attributes.get(name)):
            raise TypeError(
                f"BoundaryLoad: {name} is a function, which no checkpoint can hold; give a table of it, "
                f"{name}Table=np.column_stack((t, f(t)))"
            )
        if {name, f"{name}Table"} <= set(attributes):
            raise ValueError(f"BoundaryLoad: {name} and {name}Table are given; give one of the two")
    if body.mesh is None or not body.count:
        raise ValueError(f"BoundaryLoad: '{body.name}' {_whyNoFacets(body)}")


def _whyNoFacets(body):
    if not body.type._core.isMeshed:
        return "is no mesh and has no facets; mpm.SurfaceLoad loads the ground of boxes, scene.attach(it)"
    if body.count:
        return "lost its first mesh when domains were converted; make loads before that"
    return "has no domains left, they were converted; make loads before that"


def _rows(name, value):
    """Rows of a table; ValueError for anything else. Facets may come as one list, as in older checkpoints."""
    try:
        rows = floats(value)
    except (TypeError, ValueError):
        rows = np.zeros(())
    if name == "facets" and rows.ndim == 1 and rows.size % 2 == 0:
        rows = rows.reshape(-1, 2)
    isWhole = name != "facets" or not (rows % 1).any()
    if rows.ndim != 2 or not isWhole or (name == "facets" and rows.shape[1] != 2):
        wanted = {
            "facets": "pairs of whole numbers (particle id, number of the facet)",
            "pressureTable": "rows (time, pressure), s and kPa",
            "tractionTable": "rows (time, one component per axis), s and kPa",
        }[name]
        raise ValueError(f"BoundaryLoad: {name} has the shape {rows.shape}; give {wanted}")
    return rows


def _shareVelocity(scene, body, other):
    """Whether two bodies are bonded where they touch."""
    separates = any(isinstance(e, Contact) and not e.dead for e in scene.engines)
    return body.group == other.group or not separates


def _isInside(points, body):
    """Whether points (N, M, dim) are inside domains of a body (N, M)."""
    flat = points.reshape(-1, points.shape[2])
    if body.cells is None:
        return insideBoxes(flat, body.position, body.halfSize).reshape(points.shape[:2])
    return insideCells(flat, body.corners()).reshape(points.shape[:2])


def _vertices(cells, pairs):
    """Vertex numbers of facets, (N, 2 or 4)."""
    table = np.array(FACETS[2 if cells.shape[1] == 4 else 3])
    return np.take_along_axis(cells[pairs[:, 0]], table[pairs[:, 1]], axis=1)


def _probes(corners):
    """Points in front of facets, half way between their centre and their corners (N, 2 or 4, dim)."""
    centre, outward = corners.mean(axis=1, keepdims=True), facetAreas(corners)
    size = np.linalg.norm(outward, axis=1)
    reach = size if corners.shape[1] == 2 else np.sqrt(size)
    outward *= (PROBE * reach / size)[:, None]
    return centre + 0.5 * (corners - centre) + outward[:, None]


def _facetNumber(cell, facet):
    """Which facet of a cell has these vertices."""
    dim = 2 if len(cell) == 4 else 3
    for number, corners in enumerate(FACETS[dim]):
        if set(cell[list(corners)]) == set(facet):
            return number
    raise AssertionError("a boundary facet belongs to its owner")
