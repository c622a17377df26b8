# SPDX-License-Identifier: GPL-2.0-or-later
"""Maps of a flow over terrain: depth, greatest depth and velocity, arrival."""

from __future__ import annotations

import os

import numpy as np

from ..base.kinds import FILE, NUMBER, POSITIVE, ofClass, takes
from ..engine.callback import Callback
from ..geometry.terrain import Terrain
from .rasters import writeRaster

NAMES = "depth", "greatestDepth", "greatestVelocity", "arrival"
TERRAIN = ofClass("Terrain", "a Terrain, as of mpm.heightField or mpm.readTerrain")


class TerrainMaps(Callback):
    """Looks at the flow over a terrain every period and keeps maps of it; made by `scene.maps`.

    Parameters
    ----------
    terrain : Terrain, whose raster the maps have.
    period : s, scene time between two looks.
    least : m, depth from which on a cell of the raster counts as reached.
    label : name of the engine; default "maps".

    Attributes, arrays of the shape of the heights: `depth` m, volume (with the gaps of loosened soil) over
    the area of the cell in the scene, when it was looked at last, after a run the deposit; `greatestDepth` m;
    `greatestVelocity` m/s, of the mean over the depth, where at least `least` deep; `arrival` s, nan where
    nothing came.
    """

    @takes(period=POSITIVE, least=NUMBER)
    def __init__(self, terrain: Terrain, period: float, least: float, label: str = "maps") -> None:
        if isinstance(terrain, (list, tuple)):  # of a checkpoint
            terrain = Terrain(*terrain)
        TERRAIN.require("TerrainMaps", "terrain", terrain)
        super().__init__(period=period, label=label)
        self._terrain, self._least = terrain, float(least)
        shape = terrain.heights.shape
        self._maps = {name: np.full(shape, np.nan if name == "arrival" else 0.0) for name in NAMES}

    terrain = property(lambda self: self._terrain, doc="Whose raster the maps have.")
    depth = property(lambda self: self._maps["depth"].copy(), doc="m, at the last look.")
    greatestDepth = property(lambda self: self._maps["greatestDepth"].copy(), doc="m, so far.")
    greatestVelocity = property(
        lambda self: self._maps["greatestVelocity"].copy(), doc="m/s, mean over the depth, so far."
    )
    arrival = property(lambda self: self._maps["arrival"].copy(), doc="s; nan where nothing came.")

    @takes(name=FILE)
    def write(self, name: str | os.PathLike) -> list[str]:
        """Writes each map as a raster.

        Parameters
        ----------
        name : of the files, e.g. "slide.tif" for slide-depth.tif, slide-greatestDepth.tif and so on; .tif
            takes rasterio, .asc does not.

        Returns their names.
        """
        stem, ending = os.path.splitext(os.fspath(name))
        files = [f"{stem}-{one}{ending}" for one in NAMES]
        for one, file in zip(NAMES, files):
            writeRaster(file, self._terrain, self._maps[one])
        return files

    def _look(self, scene):
        """Takes the state of a scene into the maps."""
        volume, mass = np.zeros((2, *self._terrain.heights.shape))
        momentum = np.zeros((scene.dim, *volume.shape))
        for body in (b for b in scene.bodies if b.count):
            half = body.corners().reshape(body.count, -1, scene.dim)
            half = 0.5 * (half.max(axis=1) - half.min(axis=1))[:, :-1]
            volumes = body.bulkVolume if hasattr(body, "bulkVolume") else body.volume
            spread = _Spread(self._terrain, body.position[:, :-1], half)
            volume += spread.sum(volumes)
            mass += spread.sum(body.mass)
            for k in range(scene.dim):
                momentum[k] += spread.sum(body.mass * body.velocity[:, k])
        maps = self._maps
        maps["depth"] = volume / self._areas(scene)
        maps["greatestDepth"] = np.maximum(maps["greatestDepth"], maps["depth"])
        isThere = maps["depth"] >= max(self._least, 1e-12)
        speed = np.where(isThere, np.linalg.norm(momentum, axis=0) / np.where(isThere, mass, 1), 0)
        maps["greatestVelocity"] = np.maximum(maps["greatestVelocity"], speed)
        maps["arrival"] = np.where(isThere & np.isnan(maps["arrival"]), scene.time, maps["arrival"])

    def _areas(self, scene):
        """Of the cells of the raster that lie in the scene, m2 (2D: m): at its sides at least half a cell."""
        ground, area = self._terrain, 1.0
        for k, count in enumerate(ground.heights.shape):
            step = ground.spacing[k]
            middles = ground.origin[k] + step * np.arange(count)
            ends = np.clip([middles - step / 2, middles + step / 2], scene.lower[k], scene.upper[k])
            area = np.multiply.outer(area, np.maximum(ends[1] - ends[0], 0.5 * step))
        return area

    # --- engine ---
    def bind(self, scene):
        super().bind(scene)
        if scene.steps == 0 and np.isnan(self._maps["arrival"]).all():
            self._look(scene)

    def act(self, scene):
        self._look(scene)

    def spec(self):
        """Dict of constructor arguments, of plain types."""
        ground = self._terrain
        terrain = ground.heights.tolist(), ground.spacing.tolist(), ground.origin.tolist(), ground.reference
        return {"terrain": terrain, "period": self.period, "least": self._least, "label": self.label}

    def state(self):
        """See `Callback`."""
        return {name: np.where(np.isnan(one), -1, one).tolist() for name, one in self._maps.items()}

    def restoreState(self, state):
        """See `Callback`."""
        shape = self._terrain.heights.shape
        for name in NAMES:
            one = np.array(state[name], float)
            if one.shape != shape:
                raise ValueError(
                    f"TerrainMaps: the map {name} of a checkpoint has the shape {one.shape}, not {shape}"
                )
            self._maps[name] = np.where(one < 0, np.nan, one)


class _Spread:
    """Shares of boxes, seen from above, in the cells round the heights of a raster."""

    def __init__(self, terrain, centres, half):
        self._shape = terrain.heights.shape
        along = [
            _overlaps(
                (centres[:, k] - terrain.origin[k]) / terrain.spacing[k], half[:, k] / terrain.spacing[k], n
            )
            for k, n in enumerate(self._shape)
        ]
        self._cells, self._shares = along[0]
        if len(along) == 2:
            (first, share), (second, across) = along
            self._cells = (first[:, :, None] * self._shape[1] + second[:, None, :]).reshape(len(first), -1)
            self._shares = (share[:, :, None] * across[:, None, :]).reshape(len(first), -1)

    def sum(self, values):
        flat = np.bincount(
            self._cells.ravel(), (self._shares * values[:, None]).ravel(), np.prod(self._shape)
        )
        return flat.reshape(self._shape)


def _overlaps(x, half, count):
    """Cells along an axis that intervals x +- half reach into, and their shares; those beyond the ends count
    in the cells there."""
    half = np.maximum(half, 1e-9)
    first = np.floor(x - half + 0.5).astype(int)
    cells = first[:, None] + np.arange(int(np.ceil(2 * half.max())) + 1 if len(half) else 1)
    lower, upper = np.maximum(cells - 0.5, (x - half)[:, None]), np.minimum(cells + 0.5, (x + half)[:, None])
    return np.clip(cells, 0, count - 1), np.maximum(upper - lower, 0) / (2 * half[:, None])
