# SPDX-License-Identifier: GPL-2.0-or-later
"""Words for an error that says nothing to users: from the signature and the docstring of what they called."""

import inspect
import re
import reprlib

LONGEST = 2000  # characters of an error
MOST_SHOWN = 80  # characters of a value in it,
MOST_TOLD = 250  # of what is allowed for one argument,
MOST_REASON = 300  # and of what the inside says
MOST_ARGUMENTS = 6  # that are told of

# An entry of a docstring: names, a colon between blanks, and lines up to the next entry or an empty line.
ENTRY = r"^ *{name}\b(?:, \w+)* : (.*(?:\n(?! *\w+(?:, \w+)* : | *\n).*)*)"
FIXED = "has no setter|cannot assign to field|can't set attribute"  # an attribute, says Python
OF_THE_CLASS = ("__init__", "__setattr__", "__call__")  # which users write without a name of their own
SIGNS = {"__add__": "+", "__or__": "|", "__sub__": "-", "__and__": "&"}


def wordsFor(error, function, name, owner, arguments, named):
    """The error to raise instead: of the same kind, or the nearest one that users expect.

    Parameters
    ----------
    error : Exception, from the inside.
    function : that was called, and its name for users. owner : class that it is a method of, or None.
    arguments, named : what it was called with.
    """
    who, documented = _whoIs(name, owner, arguments)
    reason = f"{type(error).__name__}: {_reason(error)}"
    try:
        bound = inspect.signature(function).bind(*arguments, **named).arguments
    except TypeError as wrong:
        kind = type(arguments[0]) if owner is not None and arguments else owner
        text = f"{who}: {wrong}; give {_signature(function, kind, name)}"
        return TypeError(shortened(text))
    given = _flat(bound, function, owner)
    if name == "__setattr__":
        given = {given["name"]: given["value"]}
        if re.search(FIXED, str(error)):
            return AttributeError(f"{who}: {arguments[1]} can be read, not set ({reason})")
    return _kind(error)(shortened(f"{who}: {_said(given, error, reason, [function, *documented])}"))


def shortened(text, most=LONGEST):
    """A text whose middle is left out where it is too long: half of what may stay is left."""
    if len(text) <= most:
        return text
    return f"{text[: most // 4]} ... ({len(text)} characters) ... {text[-most // 4 :]}"


def shown(value):
    """A value as text, short, whatever it is."""
    try:
        return shortened(_Short().repr(value), MOST_SHOWN)
    except Exception:  # of a __repr__ of the user, too; 10**5000 has no text
        return f"<{type(value).__name__}>"


class _Short(reprlib.Repr):
    def __init__(self):
        super().__init__()
        self.maxstring = self.maxother = MOST_SHOWN
        self.maxlevel = 3


def _whoIs(name, owner, arguments):
    """Name of what was called, as users write it, and what besides it documents its arguments."""
    if owner is None:
        return name, []
    kind = type(arguments[0]) if arguments and isinstance(arguments[0], owner) else owner
    if name in SIGNS:
        return f"{shown(arguments[0])} {SIGNS[name]}", []
    return (kind.__name__ if name in OF_THE_CLASS else f"{kind.__name__}.{name}"), kind.__mro__


def _reason(error):
    text = str(error)
    if "did not match C++ signature" in text:  # Boost.Python's ArgumentError, over many lines
        text = f"the solver does not take {text.splitlines()[1].strip()}"
    return shortened(" ".join(text.split()), MOST_REASON)


def _signature(function, owner, name):
    if name == "__init__" and hasattr(owner, "__signature__"):  # made from the parameter list
        return str(owner.__signature__).replace("(*, ", "names: (")
    parameters = list(inspect.signature(function).parameters.values())[owner is not None :]
    return str(inspect.Signature(parameters)) if parameters else "no argument"


def _flat(bound, function, owner):
    """Arguments by name, those of *arguments and **named one by one, without self."""
    flat = {}
    for k, (name, value) in enumerate(bound.items()):
        kind = inspect.signature(function).parameters[name].kind
        if k == 0 and owner is not None:
            continue
        if kind is inspect.Parameter.VAR_KEYWORD:
            flat.update(value)
        elif kind is inspect.Parameter.VAR_POSITIONAL:
            flat.update({f"{name}[{i}]": v for i, v in enumerate(value)})
        else:
            flat[name] = value
    return flat


def _said(given, error, reason, documented):
    """What was given, why it is refused, what is allowed."""
    if isinstance(error, (OSError, MemoryError)):
        return f"not possible ({reason}); make room, or give another place"
    if not given:
        return (
            f"not possible as things are ({reason}); look at what the object was made with, or report it "
            f"together with the lines above"
        )
    of = getattr(error, "obj", error)  # what has no such attribute
    guilty = {n: v for n, v in given.items() if v is of} or given
    few = dict(list(guilty.items())[:MOST_ARGUMENTS])
    what = ", ".join(f"{n} = {shown(v)}" for n, v in few.items())
    more = f" and {len(guilty) - len(few)} more" if len(guilty) > len(few) else ""
    allowed = {n: text for n in few if (text := _allowed(n, documented))}
    told = (
        "; ".join(allowed.values()) if len(few) == 1 else "; ".join(f"{n}: {a}" for n, a in allowed.items())
    )
    verb = "is not allowed" if len(guilty) == 1 else "do not fit, at least one of them"
    return f"{what}{more} {verb} ({reason}); give {told or 'what its help() says'}"


def _allowed(name, documented):
    """What docstrings say of an argument; empty: nothing."""
    for thing in documented:
        own = vars(thing).get(name) if inspect.isclass(thing) else None
        doc = inspect.getdoc(own) if isinstance(own, property) else None
        if not doc:
            found = re.search(ENTRY.format(name=re.escape(name)), _doc(thing), re.MULTILINE)
            doc = found.group(1) if found else None
        if doc:
            return shortened(" ".join(doc.split()).rstrip("."), MOST_TOLD)
    return ""


def _doc(thing):
    return inspect.getdoc(thing) or ""


def _kind(error):
    """Class of the error to raise."""
    if isinstance(error, (KeyError, IndexError, MemoryError, OSError, NotImplementedError)):
        return next(
            k
            for k in (KeyError, IndexError, MemoryError, OSError, NotImplementedError)
            if isinstance(error, k)
        )
    if isinstance(error, (TypeError, AttributeError)):
        return TypeError
    isOfValues = isinstance(error, (ValueError, ArithmeticError, RecursionError))
    return ValueError if isOfValues else RuntimeError
