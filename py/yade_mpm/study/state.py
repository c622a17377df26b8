# SPDX-License-Identifier: GPL-2.0-or-later
"""State of a case, kept in its folder: what was asked for, how far it is, and what went wrong."""

import json
import math
import os

from ..app.resume import SUMMARY
from ..io.files import saveJson

CASE, STATE, LOG, STOP = "case.json", "state.json", "log.txt", "stop"
WAITING, RUNNING, DONE, FAILED = "waiting", "running", "done", "failed"
TIMED_OUT, INTERRUPTED = "timed out", "interrupted"
ENDED = (DONE, FAILED, TIMED_OUT)  # such a case is not run again unless asked for


def read(folder):
    """State of the case in a folder, a dict with at least `state` and `message`.

    A case whose files are damaged, or that is done without results, waits: it is run again.
    """
    file = os.path.join(folder, STATE)
    found = readJson(file)
    if found is None or not isinstance(found.get("state"), str):
        return {"state": WAITING, "message": f"{file} is damaged" if os.path.exists(file) else ""}
    summary = os.path.join(folder, SUMMARY)
    if found["state"] == DONE and readJson(summary) is None:
        return {**found, "state": WAITING, "message": f"{summary} is missing or damaged"}
    return {"message": "", **found}


def readJson(file):
    """The dict in a JSON file; None where there is none."""
    try:
        with open(file, encoding="utf-8") as text:
            found = json.load(text)
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def write(folder, state, message="", **more):
    """Notes the state of a case; what was noted of its attempts and its start stays."""
    new = {**read(folder), "state": state, "message": message, **more}
    saveJson(os.path.join(folder, STATE), new)
    return new


def readCase(folder):
    """What was asked for."""
    with open(os.path.join(folder, CASE), encoding="utf-8") as text:
        return json.load(text)


def endOfLog(folder, lines=30):
    """Last lines of what a case has said."""
    try:
        with open(os.path.join(folder, LOG), "rb") as opened:
            opened.seek(max(0, os.path.getsize(opened.name) - 8192))
            return "\n".join(opened.read().decode(errors="replace").splitlines()[-lines:])
    except OSError:
        return ""


def notNumbers(results):
    """Names of results that are not a number or infinite."""
    return [name for name, value in results.items() if isinstance(value, float) and not math.isfinite(value)]


def flat(results, before=""):
    """Numbers, texts and switches of nested results, with names such as resistance.1.0; lists are left
    out."""
    found = {}
    for name, value in results.items():
        if isinstance(value, dict):
            found.update(flat(value, f"{before}{name}."))
        elif value is None or isinstance(value, (bool, int, float, str)):
            found[before + name] = value
    return found
