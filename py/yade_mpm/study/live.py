# SPDX-License-Identifier: GPL-2.0-or-later
"""A study as it goes, in the terminal: cases that run, that have ended, and the time left."""

import itertools
import sys
import time

from tqdm import tqdm

from . import state

LOOKED_AT = 8  # cases per job whose state is read
EVERY = 0.5  # s between looks


class Live:
    """Shows a study: a line for each case that ends, and on a terminal a bar.

    Parameters
    ----------
    labels : dict folder -> words for the case in it.
    jobs : number of cases at once.
    stream : default: standard error.
    """

    def __init__(self, labels, jobs, stream=None):
        self.labels, self.jobs, self.stream = labels, jobs, stream or sys.stderr
        self.count, self._waiting, self._last = {}, dict.fromkeys(labels), 0.0
        quiet = dict(disable=not self.stream.isatty())
        self.bar = tqdm(total=len(labels), unit="case", file=self.stream, dynamic_ncols=True, **quiet)

    def ended(self, folder, at):
        """A case has ended in a state."""
        self._waiting.pop(folder, None)
        self.count[at["state"]] = self.count.get(at["state"], 0) + 1
        message = f": {at['message'].splitlines()[-1]}" if at["message"] else ""
        seconds = f" in {at['seconds']:.1f} s" if at.get("seconds") else ""
        line = f"{sum(self.count.values())}/{len(self.labels)} {at['state']}{seconds}  {self.labels[folder]}"
        tqdm.write(line + message, file=self.stream)
        self.stream.flush()
        self.bar.update()

    def look(self):
        """Tells now and then how the cases are."""
        if time.monotonic() - self._last > EVERY:
            self._last = time.monotonic()
            self.bar.set_postfix_str(self.headline())

    def headline(self):
        """How many cases are where, and what runs."""
        first = itertools.islice(self._waiting, LOOKED_AT * self.jobs)  # they run in the order of the table
        running = [self.labels[f] for f in first if state.read(f)["state"] == state.RUNNING]
        words = [f"{n} {name}" for name, n in self.count.items()]
        words += [f"{len(running)} running", f"{len(self._waiting) - len(running)} waiting"]
        return ", ".join(words) + (f"; {', '.join(running)}" if running else "")
