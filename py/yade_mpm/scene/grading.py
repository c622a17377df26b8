# SPDX-License-Identifier: GPL-2.0-or-later
"""Graded grids: cells that grow away from a box, or lines where the user wants them."""

import numpy as np

from ..base.wording import shown
from ..geometry.numbers import isNumber, numbers, requireFinite
from ..geometry.region import Region

MOST_GROWTH = 1.5  # of a cell over the one before; beyond 1.3 waves come back from the grading
LARGEST = 4  # cells; longest cell unless given (doc/explanation/graded-grids.md)
ON_LINE = 1e-6  # of a cell


class Grading:
    """Cells of the size `cell` of the scene in a box, that grow from one to the next outside of it.

    Parameters
    ----------
    box : Region, whose bounds count, or its lower and upper corner, m. Where it reaches a face of the grid or
        beyond it, cells do not grow towards that face; its sides move outward to the next multiple of `cell`
        from the lower corner of the grid.
    growth : float, largest ratio of a cell to the one before it, above 1 and at most 1.5; default 1.2. Cells
        grow by a little less, so that they fill the grid.
    largest : float, longest edge of a cell, m; default 4 times `cell`.

    Raises TypeError and ValueError for anything else. doc/explanation/graded-grids.md tells what to choose.
    """

    def __init__(self, box, growth=1.2, largest=None):
        corners = box.bounds() if isinstance(box, Region) else box
        if not (isinstance(corners, (tuple, list)) and len(corners) == 2):
            raise TypeError(f"Grading: box = {shown(box)}; give a region, or its lower and upper corner")
        lower, upper = (numbers("Grading", "a corner of the box", corner) for corner in corners)
        if lower.shape != upper.shape or lower.shape not in ((2,), (3,)) or not (lower < upper).all():
            raise ValueError(
                f"Grading: box = {shown(box)} is not allowed; give a lower corner and an upper one above it, "
                "with two or three numbers each, m"
            )
        if not (isNumber(growth) and 1 < growth <= MOST_GROWTH):
            raise ValueError(
                f"Grading: growth = {shown(growth)} is not allowed; give a number above 1 and at most "
                f"{MOST_GROWTH:g}, e.g. 1.2"
            )
        if largest is not None and not (isNumber(largest) and 0 < largest < np.inf):
            raise ValueError(
                f"Grading: largest = {shown(largest)} is not allowed; give a positive number, m, or None for "
                f"{LARGEST} cells"
            )
        self.lower, self.upper, self.growth, self.largest = lower, upper, float(growth), largest

    def __repr__(self):
        box = (tuple(self.lower.tolist()), tuple(self.upper.tolist()))
        return f"Grading(box={box}, growth={self.growth:g}, largest={self.largest})"

    def lines(self, lower, upper, cell):
        """Lines across each axis of a grid, m: a list of arrays, the ends at the faces of the grid.

        lower, upper, cell : (dim,) corners of the grid and edges of its smallest cells, m. Raises ValueError
        where they do not go together with the grading.
        """
        if len(lower) != len(self.lower):
            raise ValueError(
                f"Grading: the box is {len(self.lower)}D, the scene {len(lower)}D; give one of {len(lower)}D"
            )
        return [self._along(k, float(lower[k]), float(upper[k]), float(cell[k])) for k in range(len(lower))]

    def _along(self, k, lower, upper, cell):
        largest = LARGEST * cell if self.largest is None else float(self.largest)
        if largest < cell:
            raise ValueError(
                f"Grading: largest = {largest:g} m is smaller than cell = {cell:g} m; give at least that"
            )
        count = round((upper - lower) / cell)
        if count < 1 or abs(count * cell - (upper - lower)) > ON_LINE * cell:
            raise ValueError(
                f"Scene: upper - lower = {upper - lower:g} m along axis {k} is not a multiple of cell = "
                f"{cell:g} m; move lower or upper, or change cell"
            )
        first = int(np.floor(np.clip((self.lower[k] - lower) / cell + ON_LINE, 0, count)))
        last = int(np.ceil(np.clip((self.upper[k] - lower) / cell - ON_LINE, 0, count)))
        if first >= last:
            raise ValueError(
                f"Grading: the box from {self.lower[k]:g} to {self.upper[k]:g} m along axis {k} is outside "
                f"of the grid, {lower:g} to {upper:g} m; move it"
            )
        inside = lower + np.arange(first, last + 1) * cell
        below = inside[0] - _outward(first * cell, cell, self.growth, largest)[::-1]
        above = inside[-1] + _outward((count - last) * cell, cell, self.growth, largest)
        lines = np.concatenate([below, inside, above])
        lines[0], lines[-1] = lower, upper
        return lines


def linesOf(grading, lower, upper, cell):
    """Lines across each axis, m, of what a scene was given as `grading`; None: all cells are equal.

    grading : None, Grading, or a sequence with the lines of each axis, where None stands for equal cells.
    cell : (dim,) or None, which lines along all axes may leave out.
    """
    if grading is None:
        return None
    if isinstance(grading, Grading):
        if cell is None:
            raise ValueError(
                "Scene: cell is missing; give the edge of the cells in the box of the grading, m"
            )
        return _unlessEqual(grading.lines(lower, upper, cell), cell)
    if not isinstance(grading, (tuple, list)) or len(grading) != len(lower):
        raise TypeError(
            f"Scene: grading = {shown(grading)} is not allowed; give mpm.Grading(box=...), or the lines "
            f"across each of the {len(lower)} axes"
        )
    return [_given(k, given, lower[k], upper[k], cell) for k, given in enumerate(grading)]


def _given(k, lines, lower, upper, cell):
    """Lines across axis k as the user wants them, or equal cells."""
    if lines is None:
        if cell is None:
            raise ValueError(f"Scene: neither cell nor lines across axis {k} are given; give one of them")
        return lower + np.arange(round((upper - lower) / cell[k]) + 1) * cell[k]
    lines = numbers("Scene", f"grading: lines across axis {k}", lines)
    requireFinite("Scene", f"grading: lines across axis {k}", lines)
    if lines.ndim != 1 or len(lines) < 2 or not (np.diff(lines) > 0).all():
        raise ValueError(f"Scene: grading: lines across axis {k} must be two positions or more that grow, m")
    if np.abs(lines[[0, -1]] - (lower, upper)).max() > ON_LINE * np.diff(lines).min():
        raise ValueError(
            f"Scene: grading: lines across axis {k} go from {lines[0]:g} to {lines[-1]:g} m, and the grid "
            f"from {lower:g} to {upper:g} m; give the same ends"
        )
    return lines


def _unlessEqual(lines, cell):
    """None where the lines are those of equal cells: their scene has the bits of one without grading."""
    isEqual = all(np.abs(np.diff(x) - h).max() < ON_LINE * h for x, h in zip(lines, cell))
    return None if isEqual else lines


def _outward(length, cell, growth, largest):
    """Distances of the lines from the box, for cells that grow from one to the next and fill a length, m."""
    from scipy.optimize import brentq  # late: 0.1 s, and few need it

    if length < 0.5 * cell:
        return np.zeros(0)

    def distances(factor, count):
        return np.cumsum(np.minimum(cell * factor ** np.arange(1, count + 1), max(largest, cell)))

    count = 1
    while distances(growth, count)[-1] < length * (1 - 1e-12):
        count += 1
    if count * cell >= length * (1 - 1e-12):
        return np.arange(1, count + 1) * (length / count)
    factor = brentq(lambda f: distances(f, count)[-1] - length, 1.0, growth * (1 + 1e-9), xtol=1e-15)
    found = distances(factor, count)
    return found * (length / found[-1])
