# SPDX-License-Identifier: GPL-2.0-or-later
"""What a scene is given of its grid, checked."""

import numpy as np

from .. import _core
from ..base.wording import shown
from ..geometry.numbers import refuseLongRange


def makeCore(lower, upper, cell, lines=None):
    """The solver's scene on a grid of equal cells, or with the lines of each axis."""
    make = _core.Scene2 if len(lower) == 2 else _core.Scene3
    try:
        if lines is not None:
            return make([np.ascontiguousarray(x, float) for x in lines])
        return make(list(lower), list(upper), list(cell))
    except MemoryError as error:
        if getattr(error, "isFromSolver", False):  # in words already
            raise
        count = np.prod((upper - lower) / cell if lines is None else [len(x) - 1 for x in lines])
        raise MemoryError(
            f"Scene: the {count:.3g} cells of the grid do not fit into memory; give a larger cell or a "
            "smaller grid"
        ) from None


def cellSize(cell, dim):
    """Cell size per axis, m (dim,), from one number or one per axis."""
    try:
        size = np.broadcast_to(_numbers(cell), (dim,)).copy()
    except (TypeError, ValueError):
        size = np.zeros(dim)
    if (size > 0).all() and np.isfinite(size).all():
        return size
    raise ValueError(f"Scene: cell = {shown(cell)} is not allowed; give one positive number, or {dim}, m")


def corner(what, values):
    """A corner of the grid as an array, m (2,) or (3,); `what` names it in errors."""
    try:
        array = _numbers(values)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if array.shape not in ((2,), (3,)) or not np.isfinite(array).all():
        raise ValueError(
            f"Scene: {what} = {shown(values)} is not allowed; give two (plane strain) or three numbers, m"
        )
    return array


def _numbers(values):
    """Values as an array of floats; text and dates, which NumPy would turn into numbers, are none."""
    refuseLongRange(values)
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise TypeError("not made of numbers")
    return array.astype(float)
