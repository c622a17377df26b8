# SPDX-License-Identifier: GPL-2.0-or-later
"""A folder that one process works in at a time: a lock that ends with its process and says who holds it."""

import os
import time
from contextlib import contextmanager

from ..io.files import takeLock

LOCK = "lock"
LOOK = 0.1  # s between looks at a lock that another process holds


class Held(RuntimeError):
    """Another process holds the folder; the text says which."""


@contextmanager
def holding(folder, who, wait=0.0):
    """Holds a folder in the `with` block; raises Held where another process does for longer than `wait` s.

    who : what holds it, in words, for the other process.
    """
    with open(os.path.join(folder, LOCK), "a+", encoding="utf-8") as lock:
        until = time.monotonic() + wait
        while not takeLock(lock.fileno()):
            if time.monotonic() >= until:
                lock.seek(0)
                raise Held(lock.read().strip() or "another process")
            time.sleep(LOOK)
        lock.truncate(0)
        lock.write(f"{who}, process {os.getpid()} on {os.uname().nodename}, since {time.ctime()}\n")
        lock.flush()
        yield
