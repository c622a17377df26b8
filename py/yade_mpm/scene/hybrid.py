# SPDX-License-Identifier: GPL-2.0-or-later
"""A soil that is boxes where it flows, and a mesh of domains elsewhere: the hybrid by one word of
`Scene.add`."""

import numpy as np

from ..base.wording import shown
from ..geometry.numbers import isNumber
from ..geometry.region import Region
from ..geometry.regions import box
from ..particle.body import Body
from ..particle.types import classes

MESH = " (mesh)"  # behind the name of the body, of its other part


def addHybrid(scene, name, region, flow, add):
    """Adds boxes in `flow` and a mesh of cells elsewhere; returns the body of the boxes.

    flow : region, or (region or body, distance in m). add(name, region, type) adds a body.
    """
    if not isinstance(region, Region):
        raise TypeError(f"body '{name}': flow divides a region; region = {shown(region)} is a mesh")
    zone = flowZone(scene, name, flow)
    near = add(name, region & zone, None)
    size = tuple(float(c) for c in scene.cell)
    rest = classes["APDI"](size=size[0] if len(set(size)) == 1 else size, matched=near)
    far = add(name + MESH, region - zone, rest)
    near._chosen["particles"] = "it is where the soil flows"
    far._chosen["particles"] = f"it is away from the flow, matched to '{name}'"
    return near


def flowZone(scene, name, flow):
    """The region that flows; of a distance round something, a box on lines of nodes."""
    if isinstance(flow, Region):
        return flow
    isNear = isinstance(flow, (tuple, list)) and len(flow) == 2 and isinstance(flow[0], (Region, Body))
    if not (isNear and isNumber(flow[1]) and 0 < flow[1] < np.inf):
        raise TypeError(
            f"body '{name}': flow = {shown(flow)}; give the region that flows, or (pile, 2.0): the pile, a "
            "body or a region, and how far from it the soil flows, m"
        )
    what, distance = flow
    if isinstance(what, Body):
        corners = what.corners().reshape(-1, scene.dim)
        lower, upper = corners.min(axis=0), corners.max(axis=0)
    else:
        lower, upper = what.bounds()
    ends = [
        (_line(x, low - distance, "right", -1), _line(x, up + distance, "left", 0))
        for x, low, up in zip(scene.lines, lower, upper)
    ]
    return box(*zip(*ends))


def _line(lines, x, side, beyond):
    """The line of nodes at or beyond x, within the grid."""
    tolerance = 1e-9 * np.ptp(lines)
    n = np.searchsorted(lines, x + (tolerance if beyond else -tolerance), side) + beyond
    return float(lines[np.clip(n, 0, len(lines) - 1)])
