# SPDX-License-Identifier: GPL-2.0-or-later
"""Beams: walls, piles, plates and linings of real sections along a line."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..base.wording import shown
from ..geometry.mesh import Mesh
from ..geometry.numbers import isNumber, numbers, placeText
from ..geometry.regions import polygon
from ..material.materials import classes as materials
from ..particle.types import classes as types

ALONG = 2  # domains between two sections
PER_CELL = (
    2  # domains across a cell, as of other meshes: soil has to find vertices on the faces and at the ends
)
SHARPEST = np.radians(90)  # turn of the line at a point, from which on sections would cross


class Beam:
    """A wall, pile, plate or lining of a real section, for `scene.add`, as its region.

        sheet = mpm.Beam([(8, 1.5), (8, 8)], EI=71820, EA=3.2e6, weight=0.118, thickness=0.5)
        soil = scene.add("soil", mpm.box((0, 0), (16, 8)) - sheet.region, sand)
        wall = scene.add("wall", sheet)
        mpm.sectionForces(wall)

    What it resists are N = EA strain and M = EI curvature of its middle line, whatever the thickness of its
    mesh. It is implicit. In axisymmetric scenes it is a shell, which takes
    forces round the axis, too.

    Parameters
    ----------
    line : points (N, 2), m, of the middle line; the first one again at the end closes a ring.
    EI : kN m2/m, bending stiffness, per metre of width (of piles in a row: of one over their spacing).
    EA : kN/m, axial stiffness.
    weight : Mg/m2, mass by the area of the wall.
    thickness : m, of its mesh, for contact: two cells or more where soil is on both sides.
    GA : kN/m, shear stiffness; default None: no shear strain.
    limitMoment : kN m/m, moment at which a plastic hinge turns; default None: elastic.
    size : m, between cross-sections, a cell or more; default: a cell.

    `region` is the place that it takes. Its mass is spread over the thickness of the mesh.
    """

    def __init__(
        self,
        line: ArrayLike,
        *,
        EI: float,
        EA: float,
        weight: float,
        thickness: float,
        GA: float | None = None,
        limitMoment: float | None = None,
        size: float | None = None,
    ) -> None:
        self.line = _checkLine(line)
        given = dict(EI=EI, EA=EA, weight=weight, thickness=thickness)
        optional = dict(GA=GA, limitMoment=limitMoment, size=size)
        for name, value in {**given, **{k: v for k, v in optional.items() if v is not None}}.items():
            if not (isNumber(value) and 0 < value < np.inf):
                raise ValueError(f"Beam: {name} = {shown(value)} is not allowed; give a positive number")
        self.weight, self.thickness, self.size = float(weight), float(thickness), size
        self._section = {k: v for k, v in dict(EI=EI, EA=EA, GA=GA, limitMoment=limitMoment).items() if v}

    def __repr__(self):
        start, end = placeText(self.line[0]), placeText(self.line[-1])
        return f"<Beam from {start} to {end}, EI = {self._section['EI']:g} kN m2/m>"

    @property
    def isClosed(self):
        """Whether it is a ring."""
        return bool(np.array_equal(self.line[0], self.line[-1]))

    @property
    def region(self):
        """The region that its mesh takes, e.g. to leave it out of the ground."""
        right, left = _faces(self.line, self.thickness, self.isClosed)
        if not self.isClosed:
            return polygon(np.concatenate((right, left[::-1])))
        outer, inner = sorted((right, left), key=lambda face: -np.ptp(face, axis=0).max())
        return polygon(outer) - polygon(inner)

    def _parts(self, scene, name):
        """Mesh, material and particle type of its body."""
        if scene.dim == 3:
            raise ValueError(
                f"body '{name}': a Beam is for scenes in two dimensions; in 3D give a mesh two cells thick "
                "and LinearElastic, implicit=True"
            )
        points = self._divided(scene, name)
        faces = _faces(points, self.thickness, self.isClosed)
        cell = float(np.min(scene.cellSizeAt(self.line)))
        mesh = _mesh(*faces, self.isClosed, max(1, round(PER_CELL * self.thickness / cell)))
        material = materials["BeamSection"](
            density=self.weight / self.thickness, thickness=self.thickness, **self._section
        )
        return mesh, material, types["APDI"](hourglass=0)

    def _divided(self, scene, name):
        """Points of the line at the ends of the domains."""
        cell = float(np.max(scene.cellSizeAt(self.line)))
        size, slack = self.size or cell, 1e-6 * cell
        parts = [self.line[:1]]
        for start, end in zip(self.line[:-1], self.line[1:]):
            length = np.linalg.norm(end - start)
            if min(length, size) < cell - slack:
                raise ValueError(
                    f"body '{name}': domains of a Beam near {placeText(start)} are {min(length, size):.4g} m "
                    f"long, less than a cell of {cell:g} m, which makes it too stiff; give a larger size, "
                    "points farther apart, or smaller cells"
                )
            n = max(1, int(length / size + 1e-6))
            parts.append(start + (end - start) * (np.arange(1, n + 1) / n)[:, None])
        return np.concatenate(parts)


def _mesh(right, left, isClosed, across):
    """A mesh between two faces, each piece cut in two along it and some across; the vertices that are not on
    the faces of sections hang on these, but for those inside of the ends (BeamEnds.hpp)."""
    count = len(right) - isClosed
    points, cells = [*right[:count], *left[:count]], []
    slaves, masters, shares, inside = (
        [],
        [],
        [],
        {},
    )  # inside: row of vertices of a section that two elements share

    def hang(corner, weights, isAtEnd):
        points.append(weights @ np.array([points[v] for v in np.where(corner < 0, 0, corner)]))
        if not isAtEnd:
            slaves.append(len(points) - 1)
            masters.append(corner)
            shares.append(weights)
        return len(points) - 1

    def row(corner, x):  # of vertices across an element, x: part of the way along it
        a, b, c, d = corner
        section = {0: (a, d), ALONG: (b, c)}.get(x)
        isShared = section is not None and (isClosed or 0 < section[0] < count - 1)
        if isShared and section in inside:
            return inside[section]
        part, y = x / ALONG, np.arange(across + 1) / across
        weights = np.stack([(1 - part) * (1 - y), part * (1 - y), part * y, (1 - part) * y], axis=1)
        on = corner
        if isShared:
            on = np.array([*section, -1, -1])
            weights = np.stack([1 - y, y, 0 * y, 0 * y], axis=1)
        ends = section or (None, None)
        made = [ends[0], *[None] * (across - 1), ends[1]]
        isAtEnd = section is not None and not isShared
        made = [hang(on, w, isAtEnd) if v is None else v for v, w in zip(made, weights)]
        if isShared:
            inside[section] = made
        return made

    for start in range(len(right) - 1):
        end = (start + 1) % count
        rows = [row(np.array([start, end, count + end, count + start]), x) for x in range(ALONG + 1)]
        for one, two in zip(rows, rows[1:]):
            cells += [(one[j], two[j], two[j + 1], one[j + 1]) for j in range(across)]
    hanging = np.reshape(masters, (-1, 4)).astype(int), np.reshape(shares, (-1, 4)).astype(float)
    return Mesh(np.array(points), np.array(cells), np.array(slaves, int), *hanging)


def _checkLine(line):
    points = numbers("Beam", "line", line)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
        raise ValueError(f"Beam: line = {shown(line)} is not allowed; give two points (x, y) or more, m")
    spans = np.diff(points, axis=0)
    if not (spans.any(axis=1)).all():
        raise ValueError("Beam: line has a point twice in a row; give each once")
    if np.array_equal(points[0], points[-1]):
        spans = np.concatenate((spans, spans[:1]))
    unit = spans / np.linalg.norm(spans, axis=1)[:, None]
    turn = np.arccos(np.clip((unit[1:] * unit[:-1]).sum(axis=1), -1, 1))
    if (turn > SHARPEST + 1e-9).any():
        at = points[(1 + np.argmax(turn)) % len(points)]
        raise ValueError(f"Beam: line turns by more than 90 degrees at {placeText(at)}; give two beams")
    return points


def _faces(points, thickness, isClosed):
    """Points on the faces to the right and to the left of a line: sections halve the angle where it turns."""
    along = np.diff(points, axis=0)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
    before = np.concatenate((normal[-1:] if isClosed else normal[:1], normal))
    after = np.concatenate((normal, normal[:1] if isClosed else normal[-1:]))
    across = (before + after) / (1 + (before * after).sum(axis=1))[:, None]
    return points - 0.5 * thickness * across, points + 0.5 * thickness * across
