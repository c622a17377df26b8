# SPDX-License-Identifier: GPL-2.0-or-later
"""Beams: walls, piles, plates and linings of real sections along a line."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..base.kinds import POSITIVE
from ..base.wording import shown
from ..geometry.mesh import Mesh
from ..geometry.numbers import numbers, placeText
from ..geometry.regions import polygon
from ..material.materials import classes as materials
from ..particle.types import classes as types

ALONG = 2  # domains between two sections, as in Beam.hpp
PER_CELL = (
    2  # domains across a cell, as of other meshes: soil has to find vertices on the faces and at the ends
)
SAMPLES, SLACK = 4096, 1e-6  # of the cells along a piece of the line; round-off of lengths
MISSED = 0.01  # cells that samples may miss along a piece
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
    size : m, between cross-sections, one to two cells; default: a cell.

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
            POSITIVE.check("Beam", **{name: value})
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
        cell = float(np.min(scene.cellSizeAt(points)))
        mesh = _mesh(*faces, self.isClosed, max(1, round(PER_CELL * self.thickness / cell)))
        material = materials["BeamSection"](
            density=self.weight / self.thickness, thickness=self.thickness, **self._section
        )
        return mesh, material, types["APDI"](hourglass=0)

    def _divided(self, scene, name):
        """Points of the line at the ends of the domains, a cell of the grid there apart or a little more."""
        parts = [self.line[:1]]
        for start, end in zip(self.line[:-1], self.line[1:]):
            length, part = np.linalg.norm(end - start), np.linspace(0, 1, SAMPLES + 1)
            middle = start + (end - start) * ((part[1:] + part[:-1]) / 2)[:, None]
            cells = scene.cellSizeAt(middle).max(axis=1)
            self._checkSize(name, start, length, cells.min(), cells.max())
            passed = np.cumsum([0, *(length / SAMPLES / (self.size or cells) * np.ones(SAMPLES))])
            n = max(1, int(passed[-1] + MISSED))
            at = np.interp(np.arange(1, n + 1) / n * passed[-1], passed, part)
            parts.append(start + (end - start) * at[:, None])
        return np.concatenate(parts)

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
    """A mesh between two faces: the vertices of each section from its right face to its left one, then those
    between two sections, which hang on these (Beam.hpp)."""
    count, pieces = len(right) - isClosed, len(right) - 1
    y = np.linspace(0, 1, across + 1)[:, None]
    sections = (1 - y) * right[:count, None] + y * left[:count, None]
    vertex = np.arange(count * (across + 1)).reshape(count, across + 1)
    start, end = vertex[:pieces], vertex[np.arange(1, pieces + 1) % count]
    part = np.arange(1, ALONG)[:, None] / ALONG
    hanging = vertex.size + np.arange(pieces * (ALONG - 1) * (across + 1)).reshape(pieces, ALONG - 1, -1)
    masters, weights = np.full((*hanging.shape, 4), -1), np.zeros((*hanging.shape, 4))
    masters[..., 0], masters[..., 1] = start[:, None], end[:, None]
    weights[..., 0], weights[..., 1] = 1 - part, part
    points = sections.reshape(-1, 2)
    between = (weights[..., :2, None] * points[masters[..., :2]]).sum(axis=-2)
    rows = np.concatenate((start[:, None], hanging, end[:, None]), axis=1)
    cells = np.stack((rows[:, :-1, :-1], rows[:, 1:, :-1], rows[:, 1:, 1:], rows[:, :-1, 1:]), axis=-1)
    return Mesh(
        np.concatenate((points, between.reshape(-1, 2))),
        cells.reshape(-1, 4),
        hanging.ravel(),
        masters.reshape(-1, 4),
        weights.reshape(-1, 4),
    )


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
