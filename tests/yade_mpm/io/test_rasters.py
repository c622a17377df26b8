# SPDX-License-Identifier: GPL-2.0-or-later
"""Rasters in files: heights in, maps out."""

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.io.rasters import writeRaster


def hill(count=(7, 5), spacing=2.0):
    x, y = (np.arange(n) * spacing for n in count)
    return mpm.heightField(100 + 0.3 * x[:, None] - 0.2 * y[None, :] ** 1.5, spacing, origin=(600.0, 5000.0))


@pytest.mark.parametrize("ending", ["asc", "tif"])
def test_a_raster_comes_back_as_it_was_written(ending, tmp_path):
    if ending == "tif":
        pytest.importorskip("rasterio")
    ground, file = hill(), tmp_path / f"hill.{ending}"
    writeRaster(file, ground, ground.heights)
    back = mpm.readTerrain(file)
    assert np.abs(back.heights - ground.heights).max() < 1e-5
    assert back.origin == pytest.approx(ground.origin) and back.spacing == pytest.approx([2, 2])
    part = mpm.readTerrain(file, lower=(606, 5002), upper=(608, 5004))
    assert part.heights.shape == (6, 5) and part.origin == pytest.approx([602, 5000])
    assert np.abs(part.heights - ground.heights[1:]).max() < 1e-5


def test_an_ascii_grid_runs_from_north_to_south(tmp_path):
    file = tmp_path / "map.asc"
    file.write_text(
        "ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9\n1 2 3\n4 5 6\n"
    )
    ground = mpm.readTerrain(file)
    assert ground.heights.tolist() == [[4, 1], [5, 2], [6, 3]] and ground.origin.tolist() == [11, 21]


def test_triangles_become_a_raster(tmp_path):
    file = tmp_path / "plane.obj"
    corners = [(x, y, 5 + 0.5 * x - 0.25 * y) for x, y in ((0, 0), (8, 0), (8, 6), (0, 6))]
    file.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 3\nf 1 3 4\n")
    ground = mpm.readTerrain(file, spacing=2.0)
    x, y = np.meshgrid(np.arange(5) * 2.0, np.arange(4) * 2.0, indexing="ij")
    assert np.abs(ground.heights - (5 + 0.5 * x - 0.25 * y)).max() < 1e-9


def test_files_that_are_no_terrain_are_refused(tmp_path):
    gaps, bad, plain = tmp_path / "gaps.asc", tmp_path / "bad.asc", tmp_path / "flat.asc"
    gaps.write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9\n1 2\n-9 4\n")
    bad.write_text("ncols 2\nnrows 2\n1 2 3\n")
    plain.write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n")
    with pytest.raises(ValueError, match="has no data at 1 of 4 places; fill the gaps"):
        mpm.readTerrain(gaps)
    with pytest.raises(ValueError, match="is no ASCII grid; give ncols"):
        mpm.readTerrain(bad)
    with pytest.raises(ValueError, match="the raster has its own, leave it out"):
        mpm.readTerrain(plain, spacing=1.0)
    with pytest.raises(ValueError, match="leave nothing of it"):
        mpm.readTerrain(plain, lower=(50, 50))
    with pytest.raises(ValueError, match="give the spacing of the raster to make"):
        mpm.readTerrain(tmp_path / "x.stl")
    with pytest.raises(ValueError, match=r"ends in .tif or .asc"):
        writeRaster(tmp_path / "x.png", hill(), hill().heights)


def test_without_rasterio_the_error_says_what_to_install(monkeypatch, tmp_path):
    import sys

    monkeypatch.setitem(sys.modules, "rasterio", None)
    with pytest.raises(ImportError, match="install it .Debian: python3-rasterio., or use an ASCII grid"):
        mpm.readTerrain(tmp_path / "x.tif")
