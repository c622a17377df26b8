# SPDX-License-Identifier: GPL-2.0-or-later
"""The ground surface of a 2D scene: its polyline, heave and trough, isolated particles."""
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from .mesh import boundaryFacets


@dataclass
class Surface:
    """Ground surface, left to right.

    x, y : polyline, m; nan where a gap (a cavity, a body that sticks through) interrupts the ground.
    explicit : True at points that are vertices of a mesh, False where the surface was inferred from particles.
    continuous : whether neighbouring points of the polyline differ by less than a cell in height where both are
        ground, and no mesh vertex is missing.
    singleValued : whether x grows along the vertices of every mesh.
    isolated : number of particles that are connected to the main body of ground no more.
    """

    x: np.ndarray
    y: np.ndarray
    explicit: np.ndarray
    continuous: bool
    singleValued: bool
    isolated: int

    def areas(self, level):
        """Areas above and below a level, m2: (heave, trough); trapezoidal rule, gaps left out."""
        good = np.isfinite(self.y)
        x, dy = self.x[good], self.y[good] - level
        fine = np.linspace(x[0], x[-1], 20001)
        dy = np.interp(fine, x, dy)
        near = np.interp(fine, self.x, np.where(good, 1.0, 0.0)) > 0.5  # no area across a gap
        step = fine[1] - fine[0]
        return float((np.clip(dy, 0, None) * near).sum() * step), float((np.clip(-dy, 0, None) * near).sum() * step)


def groundSurface(scene, bodies, level):
    """Surface of the ground made of some bodies of a 2D scene.

    bodies : those that form the ground. level : height of the initial surface, m.

    Meshed bodies give their own boundary vertices; lattices of boxes give, for each column one particle spacing
    wide, the top of the highest particle that is connected to the ground. Connected means: in a patch of occupied grid
    cells (8 neighbours) that holds the most particles, meshed domains included.
    """
    if scene.dim != 2:
        raise ValueError("groundSurface: the scene is 3D; a surface line is defined in plane strain only")
    connected, isolated = _connected(scene, bodies)
    pieces, singleValued = [], True
    for body in bodies:
        if body.count == 0:
            continue
        if body.cells is None:
            pieces.append((*_columnTops(body, connected[body.name]), False))
        else:
            for chain in _topChains(body, level):
                singleValued &= bool((np.diff(chain[:, 0]) > 0).all())
                pieces.append((chain[:, 0], chain[:, 1], True))
    x = np.concatenate([p[0] for p in pieces])
    y = np.concatenate([p[1] for p in pieces])
    explicit = np.concatenate([np.full(len(p[0]), p[2]) for p in pieces])
    order = np.argsort(x, kind="stable")
    x, y, explicit = x[order], y[order], explicit[order]
    steps = np.abs(np.diff(y))
    continuous = bool((steps[np.isfinite(steps)] < max(scene.cell)).all())
    return Surface(x, y, explicit, continuous, singleValued, isolated)


def _connected(scene, bodies):
    """Dict body -> mask of particles in the largest patch of occupied cells, and the number outside it."""
    index = {b.name: np.floor((b.position - scene.lower) / scene.cell).astype(int) + 2 for b in bodies}
    occupied = np.zeros([n + 4 for n in scene.core.nodes], int)
    for b in bodies:
        np.add.at(occupied, tuple(index[b.name].T), 1)
    labels, count = ndimage.label(occupied > 0, structure=np.ones((3,) * scene.dim))
    if count == 0:
        return {b.name: np.zeros(0, bool) for b in bodies}, 0
    largest = 1 + int(np.argmax(ndimage.sum(occupied, labels, np.arange(1, count + 1))))
    masks = {b.name: labels[tuple(index[b.name].T)] == largest for b in bodies}
    return masks, int(sum((~m).sum() for m in masks.values()))


def _columnTops(body, connected):
    """Column centres and the top of the highest connected particle in each; nan for columns without one."""
    spacing, start = 2 * body.halfSize[0], body.reference[:, 0].min()
    column = np.round((body.position[:, 0] - start) / spacing).astype(int)
    first, last = column.min(), column.max()
    tops = np.full(last - first + 1, -np.inf)
    height = body.position[:, 1] + body.halfSize[1]
    np.maximum.at(tops, column[connected] - first, height[connected])
    return start + spacing * np.arange(first, last + 1), np.where(np.isfinite(tops), tops, np.nan)


def _topChains(body, level):
    """Chains of boundary vertices that lay on the initial surface, each (n, 2) from left to right as meshed."""
    start = np.asarray(body.core.view("vertexReference", True))
    facets = _boundary(body)
    top = facets[(np.abs(start[facets][:, :, 1] - level) < 1e-6).all(axis=1)]
    following = {int(b): int(a) for a, b in top}  # outward facets of the top run from right to left
    firsts = sorted(set(following) - set(following.values()), key=lambda v: start[v, 0])
    chains = []
    for v in firsts:
        chain = [v]
        while chain[-1] in following:
            chain.append(following[chain[-1]])
        chain = chain if start[chain[0], 0] < start[chain[-1], 0] else chain[::-1]
        chains.append(body.vertices[chain])
    return chains


def _boundary(body):
    """Edges that belong to one domain only."""
    if body.mesh is not None and body.converted == 0:
        return boundaryFacets(body.mesh)[0]
    cells = body.cells
    edges = np.concatenate([cells[:, [a, (a + 1) % 4]] for a in range(4)])
    _, inverse, counts = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    return edges[counts[inverse] == 1]
