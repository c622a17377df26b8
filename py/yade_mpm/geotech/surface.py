# SPDX-License-Identifier: GPL-2.0-or-later
"""The ground surface of a 2D scene: its polyline, heave, trough and cavity, isolated particles."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..base.kinds import BODIES, NUMBER, NUMBERS, SCENE, takes
from ..geometry.lattice import _boxDistance
from ..geometry.mesh import boundaryFacets

_BRIDGED = 0.5  # cells: a wider gap parts the ground
_PER_BOX = 4  # strips that a box is seen in


@dataclass
class Surface:
    """Ground surface, left to right.

    Parameters
    ----------
    x, y : polyline, m; y is nan where no ground is.
    explicit : True at vertices of a mesh, False where the surface was inferred from particles.
    hole : interval of x, m, of what goes through the ground; None: nothing does.
    singleValued : whether x grows along the vertices of every mesh; None where the surface has no mesh. The
        inferred part has one height at each x by construction: what hangs over in it is not seen.
    isolated : number of particles that hang together with the main body of ground no more.
    """

    x: np.ndarray
    y: np.ndarray
    explicit: np.ndarray
    hole: tuple
    singleValued: bool
    isolated: int

    def isContinuous(self, jump):
        """Whether nothing interrupts the surface from end to end, or from both ends to the hole.

        Parameters
        ----------
        jump : m; a step of that or more interrupts it, a place without ground, too.
        """
        if self.hole is None:
            return not self._breaks(jump).any()
        return max(self.openBeside(jump)) < jump

    def openBeside(self, jump):
        """Widths to the left and to the right of the hole that the surface does not reach, m.

        Parameters
        ----------
        jump : m; a step of that or more on the way from either end interrupts it, a place without ground,
            too.
        """
        left, right = self._crater(jump)
        return float(self.hole[0] - left), float(right - self.hole[1])

    def areas(self, level, jump):
        """Areas between surface and a level, m2: (heave above, trough below, cavity below).

        Parameters
        ----------
        level : m, height.
        jump : m, as of `openBeside`.

        The cavity is what is below the level in the places of `openBeside`; the hole counts nowhere. Where no
        ground is, the surface is interpolated.
        """
        left, right = self._crater(jump)
        ends = (np.inf, -np.inf) if self.hole is None else self.hole
        good = np.isfinite(self.y)
        edges = np.linspace(self.x[good][0], self.x[good][-1], 20001)
        x, step = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
        rise = np.where((x > ends[0]) & (x < ends[1]), 0, np.interp(x, self.x[good], self.y[good]) - level)
        isCavity = (x > left) & (x < right)
        below = np.clip(-rise, 0, None) * step
        return (
            float(np.clip(rise, 0, None).sum() * step),
            float(below[~isCavity].sum()),
            float(below[isCavity].sum()),
        )

    def _breaks(self, jump):
        """Whether the surface is interrupted between each point and the next."""
        return ~(np.abs(np.diff(self.y)) < jump)

    def _crater(self, jump):
        """Interval of x, m, that holds the hole and the open ground beside it."""
        if self.hole is None:
            return np.inf, -np.inf
        left, right = self.x <= self.hole[0], self.x >= self.hole[1]
        return (
            _reach(self.x[left], self._breaks(jump)[left[:-1]], self.hole[0]),
            -_reach(-self.x[right][::-1], self._breaks(jump)[right[1:]][::-1], -self.hole[1]),
        )


def _reach(x, breaks, hole):
    """Last x before the first break on the way to the hole, at most that of the hole; breaks[i] is that
    between point i and the next."""
    if len(x) == 0:  # the hole is at the end of the ground
        return hole
    inner = np.flatnonzero(breaks[: len(x) - 1])
    return min(x[inner[0]] if len(inner) else x[-1], hole)


@takes(scene=SCENE, bodies=BODIES, level=NUMBER, hole=NUMBERS)
def groundSurface(scene, bodies, level, hole=None):
    """Surface of the ground made of some bodies of a 2D scene.

    Parameters
    ----------
    bodies : those that form the ground.
    level : m, height of the initial surface.
    hole : interval (x0, x1), m, of what goes through the ground, for instance a pile; it is left out of
        continuity and areas. Default: none.

    Two domains hang together where the gap between them, a box round each, is at most half a cell; the ground
    is the set of domains hanging together that has the most particles, and all others are isolated. Meshed
    bodies give their own boundary vertices. Boxes give a staircase: the top of the highest one of the ground
    in strips a quarter of a box wide, where no mesh of the surface is above. Gaps of up to half a cell
    between them are closed, wider ones give the height further down, or nan where nothing is.

    Raises ValueError for a scene in 3D, and where no body has particles or an edge at the level.
    """
    if scene.dim != 2:
        raise ValueError("groundSurface: the scene is 3D; a surface line is defined in plane strain only")
    bodies = [b for b in bodies if b.count]
    if not bodies:
        raise ValueError("groundSurface: the bodies hold no particles; give those that form the ground")
    gap = _BRIDGED * min(scene.cell)
    inGround = _largestPart(bodies, gap)
    chains = [c for b in bodies if b.cells is not None for c in _topChains(b, level)]
    singleValued = all((np.diff(c[:, 0]) > 0).all() for c in chains) if chains else None
    pieces = [(c[:, 0], c[:, 1], np.ones(len(c), bool)) for c in chains]
    for body in bodies:
        if body.cells is None and inGround[body.name].any():
            x, y = _boxTops(body, inGround[body.name], gap, chains)
            pieces.append((x, y, np.zeros(len(x), bool)))
    if not pieces:
        raise ValueError(
            f"groundSurface: no mesh has edges that lay at level = {level:g} m, and there are no boxes; give "
            "the height of the initial surface"
        )
    x, y, explicit = (np.concatenate([p[k] for p in pieces]) for k in range(3))
    piece = np.concatenate([np.full(len(p[0]), k) for k, p in enumerate(pieces)])
    order = np.argsort(x, kind="stable")
    x, y, explicit, piece = x[order], y[order], explicit[order], piece[order]
    parted = np.flatnonzero((np.diff(piece) != 0) & (np.diff(x) > gap)) + 1
    x = np.insert(x, parted, 0.5 * (x[parted - 1] + x[parted]))
    return Surface(
        x,
        np.insert(y, parted, np.nan),
        np.insert(explicit, parted, False),
        hole,
        singleValued,
        int(sum((~m).sum() for m in inGround.values())),
    )


def _largestPart(bodies, gap):
    """Dict body -> mask of the particles in the largest set that hangs together over gaps of at most
    `gap`."""
    corners = [b.corners() for b in bodies]
    lower, upper = (np.concatenate([which(c, axis=1) for c in corners]) for which in (np.min, np.max))
    centre, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    pairs = cKDTree(centre).query_pairs(2 * half.max() + gap, p=np.inf, output_type="ndarray")
    i, j = pairs[
        _boxDistance(centre[pairs[:, 0]] - centre[pairs[:, 1]], half[pairs[:, 0]] + half[pairs[:, 1]])
        <= gap * (1 + 1e-9)
    ].T
    count = len(centre)
    label = connected_components(coo_array((np.ones(len(i)), (i, j)), (count, count)), directed=False)[1]
    isMain = label == np.argmax(np.bincount(label))
    return dict(zip([b.name for b in bodies], np.split(isMain, np.cumsum([b.count for b in bodies])[:-1])))


def _boxTops(body, inGround, gap, chains):
    """Both ends of strips beside the chains, and the top of the highest box of the ground there; nan where
    none is.

    Gaps of up to `gap` between boxes, and between them and the chains, are closed.
    """
    half, position = body.halfSize, body.position[inGround]
    step, start = 2 * half[0] / _PER_BOX, body.reference[:, 0].min() - half[0]
    # The middle of strip k is at start + (k + 1/2) step.
    first, last = (
        np.ceil((position[:, 0] + side * half[0] - start) / step - 0.5 - 1e-6).astype(int) for side in (-1, 1)
    )
    width = 2 * round(0.5 * gap / step)  # strips in a gap
    middle = start + step * (np.arange(first.min() - width, last.max() + width) + 0.5)
    tops = np.full(len(middle), -np.inf)
    for k in range(_PER_BOX + 1):
        covered = first + k < last
        np.maximum.at(tops, first[covered] + k - first.min() + width, position[covered, 1] + half[1])
    for chain in chains:
        below = _isWithin(middle, chain)
        tops[below] = np.interp(middle[below], *chain.T)
    tops = ndimage.grey_closing(tops, width + 1)[width : len(tops) - width]
    x = (
        middle[width : len(middle) - width, None] + 0.5 * step * (1 - 1e-6) * np.array([-1, 1])
    ).ravel()  # short of the next strip's
    isOpen = ~np.any([_isWithin(x, chain) for chain in chains], axis=0) & np.ones(len(x), bool)
    return x[isOpen], np.repeat(np.where(np.isfinite(tops), tops, np.nan), 2)[isOpen]


def _isWithin(x, chain):
    return (x >= chain[:, 0].min()) & (x <= chain[:, 0].max())


def _topChains(body, level):
    """Chains of boundary vertices that lay on the initial surface, each (n, 2) from left to right as
    meshed."""
    start = np.asarray(body._core.view("vertexReference", True))
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
