# SPDX-License-Identifier: GPL-2.0-or-later
"""Files are written whole or not at all: what was there before stays until the new one is complete."""

import contextlib
import errno
import fcntl
import glob
import json
import os
import re
import secrets
import socket
from contextlib import contextmanager

import numpy as np

from ..base.kinds import DICT, FILE, takes

HOST = re.sub(r"[^A-Za-z0-9]", "", socket.gethostname()) or "host"
NO_RESERVE = {errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS, errno.ENODEV}  # file systems that cannot
NO_LOCKS = {errno.EOPNOTSUPP, errno.ENOLCK, errno.ENOSYS}


@takes(file=FILE)
@contextmanager
def replacing(file):
    """Name to write a file under, which takes the place of `file` at the end of the `with` block.

    After an error what was written is removed, and an older file of that name is as it was. OSError names
    the file.
    """
    part = temporaryBeside(file)
    try:
        with naming(file):
            yield part
            os.replace(part, file)
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.remove(part)


def temporaryBeside(file):
    """Makes an empty file beside another one, with a name that nobody can foresee, and returns the name.

    What killed processes of this machine left of the same file is removed.
    """
    file = os.fspath(file)
    _removeLeftBehind(file)
    part = f"{file}.{HOST}-{os.getpid()}-{secrets.token_hex(8)}.part"
    with naming(file):  # exclusively: a link that somebody puts there is not followed
        os.close(os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_NOFOLLOW, 0o666))
    return part


def writeWhole(file, *pieces):
    """Writes bytes as a file that is complete on the disk, or not there, when this returns.

    Parameters
    ----------
    file : str, name of the file; an older one stays until the new one is complete.
    pieces : bytes, one behind the other.

    Raises OSError, which names the file.
    """
    with replacing(file) as part:
        fillWhole(part, *pieces)
    syncToDisk(os.path.dirname(os.path.abspath(file)))


def fillWhole(file, *pieces):
    """Writes bytes into a file that is there and empty: takes room first, waits for the disk at the end."""
    number = os.open(file, os.O_WRONLY | os.O_NOFOLLOW)
    try:
        _fill(number, 0, pieces)
        os.fsync(number)
    finally:
        os.close(number)


def _fill(number, at, pieces):
    reserve(number, at, sum(len(piece) for piece in pieces))
    for piece in pieces:
        rest = memoryview(piece).cast("B")
        while len(rest):
            rest = rest[os.write(number, rest) :]


def appendWhole(file, content):
    """Writes bytes at the end of a file: all of them, or none, and then OSError, which names the file."""
    with naming(file):
        number = os.open(file, os.O_WRONLY)
        size = os.fstat(number).st_size
        try:
            os.lseek(number, size, os.SEEK_SET)
            _fill(number, size, [content])
        except OSError:
            os.ftruncate(number, size)
            raise
        finally:
            os.close(number)


def reserve(number, at, count):
    """Takes room on the disk for bytes of an open file from a place on; OSError where there is none."""
    if count <= 0 or not hasattr(os, "posix_fallocate"):
        return
    try:
        os.posix_fallocate(number, at, count)
    except OSError as error:
        if error.errno not in NO_RESERVE:
            raise


def takeLock(number):
    """Locks an open file until it is closed; returns whether no other process has locked it. File systems
    without locks let everybody have it."""
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
    return True


@contextmanager
def naming(file):
    """Errors of the system in the `with` block name a file, and not a temporary one, or none."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename == os.fspath(file):
            raise
        raise type(error)(error.errno, error.strerror, os.fspath(file)) from error


def syncToDisk(path):
    """Waits until a file, or the names in a folder, are on the disk."""
    number = os.open(os.fspath(path), os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _removeLeftBehind(file):
    """Removes what processes of this machine that are no more left of a file that they wrote."""
    for part in glob.glob(f"{glob.escape(file)}.{HOST}-*.part"):
        found = re.fullmatch(r"(\d+)-[0-9a-f]{16}\.part", part[len(file) + len(HOST) + 2 :])
        if found and not _isAlive(int(found[1])):
            with contextlib.suppress(OSError):
                os.remove(part)


def _isAlive(process):
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


@takes(file=FILE)
def saveJson(file, value, wait=True):
    """Writes numbers, texts, lists and dicts of them as JSON, whole or not at all.

    wait : for the disk; False for what is written again when it is lost.
    """
    try:
        content = json.dumps(value, indent=1).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise TypeError(
            f"saveJson: '{os.fspath(file)}' cannot hold the value: {error}; give plain ones"
        ) from None
    if wait:
        writeWhole(file, content)
        return
    with replacing(file) as part, open(part, "wb") as opened:
        opened.write(content)


@takes(file=FILE, columns=DICT)
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


def requireRegular(who, file):
    """Refuses what is there and is no regular file, with a ValueError: a pipe waits, a device has no end."""
    if os.path.exists(file) and not os.path.isfile(file):
        raise ValueError(f"{who}: '{os.fspath(file)}' is no regular file; give the name of a file")


@takes(file=FILE)
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
