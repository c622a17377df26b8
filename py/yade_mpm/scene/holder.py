# SPDX-License-Identifier: GPL-2.0-or-later
"""Who has a scene: one thread at a time, and a name for what it does."""

import os
import threading
from contextlib import contextmanager


class Holder:
    """Lets one thread at a time work with a scene; refuses others, telling who has it. Never waits."""

    def __init__(self):
        self._lock, self._thread, self._what, self._process = threading.Lock(), None, None, None

    isHeld = property(
        lambda self: self._thread is not None, doc="Whether a thread is at work with the scene."
    )

    @contextmanager
    def held(self, what):
        """Holds the scene during the `with` block; a thread that has it already goes on.

        Parameters
        ----------
        what : str, what is done, e.g. "run".

        Raises RuntimeError where another thread has it, or had it when this process was forked.
        """
        if self._isMine():
            yield
            return
        if not self._lock.acquire(blocking=False):
            self.refuseOthers(what)
            raise RuntimeError(f"{what}: another thread is at work with the scene; use one scene for each")
        self._thread, self._what, self._process = threading.current_thread(), what, os.getpid()
        try:
            yield
        finally:
            self._thread = self._what = None
            self._lock.release()

    def refuseOthers(self, what):
        """Raises RuntimeError, in the name of `what`, where another thread has the scene."""
        holder, doing = self._thread, self._what
        if holder is None or self._isMine():
            return
        if self._process != os.getpid():
            raise RuntimeError(
                f"{what}: thread '{holder.name}' was at work with the scene ({doing}) when this process "
                f"was forked, and its state is torn here; pause() before the fork, load a checkpoint, or "
                f"start processes by 'spawn'"
            )
        raise RuntimeError(
            f"{what}: thread '{holder.name}' is at work with the scene ({doing}); wait for it, or make a "
            f"scene for each thread"
        )

    def _isMine(self):
        return self._thread is threading.current_thread() and self._process == os.getpid()
