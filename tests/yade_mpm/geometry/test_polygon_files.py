# SPDX-License-Identifier: GPL-2.0-or-later
"""Polygons of GeoJSON and DXF files as regions."""

import json
import sys

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import cases, refused

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
HOLE = [[1, 1], [2, 1], [2, 2], [1, 2], [1, 1]]


def feature(name, kind, coordinates):
    return {
        "type": "Feature",
        "properties": {"name": name} if name else None,
        "geometry": {"type": kind, "coordinates": coordinates},
    }


def written(folder, *features, name="plan.geojson"):
    file = folder / name
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return file


def test_polygons_of_geojson_are_regions_with_holes(tmp_path):
    far = [[[x + 10, y, 7.0] for x, y in SQUARE]]
    file = written(
        tmp_path,
        feature("clay", "Polygon", [SQUARE, HOLE]),
        feature(None, "MultiPolygon", [far]),
        feature("point", "Point", [1, 1]),
        feature("clay", "Polygon", [[[x, y + 4] for x, y in SQUARE]]),
    )
    found = mpm.polygonsFromFile(file)
    assert list(found) == ["clay", "polygon 2"]
    points = np.array([(3, 3), (1.5, 1.5), (3, 6), (12, 2)])
    assert found["clay"].contains(points).tolist() == [True, False, True, False]
    assert found["polygon 2"].contains(points).tolist() == [False, False, False, True]
    scene = mpm.Scene((0, 0), (16, 8), 0.5)
    body = scene.add("clay", found["clay"], mpm.LinearElastic(density=2, young=1e4, poisson=0.3), mpm.UGIMP())
    assert body.volume.sum() == pytest.approx(31)


def test_corners_that_a_file_repeats_count_once(tmp_path):
    twice = [corner for corner in SQUARE for _ in range(2)]
    found = mpm.polygonsFromFile(written(tmp_path, feature("clay", "Polygon", [twice, HOLE])))
    assert repr(found["clay"]) == repr(mpm.polygon(SQUARE) - mpm.polygon(HOLE))


def test_a_geometry_alone_is_a_polygon(tmp_path):
    file = tmp_path / "one.json"
    file.write_text(json.dumps({"type": "Polygon", "coordinates": [SQUARE]}))
    assert list(mpm.polygonsFromFile(file)) == ["polygon 1"]


def test_closed_polylines_of_dxf_are_regions_by_layer(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new()
    space = drawing.modelspace()
    space.add_lwpolyline(SQUARE[:-1], close=True, dxfattribs={"layer": "clay"})
    space.add_lwpolyline([(5, 0), (6, 0), (6, 1)], dxfattribs={"layer": "open"})
    # Two arcs: a disc of radius 1 about (10, 1).
    space.add_lwpolyline([(9, 1, 1.0), (11, 1, 1.0)], format="xyb", close=True, dxfattribs={"layer": "pile"})
    drawing.saveas(tmp_path / "plan.dxf")
    found = mpm.polygonsFromFile(tmp_path / "plan.dxf", sag=1e-3)
    assert list(found) == ["clay", "pile"]
    inside = found["pile"].contains([(10, 1.99), (10, 2.01), (9.3, 1.65), (9.2, 1.7)])
    assert inside.tolist() == [True, False, True, False]


def test_without_ezdxf_the_error_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(ImportError, match="install it .Debian: python3-ezdxf., or give GeoJSON"):
        mpm.polygonsFromFile(tmp_path / "plan.dxf")


def crossing(folder):
    return written(folder, feature("clay", "Polygon", [[[0, 0], [1, 1], [1, 0], [0, 1]]]))


def broken(folder):
    (folder / "a.json").write_text("{")
    return folder / "a.json"


@cases(
    ("is neither GeoJSON nor DXF", lambda folder: folder / "plan.shp"),
    ("has no polygons", lambda folder: written(folder, feature("a", "Point", [1, 1]))),
    ("'clay' of ... polygon: ", crossing),
    ("is no GeoJSON", broken),
)
def test_what_is_refused(named, make, kind, tmp_path):
    refused(named, lambda: mpm.polygonsFromFile(make(tmp_path)), kind)
