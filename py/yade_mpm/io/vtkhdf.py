# SPDX-License-Identifier: GPL-2.0-or-later
"""The layout of a VTKHDF file: growing arrays, frames that are appended and cut off."""

import h5py
import numpy as np

from .frame import COMPONENTS

FILTERS = (h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE)  # that arrays may have passed
CHUNK = 16384  # rows at most in a piece of a growing array


def createLayout(h5, run, isAxisymmetric=False):
    h5.attrs["run"] = run
    root = h5.create_group("VTKHDF", track_order=True)
    if isAxisymmetric:
        root.attrs["axisymmetric"] = True
    root.attrs["Version"] = (2, 0)
    root.attrs.create("Type", b"UnstructuredGrid", dtype="S16")
    root.create_group("CellData", track_order=True)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = 0
    steps.create_group("CellDataOffsets")


def appendFrame(root, frame, time, step, isSame, compress):
    steps, cells = root["Steps"], root["CellData"]  # to open a group takes a tenth of a millisecond
    k = int(steps.attrs["NSteps"])
    if not isSame:
        topology = _appendTopology(root, frame, compress)
    else:
        topology = {
            name: steps[name][k - 1] for name in ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets")
        }
    first = extend(root, "Points", frame.points, compress=compress)
    firstCell = len(cells["body"]) if k else 0
    for name, values in frame.data.items():
        known = {"unit": frame.units[name]}
        if values.shape[1:]:
            known["components"] = COMPONENTS[values.shape[1]]
        extend(cells, name, values, firstCell, compress, known)
    for name in set(cells) - set(frame.data):  # of a body that is gone
        cells[name].resize(firstCell + len(frame.data["body"]), axis=0)
    perStep = {"Values": time, "step": step, "NumberOfParts": 1, "PointOffsets": first, **topology}
    for name, value in perStep.items():
        extend(steps, name, [value], k, attributes={"unit": "s" if name == "Values" else "-"})
    _noteOffset(steps["CellDataOffsets"], frame.data, firstCell, k)
    steps.attrs["NSteps"] = k + 1


def _appendTopology(root, frame, compress):
    connectivity, offsets, types, points = frame.topology
    part = extend(root, "NumberOfPoints", [points])
    extend(root, "NumberOfCells", [len(types)])
    extend(root, "NumberOfConnectivityIds", [len(connectivity)])
    extend(root, "Offsets", offsets, compress=compress)
    return {
        "PartOffsets": part,
        "CellOffsets": extend(root, "Types", types, compress=compress),
        "ConnectivityIdOffsets": extend(root, "Connectivity", connectivity, compress=compress),
    }


def _noteOffset(offsets, names, first, k):
    """All cell data start at the same row: one array of offsets under many names."""
    shared = next(iter(offsets.values()), None)
    for name in names:
        if name not in offsets:
            if shared is None:
                extend(offsets, name, [first], k)
                shared = offsets[name]
            else:
                offsets[name] = shared
    if len(shared) == k:
        extend(offsets, next(iter(offsets)), [first], k)


def extend(group, name, values, at=None, compress=0, attributes=None):
    """Writes rows into a growing array of a group from row `at` on (default: its end) and returns `at`.

    Rows that were never written are nan (integers: zero). A new array gets the attributes.
    """
    values = np.ascontiguousarray(values)
    key = name.encode()
    if key not in group.id:
        rows = min(max(len(values), 64), CHUNK)
        filled = np.nan if values.dtype.kind == "f" else 0
        filters = dict(compression="gzip", compression_opts=compress, shuffle=True) if compress else {}
        array = group.create_dataset(
            name,
            (0, *values.shape[1:]),
            values.dtype,
            maxshape=(None, *values.shape[1:]),
            chunks=(rows, *values.shape[1:]),
            fillvalue=filled,
            **filters,
        )
        array.attrs.update(attributes or {})
    # What follows is array.resize and array[at:] = values of h5py, which take five times as long.
    array = h5py.h5d.open(group.id, key)
    at = array.shape[0] if at is None else at
    array.set_extent((at + len(values), *array.shape[1:]))
    if len(values):
        place = array.get_space()
        place.select_hyperslab((at, *(0 for _ in values.shape[1:])), values.shape)
        array.write(h5py.h5s.create_simple(values.shape), place, values)
    return at


def cutAfter(root, step):
    """Removes the frames after a step; returns how many are left, and the topology of the last of them."""
    steps = root["Steps"]
    kept = int(np.searchsorted(steps["step"][()], step, side="right"))
    parts = steps["PartOffsets"][:kept]
    last = int(parts[-1]) if kept else -1
    cells, points = root["NumberOfCells"][()], root["NumberOfPoints"][()]
    ids = root["NumberOfConnectivityIds"][()]
    _shrink(root, "Points", points[parts].sum())
    for name in root["CellData"]:
        _shrink(root["CellData"], name, cells[parts].sum())
    _shrink(root, "Types", cells[: last + 1].sum())
    _shrink(root, "Offsets", cells[: last + 1].sum() + last + 1)
    _shrink(root, "Connectivity", ids[: last + 1].sum())
    for name in ("NumberOfCells", "NumberOfPoints", "NumberOfConnectivityIds"):
        _shrink(root, name, last + 1)
    for name in (
        "Values",
        "step",
        "NumberOfParts",
        "PartOffsets",
        "PointOffsets",
        "CellOffsets",
        "ConnectivityIdOffsets",
    ):
        _shrink(steps, name, kept)
    for name in steps["CellDataOffsets"]:
        _shrink(steps["CellDataOffsets"], name, kept)
    steps.attrs["NSteps"] = kept
    if not kept:
        return 0, None
    return kept, (
        _tail(root, "Connectivity", ids[last]),
        _tail(root, "Offsets", cells[last] + 1),
        _tail(root, "Types", cells[last]),
        points[last],
    )


def _tail(group, name, rows):
    return group[name][len(group[name]) - rows :]


def _shrink(group, name, rows):
    group[name].resize(min(int(rows), len(group[name])), axis=0)
