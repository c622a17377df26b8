# SPDX-License-Identifier: GPL-2.0-or-later
"""How far a run is, on a terminal and elsewhere."""

import math
import sys
import time
import warnings


def significant(number):
    """A number with three digits that mean something, and no power of ten: 1680, 41.2."""
    return f"{float(f'{number:.3g}'):.15g}"


def threadsInWords(count):
    """A number of threads: "1 thread", "2 threads"."""
    return f"{count} thread{'s' if count > 1 else ''}"


class Progress:
    """A bar on a terminal and in a notebook, a line at once and now and then elsewhere.

    Parameters
    ----------
    scene : Scene
    wanted : bool, show it; None: for a run of more than 2 s.
    stepsLeft : function that returns the number of steps to the end.
    """

    WAIT = 2.0  # s before anything is shown
    LINES = 30.0  # s between lines where there is no bar

    def __init__(self, scene, wanted, stepsLeft):
        self.scene, self.wanted, self.stepsLeft = scene, wanted, stepsLeft
        self.began, self.firstStep = time.monotonic(), scene.steps
        self.bar, self.lastLine = None, -math.inf
        self.hasBar = sys.stderr.isatty() or isNotebook()

    def text(self):
        """Time, rate and number of threads."""
        steps = self.scene.steps - self.firstStep
        wall = time.monotonic() - self.began
        rate = wall / max(1, steps) / max(1, self.scene.particleCount) * 1e9
        threads = threadsInWords(self.scene._core.threads)
        return f"t = {self.scene.time:.4g} s, {significant(rate)} ns per particle-step on {threads}"

    def update(self):
        """Shows the present state; to be called between steps."""
        wall = time.monotonic() - self.began
        if self.wanted is False or (wall < self.WAIT and not self.wanted):
            return
        done, left = self.scene.steps - self.firstStep, self.stepsLeft()
        if self.hasBar:
            if self.bar is None:
                self.bar = _makeBar(done + left)
            self.bar.total = done + left
            self.bar.set_postfix_str(self.text(), refresh=False)
            self.bar.update(done - self.bar.n)
        elif wall - self.lastLine >= self.LINES or (left == 0 and self.lastLine > -math.inf):
            self.lastLine = wall
            remaining = wall / max(1, done) * left
            print(
                f"step {self.scene.steps} of {self.scene.steps + left}, {self.text()}, {remaining:.0f} s "
                "left",
                file=sys.stderr,
            )

    def say(self, message):
        """Writes a message above the bar."""
        if self.bar is not None:
            self.bar.write(message, file=sys.stderr)
        else:
            print(message, file=sys.stderr)

    def close(self):
        """Ends the bar."""
        if self.bar is not None:
            self.bar.close()
            self.bar = None


def isNotebook():
    """Whether the program is the kernel of a notebook, whose output is no terminal but shows a bar."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return type(shell).__name__ == "ZMQInteractiveShell"


def _makeBar(total):
    """A bar of tqdm: a widget in a notebook that has ipywidgets, text elsewhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that ipywidgets is not there: text does as well
        from tqdm.auto import tqdm
    isText = "notebook" not in tqdm.__module__ and not any("notebook" in c.__module__ for c in tqdm.__mro__)
    text = dict(file=sys.stderr, dynamic_ncols=True) if isText else {}
    return tqdm(total=total, unit="step", leave=True, **text)
