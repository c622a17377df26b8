# SPDX-License-Identifier: GPL-2.0-or-later
"""Beams: walls, piles, plates and linings of real sections along a line, in 3D drawn along a width."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..base.kinds import NOT_NEGATIVE, NUMBER, POSITIVE, Kind
from ..base.wording import shown
from ..geometry.mesh import Mesh
from ..geometry.numbers import numbers, placeText, vector
from ..geometry.regions import polygon, prism
from ..material.materials import classes as materials
from ..particle.types import classes as types
from .nodes import onLinesBetween

ALONG = 2  # domains between two fibres, as in Beam.hpp
PER_CELL = (
    2  # domains across a cell, as of other meshes: soil has to find vertices on the faces and at the ends
)
OF_LINE = (
    1  # cells between the faces of a line: contact parts soil from 0.5 to 2, and boxes of half a cell fit
)
SAMPLES, SLACK = 4096, 1e-6  # of the cells along a piece of the line; round-off of lengths
MISSED = 0.01  # cells that samples may miss along a piece
RATIO = Kind("a number between -1 and 0.5", lambda value: NUMBER.isOne(value) and -1 < value < 0.5)
SHARPEST = np.radians(90)  # turn of the line at a point, from which on sections would cross


class Beam:
    """A wall, pile, plate or lining of a real section, for `scene.add`, as its region.

        sheet = mpm.Beam([(8, 1.5), (8, 8)], EI=71820, EA=3.2e6, weight=0.118, thickness=0.5)
        soil = scene.add("soil", mpm.box((0, 0), (16, 8)) - sheet.region, sand)
        wall = scene.add("wall", sheet)
        mpm.sectionForces(wall)

    What it resists are N = EA strain and M = EI curvature of its middle line, whatever the thickness of its
    mesh. It is implicit. In axisymmetric scenes it is a shell, which takes forces round the axis, too. In 3D
    it is a plate, folded where the line turns. With nu for `poisson` and S for the root of EI EIWidth

        M_x = (EI k_x + nu S k_y)/(1 - nu^2),  M_y alike,  M_xy = S k_xy/(1 + nu),

    k_x and k_y the curvatures along line and width. Normal forces and membrane shear follow from EA and
    EAWidth in the same way, with gamma_xy/2 for k_xy.

    Parameters
    ----------
    line : points (N, dim), m, of the middle line; the first one again at the end closes a ring.
    width : (3,), m, in 3D: the vector along which the line is drawn, parallel to an axis and across all of
        the line. The left face is on the side of line x width.
    EI : kN m2/m, bending stiffness, per metre of width (of piles in a row: of one over their spacing).
    EA : kN/m, axial stiffness.
    weight : Mg/m2, mass by the area of the wall.
    thickness : m, between its faces, for contact: two cells or more where soil is on both sides, half a cell
        where this is dry; default 0, a line: a cell of the grid there, as `thickness` says once it is in a
        scene.
    GA : kN/m, shear stiffness; default None: no shear strain.
    limitMoment : kN m/m, moment at which a plastic hinge turns, in 3D largest principal moment; default
        None: elastic. In 3D not with GA, nor with EIWidth.
    poisson : in 3D, Poisson's ratio, the root of the product of those of both directions; default 0.
    EIWidth, EAWidth : kN m2/m, kN/m, in 3D, stiffness along the width (small for sheet piles); default None:
        EI, EA.
    size : m, between cross-sections, one to two cells; default: a cell, along an axis from line to line of
        the grid.

    `region` is the place that it takes; of a line, once it is in a scene: add it before the ground. Its mass
    is spread over the thickness of the mesh. The particles hold the forces per metre: `normalForce`,
    `shearForce`, `bendingMoment`, in 3D those along the width, too (`hoopForce`, `hoopShear`, `hoopMoment`),
    `membraneShear` and `twistingMoment`.

    Raises ValueError for a line that turns by more than 90 degrees, a width that is not across it, numbers
    that are not positive, a ratio outside of (-1, 0.5), limitMoment with GA or EIWidth in 3D; `scene.add`
    for domains shorter than a cell.

    Sources: MacNeal 1978, Computers & Structures 8, 175-183, in each direction; Timoshenko &
    Woinowsky-Krieger 1959, chapter 11, for sections that differ (Huber's M_xy).
    """

    def __init__(
        self,
        line: ArrayLike,
        *,
        EI: float,
        EA: float,
        weight: float,
        thickness: float = 0.0,
        width: ArrayLike | None = None,
        GA: float | None = None,
        limitMoment: float | None = None,
        size: float | None = None,
        poisson: float = 0.0,
        EIWidth: float | None = None,
        EAWidth: float | None = None,
    ) -> None:
        self.line = _checkPoints(line)
        self.width = _checkWidth(self.line, width)
        self._plane = np.delete(np.arange(self.line.shape[1]), [] if width is None else self._axis)
        _checkTurns(self.line, self._plane)
        given = dict(EI=EI, EA=EA, weight=weight)
        ofPlates = dict(EIWidth=EIWidth, EAWidth=EAWidth)
        optional = dict(GA=GA, limitMoment=limitMoment, size=size, **ofPlates)
        for name, value in {**given, **{k: v for k, v in optional.items() if v is not None}}.items():
            POSITIVE.check("Beam", **{name: value})
        NOT_NEGATIVE.check("Beam", "m", thickness=thickness)
        RATIO.check("Beam", poisson=poisson)
        self._checkPlate(limitMoment, dict(GA=GA, EIWidth=EIWidth), dict(poisson=poisson or None, **ofPlates))
        self.weight, self.thickness, self.size = float(weight), float(thickness), size
        self._isLine = self.thickness == 0
        section = dict(EI=EI, EA=EA, GA=GA, limitMoment=limitMoment, poisson=poisson, **ofPlates)
        self._section = {k: v for k, v in section.items() if v}

    def _checkPlate(self, limitMoment, besideLimit, ofPlates):
        """Refuses what a beam in 2D, or a plate with a limit, cannot have."""
        for name, value in (ofPlates if self.width is None else {}).items():
            if value is not None:
                raise ValueError(f"Beam: {name} = {shown(value)} is for a line in 3D; leave it out")
        isLimited = self.width is not None and limitMoment is not None
        for name, value in besideLimit.items():
            if isLimited and value is not None:
                raise ValueError(
                    f"Beam: {name} = {shown(value)} and limitMoment = {shown(limitMoment)} are not for 3D "
                    "together; leave one out"
                )

    def __repr__(self):
        start, end = placeText(self.line[0]), placeText(self.line[-1])
        faces = f", faces {self.thickness:g} m apart" if self.thickness else ""
        return f"<Beam from {start} to {end}, EI = {self._section['EI']:g} kN m2/m{faces}>"

    @property
    def isClosed(self):
        """Whether it is a ring."""
        return bool(np.array_equal(self.line[0], self.line[-1]))

    @property
    def region(self):
        """The region that its mesh takes, e.g. to leave it out of the ground. RuntimeError for a line that is
        in no scene."""
        if not self.thickness:
            raise RuntimeError(
                "Beam: region: a Beam of thickness 0 is as thick as a cell of its scene; add it before "
                "the ground that leaves it out, or give a thickness"
            )
        right, left = _faces(self.line[:, self._plane], self.thickness, self.isClosed)
        if not self.isClosed:
            return self._drawn(np.concatenate((right, left[::-1])))
        outer, inner = sorted((right, left), key=lambda face: -np.ptp(face, axis=0).max())
        return self._drawn(outer) - self._drawn(inner)

    @property
    def _axis(self):
        return int(np.flatnonzero(self.width)[0])

    def _drawn(self, points):
        """The region of a polygon, in 3D along the width."""
        if self.width is None:
            region = polygon(points)
        else:
            ends = self.line[0, self._axis] + np.array([0, self.width[self._axis]])
            region = prism(points, *np.sort(ends), "xyz"[self._axis])
        region.origin = f"a face or an end of {self!r}"
        return region

    def _parts(self, scene, name):
        """Mesh, material and particle type of its body."""
        dim = self.line.shape[1]
        if scene.dim != dim:
            width = ", and width=(0, 8, 0) or alike" if scene.dim == 3 else ""
            raise ValueError(
                f"body '{name}': the line of its Beam is {dim}D, the scene {scene.dim}D; give points in "
                f"{scene.dim}D{width}"
            )
        if self._isLine:
            self.thickness = OF_LINE * self._largestCell(scene)
        points = self._divided(scene, name, self.line)
        places = [points]
        faces = _faces(points[:, self._plane], self.thickness, self.isClosed)
        self._checkFaces(scene, name, points, faces)
        if self.width is None:
            faces = [face[:, None] for face in faces]
        else:
            places.append(self._divided(scene, name, self.line[0] + np.outer((0, 1), self.width)))
            faces = self._drawnFaces(faces, places[1][:, self._axis])
        cell = float(np.min(scene.cellSizeAt(np.concatenate(places))))
        mesh = _mesh(*faces, self.isClosed, max(1, round(PER_CELL * self.thickness / cell)))
        material = materials["BeamSection"](
            density=self.weight / self.thickness, thickness=self.thickness, **self._section
        )
        return mesh, material, types["APDI"](hourglass=0)

    def _largestCell(self, scene):
        """Of the cells along the line, m."""
        part = np.linspace(0, 1, SAMPLES + 1)[:, None]
        pieces = [start + part * (end - start) for start, end in zip(self.line[:-1], self.line[1:])]
        return float(scene.cellSizeAt(np.concatenate(pieces)).max())

    def _drawnFaces(self, faces, along):
        """The right face and the left one (S, W, 3), which is on the side of line x width, from a profile."""
        drawn = [np.empty((len(faces[0]), len(along), 3)) for _ in faces]
        for face, points in zip(faces, drawn):
            points[..., self._plane], points[..., self._axis] = face[:, None], along
        u, v = np.eye(3)[self._plane]
        return drawn if np.cross(u, self.width) @ v > 0 else drawn[::-1]

    def _divided(self, scene, name, line):
        """Points of a line at the ends of the domains, a cell of the grid there apart or a little more."""
        parts, longer = [line[:1]], self._longerAtTurns(line)
        for k, (start, end) in enumerate(zip(line[:-1], line[1:])):
            length, part = np.linalg.norm(end - start), np.linspace(0, 1, SAMPLES + 1)
            middle = start + (end - start) * ((part[1:] + part[:-1]) / 2)[:, None]
            cells = scene.cellSizeAt(middle).max(axis=1)
            self._checkSize(name, start, length, cells.min(), cells.max())
            passed = np.cumsum([0, *(length / SAMPLES / (self.size or cells) * np.ones(SAMPLES))])
            isFree = not self.size and not longer[k : k + 2].any()
            if isFree and (onLines := onLinesBetween(scene, start, end)) is not None:
                parts.append(np.concatenate((onLines, end[None])))
                continue
            first, last = self._shares(longer[k : k + 2], cells[[0, -1]])
            n = max(1, int(passed[-1] - first - last + MISSED))
            between = first + np.arange(1, n) / n * (passed[-1] - first - last)
            ends = np.append(between, passed[-1])
            at = np.interp(ends, passed, part)
            parts.append(start + (end - start) * at[:, None])
        return np.concatenate(parts)

    def _longerAtTurns(self, line):
        """By how much a domain beside each point of the line is longer than others, m: its inner face is
        shorter than the line where this turns, and within a cell the grid is linear, so that sections closer
        to each other there would turn alike."""
        turn = np.zeros(len(line))
        unit = np.diff(line, axis=0)
        unit /= np.linalg.norm(unit, axis=1)[:, None]
        turn[1:-1] = np.arccos(np.clip((unit[1:] * unit[:-1]).sum(axis=1), -1, 1))
        if np.array_equal(line[0], line[-1]):
            turn[[0, -1]] = np.arccos(np.clip(unit[-1] @ unit[0], -1, 1))
        return 0.5 * self.thickness * np.tan(turn / 2)

    def _shares(self, longer, cells):
        """The same in domains, of both ends of a piece of the line; no domain has two cells."""
        size = self.size or cells
        return np.minimum(longer, (2 - SLACK) * cells - size) / size

    def _checkFaces(self, scene, name, points, faces):
        """Refuses a thickness that leaves less than a cell on the inner side of a turn."""
        along = np.diff(points, axis=0)
        length = np.linalg.norm(along, axis=1)
        unit = along[:, self._plane] / length[:, None]
        inner = np.min([(np.diff(face, axis=0) * unit).sum(axis=1) for face in faces], axis=0)
        cell = scene.cellSizeAt((points[1:] + points[:-1]) / 2).max(axis=1)
        worst = np.argmin(inner / np.minimum(cell, length))
        if inner[worst] < (1 - MISSED) * min(cell[worst], length[worst]):
            raise ValueError(
                f"body '{name}': thickness = {self.thickness:g} m of a Beam leaves "
                f"{max(0, inner[worst]):.4g} m between its sections on the inner side of the turn near "
                f"{placeText(points[worst + 1])}, less than a cell of {cell[worst]:g} m, which makes it too "
                "stiff; give a smaller thickness, points farther apart, or smaller cells"
            )

    def _checkSize(self, name, start, length, least, most):
        size = self.size or most
        if min(length, size) < (1 - SLACK) * most:
            raise ValueError(
                f"body '{name}': domains of a Beam near {placeText(start)} are {min(length, size):.4g} m "
                f"long, less than a cell of {most:g} m, which makes it too stiff; give a larger size, "
                "points farther apart, or smaller cells"
            )
        if self.size and size > (2 - SLACK) * least:
            raise ValueError(
                f"body '{name}': size = {size:g} m of a Beam near {placeText(start)} is two cells of "
                f"{least:g} m or more, and nodes between its sections have no mass; leave size out"
            )


def _mesh(right, left, isClosed, across):
    """A mesh between two faces (S, W, dim), W = 1 in 2D: the vertices of each fibre from the right face to
    the left one, then those of the fibres between, which hang on these (Beam.hpp)."""
    dim, pieces = right.shape[-1], np.array(right.shape[:2]) - 1
    count = len(right) - isClosed, right.shape[1]
    y = np.linspace(0, 1, across + 1)[:, None]
    sections = (1 - y) * right[: count[0], :, None] + y * left[: count[0], :, None]
    own = np.arange(count[0] * count[1]).reshape(count)[np.arange(pieces[0] + 1) % count[0]]
    fibre, masters, weights = _betweenFibres(own, isClosed)
    layer = np.arange(across + 1)
    each = np.where(masters[:, None] < 0, -1, masters[:, None] * (across + 1) + layer[:, None]).reshape(-1, 4)
    weights = np.repeat(weights, across + 1, axis=0)
    points = sections.reshape(-1, dim)
    between = (weights[..., None] * points[each]).sum(axis=1)
    return Mesh(
        np.concatenate((points, between)),
        _cells(fibre[..., None] * (across + 1) + layer, dim),
        len(points) + np.arange(len(between)),
        each,
        weights,
    )


def _betweenFibres(own, isClosed):
    """Numbers of all fibres, ALONG times as dense as those that stand by themselves, `own` (S, W). Of the
    fibres between, which are numbered behind these: up to four masters, -1 for none, and weights (N, 4)."""
    shape = [ALONG * (n - 1) + 1 for n in own.shape]
    place = np.indices(shape)
    part = place % ALONG / ALONG
    isBetween = part.any(axis=0)
    if isClosed:
        isBetween[-1] = False
    fibre = np.empty(shape, int)
    fibre[::ALONG, ::ALONG] = own
    fibre[isBetween] = own.max() + 1 + np.arange(np.count_nonzero(isBetween))
    if isClosed:
        fibre[-1] = fibre[0]
    (i, j), (a, b) = (x[:, isBetween] for x in (place // ALONG, part))
    last = np.array(own.shape) - 1
    masters, weights = [], []
    for k, share in (0, 1 - a), (1, a):
        for m, its in (0, 1 - b), (1, b):
            masters.append(own[np.minimum(i + k, last[0]), np.minimum(j + m, last[1])])
            weights.append(share * its)
    weights = np.stack(weights, axis=1)
    order = np.argsort(weights == 0, axis=1, kind="stable")  # those that count first
    weights = np.take_along_axis(weights, order, axis=1)
    masters = np.take_along_axis(np.stack(masters, axis=1), order, axis=1)
    return fibre, np.where(weights > 0, masters, -1), weights


def _cells(vertex, dim):
    """Cells between fibres (S, W, layers): of an element they follow each other, see Beam.hpp."""
    start, end = vertex[:-1], vertex[1:]
    if dim == 2:
        sides = np.stack((start[:, 0], end[:, 0]), axis=-1)  # (cells along, layers, 2)
        cells = np.concatenate((sides[:, :-1], sides[:, 1:, ::-1]), axis=-1)
        return cells.reshape(-1, 4)
    sides = np.stack((start[:, :-1], end[:, :-1], end[:, 1:], start[:, 1:]), axis=-1)
    cells = np.concatenate((sides[..., :-1, :], sides[..., 1:, :]), axis=-1)  # (along, width, layers, 8)
    split = cells.reshape(len(cells) // ALONG, ALONG, -1, ALONG, *cells.shape[2:])
    stacks = [split[:, 0, :, 0], split[:, 1, :, 0], split[:, 1, :, 1], split[:, 0, :, 1]]
    return np.stack(stacks, axis=2).reshape(-1, 8)


def _checkPoints(line):
    points = numbers("Beam", "line", line)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) < 2 or not np.isfinite(points).all():
        raise ValueError(
            f"Beam: line = {shown(line)} is not allowed; give two points or more, (x, y) or (x, y, z), m"
        )
    if np.abs(points[-1] - points[0]).max() <= SLACK * np.ptp(points, axis=0).max():
        points = np.concatenate((points[:-1], points[:1]))  # a ring by cos and sin
    return points


def _checkWidth(line, width):
    """The vector that a line in 3D is drawn along; None in 2D."""
    if line.shape[1] == 2:
        if width is not None:
            raise ValueError(f"Beam: width = {shown(width)} is for a line in 3D; leave it out")
        return None
    if width is None:
        raise ValueError(
            "Beam: a line in 3D needs width, the vector along which it is drawn, m, e.g. width=(0, 8, 0)"
        )
    along = vector("Beam", "width", width, 3)
    axes = np.flatnonzero(along)
    if len(axes) != 1 or np.ptp(line[:, axes[0]]) > SLACK * np.abs(along).max():
        raise ValueError(
            f"Beam: width = {shown(width)} is not allowed; give a vector along x, y or z, across which all "
            "points of the line lie"
        )
    return along


def _checkTurns(line, plane):
    """Refuses a line whose pieces turn too far, or have no length."""
    points = line[:, plane]
    spans = np.diff(points, axis=0)
    if not (spans.any(axis=1)).all():
        raise ValueError("Beam: line has a point twice in a row; give each once")
    if np.array_equal(points[0], points[-1]):
        spans = np.concatenate((spans, spans[:1]))
    unit = spans / np.linalg.norm(spans, axis=1)[:, None]
    turn = np.arccos(np.clip((unit[1:] * unit[:-1]).sum(axis=1), -1, 1))
    if (turn > SHARPEST + 1e-9).any():
        at = line[(1 + np.argmax(turn)) % len(line)]
        raise ValueError(f"Beam: line turns by more than 90 degrees at {placeText(at)}; give two beams")


def _faces(points, thickness, isClosed):
    """Points on the faces to the right and to the left of a line: sections halve the angle where it turns."""
    along = np.diff(points, axis=0)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
    before = np.concatenate((normal[-1:] if isClosed else normal[:1], normal))
    after = np.concatenate((normal, normal[:1] if isClosed else normal[-1:]))
    across = (before + after) / (1 + (before * after).sum(axis=1))[:, None]
    return points - 0.5 * thickness * across, points + 0.5 * thickness * across
