# SPDX-License-Identifier: GPL-2.0-or-later
"""The ground surface of a 2D scene: its polyline, heave and trough, isolated particles."""
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from .mesh import boundaryFacets


@dataclass
class Surface:
    """Ground surface, left to right.

    x, y : polyline, m; nan where no ground is connected below. explicit : True at vertices of a mesh, False where the
    surface was inferred from particles.
    hole : interval of x, m, in which something goes through the ground; None: nowhere.
    singleValued : whether x grows along the vertices of every mesh.
    isolated : number of particles that are connected to the main body of ground no more.
    """

    x: np.ndarray
    y: np.ndarray
    explicit: np.ndarray
    hole: tuple
    singleValued: bool
    isolated: int

    def _outside(self):
        return np.ones(len(self.x), bool) if self.hole is None else (self.x < self.hole[0]) | (self.x > self.hole[1])

    def isContinuous(self, jump):
        """Whether neighbouring points outside the hole differ by less than `jump` (m) in height, with no point missing."""
        outside = self._outside()
        steps = np.abs(np.diff(self.y))[outside[1:] & outside[:-1]]
        return bool(np.isfinite(self.y[outside]).all() and (steps < jump).all())

    def areas(self, level):
        """Areas between surface and a level, m2: (heave above, trough below outside the hole, cavity below inside it)."""
        good = np.isfinite(self.y)
        x = np.linspace(self.x[good][0], self.x[good][-1], 20001)
        rise = np.interp(x, self.x[good], self.y[good]) - level
        inHole = np.zeros(len(x), bool) if self.hole is None else (x >= self.hole[0]) & (x <= self.hole[1])
        step = x[1] - x[0]
        below = np.clip(-rise, 0, None) * step
        return float(np.clip(rise, 0, None).sum() * step), float(below[~inHole].sum()), float(below[inHole].sum())


def groundSurface(scene, bodies, level, hole=None):
    """Surface of the ground made of some bodies of a 2D scene.

    bodies : those that form the ground. level : height of the initial surface, m. hole : interval (x0, x1), m, in which
    something goes through the ground; it is left out of the continuity and counts as cavity in the areas.

    Meshed bodies give their own boundary vertices. Lattices of boxes give, for each column one particle spacing wide
    that is not below a mesh, the top of the highest particle that is connected to the ground: in the patch of occupied
    grid cells (8 neighbours), meshed domains included, that holds the most particles.
    """
    if scene.dim != 2:
        raise ValueError("groundSurface: the scene is 3D; a surface line is defined in plane strain only")
    bodies = [b for b in bodies if b.count]
    connected, isolated = _connected(scene, bodies)
    chains = [c for b in bodies if b.cells is not None for c in _topChains(b, level)]
    singleValued = all((np.diff(c[:, 0]) > 0).all() for c in chains)
    pieces = [(c[:, 0], c[:, 1], np.ones(len(c), bool)) for c in chains]
    for body in bodies:
        if body.cells is None:
            x, y = _columnTops(body, connected[body.name])
            open_ = np.all([(x < c[:, 0].min()) | (x > c[:, 0].max()) for c in chains], axis=0) if chains else np.ones(len(x), bool)
            pieces.append((x[open_], y[open_], np.zeros(open_.sum(), bool)))
    x, y, explicit = (np.concatenate([p[k] for p in pieces]) for k in range(3))
    order = np.argsort(x, kind="stable")
    return Surface(x[order], y[order], explicit[order], hole, singleValued, isolated)


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
