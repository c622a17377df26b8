# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of numbers that the solver goes by without looking again: checked when they come from a file."""

import numpy as np

from ..geometry.meshChecks import checkHanging, checkRange


def checkTables(body, count, stored):
    """Refuses tables of a body whose numbers do not fit it.

    Parameters
    ----------
    body : Body, as yet without particles.
    count : int, number of its particles.
    stored : dict of the dicts "particles", "domains" and "tables" of arrays, as a checkpoint has them.

    Raises ValueError, which names the table.
    """
    tables, domains = stored["tables"], stored["domains"]
    for name, table in tables.items():
        _require(table.ndim == 1, f"{name} has {table.ndim} dimensions")
    points = len(domains["vertexPosition"]) if "vertexPosition" in domains else count
    dim = body.core.fields(False)[1]["shape"][0]
    _checkRows(domains, points, count, dim)
    _checkGroups(tables.get("blockStart"), tables.get("blockOrder"), points)
    if "corners" in tables:
        _require(tables["corners"].size == 2**dim * count, f"corners has {tables['corners'].size} numbers")
        checkRange("corners", tables["corners"], 0, points)
        checkHanging(points, tables["slaves"], tables["masters"], domains.get("masterWeight"))
    if "runsWhenSorted" in tables:
        _require(tables["runsWhenSorted"].shape == (1,), "runsWhenSorted is not one number")
        checkRange("runsWhenSorted", tables["runsWhenSorted"], 0, max(1, points) + 1)
    _checkNumbers(count, stored)


def _checkRows(domains, points, count, dim):
    """Fields with a row for each vertex, domain, facet of the outline or axis have just as many."""
    facets = len(domains.get("outlineCarrier", ()))
    for name, field in domains.items():
        whose = {"hourglassReference": (count, "domains"), "halfSize": (dim, "axes")}.get(name)
        if name.startswith("vertex"):
            whose = points, "vertices"
        elif name.startswith("outline"):
            whose = facets, "facets"
        if whose:
            _require(len(field) == whose[0], f"{name} has {len(field)} rows for {whose[0]} {whose[1]}")


def _checkGroups(start, order, points):
    """Points by blocks of the grid: where each block begins, and the numbers of the points in this order."""
    if start is None:
        return
    if len(start):
        isRising = start[0] == 0 and start[-1] == points and (np.diff(start) >= 0).all()
        _require(isRising, f"blockStart does not rise from 0 to {points}")
    if len(order):
        isWhole = len(order) == points and np.array_equal(np.sort(order), np.arange(points))
        _require(isWhole, f"blockOrder is no order of {points} points")


def _checkNumbers(count, stored):
    """Numbers of particles, in the order of which the outline of cut boxes is found."""
    ids = stored["particles"].get("id")
    _require(ids is not None and ids.dtype.kind == "i" and (ids >= 0).all(), "id has numbers below zero")
    carriers = stored["domains"].get("outlineCarrier")
    if carriers is not None and len(carriers):
        _require(np.array_equal(np.sort(ids), np.arange(count)), f"id is no order of {count} particles")
        checkRange("outlineCarrier", carriers, 0, count)
    half = stored["domains"].get("halfSize")
    _require(half is None or ((half > 0) & np.isfinite(half)).all(), "halfSize is not positive")


def _require(isRight, complaint):
    if not isRight:
        raise ValueError(complaint)
