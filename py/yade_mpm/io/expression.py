# SPDX-License-Identifier: GPL-2.0-or-later
"""Expressions as text, for what a file may bring: they look at a scene, compute, and can do nothing else.

The text is parsed by `ast` and walked here, never compiled: what `language` does not name does not exist.
Arrays of a scene are given out read-only.
"""

import ast
import operator

import numpy as np

from ..base.wording import shown
from ..check import diagnostics
from .language import (
    ARRAY_ATTRIBUTES,
    ARRAY_METHODS,
    BINARY,
    COMPARE,
    CONSTANTS,
    FUNCTIONS,
    KINDS,
    METHODS,
    MOST_BITS,
    MOST_NODES,
    MOST_TEXT,
    NODES,
    NUMPY,
    SCENE_ATTRIBUTES,
    SCENE_METHODS,
    UNARY,
    isData,
    readOnly,
)


class Expression:
    """An expression of `scene`, `diagnostics` and `np`: fields, arithmetic, comparisons, indexing, sums.

    text : of the expression. who : of the error, e.g. "History: column 'toe'".

    Names that begin with an underscore, assignments, imports, lambdas, calls of anything but the functions
    of `yade_mpm.diagnostics`, plain functions of NumPy and methods that only look, do not exist:
    ValueError, which tells what is allowed. SyntaxError for text that is no expression.
    """

    def __init__(self, text, who):
        self.text, self._who = text, who
        if len(text) > MOST_TEXT:
            self._refuse(f"it has {len(text)} characters, and {MOST_TEXT} are allowed")
        try:
            self._tree = ast.parse(text, f"<{who}>", "eval")
        except SyntaxError as error:
            said = f"{who} = {shown(text)} is not allowed: {error.msg}; give an expression, or a function"
            raise SyntaxError(said, error.args[1]) from None
        except (RecursionError, MemoryError, ValueError):  # ValueError: a null character
            self._refuse("it is nested too deeply, or holds characters that no text has")
        self._check()

    def __call__(self, scene):
        """The value for a scene."""
        return _Evaluation(self, scene).value(self._tree.body, {})

    def _refuse(self, reason):
        shown = self.text if len(self.text) <= 200 else self.text[:200] + " ..."
        raise ValueError(
            f"{self._who} = {shown!r} is not allowed: {reason}; as text a column takes fields of the scene "
            f"and its bodies, diagnostics.NAME(scene), arithmetic, comparisons, indexing and functions of "
            f"NumPy such as np.quantile; for anything else give a function"
        )

    def _check(self):
        """What is known to be wrong without a scene."""
        own = {n.id for n in ast.walk(self._tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        known = {"scene", "diagnostics", "np", *FUNCTIONS}
        for node in ast.walk(self._tree):
            if not isinstance(node, NODES):
                self._refuse(f"{type(node).__name__} is not part of the language")
            name = getattr(node, "attr", None) or getattr(node, "id", None) or getattr(node, "arg", None)
            if isinstance(name, str) and name.startswith("_"):
                self._refuse(f"the name '{name}' begins with an underscore")
            if isinstance(node, ast.Name) and node.id not in known | own:
                self._refuse(f"there is no name '{node.id}'")
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id in known:
                self._refuse(f"the name '{node.id}' has a meaning already")
            if isinstance(node, ast.Call) and not isinstance(node.func, (ast.Name, ast.Attribute)):
                self._refuse("what is called has no name")
            if isinstance(node, ast.comprehension) and not isinstance(node.target, ast.Name):
                self._refuse("a loop takes one name")
            if isinstance(node, ast.keyword) and node.arg in (None, "out", "dtype"):
                self._refuse(f"the argument '{node.arg or '**'}' is not part of the language")


class _Evaluation:
    """One walk over an expression."""

    def __init__(self, expression, scene):
        self._refuse, self._scene, self._left = expression._refuse, scene, MOST_NODES

    def value(self, node, own):
        """Of a part of the expression; own : dict of the names that loops gave."""
        self._left -= 1
        if self._left < 0:
            self._refuse(f"it takes more than {MOST_NODES} operations")
        return getattr(self, "_of" + type(node).__name__)(node, own)

    # --- leaves ---
    def _ofConstant(self, node, own):
        if not isinstance(node.value, (int, float, str, bool, type(None), type(...))):
            self._refuse(f"{node.value!r} is no number")
        return node.value

    def _ofName(self, node, own):
        if node.id in own:
            return own[node.id]
        if node.id == "scene":
            return self._scene
        return self._refuse(f"'{node.id}' stands alone")

    def _ofTuple(self, node, own):
        return tuple(self.value(n, own) for n in node.elts)

    def _ofList(self, node, own):
        return [self.value(n, own) for n in node.elts]

    def _ofSlice(self, node, own):
        return slice(
            *(None if n is None else self.value(n, own) for n in (node.lower, node.upper, node.step))
        )

    # --- arithmetic ---
    def _ofBinOp(self, node, own):
        a, b = self._number(self.value(node.left, own)), self._number(self.value(node.right, own))
        if isinstance(a, int) and isinstance(b, int):
            power = isinstance(node.op, ast.Pow)
            if (a.bit_length() * max(0, b) if power else a.bit_length() + b.bit_length()) > MOST_BITS:
                self._refuse("a whole number becomes too long")
        return BINARY[type(node.op)](a, b)

    def _number(self, value):
        if not isinstance(value, (int, float, np.number, np.bool_, np.ndarray)):
            raise TypeError(f"{type(value).__name__} is no number")
        return value

    def _ofUnaryOp(self, node, own):
        value = self.value(node.operand, own)
        return UNARY[type(node.op)](value if isinstance(node.op, ast.Not) else self._number(value))

    def _ofBoolOp(self, node, own):
        value = None
        for part in node.values:
            value = self.value(part, own)
            if bool(value) != isinstance(node.op, ast.And):
                break
        return value

    def _ofCompare(self, node, own):
        left, result = self.value(node.left, own), True
        for kind, other in zip(node.ops, node.comparators):
            right = self.value(other, own)
            result = COMPARE[type(kind)](left, right)
            if len(node.ops) > 1 and not result:
                break
            left = right
        return result

    def _ofIfExp(self, node, own):
        return self.value(node.body if self.value(node.test, own) else node.orelse, own)

    def _ofListComp(self, node, own):
        return list(self._loop(node.elt, node.generators, dict(own)))

    _ofGeneratorExp = _ofListComp

    def _loop(self, element, loops, own):
        if not loops:
            yield self.value(element, own)
            return
        for one in self.value(loops[0].iter, own):
            own[loops[0].target.id] = one
            if all(self.value(test, own) for test in loops[0].ifs):
                yield from self._loop(element, loops[1:], own)

    # --- looking ---
    def _ofSubscript(self, node, own):
        holder, index = self.value(node.value, own), self.value(node.slice, own)
        if not (
            holder is self._scene or isinstance(holder, (np.ndarray, np.generic, list, tuple, dict, str))
        ):
            self._refuse(f"a {type(holder).__name__} cannot be indexed")
        return holder[index]

    def _ofAttribute(self, node, own):
        if _dotted(node).startswith("np."):
            if (name := _dotted(node)[3:]) in CONSTANTS:
                return CONSTANTS[name]
            self._refuse(f"np.{name} is not part of the language, or is not called")
        holder, name = self.value(node.value, own), node.attr
        if isinstance(holder, (np.ndarray, np.generic)):
            isKnown = name in ARRAY_ATTRIBUTES
        elif holder is self._scene:
            isKnown = name in SCENE_ATTRIBUTES
        else:
            isKnown = isinstance(holder, KINDS) and name != "core"
        if not isKnown:
            self._refuse(f"'{name}' of a {type(holder).__name__} is not part of the language")
        found = readOnly(getattr(holder, name))
        if not isData(found):
            self._refuse(f"'{name}' of a {type(holder).__name__} is not a value")
        return found

    def _ofCall(self, node, own):
        function = self._function(node.func, own)
        given = [self.value(a, own) for a in node.args]
        named = {k.arg: self.value(k.value, own) for k in node.keywords}
        if isinstance(function, np.ufunc) and len(given) > function.nin:
            self._refuse(f"np.{function.__name__} takes {function.nin} arguments")
        return readOnly(function(*given, **named))

    def _function(self, node, own):
        name = _dotted(node)
        if name in FUNCTIONS:
            return FUNCTIONS[name]
        if name.startswith("np."):
            if name[3:] not in NUMPY:
                self._refuse(f"{name} is not part of the language")
            return operator.attrgetter(name[3:])(np)
        if name.startswith("diagnostics."):
            if name[12:] not in diagnostics.__all__:
                self._refuse(f"there is no {name}")
            return getattr(diagnostics, name[12:])
        if isinstance(node, ast.Name):
            self._refuse(f"'{name}' cannot be called")
        holder = self.value(node.value, own)
        allowed = {m for kind, names in METHODS.items() if isinstance(holder, kind) for m in names}
        if isinstance(holder, (np.ndarray, np.generic)):
            allowed = ARRAY_METHODS
        elif holder is self._scene:
            allowed = SCENE_METHODS
        if node.attr not in allowed:
            self._refuse(f"{node.attr}() of a {type(holder).__name__} is not part of the language")
        return getattr(holder, node.attr)


def _dotted(node):
    """np.linalg.norm of a chain of attributes; nothing for anything else."""
    if isinstance(node, ast.Name):
        return node.id
    return f"{_dotted(node.value)}.{node.attr}" if isinstance(node, ast.Attribute) else ""
