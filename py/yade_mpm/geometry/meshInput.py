# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes that users bring, as arrays or files, checked."""

import os
from importlib.util import find_spec

import numpy as np

from ..base.kinds import FILE, Kind, requireFile, takes
from .mesh import Mesh, cellVolumes, cornerJacobians
from .meshChecks import checkIndices, checkMesh
from .meshReader import readMesh
from .numbers import formatPoint, numbers

_MIRROR = {2: [0, 3, 2, 1], 3: [0, 3, 2, 1, 4, 7, 6, 5]}

MESH_FILE = Kind("the name of a mesh file", lambda value: FILE.isOne(value) or isinstance(value, bytes))


def meshFromArrays(points, cells, name):
    """Mesh from vertex coordinates and cells, checked.

    Parameters
    ----------
    points : (Nv, 2 or 3), m; a z column of zeros is dropped if the cells are quadrilaterals.
    cells : (Nc, 4) quadrilaterals or (Nc, 8) hexahedra.
    name : of the body, for errors.

    Points that no cell uses are dropped. If all cells are mirrored they are turned over.
    Raises ValueError, with cell number and position, on a wrong shape, a number that is not finite,
    an index out of range, a repeated vertex, or a cell that is inverted, concave or collapsed.
    """
    points, cells = _asArrays(points, cells, name)
    checkIndices(name, points, cells)
    ordered = np.sort(cells, axis=1)
    _refuseCells(
        np.any(ordered[:, 1:] == ordered[:, :-1], axis=1),
        points,
        cells,
        name,
        "names a vertex twice; use quadrilaterals and hexahedra with distinct corners",
    )
    used, cells = np.unique(cells, return_inverse=True)
    points, cells = points[used], cells.reshape(ordered.shape)
    isInverted = cellVolumes(points, cells) < 0
    if np.all(isInverted):
        cells, isInverted = cells[:, _MIRROR[points.shape[1]]], ~isInverted
    _refuseCells(isInverted, points, cells, name, "is inverted; order its vertices as in the other cells")
    jacobians = cornerJacobians(points, cells)
    isBad = jacobians.min(axis=1) <= 1e-10 * np.abs(jacobians).max(axis=1)
    _refuseCells(isBad, points, cells, name, "is concave or collapsed; every corner must be convex")
    return checkMesh(name, Mesh(points, cells))


@takes(path=MESH_FILE)
def meshFromFile(path, name):
    """Mesh from a file of any format that meshio reads (Gmsh, VTK, Abaqus, ...).

    Parameters
    ----------
    path : of the file. It must hold quadrilaterals, or hexahedra, and no other cells of that dimension;
        cells of lower dimension (boundary lines, points) are ignored.
    name : of the body, for errors.

    Raises FileNotFoundError, ImportError without meshio, ValueError on an unreadable file, on other
    cells, and as `meshFromArrays` does.
    """
    points, cells, _ = _readFile(path, name)
    return meshFromArrays(points, _wantedCells(path, cells, name), name)


@takes(path=MESH_FILE)
def meshesFromFile(path):
    """The meshes of the groups of a file: physical groups of Gmsh, sets of Abaqus.

        for name, mesh in mpm.meshesFromFile("slope.msh").items():
            scene.add(name, mesh, laws[name])

    Parameters
    ----------
    path : of the file, as of `meshFromFile`. Groups of lower dimension (lines, in 3D surfaces) are left out.

    Returns a dict name of the group -> Mesh. Raises ValueError for a file without groups, or one whose cells
    belong to none or to several of them, and as `meshFromFile` does.
    """
    who = os.path.basename(os.fsdecode(path))
    points, cells, groups = _readFile(path, who)
    _wantedCells(path, cells, who)
    dim = max(cellsDim for _, cellsDim, _ in cells)
    blocks = [k for k, (_, cellsDim, _) in enumerate(cells) if cellsDim == dim]
    found = {name: [(k, rows[k]) for k in blocks if len(rows[k])] for name, rows in groups.items()}
    found = {name: parts for name, parts in found.items() if parts}
    times = [np.zeros(len(corners), int) for _, _, corners in cells]
    for parts in found.values():
        for k, rows in parts:
            times[k][rows] += 1
    wrong = sum(int((times[k] != 1).sum()) for k in blocks)
    if not found or wrong:
        raise ValueError(
            f"mesh '{who}': {wrong} cells belong to no group or to several; give each part one physical "
            "group in "
            "Gmsh, or read the file with meshFromFile"
        )
    return {
        name: meshFromArrays(points, np.concatenate([cells[k][2][rows] for k, rows in parts]), name)
        for name, parts in found.items()
    }


