# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters of a scene, declared once: the command line, --help, checks, tables of cases and studies are
made from that."""

import argparse
import contextlib
import io

from ..base.kinds import DICT, FLAG, FUNCTION, TEXT, TEXTS, takes
from .commandLine import Parser


class Parameters:
    """The parameters of a scene: from them its command line, and its cases in a study.

    Parameters
    ----------
    scene : str, name; results go to results/NAME.
    doc : str, docstring of the scene, its description.
    parameters : Parameter, in the order of --help.
    smoke : dict name -> default beside --smoke.
    fixed : dict name -> value, or function of the arguments, of what the scene uses and its command line
        does not have; a study of the scene may offer it with `extended`.
    derived : dict name -> function of the arguments: what follows from them, also where a run is resumed
        with another end.
    check : function of the arguments that returns what is wrong with them in words, or None.
    resume : names that a run may change when it is resumed; default None: it cannot be.
    threads : as of `commandLine.Parser`.
    """

    @takes(
        scene=TEXT, doc=TEXT, smoke=DICT, fixed=DICT, derived=DICT, check=FUNCTION, resume=TEXTS, threads=FLAG
    )
    def __init__(
        self,
        scene,
        doc,
        *parameters,
        smoke=None,
        fixed=None,
        derived=None,
        check=None,
        resume=None,
        threads=True,
    ):
        self.scene, self.doc = scene, doc
        self.all = {p.name: p for p in parameters}
        self.smoke, self.fixed, self.derived = dict(smoke or {}), dict(fixed or {}), dict(derived or {})
        self.check, self.resume, self.threads = check, resume, threads
        unknown = set(self.smoke) - set(self.all) - set(self.fixed)
        if unknown:
            raise ValueError(f"Parameters of {scene}: smoke names {sorted(unknown)}, which it does not have")

    def __iter__(self):
        return iter(self.all.values())

    def __getitem__(self, name):
        return self.all[name]

    def extended(self, scene, doc, *parameters, **changes):
        """Those of a study of the scene: with other names and more parameters.

        Parameters
        ----------
        scene, doc, parameters : as of the class; parameters of the same name replace those of the scene.
        changes : `smoke`, `fixed`, `derived`, `check`, `resume`, which replace those of the scene (dicts:
            entries of them).
        """
        given = dict(check=changes.get("check", self.check), resume=changes.get("resume", self.resume))
        for name in ("smoke", "fixed", "derived"):
            given[name] = {**vars(self)[name], **changes.get(name, {})}
        more = {**self.all, **{p.name: p for p in parameters}}
        return Parameters(scene, doc, *more.values(), threads=self.threads, **given)

    def parser(self):
        """The command line."""
        parser = Parser(self.scene, self.doc, self.smoke, threads=self.threads, resume=self.resume)
        for parameter in self.all.values():
            parameter.addTo(parser)
        defaults = {**self.fixed, **{p.name: p.default for p in self}}
        # argparse would call a function that is a default's type on a text only, but shows defaults.
        parser.set_defaults(**defaults)
        return parser

    @takes(words=TEXTS)
    def parse(self, words=None):
        """Arguments of a command line, a list of words (default: of the program), as a namespace; with
        --resume those of the run continued. What is wrong ends the program with a message."""
        if self._readFrom is not None and words is None:
            raise ValueError(
                f"{self._readFrom}: it runs when it is read, for a study: parses its command line; put what "
                "runs below `if __name__ == '__main__':`, see doc/howto/studies.md"
            )
        parser = self.parser()
        a = parser.parse(words)
        isNew = not getattr(a, "resume", None)
        if isNew:
            for parameter in self:
                if parameter.sets and getattr(a, parameter.name):
                    parser.fill(a, words, **parameter.sets)
        values = _Resolving({**vars(a), **self.derived})
        a = argparse.Namespace(**{name: getattr(values, name) for name in (*vars(a), *self.derived)})
        wrong = self.check(a, parser.given(words)) if self.check else None
        if wrong:
            parser.error(wrong)
        return a

    _readFrom = None  # file of the scene that is read now, not run

    @classmethod
    @contextlib.contextmanager
    def _notParsed(cls, file):
        """While a file is read for what it declares: a command line that it parses then is an error."""
        cls._readFrom = file
        try:
            yield
        finally:
            cls._readFrom = None

    @takes(words=TEXTS)
    def problem(self, words):
        """What a command line has that is not allowed, in words; None: nothing."""
        said = io.StringIO()
        try:
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
                self.parse(words)
        except SystemExit:
            return said.getvalue().strip().rpartition("error: ")[2]
        return None

    @takes(values=DICT)
    def words(self, values):
        """Command line of a dict name -> value; ValueError for a name or value that is not allowed."""
        words = []
        for name, value in values.items():
            parameter = self._named(name)
            if parameter.isSwitch:
                words += [parameter.option] if parameter.value(str(value)) else []
            elif parameter.several:
                words += [parameter.option, *map(str, value if isinstance(value, list) else [value])]
            elif value is not None:
                text = repr(value) if isinstance(value, float) else str(value)
                words += [f"{parameter.option}={text}"] if text.startswith("-") else [parameter.option, text]
        return words

    @takes(name=TEXT, text=TEXT)
    def read(self, name, text):
        """Value of the text for a parameter; ValueError, with what is allowed."""
        parameter = self._named(name)
        try:
            return parameter.value(text)
        except argparse.ArgumentTypeError as error:
            raise ValueError(f"{self.scene}: {parameter.option}: {error}") from None

    def _named(self, name):
        if name not in self.all:
            raise ValueError(
                f"{self.scene}: there is no parameter '{name}'; it has {', '.join(sorted(self.all))}"
            )
        return self.all[name]


class _Resolving:
    """Values of arguments, where those that are functions of others are found when they are asked for."""

    def __init__(self, values):
        self._values = values

    def __getattr__(self, name):
        value = self._values[name]
        if callable(value):
            self._values[name] = None  # one that needs itself finds nothing
            value = self._values[name] = value(self)
        return value
