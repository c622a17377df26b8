# SPDX-License-Identifier: GPL-2.0-or-later
"""The outline of boxes that were cut from a region: its facets, and how they go with the particles
(doc/explanation/contact.md)."""

import numpy as np
import pytest
import yade_mpm as mpm
from inputs import refused
from setups import chain, elastic
from yade_mpm import box, disc, halfSpace, polygon, sphere
from yade_mpm.geometry.lattice import cutCells, cutOutline

CUT = mpm.UGIMP(perCell=2, cut=True)


def facets(region, spacing=0.25):
    args = (region, [0] * region.dim, [4] * region.dim, spacing, "body")
    centroids, _, numbers = cutCells(*args)
    carriers, offsets, areas = cutOutline(*args, numbers, centroids)
    return centroids[carriers] + offsets, areas, np.linalg.norm(offsets, axis=1)


def scene(region, type_=CUT, cell=0.5, **options):
    made = mpm.Scene((0,) * region.dim, (4,) * region.dim, cell, threads=1)
    return made, made.add("body", region, elastic(1e3), type_, **options)


def enclosed(middles, areas):
    """What a closed surface holds, by the theorem of Gauss."""
    return (middles * areas).sum() / middles.shape[1]


@pytest.mark.parametrize(
    "region, size",
    [
        (disc((2.03, 1.98), 1.25), np.pi * 1.25**2),
        (sphere((2.03, 1.98, 2.01), 1.25), 4 / 3 * np.pi * 1.25**3),
        (box((1, 1), (3, 2.5)), 3.0),
        (box((1, 1, 1), (2, 2, 2.5)), 1.5),
        (box((1, 1), (3, 3)) - disc((2, 2), 0.6), 4 - np.pi * 0.36),
        (box((1, 1, 1), (2, 2, 2)) & halfSpace((2, 2, 1.5), (0.3, 0, 1)), 0.65),
        (box((0, 0), (4, 4)), 16.0),
    ],
    ids=repr,
)
def test_facets_close_round_the_region(region, size):
    middles, areas, far = facets(region)
    assert np.abs(areas.sum(axis=0)).max() < 1e-4 * size
    assert enclosed(middles, areas) == pytest.approx(size, rel=0.02)
    assert far.max() < 0.25  # from the particle that carries it; a box has edges of 0.25


@pytest.mark.parametrize(
    "region, degrees", [(disc((2.03, 1.98), 1.25), 0.1), (sphere((2.03, 1.98, 2.01), 1.25), 3)], ids=repr
)
def test_facets_lie_on_the_region_and_face_away_from_it(region, degrees):
    middles, areas, _ = facets(region)
    out, size = middles - region._centre, np.linalg.norm(areas, axis=1)
    assert np.linalg.norm(out, axis=1) == pytest.approx(1.25, abs=1e-6)
    assert ((out * areas).sum(axis=1) / size / 1.25).min() > np.cos(np.radians(degrees))
    assert size.min() > 0.19 * 0.25 ** (region.dim - 1)  # smaller ones are joined


def test_faces_of_whole_boxes_on_the_boundary_are_facets():
    middles, areas, _ = facets(box((1, 1), (2, 1.5)), 0.25)
    assert len(middles) == 12
    assert (np.isclose(middles[:, 1], 1) & (areas == (0, -0.25)).all(axis=1)).sum() == 4


def test_a_polygon_has_the_normals_of_its_sides_but_at_its_corners():
    middles, areas, _ = facets(polygon([(0.6, 0.7), (3.3, 1.2), (1.4, 3.1)]), 0.125)
    normals = areas / np.linalg.norm(areas, axis=1)[:, None]
    corners = np.array([(0.6, 0.7), (3.3, 1.2), (1.4, 3.1)])
    sides = np.roll(corners, -1, axis=0) - corners
    exact = np.stack([sides[:, 1], -sides[:, 0]], axis=1) / np.linalg.norm(sides, axis=1)[:, None]
    away = np.linalg.norm(middles[:, None] - corners, axis=2).min(axis=1) > 0.2
    assert (normals @ exact.T).max(axis=1)[away].min() > 1 - 1e-6 and away.sum() > 50


