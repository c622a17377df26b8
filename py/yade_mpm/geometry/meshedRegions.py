# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes of quadrilaterals and hexahedra that Gmsh makes of regions in a plane."""

from __future__ import annotations

import numpy as np

from ..base.kinds import NUMBER, POSITIVE, REGIONS, Kind, takes
from ..base.wording import shown
from .mesh import Mesh
from .meshInput import meshFromArrays
from .numbers import formatPoint
from .polygon import Polygon
from .primitives import Ball, Box
from .region import Composed

AXIS = Kind("'x', 'y' or 'z'", lambda value: value in ("x", "y", "z"))
QUADRILATERAL = 3  # of Gmsh's types of cells
BOOLEANS = {"union": "fuse", "difference": "cut", "intersection": "intersect"}
OPTIONS = {
    "General.Terminal": 0,
    "Mesh.RecombineAll": 1,
    "Mesh.SubdivisionAlgorithm": 1,  # what is left of triangles, too; halves the size
    "Mesh.Smoothing": 5,
}


@takes(regions=REGIONS, size=POSITIVE, start=NUMBER, end=NUMBER, axis=AXIS)
def meshesFromRegions(
    regions: dict, size: float, start: float | None = None, end: float | None = None, axis: str = "z"
) -> dict[str, Mesh]:
    """Meshes of regions with slanted and curved edges, made by Gmsh; where they meet they share vertices.

        soils = mpm.polygonsFromFile("section.dxf")
        for name, mesh in mpm.meshesFromRegions(soils, size=0.5).items():
            scene.add(name, mesh, laws[name], mpm.APDI())

    Parameters
    ----------
    regions : dict name -> region in 2D, of boxes, discs and polygons, also composed.
    size : m, edge of a cell, about.
    start, end : m, ends along the axis, for a mesh of hexahedra; default: a mesh in 2D.
    axis : "x", "y" or "z", of the mesh of hexahedra; the regions are in the two others, as of `prism`.

    Returns a dict name -> Mesh. Raises ImportError where gmsh is missing, ValueError for regions that overlap
    or are empty, or that Gmsh cannot mesh.
    """
    if (start is None) != (end is None) or start is not None and not start < end:
        raise ValueError(
            f"meshesFromRegions: start = {shown(start)}, end = {shown(end)} are not allowed; give both, "
            "start below end, or none for a mesh in 2D"
        )
    gmsh = _gmsh()
    isOurs = not _isInitialized(gmsh)
    if isOurs:
        gmsh.initialize([], False)  # without files of options
    gmsh.model.add("yade_mpm")
    try:
        # Frontal, for quadrilaterals; Gmsh 4.8 of Debian 12 crashes with it, and takes that for triangles.
        algorithm = 8 if hasattr(gmsh, "isInitialized") else 6
        sizes = {"Mesh.MeshSizeMax": 2 * size, "Mesh.MeshSizeMin": 2 * size}
        for option, value in {**OPTIONS, **sizes, "Mesh.Algorithm": algorithm}.items():
            gmsh.option.setNumber(option, value)
        meshes = _cellsOf(gmsh, regions)
    finally:
        gmsh.finalize() if isOurs else gmsh.model.remove()
    if start is not None:
        layers = np.linspace(start, end, max(1, round((end - start) / size)) + 1)
        meshes = {name: _drawnAlong(*mesh, layers, "xyz".index(axis)) for name, mesh in meshes.items()}
    return {name: meshFromArrays(*mesh, name) for name, mesh in meshes.items()}


