# SPDX-License-Identifier: GPL-2.0-or-later
"""What is in HDF5 files, and checkpoints that are changed by hand and are valid again."""

import contextlib
import json

import h5py
import numpy as np
from yade_mpm.io import checkpoint


def arraysOf(file, group="/"):
    """All arrays of an HDF5 file below a group, by name."""
    found = {}
    with h5py.File(file) as h5:
        h5[group].visititems(lambda name, one: found.update({name: one}) if hasattr(one, "shape") else None)
        return {name: one[()] for name, one in found.items()}


def bitsOf(file):
    """Arrays and clock of a checkpoint, as bytes."""
    return {name: values.tobytes() for name, values in arraysOf(file).items() if name != "scene"}


@contextlib.contextmanager
def opened(file):
    """The HDF5 file of a checkpoint; its sum is made again at the end."""
    with h5py.File(file, "r+") as h5:
        yield h5
    checkpoint.seal(file)


def describedAnew(file, change):
    """change(spec) changes the description in a checkpoint."""
    with opened(file) as h5:
        spec = json.loads(bytes(h5["scene"][...]))
        change(spec)
        del h5["scene"]
        h5["scene"] = np.frombuffer(json.dumps(spec).encode(), np.uint8)
