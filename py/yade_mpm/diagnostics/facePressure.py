# SPDX-License-Identifier: GPL-2.0-or-later
"""Pressure of contact on the faces of a structure, facet by facet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base.kinds import BODY, NUMBER, Kind, takes
from ..base.wording import shown
from ..engine.contact import Contact
from ..geometry.mesh import facetAreas

SIDES = {
    2: {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)},
    3: {
        "left": (-1, 0, 0),
        "right": (1, 0, 0),
        "front": (0, -1, 0),
        "back": (0, 1, 0),
        "bottom": (0, 0, -1),
        "top": (0, 0, 1),
    },
}
FACING = 0.7  # cosine from which on a facet belongs to a side: 45 degrees
OF_A_BODY = 3  # numbers that stand before the impulses of a body, see FacetImpulses.hpp


@dataclass(frozen=True, eq=False, repr=False)
class FacePressure:
    """What contact does to the facets of a body, as a mean over a time: made by `facePressure`.

    Attributes
    ----------
    body : its name.
    begin : s, start of the time of which it is the mean.
    end : s, its end.
    impulse : (N, dim), kN s, on each facet since the contact began.
    force : (N, dim), kN, on each facet: the mean.
    centre : (N, dim), of each facet, m.
    normal : (N, dim), of each facet, out of the body, -.
    area : (N,), m2 (plane strain: m).
    """

    body: str
    begin: float
    end: float
    impulse: np.ndarray
    force: np.ndarray
    centre: np.ndarray
    normal: np.ndarray
    area: np.ndarray

    def __repr__(self):
        return (
            f"<FacePressure of '{self.body}': {len(self.area)} facets, t = {self.begin:g} to {self.end:g} s>"
        )

    @property
    def pressure(self) -> np.ndarray:
        """Normal stress on each facet, kPa (N,), positive where it presses on the body."""
        return -(self.force * self.normal).sum(axis=1) / self.area

    @property
    def shear(self) -> np.ndarray:
        """Shear stress on each facet as a vector along it, kPa (N, dim)."""
        along = self.force - (self.force * self.normal).sum(axis=1)[:, None] * self.normal
        return along / self.area[:, None]

    @property
    def total(self) -> np.ndarray:
        """Sum of the forces of all facets, kN (dim,)."""
        return self.force.sum(axis=0)

    def side(self, which: str | tuple) -> FacePressure:
        """The facets of one side alone, in the order of their height.

        Parameters
        ----------
        which : "left", "right", "bottom", "top"; in 3D also "front", "back"; or a vector that points away
            from the side. Facets within 45 degrees of it count.

        Raises ValueError for another name, or where no facet looks there.
        """
        dim = self.centre.shape[1]
        direction = SIDES[dim].get(which) if isinstance(which, str) else which
        if direction is None or np.shape(direction) != (dim,) or not np.linalg.norm(direction) > 0:
            raise ValueError(
                f"FacePressure: side {shown(which)} is not allowed; give one of {', '.join(SIDES[dim])}, or "
                f"a vector of {dim} numbers"
            )
        facing = self.normal @ (np.asarray(direction, float) / np.linalg.norm(direction))
        found = np.flatnonzero(facing > FACING)
        if not len(found):
            raise ValueError(
                f"FacePressure: no facet of '{self.body}' looks towards {shown(which)}; give another side"
            )
        found = found[np.argsort(self.centre[found, -1], kind="stable")]
        arrays = ("impulse", "force", "centre", "normal", "area")
        return replace(self, **{name: getattr(self, name)[found] for name in arrays})


EARLIER = Kind("an earlier result of facePressure", lambda value: isinstance(value, FacePressure))


@takes(body=BODY, since=EARLIER)
def facePressure(body, since: FacePressure | None = None) -> FacePressure:
    """Normal and shear stress of contact on each facet of a structure, as a mean over a time.

        before = mpm.facePressure(wall)
        scene.run(until=12)
        back = mpm.facePressure(wall, since=before).side("left")
        back.centre[:, 1], back.pressure  # m, kPa

    Parameters
    ----------
    body : Body with a mesh, in a group of meshes alone, and a `Contact` among the engines (`scene.contact`).
    since : an earlier result, from whose time on the mean is taken; default None: since the body has first
        met another group. Forces of single steps are noisy: take the mean over 0.1 s and more.

    Each side of a wall has facets of its own, so what presses on the back and on the front is told apart. The
    sum over the facets is the force of contact on the body's group, to round-off. A facet feels the soil up
    to a cell away along the face, so a pressure that changes within a cell is smeared over it.

    Raises ValueError for a body without a mesh or contact, and for `since` of another body or the same time.
    """
    contact = _contactOf(body)
    facets = np.reshape(body._core.boundaryFacets(), (-1, 2 ** (body.scene.dim - 1))).astype(int)
    begin, impulse = _sums(contact, body, len(facets))
    end, before = body.scene.time, np.zeros_like(impulse)
    if since is not None:
        if since.body != body.name or since.impulse.shape != impulse.shape:
            raise ValueError(
                f"facePressure: since is of {len(since.area)} facets of '{since.body}', and '{body.name}' "
                f"has {len(facets)}; give a result for all facets of the same body"
            )
        begin, before = since.end, since.impulse
    if not end > begin and since is not None:
        raise ValueError(f"facePressure: since is of the same time, {end:g} s; run the scene in between")
    corners = body.vertices[facets]
    vector = facetAreas(corners)
    length = np.linalg.norm(vector, axis=1)
    middle = corners.mean(axis=1)
    area = length * body.scene._thicknessAt(middle[:, 0])
    force = (impulse - before) / (end - begin) if end > begin else np.zeros_like(impulse)
    return FacePressure(body.name, begin, end, impulse, force, middle, vector / length[:, None], area)


@takes(body=BODY, lower=NUMBER, upper=NUMBER)
def pressureImpulse(body, side, lower=-np.inf, upper=np.inf):
    """Time integral of the pressure on a face of a structure, kPa s, the mean between two heights.

        scene.history(0.1, columns={"p": "d/dt diagnostics.pressureImpulse(scene['wall'], 'left', 2, 3)"})

    Parameters
    ----------
    body : Body, see `facePressure`.
    side : as of `FacePressure.side`.
    lower, upper : m, heights between which the middles of facets lie; default: the whole face.

    "d/dt " makes it the mean pressure since the row before, kPa. Raises ValueError where no facet is.
    """
    face = facePressure(body).side(side)
    inside = (face.centre[:, -1] >= lower) & (face.centre[:, -1] <= upper)
    if not inside.any():
        raise ValueError(
            f"pressureImpulse: no facet on the {side} of '{body.name}' is between {lower:g} and {upper:g} m; "
            "give heights farther apart"
        )
    pressed = -(face.impulse * face.normal).sum(axis=1)
    return float(pressed[inside].sum() / face.area[inside].sum())


def _contactOf(body):
    """The engine that knows what touches a body; ValueError where none can."""
    who = f"facePressure: '{body.name}'"
    contact = next((e for e in body.scene.engines if isinstance(e, Contact) and not e.dead), None)
    if contact is None:
        raise ValueError(f"{who} is in no contact; call scene.contact(body, soil) before the first step")
    members = [other for other in body.scene.bodies if other.group == body.group and other.count]
    without = [other for other in members if other.cells is None]
    if body.cells is None or without:
        name = (without or [body])[0].name
        raise ValueError(
            f"{who} is in a group with '{name}', which is of boxes and has no facets; give a structure a "
            "mesh, mpm.APDI(...), and a group of its own"
        )
    return contact


def _sums(contact, body, count):
    """Time from which on the impulses on the facets of a body are known, s, and these, kN s (N, dim)."""
    sums, dim = np.asarray(contact.facetImpulses, float), body.scene.dim
    number = next(k for k, other in enumerate(body.scene.bodies) if other is body)
    at = 0
    while at < len(sums):
        found, begin, facets = sums[at : at + OF_A_BODY]
        first, at = at + OF_A_BODY, at + OF_A_BODY + 3 * int(facets)
        if int(found) == number and int(facets) == count:
            return begin, sums[first:at].reshape(-1, 3)[:, :dim].copy()
    return body.scene.time, np.zeros((count, dim))
