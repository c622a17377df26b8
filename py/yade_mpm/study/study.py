# SPDX-License-Identifier: GPL-2.0-or-later
"""A study: one scene, many cases, each in a folder of its own, whatever happens to the others."""

import contextlib
import importlib.util
import os
import sys
import time
from contextlib import contextmanager, nullcontext
from functools import cached_property
from glob import escape, glob
from hashlib import sha256

from ..app.parameters import Parameters
from ..base.kinds import DICT, FILE, LIST, NUMBER, TEXTS, Kind, listOf, ofClass, takes
from ..base.warn import warnUser
from ..base.wording import shown
from ..io.files import saveJson, writeWhole
from . import cases as casesOf
from . import collect, execution, identity, report, state
from .live import Live
from .lock import Held, holding
from .optional import needed

REPORT_SHARE = 60.0  # a report that took a second to write is not written again for a minute
REPORT_PAUSE = 2.0  # s at least
SHOWN = 200  # characters of a command line

PYTHON = Kind("a function that is written in Python", lambda v: hasattr(v, "__code__"))
BUILD = Kind(
    "a function of the arguments of a case, or the file of a scene",
    lambda v: PYTHON.isOne(v) or FILE.isOne(v),
)
_AXES = Kind("", lambda v: DICT.isOne(v) and all(map(LIST.isOne, v.values())))
CASES = Kind(
    "a list of dicts, a table, or a dict name -> values",
    lambda v: hasattr(v, "to_dict") or _AXES.isOne(v) or listOf(DICT, "").isOne(v),
)
PARAMETERS = ofClass("Parameters", "a Parameters")


