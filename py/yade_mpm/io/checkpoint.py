# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoint files: the description of a scene and its arrays in HDF5.

Layout, format 2: root attributes `format`, `formatVersion`, `package`; dataset `scene`, UTF-8 text of a JSON
object with everything but arrays; groups `bodies/0`, `bodies/1` ... with `particles/FIELD` (one row per
particle, in the order of the solver), `domains/FIELD` and `tables/NAME` (how particles and vertices are
grouped and connected). Datasets carry a checksum.
"""

import json
import os

import h5py
import numpy as np

from .. import __version__
from .files import checkWritable, replacing

FORMAT, VERSION = "yade-mpm checkpoint", 2


def write(file, description, bodies):
    """Writes a checkpoint; an older file of that name stays until the new one is complete on the disk.

    Parameters
    ----------
    file : str, name of the file.
    description : dict that JSON can hold: everything but arrays.
    bodies : list of Body, whose arrays are written.

    Raises OSError when the file cannot be written.
    """
    file = os.fspath(file)
    checkWritable(file)
    text = json.dumps(description)
    try:
        with replacing(file) as part:
            with h5py.File(part, "w") as h5:
                _writeAll(h5, text, bodies)
            _syncToDisk(part)
        _syncToDisk(os.path.dirname(os.path.abspath(file)))
    except (
        OSError,
        RuntimeError,
    ) as error:  # RuntimeError: h5py, when a full disk fails the closing of a file
        raise OSError(f"checkpoint '{file}' could not be written: {error}") from error


def read(file):
    """Description and arrays from a checkpoint.

    Parameters
    ----------
    file : str, name of the file.

    Returns the dict that was written, and for each body a dict with the dicts "particles", "domains" and
    "tables". Raises FileNotFoundError, and ValueError for a file that is damaged, no checkpoint, or of
    another format.
    """
    if not os.path.isfile(file):
        raise FileNotFoundError(f"checkpoint '{file}' does not exist")
    if not h5py.is_hdf5(file):
        raise ValueError(f"'{file}' is no checkpoint, or damaged: it is not an HDF5 file")
    try:
        with h5py.File(file, "r") as h5:
            spec = _readSpec(h5, file)
            return spec, [_readArrays(h5[f"bodies/{k}"]) for k in range(len(spec["bodies"]))]
    except (OSError, KeyError, RuntimeError, json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"checkpoint '{file}' is damaged: {error}; use an older one") from error


def _writeAll(h5, text, bodies):
    h5.attrs.update(format=FORMAT, formatVersion=VERSION, package=__version__)
    _write(h5, "scene", np.frombuffer(text.encode(), np.uint8))
    for k, body in enumerate(bodies):
        group = h5.create_group(f"bodies/{k}")
        for name in storedFields(body):
            _write(group, f"particles/{name}", np.asarray(body.core.view(name, False)))
        for field in body.core.fields(True):
            _write(group, f"domains/{field['name']}", np.asarray(body.core.view(field["name"], True)))
        for name, table in body.core.tables().items():
            _write(group, f"tables/{name}", np.array(table, np.int32))


def _write(group, name, array):
    group.create_dataset(name, data=array, fletcher32=array.size > 0 or None)


def storedFields(body):
    """All but the body force that nobody has asked for: to ask is to switch it on."""
    return [f["name"] for f in body.core.fields(False) if f["name"] != "bodyForce" or body.core.hasBodyForce]


def _syncToDisk(path):
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _readSpec(h5, file):
    if h5.attrs.get("format") != FORMAT:
        raise ValueError(f"'{file}' is an HDF5 file, but no checkpoint of yade_mpm")
    version = int(h5.attrs.get("formatVersion", 0))
    if version != VERSION:
        raise ValueError(
            f"checkpoint '{file}' has format {version}, written by yade_mpm {h5.attrs.get('package')}; "
            f"yade_mpm {__version__} reads format {VERSION}; continue it with that version"
        )
    return json.loads(bytes(h5["scene"][...]).decode())


def _readArrays(group):
    return {
        kind: {name: data[...] for name, data in group.get(kind, {}).items()}
        for kind in ("particles", "domains", "tables")
    }
