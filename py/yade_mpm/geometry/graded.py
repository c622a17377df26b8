# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes whose domains follow the cells of a graded grid.

They are made where every cell has the smallest size (the grid unfolded), and then put back on the lines: so
domains grow with the cells, and what is refined beside particles is so by the size of the cell there.
"""

from dataclasses import replace

import numpy as np

from .meshing import meshRegion, refineNear
from .region import Region

_ON_EDGE = 1e-6  # of a domain


class Unfolding:
    """The way from a graded grid to one of equal cells, and back.

    lines: list of (Ni,) positions across each axis, m. cell: (dim,) edges of the smallest cells, m.
    """

    def __init__(self, lines, cell):
        self.lines, self.dim = [np.asarray(x) for x in lines], len(lines)
        self.even = [x[0] + np.arange(len(x)) * h for x, h in zip(self.lines, cell)]

    def unfold(self, points):
        """Where points (N, dim) of the grid are on equal cells; beyond its ends the outermost cells go on."""
        return self._mapped(points, self.lines, self.even)

    def fold(self, points):
        """The way back."""
        return self._mapped(points, self.even, self.lines)

    def _mapped(self, points, start, end):
        points = np.asarray(points, float)
        mapped = np.empty(points.shape)
        for k in range(self.dim):
            a, b, x = start[k], end[k], points[:, k]
            i = np.clip(np.searchsorted(a, x, "right") - 1, 0, len(a) - 2)
            mapped[:, k] = b[i] + (x - a[i]) / (a[i + 1] - a[i]) * (b[i + 1] - b[i])
        return mapped

    def coordinate(self, axis, x):
        """A coordinate along an axis, unfolded."""
        point = np.zeros((1, self.dim))
        point[0, axis] = x
        return float(self.unfold(point)[0, axis])


class _Unfolded(Region):
    """A region as it is on equal cells."""

    def __init__(self, region, unfolding):
        super().__init__(region.dim)
        self._region, self._unfolding = region, unfolding

    def __repr__(self):
        return repr(self._region)

    def contains(self, points, closed=True):
        return self._region.contains(self._unfolding.fold(points), closed)

    def bounds(self):
        far = 1e9  # m; corners at infinity stay there
        corners = np.array(self._region.bounds(), float)
        found = self._unfolding.unfold(np.clip(corners, -far, far))
        return tuple(np.where(np.isfinite(corners), found, corners))

    def edges(self):
        return [(axis, self._unfolding.coordinate(axis, x)) for axis, x in self._region.edges()]


def meshOnLines(region, scene, size, name):
    """Mesh of a region with domains of the edges `size` (dim,), m, where cells are smallest, unfolded.

    Raises ValueError for an edge of the region that is not on a line of the mesh, and as `meshRegion` does.
    """
    unfolding = Unfolding(scene.lines, scene.cell)
    for axis, x in region.edges():
        steps = (unfolding.coordinate(axis, x) - scene.lower[axis]) / size[axis]
        if abs(steps - round(steps)) > _ON_EDGE:
            ends = np.repeat([scene.lower], 2, axis=0)
            ends[:, axis] += np.array([np.floor(steps), np.ceil(steps)]) * size[axis]
            below, above = unfolding.fold(ends)[:, axis]
            raise ValueError(
                f"body '{name}': edge {'xyz'[axis]} = {x:.9g} is not on a line of the mesh, which follows "
                f"the graded grid; move it to {below:.9g} or {above:.9g}, or change size or grading"
            )
    upper = np.array([x[-1] for x in unfolding.even])
    return meshRegion(_Unfolded(region, unfolding), scene.lower, upper, size, name)


def refined(mesh, scene, boxes, ratio):
    """An unfolded mesh with the domains within one cell of boxes (a body) split."""
    unfolding = Unfolding(scene.lines, scene.cell)
    lower = unfolding.unfold(boxes.position - boxes.halfSize)
    upper = unfolding.unfold(boxes.position + boxes.halfSize)
    return refineNear(mesh, (lower + upper) / 2, (upper - lower) / 2, float(min(scene.cell)), ratio)


def folded(mesh, scene):
    """A mesh on equal cells, put on the lines of a graded grid."""
    points = Unfolding(scene.lines, scene.cell).fold(mesh.points)
    if len(mesh.slaves):
        points[mesh.slaves] = np.einsum("sm,smd->sd", mesh.masterWeights, points[mesh.masters])
    return replace(mesh, points=points)
