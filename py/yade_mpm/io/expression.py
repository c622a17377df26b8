# SPDX-License-Identifier: GPL-2.0-or-later
"""Columns as text, which a checkpoint may bring: they name fields and diagnostics, and calculate.

    -scene['footing'].displacement[:, 1].mean()
    np.quantile(scene['column'].position[:, 0], 0.99) - 2.0
    diagnostics.sectionForce(scene['pile'], height=1.25) / scene.time
    diagnostics.pressureImpulse(scene['wall'], 'left', 2, 3)

Python's parser reads the text; each form that is known becomes a function of ours, and the text is never
compiled. Numbers are floating-point, so that no power takes long.
"""

import ast
import operator

import numpy as np

from .. import diagnostics
from ..base.wording import shown
from .frame import DERIVED

MOST_TEXT = 1000  # characters
SCENE = ("time", "steps", "dt", "dtCritical", "particleCount")
MEANS = {"min": np.min, "max": np.max, "mean": np.mean, "sum": np.sum}  # of a field
FUNCTIONS = {"abs": abs, "min": min, "max": max}  # of numbers
OPERATIONS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: lambda a, b: float(a) ** float(b),
}
SIGNS = {ast.UAdd: operator.pos, ast.USub: operator.neg}


class Expression:
    """A number that a text tells of a scene.

    text : of the expression. who : of the error, e.g. "History: column 'toe'".

    Raises SyntaxError for text that is no expression, ValueError, which tells what is allowed, for any other
    form than those of this module.
    """

    def __init__(self, text, who):
        self.text, self._who = text, who
        if len(text) > MOST_TEXT:
            self._refuse(f"it has {len(text)} characters, and {MOST_TEXT} are allowed")
        try:
            tree = ast.parse(text, f"<{who}>", "eval")
        except SyntaxError as error:
            said = f"{who} = {shown(text)} is not allowed: {error.msg}; give an expression, or a function"
            raise SyntaxError(said, error.args[1]) from None
        except (RecursionError, MemoryError, ValueError):  # ValueError: a null character
            self._refuse("it is nested too deeply, or holds characters that no text has")
        try:
            self._value = self._number(tree.body)
        except RecursionError:
            self._refuse("it is nested too deeply")

    def __call__(self, scene):
        """The value for a scene, a float."""
        return float(self._value(scene))

    def _refuse(self, reason):
        raise ValueError(
            f"{self._who} = {shown(self.text)} is not allowed: {reason}; as text a column takes numbers, "
            f"+ - * / **, scene.time, scene['body'].FIELD[:, 0].mean() (min, max, sum), np.quantile(FIELD, "
            f"0.9) and diagnostics.NAME(scene); for anything else give a function"
        )

    # --- forms, each as a function of the scene -------------------------------------------------------
    def _number(self, node):
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                number = self._asFloat(value)
                return lambda scene: number
            case ast.UnaryOp(op=op, operand=operand) if type(op) in SIGNS:
                sign, of = SIGNS[type(op)], self._number(operand)
                return lambda scene: sign(of(scene))
            case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATIONS:
                of, first, second = OPERATIONS[type(op)], self._number(left), self._number(right)
                return lambda scene: of(first(scene), second(scene))
            case ast.Attribute(value=ast.Name(id="scene"), attr=name) if name in SCENE:
                return lambda scene: getattr(scene, name)
            case ast.Call(func=ast.Name(id=name), args=[_, *_] as given, keywords=[]) if name in FUNCTIONS:
                of, numbers = FUNCTIONS[name], [self._number(one) for one in given]
                return lambda scene: of(*(number(scene) for number in numbers))
            case ast.Call(func=ast.Attribute(value=field, attr=name), args=[], keywords=[]) if name in MEANS:
                mean, values = MEANS[name], self._field(field)
                return lambda scene: mean(values(scene))
            case ast.Call(
                func=ast.Attribute(value=ast.Name(id="np"), attr="quantile"), args=[field, share], keywords=[]
            ):
                values, of = self._field(field), self._number(share)
                return lambda scene: np.quantile(values(scene), of(scene))
            case ast.Subscript(value=ast.Call() as call, slice=index):
                vector, k = self._diagnostic(call), self._whole(index)
                return lambda scene: vector(scene)[k]
            case ast.Call():
                return self._diagnostic(node)
            case ast.Subscript(slice=ast.Constant() | ast.UnaryOp()):
                values, k = self._field(node.value), self._whole(node.slice)
                return lambda scene: values(scene)[k]
        return self._refuse(f"'{ast.unparse(node)[:80]}' is not part of the language")

    def _field(self, node):
        """An array: scene['body'].FIELD, or a component of it."""
        match node:
            case ast.Attribute(value=holder, attr=name):
                of = self._body(holder)
                return lambda scene: _fieldOf(of(scene), name)
            case ast.Subscript(
                value=ast.Attribute() as field, slice=ast.Tuple(elts=[ast.Slice() as all_, *axes])
            ):
                if any((all_.lower, all_.upper, all_.step)):
                    self._refuse("a component is FIELD[:, 0]")
                values, component = self._field(field), tuple(self._whole(axis) for axis in axes)
                return lambda scene: values(scene)[(slice(None), *component)]
        return self._refuse(f"'{ast.unparse(node)[:80]}' is no field of a body")

    def _body(self, node):
        match node:
            case ast.Subscript(value=ast.Name(id="scene"), slice=ast.Constant(value=str() as name)):
                return lambda scene: scene[name]
            case ast.Subscript(value=ast.Attribute(value=ast.Name(id="scene"), attr="bodies"), slice=index):
                k = self._whole(index)
                return lambda scene: scene.bodies[k]
        return self._refuse(f"'{ast.unparse(node)[:80]}' is no body; give scene['name']")

    def _diagnostic(self, node):
        """diagnostics.NAME of the scene or a body, with numbers or text besides."""
        match node:
            case ast.Call(
                func=ast.Attribute(value=ast.Name(id="diagnostics"), attr=name),
                args=[who, *given],
                keywords=named,
            ) if name in diagnostics.__all__ and all(one.arg for one in named):
                of = getattr(diagnostics, name)
                isScene = isinstance(who, ast.Name) and who.id == "scene"
                about = (lambda scene: scene) if isScene else self._body(who)
                numbers = [self._argument(one) for one in given]
                more = {one.arg: self._argument(one.value) for one in named}
                return lambda scene: of(
                    about(scene), *(n(scene) for n in numbers), **{k: n(scene) for k, n in more.items()}
                )
        return self._refuse(f"'{ast.unparse(node)[:80]}' is not part of the language")

    def _argument(self, node):
        match node:
            case ast.Constant(value=str() as text):
                return lambda scene: text
        return self._number(node)

    def _whole(self, node):
        match node:
            case ast.Constant(value=int() as k) if not isinstance(k, bool):
                return k
            case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() as k)):
                return -k
        return self._refuse(f"'{ast.unparse(node)[:80]}' is no number of a component")

    def _asFloat(self, value):
        try:
            return float(value)
        except OverflowError:
            return self._refuse("a number has too many digits")


def _fieldOf(body, name):
    known = [*(field["name"] for field in body.fields()), *DERIVED]
    values = DERIVED[name][1](body) if name in DERIVED else getattr(body, name) if name in known else None
    if values is None:
        raise ValueError(f"body '{body.name}' has no field '{name}'; fields: {', '.join(known)}")
    return values
