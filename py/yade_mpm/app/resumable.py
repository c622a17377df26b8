# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene run to its end, with its results in a folder; after Ctrl-C the run can be resumed there."""

import json
import os
import sys
import time

from ..base.kinds import DICT, FUNCTION, SCENE, takes
from ..io.files import saveJson
from ..io.history import History
from ..scene.progress import threadsInWords
from ..scene.restoring import load
from .record import record, saveHistories
from .resume import SUMMARY, keep


class Run:
    """A run of a scene, from its start or from the checkpoint of --resume.

    a : arguments, a namespace with `until` (s), `threads`, `out` and `resume` as `commandLine.Parser` gives
    them.
    begin : function without arguments that returns the scene with its output; called unless the run is
    resumed.
    callbacks : dict label -> function of the PyRunners, which a checkpoint does not keep. columns : dict of
    the columns of the History that are functions, for the same reason.
    again : checkpoint that --resume should name after an interruption, default the one in a.out.

    scene, history : of the run; history is None without one. isAtEnd : whether a resumed run had come to its
    end before.
    """

    @takes(begin=FUNCTION, callbacks=DICT, columns=DICT)
    def __init__(self, a, begin, callbacks=None, columns=None, again=None):
        if not hasattr(a, "resume") or not hasattr(a, "until"):
            raise ValueError(
                'Run: the arguments have no `until` or no `resume`; give Parameters a "until" and '
                'resume=("until",), see doc/howto/studies.md'
            )
        self.a, self.out = a, a.out
        os.makedirs(self.out, exist_ok=True)
        self._checkpoint = os.path.join(self.out, "checkpoint.h5")
        self._again = again or self._checkpoint
        if a.resume:
            self.scene = load(a.resume, callbacks=callbacks or {})
            self._checkEnd()
        else:
            keep(a)
            self.scene = begin()
            SCENE.require("Run", "what begin() returns", self.scene)
        self.history = next((e for e in self.scene.engines if isinstance(e, History)), None)
        if a.resume and columns:
            self.history.columns.update(columns)
        if a.resume and a.threads:
            self.scene.threads = a.threads
        self.seconds, self._firstStep = 0.0, self.scene.steps
        self.isAtEnd = a.until - self.scene.time < 1e-6 * (self.scene.dt or 1.0)

    def _checkEnd(self):
        scene, until = self.scene, self.a.until
        if scene.time > until + scene.dt:
            raise SystemExit(
                f"{_program()}: {self.a.resume} is at t = {scene.time:g} s and the run ends at {until:g} s; "
                f"give a later --until"
            )

    def finish(self):
        """Runs to a.until, and leaves a checkpoint; when it is interrupted it tells how to go on. Returns
        scene and history."""
        scene = self.scene
        scene.prepare()
        print(self._headline(), flush=True)
        began = time.monotonic()
        if not self.isAtEnd:
            try:
                scene.run(until=self.a.until, checkpointFile=self._checkpoint)
            except (KeyboardInterrupt, SystemExit):
                print(f"continue with: scripts/run {_program()} --resume {self._again}", file=sys.stderr)
                raise
        self.seconds = time.monotonic() - began
        if self.history is not None:
            self.history.flush()
        scene.save(self._checkpoint)
        return scene, self.history

    def _headline(self):
        scene, until = self.scene, self.a.until
        particles = ", ".join(f"{b.name} {b.count}" for b in scene.bodies)
        left = ", ".join(f"'{b.name}'" for b in scene.bodies if b.implicit)
        without = f" without {left}, implicit" if left else ""
        critical = "" if scene.dtCritical is None else f" (critical {scene.dtCritical:.3g} s{without})"
        steps = f"{round(until / scene.dt)} steps of {scene.dt:.3g} s{critical}"
        return f"{particles} particles; {steps}, {threadsInWords(scene.threads)}"

    def record(self):
        """What every summary says, see `study.record`."""
        return record(self.a, self.scene, self.seconds, self.scene.steps - self._firstStep)

    def save(self, results):
        """Writes summary.json: what every summary says, and the results. Returns it as a dict."""
        summary = {**self.record(), **results}
        if self.scene.changes:
            summary["changes"] = self.scene.changes
        saveHistories(self.out, self.scene)
        saveJson(os.path.join(self.out, SUMMARY), summary)
        return summary

    def savedSummary(self):
        """What summary.json says; None if there is none."""
        file = os.path.join(self.out, SUMMARY)
        if not os.path.exists(file):
            return None
        with open(file) as text:
            return json.load(text)


def _program():
    """Name of the scene that runs."""
    return os.path.splitext(os.path.basename(sys.argv[0]))[0]
