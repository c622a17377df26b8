# SPDX-License-Identifier: GPL-2.0-or-later
"""The ground surface (yade_mpm/surface.py) of small made-up scenes, against heights, areas and numbers found
by hand.

Cells of 0.5 m, boxes of 0.25 m; gaps of up to 0.25 m are bridged.
"""

import numpy as np
import pytest
import yade_mpm as mpm
from setups import soft
from yade_mpm import box
from yade_mpm.geotech import groundSurface

SOIL = soft(2)
UGIMP, APDI = mpm.UGIMP(perCell=2), mpm.APDI(size=0.5)
MOST = 0.5 * (1 - 1e-9)  # m: the largest step that a limit of 0.5 m lets pass


def scene(**bodies):
    """Scene of bodies, each given as (region, particle type)."""
    made = mpm.Scene((0, 0), (10, 6), 0.5)
    for name, (region, type_) in bodies.items():
        made.add(name, region, SOIL, type_)
    return made


def surface(made, level=2.0, hole=None):
    return groundSurface(made, list(made.bodies), level, hole)


# --- the polyline -------------------------------------------------------------------------------------------
BLOCK, MIDDLE = box((0, 0), (10, 2)), box((4, 0), (6, 2))


@pytest.mark.parametrize(
    "bodies, meshed",
    [
        ({"a": (BLOCK, UGIMP)}, 0),
        ({"a": (BLOCK, APDI)}, 10),
        ({"a": (BLOCK - MIDDLE, APDI), "b": (MIDDLE, UGIMP)}, 8),
    ],
)
def test_a_level_block_has_a_level_surface_from_end_to_end(bodies, meshed):
    s = surface(scene(**bodies))
    assert s.y == pytest.approx(2.0, abs=1e-12) and (np.diff(s.x) > 0).all()
    assert (s.x[0], s.x[-1]) == pytest.approx((0, 10), abs=1e-6)
    isInMiddle = (s.x > 4) & (s.x < 6)
    assert s.explicit.all() if meshed == 10 else (s.explicit == (~isInMiddle if meshed else False)).all()
    assert s.isContinuous(1e-6) and s.isolated == 0 and s.singleValued is (True if meshed else None)
    assert s.areas(2.0, 0.5) == pytest.approx((0, 0, 0), abs=1e-9)


def test_boxes_below_a_mesh_are_not_the_surface():
    s = surface(scene(above=(box((0, 1), (10, 2)), APDI), below=(box((0, 0), (10, 1)), UGIMP)))
    assert s.explicit.all() and s.y == pytest.approx(2.0)


def test_heave_and_trough_of_boxes_are_their_steps():
    """A bank of 3 m x 0.25 m on the left, a ditch of 2 m x 0.5 m on the right."""
    bank, ditch = box((0, 2), (3, 2.25)), box((8, 1.5), (10, 2))
    made = scene(soil=((BLOCK | bank) - ditch, UGIMP))
    assert surface(made).areas(2.0, 1.0) == pytest.approx((3 * 0.25, 2 * 0.5, 0), abs=2e-3)


def test_heave_and_trough_of_a_mesh_are_its_polyline():
    """Vertices up to 3 m raised by 0.75 m, from 8 m on lowered by 0.5 m; a ramp of one cell beside each."""
    made = scene(soil=(BLOCK, APDI))
    x, y = made["soil"].vertices.T
    y[(y > 1.9) & (x < 3.1)] += 0.75
    y[(y > 1.9) & (x > 7.9)] -= 0.5
    assert surface(made).areas(2.0, 1.0) == pytest.approx((3.25 * 0.75, 2.25 * 0.5, 0), abs=2e-3)


def test_a_surface_is_continuous_up_to_its_highest_step():
    made = scene(soil=(BLOCK - box((6, 1.5), (10, 2)), UGIMP))
    s = surface(made)
    assert s.isContinuous(0.51) and not s.isContinuous(MOST)
    assert s.areas(2.0, 0.6) == pytest.approx((0, 4 * 0.5, 0), abs=2e-3)


