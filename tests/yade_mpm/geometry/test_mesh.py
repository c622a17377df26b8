# SPDX-License-Identifier: GPL-2.0-or-later
import numpy as np
import pytest
import yade_mpm as mpm
from inputs import refused
from yade_mpm.geometry.lattice import latticePoints
from yade_mpm.geometry.mesh import boundaryFacets, cellVolumes, cornerJacobians
from yade_mpm.geometry.meshing import meshRegion, refineNear
from yade_mpm.geometry.meshInput import meshFromArrays, meshFromFile
from yade_mpm.geometry.regions import box, sphere

SHAFT = box((14.875, 11), (15.125, 21))
ZONE = box((14, 5.5), (16, 12)) - SHAFT
GROUND = box((0, 0), (30, 12)) - ZONE - SHAFT
QUADS = ([(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)], [(0, 1, 4, 3), (1, 2, 5, 4)])
HEX = ([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1))], [list(range(8))])
CORNERS = {2: np.array([(0, 0), (1, 0), (1, 1), (0, 1)])}
CORNERS[3] = np.array([(*xy, z) for z in (0, 1) for xy in CORNERS[2]])


def defaultMesh():
    near = latticePoints(ZONE, (0, 0), (30, 24), 0.125, "near soil")
    coarse = meshRegion(GROUND, (0, 0), (30, 24), 0.25, "far soil")
    return coarse, refineNear(coarse, near, 0.0625, distance=0.25, ratio=2)


def test_default_scene_surface_has_no_facet_between_coarse_and_fine():
    coarse, fine = defaultMesh()
    ring = 2 * 26 + 8 + 2  # coarse facets of the ring on the zone and on the ground surface
    assert len(boundaryFacets(fine)[0]) == len(boundaryFacets(coarse)[0]) + ring


def blockWithHole(dim, ratio, particle=None):
    """Coarse block of 5^dim cells of edge 0.2, refined next to one particle in the removed middle cell."""
    hole = box((0.4,) * dim, (0.6,) * dim)
    coarse = meshRegion(box((0,) * dim, (1,) * dim) - hole, (0,) * dim, (1,) * dim, 0.2, "block")
    particle = [(0.5,) * dim] if particle is None else particle
    return coarse, refineNear(coarse, particle, 0.1, distance=0.2, ratio=ratio)


REFINED = [(dim, ratio) for dim in (2, 3) for ratio in (2, 3)]


def test_cells_and_vertices_are_ordered_row_by_row():
    mesh = meshRegion(box((1, 0), (2, 1)), (0, 0), (4, 4), 0.5, "soil")
    expected = [(x, y) for y in (0, 0.5, 1) for x in (1, 1.5, 2)]
    assert np.array_equal(mesh.points, expected)
    assert np.array_equal(mesh.cells, [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)])
    assert mesh.dim == 2 and len(mesh.slaves) == 0


def test_hexahedra_are_in_vtk_order():
    mesh = meshRegion(box((0, 0, 0), (1, 2, 3)), (0, 0, 0), (1, 2, 3), (1, 2, 3), "soil")
    assert np.array_equal(mesh.points[mesh.cells[0]], CORNERS[3] * (1, 2, 3))


def test_cell_is_there_if_its_centre_is_inside():
    mesh = meshRegion(sphere((1, 1, 1), 0.8), (0, 0, 0), (2, 2, 2), 0.25, "ball")
    expected = latticePoints(sphere((1, 1, 1), 0.8), (0, 0, 0), (2, 2, 2), 0.25, "ball")
    np.testing.assert_allclose(mesh.points[mesh.cells].mean(axis=1), expected, rtol=0, atol=1e-14)
    assert len(np.unique(mesh.points, axis=0)) == len(mesh.points)


def test_mesh_of_a_region_that_does_not_fit_is_refused():
    told = "'soil': edge x = 1.1 is not a multiple of the spacing 0.5 ... move it to 1 or 1.5"
    refused(told, lambda: meshRegion(box((0, 0), (1.1, 1)), (0, 0), (4, 4), 0.5, "soil"))


