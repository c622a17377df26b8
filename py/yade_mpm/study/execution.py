# SPDX-License-Identifier: GPL-2.0-or-later
"""The cases of a study through Dask: on this machine, or on the workers of a scheduler elsewhere."""

import contextlib
import os
import signal
import threading
import time

from . import state
from .optional import needed
from .watch import GRACE, environment, runCase

LOOK = 0.25  # s between looks at what has ended
LOCAL = "127.0.0.1:0"  # this machine alone, any free port
# Dask looks at its threads, its event loops and the load of its workers two to a hundred times per second,
# which takes 3 % of a processor; ours wait.
SELDOM = {
    "distributed.worker.profile.interval": "1s",
    "distributed.worker.profile.cycle": "60s",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "2s",
    "distributed.scheduler.work-stealing": False,
}
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
def cluster(scheduler=None, jobs=1):
    """A client of a scheduler at an address, or of workers on this machine that only start processes."""
    distributed = needed("distributed", "a study")
    if scheduler:
        with distributed.Client(scheduler, timeout=20) as client:
            yield client
        return
    with needed("dask", "a study").config.set(SELDOM):
        local = distributed.LocalCluster(
            n_workers=1,
            threads_per_worker=jobs,
            processes=False,
            memory_limit=0,  # cases are processes of their own
            dashboard_address=LOCAL,  # Dask serves its dashboard in any case; nobody else may see it
            worker_dashboard_address=LOCAL,
            silence_logs=50,  # what a worker says when its study is interrupted is of no use
        )
    with local, distributed.Client(local) as client:
        yield client


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


def execute(client, folders, stop, timeout, tell, look):
    """Runs the cases in their folders; returns False where the study was interrupted.

    client : of Dask. stop : file of this study alone that ends all of its cases. timeout : s per case, or
    None. tell : function of a folder and its state, called as each ends. look : function without arguments,
    called now and then.
    RuntimeError where the scheduler is lost; what has ended is kept.
    """
    shared = dict(stop=stop, timeout=timeout, variables=environment(), cwd=os.getcwd(), pure=False)
    with _interruptible():
        try:
            futures = {
                folder: client.submit(runCase, folder, priority=-i, **shared)
                for i, folder in enumerate(folders)
            }
            while futures:
                _collect(client, futures, tell)
                look()
                time.sleep(LOOK)
        except KeyboardInterrupt:
            _stop(futures, stop, look)
            return False
    return True


def _collect(client, futures, tell):
    """Takes what has ended out of the futures."""
    for folder, future in list(futures.items()):
        if future.status == "pending":
            continue
        del futures[folder]
        if future.status in ("cancelled", "lost") or client.status != "running":
            raise RuntimeError(
                "the scheduler is lost; finished cases are kept, give the same command to go on with the rest"
            )
        if future.status == "error":
            tell(folder, state.write(folder, state.FAILED, f"its worker: {future.exception()}"))
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
