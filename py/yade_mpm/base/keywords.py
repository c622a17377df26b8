# SPDX-License-Identifier: GPL-2.0-or-later
"""Keyword arguments: unknown ones, those that had another name, and those that help leaves out."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from .deprecation import currentKeywords
from .wording import didYouMean

F = TypeVar("F", bound=Callable[..., Any])


def refuseUnknown(who, given, allowed, hidden=()):
    """TypeError for the first argument that is neither allowed nor hidden, with the nearest one."""
    for name in given:
        if name not in allowed and name not in hidden:
            listed = ", ".join(dict.fromkeys(repr(n) for n in allowed if n not in hidden))
            raise TypeError(
                f"{who} has no argument '{name}'{didYouMean(name, [*allowed, *hidden])} (allowed: {listed})"
            )


def checked(who: str, research: Iterable[str] = (), **renamed: str) -> Callable[[F], F]:
    """Decorator of a function, or of the constructor of a class, that checks the names of its arguments.

    Parameters
    ----------
    who : str, whose arguments they are, for messages.
    research : names that work, but which signature and help leave out.
    renamed : old=new, arguments that had other names.
    """

    def decorate(function):
        signature = inspect.signature(function)
        parameters = signature.parameters.values()
        known = [p.name for p in parameters if p.name not in ("self", "scene")]

        @functools.wraps(function)
        def accepting(*arguments, **given):
            given = currentKeywords(who, renamed, given)
            refuseUnknown(who, given, known, research)
            return function(*arguments, **given)

        accepting.__signature__ = _without(research, signature)
        return accepting

    return decorate


def _without(names, signature):
    """A signature without some parameters; those behind them are then given by keyword."""
    shown, isBehind = [], False
    for p in signature.parameters.values():
        if p.name in names:
            isBehind = True
        elif isBehind and p.kind is p.POSITIONAL_OR_KEYWORD:
            shown.append(p.replace(kind=p.KEYWORD_ONLY))
        else:
            shown.append(p)
    return signature.replace(parameters=shown)
