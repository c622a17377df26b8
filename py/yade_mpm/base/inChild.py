# SPDX-License-Identifier: GPL-2.0-or-later
"""Work with libraries that may crash or go round for ever on a damaged file, in a process of its own."""

import contextlib
import faulthandler
import os
import pickle
import resource
import select
import signal
import time
import warnings

PIECE = 1 << 20  # bytes read at once
WAITING = 6  # s that a child may take for each second of its processor time: other jobs, slow disks
NOT_READY = "it is not ready in time"


class LostInChild(RuntimeError):
    """The process crashed or did not come to an end; the text says which."""


def inChild(work, seconds, memory):
    """What a function returns, called in a child process; what it raises is raised here.

    Parameters
    ----------
    work : function without arguments; what it returns must be picklable.
    seconds : float, s of its processor time, or WAITING times as many of wall time, after which the child is
        ended.
    memory : int, bytes that it may take besides those that this process has.

    Raises LostInChild for a child that crashes, or is not ready in time.
    """
    reading, writing = os.pipe()
    with warnings.catch_warnings():  # Python 3.12: of threads, which the child does without
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        _workInChild(work, writing, seconds, memory)
    os.close(writing)
    try:
        told = _readAll(reading, time.monotonic() + WAITING * seconds)
    except BaseException:  # LostInChild, and a Ctrl-C of the user
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.close(reading)
        status = os.waitpid(child, 0)[1]
    if status != 0:
        code = os.waitstatus_to_exitcode(status)
        if code == -signal.SIGPROF:
            raise LostInChild(NOT_READY)
        raise LostInChild(f"it crashed ({signal.Signals(-code).name if code < 0 else f'exit code {code}'})")
    result, error = pickle.loads(told)
    if error is not None:
        raise error
    return result


def _workInChild(work, writing, seconds, memory):
    """Never returns."""
    code = 1
    try:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGPROF):  # handlers of a run are not its own
            signal.signal(number, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, seconds)  # ends what goes round for ever
        faulthandler.disable()
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        _limitMemory(memory)
        with open(writing, "wb") as out:
            pickle.dump(_outcome(work), out)
        code = 0
    finally:
        os._exit(code)


def _outcome(work):
    try:
        return work(), None
    except BaseException as error:
        with contextlib.suppress(Exception):
            pickle.loads(pickle.dumps(error))
            return None, error
        return None, RuntimeError(f"{type(error).__name__}: {error}")


def _limitMemory(more):
    with open("/proc/self/statm") as file:
        here = int(file.read().split()[0]) * resource.getpagesize()
    most = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = here + more
    resource.setrlimit(resource.RLIMIT_AS, (limit if most < 0 else min(limit, most), most))


def _readAll(number, deadline):
    """All bytes up to the end, which has to come before the deadline."""
    told = bytearray()
    while True:
        left = deadline - time.monotonic()
        if left <= 0 or not select.select([number], [], [], left)[0]:
            raise LostInChild(NOT_READY)
        piece = os.read(number, PIECE)
        if not piece:
            return told
        told += piece