def test_a_mesh_that_hangs_over_is_not_single_valued():
    made = scene(soil=(box((0, 0), (5, 2)), APDI))
    corner = np.flatnonzero((made["soil"].vertices == (4.5, 2)).all(axis=1))
    made["soil"].vertices[corner, 0] = 5.1
    assert surface(made).singleValued is False
    made["soil"].vertices[corner, 0] = 4.9
    assert surface(made).singleValued is True


# --- gaps ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("width, continuous", [(0.25, True), (0.5, False), (1.0, False)])
def test_a_slit_of_more_than_half_a_cell_interrupts_the_surface(width, continuous):
    s = surface(scene(soil=(BLOCK - box((5, 0.5), (5 + width, 2)), UGIMP)))
    assert s.isContinuous(0.5) is continuous and s.isolated == 0
    assert np.nanmin(s.y) == pytest.approx(2.0 if continuous else 0.5)


def test_a_place_without_ground_interrupts_it_whatever_the_step():
    made = scene(base=(box((0, 0), (10, 1)), APDI), soil=(box((0, 1), (10, 2)) - box((5, 1), (6, 2)), UGIMP))
    s = surface(made)  # the mesh below has no edge at the level
    assert np.isnan(s.y[(s.x > 5) & (s.x < 6)]).all() and not s.isContinuous(10)
    assert s.areas(2.0, 10)[:2] == pytest.approx((0, 0), abs=1e-9)
    assert np.isfinite(surface(scene(soil=(BLOCK, UGIMP))).y).all()


def test_a_gap_between_two_pieces_of_mesh_interrupts_it():
    made = scene(soil=(BLOCK - box((4, 0.5), (6, 2)), APDI))
    assert not surface(made).isContinuous(10) and surface(made).singleValued
    assert surface(made, hole=(4, 6)).isContinuous(0.01)
    s = surface(made, hole=(4.5, 5))
    assert s.openBeside(0.5) == pytest.approx((0.5, 1.0)) and not s.isContinuous(0.5)


def test_a_narrow_gap_between_a_mesh_and_boxes_is_closed():
    """The boxes above 1 m stand 0.2 m off, those below touch the mesh; control: 0.3 m off."""
    made = scene(mesh=(box((0, 0), (4, 2)), APDI), soil=(box((4, 0), (8, 2)), UGIMP))
    position = made["soil"].position
    position[position[:, 1] > 1, 0] += 0.2
    assert surface(made).isContinuous(0.01)
    position[position[:, 1] > 1, 0] += 0.1
    assert surface(made).isContinuous(1.01) and not surface(made).isContinuous(1 - 1e-9)


# --- the hole -----------------------------------------------------------------------------------------------
def withCrater():
    """A crater of 3 to 7 m, 1 m deep, a step of 0.25 m on its left edge; with a ditch of 0.25 m far from
    it."""
    return scene(soil=(BLOCK - box((3, 1), (7, 2)) - box((2, 1.75), (3, 2)) - box((8, 1.75), (10, 2)), UGIMP))


def test_the_open_ground_beside_a_hole_is_what_the_surface_does_not_reach():
    s = surface(withCrater(), hole=(4.5, 5.0))
    assert s.openBeside(0.5) == pytest.approx((1.5, 2.0), abs=1e-6) and not s.isContinuous(0.5)
    assert s.openBeside(0.2) == pytest.approx((2.5, 3.0), abs=1e-6)
    assert s.openBeside(1.1) == pytest.approx((0, 0), abs=1e-6) and s.isContinuous(1.1)


def test_the_cavity_is_below_the_open_ground_and_the_trough_elsewhere():
    s = surface(withCrater(), hole=(4.5, 5.0))
    assert s.areas(2.0, 0.5) == pytest.approx((0, (1 + 2) * 0.25, 4 - 0.5), abs=2e-3)
    assert s.areas(2.0, 1.1) == pytest.approx((0, 3 * 0.25 + 3.5, 0), abs=2e-3), (
        "control: nothing interrupts it"
    )
    assert s.areas(1.5, 0.5)[0] == pytest.approx((2 + 1) * 0.5 + (1 + 2) * 0.25, abs=2e-3)


