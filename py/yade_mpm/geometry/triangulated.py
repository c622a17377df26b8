# SPDX-License-Identifier: GPL-2.0-or-later
"""Regions that a closed surface of triangles bounds."""

from __future__ import annotations

import os

import numpy as np

from ..base.kinds import FILE, POSITIVE, takes
from ..base.wording import shown
from .numbers import numbers, placeText, requireFinite
from .primitives import Primitive
from .region import _TOLERANCE, Region
from .triangleFiles import readTriangles

ASIDE = 0.9, 0.7, 0.5  # tolerances; a point on a face belongs where points so far beside it lie
SAME_POINT = 1e-7  # of the size: corners of single precision that are one


@takes(file=FILE, unit=POSITIVE)
def solidFromFile(file: str | os.PathLike, unit: float = 1.0) -> Region:
    """The solid in an STL or OBJ file as a region in 3D.

        rock = mpm.solidFromFile("rock.stl", unit=0.001)  # drawn in mm
        scene.add("rock", rock, granite)

    Parameters
    ----------
    file : of triangles or quadrilaterals, in any format that meshio reads, which bound the solid without a
        gap.
    unit : m, length of one unit of the file; default 1.

    VTK tells which points are inside. Raises ImportError where it is missing, FileNotFoundError, ValueError
    for a surface that is open, or another file.
    """
    points, triangles = readTriangles("solidFromFile", file, unit)
    try:
        return Triangulated(points, triangles)
    except ValueError as error:
        raise ValueError(f"solidFromFile: {shown(os.fspath(file))}: {error}") from None


class Triangulated(Primitive):
    """Solid inside a closed surface; made by `solidFromFile`."""

    toChange = ", or give the unit of its file, e.g. solidFromFile(file, unit=0.001) for mm"

    def __init__(self, points, triangles):
        points, triangles = numbers("solid", "points", points), numbers("solid", "triangles", triangles)
        requireFinite("solid", "points", points)
        isNumbered = triangles.ndim == 2 and triangles.shape[1] == 3 and len(triangles)
        isNumbered = isNumbered and (triangles == np.clip(triangles.round(), 0, len(points) - 1)).all()
        if points.ndim != 2 or points.shape[1] != 3 or not isNumbered:
            raise ValueError(
                f"solid: triangles of shape {triangles.shape} do not name corners among points of shape "
                f"{points.shape}; give (M, 3) and (N, 3)"
            )
        points, triangles = _joined(points, triangles.astype(int))
        _refuseOpen(points, triangles)
        super().__init__("solid", 3, points=points, triangles=triangles)
        self._surface = None  # for VTK, made when it is asked

    def __repr__(self):
        points = self._arguments["points"]
        size = " x ".join(f"{length:.4g}" for length in np.ptp(points, axis=0))
        count = len(self._arguments["triangles"])
        return f"solid({count} triangles, {size} m, from {placeText(points.min(axis=0))})"

    def bounds(self):
        points = self._arguments["points"]
        return points.min(axis=0), points.max(axis=0)

    def _covers(self, points):
        lower, upper = self.bounds()
        near = np.flatnonzero(((points >= lower) & (points <= upper)).all(axis=1))
        inside = np.zeros(len(points), bool)
        if len(near):
            vtk = _vtk()
            if self._surface is None:
                self._surface = _polyData(vtk, **self._arguments)
            asked = vtk.vtkSelectEnclosedPoints()
            asked.SetSurfaceData(self._surface)
            asked.SetTolerance(_TOLERANCE / 100)
            asked.SetInputData(_polyData(vtk, points[near] + self._tolerance() * np.array(ASIDE)))
            asked.Update()
            inside[near] = np.asarray(asked.GetOutput().GetPointData().GetArray("SelectedPoints")) == 1
        return inside


def _joined(points, triangles):
    """The surface with corners at one place made one, and without triangles that vanish by that."""
    size = np.ptp(points, axis=0).max() * SAME_POINT or 1.0
    _, first, same = np.unique(np.round(points / size), axis=0, return_index=True, return_inverse=True)
    triangles = same.ravel()[triangles]
    ordered = np.sort(triangles, axis=1)
    return points[first], triangles[(ordered[:, 1:] != ordered[:, :-1]).all(axis=1)]


def _refuseOpen(points, triangles):
    """ValueError unless two triangles meet at each edge."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    bad = np.flatnonzero(count != 2)
    if len(bad) or not len(edges):
        place = placeText(points[edges[bad[:1]]].mean(axis=(0, 1))) if len(bad) else "no place"
        raise ValueError(
            f"the surface is not closed: at {len(bad)} of {len(edges)} edges, one at {place}, other than two "
            "triangles meet; close it in the program that drew it (repair, make manifold), or "
            "read ground by mpm.readTerrain"
        )


def _vtk():
    try:
        import vtk
    except ImportError:
        raise ImportError(
            "solidFromFile: which points are inside takes VTK, which is not installed; install it "
            "(Debian: python3-vtk9, else pip install vtk)"
        ) from None
    return vtk


def _polyData(vtk, points, triangles=()):
    from vtk.util.numpy_support import numpy_to_vtk

    made, corners, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    corners.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    for triangle in np.asarray(triangles).tolist():
        cells.InsertNextCell(3, triangle)
    made.SetPoints(corners)
    made.SetPolys(cells)
    return made
