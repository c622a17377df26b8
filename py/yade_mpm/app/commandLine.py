# SPDX-License-Identifier: GPL-2.0-or-later
"""Command lines of scenes: what they share, and how a scene ends.

    parser = app.Parser("footing", __doc__, smoke={"cell": 0.5})  # unless --cell is given
    parser.add_argument("--cell", type=app.partOf(2.0), default=0.25)
    a = parser.parse()

It is part of the package, not of scripts/, so that a copy of a scene runs in any folder, and in YADE, which
does not look beside a script.
"""

import argparse
import os
import re
import sys

from ..base import program
from ..base.kinds import DICT, FLAG, FUNCTION, TEXT, TEXTS, takes
from ..base.wording import didYouMean
from .numbers import count
from .resume import resumed

SMOKE = "coarse, thick and fast: no numbers"  # thick: a thin body is at least a cell across

CHECKED = "--smoke: the check below judges the run, not the soil; take no number from here"


def printCheck(certificate):
    """Prints the quasi-static check of a run; with --smoke first what it does not say."""
    print(*[CHECKED] * program.isSmoke, certificate, sep="\n", flush=True)


NEGATIVE = re.compile(r"-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")


class Parser(argparse.ArgumentParser):
    """Command line of a scene, with --smoke, --threads, --out and, where the scene can be resumed, --resume.

    name : of the scene; results go to results/NAME. doc : docstring of the scene, its description. smoke :
    dict argument -> its default beside --smoke. threads : whether the scene takes a number of threads;
    default True. resume : names of the arguments that a run may change when it is resumed; default None: it
    cannot be.
    """

    @takes(name=TEXT, doc=TEXT, smoke=DICT, threads=FLAG, resume=TEXTS)
    def __init__(self, name, doc, smoke, threads=True, resume=None):
        super().__init__(
            prog=name,
            description=doc,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        self._negative_number_matcher = NEGATIVE  # argparse takes -1e-5 for an option
        self._smoke, self._mayChange = smoke, resume
        self._folder = os.path.join("results", name)
        shared = self.add_argument_group("all scenes")
        shared.add_argument(
            "--smoke",
            action="store_true",
            help=f"{SMOKE}; where nothing else is given: " + ", ".join(map(_pair, smoke.items())),
        )
        if threads:
            shared.add_argument("--threads", type=count, help="number of threads (default: automatic)")
        # With --resume the default is the folder of the run.
        shared.add_argument("--out", help=f"folder of the results (default {self._folder})")
        if resume is not None:
            shared.add_argument("--resume", metavar="CHECKPOINT", help=self._resumeHelp())

    def _resumeHelp(self):
        changed = ", ".join(f"--{name}" for name in (*self._mayChange, "threads"))
        return (
            "continue the run that left this checkpoint in the folder of its results, with its arguments; "
            f"of others only {changed} may be given"
        )

    def error(self, message):
        """Ends the program with a message, and for an unknown option the nearest known one."""
        unknown = re.findall(r"--[\w-]+", message) if message.startswith("unrecognized arguments") else []
        hints = {didYouMean(name, self._option_string_actions).strip("; ") for name in unknown} - {""}
        super().error("; ".join([message, *sorted(hints)]))

    def parse(self, words=None):
        """Arguments of a command line, a list of words (default: of the program); with --resume those of
        the run continued."""
        a = self.parse_args(words)
        if a.smoke:
            self.set_defaults(**self._smoke)
            a = self.parse_args(words)
        if self._mayChange is not None and a.resume:
            return resumed(self, a, self.given(words), self._mayChange)
        a.out = a.out or self._folder
        return a

    def given(self, words=None):
        """Names of the arguments that stand on the command line, whatever their values."""
        nothing = object()
        a = self.parse_args(words, argparse.Namespace(**dict.fromkeys(vars(self.parse_args(words)), nothing)))
        return {name for name, value in vars(a).items() if value is not nothing}

    def fill(self, a, words, **values):
        """Gives values to arguments that stand neither on the command line nor among those of --smoke."""
        known = self.given(words) | (set(self._smoke) if a.smoke else set())
        vars(a).update({name: value for name, value in values.items() if name not in known})

    def refuseBeside(self, words, option, names, why):
        """Ends the program if any of the arguments `names` is given beside `option`, which takes no notice
        of them."""
        for name in sorted(self.given(words) & set(names)):
            self.error(f"--{name.replace('_', '-')} has no meaning beside {option}: {why}")


def _pair(item):
    """An argument and its value in words."""
    name, value = item
    values = value if isinstance(value, list) else [value]
    return f"{name} " + " ".join(f"{v:.7g}" if isinstance(v, float) else str(v) for v in values)


@takes(main=FUNCTION)
def run(main):
    """Calls the main function of a scene. What this package refuses or cannot go on with, and files that
    fail, end the program with their message and 1, Ctrl-C ends it with 130; any other error keeps its
    traceback. Pictures go to files, never to a screen."""
    _drawToFiles()
    program.isSmoke = "--smoke" in sys.argv
    try:
        main()
        if program.isSmoke:
            print(f"--smoke: {SMOKE}")
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    except (ValueError, RuntimeError, OSError, ImportError) as error:
        if not (isinstance(error, OSError) or _isOfPackage(error)):
            raise
        raise SystemExit(f"{os.path.splitext(os.path.basename(sys.argv[0]))[0]}: {error}") from None


def _drawToFiles():
    """Pictures go to files. matplotlib, which takes longer to import than all else, is left to scenes that
    draw."""
    program.drawsToFiles = True
    if "matplotlib.pyplot" in sys.modules:
        from ..plot.figures import drawToFiles

        drawToFiles()
    else:
        os.environ["MPLBACKEND"] = "Agg"


def _isOfPackage(error):
    """Whether an error was raised in this package, or in the solver below it."""
    last = error.__traceback__
    while last.tb_next:
        last = last.tb_next
    package = os.path.dirname(os.path.dirname(__file__))
    return last.tb_frame.f_code.co_filename.startswith(package + os.sep)
