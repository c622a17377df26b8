# SPDX-License-Identifier: GPL-2.0-or-later
"""Normal force, shear force and bending moment along a body, from the forces of its stresses on the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.kinds import BODY, NUMBER, takes
from ..base.wording import shown
from ..material.materials import isBeam

AXES = {"x": 0, "y": 1, "z": 2}
STRAIGHT = 1e-9  # of the cosine between pieces of a line
NEAR_END = 0.25  # cells: an end that bends is no plane


@dataclass(frozen=True, eq=False, repr=False)
class SectionForces:
    """Forces in sections across a body, made by `sectionForces`. 2D: per metre of thickness.

    Attributes
    ----------
    body : its name.
    axis : (dim,), unit vector along the body, in which s grows; of a `Beam` that is not straight (N, dim).
    across : (2D) unit vector of Q and of the deflection, to the right when one looks along the axis;
        (3D) two of them, as rows; of a `Beam` that is not straight (N, dim).
    s : (N,), m, position of the sections along the axis.
    centre : (N, dim), m, middle of the body there.
    displacement : (N, dim), m, mean displacement of the body there.
    N : (N,), kN, normal force, tension positive.
    Q : (N,), kN, shear force: that of the part beyond on the part before, along `across`. 3D: (N, 2).
    M : (N,), kN m, bending moment, positive with tension on the side that `across` points away from, so that
        dM/ds = -Q. 3D: (N, 2), one for each row of `across`.
    """

    body: str
    axis: np.ndarray
    across: np.ndarray
    s: np.ndarray
    centre: np.ndarray
    displacement: np.ndarray
    N: np.ndarray
    Q: np.ndarray
    M: np.ndarray

    def __repr__(self):
        largest = f"{abs(self.M).max():.3g}" if len(self.s) else "-"
        return f"<SectionForces of '{self.body}': {len(self.s)} sections, largest moment {largest}>"


@takes(body=BODY)
def sectionForces(body, axis=None, at=None) -> SectionForces:
    """Normal force, shear force and bending moment in sections across a body, at the end of the last step.

        forces = mpm.sectionForces(wall, "y")
        forces.s, forces.M  # m, kN m per metre

    The forces of the stresses on the nodes of the grid balance all else that acts on the body: soil, props,
    weight, inertia. So a section takes what acts on the nodes beyond it, and it does so with a single cell
    across the body, too, where stresses show half of the moment.

    Parameters
    ----------
    body : Body; not one with F-bar, whose mean stress acts by the cells.
    axis : "x", "y", "z" or a vector along the body; default: its longest side.
    at : positions of sections along the axis, m, a number or several; default: the lines of the grid that the
        body crosses. There the moments are exact for what acts on the nodes; between two lines the moment is
        linear, and misses q h^2/8 of a load q, and F h/8 of the peak at a point load F, which acts on the
        nodes of the cells round it. At an end of the body N and Q are those half a cell inside.

    Of a `Beam` in 2D they are those of its own sections; where its line is not straight, by the length along
    it. In 3D they are of all its width.

    Raises ValueError for an empty body, one with F-bar, or an axis or a position that is not allowed.
    """
    _check(body)
    if isBeam(body.material) and body.scene.dim == 2:
        return alongBeam(body, axis, at)
    along = _axisOf(body, axis)
    width = np.abs(along) @ body.scene.cell
    ends = body.corners().reshape(-1, body.scene.dim) @ along
    ends = ends.min(), ends.max()
    stations, cut = _stations(body, along, width, ends, at), _Cut(body, along, width)
    rows = np.array([cut.atEnd(s, ends) if cut.isAtEnd(s, ends) else cut.at(s) for s in stations])
    centre, across = _along(body, along, width, stations), cut.across
    count = len(across)
    rows = rows.reshape(len(stations), 1 + 2 * count)
    N, Q, M = rows[:, 0], rows[:, 1 : 1 + count], rows[:, 1 + count :]
    if body.scene.dim == 2:
        Q, M, across = Q[:, 0], M[:, 0], across[0]
    return SectionForces(body.name, along, across, stations, *centre.values(), N, Q, M)


class _Cut:
    """A body that is cut across an axis: what acts on the nodes beyond a section."""

    def __init__(self, body, along, width):
        found = body._core.internalForces()
        x, f = (np.reshape(found[name], (-1, body.scene.dim)) for name in ("position", "force"))
        self.body, self.along, self.width, self.across = body, along, width, _across(along)
        self.x, self.s, self.axial, self.side = x, x @ along, -f @ along, -f @ self.across.T

    def at(self, s):
        """N, Q and M at a section; of a node on it half counts."""
        part = np.clip((self.s - s) / self.width + 0.5, 0.0, 1.0)
        centre = _along(self.body, self.along, self.width, [s])["position"][0]
        arm = np.maximum(self.s - s, 0.0)
        M = arm @ self.side - (part * self.axial) @ ((self.x - centre) @ self.across.T)
        return np.concatenate(([part @ self.axial], part @ self.side, M))

    def isAtEnd(self, s, ends):
        """Whether a section is at an end of a body that is long enough to come from inside."""
        isThere = min(abs(s - ends[0]), abs(s - ends[1])) < NEAR_END * self.width
        return isThere and ends[1] - ends[0] > 4 * self.width

    def atEnd(self, s, ends):
        """The same from inside, for the nodes at an end have the forces of supports, too: N and Q half a cell
        away, and M with that Q."""
        step = self.width if abs(s - ends[0]) < abs(s - ends[1]) else -self.width
        middle, beside, count = self.at(s + 0.5 * step), self.at(s + step), len(self.across)
        Q = middle[1 : 1 + count]
        return np.concatenate((middle[: 1 + count], beside[1 + count :] + step * Q))


@takes(body=BODY, height=NUMBER)
def bendingMoment(body, height):
    """Bending moment of a 2D body in a horizontal section, kN m per metre, see `sectionForces`; for columns
    of a history: {"M": "diagnostics.bendingMoment(scene['wall'], 3.0)"}.

    Parameters
    ----------
    body : Body.
    height : m.
    """
    return _single(body, height).M[0]


@takes(body=BODY, height=NUMBER)
def shearForce(body, height):
    """Shear force of a 2D body in a horizontal section, kN per metre, see `sectionForces`.

    Parameters
    ----------
    body : Body.
    height : m.
    """
    return _single(body, height).Q[0]


@takes(body=BODY, height=NUMBER)
def normalForce(body, height):
    """Normal force of a body in a horizontal section, kN, tension positive, from the forces on the nodes, see
    `sectionForces`.

    Parameters
    ----------
    body : Body.
    height : m.
    """
    return _single(body, height).N[0]


def alongBeam(body, axis, at):
    """The forces in the cross-sections of a `Beam`: the mean of both elements that meet there."""
    ends = _sectionsOf(body, body.vertices)
    before = _sectionsOf(body, np.asarray(body._core.view("vertexReference", True)))
    span = np.diff(ends, axis=0)
    length = np.linalg.norm(span, axis=1)
    s, isClosed = np.concatenate(([0.0], np.cumsum(length))), np.array_equal(before[0], before[-1])
    each = body.count // len(length)  # domains of an element
    N, Q, M = body.normalForce[::each], body.shearForce[::each], body.bendingMoment[::each]
    sides = np.stack([M + Q * length / 2, M - Q * length / 2], axis=1)  # dM/ds = -Q
    values = [_atEnds(pair, isClosed) for pair in (np.stack([N, N], 1), np.stack([Q, Q], 1), sides)]
    unit = span / length[:, None]
    along = np.stack([_atEnds(np.stack([u, u], 1), isClosed) for u in unit.T], axis=1)
    along /= np.linalg.norm(along, axis=1)[:, None]
    first = np.diff(before, axis=0)
    cosine = first @ first[0] / (np.linalg.norm(first, axis=1) * np.linalg.norm(first[0]))
    isStraight = bool((cosine > 1 - STRAIGHT).all())
    if axis is not None and not isStraight:
        raise ValueError(
            f"sectionForces: axis = {shown(axis)}, and '{body.name}' is not straight; leave it out"
        )
    if isStraight:
        along = first[0] / np.linalg.norm(first[0])
        s = s + ends[0] @ along
        if axis is not None and _axisOf(body, axis) @ along < 0:
            along, s, values[2] = -along, -s, -values[2]
    across = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    rows = [s, ends, ends - before, *values]
    if isStraight and s[-1] < s[0]:
        rows = [row[::-1] for row in rows]
    if at is not None:
        at = _stations(body, np.zeros(2), 0.0, (rows[0][0], rows[0][-1]), at)
        rows = [at, *(_between(at, rows[0], row) for row in rows[1:])]
    return SectionForces(body.name, along, across, *rows)


def _sectionsOf(body, vertices):
    """Middles of the cross-sections of a `Beam` in their order, m (N, 2); of a ring the first one again."""
    tables = body._core.tables()
    perSection = tables["masters"][1] - tables["masters"][0]  # see Beam.hpp
    faces = vertices[: tables["slaves"][0]].reshape(-1, perSection, 2)[:, [0, -1]]
    middle = faces.mean(axis=1)
    isClosed = np.count_nonzero(body.cells == 0) == 2
    return np.concatenate((middle, middle[:1])) if isClosed else middle


def _atEnds(pair, isClosed):
    """Of what domains have at their start and end (N, 2), what cross-sections have (N + 1,)."""
    both = np.concatenate((pair[:1, 0], (pair[:-1, 1] + pair[1:, 0]) / 2, pair[-1:, 1]))
    if isClosed:
        both[[0, -1]] = (both[0] + both[-1]) / 2
    return both


def _between(at, s, row):
    row = row.reshape(len(s), -1)
    values = np.stack([np.interp(at, s, column) for column in row.T], axis=1)
    return values if values.shape[1] > 1 else values[:, 0]


def _single(body, height):
    return sectionForces(body, np.eye(body.scene.dim)[-1], height)


def _check(body):
    if not body.count:
        raise ValueError(f"sectionForces: '{body.name}' is empty; give a body with particles")
    if body.scene.isAxisymmetric and not isBeam(body.material):
        raise ValueError(
            f"sectionForces: '{body.name}' is in an axisymmetric scene, where stress round the axis acts, "
            "too; use diagnostics.sectionForce, or the stress of the body"
        )
    if body.fbar:
        raise ValueError(
            f"sectionForces: '{body.name}' has fbar=True, and its mean stress acts by the cells, not by the "
            "body; add it with fbar=False"
        )


def _axisOf(body, axis):
    """Unit vector along a body."""
    dim = body.scene.dim
    if axis is None:
        return np.eye(dim)[np.ptp(body.corners().reshape(-1, dim), axis=0).argmax()]
    vector = np.eye(dim)[AXES[axis]] if isinstance(axis, str) and axis in "xyz"[:dim] and axis else axis
    try:
        vector = np.asarray(vector, float)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (dim,) or not np.isfinite(vector).all() or not vector.any():
        raise ValueError(
            f"sectionForces: axis = {shown(axis)} is not allowed; give one of {', '.join('xyz'[:dim])}, or a "
            f"vector of {dim} numbers"
        )
    return vector / np.linalg.norm(vector)


def _across(along):
    """Unit vectors across an axis, as rows: one in 2D, to its right; two in 3D."""
    if len(along) == 2:
        return np.array([[along[1], -along[0]]])
    first = np.eye(3)[np.abs(along).argmin()]
    first = first - (first @ along) * along
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(along, first)])


def _stations(body, along, width, ends, at):
    lower, upper = ends
    if at is None:
        k = np.abs(along).argmax()
        if np.abs(along[k]) > 1 - 1e-9:
            lines = np.sort(np.sign(along[k]) * body.scene.lines[k])
        else:
            lines = lower + width * np.arange(int((upper - lower) / width) + 1)
        slack = 1e-9 * width
        return lines[(lines >= lower - slack) & (lines <= upper + slack)]
    try:
        stations = np.atleast_1d(np.asarray(at, float))
    except (TypeError, ValueError):
        stations = np.zeros((0, 0))
    if stations.ndim != 1 or not np.isfinite(stations).all():
        raise ValueError(f"sectionForces: at = {shown(at)} is not allowed; give positions in m")
    if ((stations < lower - width) | (stations > upper + width)).any():
        raise ValueError(
            f"sectionForces: at = {shown(at)} is beyond '{body.name}', which reaches from {lower:g} to "
            f"{upper:g} m along the axis; give positions there"
        )
    return stations


def _along(body, along, width, stations):
    """Mean position and displacement of a body round stations, weighted linearly over a cell to both sides,
    and carried to the station by the slope there."""
    s, mass = body.position @ along, body.mass
    rows = {name: np.zeros((len(stations), body.scene.dim)) for name in ("position", "displacement")}
    for k, at in enumerate(stations):
        weight = mass * np.maximum(1 - np.abs(s - at) / (2 * width), 0.0)
        if not weight.any():
            weight = mass * (np.abs(s - at) <= np.abs(s - at).min() + width)
        d = s - weight @ s / weight.sum()
        spread = weight @ d**2
        for name, row in rows.items():
            values = getattr(body, name)
            slope = (weight * d) @ values / spread if spread > 0 else 0.0
            row[k] = weight @ values / weight.sum() + slope * (at - weight @ s / weight.sum())
    return rows
