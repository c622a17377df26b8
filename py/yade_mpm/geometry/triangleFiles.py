# SPDX-License-Identifier: GPL-2.0-or-later
"""Surfaces of triangles in files: STL, OBJ and what else meshio reads."""

import os

import numpy as np

from ..base.kinds import requireFile
from ..base.wording import shown
from .meshReader import readMesh


def readTriangles(who, file, unit=1.0):
    """Points (N, 3), m, and triangles (M, 3) of a surface in a file; other faces are split.

    unit: m, length of one unit of the file. Raises FileNotFoundError, or ValueError for other contents.
    """
    name = shown(requireFile(who, file, "the name of an STL or OBJ file"))
    try:
        isObj = os.fspath(file).lower().endswith(".obj")
        points, cells = _readObj(file) if isObj else readMesh(file)[:2]
    except (RuntimeError, ValueError, OverflowError) as error:
        raise ValueError(f"{who}: {name} is no mesh of triangles: {error}") from None
    found = [part for kind, _, corners in cells for part in _trianglesOf(kind, corners) if len(part)]
    if not found or points.shape[1] != 3:
        raise ValueError(f"{who}: {name} has no triangles in space; give STL or OBJ")
    triangles = np.concatenate(found).astype(int)
    if len(bad := np.flatnonzero(~np.isfinite(points).all(axis=1))):
        place = shown(points[bad[0]].tolist())
        raise ValueError(f"{who}: {name}: point {bad[0]} is at {place}; write the file again")
    wrong = np.flatnonzero(((triangles < 0) | (triangles >= len(points))).any(axis=1))
    if len(wrong):
        raise ValueError(
            f"{who}: {name}: triangle {wrong[0]} names corner {triangles[wrong[0]].max()} of {len(points)} "
            "points; write the file again"
        )
    return points * unit, triangles


def _readObj(file):
    """Points (N, 3) and cells of an OBJ file; meshio refuses normals and textures of other numbers."""
    points, faces = [], []
    with open(file, encoding="utf-8", errors="replace") as lines:
        for words in (line.split() for line in lines):
            if words[:1] == ["v"]:
                points.append([float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(word.split("/")[0]) for word in words[1:]]  # from 1 on; -1: the last point
                faces.append([c - 1 if c > 0 else len(points) + c for c in corners])
    parts = [[face[0], *pair] for face in faces for pair in zip(face[1:], face[2:])]
    return np.reshape(points, (-1, 3)), [("triangle", 2, np.reshape(np.array(parts, int), (-1, 3)))]


def _trianglesOf(kind, corners):
    """Fans of convex faces."""
    if kind not in ("triangle", "quad", "polygon"):
        return []
    return [corners[:, [0, k, k + 1]] for k in range(1, corners.shape[1] - 1)]
