# SPDX-License-Identifier: GPL-2.0-or-later
"""Frames of an axisymmetric scene as the body in space that they stand for, for ParaView."""

import io
import os
import uuid
from types import SimpleNamespace

import h5py
import numpy as np

from ..base.wording import shown
from ..geometry.numbers import isCount, isNumber
from ..io.files import checkWritable, writeWhole
from ..io.frame import COMPONENTS, HEXAHEDRON, memberName
from ..io.vtkhdf import appendFrame, createLayout

PAIRS = [("xyz".index(i), "xyz".index(j)) for i, j in COMPONENTS[6]]


def write(results, file, angle, pieces):
    """See `Results.revolve`."""
    if not (isNumber(angle) and 0 < angle <= 2 * np.pi):
        raise ValueError(f"revolve: angle = {shown(angle)} is not allowed; give radians, above 0 to 2 pi")
    if not isCount(pieces):
        raise ValueError(f"revolve: pieces = {shown(pieces)} is not allowed; give a whole number, 1 or more")
    file = os.fspath(file)
    if os.path.abspath(file) == os.path.abspath(results.file):
        raise ValueError(f"revolve: '{file}' is the file that is read; give another name")
    checkWritable(file, "revolve")
    image = io.BytesIO()
    with h5py.File(image, "w") as h5:
        createLayout(h5, uuid.uuid4().hex)
        root = h5["VTKHDF"]
        root["CellData"].attrs["bodies"] = results.bodies
        for frame in results:
            if not frame.isAxisymmetric:
                raise ValueError(
                    f"revolve: the scene of '{results.file}' is not axisymmetric; ParaView shows the file as "
                    "it is"
                )
            appendFrame(root, _revolved(frame, angle, int(pieces)), frame.time, frame.step, False, 0)
    writeWhole(file, image.getbuffer())


def _revolved(frame, angle, pieces):
    """A frame as of a Recorder, each domain as so many hexahedra round the axis."""
    at = np.linspace(0, angle, pieces + 1)
    r, z = frame.corners[:, None, :, 0], frame.corners[:, None, :, 1]
    cos, sin = np.cos(at)[:, None], np.sin(at)[:, None]
    points = np.stack([r * cos, z + 0 * cos, r * sin], axis=-1).reshape(-1, 3)
    first = np.arange(frame.count * (pieces + 1)).reshape(-1, pieces + 1)
    ends = np.stack([first[:, :-1], first[:, 1:]], axis=-1)[..., None] * 4 + np.arange(4)
    count = frame.count * pieces
    offsets, types = 8 * np.arange(count + 1), np.full(count, HEXAHEDRON, np.uint8)
    middle = 0.5 * (at[1:] + at[:-1])
    data = {name: _turned(values, middle) for name, values in frame.items()}
    for number, body in enumerate(frame.bodies):
        data[memberName(body)] = (data["body"] == number).astype(np.uint8)
    topology = ends.ravel(), offsets, types, len(points)
    units = {name: frame.units.get(name, "-") for name in data}
    return SimpleNamespace(points=points, topology=topology, data=data, units=units)


def _turned(values, angles):
    """A field of the plane at some angles round the axis, domain by domain."""
    axes = np.zeros((len(angles), 3, 3))  # of r, z and the circumference, one a column
    axes[:, 0, 0] = axes[:, 2, 2] = np.cos(angles)
    axes[:, 2, 0] = np.sin(angles)
    axes[:, 0, 2] = -axes[:, 2, 0]
    axes[:, 1, 1] = 1
    if values.ndim == 1:
        return np.repeat(values, len(angles))
    if values.shape[1:] == (3,):
        return np.einsum("aij,nj->nai", axes, values).reshape(-1, 3)
    if values.shape[1:] == (6,):
        full = np.zeros((len(values), 3, 3))
        for k, (i, j) in enumerate(PAIRS):
            full[:, i, j] = full[:, j, i] = values[:, k]
        turned = _turned(full, angles).reshape(-1, 3, 3)
        return np.stack([turned[:, i, j] for i, j in PAIRS], axis=1)
    return np.einsum("aij,njk,alk->nail", axes, values, axes).reshape(-1, 9)
