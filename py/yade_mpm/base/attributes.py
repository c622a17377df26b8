# SPDX-License-Identifier: GPL-2.0-or-later
"""Python faces of the solver's classes, made from their parameter lists.

A material, particle type or engine registered in C++ appears here as a class with keyword arguments,
checked attributes and a docstring; no other file names it.
"""

import inspect
from typing import TYPE_CHECKING

import numpy as np

from .deprecation import currentKeywords, currentName
from .html import card, table
from .keywords import refuseUnknown
from .research import OPTIONS, SELDOM, SET_BY_METHODS, hiddenOf
from .wording import didYouMean, shortened, shown

whenSet = []  # functions without argument, called when an attribute of a material, an engine ... was set


def keep(guarded, **values):
    """Sets attributes of a Guarded object that users may only read."""
    vars(guarded).update(values)


def ofCore(name, doc):
    """Property that the solver's object has under a name."""
    return property(lambda self: getattr(self._core, name), doc=doc)


class Guarded:
    """Object of which users set properties only, those that have a setter; it is neither copied nor pickled.

    The AttributeError says that an attribute is read only, names the nearest one, or where the wanted one is.
    """

    _elsewhere = {}  # name that users look for here -> what to do instead
    _instead = "make another one"  # of a copy
    _renamed = {}  # old names of attributes: old -> new

    def __reduce__(self):
        kind = type(self).__name__
        raise TypeError(f"{kind}: it cannot be copied or pickled; {self._instead}")

    def __dir__(self):
        kind = type(self)
        return sorted(set(super().__dir__()) - hiddenOf(kind) - set(SELDOM.get(kind.__name__, ())))

    if not TYPE_CHECKING:  # for type checkers a name that is not declared is an error

        def __getattr__(self, name):
            if name.startswith("_"):
                raise AttributeError(name)
            if (current := currentName(type(self), name)) is not None:
                return getattr(self, current)
            raise AttributeError(f"{type(self).__name__} has no attribute '{name}'{self._hint(name)}")

    def _hint(self, name):
        """What to do about an attribute that does not exist."""
        if name in self._elsewhere:
            return f"; {self._elsewhere[name]}"
        return didYouMean(name, [n for n in (*dir(self), *dir(type(self))) if n[0] != "_"])

    def __setattr__(self, name, value):
        kind = type(self)
        name = currentName(kind, name) or name
        if not (name.startswith("_") or isinstance(getattr(kind, name, None), property)):
            if name in self.__dict__ or hasattr(kind, name):
                hint = f"; {self._elsewhere[name]}" if name in self._elsewhere else ""
                raise AttributeError(f"{kind.__name__}: {name} can be read, not set{hint}")
            raise AttributeError(f"{kind.__name__} has no attribute '{name}'{self._hint(name)}")
        if isinstance(of := getattr(kind, name, None), property) and of.fset is None:
            raise AttributeError(f"{kind.__name__}: {name} can be read, not set")
        object.__setattr__(self, name, value)


