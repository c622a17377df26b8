# SPDX-License-Identifier: GPL-2.0-or-later
"""Where contact is known to be wrong: boxes on boxes, soil beside thin walls, and between bodies."""

from itertools import combinations

import numpy as np

from ..engine.contact import Contact
from ..engine.poreWater import waterOf
from ..geometry.mesh import Mesh, boundaryFacets
from ..geometry.numbers import placeText
from ..material.materials import isBeam

NARROW = 3  # cells between two bodies from which on soil that flows there keeps its pressure
THIN = 2  # cells; in a wall as thick as that no node feels the soil on both sides of it
PARTED = 0.5  # cells; a wall that parts soil moves it as far as itself from this thickness on
OPPOSITE = -0.9  # cosine between the normals of the two sides of a wall; flat tips and wedges are none
ROUNDOFF = 1e-6  # cells
BESIDE = 0.5  # cells from a wall to where soil is looked for,
NEAR = 0.75  # and how far from there a particle may be: boxes are half a cell large at most


def contactMistakes(scene, contact):
    """Yields a text for each fault of contact that a scene will meet.

    contact : Contact.
    """
    if not (contact.separation or contact.slip):  # one body
        return
    groups = dict.fromkeys(b.group for b in scene.bodies if b.count)
    bodies = {group: [b for b in scene.bodies if b.group == group and b.count] for group in groups}
    isMesh = {group: all(b.cells is not None for b in bodies[group]) for group in groups}
    boxes = [(a, b) for a, b in combinations(groups, 2) if not (isMesh[a] or isMesh[b])]
    if boxes:
        yield (
            f"Contact: {_inWords(boxes)} are boxes on both sides, whose surface only the nodes see: the load "
            "of a plane surface is 10 to 30 % too large, that of a footing 10 to 25 % too small (cells of a "
            "quarter and an eighth of its width); give APDI(size=...) to one of the two, a structure best"
        )
    for group in (g for g in groups if isMesh[g]):
        for body in bodies[group]:
            soils = [other for other in groups if other != group]
            yield from _thinWall(scene, body, [(soil, bodies[soil]) for soil in soils])


def _inWords(pairs):
    return ", ".join(f"'{a}' and '{b}'" for a, b in pairs)


def _thinWall(scene, body, soils):
    """Yields a text if a mesh is thinner than two cells where soil is on both sides that it does not part."""
    from scipy.spatial import cKDTree  # late: 0.1 s, and few need it

    middle, normal, thickness, first, second = _walls(scene, body)
    cell = scene.cellSizeAt(middle).min(axis=1) if len(middle) else np.zeros(0)
    for group, others in soils:
        if not len(first):
            return
        isParted = (body.name, group) in scene._core.partedWalls
        soil = cKDTree(np.concatenate([b.position for b in others]))
        far, _ = soil.query(middle + BESIDE * cell[:, None] * normal)
        isBeside = far < NEAR * cell
        isThin = isBeside[first] & isBeside[second]
        if isParted:
            isThin &= thickness < (PARTED - ROUNDOFF) * cell[first]
        found = np.flatnonzero(isThin)
        if not len(found):
            continue
        worst = found[np.argmin(thickness[found] / cell[first[found]])]
        thin, size, place = thickness[worst], cell[first[worst]], placeText(middle[first[worst]])
        if isParted:
            yield (
                f"Contact: '{body.name}' is {thin:.3g} m thick at {place}, less than half a cell of "
                f"{size:.3g} m, with '{group}' on both sides: if the wall moves sideways, the soil moves "
                f"less, by a fifth at a quarter of a cell; give {_thicker(body, thin, PARTED * size, size)}"
            )
            return
        yield (
            f"Contact: '{body.name}' is {thin:.3g} m thick at {place}, less than two cells of {size:.3g} m, "
            f"with '{group}' on both sides, which shares nodes: if the wall moves sideways, the soil moves "
            "only half as far, and resists up to a quarter too little; if the wall stands between grid "
            "lines, only a third to a half of its friction acts; dry soil of boxes without outline is parted "
            "by a straight wall of half a cell or more, without rigid bodies and USF; else give "
            f"{_thicker(body, thin, THIN * size, size)}"
        )
        if thin < (1 - ROUNDOFF) * size and waterOf(scene):
            yield (
                f"PoreWater: '{body.name}' is {thin:.3g} m thick at {place}, less than a cell of {size:.3g} "
                f"m: water flows through it; give {_thicker(body, thin, size, size)}"
            )
        return


