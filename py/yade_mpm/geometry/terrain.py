# SPDX-License-Identifier: GPL-2.0-or-later
"""Ground by heights on a raster: the same surface as that of the solver (`HeightSurface.hpp`), and regions on
it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..base.wording import shown
from .numbers import floats, numbers
from .primitives import Primitive

REACH = 2  # heights beside one up to which it counts
STRIPS = 4  # of a box along each axis in plan, in which a layer is looked up


class Terrain:
    """Ground by heights on a raster; made by `heightField` and `readTerrain`.

    Attributes
    ----------
    heights : (columns, rows), m, along x and y; of a 2D scene (columns,).
    spacing : (1,) or (2,), m, between two heights.
    origin : (1,) or (2,), m, x and y of the first height.
    reference : coordinate system as text, of a GeoTIFF; None: none is known.
    """

    def __init__(self, heights, spacing, origin=None, reference=None):
        self.heights = _heights("heightField", "array", heights)
        axes = self.heights.ndim
        self.spacing = _alongAxes("spacing", spacing, axes)
        self.origin = np.zeros(axes) if origin is None else _alongAxes("origin", origin, axes)
        self.reference = reference
        if not (self.spacing > 0).all():
            raise ValueError(
                f"heightField: spacing = {shown(spacing)} is not allowed; give one positive number in m, "
                "or one "
                "for each axis of the raster"
            )
        if lost := int((~np.isfinite(self.heights)).sum()):
            raise ValueError(
                f"heightField: {lost} of {self.heights.size} heights are not finite; fill the gaps of the "
                "raster, "
                "or give a part of it without any"
            )

    def __repr__(self):
        size = " x ".join(map(str, self.heights.shape))
        low, high = self.heights.min(), self.heights.max()
        return f"<Terrain of {size} heights, {low:.4g} to {high:.4g} m>"

    @property
    def dim(self) -> int:
        """Of the scenes that it is ground of: 2 or 3."""
        return self.heights.ndim + 1

    @property
    def upper(self) -> np.ndarray:
        """x, y of the last height, m."""
        return self.origin + (np.array(self.heights.shape) - 1) * self.spacing

    def height(self, points: ArrayLike) -> np.ndarray:
        """Height of the surface, m (N,).

        Parameters
        ----------
        points : (N, 1 or more), m, of which x (in 3D x, y) count.
        """
        points = numbers("height", "points", points)
        if points.ndim != 2 or points.shape[1] < self.dim - 1:
            raise ValueError(
                f"height: points has shape {points.shape}; give (N, {self.dim - 1}) or (N, {self.dim})"
            )
        return surfaceOf(self.heights, self.spacing, self.origin, points)

    def layer(self, depth: ArrayLike) -> Layer:
        """The region from the surface up to a depth above it, for soil that lies on the ground.

        Parameters
        ----------
        depth : m, one number, or a raster of the shape of the heights, zero where nothing lies.
        """
        depth = _heights("layer", "depth", depth, least=0)
        if depth.ndim and depth.shape != self.heights.shape:
            raise ValueError(
                f"layer: depth has the shape {depth.shape}; give one number or the shape of the heights, "
                f"{self.heights.shape}"
            )
        if not (np.isfinite(depth).all() and (depth >= 0).all() and depth.max() > 0):
            raise ValueError("layer: depth has entries that are negative or not finite, or none above zero")
        return Layer(self.heights, self.spacing, self.origin, np.broadcast_to(depth, self.heights.shape))

    def below(self) -> Below:
        """The region below the surface, to subtract from another one: `box(...) - terrain.below()`."""
        return Below(self.heights, self.spacing, self.origin)


def heightField(array: ArrayLike, spacing: ArrayLike, origin: ArrayLike | None = None) -> Terrain:
    """Ground by heights on a raster, for `scene.terrain` and for regions on it.

        ground = mpm.heightField(heights, spacing=2.0)
        scene.add("slide", ground.layer(depth), soil)
        scene.terrain(ground, friction=0.4)

    Parameters
    ----------
    array : m, (columns, rows) along x and y; in 2D (columns,) along x. A raster of a map, whose rows run from
        north to south, is `map.T[:, ::-1]`; `readTerrain` turns it.
    spacing : m, between two heights; one number, or one for each axis.
    origin : m, x, y of the first height; default zero.

    The surface is the bilinear one through the heights, averaged over a cell of the raster, so that it has no
    edges; beyond the raster it goes on straight.

    Raises ValueError for gaps (nan), or numbers that are not allowed.
    """
    return Terrain(array, spacing, origin)


def surfaceOf(heights, spacing, origin, points):
    """Heights of a surface at points in plan: quadratic B-splines, straight on beyond the raster."""
    axes = heights.ndim
    padded = np.pad(heights, 1, mode="reflect", reflect_type="odd")
    first, weights, beyond = zip(*(_weights(points[:, k], k, heights, spacing, origin) for k in range(axes)))
    height = np.zeros(len(points))
    for offsets in np.ndindex(*[3] * axes):
        there = padded[tuple(f + o for f, o in zip(first, offsets))]
        weight = np.prod([w[0][o] for w, o in zip(weights, offsets)], axis=0)
        for k in np.flatnonzero([b.any() for b in beyond]):
            slope = [w[int(k == a)][o] for a, (w, o) in enumerate(zip(weights, offsets))]
            weight = weight + beyond[k] * np.prod(slope, axis=0)
        height += weight * there
    return height


def _weights(x, axis, heights, spacing, origin):
    """Along an axis: number of the first of three heights with one more on each side, (weights, their
    slopes), distance beyond the raster, m."""
    inCells = (x - origin[axis]) / spacing[axis]
    u = np.clip(inCells, 0, heights.shape[axis] - 1)
    middle = (u + 0.5).astype(int)
    t = u - middle
    before, after = 0.5 - t, 0.5 + t
    values = 0.5 * before**2, 0.75 - t**2, 0.5 * after**2
    slopes = -before / spacing[axis], -2 * t / spacing[axis], after / spacing[axis]
    return middle, (values, slopes), (inCells - u) * spacing[axis]


class OnRaster(Primitive):
    """Region that a surface over a raster bounds; base of `Below` and `Layer`."""

    def __init__(self, kind, heights, spacing, origin, **more):
        self._heights, self._spacing, self._origin = (
            np.asarray(a, float) for a in (heights, spacing, origin)
        )
        super().__init__(
            kind,
            self._heights.ndim + 1,
            heights=self._heights,
            spacing=self._spacing,
            origin=self._origin,
            **more,
        )

    def __repr__(self):
        return f"{self._kind}(a raster of {' x '.join(map(str, self._heights.shape))} heights)"

    def _surface(self, points):
        return surfaceOf(self._heights, self._spacing, self._origin, points)

    def _size(self):
        return float(np.ptp(self._heights) + (np.array(self._heights.shape) * self._spacing).max())


class Below(OnRaster):
    """All below the surface of a `Terrain`."""

    def __init__(self, heights, spacing, origin):
        super().__init__("below", heights, spacing, origin)

    def bounds(self):
        lower, upper = np.full(self.dim, -np.inf), np.full(self.dim, np.inf)
        upper[-1] = self._heights.max()
        return lower, upper

    def _covers(self, points):
        return points[:, -1] < self._surface(points)

    def _breaks(self, axis):
        return [self._heights.min(), self._heights.max()] if axis == self.dim - 1 else []


class Layer(OnRaster):
    """Soil on a `Terrain`, up to a depth above it."""

    def __init__(self, heights, spacing, origin, depth):
        depth = np.array(depth, float)
        super().__init__("layer", heights, spacing, origin, depth=depth)
        self._depth = depth

    def bounds(self):
        plan = range(self._depth.ndim)
        there = [np.flatnonzero(self._depth.any(axis=tuple(a for a in plan if a != k))) for k in plan]
        first = np.maximum([n[0] - REACH for n in there], 0)
        last = np.minimum([n[-1] + REACH for n in there], np.array(self._depth.shape) - 1)
        near = tuple(slice(a, b + 1) for a, b in zip(first, last))
        low, high = self._heights[near].min(), (self._heights + self._depth)[near].max()
        return (
            np.append(self._origin + first * self._spacing, low),
            np.append(self._origin + last * self._spacing, high),
        )

    def depthAt(self, points):
        """Depth at points in plan, m; none beyond the raster."""
        upper = self._origin + (np.array(self._depth.shape) - 1) * self._spacing
        plan = points[:, : self.dim - 1]
        isOn = ((plan >= self._origin) & (plan < upper)).all(axis=1)
        return np.where(isOn, np.maximum(surfaceOf(self._depth, self._spacing, self._origin, points), 0), 0)

    def _covers(self, points):
        above = points[:, -1] - self._surface(points)
        return (above >= 0) & (above < self.depthAt(points))

    def shareOf(self, centres, spacing):
        """Centroids (N, dim) and shares (N,) of the parts inside of boxes: by columns, 4 along each axis in
        plan."""
        bottom, top = centres[:, -1] - spacing[-1] / 2, centres[:, -1] + spacing[-1] / 2
        share, centroid = np.zeros(len(centres)), np.zeros(centres.shape)
        count = STRIPS ** (self.dim - 1)
        for step in np.ndindex(*[STRIPS] * (self.dim - 1)):
            plan = centres[:, :-1] + ((np.array(step) + 0.5) / STRIPS - 0.5) * spacing[:-1]
            floor = self._surface(plan)
            roof = np.clip(floor + self.depthAt(plan), bottom, top)
            floor = np.clip(floor, bottom, top)
            part = (roof - floor) / spacing[-1] / count
            share += part
            centroid += part[:, None] * np.column_stack((plan, (roof + floor) / 2))
        return centroid / np.maximum(share, 1e-300)[:, None], share

    def _breaks(self, axis):
        lower, upper = self.bounds()
        return [lower[axis], upper[axis]]


def onTerrain(region) -> bool:
    """Whether a region has a raster, alone or among its parts."""
    parts = (getattr(region, name, None) for name in ("_a", "_b"))
    return isinstance(region, OnRaster) or any(onTerrain(part) for part in parts if part is not None)


def _heights(who, what, given, least=1):
    try:
        array = floats(given)
    except (TypeError, ValueError):
        raise TypeError(
            f"{who}: {what} = {shown(given)} is not made of numbers; give an array in m"
        ) from None
    if array.ndim not in (least, 1, 2) or array.ndim and min(array.shape) < 2:
        raise ValueError(
            f"{who}: {what} has the shape {array.shape}; give at least two numbers along x, or along x and "
            "y each"
        )
    return array


def _alongAxes(name, given, axes):
    try:
        values = np.atleast_1d(floats(given))
    except (TypeError, ValueError):
        values = np.zeros(0)
    if name == "spacing" and values.shape == (1,):
        values = np.full(axes, values[0])
    if values.shape != (axes,) or not np.isfinite(values).all():
        raise ValueError(
            f"heightField: {name} = {shown(given)} is not allowed; give one number in m for each axis of "
            "the raster"
        )
    return values