class Study:
    """Cases of a scene with their folders.

    Parameters
    ----------
    scene : file of a scene that has PARAMETERS; or a function of the arguments of a case, a namespace with
        `out` and `threads` besides, that returns a Scene.
    cases : list of dicts name -> value, a table (DataFrame), or a dict name -> list of values, all of whose
        combinations are run.
    out : folder of the study.
    results : function of the Scene that returns a dict of numbers; where `scene` is a function.
    until : scene time to run to, s, before `results`; None: that runs the scene itself.
    parameters : Parameters of a scene that is a function: their defaults, and what is allowed; may be None.
    words : options for the scene in all cases, such as ["--smoke"].
    threads : of each case, None: chosen. show : names of the results in the report, default the first that
        differ.

    Raises ValueError for what the scene does not allow, with the number of the case, before anything runs.
    """

    @takes(
        scene=BUILD, cases=CASES, out=FILE, results=PYTHON, until=NUMBER, parameters=PARAMETERS, words=TEXTS
    )
    def __init__(
        self, scene, cases, out, results=None, until=None, parameters=None, words=(), threads=None, show=()
    ):
        self.out, self.threads, self.show = os.path.abspath(out), threads, list(show)
        self.argumentNames, self.folders, self._numbers = set(), [], {}
        self.cases = _listed(cases)
        if not self.cases:
            raise ValueError("study: there is no case; give a table, or NAME=VALUES")
        if os.path.exists(self.out) and not os.path.isdir(self.out):
            raise ValueError(f"study: out = {shown(self.out)} is no folder; give the name of one")
        os.makedirs(os.path.join(self.out, "cases"), exist_ok=True)
        with self._holding():
            if callable(scene):
                self._ofFunction(scene, results, until, parameters)
            else:
                self._ofScene(scene, list(words))
        self.labels = dict(zip(self.folders, map(self._label, self.cases)))

    @contextmanager
    def _holding(self):
        """The folder belongs to this study alone: two would mix their cases, their table and their ends."""
        try:
            with holding(self.out, f"a study ({' '.join(sys.argv)[:SHOWN]})"):
                yield
        except Held as other:
            raise RuntimeError(
                f"study: '{self.out}' is in use by {other}; wait for its end, or give another folder (out)"
            ) from None

    def _ofScene(self, file, words):
        self.scene = findScene(file)
        self.parameters = parametersOf(self.scene)
        self.name, source = self.parameters.scene, identity.sceneSource(self.scene)
        for number, values in enumerate(self.cases, 1):
            values = {name: v for name, v in values.items() if name != casesOf.DESCRIPTION}
            own = [*words, *self.parameters.words(values)]
            wrong = self.parameters.problem(own)
            if wrong:
                label = self._label(values)
                raise ValueError(f"case {number}{f' ({label})' if label else ''}: {wrong}")
            a = vars(self.parameters.parse(own))
            known = {name: value for name, value in a.items() if name not in ("out", "resume", "threads")}
            shown = {name: a[name] for name in self.parameters.all}
            more = dict(scene=self.scene, words=own, isResumable=self.parameters.resume is not None)
            self._add(identity.identity(known, source), shown, **more)

    def _ofFunction(self, build, results, until, parameters):
        self.scene, self.parameters = None, parameters
        self.name = build.__name__ if parameters is None else parameters.scene
        pickled = needed("cloudpickle", "a study").dumps((build, results))
        file = os.path.join(self.out, f"functions-{sha256(pickled).hexdigest()[: identity.DIGITS]}.pkl")
        writeWhole(file, pickled)
        source = [identity.functionSource(f) for f in (build, results) if f] + [until]
        for values in self.cases:
            a = dict(values)
            if parameters is not None:
                a = {**vars(parameters.parse(parameters.words(values))), **values}
                a = {name: v for name, v in a.items() if name not in ("out", "resume", "threads")}
            more = dict(functions=file, until=until, path=[os.path.abspath(p) for p in sys.path if p])
            self._add(identity.identity(a, source), a, isResumable=True, **more)

    def _add(self, name, arguments, **more):
        taken = sorted(set(arguments) & set(collect.ABOUT))
        if taken:
            columns = ", ".join(collect.ABOUT)
            raise ValueError(
                f"study: a parameter is named '{taken[0]}', as a column of its table is ({columns}); give "
                f"it another name"
            )
        folder = os.path.join(self.out, "cases", name)
        number = len(self.folders) + 1
        if (same := self._numbers.setdefault(folder, number)) != number:
            raise ValueError(f"study: cases {same} and {number} are the same; give each once")
        os.makedirs(folder, exist_ok=True)
        about = dict(identity=name, code=identity.codeVersion(), arguments=arguments, threads=self.threads)
        saveJson(os.path.join(folder, state.CASE), {**about, **more}, wait=False)
        self.folders.append(folder)
        self.argumentNames |= set(arguments)

    @cached_property
    def varied(self):
        """Names of the parameters that differ between cases."""
        names = dict.fromkeys(name for case in self.cases for name in case)
        isVaried = {n: len({repr(case.get(n)) for case in self.cases}) > 1 for n in names}
        return [name for name in names if isVaried[name]]

    def _label(self, values):
        names = self.varied or list(values)
        return values.get(casesOf.DESCRIPTION) or ", ".join(
            f"{n} {values[n]:.6g}" if isinstance(values[n], float) else f"{n} {values[n]}"
            for n in names
            if n in values
        )

    @property
    def title(self):
        """Name of what is studied, and the first sentence of its description."""
        first = " ".join(
            (self.parameters.doc if self.parameters else "").strip().partition("\n\n")[0].split()
        )
        return f"Study of {self.name}" + (f": {first.partition('. ')[0].rstrip('.')}" if first else "")

    def head(self, name):
        """A parameter with its unit, or the name of a result as it is."""
        known = {} if self.parameters is None else self.parameters.all
        unit = known[name].unit if name in known else ""
        return f"{name} ({unit})" if unit else name

    def waiting(self, retry=False):
        """Folders of the cases that are to be run: not those that have ended, but with retry those that
        failed."""
        ended = (state.DONE,) if retry else state.ENDED
        return [f for f in self.folders if state.read(f)["state"] not in ended]

    def run(
        self,
        jobs=None,
        timeout=None,
        scheduler=None,
        retry=False,
        dashboard=False,
        memory=execution.MEMORY,
        quiet=False,
        pool=None,
    ):
        """Runs the cases that have not ended, and returns the table of all.

        jobs : cases at once, None: chosen. timeout : s for each. scheduler : address of a Dask scheduler.
        retry : also those that failed. dashboard : tell the address of the scheduler's. memory : GiB of a
        case. quiet : say nothing. pool : as of `execution.workers`, used instead of one of its own.

        KeyboardInterrupt after Ctrl-C; the same call goes on where it was.
        """
        with self._holding():
            return self._run(jobs, timeout, scheduler, retry, dashboard, memory, quiet, pool)

    def _run(self, jobs, timeout, scheduler, retry, dashboard, memory, quiet, pool):
        if dashboard and not scheduler:
            raise ValueError(
                "study: the dashboard is that of a Dask scheduler; give --scheduler, or leave it out"
            )
        waiting = self.waiting(retry)
        if waiting:
            jobs, threads = execution.jobsAndThreads(len(waiting), jobs, self.threads, memory)
            self._giveThreads(waiting, threads)
            with open(os.devnull, "w") as nowhere:
                live = Live({f: self.labels[f] for f in waiting}, jobs, nowhere if quiet else None)
                with execution.workers(scheduler, jobs) if pool is None else nullcontext(pool) as one:
                    if dashboard:
                        print(f"dashboard: {one.dashboard_link}", file=sys.stderr, flush=True)
                    isWhole = self._execute(one, waiting, live, timeout)
                live.bar.close()
        frame = self.write(isFinal=True)
        if waiting and not isWhole:
            raise KeyboardInterrupt
        return frame

    def _giveThreads(self, folders, threads):
        for folder in folders:
            case = state.readCase(folder)
            if case["threads"] != threads:
                saveJson(os.path.join(folder, state.CASE), {**case, "threads": threads}, wait=False)

    def _execute(self, pool, waiting, live, timeout):
        writer = _Writer(self)

        def ended(folder, at):
            live.ended(folder, at)
            writer.isNew = True

        def look():
            live.look()
            writer.look()

        for old in glob(os.path.join(escape(self.out), f"{state.STOP}*")):
            os.remove(old)
        stop = os.path.join(self.out, f"{state.STOP}-{os.uname().nodename}-{os.getpid()}")
        return execution.execute(pool, waiting, stop, timeout, ended, look)

    def write(self, isFinal=False):
        """Writes the table and the report of the cases as they are; returns the table.

        isFinal : of a run, whose results no report takes away: what goes wrong with it is a warning.
        """
        frame = collect.table(self.folders)
        collect.save(frame, self.out)
        try:
            report.write(self, frame)
        except Exception as error:
            if not isFinal:
                raise
            warnUser(f"study: the report of '{self.out}' is not written: {type(error).__name__}: {error}")
        return frame


