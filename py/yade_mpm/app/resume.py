# SPDX-License-Identifier: GPL-2.0-or-later
"""The arguments of a run stay beside its checkpoint, so that --resume CHECKPOINT goes on with them and
with no others."""

import argparse
import json
import os

from ..base.kinds import Kind, takes
from ..io.files import saveJson

ARGUMENTS = "arguments.json"  # in the folder of the results
SUMMARY = "summary.json"
ARGUMENTS_OF_RUN = Kind("the arguments of a run, with `out`", lambda value: hasattr(value, "out"))


@takes(a=ARGUMENTS_OF_RUN)
def keep(a):
    """Writes the arguments of a run into the folder of its results, in place of those of another run and
    its summary."""
    file, old = (os.path.join(a.out, name) for name in (ARGUMENTS, SUMMARY))
    if os.path.exists(old):
        os.remove(old)
    saveJson(file, vars(a))


def resumed(parser, a, given, mayChange):
    """The arguments of the run that left the checkpoint a.resume, but for those given that may change.

    parser : its `error` ends the program where that cannot be. given : names of the arguments on the command
    line. mayChange : names of those that may differ from the run's.
    """
    folder, who = os.path.dirname(os.path.abspath(a.resume)), f"--resume {a.resume}"
    kept = _kept(parser, a.resume, folder, who)
    a.out = os.path.abspath(a.out or folder)
    mayChange = {*mayChange, "resume", "threads"}
    other = {
        name: kept.get(name)
        for name in sorted(given - mayChange)
        if vars(a)[name] != (folder if name == "out" else kept.get(name))
    }
    if other:
        parser.error(
            f"{who}: that run has "
            + ", ".join(f"--{name.replace('_', '-')} {value}" for name, value in other.items())
            + "; leave that out, or start a run of its own"
        )
    changed = {name: vars(a)[name] for name in given & mayChange}
    return argparse.Namespace(**{**vars(a), **kept, **changed})


def _kept(parser, checkpoint, folder, who):
    """Arguments of the run that left a checkpoint in a folder."""
    file = os.path.join(folder, ARGUMENTS)
    if not os.path.isfile(checkpoint):
        parser.error(f"{who}: there is no such file")
    try:
        with open(file) as text:
            kept = json.load(text)
    except (OSError, ValueError):
        parser.error(
            f"{who}: there is no {ARGUMENTS} of its run beside it, or none that can be read; give the "
            f"checkpoint in the folder of its run"
        )
    if os.path.getmtime(checkpoint) < os.path.getmtime(file):
        parser.error(f"{who} is older than the run in that folder, which has left no checkpoint yet")
    if os.path.abspath(kept["out"]) != folder:
        parser.error(
            f"{who}: its run writes to '{kept['out']}', which from here is another folder; resume it from "
            f"where it was started, and leave the results in their place"
        )
    return kept
