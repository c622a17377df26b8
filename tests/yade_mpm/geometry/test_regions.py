# SPDX-License-Identifier: GPL-2.0-or-later
import json
from math import inf, nan

import numpy as np
import pytest
from inputs import cases, refused
from yade_mpm.geometry.region import Region
from yade_mpm.geometry.regions import (
    box,
    cylinder,
    disc,
    everywhere,
    halfSpace,
    polygon,
    prism,
    regionFromSpec,
    sphere,
)

SQUARE = box((0, 0), (2, 1))
ONE_OF_EACH = [
    box((0, 0), (2, 1)),
    box((0, 0, 0), (2, 1, 3)),
    sphere((1, 0.5, 0), 0.75),
    disc((1, 0.5), 0.1),
    polygon([(0, 0), (1, 0), (0.5, 2)]),
    cylinder((0, 0, 1), (1, 2, 3), 0.5),
    prism([(0, 0), (1, 0), (0.5, 2)], 0, 2, "y"),
    halfSpace((0, 12), (0, 1)),
    everywhere(3),
]


def randomPoints(dim, count=2000):
    return np.random.default_rng(1).uniform(-1, 3, (count, dim))


def test_box_contains_its_closed_set():
    points = [(1, 0.5), (0, 0), (2, 1), (2 + 1e-10, 1), (2 + 1e-7, 1), (-0.1, 0.5), (1, 1.1)]
    assert SQUARE.contains(points).tolist() == [True, True, True, True, False, False, False]


def test_sphere_contains_points_closer_than_its_radius():
    points = randomPoints(3)
    expected = np.linalg.norm(points - [1, 0.5, 0], axis=1) <= 0.75
    assert np.array_equal(sphere((1, 0.5, 0), 0.75).contains(points), expected)


def test_disc_contains_points_of_its_circle():
    assert disc((1, 1), 0.5).contains([(1.5, 1), (1, 0.5), (1.5 + 1e-7, 1)]).tolist() == [True, True, False]


@pytest.mark.parametrize("turn", [1, -1])
def test_polygon_contains_does_not_depend_on_the_orientation(turn):
    angle = polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)][::turn])
    points = randomPoints(2)
    expected = (box((0, 0), (2, 1)) + box((0, 0), (1, 2))).contains(points)
    assert np.array_equal(angle.contains(points), expected)
    assert angle.contains([(1, 1), (2, 0.5), (0, 0), (1.5, 1.5)]).tolist() == [True, True, True, False]


def test_half_space_contains_the_side_its_normal_points_away_from():
    ground = halfSpace((0, 12), (0, 3))
    assert ground.contains([(-1e6, 11), (5, 12), (5, 12.1)]).tolist() == [True, True, False]
    oblique = halfSpace((0, 0, 0), (1, 1, 0))
    assert oblique.contains([(-1, 0.5, 9), (1, -1, 9), (1, 0, 9)]).tolist() == [True, True, False]


def test_everywhere_contains_all():
    assert everywhere(2).contains([(1e9, -1e9), (0, 0)]).all()


def test_operators_are_those_of_sets():
    a, b, points = disc((1, 1), 1), box((0.5, -1), (2, 0.9)), randomPoints(2)
    inA, inB = a.contains(points), b.contains(points)
    assert np.array_equal((a + b).contains(points), inA | inB)
    assert np.array_equal((a | b).contains(points), inA | inB)
    assert np.array_equal((a - b).contains(points), inA & ~inB)
    assert np.array_equal((a & b).contains(points), inA & inB)


def test_nodes_on_a_common_face_belong_to_both_sides_and_to_the_union():
    a, b, node = box((0, 0), (1, 1)), box((1, 0), (2, 1)), [(1, 0.5)]
    for region in (a, b, a + b, (a + b) - b, (a + b) - a):
        assert region.contains(node).all()


def test_a_face_inside_a_removed_union_is_not_left_behind():
    a, b = box((0, 0), (1, 1)), box((1, 0), (2, 1))
    rest = box((-1, -1), (3, 3)) - (a + b)
    assert rest.contains([(1, 0.5), (1, 1), (0, 0.5)]).tolist() == [False, True, True]


def test_regions_that_only_touch_have_no_intersection():
    assert not (box((0, 0), (1, 1)) & box((1, 0), (2, 1))).contains([(1, 0.5)]).any()


@pytest.mark.parametrize(
    "cut",
    [
        disc((0, 0), 0.5),
        box((0, 0), (0.5, 0.5)),
        halfSpace((0.25, 0), (1, 0)),
        polygon([(0, 0), (1, 0), (0, 1)]),
    ],
)
def test_each_point_of_a_cut_region_is_in_one_part_even_on_the_cut(cut):
    whole = box((-1, -1), (1, 1))
    ticks = np.arange(-8, 8) / 8
    points = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    parts = [(whole & cut).contains(points, closed=False), (whole - cut).contains(points, closed=False)]
    assert np.array_equal(parts[0], ~parts[1])
    control = (whole & cut).contains(points) & (whole - cut).contains(points)
    assert control.any()  # the closed sets share the cut


