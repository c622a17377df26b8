# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoint files: the description of a scene and its arrays in HDF5, sealed by a checksum.

Layout, format 3. The first 512 bytes are text: what the file is, and the SHA-256 sum of everything behind
them, in which HDF5 begins (its "user block"; h5py and other readers skip it). Root attributes `format`,
`formatVersion`, `package`; dataset `scene`, UTF-8 text of a JSON object with everything but arrays; groups
`bodies/0`, `bodies/1` ... with `particles/FIELD` (one row per particle, in the order of the solver),
`domains/FIELD` and `tables/NAME` (how particles and vertices are grouped and connected). Datasets are
plain: no filters, no links to other files. Names of other files are relative to the folder of the
checkpoint.

HDF5 sees no byte before the checksum is verified. A file without it, as of format 2, is refused.
"""

import hashlib
import io
import json
import os

import h5py
import numpy as np

from .. import __version__
from ..base.kinds import requireFile
from .files import checkWritable, writeWhole

FORMAT, VERSION = "yade-mpm checkpoint", 3
NOT_AS_WRITTEN = (
    "checkpoint '{}' is damaged: it is not what was written (its checksum differs); use an older one"
)
MAGIC = b"yade-mpm checkpoint; sha256 "
SEAL = 512  # bytes; the smallest user block of HDF5
PIECE = 1 << 20  # bytes read at once
MOST_BODIES = 100_000
READING = (OSError, KeyError, TypeError, AttributeError, RuntimeError, MemoryError, OverflowError)


def write(file, description, bodies):
    """Writes a checkpoint; an older file of that name stays until the new one is complete on the disk.

    The image of the file is made in memory, for HDF5 does not survive a disk that becomes full.

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
    image = io.BytesIO()
    with h5py.File(image, "w", userblock_size=SEAL) as h5:
        _writeAll(h5, text, bodies)
    content = image.getbuffer()[SEAL:]
    try:
        writeWhole(file, sealOf(content), content)
    except OSError as error:
        raise OSError(
            error.errno,
            f"checkpoint '{file}' could not be written: {error.strerror or error}; an older file of that "
            "name is as it was",
        ) from error


def sealOf(content):
    """The first bytes of a checkpoint, from all that follow."""
    return _sealText(hashlib.sha256(content))


def _sealText(total):
    return (MAGIC + total.hexdigest().encode() + b"\n").ljust(SEAL, b"\0")


def seal(file):
    """Makes a checkpoint whose content was changed by hand valid again."""
    with open(file, "rb") as f:
        content = f.read()[SEAL:]
    writeWhole(file, sealOf(content), content)


def read(file):
    """Description and arrays from a checkpoint.

    Parameters
    ----------
    file : str, name of the file.

    Returns the dict that was written, and for each body a dict with the dicts "particles", "domains" and
    "tables". Takes no more memory than the file has bytes. Raises FileNotFoundError, and ValueError for a
    file that is damaged, no checkpoint, or of another format.
    """
    _checkSeal(file)
    try:
        with h5py.File(file, "r") as h5:
            _checkVersion(h5, file)
            checkPlain(h5)
            reader = _Reader(h5, file)
            spec = json.loads(bytes(reader.array(h5, "scene", np.dtype(np.uint8), 1)).decode())
            count = len(spec["bodies"])
            if count > MOST_BODIES or count != len(h5.get("bodies", ())):
                raise KeyError(f"{count} bodies are described, {len(h5.get('bodies', ()))} are there")
            return spec, [reader.body(f"bodies/{k}") for k in range(count)]
    except ValueError as error:
        if str(error).startswith(("checkpoint", f"'{file}'")):
            raise
        raise _damaged(file, error) from error
    except READING as error:
        raise _damaged(file, error) from error


def _damaged(file, error):
    return ValueError(f"checkpoint '{file}' is damaged: {type(error).__name__}: {error}; use an older one")


def _checkSeal(file):
    """Refuses a file whose bytes are not those that were written, before HDF5 sees them."""
    requireFile("load", file, "the name of a checkpoint (.h5) of a run")
    if not h5py.is_hdf5(file):
        raise ValueError(f"'{file}' is no checkpoint, or damaged: it is not an HDF5 file")
    total = hashlib.sha256()
    with open(file, "rb") as f:
        stated = f.read(SEAL)
        while piece := f.read(PIECE):
            total.update(piece)
    if not stated.startswith(MAGIC):
        raise ValueError(
            f"'{file}' is an HDF5 file without the checksum of a checkpoint; give one that scene.save wrote. "
            f"A checkpoint of the release 0.1.0 (format 2) has none: continue it with that release"
        )
    if stated != _sealText(total):
        raise ValueError(NOT_AS_WRITTEN.format(file))


