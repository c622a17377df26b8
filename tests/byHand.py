# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints that are changed by hand and are valid again."""

import contextlib
import json

import h5py
import numpy as np
from yade_mpm.io import checkpoint


@contextlib.contextmanager
def opened(file):
    """The HDF5 file of a checkpoint; its sum is made anew at the end."""
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