def test_bounds_hold_the_region():
    assert np.array_equal(disc((1, 2), 0.5).bounds(), [(0.5, 1.5), (1.5, 2.5)])
    assert np.array_equal(halfSpace((3, 12), (0, 1)).bounds(), [(-inf, -inf), (inf, 12)])
    assert np.array_equal(halfSpace((3, 12), (1, 1)).bounds(), [(-inf, -inf), (inf, inf)])
    assert np.array_equal((SQUARE + disc((2, 0), 1)).bounds(), [(0, -1), (3, 1)])
    assert np.array_equal((SQUARE & halfSpace((0.5, 0), (-1, 0))).bounds(), [(0.5, 0), (2, 1)])
    assert np.array_equal((SQUARE - box((1, -1), (3, 2))).bounds(), SQUARE.bounds())


def test_edges_are_the_axis_aligned_planes():
    assert SQUARE.edges() == [(0, 0.0), (0, 2.0), (1, 0.0), (1, 1.0)]
    assert box((0, 1, 2), (3, 4, 5)).edges() == [(0, 0.0), (0, 3.0), (1, 1.0), (1, 4.0), (2, 2.0), (2, 5.0)]
    assert polygon([(0, 0), (1, 0), (1, 1)]).edges() == [(0, 1.0), (1, 0.0)]
    assert halfSpace((3, 12), (0, 2)).edges() == [(1, 12.0)]
    assert halfSpace((3, 12), (1, 2)).edges() == []
    assert disc((0, 0), 1).edges() == [] == everywhere(2).edges()


def test_composed_edges_are_those_of_the_operands_that_still_bound_the_result():
    zone = box((14, 5.5), (16, 12))
    shaft = box((14.875, 11), (15.125, 21))
    assert (zone - shaft).edges() == [
        (0, 14.0),
        (0, 14.875),
        (0, 15.125),
        (0, 16.0),
        (1, 5.5),
        (1, 11.0),
        (1, 12.0),
    ]
    ground = box((0, 0), (30, 12)) - zone - shaft  # what the shaft would cut is gone with the zone
    assert ground.edges() == [(0, 0.0), (0, 14.0), (0, 16.0), (0, 30.0), (1, 0.0), (1, 5.5), (1, 12.0)]
    assert (box((0, 0), (1, 1)) + box((1, 0), (2, 1))).edges() == SQUARE.edges()
    cube = box((0, 0, 0), (1, 1, 1))
    assert (cube & halfSpace((0, 0, 0.3), (0, 0, 1))).edges()[-2:] == [(2, 0.0), (2, 0.3)]


@pytest.mark.parametrize(
    "text",
    [
        "box((0, 0), (30, 12))",
        "box((0, 0, 0), (1, 1, 0.25))",
        "sphere((0, 0, 1), 0.1)",
        "disc((0.3, 0), 2)",
        "polygon([(0, 0), (1, 0), (0, 1)])",
        "halfSpace((0, 12), (0, 1))",
        "everywhere(2)",
        "box((0, 0), (3, 3)) - disc((1, 1), 0.5) + disc((1, 1), 0.25)",
        "box((0, 0), (3, 3)) - (disc((1, 1), 0.5) - disc((1, 1), 0.25))",
        "(box((0, 0), (3, 3)) + disc((1, 1), 9)) & everywhere(2) & halfSpace((0, 1), (0, 1))",
    ],
)
def test_repr_and_spec_give_the_region_back(text):
    region = eval(text)
    assert repr(region) == text
    again = regionFromSpec(json.loads(json.dumps(region.spec())))
    assert repr(again) == text and again.spec() == region.spec()
    points = randomPoints(region.dim)
    assert np.array_equal(again.contains(points), region.contains(points))


@pytest.mark.parametrize("region", ONE_OF_EACH, ids=repr)
def test_points_of_the_wrong_shape_are_refused(region):
    with pytest.raises(ValueError, match=r"contains: points has shape \(4,\).* a single point as \[point\]"):
        region.contains([0, 0, 0, 0])
    with pytest.raises(TypeError, match="contains: points = 'origin' is not made of numbers"):
        region.contains("origin")


