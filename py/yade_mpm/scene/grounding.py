# SPDX-License-Identifier: GPL-2.0-or-later
"""Terrain under a scene: rigid ground by heights on a raster, and maps of what flows over it."""

from __future__ import annotations

import numpy as np

from ..base.kinds import NUMBER, POSITIVE, takes
from ..engine.rigidContact import RigidContact
from ..geometry.terrain import Terrain
from ..io.maps import TERRAIN, TerrainMaps
from ..rigid.shapes import HeightField
from .running import refuseDuringStep

REACHED = 0.1  # of a cell: depth from which on the flow has arrived


@takes(terrain=TERRAIN, friction=NUMBER, adhesion=NUMBER)
def terrain(scene, terrain: Terrain, friction: float = 0.0, adhesion: float = 0.0) -> RigidContact:
    """Puts rigid ground under the scene; soil rests and slides on it.

        ground = mpm.readTerrain("valley.tif")
        scene.add("slide", ground.layer(depth), soil)
        scene.terrain(ground, friction=0.4)

    Parameters
    ----------
    terrain : Terrain, as of `heightField` or `readTerrain`; its raster reaches over all of the scene.
    friction : coefficient of the surface, -; default 0.
    adhesion : kPa; default 0.

    Returns the `RigidContact`, which has the forces on the ground. ValueError for a second terrain, a raster
    that ends within the scene or has other axes; RuntimeError after the first run.
    """
    refuseDuringStep(scene, "terrain")
    _checkReach(scene, terrain)
    engine = next((e for e in scene.engines if type(e) is RigidContact), None)
    isNew = engine is None
    if not isNew and len(engine._core.value("heights")):
        raise ValueError(
            "terrain: the scene has a terrain already; give one, e.g. mpm.heightField(np.maximum(a, b), ...)"
        )
    engine = RigidContact() if isNew else engine
    shape = HeightField(terrain.heights, terrain.spacing, terrain.origin)
    engine.addBody(shape, friction=friction, adhesion=adhesion)
    if isNew:
        scene.engines.insert(scene.engines.index(scene._gridSolver("terrain")), engine)
    scene._asked.add(engine)
    scene.stepper.noteChange()
    return engine


@takes(terrain=TERRAIN, every=POSITIVE, least=NUMBER)
def maps(scene, terrain: Terrain, every: float, least: float | None = None) -> TerrainMaps:
    """Keeps maps of the flow over a terrain: depth, greatest depth and velocity, arrival.

    Parameters
    ----------
    terrain : Terrain, whose raster the maps have.
    every : s, scene time between two looks.
    least : m, depth from which on a place counts as reached; default: a tenth of the height of a cell.

    Returns the `TerrainMaps`.
    """
    refuseDuringStep(scene, "maps")
    _checkAxes(scene, terrain, "maps")
    engine = TerrainMaps(terrain, every, REACHED * scene.cell[-1] if least is None else least)
    scene.engines.append(engine)
    scene.stepper.noteChange()
    return engine


def _checkAxes(scene, terrain, who):
    if terrain.dim != scene.dim:
        raise ValueError(
            f"{who}: the terrain has {terrain.heights.ndim} axes in plan, the scene is {scene.dim}D; give "
            + ("an array (columns, rows)" if scene.dim == 3 else "a profile (columns,)")
        )


def _checkReach(scene, terrain):
    _checkAxes(scene, terrain, "terrain")
    slack = 1e-6 * scene.cell[:-1]
    if (terrain.origin > scene.lower[:-1] + slack).any() or (terrain.upper < scene.upper[:-1] - slack).any():
        raise ValueError(
            f"terrain: the raster goes from {tuple(np.round(terrain.origin, 6).tolist())} to "
            f"{tuple(np.round(terrain.upper, 6).tolist())} m in plan, the scene from "
            f"{tuple(scene.lower[:-1].tolist())} to {tuple(scene.upper[:-1].tolist())}; make the scene "
            "smaller, or give a raster that reaches over all of it"
        )
