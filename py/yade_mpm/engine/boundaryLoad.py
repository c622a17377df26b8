# SPDX-License-Identifier: GPL-2.0-or-later
"""Pressures and tractions on the boundary of a body."""

import numpy as np

from ..geometry.mesh import FACETS, boundaryFacets
from ..geometry.region import Region
from ..particle.body import Body
from .engine import generated


class BoundaryLoad(generated["BoundaryLoad"]):
    __doc__ = (
        generated["BoundaryLoad"].__doc__
        + """
body : the loaded APDI body.
where : region; facets whose centre is inside are loaded (default: all boundary facets)."""
    )

    _fixed = ("body", "facets")

    def bind(self, scene):
        body = scene[self.body]
        most = body.id.max(initial=-1), 2 * scene.dim
        pairs = np.reshape(self.facets, (-1, 2)) if len(self.facets) % 2 == 0 else np.full((1, 2), -1)
        if ((pairs < 0) | (body.converted == 0) & (pairs > np.array(most) - (0, 1))).any() or (
            pairs % 1
        ).any():
            raise ValueError(
                f"BoundaryLoad: facets name domains that '{self.body}' does not have; make the load from the "
                "body"
            )

    def __init__(self, body, where=None, **attributes):
        self._usedBy = body if isinstance(body, str) else getattr(body, "name", None)
        if isinstance(body, str):  # from a checkpoint: the facets are given
            super().__init__(body=body, **attributes)
            return
        if not isinstance(body, Body):
            raise TypeError(f"BoundaryLoad: body = {body!r}; give a body, as scene.add returns it")
        if not (where is None or isinstance(where, Region)):
            raise TypeError(f"BoundaryLoad: where = {where!r}; give a region, e.g. box((0, 2), (1, 3))")
        if body.mesh is None:
            raise ValueError(
                f"BoundaryLoad: '{body.name}' "
                + (
                    "lost its first mesh when domains were converted; make loads before that"
                    if body.type.core.isMeshed
                    else "has no boundary facets; loads need an APDI body"
                )
            )
        facets, owners = boundaryFacets(body.mesh)
        if where is not None:
            inside = where.contains(body.mesh.points[facets].mean(axis=1))
            facets, owners = facets[inside], owners[inside]
        if len(facets) == 0:
            raise ValueError(
                f"BoundaryLoad: no boundary facet of '{body.name}' is inside {where!r}; widen the region"
            )
        pairs = [(owner, _facetNumber(body.mesh.cells[owner], facet)) for facet, owner in zip(facets, owners)]
        super().__init__(body=body.name, facets=np.array(pairs, float).ravel(), **attributes)
        body.scene.loadsAndDrives.append(self)


def _facetNumber(cell, facet):
    """Which facet of a cell has these vertices."""
    dim = 2 if len(cell) == 4 else 3
    for number, corners in enumerate(FACETS[dim]):
        if set(cell[list(corners)]) == set(facet):
            return number
    raise AssertionError("a boundary facet belongs to its owner")
