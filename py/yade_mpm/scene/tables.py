# SPDX-License-Identifier: GPL-2.0-or-later
"""Arrays of a body by which the solver finds its way, as a checkpoint holds them: what each must be.

`checkTables` goes by this declaration, and the manual shows it (doc/reference/file-formats.md).
Arrays that are not named here (velocity, stress ...) have a row per particle, and any numbers.
"""

from typing import NamedTuple

import numpy as np

from ..geometry.meshChecks import checkHanging, checkRange

MOST_ID = 1 << 53  # whole numbers up to here are exact as floating-point numbers, too


class Table(NamedTuple):
    """rows : for what there is one row each, a key of what `_counts` gives; least, end : range of the
    numbers, end not included, a number or such a key, None: any; rule : more that holds, see `_RULES`."""

    rows: str
    least: float | None
    end: float | str | None
    text: str
    rule: str = ""


DECLARED = {
    "id": Table("particles", 0, MOST_ID, "Number of the particle", "each once where there are facets"),
    "halfSize": Table("axes", 0, None, "Half edge of the boxes, m", "positive"),
    "splitShare": Table("particles", None, None, "What cuts left of the domain of a particle"),
    "outlineCarrier": Table("facets", 0, "particles", "`id` of the particle that carries a facet"),
    "outlineOffset": Table("facets", None, None, "From the particle to the facet, m"),
    "outlineArea": Table("facets", None, None, "Area vector of the facet, m2"),
    "vertexPosition": Table("vertices", None, None, "Position, m"),
    "vertexReference": Table("vertices", None, None, "Position when the body was made, m"),
    "vertexVelocity": Table("vertices", None, None, "Velocity in the last step, m/s"),
    "hourglassReference": Table("particles", None, None, "Hourglass pattern of the undeformed domain"),
    "masterWeight": Table("hanging vertices", None, None, "Weights of the masters", "sum up to 1"),
    "blockStart": Table("blocks", 0, "points + 1", "First point of each block, and the end", "rises"),
    "blockOrder": Table("ordered points", 0, "points", "Points in the order of the blocks", "each once"),
    "corners": Table("corners", 0, "vertices", "Vertices of the domains"),
    "slaves": Table("hanging vertices", 0, "vertices", "Hanging vertices", "rises"),
    "masters": Table("masters", -1, "vertices", "Four masters of each, -1: none", "are no slaves"),
    "runsWhenSorted": Table("body", 0, "points + 2", "Runs of equal cells at the last sorting"),
}  # fmt: skip


def checkTables(body, count, stored):
    """Refuses tables of a body whose numbers do not fit it.

    Parameters
    ----------
    body : Body, as yet without particles.
    count : int, number of its particles.
    stored : dict of the dicts "particles", "domains" and "tables" of arrays, as a checkpoint has them.

    Raises ValueError, which names the table.
    """
    arrays = {"id": stored["particles"]["id"], **stored["domains"], **stored["tables"]}
    counts = _counts(body, count, stored)
    for name, array in arrays.items():
        if name in DECLARED:
            _check(name, array, DECLARED[name], counts)
    for name, table in stored["tables"].items():
        _require(table.ndim == 1, f"{name} has {table.ndim} dimensions")
    if "blockStart" in arrays:
        start = arrays["blockStart"]
        isRising = start[0] == 0 and start[-1] == counts["points"] and (np.diff(start) >= 0).all()
        _require(isRising, f"blockStart does not rise from 0 to {counts['points']}")
    if len(arrays.get("blockOrder", ())):
        _checkOnce("blockOrder", arrays["blockOrder"], counts["points"])
    if counts["facets"]:
        _checkOnce("id", arrays["id"], count)
    if "corners" in arrays:
        checkHanging(counts["vertices"], arrays["slaves"], arrays["masters"], arrays["masterWeight"])


def _counts(body, count, stored):
    """Dict what there may be rows for -> how many; None: at least one."""
    domains, tables = stored["domains"], stored["tables"]
    dim, isMeshed = body._core.fields(False)[1]["shape"][0], body.type._core.isMeshed
    vertices = len(domains["vertexPosition"]) if isMeshed else 0
    hanging, points = len(tables.get("slaves", ())), vertices if isMeshed else count
    return {
        "particles": count,
        "vertices": vertices,
        "axes": dim,
        "facets": len(domains.get("outlineCarrier", ())),
        "hanging vertices": hanging,
        "masters": 4 * hanging,
        "corners": 2**dim * count,
        "points": points,  # what the blocks group: vertices of meshes, or particles
        "points + 1": points + 1,
        "points + 2": points + 2,
        "ordered points": vertices,  # boxes lie in the order of the blocks
        "blocks": None,
        "body": 1,
    }


def _check(name, array, table, counts):
    """Refuses an array of another kind, with another number of rows, or with numbers out of range."""
    rows = counts[table.rows]
    if rows is None:
        _require(len(array) > 0, f"{name} is empty")
    else:
        _require(len(array) == rows, f"{name} has {len(array)} rows for {rows} {table.rows}")
    if isinstance(table.end, (int, str)):
        _require(array.dtype.kind == "i", f"{name} holds no whole numbers")
        checkRange(name, array, table.least, counts.get(table.end, table.end))
    elif table.least == 0:
        _require(((array > 0) & np.isfinite(array)).all(), f"{name} is not positive")


def _checkOnce(name, numbers, count):
    isWhole = len(numbers) == count and np.array_equal(np.sort(numbers), np.arange(count))
    _require(isWhole, f"{name} has not each number from 0 to {count - 1} once")


def _require(isRight, complaint):
    if not isRight:
        raise ValueError(complaint)