def _checkVersion(h5, file):
    if h5.attrs.get("format") != FORMAT:
        raise ValueError(
            f"'{file}' is an HDF5 file, but no checkpoint of yade_mpm; give one that scene.save wrote"
        )
    version = int(h5.attrs.get("formatVersion", 0))
    if version != VERSION:
        raise ValueError(
            f"checkpoint '{file}' has format {version}, written by yade_mpm {h5.attrs.get('package')}; "
            f"yade_mpm {__version__} reads format {VERSION}; continue it with that version"
        )


def checkPlain(h5, filters=(), most=float("inf")):
    """Refuses an HDF5 file, with a ValueError, of which something is in other files or needs their code.

    filters : numbers of those that arrays may have passed, each once.
    most : bytes that an array may have.
    """
    groups, known = [h5["/"]], set()
    while groups:
        group = groups.pop()
        for name in group:
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise ValueError(f"{name} is a link to elsewhere")
            one = group[name]
            if isinstance(one, h5py.Dataset):
                _checkPlainArray(name, one.id.get_create_plist(), filters)
                if one.nbytes > most:
                    raise ValueError(f"{name} with the shape {one.shape} is larger than the file")
            elif isinstance(one, h5py.Group) and (place := h5py.h5o.get_info(one.id).addr) not in known:
                known.add(place)
                groups.append(one)


def _checkPlainArray(name, plist, filters):
    found = [plist.get_filter(k)[0] for k in range(plist.get_nfilters())]
    isElsewhere = plist.get_external_count() or plist.get_layout() == h5py.h5d.VIRTUAL
    if isElsewhere or len(found) > len(set(found)) or not set(found) <= set(filters):
        raise ValueError(f"{name} is compressed, or elsewhere")


class _Reader:
    """Arrays of an open checkpoint, whose kind and size are checked before memory is taken for them."""

    KINDS = {"particles": None, "domains": None, "tables": np.dtype(np.int32)}

    def __init__(self, h5, file):
        self._h5, self._left = h5, os.path.getsize(file)

    def body(self, path):
        """Dict of dicts of the arrays of a body."""
        group = self._h5[path]
        return {
            kind: {name: self.array(group[kind], name, dtype) for name in group[kind]}
            if kind in group
            else {}
            for kind, dtype in self.KINDS.items()
        }

    def array(self, group, name, dtype=None, ndim=None):
        """An array by its name."""
        data = group[name]
        if not isinstance(data, h5py.Dataset):
            raise ValueError(f"{name} is no array")
        if data.dtype not in ([dtype] if dtype else [np.dtype(np.float64), np.dtype(np.int64)]):
            raise ValueError(f"{name} has numbers of the kind {data.dtype}")
        if data.ndim not in ([ndim] if ndim else [1, 2, 3]):
            raise ValueError(f"{name} has {data.ndim} dimensions")
        self._left -= data.nbytes
        if self._left < 0 or data.id.get_storage_size() < data.nbytes:
            raise ValueError(f"{name} with the shape {data.shape} is larger than the file")
        return data[...]


def _writeAll(h5, text, bodies):
    h5.attrs.update(format=FORMAT, formatVersion=VERSION, package=__version__)
    h5.create_dataset("scene", data=np.frombuffer(text.encode(), np.uint8))
    for k, body in enumerate(bodies):
        group = h5.create_group(f"bodies/{k}")
        for name in storedFields(body):
            group.create_dataset(f"particles/{name}", data=np.asarray(body._core.view(name, False)))
        for field in body._core.fields(True):
            name = field["name"]
            group.create_dataset(f"domains/{name}", data=np.asarray(body._core.view(name, True)))
        for name, table in body._core.tables().items():
            group.create_dataset(f"tables/{name}", data=np.array(table, np.int32))


def storedFields(body):
    """All but the body force that nobody has asked for: to ask is to switch it on."""
    return [
        f["name"] for f in body._core.fields(False) if f["name"] != "bodyForce" or body._core.hasBodyForce
    ]
