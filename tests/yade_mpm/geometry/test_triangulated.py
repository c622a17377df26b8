# SPDX-License-Identifier: GPL-2.0-or-later
"""Solids of STL and OBJ files as regions, and their triangles as rigid bodies."""

import sys

import numpy as np
import pytest
import yade_mpm as mpm
from yade_mpm.geometry.regions import regionFromSpec

CORNERS = np.array([(x, y, z) for x in (1, 3) for y in (1, 4) for z in (1, 2)], float)
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = mpm.box((1, 1, 1), (3, 4, 2))


def written(file, points, faces, scale=1.0):
    """A file of triangles or quadrilaterals; of STL every triangle has corners of its own."""
    points = np.asarray(points) * scale
    if file.suffix == ".obj":
        rows = [f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points]
        rows += ["f " + " ".join(f"{corner + 1}" for corner in face) + "\n" for face in faces]
        file.write_text("".join(rows))
    else:
        rows = ["solid s\n"]
        for corners in halved(faces):
            vertices = "".join("vertex {:.9g} {:.9g} {:.9g}\n".format(*points[c]) for c in corners)
            rows.append(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        file.write_text("".join([*rows, "endsolid s\n"]))
    return file


def halved(faces):
    return [part for f in faces for part in ((f[0], f[1], f[2]), (f[0], f[2], f[-1]))[: len(f) - 2]]


def places(spacing=0.25):
    """Also on the faces of the cube."""
    x = np.arange(0.5, 4.6, spacing)
    return np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("ending", ["stl", "obj"])
def test_a_solid_of_a_file_is_the_region_inside_of_it(ending, tmp_path):
    pytest.importorskip("vtk")
    solid = mpm.solidFromFile(written(tmp_path / f"cube.{ending}", CORNERS, FACES, 1000), unit=0.001)
    for closed in (True, False):  # the faces belong to it as those of a box do
        assert (solid.contains(places(), closed) == CUBE.contains(places(), closed)).all()
    assert (solid.contains(places(0.3), False)).any()
    assert solid.bounds()[0] == pytest.approx([1, 1, 1]) and solid.bounds()[1] == pytest.approx([3, 4, 2])
    assert repr(solid) == "solid(12 triangles, 2 x 3 x 1 m, from (1, 1, 1))"


def test_the_direction_of_triangles_does_not_matter_and_a_hole_inside_is_empty(tmp_path):
    pytest.importorskip("vtk")
    faces = [face[::-1] if k % 2 else face for k, face in enumerate(FACES)]
    middle = CORNERS.mean(axis=0)
    inner = middle + 0.25 * (CORNERS - middle)
    faces += [tuple(c + 8 for c in face) for face in FACES]
    solid = mpm.solidFromFile(written(tmp_path / "hollow.obj", [*CORNERS, *inner], faces))
    hole = mpm.box(inner[0], inner[-1])
    asked = places(0.125) + 0.01
    assert (solid.contains(asked, False) == (CUBE - hole).contains(asked, False)).all()


def test_a_solid_fills_a_body_and_a_checkpoint_keeps_it(tmp_path):
    pytest.importorskip("vtk")
    solid = mpm.solidFromFile(written(tmp_path / "cube.stl", CORNERS, FACES))
    rock = mpm.LinearElastic(density=2, young=1e4, poisson=0.3)
    scene = mpm.Scene((0, 0, 0), (4, 5, 3), 0.5, gravity=9.81)
    scene.fix("bottom")
    assert scene.add("rock", solid, rock, mpm.UGIMP()).volume.sum() == pytest.approx(6)
    again = regionFromSpec(solid.spec())
    assert again == solid and (again.contains(places()) == solid.contains(places())).all()
    scene.save(tmp_path / "a.h5")
    assert mpm.load(tmp_path / "a.h5")["rock"].region == solid


def test_a_surface_with_a_gap_is_refused(tmp_path):
    file = written(tmp_path / "open.stl", CORNERS, FACES[:-1])
    with pytest.raises(ValueError, match=r"not closed: at 4 of 17 edges, one at .*; close it"):
        mpm.solidFromFile(file)
    assert len(mpm.rigid.facetsFromFile(file)) == 10  # a rigid body may be open


def test_the_error_of_a_solid_in_another_unit_says_so(tmp_path):
    pytest.importorskip("vtk")
    rock = mpm.LinearElastic(density=2, young=1e4, poisson=0.3)
    for scale, told in ((1000, "outside the grid: it spans"), (0.001, "empty body")):
        solid = mpm.solidFromFile(written(tmp_path / "cube.obj", CORNERS, FACES, scale))
        with pytest.raises(ValueError, match=rf"{told}.*give the unit of its file, e.g. .*unit=0.001"):
            mpm.Scene((0, 0, 0), (4, 5, 3), 0.5).add("rock", solid, rock, mpm.UGIMP())


def test_other_files_and_no_vtk_are_refused_with_what_to_do(tmp_path, monkeypatch):
    (tmp_path / "bad.stl").write_text("hello\n")
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\n")
    (tmp_path / "wrong.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n")
    with pytest.raises(
        FileNotFoundError, match="solidFromFile: there is no file .*; give the name of an STL"
    ):
        mpm.solidFromFile(tmp_path / "none.stl")
    for name, told in (
        ("bad.stl", "no mesh of triangles|no triangles"),
        ("points.obj", "has no triangles in space; give STL or OBJ"),
        ("wrong.obj", "triangle 0 names corner 6 of 3 points"),
    ):
        with pytest.raises(ValueError, match=told):
            mpm.solidFromFile(tmp_path / name)
    solid = mpm.solidFromFile(written(tmp_path / "cube.stl", CORNERS, FACES))
    monkeypatch.setitem(sys.modules, "vtk", None)
    with pytest.raises(ImportError, match="takes VTK, .*; install it .Debian: python3-vtk9, else pip"):
        solid.contains([(2, 2, 1.5)])


def test_the_triangles_of_a_file_are_a_rigid_body(tmp_path):
    file = written(tmp_path / "cube.obj", CORNERS, FACES, 1000)
    scene = mpm.Scene((0, 0, 0), (4, 5, 4), 0.5, gravity=9.81)
    contact = mpm.RigidContact()
    contact.addBody(mpm.rigid.facetsFromFile(file, unit=0.001), friction=0.3)
    scene.engines.insert(1, contact)
    rock = mpm.LinearElastic(density=2, young=1e4, poisson=0.2)
    scene.add("slab", mpm.box((1, 1, 2), (3, 4, 2.5)), rock, mpm.UGIMP())
    scene.run(until=0.02)  # it falls by 2 mm
    start = contact.forces[0, 2]
    scene.run(until=0.2)
    pushed = -contact.takeImpulses()[0][0, 2]
    momentum = (scene["slab"].mass * scene["slab"].velocity[:, 2]).sum()
    weight = 2 * 9.81 * 3
    assert start < 0 and pushed == pytest.approx(weight * 0.2 + momentum, rel=1e-6)
    assert scene["slab"].position[:, 2].min() > 2.1


NORMALS = "# drawn\nmtllib a.mtl\no rock\nvn 0 0 1\nvt 0 0\ns off\n"


@pytest.mark.parametrize("corner", ["{0}/1/1", "{0}//1", "{0}/1", "{1}"])
def test_an_obj_file_may_have_normals_textures_and_faces_of_many_corners(corner, tmp_path):
    """A prism on a hexagon of the area 1.5 sqrt(3)."""
    pytest.importorskip("vtk")
    angles = np.arange(6) * np.pi / 3
    points = [(np.cos(a), np.sin(a), z) for z in (0, 1) for a in angles]
    faces = [range(5, -1, -1), range(6, 12), *((k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6) for k in range(6))]
    rows = [f"v {x:.9g} {y:.9g} {z}\n" for x, y, z in points]
    rows += ["f " + " ".join(corner.format(c + 1, c - 12) for c in face) + "\n" for face in faces]
    file = tmp_path / "prism.OBJ"
    file.write_text(NORMALS + "".join(rows))
    facets = mpm.rigid.facetsFromFile(file)
    area = sum(
        np.linalg.norm(np.cross(f.vertices[1] - f.vertices[0], f.vertices[2] - f.vertices[0])) / 2
        for f in facets
    )
    assert len(facets) == 20 and area == pytest.approx(3 * 3**0.5 + 6)
    assert mpm.solidFromFile(file).contains([[0.0, 0.8, 0.5], [0.9, 0.4, 0.5]]).tolist() == [True, False]


@pytest.mark.parametrize(
    "words", ["v nan 1 1", "v 1 one 1", "v 1 2", "f 1 2 99999999999999999999", "f 1 2 x"]
)
def test_an_obj_file_with_other_words_is_refused(words, tmp_path):
    file = written(tmp_path / "cube.obj", CORNERS, FACES)
    file.write_text(f"{words}\n" + file.read_text())
    with pytest.raises(ValueError, match="facetsFromFile: .*cube.obj"):
        mpm.rigid.facetsFromFile(file)
