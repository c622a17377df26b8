# SPDX-License-Identifier: GPL-2.0-or-later
"""What the engines of a scene cost, and how well threads share it."""

from __future__ import annotations

import numpy as np

CORES = 16  # that the bound is for


class Timing(dict):
    """Dict engine -> (seconds, calls), with what limits the speed on many threads.

    Print it for a table, with shares of the work of all engines.

    threads : dict engine -> seconds in which one thread works alone, in which threads share work (the sum
        over all), and in which they wait for each other then.
    alone : share of the work that one thread does while the others wait, -.
    imbalance : time of the loops that threads share, over the time with even shares and no waiting, -.
    bound : by Amdahl's law, how many times as fast 16 threads can be as one.
    memory : what the particles hold, bytes.
    bandwidth : bytes per second of the steps, if a step reads and writes all that the particles hold once;
        it reads more of it twice. Where more threads do not raise it, memory sets the speed.

    `alone`, `imbalance` and `bound` are None before a run on two threads or more, `bandwidth` before a run.
    """

    def __init__(self, times, threads, memory):
        super().__init__(times)
        self.threads, self.memory = threads, memory
        seconds, steps = sum(t for t, _ in self.values()), max(n for _, n in self.values())
        self.bandwidth = 2 * memory * steps / seconds if seconds else None
        alone, busy, waiting = map(sum, zip(*self.threads.values()))
        isMeasured = busy > 0
        self.alone = alone / (alone + busy) if isMeasured else None
        self.imbalance = (busy + waiting) / busy if isMeasured else None
        self.bound = 1 / (self.alone + (1 - self.alone) / CORES) if isMeasured else None

    def since(self, earlier: Timing) -> Timing:
        """What has come since an earlier call of `scene.timing`. A first step sorts all particles."""

        def less(now, before):  # an engine may have been added between the two
            return {n: tuple(np.subtract(now[n], before.get(n, 0)).tolist()) for n in now}

        return Timing(less(self, earlier), less(self.threads, earlier.threads), self.memory)

    def __repr__(self):
        width = max(map(len, self))
        lines = [f"{'':{width}} {'seconds':>9} {'calls':>8} {'one thread':>11} {'waiting':>8}"]
        work = sum(alone + busy for alone, busy, _ in self.threads.values())
        for name, (seconds, calls) in self.items():
            alone, _, waiting = self.threads[name]
            shares = (f"{x / work:.1%}" if work else "" for x in (alone, waiting))
            lines.append("{:{}} {:9.3f} {:8} {:>11} {:>8}".format(name, width, seconds, calls, *shares))
        return "\n".join([*lines, self.line()])

    def line(self):
        """What limits the speed on many threads, in one line."""
        memory = f"; memory: at least {self.bandwidth / 1e9:.2g} GB/s" if self.bandwidth else ""
        if self.alone is None:
            return f"threads: not measured; run on two or more{memory}"
        return (
            f"threads: one does {self.alone:.1%} of the work alone, loops last {self.imbalance:.2f} times as "
            f"long as with even shares; {CORES} threads are at most {self.bound:.1f} times as fast as one"
            + memory
        )
