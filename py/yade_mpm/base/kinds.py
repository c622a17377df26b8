# SPDX-License-Identifier: GPL-2.0-or-later
"""What arguments of public functions may be, checked where they enter.

    @takes(scene=SCENE, kinetic=NUMBER)
    def unseenEnergy(scene, kinetic=None):

An argument that is left out, or given as its default, is not looked at.
"""

import functools
import inspect
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from .wording import shown

F = TypeVar("F", bound=Callable[..., Any])


class Kind:
    """What an argument may be.

    Parameters
    ----------
    words : str, what to give.
    isOne : function of a value, whether it is of the kind.
    of : Kind that it is a part of, such as the numbers that are positive.
    """

    def __init__(self, words, isOne, of=None):
        self.words, self.isOne, self.of = words, isOne, of

    def require(self, who, name, value):
        """TypeError for a value of another kind, ValueError for one of the wider kind."""
        if not self.isOne(value):
            error = ValueError if self.of and self.of.isOne(value) else TypeError
            raise error(f"{who}: {name} = {shown(value)} is not allowed; give {self.words}")

    def check(self, who, unit="", **given):
        """ValueError, which names the unit, for one of several values, by their names, of another kind."""
        for name, value in given.items():
            if not self.isOne(value):
                words = f"{self.words} ({unit})" if unit else self.words
                raise ValueError(f"{who}: {name} = {shown(value)} is not allowed; give {words}")


def takes(**kinds: Kind) -> Callable[[F], F]:
    """Decorator of a function that takes arguments of these kinds, each a `Kind` by the argument's name."""

    def decorate(function):
        path = function.__qualname__.split(".")
        who = path[-2] if path[-1] == "__init__" else path[-1]
        parameters = inspect.signature(function).parameters
        places = [name for name, p in parameters.items() if p.kind is p.POSITIONAL_OR_KEYWORD]
        defaults = {name: p.default for name, p in parameters.items() if name in kinds}

        @functools.wraps(function)
        def checked(*given, **named):
            for name, value in (*zip(places, given), *named.items()):
                if name in kinds and value is not defaults[name]:
                    kinds[name].require(who, name, value)
            return function(*given, **named)

        return checked

    return decorate


def ofClass(name, words):
    """Kind of objects of a class of this package, by its name: layers above cannot be imported here."""

    @functools.cache
    def isSubclass(kind):
        return any(c.__name__ == name and c.__module__.startswith("yade_mpm") for c in kind.__mro__)

    return Kind(words, lambda value: isSubclass(type(value)))


def listOf(kind, words, least=0):
    """Kind of lists, or alike, of so many entries or more, which are of a kind."""

    def isList(value):
        isOne = isinstance(value, (Sequence, np.ndarray, set)) and not isinstance(value, (str, bytes))
        return isOne and all(map(kind.isOne, value))

    return Kind(words, lambda value: isList(value) and len(value) >= least, Kind(words, isList))


def _isNumber(value):
    if isinstance(value, (np.generic, np.ndarray)):
        return value.ndim == 0 and value.dtype.kind in "iuf"
    return hasattr(value, "__float__") and not isinstance(value, bool)


def _isFinite(value):
    return _isNumber(value) and abs(value) <= sys.float_info.max  # a whole number may be larger


def _areNumbers(value):
    try:
        return np.ndim(value) > 0 and np.asarray(value).dtype.kind in "biuf"
    except (TypeError, ValueError):
        return False


def _isWindow(value):
    left, right, bottom, top = np.reshape(value, (-1, 4)).T
    return bool(np.isfinite(value).all() and ((left < right) & (bottom < top)).all())


