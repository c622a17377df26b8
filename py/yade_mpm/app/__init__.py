# SPDX-License-Identifier: GPL-2.0-or-later
"""A scene as a program: its parameters and command line, its run with --resume, its summary.

Parameter, Parameters                    what a scene takes, declared once
run(main), printCheck                    how a scene begins and ends
Run                                      a scene run to its end, its results in a folder
keep, resumed, ARGUMENTS, SUMMARY        the arguments of a run, kept beside its results
record, saveCurve                        what every summary says of a run, and curves that studies overlay
Parser, positive, count, partOf, ...     command lines by hand, and numbers that argparse checks
"""

from .commandLine import Parser, printCheck, run
from .numbers import below, between, count, isWhole, notNegative, partOf, positive
from .parameter import Parameter
from .parameters import Parameters
from .record import record, saveCurve
from .resumable import Run
from .resume import ARGUMENTS, SUMMARY, keep, resumed
