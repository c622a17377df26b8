# SPDX-License-Identifier: GPL-2.0-or-later
"""Surfaces of triangles in files: STL, OBJ and what else meshio reads."""

import os

import numpy as np

from ..base.wording import shown
from .meshReader import readMesh


def readTriangles(who, file, unit=1.0):
    """Points (N, 3), m, and triangles (M, 3) of a surface in a file; quadrilaterals are halved.

    unit: m, length of one unit of the file. Raises FileNotFoundError, or ValueError for other contents.
    """
    name = shown(os.fspath(file))
    if not os.path.isfile(file):
        raise FileNotFoundError(f"{who}: there is no file {name}; give the name of an STL or OBJ file")
    try:
        points, cells, _ = readMesh(file)
    except RuntimeError as error:
        raise ValueError(f"{who}: {name} is no mesh of triangles: {error}") from None
    found = [part for kind, _, corners in cells for part in _trianglesOf(kind, corners)]
    if not found or points.shape[1] != 3:
        raise ValueError(f"{who}: {name} has no triangles in space; give STL or OBJ")
    triangles = np.concatenate(found).astype(int)
    wrong = np.flatnonzero(((triangles < 0) | (triangles >= len(points))).any(axis=1))
    if len(wrong):
        raise ValueError(
            f"{who}: {name}: triangle {wrong[0]} names corner {triangles[wrong[0]].max()} of {len(points)} "
            "points; write the file again"
        )
    return points * unit, triangles


def _trianglesOf(kind, corners):
    if kind == "triangle":
        return [corners]
    return [corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]] if kind == "quad" else []
