# SPDX-License-Identifier: GPL-2.0-or-later
"""Who writes a file of results: one engine at a time, the one whose run began last, of one process."""

import os
import weakref

from .files import takeLock

_owners = {}  # real path -> weak reference to the engine that writes it
_locks = {}  # real path -> descriptor of the file, locked by this process until the engine is gone


def take(file, engine):
    """Makes an engine the owner of a file; called when its run begins.

    RuntimeError where it has lost the file to another scene, or that one is running: they would write by
    turns.
    """
    path = os.path.realpath(file)
    other = _owners.get(path, lambda: None)()
    if other is engine:
        return
    if getattr(engine, "_owned", None) == path and other is not None:
        _refuse(file, engine, "belongs to another scene, which has written to it since")
    if other is not None and other._scene is not engine._scene and other._scene._holder.isHeld:
        _refuse(file, engine, "belongs to another scene, which is writing to it")
    _owners[path] = weakref.ref(engine, lambda gone: _release(path, gone))
    object.__setattr__(engine, "_owned", path)


def check(file, engine):
    """Refuses an engine that has lost its file while its run went on."""
    if _owners.get(os.path.realpath(file), lambda: engine)() is not engine:
        _refuse(file, engine, "belongs to another scene, which has written to it since")


def lock(file, engine):
    """Locks a file as it is now, if it is there, until its owner is gone; RuntimeError where another process
    has locked it. Not for files of HDF5, whose readers lock them, too."""
    path = os.path.realpath(file)
    try:
        number = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    except OSError:  # not there, or not for us: what writes it says so
        return
    held, found = _locks.get(path), os.fstat(number)
    if any(os.path.samestat(os.fstat(one), found) for one in _locks.values()):  # ours, maybe by another name
        os.close(number)
    elif takeLock(number):
        _locks[path] = number
        if held is not None:
            os.close(held)
    else:
        os.close(number)
        _refuse(file, engine, "is written by another process")


def _release(path, owner):
    if _owners.get(path) is owner:
        del _owners[path]
        if path in _locks:
            os.close(_locks.pop(path))


def release(engine):
    """Another engine may write the file of this one, whose run is over."""
    for path, owner in list(_owners.items()):
        if owner() is engine:
            _release(path, owner)


def _refuse(file, engine, what):
    raise RuntimeError(
        f"{type(engine).__name__}: '{file}' {what}; go on with that one, or give each run a file of its own"
    )
