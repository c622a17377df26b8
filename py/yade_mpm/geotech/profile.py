# SPDX-License-Identifier: GPL-2.0-or-later
"""Values over the depth of the ground, from the table of a sounding."""

import csv
import re

import numpy as np

from ..base.kinds import FILE, FINITE, TEXT, requireFile, takes
from ..base.wording import didYouMean, shown

DOWN, UP = ("depth", "z"), ("height", "elevation", "level")
UNITS = {"kPa": 1.0, "MPa": 1e3, "Pa": 1e-3, "bar": 100.0, "m": 1.0, "cm": 0.01, "mm": 1e-3}  # in kPa, m


@takes(file=FILE, column=TEXT)
def readProfile(file, column, top=None):
    """Reads a column of a sounding, such as a CPT, as a profile: what laws, K0 and OCR take.

        qt = mpm.geotech.readProfile("cpt.csv", "qt", top=8.0)
        su = np.column_stack((qt[:, 0], (qt[:, 1] - 18 * (8.0 - qt[:, 0])) / 15))
        clay = mpm.Tresca(density=1.8, young=2e4, poisson=0.49, undrainedStrength=su)

    with a file of one row for each depth, in any order:

        depth (m), qt (MPa), fs (kPa)
        0.02, 0.31, 4.0
        0.04, 0.35, 4.2

    Parameters
    ----------
    file : path of a CSV file with a heading; cells are separated by commas, semicolons or tabs.
    column : name of the column, without its unit. MPa, Pa and bar are converted to kPa, cm and mm to m.
    top : m, height of the ground; required where the file has depths (`depth` or `z`) and no heights
        (`height`, `elevation` or `level`).

    Rows without a number in the column are left out. Returns an array (N, 2), height (m) and value, upwards.
    Raises ValueError, with the row, for what is not allowed.
    """
    with open(requireFile("readProfile", file), newline="", encoding="utf-8-sig") as opened:
        text = opened.read()
    first = text.partition("\n")[0]
    between = next((sign for sign in ("\t", ";") if sign in first), ",")
    rows = [row for row in csv.reader(text.splitlines(), delimiter=between, skipinitialspace=True) if row]
    heads = [_head(cell) for cell in rows[0]] if rows else []
    names = {name.lower(): k for k, (name, _) in enumerate(heads)}
    where = next((name for name in (*UP, *DOWN) if name in names), None)
    if where is None:
        raise ValueError(f"readProfile: {shown(str(file))} has no column 'depth' or 'height'; give one")
    if column.lower() not in names:
        raise ValueError(
            f"readProfile: {shown(str(file))} has no column {shown(column)}{didYouMean(column, names)}"
        )
    if where in DOWN:
        if top is None:
            raise ValueError(
                f"readProfile: {shown(str(file))} has depths; give top, the height of the ground, m"
            )
        FINITE.check("readProfile", "m", top=top)
    numbers = [names[where], names[column.lower()]]
    found = [_numbers(file, number, row, numbers) for number, row in enumerate(rows[1:], 2)]
    factors = [UNITS.get(heads[k][1], 1.0) for k in numbers]
    found = np.array([pair for pair in found if pair is not None], float).reshape(-1, 2) * factors
    if where in DOWN:
        found[:, 0] = top - found[:, 0]
    found = found[np.argsort(found[:, 0], kind="stable")]
    if len(found) < 2 or (np.diff(found[:, 0]) <= 0).any():
        wrong = "a depth twice" if len(found) > 1 else "fewer than two rows"
        raise ValueError(
            f"readProfile: {shown(str(file))} has {wrong} "
            f"with a number in {shown(column)}; give two depths or more, each once"
        )
    return found


def _head(cell):
    """Name and unit of a column."""
    name, unit = re.fullmatch(r"\s*(.*?)\s*(?:[(\[]([^)\]]*)[)\]])?\s*", cell).groups()
    return name, (unit or "").strip()


def _numbers(file, number, row, columns):
    """Depth and value of a row; None where the value is empty."""
    cells = [row[k].strip() if k < len(row) else "" for k in columns]
    if not all(cells):
        return None
    try:
        pair = [float(cell) for cell in cells]
    except ValueError:
        pair = [np.nan]
    if not np.isfinite(pair).all():
        raise ValueError(f"readProfile: row {number} of {shown(str(file))}: {shown(cells)} are no numbers")
    return pair