class Attributed:
    """Object whose attributes are the parameter list of a C++ class.

    Keyword arguments and later assignments are checked at once; ValueError says what is allowed, TypeError of
    an unknown keyword and AttributeError of an unknown attribute which one was meant.
    """

    _make = None  # name -> C++ object
    _found = ()  # sums that a run continues: only a checkpoint sets them
    _coreName = None
    _usedBy = None  # name of the body made with it
    _fixed = ()  # attributes that cannot change from then on; None: all
    _renamed = {}  # old names of attributes: old -> new
    _hooks = ("restoreState", "state")  # what engines and types offer to the scene, not to users

    def __init_subclass__(cls, **options):
        """Gives a class the signature that its parameter list makes, for help and completion."""
        super().__init_subclass__(**options)
        if cls._coreName is not None:
            cls.__signature__ = signatureOf(cls)

    def __init__(self, **attributes):
        object.__setattr__(self, "_core", type(self)._make(type(self)._coreName))
        for name, value in self._checked(attributes).items():
            self._assign(name, value)
        self._core.finish()

    def _checked(self, attributes):
        """Keyword arguments by their present names; TypeError for one that there is not."""
        kind = type(self)
        attributes = currentKeywords(kind.__name__, self._renamed, attributes)
        allowed = [*_ownArguments(kind), *self._attributeNames()]
        refuseUnknown(kind.__name__, attributes, allowed, {*hiddenOf(kind), *self._found})
        return attributes

    def __reduce__(self):
        """Copies and pickles are refused: they would go on sharing values and results with the first one."""
        kind = type(self).__name__
        raise TypeError(f"{kind}: it cannot be copied; make another one, e.g. {kind}(**one.attributes())")

    def __setattr__(self, name, value):
        if name.startswith("_") or isinstance(getattr(type(self), name, None), property):
            object.__setattr__(self, name, value)
            return
        name = currentName(type(self), name) or name
        before = getattr(self, name) if name in self._attributeNames() else None
        self._assign(name, value)
        try:
            self._core.finish()
            self._refuseFixed(name, before)
        except ValueError:
            self._assign(name, before)
            self._core.finish()
            raise
        for tell in whenSet:
            tell()

    def _assign(self, name, value):
        """Gives the core a value; None takes it back where the default is "not given"."""
        if name not in self._attributeNames():
            kind, taken = type(self).__name__, _ownArguments(type(self))
            if name in taken:
                others = ", ".join(map(repr, self._attributeNames()))
                raise ValueError(
                    f"{kind}: {name} is an argument of {kind}(...) and cannot be set afterwards; make "
                    f"another one, or set one of {others}"
                )
            if name in self._found:
                raise ValueError(f"{kind}: {name} is what a run has found; it can be read, not set")
            known = [*taken, *self._attributeNames()]
            raise AttributeError(
                f"{kind} has no attribute '{name}'{didYouMean(name, known)} "
                f"(allowed: {', '.join(map(repr, known))})"
            )
        if value is None and self._make is not None and self._make(self._coreName).value(name) is None:
            self._core.clear(name)
        else:
            try:
                value = plain(value)
            except RecursionError:
                raise ValueError(
                    f"{type(self).__name__}: {name} is nested too deeply; give numbers"
                ) from None
            try:
                self._core.set(name, value)
            except ValueError as error:
                raise ValueError(shortened(str(error))) from None

    def _refuseFixed(self, name, before):
        isFixed = self._usedBy is not None and (self._fixed is None or name in self._fixed)
        if isFixed and getattr(self, name) != before:
            raise ValueError(
                f"{type(self).__name__}: {name} = {shown(before)} cannot change any more, the particles of "
                f"'{self._usedBy}' were made with it; set it before scene.add"
            )

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._core.value(name)
        except ValueError:
            if (current := currentName(type(self), name)) is not None:
                return getattr(self, current)
            raise AttributeError(
                f"{type(self).__name__} has no attribute '{name}'{didYouMean(name, dir(self))}"
            ) from None

    def _markUsed(self, name):
        """Called when the body of that name was made with it: what is fixed cannot change from then on."""
        self._usedBy = name

    def _attributeNames(self):
        """Names of all attributes."""
        return [p["name"] for p in _hiddenOf(type(self), self._core)]

    def state(self):
        """Dict of what the solver keeps between steps besides the attributes, for checkpoints."""
        return {name: value for name in self._found if (value := self._core.value(name)) not in (None, ())}

    def restoreState(self, state, attributes=None):
        """Sets what `state` and `attributes` have given, read from a checkpoint: at once, for one has to fit
        the other."""
        for name, value in state.items():
            if name not in self._found:
                raise ValueError(f"{type(self).__name__}: '{name}' is none of its state")
            self._core.set(name, plain(value))
        for name, value in (attributes or {}).items():
            self._assign(name, value)
        self._core.finish()

    def attributes(self):
        """Dict of all attributes that have a value."""
        values = {name: self._core.value(name) for name in self._attributeNames()}
        return {name: value for name, value in values.items() if value is not None and value != ()}

    def __dir__(self):
        hidden = {*hiddenOf(type(self)), *self._hooks}
        return sorted({*super().__dir__(), *self._attributeNames()} - hidden)

    def __repr__(self):
        told = {k: v for k, v in self.attributes().items() if (k, v) not in (("label", ""), ("dead", False))}
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in told.items())})"

    def _repr_html_(self):
        """Card for a notebook: every attribute that has a value, with its unit and meaning."""
        values = self.attributes()
        rows = [
            (p["name"], values[p["name"]], p["unit"].replace("-", ""), p["doc"])
            for p in _hiddenOf(type(self), self._core)
            if p["name"] in values
        ]
        return card(type(self).__name__, table(("attribute", "value", "unit", "meaning"), rows))