def _thicker(body, thin, enough, cell):
    """What to give for a wall to be thick enough: the faces of a Beam may lie anywhere, and those of a line
    are always a cell apart."""
    if isBeam(body.material):
        return f"its Beam thickness={enough:.3g}, which does not change how it bends"
    return f"cells of {thin / enough * cell:.3g} m at most"


def _walls(scene, body):
    """Middles of the facets of a mesh (N, dim) and their normals; thickness, m, of the walls between two of
    them that are less than two cells apart, and the numbers of these two."""
    from scipy.spatial import cKDTree

    corners = _facets(body)
    if body.scene.dim == 2:
        along = corners[:, 1] - corners[:, 0]
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    else:
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    middle, reach = corners.mean(axis=1), np.linalg.norm(corners - corners.mean(axis=1)[:, None], axis=2)
    room = THIN * scene.cellSizeAt(middle).min(axis=1)
    pairs = cKDTree(middle).query_pairs(room.max(), output_type="ndarray")
    first, second = pairs[np.einsum("ij,ij->i", *normal[pairs.T]) < OPPOSITE].T
    apart = middle[first] - middle[second]
    thickness = np.einsum("ij,ij->i", apart, normal[first])
    beside = np.linalg.norm(apart - thickness[:, None] * normal[first], axis=1)
    small = ROUNDOFF * room[first]
    isWall = (thickness > small) & (thickness < room[first] - small) & (beside < reach.max(axis=1)[first])
    return middle, normal, thickness[isWall], first[isWall], second[isWall]


def squeezed(scene):
    """What is wrong where soil lies between two structures less than three cells apart, as text; or None."""
    from scipy.spatial import cKDTree

    soils = [b for b in scene.bodies if b.count and b.cells is None and b.fbar]
    sharesCells = any(isinstance(e, Contact) and e.sharedCells and not e.dead for e in scene.engines)
    if not (soils and sharesCells):
        return None
    ofSoil = {soil.group for soil in soils}
    bodies = [b for b in scene.bodies if b.count and b.cells is not None and b.group not in ofSoil]
    surfaces = {body.name: _surfacePoints(body) for body in bodies if len(bodies) > 1}
    widest = NARROW * scene.cellSizeAt(np.concatenate([*surfaces.values()])).max() if surfaces else 0.0
    for a, b in combinations(bodies, 2):
        points, others = surfaces[a.name], surfaces[b.name]
        apart = np.maximum(points.min(axis=0) - others.max(axis=0), others.min(axis=0) - points.max(axis=0))
        if a.group == b.group or apart.max() >= widest:
            continue
        width, which = cKDTree(others).query(points)
        middle = 0.5 * (points + others[which])
        cell = scene.cellSizeAt(middle).min(axis=1)
        soil, _ = cKDTree(np.concatenate([s.position for s in soils])).query(middle)
        found = np.flatnonzero((width < (NARROW - ROUNDOFF) * cell) & (soil < BESIDE * cell))
        if len(found) and (width > ROUNDOFF * cell).all():  # bodies that touch have none between them
            worst = found[np.argmin(width[found] / cell[found])]
            place = placeText(middle[worst])
            return (
                f"Contact: '{a.name}' and '{b.name}' are {width[worst]:.3g} m apart at {place}, less than "
                f"three cells of {cell[worst]:.3g} m, with soil between them: if it flows there it does not "
                "keep its pressure (171 to 295 of 200 kPa in a closed box where two bars pass each other one "
                f"cell apart); give cells of {width[worst] / NARROW:.3g} m at most"
            )
    return None


def _surfacePoints(body):
    """Corners and middles of the facets of a mesh, (N, dim), m."""
    corners = _facets(body)
    return np.concatenate([corners.reshape(-1, corners.shape[-1]), corners.mean(axis=1)])


def _facets(body):
    """Corners of the facets of a mesh, (N, corners, dim), m."""
    mesh = body.mesh if body.mesh is not None else Mesh(body.vertices, body.cells)
    return body.vertices[boundaryFacets(mesh)[0]]
