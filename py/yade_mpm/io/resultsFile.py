# SPDX-License-Identifier: GPL-2.0-or-later
"""What is read of a Recorder's file, in a child process: HDF5 goes astray in damaged ones."""

import os

import h5py
import numpy as np

from ..base.inChild import LostInChild, inChild
from .checkpoint import READ_MEMORY, READ_SECONDS, READ_SPEED, READING
from .frame import MEMBER, QUADRILATERAL

MOST_EXPANSION = 64  # bytes of memory for one of a file, which may be compressed


def asked(file, work):
    """What a function of the open file returns; ValueError where that cannot be read."""

    def ask():
        with h5py.File(file) as h5:
            return work(h5)

    size = os.path.getsize(file)
    try:
        return inChild(ask, READ_SECONDS + size / READ_SPEED, READ_MEMORY + MOST_EXPANSION * size)
    except (LostInChild, ValueError, IndexError, *READING) as error:
        raise ValueError(
            f"read: '{file}' is damaged: {type(error).__name__}: {error}; give a whole file, or run the "
            "scene again"
        ) from error


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
    part = int(steps["PartOffsets"][k])
    count, points = int(root["NumberOfCells"][part]), int(root["NumberOfPoints"][part])
    where = _rows(root["Points"], steps["PointOffsets"][k], points)
    ids = int(root["NumberOfConnectivityIds"][part])
    corners = _rows(root["Connectivity"], steps["ConnectivityIdOffsets"][k], ids)
    isFlat = count == 0 or root["Types"][int(steps["CellOffsets"][k])] == QUADRILATERAL
    corners = corners.reshape(count, 4 if isFlat else 8)
    used = np.bincount(corners.ravel(), minlength=points)
    data = {name: _rows(cells[name], steps["CellDataOffsets"][name][k], count) for name in _fields(cells)}
    data = {name: v.reshape(-1, 3, 3) if v.shape[1:] == (9,) else v for name, v in data.items()}
    shared = (used[corners] > 1).any(axis=1)
    time, step = float(steps["Values"][k]), int(steps["step"][k])
    return time, step, bodies, where[corners], shared, data, units(cells)


def _rows(array, first, count):
    return array[int(first) : int(first) + count]
