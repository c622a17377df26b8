# SPDX-License-Identifier: GPL-2.0-or-later
"""Errors from the inside, in the words of the outside: who, what was given, what is allowed, what to do.

What the package and the solver refuse says so already. A TypeError of Python, NumPy or Boost.Python, for an
argument that nobody thought of, does not: at the public surface it becomes one that does, with the first one
as its cause. Errors in code of the user, such as callbacks, pass as they are.

An error in words ends its traceback at the user's own line, which it tells what to do about.
YADE_MPM_TRACEBACKS=whole in the environment shows all of it, for work on the package.
"""

import dis
import functools
import inspect
import os
import sys
from dataclasses import FrozenInstanceError

from .wording import LONGEST, shortened, wordsFor

PACKAGE = __name__.split(".")[0]
USED = {"numpy", "scipy", "h5py", "matplotlib", "mpl_toolkits", "meshio", "tqdm", "rich", "PIL"}
LIBRARIES = {PACKAGE, *USED, *sys.stdlib_module_names}  # whose errors are not the user's own
# Methods that users call by operators, or by making an object.
OPERATORS = {
    f"__{name}__"
    for name in ["init", "call", "getitem", "setitem", "setattr", "contains", "add", "sub", "and", "or"]
}
RAISE = dis.opmap["RAISE_VARARGS"]  # the statement `raise`


def makeClear(namespace):
    """Public functions and classes of this package in a namespace, e.g. globals(), raise errors in words from
    now on; where they are defined, too."""
    for name, thing in list(namespace.items()):
        if name.startswith("_") or not str(getattr(thing, "__module__", "")).startswith(PACKAGE):
            continue
        if inspect.isclass(thing):
            for one in thing.__mro__:
                if one.__module__.startswith(PACKAGE) and not issubclass(one, BaseException):
                    _makeClassClear(one)
        elif inspect.isfunction(thing):
            namespace[name] = clear = _clear(thing, name)
            home = vars(sys.modules[thing.__module__])
            if home.get(thing.__name__) is thing:
                home[thing.__name__] = clear


def _makeClassClear(owner):
    for name, thing in list(vars(owner).items()):
        if name.startswith("_") and name not in OPERATORS:
            continue
        if inspect.isfunction(thing):
            setattr(owner, name, _clear(thing, name, owner))
        elif isinstance(thing, classmethod):
            setattr(owner, name, classmethod(_clear(thing.__func__, name, owner)))
        elif isinstance(thing, staticmethod):
            setattr(owner, name, staticmethod(_clear(thing.__func__, name)))
        elif isinstance(thing, property) and thing.fset and owner.__setattr__ is object.__setattr__:
            setattr(owner, name, property(thing.fget, _clear(thing.fset, name, owner), None, thing.__doc__))


def _clear(function, name, owner=None):
    """The function, with errors in words."""
    if hasattr(function, "isClear"):
        return function

    @functools.wraps(function)
    def clear(*arguments, **named):
        __tracebackhide__ = True  # IPython and pytest leave this function out
        try:
            return function(*arguments, **named)
        except Exception as error:
            frame = sys._getframe()
            _hide(frame.f_code, error.__traceback__)
            # The package itself needs no words: whoever called it from outside has better ones.
            if _library(frame.f_back) == PACKAGE:
                raise
            if not _isFromInside(error):
                _endHere(error.__traceback__)
                raise
            raise wordsFor(error, function, name, owner, arguments, named) from error

    clear.isClear = True
    return clear


def _hide(code, traceback):
    """Takes the frames of a function out of a traceback, but for the first one."""
    while traceback.tb_next is not None:
        if traceback.tb_next.tb_frame.f_code is code:
            traceback.tb_next = traceback.tb_next.tb_next
        else:
            traceback = traceback.tb_next


def _endHere(traceback):
    """Takes what is further in out of a traceback, unless code of the user is there."""
    inner, step = set(), traceback
    while (step := step.tb_next) is not None:
        inner.add(_library(step.tb_frame))
    if inner <= LIBRARIES and os.environ.get("YADE_MPM_TRACEBACKS") != "whole":
        traceback.tb_next = None


def _library(frame):
    """Name of the package that a frame is in."""
    return frame.f_globals.get("__name__", "").split(".")[0]


def _isFromInside(error):
    """Whether an error, caught in this package, was raised neither by it in words nor by code of the user.

    One in words that is too long is cut.
    """
    if isinstance(error, (Warning, ImportError)):
        return False
    last = error.__traceback__.tb_next
    if last is None:
        return True  # the call itself: wrong arguments
    where = []
    while last is not None:
        where.append(last)
        last = last.tb_next
    if not {_library(step.tb_frame) for step in where} <= LIBRARIES:
        return False
    frame = where[-1].tb_frame
    isRaised = frame.f_code.co_code[where[-1].tb_lasti] == RAISE and not isinstance(
        error, FrozenInstanceError
    )
    # Of an attribute that the package has asked for, of an object of another kind.
    isAsked = frame.f_code.co_name == "__getattr__" and len(where) > 1
    isInWords = isRaised and _library(frame) == PACKAGE and not isAsked
    if not (isInWords or hasattr(error, "isFromSolver") or getattr(error, "filename", None) is not None):
        return True
    if len(str(error)) > LONGEST:
        error.args = tuple(shortened(a) if isinstance(a, str) else a for a in error.args)
        if isinstance(error, OSError) and isinstance(error.filename, str):
            error.filename = shortened(error.filename)
    return False
