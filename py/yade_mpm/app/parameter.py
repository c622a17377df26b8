# SPDX-License-Identifier: GPL-2.0-or-later
"""One parameter of a scene: its name, default, unit, range and choices."""

import argparse
from itertools import islice

from ..base.kinds import DICT, FLAG, LIST, NUMBER, POSITIVE, TEXT, Kind, takes
from ..base.wording import shown
from .numbers import Range

MOST_CHOICES = 1000
PARSER = Kind("an argparse.ArgumentParser, or a group of one", lambda value: hasattr(value, "add_argument"))


class Parameter:
    """A number, a choice or a switch that a scene takes.

    Parameters
    ----------
    name : str, option of the command line without its dashes, and attribute of the arguments.
    default : number, text, True or False; None: not set; or a function of the arguments, for a default that
        follows from others. A switch has the default False and takes no value on the command line.
    help : str, what it is.
    unit : str, default "": none.
    choices : allowed texts or numbers, at most 1000; default: any.
    above, least, most, below : float, ends of the range; above and below are not included. Default: none.
    partOf : float, length of which the value must be a whole part, such as a cell that has to fit into it.
    whole : bool, only whole numbers; default False.
    several : bool, takes several values, and the default is a list; default False.
    sets : dict, of a switch: defaults of other parameters while it is on.

    Raises ValueError where the default is outside of the range, and for too many choices.
    """

    @takes(
        name=TEXT,
        help=TEXT,
        unit=TEXT,
        choices=LIST,
        above=NUMBER,
        least=NUMBER,
        most=NUMBER,
        below=NUMBER,
        partOf=POSITIVE,
        whole=FLAG,
        several=FLAG,
        sets=DICT,
    )
    def __init__(
        self,
        name,
        default,
        help="",
        *,
        unit="",
        choices=None,
        above=None,
        least=None,
        most=None,
        below=None,
        partOf=None,
        whole=False,
        several=False,
        sets=None,
    ):
        self.name, self.default, self.help, self.unit = name, default, help, unit
        self.choices = None if choices is None else self._chosen(choices)
        self._range = Range(least, most, above, below, whole, partOf)
        self.whole, self.several, self.sets = whole, several, dict(sets or {})
        if not (self.isSwitch or default is None or callable(default)):
            self._checkDefault()

    def _chosen(self, choices):
        few = tuple(islice(choices, MOST_CHOICES + 1))
        if len(few) > MOST_CHOICES:
            raise ValueError(
                f"Parameter {self.name}: more than {MOST_CHOICES} choices; give a range by `least` and "
                "`most`, with whole=True where only whole numbers are allowed"
            )
        return few

    def _checkDefault(self):
        if self.several and not LIST.isOne(self.default):
            raise ValueError(
                f"Parameter {self.name}: default = {shown(self.default)} is no list; give one, for several "
                "values"
            )
        try:
            for value in self.default if self.several else [self.default]:
                self.value(str(value))
        except argparse.ArgumentTypeError as error:
            raise ValueError(f"Parameter {self.name}: the default {error}") from None

    @property
    def isSwitch(self):
        """Whether it is on or off."""
        return isinstance(self.default, bool)

    @property
    def isNumber(self):
        """Whether its values are numbers."""
        return not self.isSwitch and (
            self.choices is None or not any(isinstance(c, str) for c in self.choices)
        )

    @property
    def option(self):
        """Name on the command line."""
        return "--" + self.name.replace("_", "-")

    def range(self):
        """What is allowed, in words."""
        if self.isSwitch:
            return "on or off"
        if self.choices is not None:
            return "one of " + ", ".join(map(str, self.choices))
        return self._range.words()

    @takes(text=TEXT)
    def value(self, text):
        """The value that a text means; argparse.ArgumentTypeError with what is allowed."""
        if self.isSwitch:
            return self._switched(text)
        if self.choices is not None:
            known = {str(c): c for c in self.choices}
            if text not in known:
                raise argparse.ArgumentTypeError(f"{text} is not allowed; give {self.range()}")
            return known[text]
        return self._range(text)

    def _switched(self, text):
        known = {"1": True, "true": True, "on": True, "yes": True}
        known |= {"0": False, "false": False, "off": False, "no": False}
        if text.lower() not in known:
            raise argparse.ArgumentTypeError(f"{text} is not allowed; give {self.range()}")
        return known[text.lower()]

    @takes(parser=PARSER)
    def addTo(self, parser):
        """Makes it an option of a command line."""
        how = dict(dest=self.name, help=self.describe())
        if self.isSwitch:
            parser.add_argument(self.option, action="store_true", **how)
            return
        if self.several:
            how["nargs"] = "+"
        if self.choices is None:
            parser.add_argument(self.option, type=self.value, metavar=self.unit or "NUMBER", **how)
        else:
            kinds = {type(c) for c in self.choices}
            kind = kinds.pop() if len(kinds) == 1 else self.value
            parser.add_argument(self.option, type=kind, choices=self.choices, **how)

    def describe(self):
        """Its line in --help."""
        words = [self.help]
        if self.sets:
            words.append("unless given: " + ", ".join(f"{n} {_shown(v)}" for n, v in self.sets.items()))
        if self.unit:
            words.append(self.unit)
        if not self.isSwitch and self.choices is None:
            words.append(self.range())
        text = "; ".join(w for w in words if w)
        if not (self.isSwitch or self.several or self.default is None or callable(self.default)):
            text += f" (default {_shown(self.default)})"
        return text.replace("%", "%%")

    def __repr__(self):
        return f"Parameter({self.name!r}, {self.default!r}, unit={self.unit!r}, {self.range()})"


def _shown(value):
    return f"{value:.7g}" if isinstance(value, float) else "see there" if callable(value) else str(value)
