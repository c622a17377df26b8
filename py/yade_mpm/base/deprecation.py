# SPDX-License-Identifier: GPL-2.0-or-later
"""Old spellings, which run through one minor version, with a warning that says what to write."""

from .warn import warnUser

LAST = "0.3"  # the minor version that is the last to know them


def warnDeprecated(old, new):
    """Warns in the user's own line that an old spelling goes, and says what to write."""
    warnUser(f"{old} is deprecated, and version {LAST} is the last to know it; {new}", DeprecationWarning)


def currentName(kind, name):
    """The name that an attribute of a class has now, None for one that never had another; warns.

    A class says in `_renamed` which of its names were others: a dict old -> new.
    """
    new = kind._renamed.get(name)
    if new is not None:
        what = f"it is internal, {new} for now" if new.startswith("_") else f"write {new}"
        warnDeprecated(f"{kind.__name__}.{name}", what)
    return new


def currentKeywords(who, renamed, given):
    """Keyword arguments by the names that they have now; warns of old ones.

    Parameters
    ----------
    who : str, whose arguments they are. renamed : dict old -> new. given : dict of the arguments.

    Raises TypeError where an argument is given by both names.
    """
    current = {}
    for name, value in given.items():
        new = renamed.get(name, name)
        if new != name:
            warnDeprecated(f"{who}({name}=...)", f"write {new}=...")
            if new in given:
                raise TypeError(f"{who}: {name} and {new} are one argument; give {new}")
        current[new] = value
    return current