def test_default_scene_splits_62_cells_into_248():
    coarse, fine = defaultMesh()
    volumes = cellVolumes(fine.points, fine.cells)
    assert len(coarse.cells) == 5552
    assert np.sum(volumes < 0.05) == 248
    assert len(fine.cells) == 5552 - 62 + 248
    assert len(fine.slaves) == 2 * 27 + 10
    assert volumes.sum() == pytest.approx(cellVolumes(coarse.points, coarse.cells).sum(), rel=1e-12)


@pytest.mark.parametrize("dim, ratio", REFINED)
def test_refinement_keeps_the_volume_and_orders_cells_by_centre(dim, ratio):
    coarse, fine = blockWithHole(dim, ratio)
    split = 3**dim - 1  # touching at a corner counts
    assert len(fine.cells) == len(coarse.cells) - split + split * ratio**dim
    volumes = cellVolumes(fine.points, fine.cells)
    assert volumes.sum() == pytest.approx(cellVolumes(coarse.points, coarse.cells).sum(), rel=1e-12)
    assert np.all(cornerJacobians(fine.points, fine.cells) > 0)
    centres = fine.points[fine.cells].mean(axis=1).round(9)
    assert np.array_equal(np.lexsort(centres.T), np.arange(len(centres)))


@pytest.mark.parametrize("dim, ratio", REFINED)
def test_refined_cells_leave_no_gap_and_no_overlap(dim, ratio):
    _, fine = blockWithHole(dim, ratio)
    random = np.random.default_rng(3).uniform(0, 1, (300, dim))
    corners = fine.points[fine.cells]
    isIn = np.all((random[:, None] > corners.min(axis=1)) & (random[:, None] < corners.max(axis=1)), axis=2)
    isHole = np.all((random > 0.4) & (random < 0.6), axis=1)
    assert np.array_equal(isIn.sum(axis=1), np.where(isHole, 0, 1))


@pytest.mark.parametrize("dim, ratio", REFINED)
def test_slaves_are_exactly_the_weighted_sum_of_masters_and_never_masters(dim, ratio):
    _, fine = blockWithHole(dim, ratio)
    assert len(fine.slaves) > 0
    assert np.array_equal(
        np.einsum("sm,smd->sd", fine.masterWeights, fine.points[fine.masters]), fine.points[fine.slaves]
    )
    np.testing.assert_allclose(fine.masterWeights.sum(axis=1), 1, rtol=0, atol=1e-15)
    assert np.array_equal(fine.masters < 0, fine.masterWeights == 0)
    assert set(np.sum(fine.masters >= 0, axis=1)) == ({2} if dim == 2 else {2, 4})
    assert not np.intersect1d(fine.masters, fine.slaves).size


@pytest.mark.parametrize("dim, ratio", REFINED)
def test_every_hanging_vertex_is_a_slave(dim, ratio):
    """A vertex hangs if it lies on a cell of which it is no corner."""
    _, fine = blockWithHole(dim, ratio)
    corners = fine.points[fine.cells]
    lower, upper = corners.min(axis=1) - 1e-9, corners.max(axis=1) + 1e-9
    touches = np.all((fine.points[:, None] >= lower) & (fine.points[:, None] <= upper), axis=2)
    isHanging = touches.sum(axis=1) > np.bincount(fine.cells.ravel(), minlength=len(fine.points))
    assert np.array_equal(np.flatnonzero(isHanging), fine.slaves)


def test_slaves_of_ratio_two_are_midpoints():
    _, fine = blockWithHole(2, 2, particle=[(0.5, 0.9)])
    assert set(fine.masterWeights.ravel()) == {0, 0.5}
    ends = fine.points[fine.masters[:, :2]]
    assert np.array_equal(fine.points[fine.slaves], ends.mean(axis=1))