def _ownArguments(cls):
    """Names of the arguments of a class that are no attributes of the core."""
    parameters = inspect.signature(cls.__init__).parameters
    return [n for n, p in parameters.items() if n != "self" and p.kind is not p.VAR_KEYWORD]


def signatureOf(cls):
    """Signature of a class: arguments of its own, then the attributes as keywords with their defaults,
    without what help leaves out."""
    own = [
        p
        for p in inspect.signature(cls.__init__).parameters.values()
        if p.name != "self" and p.kind is not p.VAR_KEYWORD
    ]
    taken = {p.name for p in own} | hiddenOf(cls)
    attributes = [
        inspect.Parameter(p["name"], inspect.Parameter.KEYWORD_ONLY, default=p["default"])
        for p in _hiddenOf(cls, cls._make(cls._coreName))
        if p["name"] not in taken
    ]
    return inspect.Signature([*own, *attributes])


def _hiddenOf(cls, core):
    """Parameters that users set."""
    return [p for p in core.parameters() if p["name"] not in cls._found]


def plain(value):
    """Arrays as lists and NumPy scalars as Python numbers, which is what the core reads."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, dict):
        return {name: plain(entries) for name, entries in value.items()}
    return value


def makeClass(name, make, base=Attributed, state=()):
    """Class `name` whose instances are made by make(name); its docstring lists attribute, default, unit,
    meaning. state : names of parameters that are no attributes."""
    core = make(name)
    hidden = {*OPTIONS.get(name, ()), *SET_BY_METHODS.get(name, ())}
    lines = [core.doc, "", "Attributes", "----------"]
    for p in core.parameters():
        if p["name"] in state or p["name"] in hidden:
            continue
        default = None if p["default"] == () else p["default"]
        unit = f", {p['unit']}" if p["unit"] not in ("", "-") else ""
        allowed = (
            f" One of {', '.join(p['choices'])}."
            if p["choices"]
            else f" Allowed: {p['allowed']}."
            if p["isNumber"]
            else ""
        ) + (" May vary in space." if p.get("mayVary") else "")
        lines.append(f"{p['name']} : default {default!r}{unit}\n    {p['doc'].rstrip('.')}.{allowed}")
    return type(
        name,
        (base,),
        {
            "__doc__": "\n".join(lines),
            "_make": staticmethod(make),
            "_coreName": name,
            "_found": state,
            "__module__": "yade_mpm",
        },
    )


def makeClasses(names, make, base=Attributed, states=None):
    """Dict name -> class for all registered names. states : dict name -> parameters that are none."""
    return {name: makeClass(name, make, base, (states or {}).get(name, ())) for name in names}


def classAttribute(classes):
    """The `__getattr__` of a module that has classes by their names in a dict, later ones too."""

    def find(name):
        try:
            return classes[name]
        except KeyError:
            raise AttributeError(f"there is no class {name}") from None

    return find
