# SPDX-License-Identifier: GPL-2.0-or-later
"""Python faces of the solver's classes, made from their parameter lists.

A material, particle type or engine registered in C++ appears here as a class with keyword arguments,
checked attributes and a docstring; no other file names it.
"""
import numpy as np


class Attributed:
    """Object whose attributes are the parameter list of a C++ class.

    Keyword arguments and later assignments are checked at once; ValueError says what is allowed.
    """

    _make = None  # name -> C++ object
    _coreName = None

    def __init__(self, **attributes):
        object.__setattr__(self, "core", type(self)._make(type(self)._coreName))
        for name, value in attributes.items():
            self.core.set(name, _plain(value))
        self.core.finish()

    def __setattr__(self, name, value):
        if name.startswith("_") or isinstance(getattr(type(self), name, None), property):
            object.__setattr__(self, name, value)
            return
        before = getattr(self, name) if name in self.attributeNames() else None
        self.core.set(name, _plain(value))
        try:
            self.core.finish()
        except ValueError:
            if before is not None:
                self.core.set(name, before)
                self.core.finish()
            raise

    def __getattr__(self, name):
        if name.startswith("_") or name == "core":
            raise AttributeError(name)
        try:
            return self.core.value(name)
        except ValueError as error:
            raise AttributeError(str(error)) from None

    def attributeNames(self):
        """Names of all attributes."""
        return [p["name"] for p in self.core.parameters()]

    def attributes(self):
        """Dict of all attributes that have a value."""
        values = {name: self.core.value(name) for name in self.attributeNames()}
        return {name: value for name, value in values.items() if value is not None and value != ()}

    def __dir__(self):
        return [*super().__dir__(), *self.attributeNames()]

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.attributes().items())})"


def _plain(value):
    """Arrays as lists and NumPy scalars as Python numbers, which is what the core reads."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return value


def makeClass(name, make, base=Attributed):
    """Class `name` whose instances are made by make(name); its docstring lists attribute, default, unit, meaning."""
    core = make(name)
    lines = [core.doc, "", "Attributes", "----------"]
    for p in core.parameters():
        default = "required or derived" if p["default"] is None else repr(p["default"])
        unit = f", {p['unit']}" if p["unit"] not in ("", "-") else ""
        allowed = f" One of {', '.join(p['choices'])}." if p["choices"] else f" Allowed: {p['allowed']}." if p["isNumber"] else ""
        lines.append(f"{p['name']} : default {default}{unit}\n    {p['doc']}{allowed}")
    return type(name, (base,), {"__doc__": "\n".join(lines), "_make": staticmethod(make), "_coreName": name,
                                "__module__": "yade_mpm"})


def makeClasses(names, make, base=Attributed):
    """Dict name -> class for all registered names."""
    return {name: makeClass(name, make, base) for name in names}
