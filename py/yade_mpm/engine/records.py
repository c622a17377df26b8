# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of the solver: dicts of columns by name; a table without rows is an empty tuple."""

import numpy as np


def column(table, name, width=None, type=float):
    """Column of a table as an array, (N,) or (N, width)."""
    rows = table[name] if table else []
    return np.array(rows, type).reshape(-1 if width is None else (len(rows), width))


def withRows(table, rows):
    """The table with some rows more: dicts with the names of its columns."""
    known = table or dict.fromkeys(rows[0], [])
    return {name: [*entries, *(row[name] for row in rows)] for name, entries in known.items()}


def tableOf(rows):
    """Table of rows, at least one: dicts with the same names."""
    return withRows((), rows)
