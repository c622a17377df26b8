# SPDX-License-Identifier: GPL-2.0-or-later
"""Checkpoints while YADE runs: an engine at the head of O.engines saves all of it between two steps.

There every engine of YADE has the step before it, so that a run from the file takes the whole step again.
"""

import re
import sys
import time

from .commands import setCommand

SHARE = 0.01  # of the wall time that checkpoints may take
COMMAND = re.compile(r"yadeMpmSave_(\w+)\(\)")


def insert(omega, label, period):
    """Puts the engine that saves at the head of O.engines, or takes that of the label out.

    Parameters
    ----------
    omega : O of YADE. label : of the coupling.
    period : s of wall time between two checkpoints; None: there are none.
    """
    from yade.wrapper import PyRunner

    command = f"yadeMpmSave_{label}()"
    engines = [e for e in omega.engines if getattr(e, "command", "") != command]
    if period is not None:
        saver = PyRunner(command=command, realPeriod=period, label=f"{label}_Checkpoint", updateGlobals=False)
        saver.realLast = time.time()
        engines.insert(0, saver)
    if len(engines) != len(omega.engines) or period is not None:
        omega.engines = engines


def define(engines, save):
    """Makes the names in the commands of such engines known. save : function of the engine."""
    for engine in engines:
        if COMMAND.fullmatch(command := getattr(engine, "command", "")):
            setCommand(command, Saver(engine, save))


class Saver:
    """What the engine does: writes one of two files in turn, so that one is whole at any time.

    engine : of YADE. save : function of a name of a file.
    """

    def __init__(self, engine, save):
        self._engine, self._period, self._save, self._turn = engine, engine.realPeriod, save, 0

    def __call__(self):
        began, letter = time.monotonic(), "ab"[self._turn % 2]
        try:
            self._save(letter)
            self._turn += 1
        except Exception as error:
            print(f"warning: {self._engine.label}: {error}; the run goes on", file=sys.stderr)
        self._engine.realPeriod = max(self._period, (time.monotonic() - began) / SHARE)
