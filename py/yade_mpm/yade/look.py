# SPDX-License-Identifier: GPL-2.0-or-later
"""A look at the soil every so many steps of YADE, and the colours of a field."""

import matplotlib
import numpy as np

from ..base.kinds import COUNT
from ..base.wording import shown
from ..plot.picture import componentOf, partsOf
from .plane import Plane

COLOURS = "viridis"
GREY = 0.55  # of bodies that do not have the field


class Look:
    """Base of what shows the soil, an exchange of a coupling: calls `update` every `period` steps.

    Neither bodies nor forces are exchanged, so that the plugin's engines may step between two looks.

    Parameters
    ----------
    omega : O of YADE.
    """

    def __init__(self, omega):
        self._omega, self._next = omega, omega.iter

    def read(self, coupling):
        """Looks where it is time."""
        if self._omega.iter >= self._next:
            self.look()

    def look(self):
        """Looks now, and again after `period` steps."""
        self._next = self._omega.iter + self.period
        self.update()

    def apply(self, coupling):
        """Nothing: no force comes of it."""

    def cyclesToLook(self, coupling):
        """Steps before the next look."""
        return self._next - self._omega.iter - 1

    def grantedPart(self):
        """Nothing that reads or pushes bodies."""
        return ()


def checkLook(who, omega, period):
    """RuntimeError while YADE runs, ValueError for a period that is no whole number of steps."""
    if omega.running:
        raise RuntimeError(f"{who}: YADE is running; O.pause() first")
    COUNT.check(who, "steps", period=period)


def coloursOf(who, bodies, field, component=None, limits=None, colours=COLOURS):
    """Colours (n, 3) of all particles of some bodies by a field, and the values at the ends of the scale.

    Parameters
    ----------
    who : str, for errors.
    bodies : bodies of a scene.
    field, component : name of a field, and "x" of a vector (None: its length), "xy" of a tensor.
    limits : values at the ends; None: the extremes.
    colours : name of a colour map of matplotlib.

    Raises ValueError where no body has the field.
    """
    parts = partsOf(bodies)
    values = [part.field(field) for part in parts]
    if all(v is None for v in values):
        known = sorted({name for part in parts for name in part.field.units})
        raise ValueError(f"{who}: no body has a field {shown(field)}; fields: {', '.join(known)}")
    numbers = [
        np.full(len(p.corners), np.nan) if v is None else componentOf(field, v[0], component)
        for p, v in zip(parts, values)
    ]
    value = np.concatenate(numbers)
    low, high = limits or (np.nanmin(value), np.nanmax(value))
    coloured = matplotlib.colormaps[colours]((value - low) / (high - low or 1.0))[:, :3]
    coloured[np.isnan(value)] = GREY
    return coloured, (low, high)


def planeOf(coupling):
    """The plane of YADE in which a 2D scene is shown: that of its bodies."""
    return next((e.plane for e in coupling.exchanges if hasattr(e, "plane")), Plane())


def toYade(plane, points):
    """Points (..., dim) of a scene in the axes of YADE, (..., 3)."""
    if points.shape[-1] == 2:
        points = np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
    return plane.toYade(points)


def chosen(scene, bodies):
    """Bodies of a scene, given themselves or by their names; all by default."""
    return [scene[b] if isinstance(b, str) else b for b in bodies or scene.bodies]
