# SPDX-License-Identifier: GPL-2.0-or-later
"""A study as it goes, in the terminal: cases that run, that have ended, and the time left."""

import itertools
import sys
import time

from . import state

SHOWN = 12  # running cases
LOOKED_AT = 8  # cases per job whose state is read
EVERY = 0.5  # s between looks


class Live:
    """Shows a study.

    Parameters
    ----------
    labels : dict folder -> words for the case in it.
    jobs : number of cases at once.
    stream : default: standard error. On a terminal a block that is drawn anew, elsewhere a line for each case
        that ends.
    """

    def __init__(self, labels, jobs, stream=None):
        self.labels, self.jobs, self.stream = labels, jobs, stream or sys.stderr
        self.began = self._last = time.monotonic()
        self.count = dict.fromkeys((state.DONE, state.FAILED, state.TIMED_OUT, state.INTERRUPTED), 0)
        self._drawn, self._waiting = 0, dict.fromkeys(labels)
        self.isTerminal = self.stream.isatty()

    def ended(self, folder, at):
        """A case has ended in a state."""
        self._waiting.pop(folder, None)
        self.count[at["state"]] = self.count.get(at["state"], 0) + 1
        self._clear()
        message = f": {at['message'].splitlines()[-1]}" if at["message"] else ""
        seconds = f" in {at['seconds']:.1f} s" if at.get("seconds") else ""
        line = f"{sum(self.count.values())}/{len(self.labels)} {at['state']}{seconds}  {self.labels[folder]}"
        print(line + message, file=self.stream, flush=True)

    def look(self):
        """Draws the block anew, now and then."""
        if self.isTerminal and time.monotonic() - self._last > EVERY:
            self._clear()
            lines = self.lines()
            print("\n".join(lines), file=self.stream, flush=True)
            self._drawn, self._last = len(lines), time.monotonic()

    def lines(self):
        """What runs, and a line for all."""
        first = itertools.islice(self._waiting, LOOKED_AT * self.jobs)  # they run in the order of the table
        running = [(f, at) for f in first if (at := state.read(f))["state"] == state.RUNNING]
        lines = [
            f"  running {time.time() - at['began']:6.0f} s  {self.labels[f]}" for f, at in running[:SHOWN]
        ]
        if len(running) > SHOWN:
            lines.append(f"  and {len(running) - SHOWN} more")
        return [*lines, self.headline(len(running))]

    def headline(self, running):
        """How many cases are where, and the time left."""
        ended = sum(self.count.values())
        words = [f"{n} {name}" for name, n in self.count.items() if n]
        words += [f"{running} running", f"{len(self._waiting) - running} waiting"]
        left = self.secondsLeft(ended)
        return ", ".join(words) + ("" if left is None else f"; about {_duration(left)} left")

    def secondsLeft(self, ended):
        """Time left if all cases take as long as those that have ended did; None: none has."""
        if not ended:
            return None
        return (time.monotonic() - self.began) / ended * len(self._waiting)

    def _clear(self):
        if self._drawn:
            print(f"\x1b[{self._drawn}F\x1b[J", end="", file=self.stream)
            self._drawn = 0


def _duration(seconds):
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
