# SPDX-License-Identifier: GPL-2.0-or-later
"""Who writes a file of results: one engine at a time, the one whose run began last."""

import os
import weakref

_owners = {}  # real path -> weak reference to the engine that writes it


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
        _refuse(file, engine, "has written to it since")
    if other is not None and other._scene is not engine._scene and other._scene.holder.isHeld:
        _refuse(file, engine, "is writing to it")
    _owners[path] = weakref.ref(engine)
    object.__setattr__(engine, "_owned", path)


def check(file, engine):
    """Refuses an engine that has lost its file while its run went on."""
    if _owners.get(os.path.realpath(file), lambda: engine)() is not engine:
        _refuse(file, engine, "has written to it since")


def _refuse(file, engine, what):
    raise RuntimeError(
        f"{type(engine).__name__}: '{file}' belongs to another scene, which {what}; go on with that one, or "
        "give each scene a file of its own"
    )
