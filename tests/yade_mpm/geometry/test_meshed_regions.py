# SPDX-License-Identifier: GPL-2.0-or-later
"""Meshes that Gmsh makes of regions."""

import sys

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.geometry.mesh import boundaryFacets, cellVolumes

SLOPE = mpm.polygon([(0, 0), (12, 0), (12, 3), (7, 3), (3, 5), (0, 5)])
FOOT = mpm.polygon([(7, 3), (12, 3), (12, 4), (9, 4)])


def gmsh():
    return pytest.importorskip("gmsh", reason="no gmsh here; Debian: python3-gmsh")


def sizeOf(mesh):
    return float(cellVolumes(mesh.points, mesh.cells).sum())


def test_regions_are_meshed_with_vertices_in_common():
    gmsh()
    made = mpm.meshesFromRegions({"slope": SLOPE, "foot": FOOT}, size=0.5)
    assert sizeOf(made["slope"]) == pytest.approx(46) and sizeOf(made["foot"]) == pytest.approx(4)
    edges = np.sqrt(cellVolumes(made["slope"].points, made["slope"].cells))
    assert edges.min() > 0.25 and 0.35 < edges.mean() < 0.6 and edges.max() < 0.75
    common = [
        {tuple(p) for p in mesh.points[np.unique(boundaryFacets(mesh)[0])].round(9) if abs(p[1] - 3) < 1e-9}
        for mesh in made.values()
    ]
    assert common[0] == common[1] and len(common[0]) > 9


def test_composed_regions_and_discs_are_meshed():
    gmsh()
    ring = mpm.disc((2, 2), 1.5) - mpm.disc((2, 2), 0.5)
    half = (mpm.box((4, 0), (6, 1)) + mpm.box((4, 1), (5, 2))) & mpm.box((4, 0), (5, 2))
    made = mpm.meshesFromRegions({"ring": ring, "half": half}, size=0.2)
    assert sizeOf(made["ring"]) == pytest.approx(2 * np.pi, rel=0.01)
    assert sizeOf(made["half"]) == pytest.approx(2)


def test_a_section_that_is_drawn_along_an_axis_is_a_mesh_of_hexahedra():
    gmsh()
    mesh = mpm.meshesFromRegions({"slope": SLOPE}, size=1.0, start=-1, end=2, axis="y")["slope"]
    assert mesh.dim == 3 and sizeOf(mesh) == pytest.approx(46 * 3)
    assert mesh.points.min(axis=0) == pytest.approx([0, -1, 0])
    assert mesh.points.max(axis=0) == pytest.approx([12, 2, 5])


def test_a_slope_of_two_meshes_rests():
    gmsh()
    scene = mpm.Scene((0, 0), (12, 6), 0.5, gravity=9.81)
    scene.fix("bottom")
    scene.roller("left", "right")
    rock = mpm.LinearElastic(density=2, young=1e4, poisson=0.3)
    for name, mesh in mpm.meshesFromRegions({"slope": SLOPE, "foot": FOOT}, size=0.5).items():
        scene.add(name, mesh, rock, mpm.APDI())
    scene.settle()
    moment = sum(9.81 * float(body.mass @ body.position[:, 1]) for body in scene.bodies)
    held = -sum(float(body.volume @ body.stress[:, 1, 1]) for body in scene.bodies)
    assert held == pytest.approx(moment, rel=0.01)  # the integrals of stress and of weight times height


def test_what_cannot_be_meshed_is_refused():
    gmsh()
    with pytest.raises(ValueError, match=r"'slope' and 'box' overlap at \(1, 1\); subtract one"):
        mpm.meshesFromRegions({"slope": SLOPE, "box": mpm.box((0.5, 0.5), (1.5, 1.5))}, size=0.5)
    with pytest.raises(ValueError, match="'none': .* is empty; give another"):
        mpm.meshesFromRegions({"none": mpm.box((0, 0), (1, 1)) & mpm.box((2, 2), (3, 3))}, size=0.5)
    with pytest.raises(TypeError, match="'cube': .* has no mesh; give boxes, discs and polygons in 2D"):
        mpm.meshesFromRegions({"cube": mpm.box((0, 0, 0), (1, 1, 1))}, size=0.5)


def test_without_gmsh_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(ImportError, match="takes gmsh, .*Debian: python3-gmsh, else pip install gmsh"):
        mpm.meshesFromRegions({"slope": SLOPE}, size=0.5)
    with pytest.raises(ValueError, match="start = 1, end = None are not allowed; give both"):
        mpm.meshesFromRegions({"slope": SLOPE}, size=0.5, start=1)


def test_a_session_of_gmsh_goes_on():
    session = gmsh()
    session.initialize([], False)
    try:
        session.model.add("own")
        mpm.meshesFromRegions({"slope": SLOPE}, size=1.0)
        assert session.model.list()[-1] == session.model.getCurrent() == "own"
    finally:
        session.finalize()
