# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes that are symmetric about an axis: where the axis is, and what they do without."""

import numpy as np

from ..base.wording import shown

# Engines that know plane strain and space alone.
UNDONE = ("RigidContact", "UniformAlong", "ViscousBoundary")
ON_AXIS = 1e-9  # of the width of the grid: as near to the axis it begins there


def check(axisymmetric, lower, upper):
    """Refuses other values than True and False; a grid that begins near the axis begins there."""
    if not isinstance(axisymmetric, (bool, np.bool_)):
        raise TypeError(f"Scene: axisymmetric = {shown(axisymmetric)}; give True or False")
    if axisymmetric and 0 < abs(lower[0]) < ON_AXIS * abs(upper[0]):
        lower[0] = 0.0


def begin(core, lower):
    """Makes the grid of a scene that of rings. ValueError for one that cannot be."""
    if len(lower) != 2:
        raise ValueError(
            f"Scene: axisymmetric=True, and lower has {len(lower)} components; give two, (distance from the "
            "axis, height)"
        )
    if lower[0] < 0:
        raise ValueError(
            f"Scene: axisymmetric=True, and the grid begins at x = {lower[0]:g} m; x is the distance from "
            "the axis: begin it at 0, or beyond"
        )
    core.isAxisymmetric = True


def refuseUndone(scene):
    """ValueError before a run for what axial symmetry is not made for."""
    if not scene.isAxisymmetric:
        return
    for engine in scene.engines:
        name = type(engine).__name__
        if name == "GridSolver" and any((engine.gravity or (0,))[:1]):
            raise ValueError(
                f"GridSolver: gravity = {tuple(engine.gravity)} points away from the axis of the scene: "
                "give it along the axis, or make the scene in 3D"
            )
        if name in UNDONE and not engine.dead:
            raise ValueError(
                f"{name}: the scene is axisymmetric, and {name} knows plane strain and space alone; leave it "
                "out, or make the scene in 3D"
            )
