# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs a case in a process of its own, and ends it where its time is over or the study is stopped.

A thread here, or a worker of Dask, calls `runCase`; it needs nothing but the folder of the case, on a file
system that all machines of the study share.
"""

import os
import signal
import subprocess
import sys
import time

from . import state

LOOK = (0.05, 0.5)  # s between looks at the process, at least and at most
LATE = 0.02  # of its time, by which the end of a case may be noticed late
GRACE = 20.0  # s that a case has to leave its checkpoint
PACKAGES = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
WATCHED = ("PYTHONPATH", "MPLBACKEND", "OMP_NUM_THREADS", "OMP_WAIT_POLICY")


def environment():
    """Variables that the process of a case needs, as they are here; it may work in another folder."""
    variables = {name: os.environ[name] for name in WATCHED if name in os.environ}
    folders = [PACKAGES, *filter(None, [variables.get("PYTHONPATH")])]
    return {**variables, "PYTHONPATH": os.pathsep.join(folders)}


def runCase(folder, stop, timeout=None, variables=None, cwd=None):
    """Runs the case in a folder; returns its state. Does not raise: what went wrong is in the state.

    stop : file whose existence ends all cases of the study. timeout : s. variables : as of `environment`.
    """
    old = state.read(folder)
    if old["state"] == state.DONE:
        return old
    if os.path.exists(stop):
        return state.write(folder, state.INTERRUPTED)
    state.write(folder, state.WAITING, started=time.time())
    began = time.monotonic()
    with open(os.path.join(folder, state.LOG), "ab") as log:
        process = subprocess.Popen(
            # -u: the log has all that a case has said, also of one that is killed.
            [sys.executable, "-u", "-m", "yade_mpm.study.caseProcess", folder],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            cwd=cwd,
            env={**os.environ, **(variables or {}), "YADE_MPM_CASE_PARENT": str(os.getpid())},
        )
    why = _wait(process, stop, None if timeout is None else began + timeout)
    new, seconds = state.read(folder), time.monotonic() - began
    if new["state"] == state.DONE:
        return new
    if why == state.TIMED_OUT:
        return state.write(folder, why, f"after {timeout:g} s", seconds=seconds)
    if why == state.INTERRUPTED:
        return state.write(folder, why, seconds=seconds)
    if process.returncode < 0 or new["state"] in (state.RUNNING, state.WAITING):
        return state.write(folder, state.FAILED, _howItEnded(process.returncode, folder), seconds=seconds)
    return new


def _wait(process, stop, until):
    """Waits for the end; returns TIMED_OUT or INTERRUPTED where the process was ended for that."""
    began = time.monotonic()
    while process.poll() is None:
        why = state.INTERRUPTED if os.path.exists(stop) else None
        if until is not None and time.monotonic() > until:
            why = state.TIMED_OUT
        if why:
            _end(process)
            return why
        time.sleep(min(max(LOOK[0], LATE * (time.monotonic() - began)), LOOK[1]))
    return None


def _end(process):
    process.send_signal(signal.SIGTERM)
    try:
        process.wait(GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _howItEnded(code, folder):
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    if code >= 128:
        return f"ended by {signal.Signals(code - 128).name}"
    last = state.endOfLog(folder, 1)
    isOfScene = last and not last.startswith("$ ")  # the command line
    return f"ended with {code}: {last}" if isOfScene else f"ended with {code} without a word"
