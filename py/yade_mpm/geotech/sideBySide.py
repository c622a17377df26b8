# SPDX-License-Identifier: GPL-2.0-or-later
"""Calls side by side, each in a process of its own that begins as a copy of this one.

Any function will do, and scripts need no `if __name__ == "__main__"`: nothing is sent but what comes back.
"""

import ctypes
import multiprocessing
import signal
import sys

SET_PDEATHSIG = 1  # of prctl(2)


def callEach(function, values, what):
    """What a function returns for each value, all at once; what it changes stays in its process.

    what : str, says before a value what ended where its process was killed.
    Raises RuntimeError with the text of the first error, in the order of the values. No process is left.
    """
    fork, calls = multiprocessing.get_context("fork"), []
    try:
        for value in values:
            here, there = fork.Pipe(duplex=False)
            process = fork.Process(target=_call, args=(there, function, value), daemon=True)
            process.start()
            there.close()
            calls.append((process, here))
        return [_result(*call, f"{what} {value:.4g}") for call, value in zip(calls, values)]
    finally:
        for process, here in calls:
            process.kill()
            process.join()
            here.close()


def _call(pipe, function, value):
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits, and ends this one
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(SET_PDEATHSIG, signal.SIGKILL)  # no process outlives the one that waits
    try:
        pipe.send((function(value), None))
    except Exception as error:
        pipe.send((None, str(error)))


def _result(process, pipe, what):
    try:
        found, problem = pipe.recv()
    except EOFError:
        process.join()
        problem = (
            f"{what} was ended by the system ({process.exitcode}), often for want of memory; give fewer jobs"
        )
    if problem:
        raise RuntimeError(problem)
    return found