def test_unsplit_vertices_keep_their_coordinates_to_the_last_bit():
    coarse, fine = blockWithHole(3, 3)
    kept = {tuple(p) for p in fine.points}
    assert all(tuple(p) in kept for p in coarse.points)


def test_nothing_near_or_ratio_one_leaves_the_mesh_alone():
    coarse, fine = blockWithHole(2, 2, particle=[(5.0, 5.0)])
    assert len(fine.cells) == len(coarse.cells) and len(fine.slaves) == 0
    assert len(blockWithHole(2, 1)[1].cells) == len(coarse.cells)


@pytest.mark.parametrize(
    "change, text",
    [
        (dict(ratio=0), "refineNear: ratio = 0 must be a whole number from 1 up"),
        (dict(ratio=1.5), "ratio = 1.5 must be a whole number"),
        (dict(distance=0), "refineNear: distance = 0 must be positive and finite"),
        (
            dict(mesh=blockWithHole(2, 2)[1]),
            "not made of equal boxes with shared corners; .* refine once only",
        ),
        (dict(mesh=meshFromArrays([(0, 0), (1, 0), (1, 2), (0, 1)], [range(4)], "odd")), "not made of equal"),
    ],
)
def test_refinement_refuses_what_it_cannot_do(change, text):
    arguments = dict(mesh=blockWithHole(2, 2)[0], positions=[(0.5, 0.5)], halfSize=0.1, distance=0.2, ratio=2)
    with pytest.raises(ValueError, match=text):
        refineNear(**{**arguments, **change})


