# SPDX-License-Identifier: GPL-2.0-or-later
import numpy as np
import pytest
import yade_mpm as mpm
from inputs import refused
from setups import elastic
from yade_mpm.geometry.lattice import checkOverlap, cutCells, firstNear, latticePoints
from yade_mpm.geometry.regions import box, disc, halfSpace, polygon, sphere

LOWER, UPPER = (0, 0), (30, 24)
SHAFT = box((14.875, 11), (15.125, 21))
ZONE = box((14, 5.5), (16, 12)) - SHAFT


def test_lattice_points_are_cell_centres_with_the_first_axis_fastest():
    points = latticePoints(box((1, 2), (2, 3)), (0, 0), (4, 4), 0.5, "soil")
    assert np.array_equal(points, [(1.25, 2.25), (1.75, 2.25), (1.25, 2.75), (1.75, 2.75)])


def test_lattice_spacing_may_differ_per_direction_in_3d():
    points = latticePoints(box((0, 0, 0), (1, 1, 1)), (0, 0, 0), (1, 1, 1), (0.5, 1, 0.5), "soil")
    expected = [(0.25, 0.5, 0.25), (0.75, 0.5, 0.25), (0.25, 0.5, 0.75), (0.75, 0.5, 0.75)]
    assert np.array_equal(points, expected)


def test_lattice_is_anchored_at_the_grid_corner():
    points = latticePoints(box((0.1, 0.1), (0.3, 0.2)), (-0.2, -0.2), (1, 1), 0.1, "soil")
    np.testing.assert_allclose(points, [(0.15, 0.15), (0.25, 0.15)], rtol=0, atol=1e-15)


def test_default_scene_has_816_ugimp_and_160_pile_particles():
    assert len(latticePoints(ZONE, LOWER, UPPER, 0.125, "near soil")) == 816
    assert len(latticePoints(SHAFT, LOWER, UPPER, 0.125, "pile")) == 160


@pytest.mark.parametrize(
    "cut", [disc((2, 2), 1.25), halfSpace((2, 2), (1, 1)), polygon([(1, 1), (3, 1), (1, 3)])]
)
def test_parts_of_a_cut_region_share_the_lattice_without_gap_or_overlap(cut):
    whole = box((0, 0), (4, 4))
    args = ((0, 0), (4, 4), 0.5, "part")
    parts = np.concatenate([latticePoints(whole & cut, *args), latticePoints(whole - cut, *args)])
    parts = parts[np.lexsort(parts.T)]
    assert np.array_equal(parts, latticePoints(whole, *args))


def test_lattice_of_a_sphere_fills_its_volume():
    points = latticePoints(sphere((1, 1, 1), 0.9), (0, 0, 0), (2, 2, 2), 0.05, "ball")
    assert len(points) * 0.05**3 == pytest.approx(4 / 3 * np.pi * 0.9**3, rel=0.005)


def test_edges_cut_away_need_not_fit_the_spacing():
    ground = box((0, 0), (30, 12)) - box((14, 5.5), (16, 12)) - SHAFT
    assert len(latticePoints(ground, LOWER, UPPER, 0.25, "far soil")) == 120 * 48 - 8 * 26


@pytest.mark.parametrize(
    "region, spacing, named",
    [
        (box((1, 1), (2.3, 2)), 0.25, "'soil': edge x = 2.3 ... move it to 2.25 or 2.5"),
        (box((1, 1), (2, 2)) - box((1.5, 1.5), (2, 1.8)), 0.5, "edge y = 1.8 ... move it to 1.5 or 2"),
        (polygon([(1, 1), (2, 1), (2, 2.1), (1, 2.1)]), 0.5, "edge y = 2.1 ... move it to 2 or 2.5"),
        (box((1, 1), (2, 2)), (0.5, 0.3), "edge y = 1 is not a multiple of ... 0.3 ... to 0.9 or 1.2"),
        (box((1, 1), (2, 5)), 0.5, "'soil': ... outside the grid: it spans (1, 1) to (2, 5) ... '& box"),
        (halfSpace((0, 2), (0, 1)), 0.5, "reaches outside the grid"),
        (disc((1, 1), 0.1), 0.5, "'soil': empty body: disc((1, 1), 0.1) holds no centre of ... spacing 0.5"),
        (box((1, 1), (2, 2)) & box((3, 3), (4, 4)), 0.5, "empty body"),
        (box((1, 1), (2, 2)), 0, "'soil': spacing = 0 must be one positive number or 2 of them"),
        (box((1, 1), (2, 2)), (1, 1, 1), "must be one positive number or 2"),
        (box((1, 1, 1), (2, 2, 2)), 0.5, "is 3D, but the grid corners have shapes (2,) and (2,)"),
    ],
)
def test_a_region_that_does_not_fit_is_refused(region, spacing, named):
    refused(named, lambda: latticePoints(region, (0, 0), (4, 4), spacing, "soil"))


def test_edge_within_a_millionth_of_the_spacing_is_accepted():
    points = latticePoints(box((1, 1), (2 + 4e-7, 2)), (0, 0), (4, 4), 0.5, "soil")
    assert len(points) == 4
    with pytest.raises(ValueError, match="not a multiple"):
        latticePoints(box((1, 1), (2 + 6e-7, 2)), (0, 0), (4, 4), 0.5, "soil")


