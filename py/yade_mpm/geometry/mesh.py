# SPDX-License-Identifier: GPL-2.0-or-later
"""Quadrilateral and hexahedral meshes, the domains of APDI particles.

2D and 3D share one text: a cell is described by its corners in unit coordinates, counter-clockwise
in 2D, in VTK hexahedron order in 3D (bottom face counter-clockwise seen from above, then the top).
"""

from dataclasses import dataclass, field
from itertools import product

import numpy as np

from .. import _core
from ..base.kinds import MESH, takes

_QUAD = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
CORNERS = {2: _QUAD, 3: np.array([(*xy, z) for z in (0, 1) for xy in _QUAD])}
FACETS = {dim: _core.facetCorners(dim) for dim in (2, 3)}  # corners of each facet, outward
MAX_MASTERS = 4


@dataclass(eq=False, repr=False)
class Mesh:
    """Vertices, cells and hanging vertices.

    Parameters
    ----------
    points : (Nv, dim), m.
    cells : (Nc, 4 or 8), vertex numbers.
    slaves : (Ns,), vertices that sit on an edge or face of a coarser cell; default none.
    masters : (Ns, 4), corners of that edge or face, padded with -1; never slaves themselves.
    masterWeights : (Ns, 4), padded with 0; a slave is at sum(weight * master).
    cellNumbers : (Nc,), numbers that the cells had before `inRows`; None: they have them still.
    """

    points: np.ndarray
    cells: np.ndarray
    slaves: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    masters: np.ndarray = field(default_factory=lambda: np.zeros((0, MAX_MASTERS), int))
    masterWeights: np.ndarray = field(default_factory=lambda: np.zeros((0, MAX_MASTERS)))
    cellNumbers: np.ndarray = None

    def __repr__(self):
        return f"<Mesh {self.dim}D: {len(self.cells)} cells, {len(self.points)} points>"

    @property
    def dim(self):
        """2 or 3."""
        return self.points.shape[1]


@takes(mesh=MESH)
def boundaryFacets(mesh):
    """Facets on the surface of a mesh: edges in 2D, faces in 3D.

    Parameters
    ----------
    mesh : Mesh.

    A facet is on the surface if one cell only has it. Facets where fine cells meet a coarse one are
    left out. Returns (facets, owners): (Nf, 2 or 4) vertex numbers, ordered so that the outward
    normal is to the right of an edge or follows the right-hand rule on a face, and (Nf,) cell numbers.
    """
    table = FACETS[mesh.dim]
    facets = mesh.cells[:, table].reshape(-1, len(table[0]))
    owners = np.repeat(np.arange(len(mesh.cells)), len(table))
    _, index, count = np.unique(np.sort(facets, axis=1), axis=0, return_inverse=True, return_counts=True)
    isFree = count[index.ravel()] == 1
    facets, owners = facets[isFree], owners[isFree]
    isOuter = ~_isInterface(mesh, facets)
    return facets[isOuter], owners[isOuter]


def _isInterface(mesh, facets):
    """Which facets lie where a coarse cell meets fine ones.

    The vertices of such a facet are, or hang on, exactly the corners of one coarse facet among them.
    """
    corners = 2 ** (mesh.dim - 1)
    isFull = np.sum(mesh.masters >= 0, axis=1) == corners
    if not np.any(isFull):
        return np.zeros(len(facets), bool)
    hangsOn = np.tile(np.arange(len(mesh.points))[:, None], (1, MAX_MASTERS))
    hangsOn[mesh.slaves] = np.where(mesh.masters >= 0, mesh.masters, mesh.masters[:, :1])
    carriers = np.sort(hangsOn[facets].reshape(len(facets), -1), axis=1)
    isRepeat = np.pad(carriers[:, 1:] == carriers[:, :-1], ((0, 0), (1, 0)))
    hasRightCount = np.sum(~isRepeat, axis=1) == corners
    carriers = carriers[~isRepeat & hasRightCount[:, None]].reshape(-1, corners)
    coarse = {tuple(row) for row in np.sort(mesh.masters[isFull, :corners], axis=1)}
    coarse &= {tuple(row) for row in np.sort(facets, axis=1)}
    isInterface = np.zeros(len(facets), bool)
    isInterface[hasRightCount] = [tuple(row) in coarse for row in carriers]
    return isInterface


def facetAreas(corners):
    """Area of facets times their outward normal, m or m2 (N, dim), with corners in the order of `FACETS`."""
    if corners.shape[1] == 2:
        edge = corners[:, 1] - corners[:, 0]
        return np.stack([edge[:, 1], -edge[:, 0]], axis=1)
    return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])


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