@pytest.mark.parametrize("dim", [2, 3])
def test_the_outline_moves_with_the_deformation_of_its_particles(dim):
    """x -> F x + c: facets go along, their area vectors by Nanson's formula, in whatever order the particles
    are."""
    _, body = scene(disc((2.1, 1.9), 0.8) if dim == 2 else sphere((2.1, 1.9, 2), 0.8))
    before, areas = body.outline()
    F, shift = np.eye(3), np.array([0.1, -0.2, 0.3])[:dim]
    F[:dim, :dim] = np.linalg.qr(np.random.default_rng(2).normal(size=(dim, dim)))[0] @ np.diag(
        [1.2, 0.9, 1.1][:dim]
    )
    small = F[:dim, :dim]
    body.position[...] = body.position @ small.T + shift
    body.deformationGradient[...] = F
    after, turned = body.outline()
    assert after == pytest.approx(before @ small.T + shift, abs=1e-12)
    assert turned == pytest.approx(areas @ np.linalg.inv(small) * np.linalg.det(small), abs=1e-12)


def test_the_outline_of_a_particle_without_volume_is_refused():
    _, body = scene(disc((2.1, 1.9), 0.8))
    body.deformationGradient[...] = 0
    refused("body 'body': outline: deformationGradient of particle ... determinant 0", body.outline)


def pressed(angle, isTurned=True):
    """A wedge with an underside that slopes by `angle`, turned level, 0.01 above a base: normals and gaps
    that contact finds."""
    angle = np.radians(angle)
    made = mpm.Scene((0, 0), (4, 3), 0.25, threads=1)
    material = elastic(1e4)
    made.add("base", box((0, 0), (4, 1)), material, mpm.UGIMP(perCell=2), group="base")
    corner = np.array((2.0, 1.5))
    wedge = made.add(
        "wedge",
        box((1, 1), (3, 2.5)) & halfSpace(corner, (np.sin(angle), -np.cos(angle))),
        material,
        CUT,
        group="wedge",
    )
    back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    wedge.position[...] = (wedge.position - corner) @ back.T + (2.0, 1.01)
    if isTurned:
        wedge.deformationGradient[:, :2, :2] = back
    wedge.velocity = (0, -300.0)
    contact = mpm.Contact()
    made.engines = chain(contact=contact)
    made.dt = 1e-4
    made.run(steps=1, progress=False)
    table = contact.contactTable()
    middle = (np.abs(table["node"][:, 0] - 2) < 0.5) & (table["node"][:, 1] == 1)
    return table["normal"][middle], table["gap"][middle]


def test_contact_sees_the_outline_as_it_has_turned():
    normals, gaps = pressed(20)
    assert len(gaps) >= 3
    assert normals == pytest.approx(np.array([(0, 1, 0)] * len(gaps)), abs=1e-6)
    assert gaps == pytest.approx(0.01, abs=1e-6)
    normals, gaps = pressed(20, isTurned=False)  # control: F is what turns it
    assert len(gaps) == 0 or np.abs(normals[:, 0]).max() > 0.1


@pytest.mark.parametrize("dim", [2, 3])
def test_facets_stay_where_they_are_when_their_particle_is_split(dim):
    _, body = scene(
        disc((2.1, 1.9), 0.8) if dim == 2 else sphere((2.1, 1.9, 2), 0.8),
        mpm.UGIMP(perCell=2, cut=True, splitAt=1.3),
    )
    F = np.eye(3)
    F[:2, :2] = np.array([[0.8, -0.6], [0.6, 0.8]]) @ np.diag([1.5, 0.9])
    body.deformationGradient[...] = F
    before, areas = body.outline()
    count = body.count
    assert body._core.splitStretched() and body.count == 2 * count
    after, same = body.outline()
    assert after == pytest.approx(before, abs=1e-12) and same == pytest.approx(areas, abs=1e-12)
    carrier = np.asarray(body._core.view("outlineCarrier", True))
    assert 0.2 < (carrier >= count).mean() < 0.8  # new halves have some of them
    away = np.linalg.norm(after - body.position[np.argsort(body.id)[carrier]], axis=1)
    assert away.max() < np.linalg.norm(F[:dim, :dim] @ np.diag(2 * body.halfSize))


def test_a_checkpoint_keeps_the_outline(tmp_path):
    made, body = scene(disc((2.1, 1.9), 0.8), group="one")
    made.engines = chain(gravity=(1, -5))
    made.dt = 1e-3
    made.run(steps=20, progress=False)
    made.save(tmp_path / "a.h5")
    again = mpm.load(tmp_path / "a.h5")["body"]
    assert all((a == b).all() for a, b in zip(body.outline(), again.outline()))


def test_without_outline_boxes_have_none():
    assert scene(disc((2.1, 1.9), 0.8), mpm.UGIMP(perCell=2, cut=True, outline=False))[1].outline() is None
    assert scene(disc((2.1, 1.9), 0.8), mpm.UGIMP(perCell=2))[1].outline() is None
    assert scene(box((1, 1), (2, 2)), mpm.APDI())[1].outline() is None