@pytest.mark.parametrize("dim", [2, 3])
def test_touching_bodies_do_not_overlap_and_shifted_ones_do(dim):
    lower, upper = (0,) * dim, (4,) * dim
    a = latticePoints(box((0,) * dim, (2,) * dim), lower, upper, 0.5, "a")
    b = latticePoints(box((2,) + (0,) * (dim - 1), (4,) + (2,) * (dim - 1)), lower, upper, 0.25, "b")
    checkOverlap("a", a, 0.25, "b", b, 0.125)
    shift = np.zeros(dim)
    shift[0] = -0.1
    with pytest.raises(ValueError, match=r"bodies 'far' and 'near' overlap at \(1.95, .*; subtract"):
        checkOverlap("far", a, 0.25, "near", b + shift, 0.125)


def test_overlap_is_found_where_sizes_differ_widely():
    small = np.array([(0.6, 0.6)])
    with pytest.raises(ValueError, match=r"overlap at \(0.6, 0.6\) \(1 particle of 'large'\)"):
        checkOverlap("large", [(0, 0), (50, 50)], [(1, 1), (0.1, 0.1)], "small", small, 0.01)
    checkOverlap("large", [(0, 0), (50, 50)], [(0.5, 0.5), (0.1, 0.1)], "small", small, 0.01)


def test_bodies_without_particles_do_not_overlap():
    checkOverlap("a", np.zeros((0, 2)), 1, "b", np.zeros((1, 2)), 1)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("reach", [0.3, -0.05])
def test_first_near_agrees_with_all_pairs(dim, reach):
    random = np.random.default_rng(2)
    a, b = random.uniform(0, 4, (200, dim)), random.uniform(1, 6, (150, dim))
    halfA, halfB = random.uniform(0.05, 0.3, a.shape), random.uniform(0.05, 0.2, b.shape)
    gaps = np.abs(a[:, None] - b) - halfA[:, None] - halfB
    if reach > 0:
        isNear = np.linalg.norm(np.maximum(gaps, 0), axis=2) < reach
    else:
        isNear = np.all(gaps < reach, axis=2)
    found = firstNear(a, halfA, b, halfB, reach)
    assert np.array_equal(found >= 0, isNear.any(axis=1))
    assert isNear[found >= 0, found[found >= 0]].all()
    assert 0 < np.sum(found >= 0) < len(a)


def test_positions_and_half_sizes_of_the_wrong_shape_are_refused():
    with pytest.raises(ValueError, match=r"positions has shape \(3,\)"):
        firstNear([0, 0, 0], 1, np.zeros((1, 3)), 1, 0)
    with pytest.raises(ValueError, match=r"halfSize has shape \(3,\); give one number, \(2,\) or \(4, 2\)"):
        firstNear(np.zeros((4, 2)), np.ones(3), np.zeros((1, 2)), 1, 0)


# --- cells that a boundary cuts -------------------------------------------------------------------------
@pytest.mark.parametrize(
    "region, size",
    [
        (disc((2.03, 1.98), 1.25), np.pi * 1.25**2),
        (sphere((2.03, 1.98, 2), 1.25), 4 / 3 * np.pi * 1.25**3),
        (polygon([(1, 1), (3, 1), (1, 3)]), 2.0),
    ],
)
def test_cut_cells_hold_what_is_inside(region, size):
    dim = region.dim
    centroids, shares, _ = cutCells(region, [0] * dim, [4] * dim, 0.25, "body")
    assert shares.sum() * 0.25**dim == pytest.approx(size, rel=2e-3)
    assert 0.01 <= shares.min() < 0.5 and shares.max() == 1
    if dim == 2:
        whole = latticePoints(region, (0, 0), (4, 4), 0.25, "body")
        assert abs(len(whole) * 0.25**2 / size - 1) > 2e-3  # control: whole cells do not
    assert region.contains(centroids).all()


def test_cells_that_nothing_cuts_are_whole():
    region = box((1, 1), (3, 3)) - box((1, 1), (1.5, 2))
    centroids, shares, _ = cutCells(region, (0, 0), (4, 4), 0.25, "body")
    assert (shares == 1).all()
    np.testing.assert_allclose(
        centroids, latticePoints(region, (0, 0), (4, 4), 0.25, "body"), rtol=0, atol=1e-12
    )


def test_cut_cells_of_two_sides_make_up_the_whole():
    args, whole, cut = ((0, 0), (4, 4), 0.25, "body"), box((0, 0), (4, 4)), halfSpace((2, 2), (1, 0.3))
    shares = sum(cutCells(part, *args)[1].sum() for part in (whole & cut, whole - cut))
    assert shares == pytest.approx(256, rel=2e-3)


def test_a_cut_body_has_the_mass_of_its_region_and_may_touch_another():
    scene = mpm.Scene((0, 0), (4, 4), 0.5)
    material = elastic(1e3)
    scene.add("base", box((0, 0), (4, 1)), material, mpm.UGIMP(perCell=2))
    wheel = scene.add("wheel", disc((2, 2), 1), material, mpm.UGIMP(perCell=2, cut=True))
    assert wheel.mass.sum() == pytest.approx(2 * np.pi, rel=2e-3)
    np.testing.assert_allclose(wheel.mass, 2 * wheel.volume, rtol=1e-12)
    assert (wheel.volume == wheel.initialVolume).all()
    np.testing.assert_allclose(wheel.mass @ wheel.position / wheel.mass.sum(), (2, 2), atol=1e-9)
    with pytest.raises(ValueError, match="overlap"):
        scene.add("other", disc((2, 2), 0.9), material, mpm.UGIMP(perCell=2, cut=True))
    with pytest.raises(ValueError, match="empty body"):
        scene.add("dust", disc((0.25, 3.5), 0.01), material, mpm.UGIMP(perCell=2, cut=True))
