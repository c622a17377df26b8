# SPDX-License-Identifier: GPL-2.0-or-later
"""Shapes of rigid bodies, for `RigidContact.addBody`: mpm.rigid.Sphere(0.1)."""

from .shapes import Box, Facet, HeightField, Shape, Sphere, Wall, facetsFromFile

__all__ = ["Box", "Facet", "HeightField", "Shape", "Sphere", "Wall", "facetsFromFile"]


def __dir__():
    return __all__