def test_volume_of_a_quad_is_its_polygon_area():
    points = np.random.default_rng(4).uniform(-0.2, 0.2, (4, 2)) + CORNERS[2]
    x, y = points.T
    expected = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    assert cellVolumes(points, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(expected, rel=1e-14)


def test_volume_of_a_frustum_is_exact():
    base = CORNERS[3] * 2.0 - (1, 1, 0)
    points = base * np.where(base[:, 2:] > 1, (0.5, 0.5, 1), 1)  # 2 x 2 below, 1 x 1 above, height 2
    assert cellVolumes(points, np.arange(8)[None])[0] == pytest.approx(2 / 3 * (4 + 1 + 2), rel=1e-14)


@pytest.mark.parametrize("points, cells", [QUADS, HEX])
def test_mirrored_cells_are_turned_over_if_all_are(points, cells):
    dim = len(points[0])
    mirrored = np.array(points) * ((-1,) + (1,) * (dim - 1))
    mesh = meshFromArrays(mirrored, cells, "soil")
    assert np.all(cornerJacobians(mesh.points, mesh.cells) > 0)
    assert cellVolumes(mesh.points, mesh.cells).sum() == pytest.approx(2, rel=1e-14)
    assert np.array_equal(np.sort(mesh.cells, axis=1), np.sort(cells, axis=1))


def test_points_without_a_cell_are_dropped_and_numbers_closed_up():
    points, cells = [(9, 9), *QUADS[0]], np.array(QUADS[1]) + 1
    mesh = meshFromArrays(points, cells, "soil")
    assert np.array_equal(mesh.points, QUADS[0]) and np.array_equal(mesh.cells, QUADS[1])


def test_a_zero_third_coordinate_is_dropped_in_2d():
    assert meshFromArrays([(x, y, 0.0) for x, y in QUADS[0]], QUADS[1], "soil").dim == 2


def quads(**moved):
    """Points of QUADS, with point pN moved."""
    return [moved.get(f"p{k}", p) for k, p in enumerate(QUADS[0])]


@pytest.mark.parametrize(
    "points, cells, named",
    [
        (quads(), [(0, 1, 4, 3), (1, 4, 5, 2)], "cell 1 at (1.5, 0.5) is inverted; ... (1 such cells)"),
        (quads(p5=(1.2, 0.2)), QUADS[1], "'soil': cell 1 at ... is concave or collapsed; every corner"),
        (quads(p5=(2, 0)), QUADS[1], "cell 1 at ... is concave or collapsed"),
        (quads(), [(0, 1, 4, 4)], "cell 0 at ... names a vertex twice"),
        (quads(), [(0, 1, 4, 6)], "cell 0 names vertices [0, 1, 4, 6], but ... numbered 0 to 5"),
        (quads(), [(0, 1, 4, -1)], "count from zero"),
        (quads(p1=(np.nan, 0)), QUADS[1], "'soil': point 1 at (nan, 0) is not finite"),
        (quads(), [(0, 1, 4)], "cells has shape (1, 3) and type int64; give (Nc, 4) or (Nc, 8)"),
        (quads(), [(0.0, 1.0, 4.0, 3.0)], "type float64"),
        (quads(), np.zeros((0, 4), int), "cells has shape (0, 4)"),
        (quads(), HEX[1], "points has shape (6, 2), but cells of 8 vertices need (Nv, 3)"),
        ([(x, y, x) for x, y in QUADS[0]], QUADS[1], "must lie in the plane z = 0, but z reaches 2"),
    ],
)
def test_bad_cells_are_refused_by_number_and_place(points, cells, named):
    refused(named, lambda: meshFromArrays(points, cells, "soil"))


def test_an_inverted_hexahedron_among_good_ones_is_refused():
    mesh = meshRegion(box((0, 0, 0), (2, 1, 1)), (0, 0, 0), (2, 1, 1), 1, "soil")
    mesh.cells[1] = mesh.cells[1][[0, 3, 2, 1, 4, 7, 6, 5]]
    with pytest.raises(ValueError, match=r"'rock': cell 1 at \(1.5, 0.5, 0.5\) is inverted"):
        meshFromArrays(mesh.points, mesh.cells, "rock")


@pytest.mark.parametrize("suffix", ["vtk", "msh", "inp"])
def test_mesh_files_are_read(tmp_path, suffix):
    meshio = pytest.importorskip("meshio")
    flat = [(x, y, 0.0) for x, y in QUADS[0]]
    path = tmp_path / f"ground.{suffix}"
    arguments = dict(file_format="gmsh22") if suffix == "msh" else {}
    meshio.Mesh(flat, [("line", [(0, 1)]), ("quad", QUADS[1])]).write(path, **arguments)
    mesh = meshFromFile(path, "ground")
    assert np.array_equal(mesh.points, QUADS[0]) and np.array_equal(mesh.cells, QUADS[1])


def test_hexahedra_are_read_and_their_boundary_quads_ignored(tmp_path):
    meshio = pytest.importorskip("meshio")
    cells = [("quad", [(0, 1, 2, 3)]), ("hexahedron", HEX[1])]
    meshio.Mesh(np.array(HEX[0], float), cells).write(tmp_path / "rock.vtk")
    mesh = meshFromFile(tmp_path / "rock.vtk", "rock")
    assert np.array_equal(mesh.points, HEX[0]) and np.array_equal(mesh.cells, HEX[1])


def test_files_without_a_usable_mesh_are_refused(tmp_path):
    meshio = pytest.importorskip("meshio")
    flat = [(x, y, 0.0) for x, y in QUADS[0]]
    meshio.Mesh(flat, [("triangle", [(0, 1, 4)]), ("quad", QUADS[1])]).write(tmp_path / "mixed.vtk")
    with pytest.raises(ValueError, match=r"'soil': .*mixed.vtk holds cells of type triangle; only quad"):
        meshFromFile(tmp_path / "mixed.vtk", "soil")
    (tmp_path / "broken.vtk").write_text("no mesh")
    with pytest.raises(ValueError, match=r"'soil': .*broken.vtk is not a mesh file that meshio can read"):
        meshFromFile(tmp_path / "broken.vtk", "soil")
    with pytest.raises(FileNotFoundError, match="absent.vtk"):
        meshFromFile(tmp_path / "absent.vtk", "soil")


def facetNormals(mesh, facets):
    """Outward normals times facet size, of plane facets."""
    p = mesh.points[facets]
    if mesh.dim == 2:
        along = p[:, 1] - p[:, 0]
        return np.stack([along[:, 1], -along[:, 0]], axis=1)
    return np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]) / 2


