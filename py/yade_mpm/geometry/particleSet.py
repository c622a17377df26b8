# SPDX-License-Identifier: GPL-2.0-or-later
"""Particles that users bring: positions and volumes, as arrays or from files."""

from __future__ import annotations

import csv
import os
import re

import numpy as np
from numpy.typing import ArrayLike

from ..base.kinds import FILE, requireFile, takes
from ..base.wording import shown
from .meshReader import readPoints
from .numbers import formatNumber, numbers, placeText

NEAREST = 0.5  # of their edges, -: centres that are nearer to each other overlap
ROUND_OFF = 1e-9  # -


class ParticleSet:
    """Particles by their positions and volumes, for `Scene.add`; made by `particles` and `particlesFromFile`.

    Attributes
    ----------
    positions : (N, dim), m.
    volumes : (N,), m3; in 2D m2, the area in the plane.

    who : begins the messages of errors.
    """

    def __init__(self, positions, volumes, who="particles"):
        self.positions = numbers(who, "positions", positions)
        if self.positions.ndim != 2 or self.positions.shape[1] not in (2, 3) or not len(self.positions):
            raise ValueError(
                f"{who}: positions has the shape {self.positions.shape}; give (N, 2), or in 3D (N, 3)"
            )
        given = numbers(who, "volumes", volumes)
        if given.shape not in ((), (len(self.positions),)):
            raise ValueError(
                f"{who}: volumes has the shape {given.shape}; give one number, or one for each of the "
                f"{len(self.positions)} positions"
            )
        self.volumes = np.broadcast_to(given, len(self.positions)).copy()
        _refuseFirst(~np.isfinite(self.positions).all(axis=1), self, who, "its position is not finite")
        isWrong = ~(np.isfinite(self.volumes) & (self.volumes > 0))
        _refuseFirst(isWrong, self, who, "its volume is not a positive number")

    dim = property(lambda self: self.positions.shape[1], doc="Of the scenes that it fits: 2 or 3.")

    def __repr__(self):
        return f"<ParticleSet of {len(self.volumes)} particles in {self.dim}D>"

    def _edgesIn(self, scene, name):
        """Edges of each box over those of a cell, -; ValueError for what does not fit into the scene."""
        who = f"body '{name}'"
        if self.dim != scene.dim:
            raise ValueError(
                f"{who}: the particles are in {self.dim}D, the scene in {scene.dim}D; give others"
            )
        cell = np.array(scene._core.cell)
        edges = (self.volumes / np.prod(cell)) ** (1 / self.dim)
        wide = np.argmax(edges)
        if edges[wide] > 1 + ROUND_OFF:
            raise ValueError(
                f"{who}: particle {wide} at {placeText(self.positions[wide])} has a volume of "
                f"{self.volumes[wide]:.4g} and is larger than a cell of {np.prod(cell):.4g}; give smaller "
                "volumes, or larger cells"
            )
        if len(edges) > 1:
            self._refuseOverlap(who, self.positions / cell, edges)
        return edges

    def _refuseOverlap(self, who, places, edges):
        from scipy.spatial import cKDTree  # late: 0.1 s, and few need it

        distances, pairs = cKDTree(places).query(places, k=2, p=np.inf)
        nearest = np.where(pairs[:, 1] == np.arange(len(places)), pairs[:, 0], pairs[:, 1])
        isNear = distances[:, 1] < NEAREST * 0.5 * (edges + edges[nearest]) * (1 - ROUND_OFF)
        rule = f"nearer than {NEAREST:g} of their edges"
        _refuseFirst(isNear, self, who, f"it overlaps with particle {{other}}: {rule}", nearest)


def particles(positions: ArrayLike, volumes: ArrayLike) -> ParticleSet:
    """Particles at positions of your own, for `Scene.add`.

        soil = scene.add("soil", mpm.particles(positions, volumes), sand)
        soil.velocity = velocity[soil.id]  # other states by id, the row of the particle

    Parameters
    ----------
    positions : (N, dim), m.
    volumes : m3, in 2D m2 of the plane (of axisymmetric scenes, too): one number, or (N,).

    They become boxes in the proportions of a cell, of the size of the largest volume; those of smaller ones
    are partly filled. `perCell` is not used. Raises ValueError, with the row, for what is not finite or not
    positive; `Scene.add` does for particles that are larger than a cell, lie outside of the grid, or overlap:
    nearer to each other than half of their edges.
    """
    return ParticleSet(positions, volumes)


@takes(file=FILE)
def particlesFromFile(file: str | os.PathLike) -> ParticleSet:
    """Particles of a file, for `Scene.add`; `Body.write` writes such files.

    Parameters
    ----------
    file : a name that ends in .csv (a heading with x, y, volume, in 3D also z, in m; units in brackets and
        other columns are left out), or in .vtu (points with the data "volume"; those with z = 0 are in 2D).

    Raises FileNotFoundError, and ValueError for a file without a column, for a cell that is no number, and as
    `particles` does.
    """
    name = os.fspath(file)
    who = f"particlesFromFile: {shown(name)}"
    ending = os.path.splitext(name)[1].lower()
    if ending not in (".csv", ".vtu"):
        raise ValueError(f"{who} is neither CSV nor VTU; give one of these")
    requireFile("particlesFromFile", file)
    return ParticleSet(*(_fromCSV if ending == ".csv" else _fromVTU)(name, who), who)


def _fromCSV(file, who):
    with open(file, newline="", encoding="utf-8", errors="replace") as opened:
        rows = csv.reader(opened, skipinitialspace=True)
        head = [re.sub(r"\s*[\[(].*", "", title).strip() for title in next(rows, [])]
        missing = [title for title in ("x", "y", "volume") if title not in head]
        if missing:
            raise ValueError(
                f"{who} has no column {' and no '.join(missing)}; its heading is {shown(','.join(head))}; "
                "give x, y, volume, in 3D also z"
            )
        columns = [head.index(title) for title in ("x", "y", "z", "volume") if title in head]
        table = [_numbersOf(row, columns, f"{who}: line {rows.line_num}") for row in rows if row]
    table = np.array(table).reshape(-1, len(columns))
    return table[:, :-1], table[:, -1]


def _numbersOf(row, columns, who):
    try:
        return [float(row[column]) for column in columns]
    except (ValueError, IndexError):
        raise ValueError(f"{who}: {shown(','.join(row))} lacks a number; give one for each column") from None


def _fromVTU(file, who):
    try:
        points, volumes = readPoints(file)
    except RuntimeError as error:
        raise ValueError(f"{who} is not a file that meshio can read: {error}") from error
    if volumes is None:
        raise ValueError(f"{who} has no point data 'volume'; give points with their volumes, as Body.write")
    isFlat = points.shape[1] == 3 and not points[:, 2].any()
    return points[:, :2] if isFlat else points, volumes


def _refuseFirst(isWrong, particles, who, complaint, others=None):
    """ValueError, which names the first particle that is wrong, and how many are."""
    if isWrong.any():
        k = int(np.argmax(isWrong))
        other = "" if others is None else f"{others[k]} at {placeText(particles.positions[others[k]])}"
        volume = formatNumber(particles.volumes[k])
        raise ValueError(
            f"{who}: particle {k} at {placeText(particles.positions[k])} with the volume {volume}: "
            f"{complaint.format(other=other)} ({isWrong.sum()} such particles, counted from 0)"
        )
