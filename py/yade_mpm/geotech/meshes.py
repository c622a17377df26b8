# SPDX-License-Identifier: GPL-2.0-or-later
"""Structured meshes: quadrilaterals of a rectangle that is mapped to a shape."""

from math import ceil, pi, radians, tan

import numpy as np

from ..base.kinds import NUMBER, NUMBERS, POSITIVE, takes
from ..geometry.numbers import vector


@takes(x=NUMBERS, y=NUMBERS)
def quadrilaterals(x, y):
    """Points (N, 2) and cells (M, 4) of a structured mesh, for `scene.add`.

    x, y : coordinates of its points, m, arrays (A, B) with A, B >= 2; neighbours in an array are neighbours
    in the mesh. The cells turn counter-clockwise, whichever way the arrays run.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    if x.ndim != 2 or x.shape != y.shape or min(x.shape) < 2:
        raise ValueError(
            f"quadrilaterals: x of shape {x.shape} and y of shape {y.shape} are not allowed; give two arrays "
            "(A, B) with A, B >= 2"
        )
    rows, columns = x.shape
    points = np.stack([x, y], axis=2).reshape(-1, 2)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    along, across = points[[columns, 1]] - points[0]
    isRowFirst = along[0] * across[1] > along[1] * across[0]
    second, fourth = (columns, 1) if isRowFirst else (1, columns)
    return points, np.stack([first, first + second, first + columns + 1, first + fourth], axis=1)


@takes(middle=NUMBER, bottom=NUMBER, width=POSITIVE, height=POSITIVE, angle=POSITIVE, size=POSITIVE)
def wedgedColumn(middle, bottom, width, height, angle, size):
    """Mesh of a column with a wedge at its lower end: rows of chevrons that flatten with height. (points,
    cells).

    middle, bottom : its axis and its lowest point, m. angle : of the wedge, degrees, 180 for a flat end. size
    : of the domains, m; the width takes an even number of them.
    """
    columns, rows = 2 * ceil(width / (2 * size) - 1e-9), max(1, round(height / size))
    x, y = np.meshgrid(np.linspace(-1, 1, columns + 1), np.linspace(0, 1, rows + 1))
    rise = 0.5 * width / tan(radians(angle / 2))
    return quadrilaterals(middle + 0.5 * width * x, bottom + height * y + rise * np.abs(x) * (1 - y))


@takes(inner=POSITIVE, outer=POSITIVE, size=POSITIVE)
def ring(centre, inner, outer, size):
    """Mesh of a ring, closed round. (points, cells).

    centre : (2,), m. inner, outer : radii, m. size : of the domains at the outer radius, m.
    """
    centre = vector("ring", "centre", centre, 2)
    around = round(2 * pi * outer / size)
    across = max(1, round((outer - inner) / size))
    turn, radius = np.meshgrid(np.linspace(0, 2 * pi, around + 1), np.linspace(inner, outer, across + 1))
    points, cells = quadrilaterals(centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn))
    number = np.arange(len(points)).reshape(turn.shape)
    number[:, -1] = number[:, 0]  # where the ring closes
    kept = np.arange(len(points)).reshape(turn.shape)[:, :-1].ravel()
    place = np.zeros(len(points), int)
    place[kept] = np.arange(len(kept))
    return points[kept], place[number.ravel()[cells]]