class _Writer:
    """Rewrites table and report while cases end, but not all the time."""

    def __init__(self, study):
        self.study, self.isNew, self._next = study, False, 0.0

    def look(self):
        began = time.monotonic()
        if self.isNew and began > self._next:
            with contextlib.suppress(Exception):  # the one at the end says what is wrong
                self.study.write()
            ended = time.monotonic()
            self.isNew, self._next = False, ended + max(REPORT_PAUSE, REPORT_SHARE * (ended - began))


def _listed(cases):
    """Cases as a list of dicts."""
    if hasattr(cases, "to_dict"):  # a DataFrame
        return cases.to_dict("records")
    return casesOf.crossed(cases) if isinstance(cases, dict) else [dict(case) for case in cases]


def findScene(name):
    """File of a scene: a file, or NAME of one in a folder on Python's path, such as sheet_pile."""
    if os.path.isfile(name):
        return os.path.abspath(name)
    for folder in sys.path:
        file = os.path.join(folder, f"{name}.py")
        if folder and os.path.isfile(file):
            return os.path.abspath(file)
    raise FileNotFoundError(f"study: there is no scene {shown(name)}; give its file")


def parametersOf(file):
    """The PARAMETERS of a scene in a file."""
    name, ending = os.path.splitext(os.path.basename(file))
    if ending != ".py":
        raise ValueError(f"study: '{file}' is no scene; give the name of a Python file, which ends in .py")
    spec = importlib.util.spec_from_file_location(f"scene_{name}", file)
    module = importlib.util.module_from_spec(spec)
    with _onPath(os.path.dirname(file)), Parameters._notParsed(file):
        spec.loader.exec_module(module)
    if not hasattr(module, "PARAMETERS"):
        raise ValueError(
            f"{file} has no PARAMETERS; declare what the scene takes with yade_mpm.Parameters, see "
            f"doc/howto/studies.md"
        )
    return module.PARAMETERS


@contextmanager
def _onPath(folder):
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        sys.path.remove(folder)
