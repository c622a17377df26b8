# SPDX-License-Identifier: GPL-2.0-or-later
"""The public name of `yade_mpm.engine.rigid`."""

from .engine.rigid import Box, Facet, Shape, Sphere, Wall

__all__ = ["Box", "Facet", "Shape", "Sphere", "Wall"]
