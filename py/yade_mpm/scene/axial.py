# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes that are symmetric about an axis: where the axis is, and what they do without."""

# Engines that know plane strain and space alone.
UNDONE = ("PoreWater", "RigidContact", "UniformAlong", "ViscousBoundary")


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
        if name in UNDONE and not engine.dead:
            raise ValueError(
                f"{name}: the scene is axisymmetric, and {name} knows plane strain and space alone; leave it "
                "out, or make the scene in 3D"
            )
