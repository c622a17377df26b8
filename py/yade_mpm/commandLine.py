# SPDX-License-Identifier: GPL-2.0-or-later
"""Command lines of scenes: numbers that argparse checks, --smoke, which arguments were given, and how a scene ends.

    parser.add_argument("--cell", type=commandLine.partOf(2.0), default=0.25)
    a = commandLine.parse(parser, words, cell=0.5)    # --smoke takes 0.5 unless --cell is given

The functions of a number are for argparse's `type`: they return it, or raise ArgumentTypeError with what is allowed.

It is part of the package, not of scripts/, so that a copy of a scene runs in any folder, and in YADE, which does not look beside a script.
"""
import argparse
import os
import sys
from math import inf, isfinite


def positive(text):
    """A number above zero."""
    return _number(text, lambda x: x > 0, "a positive number")


def notNegative(text):
    """Zero or a number above it."""
    return _number(text, lambda x: x >= 0, "zero or a positive number")


def count(text):
    """A whole number from 1 on."""
    return int(_number(text, lambda x: x >= 1 and x == int(x), "a whole number from 1 on"))


def between(least, most):
    """Function that takes numbers from `least` to `most`, both included."""
    return lambda text: _number(text, lambda x: least <= x <= most, f"a number from {least:g} to {most:g}")


def below(most):
    """Function that takes zero and numbers up to `most`, which is not included."""
    return lambda text: _number(text, lambda x: 0 <= x < most, f"a number from 0 to below {most:g}")


def partOf(length):
    """Function that takes lengths (m) of which `length` is a whole number, such as cells that have to fit into it, and rounds to the digits of that."""
    return lambda text: length / round(length / _number(text, lambda x: x > 0 and isWhole(length / x), f"{length:g} over a whole number"))


def isWhole(ratio):
    """Whether a ratio of two lengths is a whole number from 1 on, but for round-off."""
    return round(ratio) >= 1 and abs(ratio - round(ratio)) < 1e-6


def _number(text, isAllowed, allowed):
    try:
        number = float(text)
    except ValueError:
        number = inf
    if not (isfinite(number) and isAllowed(number)):
        raise argparse.ArgumentTypeError(f"{text} is not allowed; give {allowed}")
    return number


def parse(parser, words=None, **smoke):
    """Arguments of a command line (default: of the program); with --smoke the values of `smoke` are the defaults."""
    a = parser.parse_args(words)
    if a.smoke:
        parser.set_defaults(**smoke)
        a = parser.parse_args(words)
    return a


def given(parser, words=None):
    """Names of the arguments that stand on the command line (default: of the program), whatever their values."""
    nothing = object()
    a = parser.parse_args(words, argparse.Namespace(**dict.fromkeys(vars(parser.parse_args(words)), nothing)))
    return {name for name, value in vars(a).items() if value is not nothing}


def refuseBeside(parser, words, option, names, why):
    """Ends the program if any of the arguments `names` is given beside `option`, which takes no notice of them."""
    for name in sorted(given(parser, words) & set(names)):
        parser.error(f"--{name.replace('_', '-')} has no meaning beside {option}: {why}")


def run(main):
    """Calls the main function of a scene. What this package refuses or cannot go on with, and files that fail, end the program with their
    message and 1, Ctrl-C ends it with 130; any other error keeps its traceback."""
    try:
        main()
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    except (ValueError, RuntimeError, OSError) as error:
        if not (isinstance(error, OSError) or _isOfPackage(error)):
            raise
        raise SystemExit(f"{os.path.splitext(os.path.basename(sys.argv[0]))[0]}: {error}") from None


def _isOfPackage(error):
    """Whether an error was raised in this package, or in the solver below it."""
    last = error.__traceback__
    while last.tb_next:
        last = last.tb_next
    return os.path.dirname(last.tb_frame.f_code.co_filename) == os.path.dirname(__file__)
