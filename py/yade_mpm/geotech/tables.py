# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables that engineers keep as CSV files: their rows, and names and units in their headings."""

import csv
import re

from ..base.kinds import requireFile
from ..base.wording import shown


def readRows(who, file):
    """Number and cells of each row of a CSV file, with commas, semicolons or tabs between cells.

    Raises ValueError for a file that is not text in UTF-8.
    """
    path = requireFile(who, file)
    try:
        with open(path, newline="", encoding="utf-8-sig") as opened:
            first = opened.readline()
            opened.seek(0)
            between = next((sign for sign in ("\t", ";") if sign in first), ",")
            rows = csv.reader(opened, delimiter=between, skipinitialspace=True)
            return [(rows.line_num, row) for row in rows if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(
            f"{who}: {shown(str(file))} is not a table of text ({error}); save it as CSV in UTF-8"
        ) from None


def nameAndUnit(heading):
    """Of a column, such as `qt (MPa)`; without a unit the second is None."""
    name, unit = re.fullmatch(r"\s*(.*?)\s*(?:[(\[]([^)\]]*)[)\]])?\s*", heading).groups()
    return name, unit and unit.strip()
