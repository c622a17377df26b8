# SPDX-License-Identifier: GPL-2.0-or-later
"""Polygons of a plan or a section as regions: GeoJSON, DXF."""

from __future__ import annotations

import json
import os

from ..base.kinds import FILE, POSITIVE, requireFile, takes
from ..base.wording import shown
from .region import Region
from .regions import polygon

RINGS = {"Polygon": lambda given: [given], "MultiPolygon": list}


@takes(file=FILE, sag=POSITIVE)
def polygonsFromFile(file: str | os.PathLike, sag: float = 0.01) -> dict[str, Region]:
    """The polygons of a file as regions, by name.

        for name, region in mpm.polygonsFromFile("section.dxf").items():
            scene.add(name, region, laws[name])

    Parameters
    ----------
    file : a name that ends in .geojson or .json (GeoJSON: polygons with their holes, by the property "name"),
        or in .dxf (closed polylines, by layer; it takes ezdxf).
    sag : m, of arcs of a DXF file above the straight sides that take their place; default 0.01.

    Returns a dict name -> region, in the order of the file; what has one name is one region. Coordinates are
    those of the file, in m. Raises ImportError where ezdxf is missing, ValueError for a file without
    polygons, or a polygon that crosses itself.
    """
    name = os.fspath(file)
    ending = os.path.splitext(name)[1].lower()
    if ending not in (".geojson", ".json", ".dxf"):
        raise ValueError(f"polygonsFromFile: {shown(name)} is neither GeoJSON nor DXF; give one of these")
    regions = {}
    for key, rings in _polylines(name, sag) if ending == ".dxf" else _features(name):
        try:
            region, *holes = (polygon(_distinct(ring)) for ring in rings)
            for hole in holes:
                region = region - hole
        except (ValueError, TypeError, IndexError) as error:
            raise ValueError(f"polygonsFromFile: '{key}' of {shown(name)}: {error}") from None
        regions[key] = regions[key] | region if key in regions else region
    if not regions:
        what = "closed polylines" if ending == ".dxf" else "polygons"
        raise ValueError(f"polygonsFromFile: {shown(name)} has no {what}; give a file with some")
    return regions


def _distinct(ring):
    """The corners of a ring, those once that a file has several times in a row."""
    return [corner for corner, before in zip(ring, [None, *ring]) if corner != before]


def _features(file):
    """(name, rings) of each polygon of a GeoJSON file, the outer ring first."""
    with open(requireFile("polygonsFromFile", file), encoding="utf-8") as opened:
        try:
            top = json.load(opened)
        except ValueError as error:
            raise ValueError(f"polygonsFromFile: {shown(file)} is no GeoJSON: {error}") from None
    features = top.get("features", [top]) if isinstance(top, dict) else []
    for number, feature in enumerate(features, 1):
        shape = feature.get("geometry") or feature
        given = feature.get("properties") or {}
        name = str(given.get("name", given.get("id", f"polygon {number}")))
        for rings in RINGS.get(shape.get("type"), lambda given: [])(shape.get("coordinates")):
            yield name, [[corner[:2] for corner in ring] for ring in rings]


def _polylines(file, sag):
    """(layer, [corners]) of each closed polyline of a DXF file."""
    try:
        import ezdxf
        from ezdxf.path import make_path
    except ImportError:
        raise ImportError(
            f"polygonsFromFile: {shown(file)} takes ezdxf; install it (Debian: python3-ezdxf), "
            "or give GeoJSON"
        ) from None
    try:
        drawing = ezdxf.readfile(requireFile("polygonsFromFile", file))
    except ezdxf.DXFError as error:
        raise ValueError(f"polygonsFromFile: {shown(file)} is no DXF: {error}") from None
    for entity in drawing.modelspace().query("LWPOLYLINE POLYLINE"):
        if entity.is_closed:
            corners = [(p.x, p.y) for p in make_path(entity).flattening(sag)]
            yield entity.dxf.layer, [corners[:-1] if corners[0] == corners[-1] else corners]