def test_what_the_hole_holds_counts_nowhere():
    made = scene(soil=(BLOCK | box((4, 2), (5, 4)), UGIMP))
    assert surface(made, hole=(4, 5)).areas(2.0, 0.5) == pytest.approx((0, 0, 0), abs=1e-9)
    assert surface(made, hole=(4, 5)).isContinuous(0.5)
    assert surface(made).areas(2.0, 0.5)[0] == pytest.approx(2, abs=0.01)
    assert not surface(made).isContinuous(0.5)  # control


# --- isolated particles -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "away, isolated", [((0, 0.24), 0), ((0, 0.26), 1), ((0.17, 0.17), 0), ((0.19, 0.19), 1)]
)
def test_a_box_is_isolated_by_a_gap_of_more_than_half_a_cell(away, isolated):
    """A box that stands on the corner of a block moves away, up or along the diagonal."""
    made = scene(soil=(box((0, 0), (4, 2)), UGIMP), stone=(box((4, 2), (4.25, 2.25)), UGIMP))
    made["stone"].position[...] += away
    s = surface(made)
    assert s.isolated == isolated
    assert np.nanmax(s.y) == pytest.approx(2.0 if isolated else 2.25 + away[1]), (
        "only what hangs together is ground"
    )


@pytest.mark.parametrize("patch, side", [(6, -1), (0, 1)])
def test_a_patch_is_isolated_as_a_whole_and_the_larger_part_is_the_ground(patch, side):
    made = scene(soil=(box((2, 0), (5, 2)) | box((patch, 0), (patch + 1, 1)), UGIMP))
    s = surface(made)
    assert s.isolated == 16 and (s.x[0], s.x[-1]) == pytest.approx((2, 5), abs=1e-6)
    position = made["soil"].position
    position[(position[:, 0] > patch) & (position[:, 0] < patch + 1), 0] += (
        0.8 * side
    )  # a gap of 0.2 m, which is less than half a cell
    assert surface(made).isolated == 0


@pytest.mark.parametrize("gap, isolated", [(0.2, 0), (0.3, 16)])
def test_boxes_hang_on_domains_and_domains_on_each_other(gap, isolated):
    made = scene(mesh=(box((0, 0), (4, 2)), APDI), boxes=(box((4, 0), (5, 1)), UGIMP))
    made["boxes"].position[:, 0] += gap
    assert surface(made).isolated == isolated
    assert surface(scene(mesh=(box((0, 0), (4, 2)) | box((5, 0), (6, 1)), APDI))).isolated == 4


# --- what cannot be -----------------------------------------------------------------------------------------
def test_a_hole_at_the_end_of_the_ground_has_one_side():
    assert surface(scene(soil=(box((2, 0), (8, 2)), UGIMP)), hole=(1, 2.0)).openBeside(0.5) == (
        0,
        pytest.approx(0, abs=1e-6),
    )
    assert surface(scene(soil=(box((2, 0), (8, 2)), UGIMP)), hole=(0, 1.0)).openBeside(0.5) == (
        0,
        pytest.approx(1, abs=1e-6),
    )


def test_a_ground_without_surface_is_refused():
    made = scene(soil=(BLOCK, APDI))
    with pytest.raises(ValueError, match="no mesh has edges that lay at level = 3 m"):
        surface(made, level=3.0)
    with pytest.raises(ValueError, match="the bodies hold no particles"):
        groundSurface(made, [], 2.0)


def test_a_scene_in_3D_is_refused():
    made = mpm.Scene((0, 0, 0), (1, 1, 1), 0.5)
    made.add("soil", box((0, 0, 0), (1, 1, 0.5)), SOIL, UGIMP)
    with pytest.raises(ValueError, match="the scene is 3D"):
        surface(made)
