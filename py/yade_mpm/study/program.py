# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line of studies: scripts/run study SCENE [NAME=VALUES ...] [--table FILE] [options]."""

import argparse
import os
import re
import shutil
import sys

from ..app.numbers import count, positive
from . import cases, state
from .report import FINDINGS
from .study import Study, findScene, parametersOf

DOC = """Runs a scene for many cases: in parallel, each in a process of its own, resumable.

    scripts/run study scripts/sheet_pile.py --table cases.csv --out results/mine
    scripts/run study sheet_pile_study psi=0:10:5 types=hybrid,ugimp --smoke
    scripts/run study sheet_pile_study psi=0..10 friction=0..0.5 --sample lhs:20

NAME=FROM:TO:STEP and NAME=A,B,... give all combinations, NAME=FROM..TO a range for --sample; further options
go to the scene in all cases. The same command again goes on: finished cases are kept. Results: results.csv,
report.html, and a folder for each case. doc/howto/studies.md tells more.
"""


def parser():
    """The options of studies themselves."""
    p = argparse.ArgumentParser(
        "study",
        description=DOC,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        usage="study SCENE [NAME=VALUES ...] [options] [options of the scene]",
        allow_abbrev=False,
    )
    p.add_argument("scene", help="file of the scene, or its name in scripts/")
    p.add_argument("--table", help="CSV, or a table of YADE, with a line for each case")
    p.add_argument("--sample", metavar="HOW:N", help="lhs:N (Latin hypercube) or sobol:N of the ranges")
    p.add_argument("--seed", type=int, default=0, help="of the sample (default 0)")
    p.add_argument("--out", help="folder of the study (default results/studies/SCENE)")
    p.add_argument("--jobs", type=count, help="cases at once (default: by cores and memory)")
    p.add_argument("--threads", type=count, help="of each case (default: cores over jobs)")
    p.add_argument("--memory", type=positive, default=1.0, help="GiB that a case may need (default 1)")
    p.add_argument("--timeout", type=positive, metavar="S", help="s after which a case is ended")
    p.add_argument("--retry", action="store_true", help="also run the cases that failed or timed out")
    p.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler, e.g. tcp://host:8786")
    p.add_argument("--dashboard", action="store_true", help="tell the address of the scheduler's dashboard")
    p.add_argument(
        "--show", type=lambda t: t.split(","), default=[], metavar="A,B", help="results in the report"
    )
    p.add_argument("--findings", metavar="FILE", help="text that the report begins with, in paragraphs")
    p.add_argument("--report", action="store_true", help="run nothing, write table and report again")
    yade = "write the cases as a table for yade-batch, and run nothing"
    p.add_argument("--yade-table", metavar="FILE", help=yade)
    return p


def main(words=None):
    """Runs a study from a command line; the exit code is 1 where a case has not ended well."""
    words = sys.argv[1:] if words is None else list(words)
    axes = [w for w in words if re.match(r"[A-Za-z]\w*=", w)]
    a, sceneWords = parser().parse_known_args([w for w in words if w not in axes])
    file = findScene(a.scene)
    if a.findings and not os.path.isfile(a.findings):
        raise FileNotFoundError(
            f"--findings {a.findings}: there is no such file; give a text file, or leave the option out"
        )
    parameters = parametersOf(file)
    listed = _cases(a, axes, parameters)
    if a.yade_table:
        cases.writeYadeTable(a.yade_table, listed)
        return
    out = a.out or os.path.join("results", "studies", parameters.scene)
    study = Study(file, listed, out, words=sceneWords, threads=a.threads, show=a.show)
    if a.findings:
        shutil.copyfile(a.findings, os.path.join(study.out, FINDINGS))
    if a.report:
        study.write()
    else:
        how = dict(jobs=a.jobs, timeout=a.timeout, scheduler=a.scheduler, retry=a.retry)
        try:
            study.run(**how, dashboard=a.dashboard, memory=a.memory)
        except KeyboardInterrupt:
            print("study: interrupted; give the same command to go on", file=sys.stderr)
            raise
    tell(study)


def _cases(a, axes, parameters):
    listed = cases.readTable(a.table, parameters) if a.table else [{}]
    sample = None
    if a.sample:
        how, _, number = a.sample.partition(":")
        if not number.isdigit():
            raise ValueError(f"--sample {a.sample} is not allowed; give lhs:N or sobol:N, N a whole number")
        sample = how, int(number)
    more = cases.fromWords(axes, parameters, sample, a.seed)
    return [{**one, **two} for one in listed for two in more]


def tell(study):
    """Prints how the cases have ended, and where the results are."""
    ends = [state.read(folder) for folder in study.folders]
    counted = {how: sum(at["state"] == how for at in ends) for how in sorted({at["state"] for at in ends})}
    print(", ".join(f"{n} {how}" for how, n in counted.items()) + f"; see {study.out}/report.html")
    for folder, at in zip(study.folders, ends):
        if at["state"] in (state.FAILED, state.TIMED_OUT):
            last = (at["message"].splitlines() or [""])[-1]
            print(f"  {at['state']}: {study.labels[folder]}: {last} ({folder}/{state.LOG})")
    if counted.get(state.DONE, 0) < len(ends):
        raise SystemExit(1)