SCENE = ofClass("Scene", "a Scene")
BODY = ofClass("Body", "a Body of a scene")
BODIES = listOf(BODY, "a list of bodies, such as scene.bodies")
SOME_BODIES = listOf(BODY, "one body or more in a list; leave it out for all", least=1)
_BODY_OR_NAME = Kind("", lambda value: BODY.isOne(value) or isinstance(value, str))
BODIES_OR_NAMES = listOf(_BODY_OR_NAME, "one body or more in a list, or their names; leave it out for all", 1)
ENGINE = ofClass("Engine", "an engine of the scene")
MESH = ofClass("Mesh", "a Mesh")
REGION = ofClass("Region", "a region, e.g. mpm.box(...)")
_ANY = Kind("a number", _isNumber)  # also nan, which no argument may be
NUMBER = Kind("a number", lambda value: _isNumber(value) and value == value, _ANY)
POSITIVE = Kind("a positive number", lambda value: _isFinite(value) and value > 0, _ANY)
NOT_NEGATIVE = Kind("zero or a positive number", lambda value: _isFinite(value) and value >= 0, _ANY)
FINITE = Kind("a finite number", _isFinite, _ANY)
SHARE = Kind("a number from 0 to 1", lambda value: _isNumber(value) and 0 <= value <= 1, _ANY)
NUMBERS = Kind("a list or an array of numbers", _areNumbers)
WHOLE = Kind("a whole number", lambda value: hasattr(value, "__index__") and not isinstance(value, bool))
LIST = Kind("a list", lambda v: isinstance(v, Iterable) and not isinstance(v, (str, bytes)))
_PAIR = Kind("", lambda value: NUMBERS.isOne(value) and np.shape(value) == (2,))
LIMITS = Kind("(low, high), low not above high", lambda v: _PAIR.isOne(v) and v[0] <= v[1], _PAIR)
_FOURS = Kind("", lambda value: NUMBERS.isOne(value) and np.shape(value)[-1] == 4)
WINDOW = Kind(
    "(left, right, bottom, top) in m, left below right and bottom below top, or a list of them",
    lambda value: _FOURS.isOne(value) and _isWindow(value),
    _FOURS,
)
AXES = Kind("axes of matplotlib", lambda value: hasattr(value, "add_collection"))
COUNT = Kind("a whole number from 1 on", lambda value: WHOLE.isOne(value) and value >= 1, NUMBER)
FLAG = Kind("True or False", lambda value: isinstance(value, (bool, np.bool_)))
TEXT = Kind("a text", lambda value: isinstance(value, str))
TEXTS = listOf(TEXT, "a list of texts")
_PATH = Kind("", lambda value: isinstance(value, (str, os.PathLike)))
FILE = Kind("the name of a file", lambda value: _PATH.isOne(value) and os.fspath(value) != "", _PATH)
FUNCTION = Kind("a function", callable)
DICT = Kind("a dict", lambda value: isinstance(value, Mapping))
REGIONS = Kind("a dict name -> region, of one or more", lambda v: DICT.isOne(v) and len(v) > 0, DICT)
COLUMNS = Kind("a dict name -> numbers", lambda v: hasattr(v, "keys") and hasattr(v, "__getitem__"))


def requireFile(who, file, wanted="the name of a file"):
    """The name of a file that is there; FileNotFoundError, or ValueError for a folder, a pipe or a device."""
    FILE.require(who, "file", file)
    name = os.fspath(file)
    if not os.path.exists(name):
        raise FileNotFoundError(f"{who}: there is no file {shown(os.path.abspath(name))}; give {wanted}")
    if not os.path.isfile(name):  # a pipe would wait, a device has no end
        raise ValueError(f"{who}: {shown(name)} is no regular file; give {wanted}")
    return name


def columns(who, **given):
    """Columns as arrays (N,) of floats of one length."""
    for name, value in given.items():
        NUMBERS.require(who, name, value)
    arrays = [np.asarray(value, float) for value in given.values()]
    if any(array.ndim != 1 or len(array) != len(arrays[0]) for array in arrays):
        shapes = ", ".join(f"{name} of shape {array.shape}" for name, array in zip(given, arrays))
        raise ValueError(f"{who}: {shapes} are not allowed; give columns of one length")
    return arrays