def _readFile(path, name):
    if find_spec("meshio") is None:
        raise ImportError(
            f"mesh '{name}': reading {path} needs the meshio package; install it or use meshFromArrays"
        )
    path = requireFile(f"mesh '{name}'", os.fsdecode(path), "the name of a mesh file")
    try:
        return readMesh(path)
    except RuntimeError as error:
        raise ValueError(f"mesh '{name}': {path} is not a mesh file that meshio can read: {error}") from error


def _wantedCells(path, cells, name):
    """The quadrilaterals or hexahedra, where all cells of the highest dimension are such."""
    dim = max((cellsDim for _, cellsDim, _ in cells), default=0)
    wanted = {2: "quad", 3: "hexahedron"}.get(dim)
    others = sorted({kind for kind, cellsDim, _ in cells if cellsDim == dim and kind != wanted})
    if wanted is None or others:
        isGmsh = set(others) & {"triangle", "tetra"}
        options = f"-{dim} -setnumber Mesh.RecombineAll 1 -setnumber Mesh.SubdivisionAlgorithm {dim - 1}"
        raise ValueError(
            f"mesh '{name}': {os.fsdecode(path)} holds cells of type {', '.join(others) or 'none'}; "
            "only quad (2D) or hexahedron (3D) cells, of 4 or 8 vertices, are allowed"
            + (f"; Gmsh makes them by: gmsh model.geo {options}" if isGmsh else "")
        )
    return np.concatenate([c for kind, _, c in cells if kind == wanted])


def _asArrays(points, cells, name):
    points, cells = numbers(f"mesh '{name}'", "points", points), np.array(cells)
    hasShape = cells.ndim == 2 and cells.shape[1] in (4, 8) and len(cells)
    if not hasShape or not np.issubdtype(cells.dtype, np.integer):
        raise ValueError(
            f"mesh '{name}': cells has shape {cells.shape} and type {cells.dtype}; "
            "give (Nc, 4) or (Nc, 8) vertex numbers (int)"
        )
    dim = 2 if cells.shape[1] == 4 else 3
    if points.ndim == 2 and points.shape[1] == 3 and dim == 2:
        if np.any(np.abs(points[:, 2]) > 1e-12 * np.max(np.abs(points))):
            raise ValueError(
                f"mesh '{name}': quadrilaterals must lie in the plane z = 0, but z reaches "
                f"{np.max(np.abs(points[:, 2])):.9g}; use hexahedra in 3D"
            )
        points = points[:, :2]
    if points.ndim != 2 or points.shape[1] != dim:
        raise ValueError(
            f"mesh '{name}': points has shape {points.shape}, but cells of {cells.shape[1]} vertices "
            f"need (Nv, {dim})"
        )
    bad = np.flatnonzero(~np.all(np.isfinite(points), axis=1))
    if len(bad):
        raise ValueError(
            f"mesh '{name}': point {bad[0]} at {formatPoint(points[bad[0]])} is not finite; give numbers"
        )
    return points, cells.astype(int)


def _refuseCells(isBad, points, cells, name, complaint):
    if np.any(isBad):
        k = np.flatnonzero(isBad)[0]
        place = formatPoint(points[cells[k]].mean(axis=0).round(9))
        raise ValueError(f"mesh '{name}': cell {k} at {place} {complaint} ({np.sum(isBad)} such cells)")
