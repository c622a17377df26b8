# SPDX-License-Identifier: GPL-2.0-or-later
"""What there is in expressions that a file may bring: functions, attributes, operations and their limits."""

import ast
import math
import operator

import numpy as np

from ..base.attributes import Attributed
from ..engine.contact import Contact
from ..engine.prescribed import Prescribed
from ..engine.rigidContact import RigidContact
from ..particle.body import Body, BodyPart


def _words(text):
    return frozenset(text.split())


# Parts of an expression looked at in one evaluation: a thousand bodies, a hundred parts for each.
MOST_NODES = 100_000
MOST_TEXT = 10_000  # characters
MOST_BITS = 4096  # of a whole number; 10**10**10 would take minutes and all memory

FUNCTIONS = {f.__name__: f for f in (abs, all, any, bool, float, int, len, max, min, round, sum)}

NUMPY = _words(
    "abs absolute all allclose any arccos arcsin arctan arctan2 argmax argmin argsort array asarray "
    "average ceil clip concatenate cos cosh count_nonzero cross cumprod cumsum deg2rad degrees diff "
    "divide dot einsum exp expm1 fabs floor fmax fmin hstack hypot inner interp isfinite isinf isnan "
    "isclose log log10 log1p log2 logical_and logical_not logical_or logical_xor max maximum mean "
    "median min minimum mod multiply nanmax nanmean nanmedian nanmin nanquantile nansum negative "
    "percentile power prod ptp quantile rad2deg radians rint round searchsorted sign sin sinh sort sqrt "
    "square squeeze stack std subtract sum take tan tanh trace trapz transpose true_divide trunc unique "
    "var vstack where add linalg.norm linalg.det linalg.eigvalsh flatnonzero float64 int64 "
    "bool_"
)
CONSTANTS = {"pi": math.pi, "inf": math.inf, "nan": math.nan, "e": math.e, "newaxis": None}

ARRAY_ATTRIBUTES = {"T", "shape", "size", "ndim", "real"}
ARRAY_METHODS = _words(
    "all any argmax argmin argsort clip copy cumprod cumsum diagonal dot flatten item max mean min prod "
    "ptp ravel reshape round squeeze std sum swapaxes take tolist trace transpose var"
)
METHODS = {  # of what a scene is made of; none of them changes anything
    Body: {"corners", "outline", "fields"},
    Contact: {"forces", "forceOn", "forceImpulses", "contactTable", "frictions"},
    RigidContact: {"contactTable", "frictions"},
}
KINDS = (
    Body,
    BodyPart,
    Attributed,
    Prescribed,
)  # whose values may be looked at; Attributed: engines, materials, types
SCENE_ATTRIBUTES = _words(
    "time steps dt dtCritical dtStable stiffest dim lower upper cell bodies engines constraints "
    "particleCount threads scheme"
)
SCENE_METHODS = {"nodePositions", "faceNodes"}

BINARY = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.MatMult: operator.matmul,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
UNARY = {ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: operator.not_, ast.Invert: operator.invert}
COMPARE = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}
NODES = (
    *(ast.Expression, ast.Constant, ast.Name, ast.Load, ast.Store, ast.Attribute, ast.Subscript, ast.Slice),
    *(ast.Tuple, ast.List),
    *(ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.And, ast.Or, ast.Compare, ast.IfExp, ast.Call, ast.keyword),
    *(ast.GeneratorExp, ast.ListComp, ast.comprehension, *BINARY, *UNARY, *COMPARE),
)  # fmt: skip


def readOnly(value):
    """Arrays as views that cannot be written to: np.add(a, b, a) would change the scene."""
    if isinstance(value, np.ndarray):
        value = value.view()
        value.flags.writeable = False
    elif isinstance(value, tuple):
        value = tuple(readOnly(v) for v in value)
    return value


def isData(value):
    """Whether a value is plain, or of a kind that may be looked at."""
    if isinstance(value, (list, tuple)):
        return all(isData(v) for v in value)
    plain = (int, float, str, bool, type(None), np.ndarray, np.generic, dict)
    return isinstance(value, (*plain, *KINDS))
