# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns that users add to a history."""

import math
from collections.abc import MutableMapping

from ..base.wording import shown
from .expression import Expression

RATE = "d/dt "  # before text: of what the column has the mean rate since the row before


class Columns(dict):
    """Columns that the user adds: name, or tuple of names -> function of the scene, expression as text, or
    None (nan)."""

    def __init__(self, columns):
        super().__init__()
        self._expressions = {}
        for name, column in dict(columns).items():
            self[name] = column

    update = MutableMapping.update  # one by one, too

    def __setitem__(self, name, column):
        isText = isinstance(column, str) and not isinstance(
            name, tuple
        )  # a checkpoint keeps each text by its name
        if not (column is None or callable(column) or isText):
            orText = "" if isinstance(name, tuple) else ", or an expression as text"
            raise TypeError(
                f"History: column '{name}' = {shown(column)}; give a function of the scene{orText}"
            )
        if not all(isinstance(one, str) and one for one in namesOf(name)):
            raise TypeError(f"History: the name {shown(name)} of a column is no text; give a text")
        if any(mark in str(one) for one in namesOf(name) for mark in ',"\n'):
            raise ValueError(
                f"History: the name of column {shown(name)} may hold no comma, quote or line end"
            )
        if isText:
            self._expressions[name] = Expression(column.removeprefix(RATE), f"History: column '{name}'")
        super().__setitem__(name, column)

    def measure(self, name, scene):
        """(name, value) of a column now, or of each of several; ValueError, which ends the run, where one is
        no number or raises something."""
        column = self[name]
        if column is None:
            return [(one, math.nan) for one in namesOf(name)]
        try:
            found = self._expressions[name](scene) if isinstance(column, str) else column(scene)
            return [
                (one, float(value))
                for one, value in zip(
                    namesOf(name), found if isinstance(name, tuple) else [found], strict=True
                )
            ]
        except Exception as error:
            raise ValueError(
                f"History: column '{name}' ({column if isinstance(column, str) else 'a function'}) gives no "
                f"number: {type(error).__name__}: {error}"
            ) from error

    def rates(self):
        """Names of the columns that are rates."""
        return [name for name, column in self.items() if isinstance(column, str) and column.startswith(RATE)]


def namesOf(key):
    """Names of the columns that the user gave as one name or a tuple."""
    return key if isinstance(key, tuple) else (key,)