@cases(
    ("box: lower = (2, 0) must be below upper = (1, 1)", lambda: box((2, 0), (1, 1))),
    ("in every direction; swap or correct the corners", lambda: box((0, 0), (1, 0))),
    ("box: upper = (1, 1, 1) must have 2 coordinates", lambda: box((0, 0), (1, 1, 1))),
    ("box: lower = (0,) must have 2 or 3 coordinates", lambda: box((0,), (1,))),
    ("box: lower ... nan ... must be finite; remove NaN", lambda: box((0, nan), (1, 1))),
    ("box: lower = 'ab' is not made of numbers", lambda: box("ab", (1, 1)), TypeError),
    ("disc: radius = -1 must be positive and finite", lambda: disc((0, 0), -1)),
    ("disc: radius = nan must be positive", lambda: disc((0, 0), nan)),
    ("disc: radius = (1, 2) must be one number", lambda: disc((0, 0), (1, 2))),
    ("disc: centre = (0, 0, 0) ... in 3D give a sphere()", lambda: disc((0, 0, 0), 1)),
    ("sphere: centre = (0, 0) ... in 2D give a disc()", lambda: sphere((0, 0), 1)),
    ("at least three points", lambda: polygon([(0, 0), (1, 1)])),
    ("polygon: points ... must be finite", lambda: polygon([(0, 0), (1, inf), (1, 1)])),
    ("(0, 0) and from (1, 0) intersect", lambda: polygon([(0, 0), (1, 1), (1, 0), (0, 1)])),
    ("intersect; reorder the corners", lambda: polygon([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)])),
    ("point 1 at (1, 0) is repeated", lambda: polygon([(0, 0), (1, 0), (1, 0), (0, 1)])),
    ("folded at (2, 0) intersect; remove", lambda: polygon([(0, 0), (2, 0), (1, 0)])),
    ("halfSpace: normal = (0, 0) has no direction", lambda: halfSpace((0, 0), (0, 0))),
    ("everywhere: dim = 4 must be 2 or 3", lambda: everywhere(4)),
    ("+ sphere ... a 2D and a 3D region do not combine", lambda: SQUARE + sphere((0, 0, 0), 1)),
    ("region - 1: the right side is a int, not a region", lambda: SQUARE - 1, TypeError),
    ("kind = 'cone' is unknown; allowed are box", lambda: regionFromSpec({"kind": "cone"})),
    ("not describe a box: ... upper", lambda: regionFromSpec({"kind": "box", "lower": [0, 0]})),
    ("describe a union: 'b'", lambda: regionFromSpec({"kind": "union", "a": SQUARE.spec()})),
    ("spec is a str; give a dict", lambda: regionFromSpec("box"), TypeError),
)
def test_bad_input_is_refused_with_what_to_do(named, make, kind):
    refused(named, make, kind)


def test_a_closed_ring_is_a_polygon():
    ring = [(0, 0), (1, 0), (0.5, 2), (0, 0)]
    assert polygon(ring).spec() == polygon(ring[:-1]).spec()


class Hill(Region):
    """A region of one's own: ground below a curve."""

    def __init__(self):
        super().__init__(2)

    def contains(self, points, closed=True):
        x, y = np.asarray(points, float).T
        return (y >= 0) & (y <= 1 + 0.5 * np.sin(x)) & (x >= 0) & (x <= 4)

    def bounds(self):
        return np.array([0.0, 0.0]), np.array([4.0, 1.5])


def test_a_region_of_ones_own_combines_with_others():
    points = randomPoints(2)
    inHill, inSquare = Hill().contains(points), SQUARE.contains(points, closed=False)
    assert np.array_equal((Hill() - SQUARE).contains(points, closed=False), inHill & ~inSquare)
    assert np.array_equal((SQUARE & Hill()).contains(points, closed=False), inHill & inSquare)
    assert Hill().spec() is None and (SQUARE + Hill()).spec() is None and Hill().edges() == []


def test_what_a_region_of_ones_own_lacks_is_said():
    with pytest.raises(NotImplementedError, match=r"Region has no contains\(points, closed=True\)"):
        Region(2).contains([(0, 0)], closed=False)
    with pytest.raises(NotImplementedError, match=r"Region has no bounds\(\)"):
        Region(2).bounds()


def test_a_cylinder_and_a_wedge_have_their_volumes():
    """By points at random: half a per cent of the box round them."""
    points = np.random.default_rng(3).uniform(0, 4, (200_000, 3))
    tilted = cylinder((1, 1, 1), (3, 2.5, 2), 0.6)
    length = np.linalg.norm([2, 1.5, 1])
    assert 64 * tilted.contains(points).mean() == pytest.approx(np.pi * 0.36 * length, abs=0.3)
    wedge = prism([(1, 0), (3, 0), (1, 2)], 1, 4, "y")
    inside = points[wedge.contains(points)]
    assert 64 * len(inside) / len(points) == pytest.approx(2 * 3, abs=0.3)
    lower, upper = wedge.bounds()
    assert (inside >= lower).all() and (inside <= upper).all() and upper.tolist() == [3, 4, 2]
    assert wedge.edges() == [(0, 1.0), (1, 1.0), (1, 4.0), (2, 0.0)]
    assert cylinder((1, 1, 0), (1, 1, 2), 0.5).edges() == [(2, 0.0), (2, 2.0)]
    lower, upper = tilted.bounds()
    inside = points[tilted.contains(points)]
    assert (inside >= lower).all() and (inside <= upper).all()


def test_cylinders_and_prisms_refuse_what_has_no_inside():
    with pytest.raises(ValueError, match="radius = 0 must be positive"):
        cylinder((0, 0, 0), (0, 0, 1), 0)
    with pytest.raises(ValueError, match="give the two ends of its axis"):
        cylinder((0, 0, 1), (0, 0, 1), 1)
    with pytest.raises(ValueError, match="axis = 'up' is not allowed; give 'x', 'y' or 'z'"):
        prism([(0, 0), (1, 0), (0, 1)], 0, 1, "up")
    with pytest.raises(ValueError, match="start = 1 must be below end = 0"):
        prism([(0, 0), (1, 0), (0, 1)], 1, 0)
