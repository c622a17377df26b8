# SPDX-License-Identifier: GPL-2.0-or-later
"""Values over the depth of the ground, from the table of a sounding."""

import numpy as np

from ..base.kinds import FILE, FINITE, TEXT, takes
from ..base.wording import didYouMean, shown
from .tables import nameAndUnit, readRows

DOWN, UP = ("depth", "z"), ("height", "elevation", "level")
LENGTHS = {"": 1.0, "m": 1.0, "cm": 0.01, "mm": 1e-3}  # m
UNITS = {
    "": 1.0,
    "-": 1.0,
    "kpa": 1.0,
    "kn/m2": 1.0,
    "pa": 1e-3,
    "bar": 100.0,
    "atm": 101.325,
    "mpa": 1e3,
    "mn/m2": 1e3,
    "n/mm2": 1e3,
    "gpa": 1e6,
    "deg": np.pi / 180,
    "rad": 1.0,
}  # kPa; radians


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
    column : name of the column, without its unit. Stresses (Pa, kPa, MPa, GPa, kN/m2, MN/m2, N/mm2, bar, atm)
        are converted to kPa, degrees (deg) to radians, depths (cm, mm) to m. Without a unit: kPa, m.
    top : m, height of the ground; required where the file has depths (`depth` or `z`) and no heights
        (`height`, `elevation` or `level`).

    Rows whose cell in the column is empty are left out. Returns an array (N, 2), height (m) and value,
    upwards. Raises ValueError, with the row, for what is not allowed: other units, negative depths, two
    columns of the name, a file that is no text in UTF-8.
    """
    rows = readRows("readProfile", file)
    heads = [nameAndUnit(cell) for cell in rows[0][1]] if rows else []
    lower = [name.lower() for name, _ in heads]
    names = {name: k for k, name in enumerate(lower)}
    where = next((name for name in (*UP, *DOWN) if name in names), None)
    if where is None:
        raise ValueError(f"readProfile: {shown(str(file))} has no column 'depth' or 'height'; give one")
    if column.lower() not in names:
        raise ValueError(
            f"readProfile: {shown(str(file))} has no column {shown(column)}{didYouMean(column, names)}"
        )
    if top is not None:
        FINITE.check("readProfile", "m", top=top)
    elif where in DOWN:
        raise ValueError(f"readProfile: {shown(str(file))} has depths; give top, the height of the ground, m")
    numbers = [names[where], names[column.lower()]]
    for k in numbers:
        if lower.count(lower[k]) > 1:
            raise ValueError(
                f"readProfile: {shown(str(file))} has two columns {shown(heads[k][0])}; give one"
            )
    factors = [_factor(file, heads[k], units) for k, units in zip(numbers, (LENGTHS, UNITS))]
    found = [_numbers(file, number, row, numbers, where in DOWN) for number, row in rows[1:]]
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


def _factor(file, head, units):
    """By which a column is multiplied for kPa, m or radians."""
    name, unit = head
    known = (unit or "").lower().replace("²", "2")
    if known not in units:
        allowed = ", ".join(filter(None, units))
        raise ValueError(
            f"readProfile: column {shown(name)} of {shown(str(file))} has the unit {shown(unit)}, which is "
            f"not known; give one of {allowed}, in small or capital letters"
        )
    return units[known]


def _numbers(file, number, row, columns, isDepth):
    """Depth or height, and value of a row; None where the value is empty."""
    cells = [row[k].strip() if k < len(row) else "" for k in columns]
    if not cells[1]:
        return None
    try:
        pair = [float(cell) for cell in cells]
    except ValueError:
        pair = [np.nan]
    if not np.isfinite(pair).all():
        raise ValueError(f"readProfile: row {number} of {shown(str(file))}: {shown(cells)} are no numbers")
    if isDepth and pair[0] < 0:
        raise ValueError(
            f"readProfile: row {number} of {shown(str(file))} has the depth {pair[0]:g}; depths count "
            "downwards, so give positive ones, or name the column 'height'"
        )
    return pair
