# SPDX-License-Identifier: GPL-2.0-or-later
"""Numbers on a command line, and what is allowed of them, for argparse's `type`."""

import argparse
from math import inf, isfinite

from ..base.kinds import NUMBER, POSITIVE, TEXT, takes


class Range:
    """Function of a text that returns the number in it, or raises argparse.ArgumentTypeError with what is
    allowed.

    least, most, above, below : ends of the range; above and below are not included. whole : only whole
    numbers. partOf : a length of which the number must be a whole part; it is rounded to that.
    """

    def __init__(self, least=None, most=None, above=None, below=None, whole=False, partOf=None):
        self.least, self.most, self.above, self.below = least, most, above, below
        self.whole, self.partOf = whole, partOf
        if partOf is not None:
            self.above = 0

    def words(self):
        """What is allowed, in words."""
        if self.partOf is not None:
            return f"{self.partOf:g} m divided by a whole number, e.g. {self.partOf / 16:.4g}"
        kind = "a whole number" if self.whole else "a number"
        isOpen = self.most is None and self.below is None
        if self.above == 0 and isOpen:
            return "a positive number"
        if self.least == 0 and isOpen:
            return "zero or a positive number"
        if self.least is not None and isOpen:
            return f"{kind} from {self.least:g} on"
        ends = ("from", self.least), ("above", self.above), ("to", self.most), ("to below", self.below)
        return " ".join([kind, *(f"{word} {end:g}" for word, end in ends if end is not None)])

    def allows(self, number):
        """Whether a number is in the range."""
        low = (self.least is None or number >= self.least) and (self.above is None or number > self.above)
        high = (self.most is None or number <= self.most) and (self.below is None or number < self.below)
        isWhole_ = not self.whole or number == int(number)
        return low and high and isWhole_ and (self.partOf is None or isWhole(self.partOf / number))

    @takes(text=TEXT)
    def __call__(self, text):
        try:
            number = numberIn(text)
        except ValueError:
            number = inf
        if not (isfinite(number) and self.allows(number)):
            raise argparse.ArgumentTypeError(f"{text} is not allowed; give {self.words()}")
        if self.partOf is not None:
            return self.partOf / round(self.partOf / number)
        return int(number) if self.whole else number


positive, notNegative, count = Range(above=0), Range(least=0), Range(least=1, whole=True)


@takes(least=NUMBER, most=NUMBER)
def between(least, most):
    """Takes numbers from `least` to `most`, both included."""
    return Range(least=least, most=most)


@takes(most=NUMBER)
def below(most):
    """Takes zero and numbers up to `most`, which is not included."""
    return Range(least=0, below=most)


@takes(length=POSITIVE)
def partOf(length):
    """Takes lengths (m) of which `length` is a whole number, such as cells that have to fit into it."""
    return Range(partOf=length)


@takes(ratio=NUMBER)
def isWhole(ratio):
    """Whether a ratio of two lengths is a whole number from 1 on, but for round-off."""
    return isfinite(ratio) and round(ratio) >= 1 and abs(ratio - round(ratio)) < 1e-6


def numberIn(text):
    """The number that a text is, of the digits 0 to 9 and without `_`; ValueError where it is none."""
    if "_" in text or not text.isascii():
        raise ValueError(f"{text} is no number")
    return float(text)
