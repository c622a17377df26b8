# SPDX-License-Identifier: GPL-2.0-or-later
"""The cases of a study side by side: on this machine, or on the workers of a Dask scheduler elsewhere."""

import contextlib
import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor

from . import state
from .optional import needed
from .watch import GRACE, environment, runCase

LOOK = 0.25  # s between looks at what has ended
LOST = "the scheduler is lost; finished cases are kept, give the same command to go on with the rest"
MEMORY = 1.0  # GiB that a case may need, unless told otherwise


def jobsAndThreads(count, jobs=None, threads=None, memory=MEMORY):
    """How many cases run at once, and with how many threads each.

    count : cases to run. jobs, threads : as asked for, None: chosen so that cores and memory suffice.
    memory : GiB that a case needs.
    """
    cores, available = len(os.sched_getaffinity(0)), needed("psutil", "a study").virtual_memory().available
    fits = max(1, int(available / 2**30 / memory))
    jobs = jobs or max(1, min(count, fits, cores // (threads or 1)))
    return jobs, threads or max(1, cores // jobs)


@contextlib.contextmanager
def workers(scheduler=None, jobs=1):
    """What cases are submitted to: the client of a Dask scheduler at an address, or threads here that only
    start processes and wait for them."""
    if scheduler:
        with needed("distributed", "--scheduler").Client(scheduler, timeout=20) as client:
            yield client
    else:
        pool = ThreadPoolExecutor(jobs)
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def _interruptible():
    """SIGTERM and SIGHUP interrupt a study as Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number, frame):
        raise KeyboardInterrupt

    old = {n: signal.signal(n, interrupt) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in old.items():
            signal.signal(number, handler)


def execute(pool, folders, stop, timeout, tell, look):
    """Runs the cases in their folders; returns False where the study was interrupted.

    pool : as of `workers`. stop : file of this study alone that ends all of its cases. timeout : s per case,
    or None. tell : function of a folder and its state, called as each ends. look : function without
    arguments, called now and then.
    RuntimeError where the scheduler is lost; what has ended is kept.
    """
    shared = dict(stop=stop, timeout=timeout, variables=environment(), cwd=os.getcwd())
    isDask = not isinstance(pool, ThreadPoolExecutor)
    futures = {}
    with _interruptible():
        try:
            for i, folder in enumerate(folders):
                own = dict(pure=False, priority=-i) if isDask else {}  # in the order of the table
                futures[folder] = pool.submit(runCase, folder, **shared, **own)
            while futures:
                for folder in [f for f, future in futures.items() if future.done()]:
                    _end(pool if isDask else None, folder, futures.pop(folder), tell)
                if isDask and pool.status != "running":
                    raise RuntimeError(LOST)
                look()
                time.sleep(LOOK)
        except BaseException as error:
            _stop(futures, stop, look)
            if not isinstance(error, KeyboardInterrupt):
                raise
            return False
    return True


def _end(client, folder, future, tell):
    """Tells how a case has ended."""
    if future.cancelled() or client is not None and client.status != "running":
        raise RuntimeError(LOST)
    if error := future.exception():
        tell(folder, state.write(folder, state.FAILED, f"its worker: {error}"))
    else:
        tell(folder, state.read(folder))


def _stop(futures, stop, look):
    """Ends the cases that run, each with a checkpoint, and waits for that."""
    with open(stop, "w"):
        pass
    until = time.monotonic() + GRACE + 5
    isRunning = dict.fromkeys(futures)
    while isRunning and time.monotonic() < until:
        for folder in list(isRunning):
            if state.read(folder)["state"] != state.RUNNING:
                del isRunning[folder]
        look()
        time.sleep(LOOK)