def _cellsOf(gmsh, regions):
    """Dict name -> (points (N, 2), quadrilaterals (M, 4)) of regions, which Gmsh fits together."""
    parts = [_surfacesOf(gmsh, name, region) for name, region in regions.items()]
    flat = [surface for surfaces in parts for surface in surfaces]
    pieces = gmsh.model.occ.fragment(flat, [])[1] if len(flat) > 1 else [flat]
    gmsh.model.occ.synchronize()
    owned, meshes = {}, {}
    for name, surfaces in zip(regions, parts):
        own = {piece for surface in surfaces for piece in pieces[flat.index(surface)] if piece[0] == 2}
        for piece in own:
            if piece in owned:
                place = formatPoint(np.round(gmsh.model.occ.getCenterOfMass(*piece)[:2], 6))
                raise ValueError(
                    f"meshesFromRegions: '{owned[piece]}' and '{name}' overlap at {place}; subtract one "
                    "from the other"
                )
            owned[piece] = name
        meshes[name] = sorted(own)
    try:
        gmsh.model.mesh.generate(2)
    except Exception as error:  # Gmsh has no class of its own
        raise ValueError(
            f"meshesFromRegions: Gmsh makes no mesh: {error}; give another size, or simpler regions"
        ) from None
    return {name: _quadrilaterals(gmsh, own) for name, own in meshes.items()}


def _surfacesOf(gmsh, name, region):
    """Gmsh's surfaces of a region."""
    occ = gmsh.model.occ
    if isinstance(region, Composed) and region.dim == 2:
        first, second = (_surfacesOf(gmsh, name, operand) for operand in (region._a, region._b))
        surfaces = getattr(occ, BOOLEANS[region._kind])(first, second)[0]
        if not surfaces:
            raise ValueError(f"meshesFromRegions: '{name}': {shown(region)} is empty; give another region")
        return surfaces
    if isinstance(region, Box) and region.dim == 2:
        lower, upper = region.bounds()
        return [(2, occ.addRectangle(*lower, 0, *(upper - lower)))]
    if isinstance(region, Ball) and region.dim == 2:
        return [(2, occ.addDisk(*region._centre, 0, region._radius, region._radius))]
    if isinstance(region, Polygon):
        corners = [occ.addPoint(x, y, 0) for x, y in region._points]
        lines = [occ.addLine(a, b) for a, b in zip(corners, [*corners[1:], corners[0]])]
        return [(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))]
    raise TypeError(
        f"meshesFromRegions: '{name}': {shown(region)} has no mesh; give boxes, discs and polygons in 2D, or "
        "what +, - and & make of them"
    )


def _quadrilaterals(gmsh, surfaces):
    tags, places, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    cells = [np.asarray(gmsh.model.mesh.getElementsByType(QUADRILATERAL, tag)[1]) for _, tag in surfaces]
    corners = order[np.searchsorted(tags, np.concatenate(cells), sorter=order)]
    return places.reshape(-1, 3)[:, :2], corners.reshape(-1, 4).astype(int)


def _drawnAlong(points, cells, layers, axis):
    """Points (N, 3) and hexahedra of quadrilaterals that are drawn along an axis."""
    drawn = np.tile(points, (len(layers), 1))
    drawn = np.insert(drawn, axis, np.repeat(layers, len(points)), axis=1)
    first = len(points) * np.arange(len(layers) - 1)[:, None, None]
    return drawn, np.concatenate((first + cells, first + len(points) + cells), axis=2).reshape(-1, 8)


def _isInitialized(gmsh):
    if hasattr(gmsh, "isInitialized"):
        return gmsh.isInitialized()
    try:  # Gmsh 4.8 has no function for it, but a model while it runs
        return bool(gmsh.model.list())
    except Exception:
        return False


def _gmsh():
    try:
        import gmsh
    except (ImportError, OSError):  # OSError: a library of the system that it takes is missing
        gmsh = None
    if gmsh is None or not hasattr(gmsh.lib, "gmshInitialize"):  # Gmsh's module without Gmsh itself
        missing = "gmsh, which is not" if gmsh is None else "the library of gmsh, and only its module is"
        raise ImportError(
            f"meshesFromRegions takes {missing} installed; install it (Debian: python3-gmsh, else "
            "pip install gmsh), or read a mesh by meshesFromFile"
        ) from None
    return gmsh
