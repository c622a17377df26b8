# SPDX-License-Identifier: GPL-2.0-or-later
"""Rasters of heights and of results: GeoTIFF, ASCII grids, surfaces of triangles."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike

from ..base.kinds import FILE, NUMBERS, POSITIVE, requireFile, takes
from ..base.wording import shown
from ..geometry.terrain import Terrain
from ..geometry.triangleFiles import readTriangles

NODATA = -9999.0
MARGIN = 2  # heights that a part of a raster has beyond its corners


@takes(file=FILE, lower=NUMBERS, upper=NUMBERS, spacing=POSITIVE, unit=POSITIVE)
def readTerrain(
    file: str | os.PathLike,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
    spacing: float | None = None,
    unit: float = 1.0,
) -> Terrain:
    """Reads the heights of the ground.

        ground = mpm.readTerrain("valley.tif", lower=(650200, 5180100), upper=(651000, 5180700))

    Parameters
    ----------
    file : a name that ends in .tif or .tiff (GeoTIFF; it takes rasterio), .asc (ASCII grid), or the name of
        a mesh of triangles (STL, OBJ and what else meshio reads), each place of which has one height.
    lower, upper : (2,), m, corners in plan of the part that is wanted; default: all.
    spacing : m, between heights that are taken from triangles; needed for them, and for them alone.
    unit : m, length of one unit of a file of triangles; default 1.

    Returns the `Terrain`; coordinates are those of the file, in m. Raises ImportError where rasterio is
    missing, ValueError for gaps (no data) in the part that is wanted, a raster that is turned, or a file
    that is no raster.
    """
    kind = os.path.splitext(os.fspath(file))[1].lower()
    isRaster = kind in (".tif", ".tiff", ".asc")
    if isRaster != (spacing is None):
        raise ValueError(
            f"readTerrain: spacing = {shown(spacing)}; "
            + (
                "the raster has its own, leave it out"
                if isRaster
                else "give the spacing of the raster to make, in m"
            )
        )
    reference = None
    if kind == ".asc":
        heights, step, origin = _readAscii(file)
    elif isRaster:
        heights, step, origin, reference = _readTiff(file)
    else:
        heights, step, origin = _fromTriangles(file, spacing, unit)
    heights, origin = _part(file, heights, step, origin, lower, upper)
    lost = int(np.isnan(heights).sum())
    if lost:
        raise ValueError(
            f"readTerrain: '{file}' has no data at {lost} of {heights.size} places; fill the gaps first, "
            "or give lower "
            "and upper of a part without any"
        )
    return Terrain(heights, step, origin, reference)


def writeRaster(file: str | os.PathLike, terrain: Terrain, values: ArrayLike) -> None:
    """Writes numbers on the raster of a terrain, for a map.

    Parameters
    ----------
    file : a name that ends in .tif (GeoTIFF; it takes rasterio) or .asc (ASCII grid).
    terrain : Terrain, in 3D.
    values : (columns, rows), as its heights; nan where there is none.

    Raises ImportError where rasterio is missing, ValueError for another ending or shape.
    """
    values = np.asarray(values, float)
    if values.shape != terrain.heights.shape or values.ndim != 2:
        raise ValueError(
            f"writeRaster: values have the shape {values.shape}; give (columns, rows) of a raster in 3D, "
            f"{terrain.heights.shape}"
        )
    rows = np.where(np.isfinite(values), values, NODATA).T[::-1]  # from north to south
    west, south = (terrain.origin - terrain.spacing / 2).tolist()
    kind = os.path.splitext(os.fspath(file))[1].lower()
    if kind == ".asc":
        if terrain.spacing[0] != terrain.spacing[1]:
            raise ValueError("writeRaster: an ASCII grid has one spacing; write a .tif")
        head = f"ncols {rows.shape[1]}\nnrows {rows.shape[0]}\nxllcorner {west!r}\nyllcorner {south!r}\n"
        head += f"cellsize {float(terrain.spacing[0])!r}\nNODATA_value {NODATA:g}"
        np.savetxt(file, rows, fmt="%.8g", header=head, comments="")
    elif kind in (".tif", ".tiff"):
        rasterio = _rasterio("writeRaster")
        north = south + terrain.spacing[1] * rows.shape[0]
        shape = {"height": rows.shape[0], "width": rows.shape[1], "count": 1, "dtype": "float64"}
        place = rasterio.transform.from_origin(west, north, *terrain.spacing)
        with rasterio.open(
            file, "w", driver="GTiff", transform=place, crs=terrain.reference, nodata=NODATA, **shape
        ) as opened:
            opened.write(rows, 1)
    else:
        raise ValueError(f"writeRaster: file = {shown(str(file))}; give a name that ends in .tif or .asc")


def _rasterio(who):
    try:
        import rasterio
        import rasterio.transform
    except ImportError:
        raise ImportError(
            f"{who}: a GeoTIFF takes rasterio, which is not installed; install it (Debian: "
            "python3-rasterio), or "
            "use an ASCII grid (.asc)"
        ) from None
    return rasterio


def _readTiff(file):
    rasterio = _rasterio("readTerrain")
    try:
        with rasterio.open(requireFile("readTerrain", file)) as opened:
            place, rows = opened.transform, opened.read(1, masked=True).filled(np.nan) * 1.0
            reference = None if opened.crs is None else opened.crs.to_wkt()
    except rasterio.errors.RasterioError as error:
        raise ValueError(f"readTerrain: {shown(str(file))} is no GeoTIFF: {error}") from None
    if place.b or place.d or place.a <= 0 or place.e >= 0:
        raise ValueError(f"readTerrain: '{file}' is turned against north; warp it first (gdalwarp)")
    step = np.array([place.a, -place.e])
    origin = np.array([place.c + place.a / 2, place.f + place.e * (rows.shape[0] - 0.5)])
    return rows[::-1].T.astype(float), step, origin, reference


def _readAscii(file):
    head, name = {}, requireFile("readTerrain", file)
    try:
        with open(name) as opened:
            lines = opened.read().splitlines()
        while lines and lines[0].split() and not _isNumber(lines[0].split()[0]):
            name, value = lines.pop(0).split()
            head[name.lower()] = float(value)
        rows = np.array(" ".join(lines).split(), float).reshape(int(head["nrows"]), int(head["ncols"]))
        step = np.full(2, head["cellsize"])
        corner = [
            head[f"{k}llcorner"] + step[0] / 2 if f"{k}llcorner" in head else head[f"{k}llcenter"]
            for k in "xy"
        ]
    except (KeyError, ValueError, UnicodeDecodeError):
        raise ValueError(
            f"readTerrain: {shown(str(file))} is no ASCII grid; give ncols, nrows, xllcorner, yllcorner, "
            "cellsize, and "
            "as many heights"
        ) from None
    rows[rows == head.get("nodata_value", NODATA)] = np.nan
    return rows[::-1].T, step, np.array(corner)


def _isNumber(word):
    try:
        float(word)
    except ValueError:
        return False
    return True


def _fromTriangles(file, spacing, unit):
    from matplotlib.tri import LinearTriInterpolator, Triangulation

    points, triangles = readTriangles("readTerrain", file, unit)
    sides = points[triangles][:, 1:] - points[triangles][:, :1]
    flat = (
        np.abs(np.cross(sides[:, 0, :2], sides[:, 1, :2])) > 1e-12 * np.ptp(points[:, :2], axis=0).max() ** 2
    )
    first, last = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    count = np.floor((last - first) / spacing + 1e-9).astype(int) + 1
    x, y = np.meshgrid(*(first[k] + np.arange(count[k]) * spacing for k in (0, 1)), indexing="ij")
    try:
        surface = Triangulation(*points[:, :2].T, triangles[flat])
        heights = LinearTriInterpolator(surface, points[:, 2])(x, y).filled(np.nan)
    except (ValueError, RuntimeError) as error:
        raise ValueError(
            f"readTerrain: the triangles of {shown(str(file))} have more than one height at a place: {error}"
        ) from None
    return heights, np.full(2, float(spacing)), first


def _part(file, heights, step, origin, lower, upper):
    """Heights between two corners with a margin around them, and the origin of these."""
    first, last = np.zeros(2, int), np.array(heights.shape) - 1
    if lower is not None:
        first = np.clip(np.floor((np.asarray(lower) - origin) / step).astype(int) - MARGIN, 0, last)
    if upper is not None:
        last = np.clip(np.ceil((np.asarray(upper) - origin) / step).astype(int) + MARGIN, 0, last)
    if (last - first < 1).any():
        raise ValueError(
            f"readTerrain: '{file}' spans {shown(tuple(origin))} to "
            f"{shown(tuple(origin + (np.array(heights.shape) - 1) * step))} m; lower = {shown(lower)} and "
            "upper = "
            f"{shown(upper)} leave nothing of it"
        )
    return heights[first[0] : last[0] + 1, first[1] : last[1] + 1], origin + first * step
