# SPDX-License-Identifier: GPL-2.0-or-later
"""What is read of a Recorder's file, also while a run writes it."""

import os

import h5py
import numpy as np

from ..io.checkpoint import READING, checkPlain
from ..io.frame import MEMBER, QUADRILATERAL
from ..io.pagedFile import committing, journalOf
from ..io.vtkhdf import FILTERS

MOST_DEFLATED = 1032  # times that deflate can make bytes fewer
TRIES = 20  # of a file that another process writes to all the time


def asked(file, work):
    """What a function of the open file returns; ValueError where that cannot be read.

    A run of this process does not change the file meanwhile. Where one of another process does, the work is
    done once more.
    """
    for _ in range(TRIES):
        before, found, wrong = _stamp(file), None, None
        try:
            with committing, h5py.File(file) as h5:
                checkPlain(h5, FILTERS, MOST_DEFLATED * before[1])
                found = work(h5)
        except (ValueError, IndexError, *READING) as error:
            wrong = error
        if _stamp(file) == before and not os.path.exists(journalOf(file)):
            break
    if wrong is None:
        return found
    advice = "give a whole file, or run the scene again"
    if os.path.exists(journalOf(file)):
        advice = "if the run that wrote it was killed, mpm.Recorder.recover(file) completes it"
    raise ValueError(f"read: '{file}' is damaged: {type(wrong).__name__}: {wrong}; {advice}") from wrong


def _stamp(file):
    """What changes when another process writes to a file."""
    found = os.stat(file)
    return found.st_mtime_ns, found.st_size, found.st_ino


def names(h5):
    """Names of the bodies; None: it is no file of a Recorder."""
    found = h5["VTKHDF/CellData"].attrs.get("bodies") if "VTKHDF/CellData" in h5 else None
    return None if found is None else [str(name) for name in found]


def units(cells):
    """Dict name of a field -> unit."""
    return {name: str(cells[name].attrs.get("unit", "-")) for name in _fields(cells)}


def _fields(cells):
    """Names of the fields, without those that are members of others."""
    return [name for name in cells if not name.startswith(MEMBER)]


def columns(h5, label, of):
    """Columns of the history of a label; None: there is none."""
    group = h5.get(f"history/{label}" if label else "history")
    if group is None:
        return None
    return {name: of(data) for name, data in group.items() if isinstance(data, h5py.Dataset)}


def frame(root, k, bodies):
    """What a `ResultFrame` is made of."""
    steps, cells = root["Steps"], root["CellData"]
    part, firstPoint, firstCell, firstId = (
        _row(steps[f"{name}Offsets"], k) for name in ("Part", "Point", "Cell", "ConnectivityId")
    )
    count, points, ids = (
        _row(root[f"NumberOf{name}"], part) for name in ("Cells", "Points", "ConnectivityIds")
    )
    where, corners = _rows(root["Points"], firstPoint, points), _rows(root["Connectivity"], firstId, ids)
    isFlat = count == 0 or _row(root["Types"], firstCell) == QUADRILATERAL
    corners = corners.reshape(count, 4 if isFlat else 8)
    if ids and not (corners.min() >= 0 and corners.max() < points):
        raise ValueError(f"cells have corners {corners.min()} to {corners.max()} of {points} points")
    used = np.bincount(corners.ravel(), minlength=points)
    data = {
        name: _rows(cells[name], _row(steps["CellDataOffsets"][name], k), count) for name in _fields(cells)
    }
    data = {name: v.reshape(-1, 3, 3) if v.shape[1:] == (9,) else v for name, v in data.items()}
    shared = (used[corners] > 1).any(axis=1)
    time, step = float(steps["Values"][k]), int(steps["step"][k])
    isRound = bool(root.attrs.get("axisymmetric", False))
    return time, step, bodies, where[corners], shared, data, units(cells), isRound


def _row(array, k):
    return int(_rows(array, k, 1)[0])


def _rows(array, first, count):
    """Rows of an array; ValueError where it has not that many."""
    if not 0 <= first <= first + count <= len(array):
        raise ValueError(f"{array.name} has {len(array)} rows, and not {count} from {first} on")
    return array[first : first + count]
