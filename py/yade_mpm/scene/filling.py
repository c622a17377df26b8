# SPDX-License-Identifier: GPL-2.0-or-later
"""Lifts of fill: boxes down to the surface that is there, be it heaved or settled."""

import numpy as np

from ..base.wording import shown
from ..particle.body import Body
from ..particle.types import Boxes

STRIPS = 4  # of a box in plan along each axis, in which the surface below it is looked up
LEAST_SHARE = 0.05  # of a whole box, below which a box is left out


def bodiesBelow(scene, name, on):
    """Bodies that a fill is put on: those given, or none."""
    bodies = [on] if isinstance(on, Body) else list(on) if isinstance(on, (tuple, list)) else [on]
    for body in bodies or [on]:
        if not (isinstance(body, Body) and body.scene is scene):
            raise TypeError(
                f"body '{name}': on = {shown(body)}; give bodies of this scene, which it is filled onto"
            )
    return bodies


def above(boxes, bodies, name):
    """The boxes of a fill without what lies below the surface of bodies: cut ones have their share and their
    centre of mass. ValueError where nothing is left, or the type does not fill with boxes."""
    if not isinstance(boxes, Boxes):
        raise ValueError(f"body '{name}': on cuts boxes at the surface; give particles=mpm.UGIMP(), no mesh")
    half, dim = np.asarray(boxes.halfSize), boxes.positions.shape[1]
    bottom, top = boxes.positions[:, -1] - half[-1], boxes.positions[:, -1] + half[-1]
    share, centre = np.zeros(len(bottom)), np.zeros(boxes.positions.shape)
    for step in np.ndindex(*[STRIPS] * (dim - 1)):
        plan = boxes.positions[:, :-1] + ((2 * np.array(step) + 1) / STRIPS - 1) * half[:-1]
        floor = np.clip(surfaceBelow(bodies, plan), bottom, top)
        part = (top - floor) / (2 * half[-1]) / STRIPS ** (dim - 1)
        share += part
        centre += part[:, None] * np.column_stack((plan, 0.5 * (top + floor)))
    kept = np.flatnonzero(share >= LEAST_SHARE)
    if not len(kept):
        raise ValueError(
            f"body '{name}': all of the region is below the surface of the bodies that it is put on"
        )
    shares = share[kept] if boxes.shares is None else share[kept] * boxes.shares[kept]
    return Boxes(centre[kept] / share[kept, None], boxes.halfSize, shares)


def surfaceBelow(bodies, points):
    """Height of the highest domain of some bodies at points in plan (N, dim - 1), m; -inf: there is none."""
    height = np.full(len(points), -np.inf)
    order = np.argsort(points[:, 0], kind="stable")
    sorted_ = points[order, 0]
    for body in (b for b in bodies if b.count):
        corners = body.corners()
        lower, upper = corners.min(axis=1), corners.max(axis=1)
        first = np.searchsorted(sorted_, lower[:, 0])
        last = np.searchsorted(sorted_, upper[:, 0], "right")
        for a, b, low, high in zip(first, last, lower, upper):
            under = order[a:b]
            if len(low) == 3:
                under = under[(points[under, 1] >= low[1]) & (points[under, 1] <= high[1])]
            height[under] = np.maximum(height[under], high[-1])
    return height
