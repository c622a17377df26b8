# SPDX-License-Identifier: GPL-2.0-or-later
"""The process of one case: python -m yade_mpm.study.caseProcess FOLDER.

It runs the scene, or calls the functions, that FOLDER/case.json names, continues from a checkpoint where one
was left, and notes in FOLDER/state.json how it ended. When the process that started it dies it is ended with
SIGTERM, which leaves a checkpoint.
"""

import argparse
import ctypes
import json
import os
import runpy
import signal
import sys
import time
import traceback

from ..app.record import saveHistories
from ..app.resume import ARGUMENTS, SUMMARY
from ..io.files import saveJson
from ..scene.restoring import load
from . import state
from .lock import Held, holding

CHECKPOINT = "checkpoint.h5"
LOCK_WAIT = 60.0  # s that a case waits for an older process of the same case to end
SET_PDEATHSIG = 1  # of prctl(2)


def main(folder):
    """Runs the case; returns the exit code."""
    _endWithParent()
    with holding(folder, "a case", LOCK_WAIT):
        if state.read(folder)["state"] == state.DONE:  # by an older process, while this one waited
            return 0
        case, attempts = state.readCase(folder), state.read(folder).get("attempts", 0) + 1
        about = dict(pid=os.getpid(), host=os.uname().nodename, began=time.time(), attempts=attempts)
        state.write(folder, state.RUNNING, **about)
        began = time.monotonic()
        how, message = _run(folder, case)
        if how == state.DONE:
            how, message = _checked(folder)
        state.write(folder, how, message, seconds=time.monotonic() - began, ended=time.time())
    return 0 if how == state.DONE else 1


def _endWithParent():
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(SET_PDEATHSIG, signal.SIGTERM)
    if os.environ.get("YADE_MPM_CASE_PARENT") not in (None, str(os.getppid())):
        raise SystemExit("the process that started this case is gone")


def _run(folder, case):
    """State and message with which the case ends."""
    try:
        _callFunctions(folder, case) if "functions" in case else _runScene(folder, case)
    except KeyboardInterrupt:
        return state.INTERRUPTED, ""
    except SystemExit as end:
        if end.code in (130, 128 + signal.SIGTERM, 128 + signal.SIGHUP):
            return state.INTERRUPTED, ""
        if end.code in (None, 0):
            return state.DONE, ""
        text = end.code if isinstance(end.code, str) else f"the scene ended with {end.code}"
        print(text, file=sys.stderr)
        return state.FAILED, text
    except BaseException as error:
        traceback.print_exc()
        return state.FAILED, f"{type(error).__name__}: {error}"
    return state.DONE, ""


def _runScene(folder, case):
    words = [*case["words"], "--out", folder]
    if case["threads"]:
        words += ["--threads", str(case["threads"])]
    if case["isResumable"] and _isLeft(folder):
        words = ["--resume", os.path.join(folder, CHECKPOINT)]
    print("$", case["scene"], *words, flush=True)
    sys.argv = [case["scene"], *words]
    sys.path.insert(0, os.path.dirname(case["scene"]))  # as for a script
    runpy.run_path(case["scene"], run_name="__main__")


def _isLeft(folder):
    """Whether a checkpoint of this case is there, and not of an older run."""
    checkpoint, arguments = (os.path.join(folder, name) for name in (CHECKPOINT, ARGUMENTS))
    isThere = os.path.exists(checkpoint) and os.path.exists(arguments)
    return isThere and os.path.getmtime(checkpoint) >= os.path.getmtime(arguments)


def _callFunctions(folder, case):
    import cloudpickle

    sys.path += [folder for folder in case["path"] if folder not in sys.path]
    with open(case["functions"], "rb") as opened:
        build, results = cloudpickle.load(opened)
    a = argparse.Namespace(**case["arguments"], out=folder, threads=case["threads"] or None)
    scene, checkpoint = None, os.path.join(folder, CHECKPOINT)
    if case["until"] is not None and os.path.exists(checkpoint):
        try:
            scene = load(checkpoint)
        except (ValueError, OSError) as error:
            print(
                f"the checkpoint cannot be continued, the case begins from its start: {error}",
                file=sys.stderr,
            )
    scene = scene or build(a)
    if scene is None and (results or case["until"] is not None):
        raise TypeError(f"{build.__name__} returned None; end it with `return scene`")
    if case["until"] is not None:
        scene.run(until=case["until"], checkpointFile=checkpoint, progress=False)
    found = results(scene) if results else {}
    if scene is not None:
        saveHistories(folder, scene)
    saveJson(os.path.join(folder, SUMMARY), dict(found))


def _checked(folder):
    """State and message of a case whose scene has ended well: its results must be numbers."""
    file = os.path.join(folder, SUMMARY)
    if not os.path.exists(file):
        return state.FAILED, f"the scene has left no {SUMMARY}"
    with open(file, encoding="utf-8") as text:
        wrong = state.notNumbers(state.flat(json.load(text)))
    return (state.FAILED, "not a number: " + ", ".join(wrong)) if wrong else (state.DONE, "")


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1]))
    except Held as other:
        sys.exit(f"another process works on this case: {other}")
