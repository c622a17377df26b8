# SPDX-License-Identifier: GPL-2.0-or-later
"""Files are written whole or not at all: what was there before stays until the new one is complete."""

import json
import os
import threading
from contextlib import contextmanager

import numpy as np


@contextmanager
def replacing(file):
    """Name to write a file under, which takes the place of `file` at the end of the `with` block. After an
    error what was written is removed, and an older file of that name is as it was."""
    part = f"{os.fspath(file)}.{os.getpid()}-{threading.get_ident()}.part"
    try:
        yield part
        os.replace(part, file)
    finally:
        if os.path.exists(part):
            os.remove(part)


def saveJson(file, value):
    """Writes numbers, texts, lists and dicts of them as JSON."""
    with replacing(file) as part, open(part, "w", encoding="utf-8") as opened:
        json.dump(value, opened, indent=1)


def saveTable(file, columns):
    """Writes columns, a dict name -> numbers, as CSV."""
    with replacing(file) as part:
        np.savetxt(
            part,
            np.column_stack(list(columns.values())),
            delimiter=",",
            comments="",
            header=",".join(columns),
            fmt="%.8g",
        )


def checkWritable(file, who="checkpoint"):
    """Raises OSError unless a file of that name can be made or replaced; `who` writes it."""
    file = os.fspath(file)
    folder = os.path.dirname(os.path.abspath(file))
    if not os.path.isdir(folder):
        raise FileNotFoundError(
            f"{who} '{file}': there is no folder '{folder}'; make it, or give another file"
        )
    if os.path.isdir(file):
        raise IsADirectoryError(f"{who} '{file}' is a folder; give the name of a file")
    if os.path.exists(file) and not os.path.isfile(file):
        raise OSError(f"{who} '{file}' is no regular file and would be replaced; give the name of a file")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(
            f"{who} '{file}': the folder '{folder}' cannot be written to; give another file"
        )
