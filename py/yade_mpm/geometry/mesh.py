# SPDX-License-Identifier: GPL-2.0-or-later
"""Quadrilateral and hexahedral meshes, the domains of APDI particles.

2D and 3D share one text: a cell is described by its corners in unit coordinates, counter-clockwise
in 2D, in VTK hexahedron order in 3D (bottom face counter-clockwise seen from above, then the top).
"""

import os
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from .lattice import asSpacing, cellsInside, firstNear
from .regions import formatPoint

_QUAD = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
CORNERS = {2: _QUAD, 3: np.array([(*xy, z) for z in (0, 1) for xy in _QUAD])}
_MIRROR = {2: [0, 3, 2, 1], 3: [0, 3, 2, 1, 4, 7, 6, 5]}
_FACETS = {
    2: [(0, 1), (1, 2), (2, 3), (3, 0)],  # outward
    3: [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
}
_MAX_MASTERS = 4


@dataclass(eq=False)
class Mesh:
    """Vertices, cells and hanging vertices.

    points: (Nv, dim). cells: (Nc, 4 or 8) vertex numbers. slaves: (Ns,) vertices that sit on an edge
    or face of a coarser cell. masters: (Ns, 4) corners of that edge or face, padded with -1; never
    slaves themselves. masterWeights: (Ns, 4), padded with 0; a slave is at sum(weight * master).
    cellNumbers: (Nc,) numbers that the cells had before `inRows`; None: they have them still.
    """

    points: np.ndarray
    cells: np.ndarray
    slaves: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    masters: np.ndarray = field(default_factory=lambda: np.zeros((0, _MAX_MASTERS), int))
    masterWeights: np.ndarray = field(default_factory=lambda: np.zeros((0, _MAX_MASTERS)))
    cellNumbers: np.ndarray = None

    @property
    def dim(self):
        """2 or 3."""
        return self.points.shape[1]


def meshRegion(region, lower, upper, size, name):
    """Mesh of equal boxes whose centres are inside a region.

    region: Region. lower, upper: (dim,) corners of the grid; the mesh is anchored at lower.
    size: edge of a cell, a number or (dim,). name: of the body, for errors.
    Vertices and cells are ordered row by row, first axis fastest. Raises ValueError as `latticePoints` does.
    """
    size = asSpacing(size, region.dim, name)
    numbers = cellsInside(region, lower, upper, size, name)
    vertices, cells = _numberVertices(numbers[:, None] + CORNERS[region.dim])
    return Mesh(np.asarray(lower, float) + vertices * size, cells)


def refineNear(mesh, positions, halfSize, distance, ratio=2):
    """Mesh of which the cells close to given particles are split into ratio x ratio (x ratio).

    mesh: equal boxes, as `meshRegion` makes it. positions: (N, dim) particle centres. halfSize: of
    the particle boxes, a number, (dim,) or (N, dim). distance: cells closer than this are split, a
    cell exactly this far (within 1e-6 of the cell edge) is not. ratio: 1, 2, 3 ...
    Hanging vertices become slaves of the coarse edge (2 masters) or face (4 masters) they sit on.
    Vertices and cells are ordered row by row, the cells by centre. Raises ValueError if the mesh
    is refined already or not of equal boxes, or if distance or ratio are out of range.
    """
    if ratio != int(ratio) or ratio < 1:
        raise ValueError(f"refineNear: ratio = {ratio!r} must be a whole number from 1 up")
    if not 0 < distance < np.inf:
        raise ValueError(
            f"refineNear: distance = {distance!r} must be positive and finite; "
            "one coarse cell edge splits one ring of cells"
        )
    ratio = int(ratio)
    origin, size, numbers = _boxLattice(mesh)
    centres = origin + (numbers + 0.5) * size
    isSplit = firstNear(centres, size / 2, positions, halfSize, distance - 1e-6 * size.min()) >= 0
    if ratio == 1 or not np.any(isSplit):
        return mesh
    # From here on coordinates are whole numbers in units of the fine edge.
    corners = CORNERS[mesh.dim]
    coarse = (numbers[~isSplit, None] + corners) * ratio
    children = np.array(list(product(range(ratio), repeat=mesh.dim)))
    fine = (numbers[isSplit, None] * ratio + children).reshape(-1, 1, mesh.dim) + corners
    cellCorners = np.concatenate([coarse, fine])
    cellCorners = cellCorners[np.lexsort(cellCorners.sum(axis=1).T)]  # by centre
    vertices, cells = _numberVertices(cellCorners)
    slaves, masters, weights = _hangingVertices(vertices, coarse[:, 0], ratio)
    points = origin + vertices * (size / ratio)
    points[_find(vertices, _coarseVertices(mesh, numbers) * ratio)] = mesh.points  # to the last bit
    points[slaves] = np.einsum("sm,smd->sd", weights, points[masters])
    return Mesh(points, cells, slaves, masters, weights)


def meshFromArrays(points, cells, name):
    """Mesh from vertex coordinates and cells, checked.

    points: (Nv, 2 or 3); a z column of zeros is dropped if the cells are quadrilaterals.
    cells: (Nc, 4) quadrilaterals or (Nc, 8) hexahedra. name: of the body, for errors.
    Points that no cell uses are dropped. If all cells are mirrored they are turned over.
    Raises ValueError, with cell number and position, on a wrong shape, a number that is not finite,
    an index out of range, a repeated vertex, or a cell that is inverted, concave or collapsed.
    """
    points, cells = _asArrays(points, cells, name)
    outside = np.any((cells < 0) | (cells >= len(points)), axis=1)
    if np.any(outside):
        k = np.flatnonzero(outside)[0]
        raise ValueError(
            f"'{name}': cell {k} names vertices {cells[k].tolist()}, but the points are "
            f"numbered 0 to {len(points) - 1}; count from zero"
        )
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
    return Mesh(points, cells)


def meshFromFile(path, name):
    """Mesh from a file of any format that meshio reads (Gmsh, VTK, Abaqus, ...).

    path: of the file. It must hold quadrilaterals, or hexahedra, and no other cells of that
    dimension; cells of lower dimension (boundary lines, points) are ignored. name: of the body.
    Raises FileNotFoundError, ImportError without meshio, ValueError on an unreadable file, on other
    cells, and as `meshFromArrays` does.
    """
    try:
        import meshio
    except ImportError as error:
        raise ImportError(
            f"'{name}': reading {path} needs the meshio package; install it or use meshFromArrays"
        ) from error
    if not os.path.exists(path):  # meshio would leave the program
        raise FileNotFoundError(
            f"'{name}': there is no mesh file '{os.path.abspath(os.fsdecode(path))}'; correct the name"
        )
    try:
        content = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio leaves the program on a file it cannot read
        raise ValueError(f"'{name}': {path} is not a mesh file that meshio can read: {error}") from error
    dim = max((block.dim for block in content.cells), default=0)
    kind = {2: "quad", 3: "hexahedron"}.get(dim)
    others = sorted({block.type for block in content.cells if block.dim == dim and block.type != kind})
    if kind is None or others:
        raise ValueError(
            f"'{name}': {path} holds cells of type {', '.join(others) or 'none'}; "
            "only quad (2D) or hexahedron (3D) cells, of 4 or 8 vertices, are allowed"
        )
    return meshFromArrays(content.points, content.cells_dict[kind], name)


def boundaryFacets(mesh):
    """Facets on the surface of a mesh: edges in 2D, faces in 3D.

    A facet is on the surface if one cell only has it. Facets where fine cells meet a coarse one are
    left out. Returns (facets, owners): (Nf, 2 or 4) vertex numbers, ordered so that the outward
    normal is to the right of an edge or follows the right-hand rule on a face, and (Nf,) cell numbers.
    """
    table = _FACETS[mesh.dim]
    facets = mesh.cells[:, table].reshape(-1, len(table[0]))
    owners = np.repeat(np.arange(len(mesh.cells)), len(table))
    _, index, count = np.unique(np.sort(facets, axis=1), axis=0, return_inverse=True, return_counts=True)
    isFree = count[index.ravel()] == 1
    facets, owners = facets[isFree], owners[isFree]
    isOuter = ~_isInterface(mesh, facets)
    return facets[isOuter], owners[isOuter]


def cellVolumes(points, cells):
    """Areas (2D) or volumes (3D) of cells, exact for bilinear and trilinear cells (2^dim Gauss points).

    points: (Nv, dim). cells: (Nc, 4 or 8). Returns (Nc,); mirrored cells count negative.
    """
    corners = points[cells]
    dim = points.shape[1]
    volumes = np.zeros(len(cells))
    for signs in product((-1, 1), repeat=dim):
        volumes += np.linalg.det(_jacobian(corners, 0.5 + np.array(signs) / np.sqrt(12)))
    return volumes / 2**dim


def cornerJacobians(points, cells):
    """Jacobian determinants of the map from the unit cell, at the corners; all are positive in a convex cell.

    points: (Nv, dim). cells: (Nc, 4 or 8). Returns (Nc, 4 or 8).
    """
    corners = points[cells]
    return np.stack([np.linalg.det(_jacobian(corners, at)) for at in CORNERS[points.shape[1]]], axis=1)


def _jacobian(corners, at):
    """dx/dxi (Nc, dim, dim) at unit coordinates of cells with given corners (Nc, 4 or 8, dim)."""
    unit = CORNERS[len(at)]
    factors = np.where(unit == 1, at, 1 - np.asarray(at, float))
    gradient = 2.0 * unit - 1
    for d in range(len(at)):
        gradient[:, d] *= np.prod(np.delete(factors, d, axis=1), axis=1)
    return np.einsum("cai,ad->cid", corners, gradient)


def _keys(numbers, counts):
    """One number per lattice point, in row order (first axis fastest)."""
    return numbers @ np.concatenate(([1], np.cumprod(counts[:-1])))


def _numberVertices(cellCorners):
    """Shared vertices (Nv, dim) in row order, and cells, from lattice corners (Nc, corners, dim)."""
    shift = cellCorners.min(axis=(0, 1))
    counts = cellCorners.max(axis=(0, 1)) - shift + 1
    _, first, cells = np.unique(_keys(cellCorners - shift, counts), return_index=True, return_inverse=True)
    return cellCorners.reshape(-1, cellCorners.shape[-1])[first], cells.reshape(cellCorners.shape[:2])


def _find(vertices, wanted):
    """Numbers of wanted lattice points among vertices, which are in row order; -1 where absent."""
    shift, counts = vertices.min(axis=0), np.ptp(vertices, axis=0) + 1
    keys, wantedKeys = _keys(vertices - shift, counts), _keys(wanted - shift, counts)
    at = np.minimum(np.searchsorted(keys, wantedKeys), len(keys) - 1)
    return np.where(keys[at] == wantedKeys, at, -1)


def _hangingVertices(vertices, coarse, ratio):
    """Slaves, masters, weights of vertices on edges or faces of unsplit cells, given by lower corner."""
    dim = vertices.shape[1]
    slaves = [np.zeros(0, int)]
    masters = [np.zeros((0, _MAX_MASTERS), int)]
    weights = [np.zeros((0, _MAX_MASTERS))]
    for local in np.array(list(product(range(ratio + 1), repeat=dim))):
        isInner = (local > 0) & (local < ratio)
        if np.all(isInner) or not np.any(isInner):
            continue
        found = _find(vertices, coarse + local)
        cells, found = coarse[found >= 0], found[found >= 0]
        weight = np.prod(np.where(CORNERS[dim] == 1, local / ratio, 1 - local / ratio), axis=1)
        active = np.flatnonzero(weight)
        corner = np.full((len(found), _MAX_MASTERS), -1)
        corner[:, : len(active)] = _find(vertices, cells[:, None] + CORNERS[dim][active] * ratio)
        slaves.append(found)
        masters.append(corner)
        weights.append(np.tile(np.pad(weight[active], (0, _MAX_MASTERS - len(active))), (len(found), 1)))
    # A vertex on an edge is met from every coarse cell round it, each time with the same masters.
    slaves, first = np.unique(np.concatenate(slaves), return_index=True)
    masters, weights = np.concatenate(masters)[first], np.concatenate(weights)[first]
    assert not np.any(np.isin(masters, slaves)), "a slave vertex has a slave as master"
    return slaves, masters, weights


def _boxLattice(mesh):
    """Origin, cell edges (dim,) and cell numbers (Nc, dim) of a mesh of equal boxes on a lattice."""
    corners = mesh.points[mesh.cells]
    lower, extent = corners.min(axis=1), np.ptp(corners, axis=1)
    origin, size = mesh.points.min(axis=0), extent[0]
    numbers = np.round((lower - origin) / size).astype(int)
    expected = origin + (numbers[:, None] + CORNERS[mesh.dim]) * size
    if len(mesh.slaves) or np.any(np.abs(corners - expected) > 1e-6 * size):
        raise ValueError(
            "refineNear: the mesh is not made of equal boxes with shared corners; "
            "give it as meshRegion() makes it, and refine once only"
        )
    return origin, size, numbers


def _coarseVertices(mesh, numbers):
    """Lattice coordinates (Nv, dim) of the vertices of a mesh of equal boxes."""
    coordinates = np.zeros((len(mesh.points), mesh.dim), int)
    coordinates[mesh.cells] = numbers[:, None] + CORNERS[mesh.dim]
    return coordinates


def _isInterface(mesh, facets):
    """Which facets lie where a coarse cell meets fine ones.

    The vertices of such a facet are, or hang on, exactly the corners of one coarse facet.
    """
    corners = 2 ** (mesh.dim - 1)
    isFull = np.sum(mesh.masters >= 0, axis=1) == corners
    if not np.any(isFull):
        return np.zeros(len(facets), bool)
    hangsOn = np.tile(np.arange(len(mesh.points))[:, None], (1, _MAX_MASTERS))
    hangsOn[mesh.slaves] = np.where(mesh.masters >= 0, mesh.masters, mesh.masters[:, :1])
    carriers = np.sort(hangsOn[facets].reshape(len(facets), -1), axis=1)
    isRepeat = np.pad(carriers[:, 1:] == carriers[:, :-1], ((0, 0), (1, 0)))
    hasRightCount = np.sum(~isRepeat, axis=1) == corners
    carriers = carriers[~isRepeat & hasRightCount[:, None]].reshape(-1, corners)
    coarse = {tuple(row) for row in np.sort(mesh.masters[isFull, :corners], axis=1)}
    isInterface = np.zeros(len(facets), bool)
    isInterface[hasRightCount] = [tuple(row) in coarse for row in carriers]
    return isInterface


def _asArrays(points, cells, name):
    points, cells = np.array(points, float), np.array(cells)
    hasShape = cells.ndim == 2 and cells.shape[1] in (4, 8) and len(cells)
    if not hasShape or not np.issubdtype(cells.dtype, np.integer):
        raise ValueError(
            f"'{name}': cells has shape {cells.shape} and type {cells.dtype}; "
            "(Nc, 4) or (Nc, 8) vertex numbers (int) are needed"
        )
    dim = 2 if cells.shape[1] == 4 else 3
    if points.ndim == 2 and points.shape[1] == 3 and dim == 2:
        if np.any(np.abs(points[:, 2]) > 1e-12 * np.max(np.abs(points))):
            raise ValueError(
                f"'{name}': quadrilaterals must lie in the plane z = 0, but z reaches "
                f"{np.max(np.abs(points[:, 2])):.9g}; use hexahedra in 3D"
            )
        points = points[:, :2]
    if points.ndim != 2 or points.shape[1] != dim:
        raise ValueError(
            f"'{name}': points has shape {points.shape}, but cells of {cells.shape[1]} vertices "
            f"need (Nv, {dim})"
        )
    bad = np.flatnonzero(~np.all(np.isfinite(points), axis=1))
    if len(bad):
        raise ValueError(f"'{name}': point {bad[0]} at {formatPoint(points[bad[0]])} is not finite")
    return points, cells.astype(int)


def _refuseCells(isBad, points, cells, name, complaint):
    if np.any(isBad):
        k = np.flatnonzero(isBad)[0]
        place = formatPoint(points[cells[k]].mean(axis=0).round(9))
        raise ValueError(f"'{name}': cell {k} at {place} {complaint} ({np.sum(isBad)} such cells)")