@pytest.mark.parametrize("dim, ratio", [(2, 1), (3, 1), *REFINED])
@pytest.mark.parametrize("particle", [0.5, 0.3, 0.1])  # round the hole, to one side, at the outside
def test_boundary_facets_are_the_surface_and_point_outwards(dim, ratio, particle):
    coarse, fine = blockWithHole(dim, ratio, particle=[(particle,) * dim])
    facets, owners = boundaryFacets(fine)
    normals = facetNormals(fine, facets)
    middles = fine.points[facets].mean(axis=1)
    assert np.abs(normals).sum() == pytest.approx(2 * dim * (1 + 0.2 ** (dim - 1)), rel=1e-12)
    outside = np.any((middles < 1e-9) | (middles > 1 - 1e-9), axis=1)
    hole = np.all((middles > 0.4 - 1e-9) & (middles < 0.6 + 1e-9), axis=1)
    assert np.all(outside | hole)
    away = middles - fine.points[fine.cells[owners]].mean(axis=1)
    assert np.all(np.sum(away * normals, axis=1) > 0)
    # Divergence theorem: the flux of x through the surface is dim times the volume.
    assert np.sum(middles * normals) == pytest.approx(dim * (1 - 0.2**dim), rel=1e-12)


# --- groups of a file ---------------------------------------------------------------------------------------
def gmshFile(path, dim, kind="quad", groups=("clay", "sand")):
    """Two cells side by side in Gmsh's format 2.2, each in a physical group, with a line or face besides."""
    import meshio

    side = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    if dim == 3:
        side = np.concatenate([side, side + (0, 0, 1)])
    points = np.concatenate([side, side + (2, 0, 0)])
    n = len(side)
    corners = np.arange(2 * n).reshape(2, n)
    if kind == "triangle":
        corners = corners[:, :3]
    low = np.array([[0, 1]]) if dim == 2 else np.array([[0, 1, 2, 3]])
    cells = [("line" if dim == 2 else "quad", low), (kind, corners)]
    tags = [np.array([9]), np.arange(1, 3)[: len(corners)]]
    named = {name: np.array([k + 1, dim]) for k, name in enumerate(groups)}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    meshio.Mesh(points, cells, cell_data=data, field_data={**named, "edge": np.array([9, dim - 1])}).write(
        path, file_format="gmsh22", binary=False
    )


@pytest.mark.parametrize("dim, kind", [(2, "quad"), (3, "hexahedron")])
def test_physical_groups_of_gmsh_are_bodies(dim, kind, tmp_path):
    gmshFile(tmp_path / "two.msh", dim, kind)
    found = mpm.meshesFromFile(tmp_path / "two.msh")
    assert list(found) == ["clay", "sand"]
    assert found["clay"].points[:, 0].max() == 1 and found["sand"].points[:, 0].min() == 2
    scene = mpm.Scene((0,) * dim, (4,) * dim, 0.5)
    law = mpm.LinearElastic(density=1.0, lame=(1.0, 1.0))
    assert [scene.add(name, mesh, law).count for name, mesh in found.items()] == [1, 1]


def test_files_that_are_no_groups_of_quadrilaterals_say_what_to_do(tmp_path):
    gmshFile(tmp_path / "three.msh", 2, "triangle")
    told = "type triangle; ... gmsh model.geo -2 -setnumber Mesh.RecombineAll 1"
    refused(told, lambda: mpm.meshesFromFile(tmp_path / "three.msh"))
    gmshFile(tmp_path / "one.msh", 2, groups=("clay",))
    with pytest.raises(ValueError, match="1 cells belong to no group or to several; give each part"):
        mpm.meshesFromFile(tmp_path / "one.msh")
